"""``drystone limit thickness`` and ``drystone limit imperfections``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli import families, kinds, loading, options
from drystone.cli.command import OUTPUT, Argument, Option, command
from drystone.cli.model_input import Subject
from drystone.cli.options import LimitSearch
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Pictures, apart

if TYPE_CHECKING:
    from drystone.assembly import Assembly
    from drystone.base.files import Job
    from drystone.cli.told import Files
    from drystone.limits import StandingShare

SEARCHED = {
    "arch": ("thickness_ratio", "", (0.2, 0.05)),
    "buttressed-arch": ("thickness", "m", (0.5, 0.05)),
    "barrel-vault": ("thickness", "m", (0.5, 0.05)),
    "vault": ("thickness", "m", (0.4, 0.01)),
    "dome": ("thickness", "m", (0.5, 0.05)),
}
"""Parameter that is thickness, its unit, and the range that is searched, by family."""


def _pair(text: str) -> tuple[float, float]:
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError as error:
        raise InputError(f"'{text}' is not LOW,HIGH", remedy="write 0.5,0.7") from error
    return low, high


_ZERO_OR_MORE = kinds.number(least=0.0)
_ORDERS = ("at-once", "ramp", "turned")


@dataclass(frozen=True)
class Drawn:
    """The files of a study of imperfections."""

    table: Annotated[
        Path | None,
        Option("Write every draw with its verdict, .csv.", OUTPUT, kind=kinds.target(".csv")),
    ] = None
    png: options.Png = None

    def __post_init__(self) -> None:
        apart([self.table, self.png])


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
    friction: options.Friction = None,
    search: LimitSearch,
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The least thickness at which a parametric model stands."""
    name, unit, (first, last) = SEARCHED[family]
    build, known = families.family(family)
    if parameter is not None and parameter != name:
        if thick is None or thin is None:
            raise InputError(
                "needs a range", where="--parameter", remedy="give --from and --to too"
            )
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
    with search.under_way(waiting) as common:
        found = limit_thickness(
            made,
            start,
            last if thin is None else thin,
            friction=0.6 if friction is None else friction,
            parameter=name,
            unit=unit,
            **common,
        )
    return Told(found, subject=family, files=partial(pictures.of, found))


@command(
    "drystone limit imperfections arch.json --offset 0.01 --draws 10",
    "drystone limit imperfections arch.json --tolerance 0.002 --draws 2 --order ramp",
)
def imperfections(
    *,
    subject: Subject,
    draws: Annotated[int, Option("Number of random structures (100).")] = 100,
    seed: Annotated[int, Option("The same seed gives the same draws (0).", expert=True)] = 0,
    friction_range: Annotated[
        tuple[float, float] | None,
        Option(
            "Range of the friction of each joint, uniform.",
            kind=kinds.OptionKind("LOW,HIGH", _pair),
        ),
    ] = None,
    corner_loss: Annotated[
        float,
        Option(
            "Probability that a corner of a joint is broken off.", kind=_ZERO_OR_MORE, expert=True
        ),
    ] = 0.0,
    offset: Annotated[
        float,
        Option(
            "Shift of joints in their plane by the root of their area.",
            kind=_ZERO_OR_MORE,
            expert=True,
        ),
    ] = 0.0,
    turn: Annotated[
        float,
        Option("Turn of joints out of their plane, degrees.", kind=_ZERO_OR_MORE, expert=True),
    ] = 0.0,
    tolerance: Annotated[
        float,
        Option("Tolerance of the joints in m: they are shifted and turned.", kind=_ZERO_OR_MORE),
    ] = 0.0,
    order: Annotated[
        tuple[str, ...],
        Option(
            "Follow every draw by steps, the load put on at-once, as a ramp, or turned from "
            "upright, instead of the check. Can be given several times.",
            kind=kinds.one_of(_ORDERS),
        ),
    ] = (),
    seismic: loading.Seismic = None,
    workers: options.Workers = 1,
    time_limit: options.TimeLimit = None,
    files: Drawn,
    waiting: Waiting,
) -> Told:
    """The share of random imperfect copies of a model that stand.

    Exit code 0: all of them. 1: not all.
    """
    from drystone import limits

    imperfect = limits.Imperfections(
        friction=friction_range,
        corner_loss=corner_loss,
        offset=offset,
        tilt_deg=turn,
        tolerance=tolerance,
    )
    if imperfect == limits.Imperfections():
        raise InputError(
            "nothing is imperfect",
            remedy="give --tolerance, --friction-range, --corner-loss, --offset or --turn",
        )
    model = subject.prepared(waiting, seismic=seismic)
    waiting.stage("solve", "drawing")
    with waiting.keywords(time_limit, workers) as common:
        found = limits.imperfections(
            model,
            imperfect,
            draws=draws,
            seed=seed,
            loading=[name.replace("-", " ") for name in order],
            **common,
        )
    notes = list(model.notes)
    if found.draws < draws:
        notes.append(f"interrupted after {found.draws} of {draws} draws")
    return Told(found, notes=notes, files=partial(_files, found, files))


def _files(found: StandingShare, wanted: Drawn) -> Files:
    """The table of draws and the plot of shares."""
    jobs: list[Job] = []
    if wanted.table is not None:
        jobs.append((wanted.table, found.table().to_csv))
    if wanted.png is not None:
        from drystone.view import save_figure  # work is imported when there is some

        jobs.append((wanted.png, partial(save_figure, found)))
    return jobs, []


def _built(
    build: Callable[..., Assembly], name: str, fixed: dict[str, Any], value: float
) -> Assembly:
    return build(**fixed, **{name: value})
