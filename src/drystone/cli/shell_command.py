"""``drystone shell``: a surface divided into blocks, with files and a verdict; and ``tune``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError, located
from drystone.cli import families, kinds, offered
from drystone.cli.check_command import safe, solve
from drystone.cli.command import command
from drystone.cli.model_input import HOW
from drystone.cli.offered import MODEL, OUTPUT, Analysis, Argument, Of, Option, writes
from drystone.cli.shell_request import ShellPattern, SurfaceRequest, find_buildable, surface_of
from drystone.cli.told import Pictures, Told, apart
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.assembly import Assembly
    from drystone.cli.told import Files, Jobs
    from drystone.design import Parameter, Tuned, TuneOptions
    from drystone.shells import Shell


def parameter_range(text: str, known: families.Parameters) -> Parameter:
    """A parameter from ``NAME=LOW:HIGH`` or ``NAME=ONE,OTHER``."""
    from drystone.design import Parameter

    name, equals, bounds = text.partition("=")
    name = name.replace("-", "_")
    if not equals:
        raise InputError(f"'{text}' is not NAME=LOW:HIGH", where="--vary")
    families.refuse_unknown(name, known, "--vary")
    low, colon, high = bounds.partition(":")
    with located("--vary"):
        values = [
            families.setting(f"{name}={one}", known)[1]
            for one in ((low, high) if colon else bounds.split(","))
        ]
    if not colon:
        return Parameter(name, choices=tuple(values))
    if not all(isinstance(end, int | float) for end in values):
        raise InputError(
            f"{name} has no bounds", where="--vary", remedy="give values separated by commas"
        )
    whole = all(isinstance(end, int) for end in values)
    return Parameter(name, float(values[0]), float(values[1]), whole=whole)


@command(
    "drystone tune arch --vary thickness_ratio=0.05:0.3 --friction 0.8 --trials 20",
    "drystone tune tower --vary edge=0.5:2 --vary count=2:6 --least volume --most height",
)
def tune(
    *,
    family: Annotated[
        str,
        Argument(
            "FAMILY",
            "A parametric family; 'drystone models' lists all. Or a shell: barrel-shell, "
            "dome-shell, free-edge-shell and others.",
        ),
    ],
    set: families.Settings = (),
    reading: Annotated[Analysis, HOW(("friction", "ends"), shown=("friction",))],
    vary: Annotated[
        tuple[str, ...],
        Option(
            "A parameter and its bounds, or values separated by commas, to be searched. Can be "
            "given several times.",
            MODEL,
            metavar="NAME=LOW:HIGH",
        ),
    ] = (),
    least: Annotated[
        tuple[str, ...],
        Option(
            "What is to be least: volume, blocks, height, reach, props, held or a parameter "
            "(volume).",
            metavar="GOAL",
        ),
    ] = (),
    most: Annotated[tuple[str, ...], Option("What is to be most.", metavar="GOAL")] = (),
    chosen: Annotated[
        TuneOptions,
        Of(
            "drystone.design.TuneOptions",
            without=("batch",),
            shown=("props", "trials"),
            metavars={"margin": "WHAT"},
        ),
    ],
    workers: offered.Workers = 1,
    store: Annotated[
        Path | None,
        Option(
            "File that keeps the trials: an interrupted search continues from it.",
            OUTPUT,
            kind=kinds.target(),
        ),
    ] = None,
    out: Annotated[
        Path | None,
        Option("Write the best model by the first goal.", OUTPUT, kind=kinds.MODEL_FILE),
    ] = None,
    png: Annotated[
        Path | None,
        writes("Draw the trials and the front: .png, .svg or .pdf.", ".png", ".svg", ".pdf"),
    ] = None,
    time_limit: offered.TimeLimit = None,
    waiting: Waiting,
) -> Told:
    """Search for the parameters with which a family of structures stands and is best.

    With several goals the front is listed: no other structure is better in all of them.

    Exit code 0: some structure stands. 1: none does. 2: bad input. 130: Ctrl-C ended the search;
    the trials so far are the answer.
    """
    build, known = families.shell_family(family) or families.family(family)
    given = dict(families.setting(text, known) for text in set)
    twice = {text.partition("=")[0].replace("-", "_") for text in vary} & given.keys()
    if twice:
        raise InputError(
            f"{', '.join(sorted(twice))} is set, and varied",
            where="--set",
            remedy="give one of them",
        )
    if not vary:
        raise InputError("nothing is varied", where="--vary", remedy="write --vary NAME=LOW:HIGH")
    ranges = [parameter_range(text, known) for text in vary]
    from drystone import design  # work is imported when there is some

    made, how = partial(build, **given), reading.given
    goals = (*least, *(f"-{goal}" for goal in most)) or ("volume",)
    waiting.stage("tune", "searching")
    waiting.checkpoint = store
    with waiting.keywords(time_limit, workers) as common:
        found = design.tune(
            made, ranges, goals=goals, how=how, store=store, options=chosen, **common
        )
    return Told(found, subject=family, files=partial(_tuned_files, found, made, how, out, png))


def _tuned_files(
    found: Tuned, build: Any, how: Mapping[str, Any], out: Path | None, png: Path | None
) -> Files:
    from drystone import io
    from drystone.design.tuning import model_of
    from drystone.view import save_figure

    def write(path: Path) -> None:
        io.write(model_of(build(**found.front[0].values), how), path)

    return [(out if found.front else None, write), (png, partial(save_figure, found))], []


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
    workers: offered.Workers = 1,
    reading: Annotated[Analysis, HOW(("friction", "ends"), shown=("friction",))],
    time_limit: offered.TimeLimit = None,
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

    Exit code 0: it stands. 1: it does not. 2: bad input. 130: Ctrl-C ended it; of a search the best
    shell so far is written.
    """
    apart([out, schedule, unrolled, pictures.html, pictures.png])
    pattern.refuse_two_ways()
    if block_format is not None and block_files is None:
        raise InputError(
            "is for --block-files", where="--block-format", remedy="name a folder with that"
        )
    if workers != 1 and not buildable:
        raise InputError("is for --buildable", where="--workers", remedy="give that with it")
    from drystone.stability.doubts import unit_doubts

    waiting.stage("read", "building the shell")
    base = surface_of(wanted)
    for doubt in unit_doubts(base.notes):
        if waiting.ask(f"{doubt.text} Use {doubt.option}?"):
            wanted = replace(wanted, **doubt.how)
            base = surface_of(wanted)
        else:
            waiting.warn(doubt.text)
    from drystone.shells import build_shell, write_blocks
    from drystone.shells.shell_families import COURSES

    waiting.stage("read", "building the shell")
    told = None
    layout = pattern.layout(base.width, COURSES if buildable else base.courses)
    body = pattern.body(wanted.sizes.get("thickness"))
    if buildable:
        told = find_buildable(
            base.shape, layout, body, pattern, reading.given, waiting, time_limit, workers
        )
        layout = told.layout or layout
    made = build_shell(base.shape, layout, body, progress=waiting)
    model = replace(made.model(**reading.given), notes=(*base.notes, *made.notes))
    pictures.require_through(model.assembly)
    result = safe(solve(model, waiting, time_limit), waiting)
    if block_files is not None:
        write_blocks(made, block_files, suffix=f".{block_format or 'obj'}")
        waiting.wrote = [f"{block_files} ({len(made.voussoirs)} files)"]
    files = partial(_files, made, out, schedule, unrolled, pictures.of(result)[0])
    also = {"shell": made, "buildable": told}
    return Told(
        result, {key: one for key, one in also.items() if one is not None}, base.shape.name,
        notes=result.model.notes, files=files, written=waiting.wrote,
    )  # fmt: skip


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
