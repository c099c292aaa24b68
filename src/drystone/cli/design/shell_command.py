"""``drystone shell``: a surface divided into blocks, with files and a verdict."""

from __future__ import annotations

from dataclasses import replace
from functools import partial as bound
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli.base import kinds, verdict
from drystone.cli.base.command import OUTPUT, Experts, Option, command
from drystone.cli.base.output import Screen
from drystone.cli.base.told import Printed, Told
from drystone.cli.base.waiting import Waiting
from drystone.cli.base.written import Pictures, apart
from drystone.cli.design.buildable_answer import find_buildable, show_buildable
from drystone.cli.design.parameter_search import SearchRequest, parameter_range, show_front
from drystone.cli.design.shell_pattern import ShellPattern, shell_on, varied_shell, with_values
from drystone.cli.inputs import families, options
from drystone.cli.inputs.surfaces import SurfaceRequest, surface_of

if TYPE_CHECKING:
    from drystone.base.files import Job
    from drystone.cli.base.told import Files
    from drystone.design import Tuned
    from drystone.shells import Shell

_BLOCK_FORMATS = ("obj", "stl", "ply", "glb", "3dm", "json")
"""Formats of the files of single blocks."""


@command(
    "drystone shell barrel --courses 5 --blocks 2 --thickness 0.6 --out barrel.json",
    "drystone shell dome --courses 4 --blocks 8 --thickness 0.4 --html dome.html",
)
def shell(
    *,
    wanted: SurfaceRequest,
    pattern: ShellPattern,
    buildable: Annotated[
        bool,
        Option(
            "Search courses, width and stagger, where they are not given, and a wedge for each "
            "course, so that the fewest blocks are propped, then held, while it is built."
        ),
    ] = False,
    search: Annotated[SearchRequest, Experts(but=("vary",))],
    friction: options.Friction = None,
    time_limit: options.TimeLimit = None,
    out: Annotated[
        Path | None,
        Option("Write the blocks: .json or .obj.", OUTPUT, kind=kinds.target(".json", ".obj")),
    ] = None,
    schedule: Annotated[
        Path | None,
        Option("Write the schedule: .csv.", OUTPUT, kind=kinds.target(".csv"), expert=True),
    ] = None,
    unrolled: Annotated[
        Path | None,
        Option("Write the flattened joint faces: .svg or .dxf.", OUTPUT,
               kind=kinds.target(".svg", ".dxf"), expert=True),
    ] = None,
    block_files: Annotated[
        str | None,
        Option("Folder for a file per block in its own frame.", OUTPUT, expert=True),
    ] = None,
    block_format: Annotated[
        str | None,
        Option("Format of these files (obj).", OUTPUT, kind=kinds.one_of(_BLOCK_FORMATS),
        expert=True),
    ] = None,
    pictures: Pictures,
    waiting: Waiting,
) -> Printed:  # fmt: skip
    """Divide a surface into blocks that fit, and check whether they stand.

    With --vary its options are searched, as ``drystone tune`` does; the best shell is the answer.

    Exit code 0: it stands. 1: it does not. 2: bad input. 130: Ctrl-C ended it; of a search the best
    shell so far is written.
    """
    apart([out, schedule, unrolled, pictures.html, pictures.png])
    pattern.refuse_two_ways()
    if block_format is not None and block_files is None:
        raise InputError(
            "is for --block-files", where="--block-format", remedy="name a folder with that"
        )
    tuned = None
    if search.vary:
        if buildable:
            raise InputError(
                "are two searches", where="--buildable and --vary", remedy="give one of them"
            )
        tuned = _search(wanted, pattern, search, friction, waiting, time_limit)
        if not tuned.front:
            return _none_stands(tuned, wanted.surface)
        wanted, pattern = with_values(wanted, pattern, **tuned.front[0].values)
    else:
        search.refuse_without_vary()
    from drystone.shells import write_blocks

    waiting.stage("read", "building the shell")
    base = surface_of(wanted)
    told = None
    if buildable:
        layout, body = pattern.layout(base.width), pattern.body(wanted.thickness)
        told = find_buildable(base.shape, layout, body, pattern, friction, waiting, time_limit)
        made = told.shell
    else:
        made = shell_on(base, wanted, pattern, waiting)
    model = made.model() if friction is None else made.model(friction=friction)
    model = replace(model, notes=(*base.notes, *made.notes))
    pictures.require_through(model.assembly)
    result = verdict.solve(model, waiting, time_limit)
    if block_files is not None:
        write_blocks(made, block_files, suffix=f".{block_format or 'obj'}")
        waiting.wrote = [f"{block_files} ({len(made.voussoirs)} files)"]
    files = bound(_files, made, out, schedule, unrolled, pictures.of(result)[0])
    answer = Told(result, subject=base.shape.name)
    data = {**answer.data, "shell": summary(made)}
    if told is not None:
        data["buildable"] = told.to_dict()
    if tuned is not None:
        data["search"] = tuned.to_dict()
    show = bound(_show, answer, data)
    return Printed(data, show, answer.code, result.model.notes, files, waiting.wrote)


def _search(
    wanted: SurfaceRequest,
    pattern: ShellPattern,
    search: SearchRequest,
    friction: float | None,
    waiting: Waiting,
    time_limit: float | None,
) -> Tuned:
    """The shells that were tried."""
    known = families.shell_parameters()
    ranges = [parameter_range(text, known) for text in search.vary]
    with_values(wanted, pattern, **{one.name: one.choices[0] if one.choices else one.low
                                    for one in ranges})  # fmt: skip
    how: dict[str, Any] = {} if friction is None else {"friction": friction}
    return search.run(bound(varied_shell, wanted, pattern), known, how, waiting, time_limit)


def _none_stands(tuned: Tuned, surface: str) -> Printed:
    """The answer where no shell is good enough."""
    message = tuned._summary()
    data = {"model": surface, "message": message, "search": tuned.to_dict()}
    return Printed(data, lambda screen: screen.line(surface, message, "bold"), 1)


def _files(
    made: Shell, out: Path | None, schedule: Path | None, unrolled: Path | None, pictures: list[Job]
) -> Files:
    from drystone import io, shells

    jobs: list[Job] = []
    if out is not None:
        jobs.append((out, bound(io.write, made.assembly)))
    if schedule is not None:
        jobs.append((schedule, bound(shells.write_schedule, made)))
    if unrolled is not None:
        jobs.append((unrolled, bound(shells.write_unrolled, made)))
    return [*jobs, *pictures], []


def summary(made: Shell) -> dict[str, Any]:
    """The shell as plain values; warp and drift by the mean width of a block."""
    return {
        "voussoirs": len(made.voussoirs),
        "ground_blocks": int(made.ground.sum()),
        "courses": int(made.mesh.course[made.voussoirs].max()) + 1,
        "volume": made.volume,
        "warp_before": made.planar.warp_before,
        "warp_after": made.planar.warp_after,
        "planar": made.planar.reached,
        "drift": made.planar.drift,
        "off_surface": made.off_surface,
        "moved_off_surface": made.fitted,
        "supports": [f"patch {edge.patch}, {edge.side.value}" for edge in made.shape.supports],
    }


def _show(answer: Told, data: dict[str, Any], screen: Screen) -> None:
    answer.show(screen)
    told = data["shell"]
    if "buildable" in data:
        show_buildable(data["buildable"], screen)
    if "search" in data:
        screen.line(data["search"]["message"])
        show_front(data["search"], screen)
    screen.line(
        f"{told['voussoirs']} voussoirs in {told['courses']} courses, {told['ground_blocks']} "
        f"ground blocks, {told['volume']:.2f} m3"
    )
    screen.line(
        f"largest warp of a joint {told['warp_before']:.2%} of a block before, "
        f"{told['warp_after']:.1e} after planarising; largest drift {told['drift']:.1%}, "
        f"{told['off_surface']:.1%} off the surface"
    )
