"""``drystone check``, and the commands that follow blocks: ``settle`` and ``fall``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.base.errors import InputError
from drystone.cli import kinds, mend_command, offered
from drystone.cli.command import command
from drystone.cli.model_input import HOW, SHOWN, Subject
from drystone.cli.offered import LOADS, Analysis, Of, Option, writes
from drystone.cli.told import Pictures, Told, Written, apart
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.answer import Answer
    from drystone.cli.told import Files
    from drystone.fall import Film
    from drystone.model import Model
    from drystone.results import Result
    from drystone.settlement import SupportResponseOptions


@dataclass(frozen=True)
class Checked(Subject):
    """The model; the help shows the strength of its joints too."""

    reading: Annotated[Analysis, HOW(shown=(*SHOWN, "strength"))]


@dataclass(frozen=True)
class CheckFiles(Written):
    """The files of a check; the help shows the report too."""

    report: offered.Report = None


def solve(
    model: Model,
    waiting: Waiting,
    time_limit: float | None,
    robust: bool = False,
    key: str = "solve",
) -> Result:
    """The verdict of ``check``, or what is known when the time limit or Ctrl-C end it.

    With ``robust`` other contact stiffnesses are tried as well. Its time is told under ``key``.
    """
    waiting.end_stage()  # the import is no part of the stage before
    from drystone.stability import CheckOptions, check

    waiting.stage(key, "solving")
    with waiting.keywords(time_limit) as common:
        options = CheckOptions.robust() if robust else CheckOptions()
        result = check(model, options=options, **common)
    waiting.end_stage()
    return result


def safe(result: Result, waiting: Waiting) -> Result:
    """The result with the margins of tilt and strength of what stands."""
    if not result.stable or result.stopped:
        return result
    from drystone.limits.bounds import with_margins

    waiting.stage("margin", "looking for the margin of tilt and strength")
    with waiting.stoppable() as stop:
        return with_margins(result, stop)


def exit_code(result: Result, strict: bool) -> int:
    """0 if stable; with ``strict`` only if it stands for every stiffness and all were tried."""
    robust = not result.sensitive and not result.stopped
    return result.code if robust or not strict else 1


@command(
    "drystone check arch.json --html arch.html",
    "drystone check arch.json --friction 40deg --load 'voussoir-05:1kN'",
)
def check(
    *,
    subject: Checked,
    strict: Annotated[
        bool,
        Option(
            "Try other contact stiffnesses too: exit code 0 only if it stands for all of them.",
            expert=True,
        ),
    ] = False,
    time_limit: offered.TimeLimit = None,
    wanted: CheckFiles,
    waiting: Waiting,
) -> Told:
    """Check whether a model stands, with a proof.

    Exit code 0: it stands. 1: it falls, or it is undecided. 2: bad input. 130: stopped by Ctrl-C,
    with what is known so far.
    """
    model = subject.prepared(waiting)
    wanted.require_through(model.assembly)
    result = safe(solve(model, waiting, time_limit, strict), waiting)
    why = mend_command.short(result, waiting)
    then: list[tuple[str, ...]] = [("mend",)] if why else []
    if result.stable and result.tilt_margin is None:
        from drystone.loads.applied import is_vertical

        train = ("limit train", "--train", "lm1")
        still = train if model.load.fills else ("limit shrink",)
        then = [("limit tilt",) if is_vertical(model.load) else still]
        rubs = result.friction_margin is None and model.contacts.plain.all()
        then += [("limit friction",)] * bool(rubs)
    return Told(
        result, why, exit_code=exit_code(result, strict), notes=result.model.notes,
        files=partial(wanted.of, result), then="; ".join(subject.command(*one) for one in then),
    )  # fmt: skip


def _refuse_farther(model: Model, to: float | None) -> None:
    """Refuse supports that move farther than the model is large, as where mm are meant."""
    motion, box = model.load.motion, model.assembly.bounds
    way = to or (0.0 if motion is None else max(math.hypot(*one) for one in motion[:, :3]))
    size = math.dist(box.min(axis=(0, 1)), box.max(axis=(0, 1)))
    if way > size:
        what = f"a support moves by {way:g} m, farther than the model is large ({size:.3g} m)"
        where = "--move" if to is None else "--to"
        raise InputError(what, where=where, remedy=f"write it in m or with its unit: {way:g}mm")


@command(
    "drystone settle arch.json --gravity 0,1,-9.81 --html settled.html",
    "drystone settle arch.json --move springer-right:1,0,0 --to 0.05 --html spread.html",
)
def settle(
    *,
    move: Annotated[
        tuple[str, ...],
        Option(
            "Motion of a support: a translation in m, or such as 30mm,0,0, and a rotation vector "
            "in degrees about its centroid. Can be given several times.",
            LOADS,
            metavar="BLOCK:DX,DY,DZ[,RX,RY,RZ]",
        ),
    ] = (),
    subject: Subject,
    to: Annotated[
        float | None,
        Option(
            "Follow the blocks by finite steps until the corner of a support that moves farthest "
            "has moved by this, or they fall.",
            kind=kinds.LENGTH,
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

    Where supports move, the blocks are followed too: the answer is that of finite steps where they
    fall on the way, or where the motion is large beside them.

    Exit code 0: the blocks come to rest, or follow the supports up to --to. 1: they do not. 2: bad
    input.
    """
    model = subject.prepared(waiting, move, settling=True)
    wanted.require_through(model.assembly)
    if model.load.motion is None and (move or to is not None):
        raise InputError(
            "no support moves", where="--move", remedy="write BLOCK:DX,DY,DZ, such as 0,0,-0.01"
        )
    _refuse_farther(model, to)
    tables = bool(wanted.joints or wanted.corners)
    if tables and (to is not None or model.load.motion is None):
        raise InputError(
            "there is no table of joints or corners without --move, nor with --to",
            remedy="ask for --html, --png or --json",
        )
    # work is imported when there is some
    from drystone import settlement

    waiting.stage("solve", "following the blocks")
    with waiting.keywords(time_limit) as common:
        if model.load.motion is None:
            found: Answer = settlement.settle(model, **common)
        elif to is not None:
            found = settlement.move_supports(model, to=to, **common)
        else:
            moved = found = settlement.support_response(model, options=small, **common)
            if tables and moved.result.falls:
                raise InputError(
                    f"{found.title}; tables of joints are of what stands", remedy="leave them out"
                )
    return Told(found, notes=model.notes, files=partial(wanted.of, found))


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
