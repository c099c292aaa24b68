"""Commands that follow blocks: ``settle`` and ``fall``."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.base.errors import InputError
from drystone.cli import kinds, offered
from drystone.cli.check_command import solve
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import LOADS, Analysis, Of, Option, writes
from drystone.cli.told import Pictures, Told, Written, apart
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.answer import Answer
    from drystone.cli.told import Files
    from drystone.fall import Film
    from drystone.settlement import SupportResponseOptions


LARGE = 0.1
"""Motion of a support by the mean size of a block from which on it is no longer small."""


@command(
    "drystone settle arch.json --gravity 0,1,-9.81 --html settled.html",
    "drystone settle arch.json --move springer-right:1,0,0 --to 0.05 --html spread.html",
)
def settle(
    *,
    move: Annotated[
        tuple[str, ...],
        Option(
            "Motion of a support: a translation in m, and a rotation vector in degrees about its "
            "centroid. Can be given several times.",
            LOADS,
            metavar="BLOCK:DX,DY,DZ[,RX,RY,RZ]",
        ),
    ] = (),
    subject: Subject,
    to: Annotated[
        float | None,
        Option(
            "Follow the blocks by finite steps until the corner of a support that moves farthest "
            "has moved by this, m, or they fall.",
            kind=kinds.POSITIVE,
        ),
    ] = None,
    small: Annotated[
        SupportResponseOptions,
        Of("drystone.settlement.SupportResponseOptions", ("compliance",)),
    ],
    time_limit: offered.TimeLimit = None,
    wanted: Written,
    waiting: Waiting,
) -> Told:
    """Where the blocks come to rest; with --move, which joints open when supports move.

    Exit code 0: the blocks come to rest, or follow the supports up to --to. 1: they do not. 2: bad
    input.
    """
    model = subject.prepared(waiting, move, settling=True)
    wanted.require_through(model.assembly)
    if model.load.motion is None and (move or to is not None):
        raise InputError(
            "no support moves", where="--move", remedy="write BLOCK:DX,DY,DZ, such as 0,0,-0.01"
        )
    if time_limit is not None and model.load.motion is not None and to is None:
        raise InputError(
            "small motions of supports take no steps that could end early",
            where="--time-limit",
            remedy="leave it out, or add --to",
        )
    if (to is not None or model.load.motion is None) and (wanted.joints or wanted.corners):
        raise InputError(
            "there is no table of joints or corners without --move, nor with --to",
            remedy="ask for --html, --png or --json",
        )
    # work is imported when there is some
    from drystone import settlement

    notes = model.notes
    with waiting.keywords(time_limit) as common:
        if model.load.motion is None:
            waiting.stage("solve", "following the blocks")
            found: Answer = settlement.settle(model, **common)
        elif to is not None:
            waiting.stage("solve", "moving")
            found = settlement.move_supports(model, to=to, **common)
        else:
            waiting.stage("solve", "settling")
            found = settlement.support_response(model, options=small)
            if found.size > LARGE * model.assembly.size.mean():
                notes += ("the motion is large, and this answer is for small ones: --to follows "
                          "the blocks",)  # fmt: skip
    return Told(found, notes=notes, files=partial(wanted.of, found))


_JAMS = (
    "the simulator holds what falls: in it joints open while they slide, which jams a block "
    "between faces; 'drystone settle' follows its motion"
)
"""Seen at hooked planks. Contacts of MuJoCo minimise work (Todorov 2014), so friction is
associated."""


@command(
    "drystone fall arch.json --seismic 0.4 --html fall.html",
    "drystone fall arch.json --seismic 0.4 --glb fall.glb",
)
def fall(
    *,
    subject: Subject,
    asked: Annotated[
        Analysis,
        Of(
            "drystone.fall.fall",
            ("options.duration", "options.ground", "time_limit_s"),
            shown=("options.duration", "options.ground"),
        ),
    ],
    no_check: Annotated[
        bool, Option("Leave out the check, whose first motion starts the film.", expert=True)
    ] = False,
    html: offered.Html = None,
    section: offered.Section = None,
    glb: Annotated[
        Path | None,
        writes("Write the film as an animated GLB.", ".glb"),
    ] = None,
    waiting: Waiting,
) -> Told:
    """Simulate the fall with inertia and impacts, as a film; this gives no verdict.

    Exit code 0: every block is at rest at the end. 1: some still move. 3: MuJoCo is missing.
    """
    pictures = Pictures(html, section=section)
    apart([html, glb])
    from drystone.fall import require_mujoco

    require_mujoco()
    model = subject.prepared(waiting)
    pictures.require_through(model.assembly)
    notes = list(model.notes)
    motion, falls = None, False
    if not no_check:
        result = solve(model, waiting, asked.time_limit, key="check")
        notes.append(f"check: {result.verdict}, {result.message}")
        motion, falls = result.mechanism, result.falls
    film = asked.of(waiting, model, motion, doing="simulating")
    if falls and not film.fell.any() and not film.stopped:
        notes.append(_JAMS)
    return Told(film, notes=notes, files=partial(_film_files, film, pictures, glb))


def _film_files(film: Film, pictures: Pictures, glb: Path | None) -> Files:
    jobs, said = pictures.of(film)
    return [*jobs, (glb, film.save_glb)], said
