"""``drystone shell``: a surface divided into blocks, with files and a verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli import families, kinds, options
from drystone.cli.check_command import safe, solve
from drystone.cli.command import command
from drystone.cli.model_input import HOW
from drystone.cli.offered import OUTPUT, Analysis, Argument, Experts, Of, Option, writes
from drystone.cli.shell_pattern import (
    ShellPattern,
    find_buildable,
    shell_on,
    varied_shell,
    with_values,
)
from drystone.cli.surfaces import SurfaceRequest, surface_of
from drystone.cli.told import Pictures, Told, apart
from drystone.cli.tune_command import SearchRequest, parameter_range
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.assembly import Assembly
    from drystone.cli.told import Files, Jobs
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
            "course, so that the fewest blocks need help, propped or held, while it is built."
        ),
    ] = False,
    search: Annotated[SearchRequest, Experts(but=("vary",))],
    reading: Annotated[Analysis, HOW(("friction", "ends"), shown=("friction",))],
    time_limit: options.TimeLimit = None,
    out: Annotated[
        Path | None,
        Option("Write the blocks.", OUTPUT, kind=kinds.MODEL_FILE),
    ] = None,
    schedule: Annotated[
        Path | None,
        writes("Write the schedule: .csv.", ".csv", expert=True),
    ] = None,
    unrolled: Annotated[
        Path | None,
        writes("Write the flattened joint faces: .svg or .dxf.", ".svg", ".dxf", expert=True),
    ] = None,
    block_files: Annotated[
        Path | None,
        Option(
            "Folder for a file per block in its own frame.", OUTPUT, kind=kinds.FOLDER, expert=True
        ),
    ] = None,
    block_format: Annotated[
        str | None,
        Option("Format of these files (obj).", OUTPUT, kind=kinds.one_of(_BLOCK_FORMATS),
        expert=True),
    ] = None,
    pictures: Pictures,
    waiting: Waiting,
) -> Told:  # fmt: skip
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
    from drystone.stability.doubts import unit_doubts

    waiting.stage("read", "building the shell")
    base = surface_of(wanted)
    for doubt in unit_doubts(base.notes):
        if waiting.ask(f"{doubt.text} Use {doubt.option}?"):
            wanted = replace(wanted, **doubt.how)
            base = surface_of(wanted)
        else:
            waiting.warn(doubt.text)
    tuned = None
    if search.vary:
        if buildable:
            raise InputError(
                "are two searches", where="--buildable and --vary", remedy="give one of them"
            )
        tuned = _search(wanted, pattern, search, reading.given, waiting, time_limit)
        if not tuned.front:
            return Told(tuned, subject=wanted.surface)
        wanted, pattern = with_values(wanted, pattern, **tuned.front[0].values)
        base = surface_of(wanted)
    else:
        # workers are for the search of wedges as well
        (replace(search, workers=1) if buildable else search).refuse_without_vary()
    from drystone.shells import build_shell, write_blocks
    from drystone.shells.shell_by_name import COURSES

    waiting.stage("read", "building the shell")
    told = None
    if buildable:
        layout = pattern.layout(base.width, COURSES)
        body = pattern.body(wanted.sizes.get("thickness"))
        told = find_buildable(
            base.shape, layout, body, pattern, reading.given, waiting, time_limit, search.workers
        )
        made = build_shell(base.shape, told.layout or layout, body)
    else:
        made = shell_on(base, wanted, pattern, waiting)
    model = replace(made.model(**reading.given), notes=(*base.notes, *made.notes))
    pictures.require_through(model.assembly)
    result = safe(solve(model, waiting, time_limit), waiting)
    if block_files is not None:
        write_blocks(made, block_files, suffix=f".{block_format or 'obj'}")
        waiting.wrote = [f"{block_files} ({len(made.voussoirs)} files)"]
    files = partial(_files, made, out, schedule, unrolled, pictures.of(result)[0])
    also = {"shell": made, "buildable": told, "search": tuned}
    return Told(
        result, {key: one for key, one in also.items() if one is not None}, base.shape.name,
        notes=result.model.notes, files=files, written=waiting.wrote,
    )  # fmt: skip


def _search(
    wanted: SurfaceRequest,
    pattern: ShellPattern,
    search: SearchRequest,
    joints: Mapping[str, Any],
    waiting: Waiting,
    time_limit: float | None,
) -> Tuned:
    """The shells that were tried."""
    known = families.shell_parameters()
    ranges = [parameter_range(text, known) for text in search.vary]
    with_values(wanted, pattern, **{one.name: one.choices[0] if one.choices else one.low
                                    for one in ranges})  # fmt: skip
    return search.run(partial(varied_shell, wanted, pattern), known, joints, waiting, time_limit)


def _files(
    made: Shell, out: Path | None, schedule: Path | None, unrolled: Path | None, pictures: Jobs
) -> Files:
    from drystone import io, shells

    return [
        (out, partial(io.write, made.assembly)),
        (schedule, lambda path: shells.schedule(made).to_csv(path)),
        (unrolled, partial(shells.write_unrolled, made)),
        *pictures,
    ], []


SEARCHED = {
    "arch": ("thickness_ratio", "", (0.2, 0.05)),
    "buttressed-arch": ("thickness", "m", (0.5, 0.05)),
    "barrel-vault": ("thickness", "m", (0.5, 0.05)),
    "vault": ("thickness", "m", (0.4, 0.01)),
    "dome": ("thickness", "m", (0.5, 0.05)),
}
"""Parameter that is thickness, its unit, and the range that is searched, by family."""


@command(
    "drystone limit thickness arch --set voussoirs=12",
    "drystone limit thickness arch --friction 0.8 --html thin.html",
)
def thickness(
    *,
    family: Annotated[
        str, Argument("FAMILY", "A parametric model.", kinds.one_of(SEARCHED, "there is no '{}'"))
    ],
    set: families.Settings = (),
    parameter: Annotated[str | None, Option("Search another parameter than the thickness.")] = None,
    thick: Annotated[
        float | None,
        Option(
            "Value at which the search starts; the model should stand there.", flags=("--from",)
        ),
    ] = None,
    thin: Annotated[
        float | None, Option("Value at which the search ends.", flags=("--to",))
    ] = None,
    asked: Annotated[
        Analysis,
        Of(
            "drystone.limits.limit_thickness",
            without=("find", "parameter", "unit"),
            shown=("friction", "strength"),
        ),
    ],
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The least thickness at which a parametric model stands."""
    name, unit, (first, last) = SEARCHED[family]
    build, known = families.family(family)
    if parameter is not None and parameter != name:
        if thick is None or thin is None:
            raise InputError("needs a range", where="--parameter", remedy="give --from and --to")
        families.refuse_unknown(parameter, known, "--parameter")
        name, unit = parameter, ""
    fixed = dict(families.setting(text, known) for text in set)
    if name in fixed:
        raise InputError(f"'{name}' is what is searched", where="--set", remedy="leave it out")
    from drystone.limits import limit_thickness

    start = first if thick is None else thick
    made = partial(_built, build, name, fixed)
    if pictures.section is not None:
        pictures.require_through(made(start))
    asked = asked.instead(limit_thickness, parameter=name, unit=unit)
    found = asked.of(waiting, made, start, last if thin is None else thin)
    notes = [] if {thick, thin} - {None} else ["--from and --to search another range"]
    return Told(found, subject=family, notes=notes, files=partial(pictures.of, found))


def _built(
    build: Callable[..., Assembly], name: str, fixed: dict[str, Any], value: float
) -> Assembly:
    return build(**fixed, **{name: value})
