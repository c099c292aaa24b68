"""``drystone shell``: a surface divided into blocks, with files and a verdict."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial as bound
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli.base import kinds, verdict
from drystone.cli.base.answer import Answer
from drystone.cli.base.command import OUTPUT, Option, command
from drystone.cli.base.output import Screen
from drystone.cli.base.waiting import Waiting
from drystone.cli.base.written import Pictures, apart
from drystone.cli.design.buildable_answer import Asked, find_buildable, show_buildable
from drystone.cli.inputs import options
from drystone.cli.inputs.surfaces import SurfaceRequest, surface_of

if TYPE_CHECKING:
    from drystone.base.files import Job
    from drystone.cli.base.answer import Files
    from drystone.shells import Shell

BLOCK_FORMATS = ("obj", "stl", "ply", "glb", "3dm", "json")
"""Formats of the files of single blocks."""


def _count_or_auto(text: str) -> int | None:
    if text == "auto":
        return None
    try:
        return int(text)
    except ValueError as error:
        raise InputError(f"is '{text}'", remedy="give a number or auto") from error


def _wedges(text: str) -> tuple[float, ...]:
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise InputError(f"is '{text}'", remedy="give numbers separated by commas") from error
    if not all(map(math.isfinite, found)):
        raise InputError(f"is {text}", remedy="give finite numbers")
    return found


@command(
    "drystone shell barrel --courses 5 --blocks 2 --thickness 0.6 --out barrel.json",
    "drystone shell dome --courses 4 --blocks 8 --thickness 0.4 --html dome.html",
)
def shell(
    *,
    wanted: SurfaceRequest,
    courses: Annotated[int | None, Option("Number of courses (12).")] = None,
    course_height: Annotated[float | None, Option("Or their height in m.", expert=True)] = None,
    partial: Annotated[
        int | None,
        Option(
            "Courses that end inside where a side is longer: a number or auto (0).",
            kind=kinds.OptionKind("COUNT|auto", _count_or_auto),
            expert=True,
        ),
    ] = 0,
    blocks: Annotated[int | None, Option("Blocks in each course.")] = None,
    width: Annotated[float | None, Option("Or their width in m (an eighth of the span).")] = None,
    wedge: Annotated[
        tuple[float, ...] | None,
        Option(
            "Shift of bed joints, by the height of a course: -0.45 to 0.45 (0; with --straight "
            "what the curvatures ask for). One value, or one for each bed line between courses.",
            kind=kinds.OptionKind("WEDGE[,WEDGE...]", _wedges),
            expert=True,
        ),
    ] = None,
    buildable: Annotated[
        bool,
        Option(
            "Search courses, width and stagger, where they are not given, and a wedge for each "
            "course, so that the fewest blocks are propped, then held, while it is built."
        ),
    ] = False,
    joggle: Annotated[
        float,
        Option(
            "Slope of hooks in bed joints, degrees: 10 to 25, or -25 to -10 (0: none).", expert=True
        ),
    ] = 0.0,
    straight: Annotated[
        bool, Option("Make the inner face of every block planar.", expert=True)
    ] = False,
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
        Option("Format of these files (obj).", OUTPUT, kind=kinds.one_of(BLOCK_FORMATS),
        expert=True),
    ] = None,
    pictures: Pictures,
    waiting: Waiting,
) -> Answer:  # fmt: skip
    """Divide a surface into blocks that fit, and check whether they stand."""
    apart([out, schedule, unrolled, pictures.html, pictures.png])
    for one, other, names in (
        (courses, course_height, "--courses and --course-height"),
        (blocks, width, "--blocks and --width"),
    ):
        if one is not None and other is not None:
            raise InputError("say the same thing", where=names, remedy="give one of them")
    if block_format is not None and block_files is None:
        raise InputError(
            "is for --block-files", where="--block-format", remedy="name a folder with that"
        )
    from drystone.shells import Intrados, Layout, ShellBody, build_shell, write_blocks
    from drystone.shells.shell_by_name import COURSES

    body = ShellBody(
        thickness=wanted.thickness,
        joggle_deg=joggle,
        intrados=Intrados.STRAIGHT if straight else Intrados.OFFSET,
    )
    waiting.stage("read", "building the shell")
    base = surface_of(wanted)
    shift = wedge[0] if wedge is not None and len(wedge) == 1 else wedge
    layout = Layout(
        courses=COURSES if courses is None and course_height is None else courses,
        height=course_height,
        partial=partial,
        blocks=blocks,
        width=base.width if blocks is None and width is None else width,
        wedge=0.0 if wedge is None and not straight else shift,
    )
    told = None
    if buildable:
        asked = Asked(wedge, courses is None and course_height is None,
                      blocks is None and width is None, straight)  # fmt: skip
        told = find_buildable(base.shape, layout, body, asked, friction, waiting, time_limit)
        made = told.shell
    else:
        made = build_shell(base.shape, layout, body, progress=waiting)
    model = made.model() if friction is None else made.model(friction=friction)
    model = replace(model, notes=(*base.notes, *made.notes))
    pictures.require_through(model.assembly)
    result = verdict.solve(model, waiting, time_limit)
    if block_files is not None:
        write_blocks(made, block_files, suffix=f".{block_format or 'obj'}")
        waiting.wrote = [f"{block_files} ({len(made.voussoirs)} files)"]
    files = bound(_files, made, out, schedule, unrolled, pictures.of(result)[0])
    answer = verdict.answer(result, waiting, base.shape.name, files)
    answer.data["shell"] = summary(made)
    if told is not None:
        answer.data["buildable"] = told.to_dict()
    show = bound(_show, answer)
    return replace(answer, show=show, written=waiting.wrote)


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


def _show(answer: Answer, screen: Screen) -> None:
    answer.show(screen)
    told = answer.data["shell"]
    if "buildable" in answer.data:
        show_buildable(answer.data["buildable"], screen)
    screen.line(
        f"{told['voussoirs']} voussoirs in {told['courses']} courses, {told['ground_blocks']} "
        f"ground blocks, {told['volume']:.2f} m3"
    )
    screen.line(
        f"largest warp of a joint {told['warp_before']:.2%} of a block before, "
        f"{told['warp_after']:.1e} after planarising; largest drift {told['drift']:.1%}, "
        f"{told['off_surface']:.1%} off the surface"
    )
