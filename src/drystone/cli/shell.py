"""``drystone shell``: from a surface to blocks, their files, and a verdict."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drystone.cli import options, output, verdict
from drystone.cli.session import warnings_of
from drystone.cli.surfaces import Wanted
from drystone.cli.surfaces import surface as surface_of
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

if TYPE_CHECKING:
    from drystone.shells import Shell


SUFFIXES = (".json", ".obj")
BLOCK_SUFFIXES = ("obj", "stl", "ply", "glb", "3dm", "json")
"""Formats of the files of single blocks."""


def shell(
    surface: Annotated[
        str,
        typer.Argument(
            metavar="SURFACE",
            help="barrel, cross, pavilion or dome; free-edge or three-vaults, whose form is found; "
            "or an open mesh file.",
        ),
    ],
    span: Annotated[float | None, typer.Option(help="Span or diameter in m (6).")] = None,
    length: Annotated[
        float | None, typer.Option(help="Length of a barrel, depth of a free-edge plan, in m.")
    ] = None,
    rise: Annotated[
        float | None, typer.Option(help="Rise of a barrel, height of a form found, in m.")
    ] = None,
    eye: Annotated[
        float | None, typer.Option(help="Diameter of the opening at the crown, in m (1).")
    ] = None,
    keystone: Annotated[
        bool, typer.Option("--keystone", help="Close the opening with one block.")
    ] = False,
    supports: Annotated[
        str | None,
        typer.Option(
            help="Sides that a mesh stands on: bottom, top, left, right; by commas "
            "(the bottom and those as low)."
        ),
    ] = None,
    units: options.Units = None,
    courses: Annotated[int | None, typer.Option(help="Number of courses (12).")] = None,
    course_height: Annotated[float | None, typer.Option(help="Or their height in m.")] = None,
    partial: Annotated[
        str, typer.Option(help="Courses that end inside where a side is longer: a number or auto.")
    ] = "0",
    blocks: Annotated[int | None, typer.Option(help="Blocks in each course.")] = None,
    width: Annotated[
        float | None, typer.Option(help="Or their width in m (an eighth of the span).")
    ] = None,
    wedge: Annotated[
        float | None,
        typer.Option(
            help="Shift of bed joints, by the height of a course: -0.45 to 0.45 "
            "(0; with --straight what the curvatures ask for)."
        ),
    ] = None,
    thickness: Annotated[
        float | None,
        typer.Option(help="Thickness in m (0.075 of the span of a barrel, else the size by 30)."),
    ] = None,
    register: Annotated[
        float,
        typer.Option(help="Degrees by which bed joints are turned to hook blocks: -35 to 35."),
    ] = 0.0,
    straight: Annotated[
        bool, typer.Option("--straight", help="Make the inner face of every block planar.")
    ] = False,
    friction: options.Friction = None,
    out: Annotated[str | None, typer.Option(help="Write the blocks: .json or .obj.")] = None,
    schedule: Annotated[str | None, typer.Option(help="Write the schedule: .csv.")] = None,
    unrolled: Annotated[
        str | None, typer.Option(help="Write the flattened joint faces: .svg or .dxf.")
    ] = None,
    block_files: Annotated[
        str | None, typer.Option(help="Folder for a file per block in its own frame.")
    ] = None,
    block_format: Annotated[
        str | None,
        typer.Option(help=f"Of these files: {', '.join(BLOCK_SUFFIXES)} (obj)."),
    ] = None,
    html: options.Html = None,
    png: options.Png = None,
    time_limit: options.TimeLimit = None,
    as_json: options.Json = False,
) -> int:
    """Divide a surface into blocks that fit, and check whether they stand."""
    pictures = verdict.Files.checked(html, png)
    for one, other, names in (
        (courses, course_height, "--courses and --course-height"),
        (blocks, width, "--blocks and --width"),
    ):
        if one is not None and other is not None:
            raise InputError("say the same thing", where=names, remedy="give one of them")
    model_path = _path(out, "--out", SUFFIXES)
    schedule_path = _path(schedule, "--schedule", (".csv",))
    unrolled_path = _path(unrolled, "--unrolled", (".svg", ".dxf"))
    suffix = _block_suffix(block_format, block_files)
    from drystone.shells import Body, Intrados, Layout, build_shell

    body = Body(
        thickness=thickness,
        register_deg=register,
        intrados=Intrados.STRAIGHT if straight else Intrados.OFFSET,
    )
    from dataclasses import replace

    from drystone.model import Model

    with Waiting() as waiting:
        waiting.stage("read", "building the shell")
        base = surface_of(
            Wanted(surface, span, length, rise, eye, keystone, supports, units, thickness)
        )
        layout = Layout(
            courses=12 if courses is None and course_height is None else courses,
            height=course_height,
            partial=_partial(partial),
            blocks=blocks,
            width=base.width if blocks is None and width is None else width,
            wedge=0.0 if wedge is None and not straight else wedge,
        )
        made = build_shell(base.shape, layout, body, progress=waiting)
        waiting.stage("detect", "finding contacts")
        model = Model.of(made.assembly, friction=friction)
        said = [] if model.report is None else warnings_of(model.report)
        model = replace(model, notes=(*base.notes, *made.notes, *said))
        result = verdict.solve(model, waiting, time_limit)
        paths = (model_path, schedule_path, unrolled_path)
        written = _write(made, paths, block_files, suffix, waiting)
        pictures.write(result, waiting)
    data = verdict.content(result, waiting.time_s, base.shape.name, pictures)
    data["files"] = [*written, *data["files"]]
    data["shell"] = summary(made)
    if as_json:
        output.emit(data)
    else:
        verdict.show(data)
        _show(data["shell"])
    return waiting.exit_code(verdict.exit_code(result, strict=False))


def summary(made: Shell) -> dict[str, Any]:
    """What was built, as plain values; warp and drift by the mean width of a block."""
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


def _show(told: dict[str, Any]) -> None:
    console = output.console()
    console.print(
        f"{told['voussoirs']} voussoirs in {told['courses']} courses, {told['ground_blocks']} "
        f"ground blocks, {told['volume']:.2f} m3"
    )
    console.print(
        f"largest warp of a joint {told['warp_before']:.2%} of a block before, "
        f"{told['warp_after']:.1e} after planarising; largest drift {told['drift']:.1%}, "
        f"{told['off_surface']:.1%} off the surface"
    )


def _path(text: str | None, option: str, suffixes: tuple[str, ...]) -> Path | None:
    return None if text is None else options.output_path(text, option, suffixes)


def _block_suffix(block_format: str | None, block_files: str | None) -> str:
    chosen = "obj" if block_format is None else block_format.lower().removeprefix(".")
    if chosen not in BLOCK_SUFFIXES:
        raise InputError(
            f"is '{block_format}'",
            where="--block-format",
            remedy=f"give one of {', '.join(BLOCK_SUFFIXES)}",
        )
    if block_format is not None and block_files is None:
        raise InputError(
            "is for --block-files", where="--block-format", remedy="name a folder with that"
        )
    return f".{chosen}"


def _partial(text: str) -> int | None:
    if text == "auto":
        return None
    try:
        return int(text)
    except ValueError as error:
        raise InputError(
            f"is '{text}'", where="--partial", remedy="give a number or auto"
        ) from error


def _write(
    made: Shell,
    paths: tuple[Path | None, Path | None, Path | None],
    block_files: str | None,
    suffix: str,
    waiting: Waiting,
) -> list[str]:
    """Write blocks, schedule, joint faces and single blocks, and name them."""
    from drystone import io, shells

    out, schedule, unrolled = paths
    if out is not None:
        io.write(made.assembly, out)
        waiting.wrote.append(str(out))
    if schedule is not None:
        shells.write_schedule(made, schedule)
        waiting.wrote.append(str(schedule))
    if unrolled is not None:
        shells.write_unrolled(made, unrolled)
        waiting.wrote.append(str(unrolled))
    if block_files is not None:
        shells.write_blocks(made, block_files, suffix=suffix)
        waiting.wrote.append(f"{block_files} ({len(made.voussoirs)} files)")
    return list(waiting.wrote)
