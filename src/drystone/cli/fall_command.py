"""``drystone fall``: a film of the blocks that fall."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.cli import kinds, options
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import OUTPUT, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Pictures, apart

if TYPE_CHECKING:
    from drystone.cli.told import Files
    from drystone.fall import Film

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
    duration: Annotated[
        float,
        Option(
            "Largest length of the film, divided by the time in which a block falls by half its "
            "size (20).",
            kind=kinds.POSITIVE,
        ),
    ] = 20.0,
    no_ground: Annotated[bool, Option("Blocks fall past the lowest point of the model.")] = False,
    no_check: Annotated[
        bool, Option("Leave out the check, whose first motion starts the film.", expert=True)
    ] = False,
    time_limit: options.TimeLimit = None,
    html: options.Html = None,
    section: options.Section = None,
    glb: Annotated[
        Path | None,
        Option("Write the film as an animated GLB.", OUTPUT, kind=kinds.target(".glb")),
    ] = None,
    waiting: Waiting,
) -> Told:
    """Simulate the fall with inertia and impacts, as a film; this gives no verdict.

    Exit code 0: every block is at rest at the end. 1: some still move. 3: MuJoCo is missing.
    """
    pictures = Pictures(html, section=section)
    apart([html, glb])
    from drystone.fall import FallOptions
    from drystone.fall import fall as followed
    from drystone.fall.simulation import require_mujoco

    require_mujoco()
    model = subject.prepared(waiting)
    pictures.require_through(model.assembly)
    notes = list(model.notes)
    motion, falls = None, False
    with waiting.keywords(time_limit) as common:
        if not no_check:
            from drystone.stability import check

            waiting.stage("check", "checking")
            result = check(model, **common)
            notes.append(f"check: {result.verdict}, {result.message}")
            motion, falls = result.mechanism, result.falls
        waiting.stage("solve", "simulating")
        wanted = FallOptions(duration=duration, ground=not no_ground)
        film = followed(model, motion, options=wanted, **common)
    if falls and not film.fell.any() and not film.stopped:
        notes.append(_JAMS)
    return Told(film, notes=notes, files=partial(_files, film, pictures, glb))


def _files(film: Film, pictures: Pictures, glb: Path | None) -> Files:
    jobs, said = pictures.of(film)
    if glb is not None:
        jobs.append((glb, film.save_glb))
    return jobs, said
