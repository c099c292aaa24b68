"""``drystone shell``: from a surface to blocks, their files, and a verdict."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drystone.cli import options, output, verdict
from drystone.cli.session import Prepared, found, warnings_of, weight
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

if TYPE_CHECKING:
    from drystone.shells import Edge, Shape, Shell


class Kind(enum.Enum):
    """Surfaces that the command knows besides mesh files."""

    BARREL = "barrel"
    CROSS = "cross"
    PAVILION = "pavilion"
    DOME = "dome"
    FREE_EDGE = "free-edge"
    THREE_VAULTS = "three-vaults"


SUFFIXES = (".json", ".obj")


def shell(
    surface: Annotated[
        str,
        typer.Argument(
            metavar="SURFACE",
            help="barrel, cross, pavilion or dome; free-edge or three-vaults, whose form is found; "
            "or an open mesh file.",
        ),
    ],
    span: Annotated[float, typer.Option(help="Span or diameter in m.")] = 6.0,
    length: Annotated[
        float | None, typer.Option(help="Length of a barrel, depth of a free-edge plan, in m.")
    ] = None,
    rise: Annotated[
        float | None, typer.Option(help="Rise of a barrel, height of a form found, in m.")
    ] = None,
    eye: Annotated[float, typer.Option(help="Diameter of the opening at the crown, in m.")] = 1.0,
    keystone: Annotated[
        bool, typer.Option("--keystone", help="Close the opening with one block.")
    ] = False,
    supports: Annotated[
        str | None,
        typer.Option(help="Sides that a mesh stands on: bottom, top, left, right; by commas."),
    ] = None,
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
        float, typer.Option(help="Shift of bed joints, by the height of a course: -0.45 to 0.45.")
    ] = 0.0,
    thickness: Annotated[
        float | None, typer.Option(help="Thickness in m (the size of the surface by 30).")
    ] = None,
    register: Annotated[
        float, typer.Option(help="Degrees by which bed joints are turned to hook blocks.")
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
    from drystone.shells import Body, Intrados, Layout, build_shell

    layout = Layout(
        courses=12 if courses is None and course_height is None else courses,
        height=course_height,
        partial=_partial(partial),
        blocks=blocks,
        width=span / 8.0 if blocks is None and width is None else width,
        wedge=wedge,
    )
    body = Body(
        thickness=thickness,
        register_deg=register,
        intrados=Intrados.STRAIGHT if straight else Intrados.OFFSET,
    )
    with Waiting() as waiting:
        waiting.stage("read", "building the shell")
        shape, notes = _shape(surface, span, length, rise, eye, keystone, supports, thickness)
        made = build_shell(shape, layout, body, progress=waiting)
        contacts, report = found(made.assembly, friction, waiting)
        notes += warnings_of(report)
        if not made.planar.reached:
            notes.append(f"joints are up to {made.planar.warp_after:.1e} of a block from planar")
        load = weight(made.assembly, None)
        prepared = Prepared(made.assembly, contacts, load, report, tuple(notes))
        result = verdict.solve(prepared, waiting, time_limit)
        written = _write(made, model_path, schedule_path, unrolled_path, block_files)
        pictures.write(result, waiting)
    data = verdict.content(result, prepared, waiting.time_s, shape.name, pictures)
    data["files"] = [*written, *data["files"]]
    data["shell"] = summary(made)
    if as_json:
        output.emit(data)
    else:
        verdict.show(data)
        _show(data["shell"])
    return verdict.exit_code(result, strict=False)


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
        "moved_off_surface": made.fitted,
    }


def _show(told: dict[str, Any]) -> None:
    console = output.console()
    console.print(
        f"{told['voussoirs']} voussoirs in {told['courses']} courses, {told['ground_blocks']} "
        f"ground blocks, {told['volume']:.2f} m3"
    )
    console.print(
        f"largest warp of a joint {told['warp_before']:.2%} of a block before, "
        f"{told['warp_after']:.1e} after planarising; largest drift {told['drift']:.1%}"
    )


def _path(text: str | None, option: str, suffixes: tuple[str, ...]) -> Path | None:
    return None if text is None else options.output_path(text, option, suffixes)


def _partial(text: str) -> int | None:
    if text == "auto":
        return None
    try:
        return int(text)
    except ValueError as error:
        raise InputError(
            f"is '{text}'", where="--partial", remedy="give a number or auto"
        ) from error


def _shape(
    surface: str,
    span: float,
    length: float | None,
    rise: float | None,
    eye: float,
    keystone: bool,
    supports: str | None,
    thickness: float | None,
) -> tuple[Shape, list[str]]:
    """The surface, and remarks about how it was made."""
    from drystone import shells

    options.positive(span, "--span")
    options.positive(length, "--length")
    options.positive(rise, "--rise")
    options.positive(eye, "--eye")
    if surface not in {kind.value for kind in Kind}:
        return _from_mesh(surface, supports)
    kind = Kind(surface)
    if supports is not None:
        raise InputError(
            "is for mesh files", where="--supports", remedy=f"leave it out for '{surface}'"
        )
    if kind is Kind.BARREL:
        return shells.barrel_vault(span, span if length is None else length, rise), []
    if kind is Kind.CROSS:
        return shells.cross_vault(span), []
    if kind is Kind.PAVILION:
        return shells.pavilion_vault(span, eye, keystone=keystone), []
    if kind is Kind.DOME:
        return shells.dome(0.5 * span, 0.5 * eye, keystone=keystone), []
    if kind is Kind.FREE_EDGE:
        plan = shells.rectangular_plan(span, span * 5.0 / 6.0 if length is None else length)
    else:
        plan = shells.three_legged_plan(span, span * 2.5 / 6.0, span * 0.4)
    form = shells.find_form(plan, height=0.3 * span if rise is None else rise, thickness=thickness)
    return form.shape, [f"form found in {form.rounds} rounds, {form.height:.3f} m high"]


def _from_mesh(path: str, supports: str | None) -> tuple[Shape, list[str]]:
    from drystone import shells

    if not Path(path).suffix:
        raise InputError(
            f"surface '{path}' is not known",
            remedy=f"use {', '.join(kind.value for kind in Kind)} or a mesh file",
        )
    fit = shells.patch_from_mesh(*shells.read_surface(path), name=Path(path).name)
    sides = ("bottom", "top") if supports is None else tuple(supports.split(","))
    shape = shells.Shape((fit.patch,), (), tuple(_edge(s) for s in sides), name=fit.patch.name)
    return shape, [f"the mesh is up to {1e3 * fit.deviation_max:.3g} mm from the patch fitted"]


def _edge(text: str) -> Edge:
    from drystone.shells import Edge, Side

    known = [side.value for side in Side]
    if text.strip() not in known:
        raise InputError(
            f"'{text}' is not a side", where="--supports", remedy=f"name {', '.join(known)}"
        )
    return Edge(0, Side(text.strip()))


def _write(
    made: Shell,
    out: Path | None,
    schedule: Path | None,
    unrolled: Path | None,
    block_files: str | None,
) -> list[str]:
    from drystone import io, shells

    written: list[str] = []
    if out is not None:
        io.write(made.assembly, out)
    if schedule is not None:
        shells.write_schedule(made, schedule)
    if unrolled is not None:
        shells.write_unrolled(made, unrolled)
    written += [str(path) for path in (out, schedule, unrolled) if path is not None]
    if block_files is not None:
        shells.write_blocks(made, block_files)
        written.append(f"{block_files} ({len(made.voussoirs)} files)")
    return written
