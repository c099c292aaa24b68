"""``drystone limit thickness`` and ``drystone limit imperfections``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli import families, kinds, options
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import OUTPUT, Analysis, Argument, Of, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Pictures, apart

if TYPE_CHECKING:
    from drystone.assembly import Assembly
    from drystone.base.files import Job
    from drystone.cli.told import Files
    from drystone.limits import Imperfections, StandingShare

SEARCHED = {
    "arch": ("thickness_ratio", "", (0.2, 0.05)),
    "buttressed-arch": ("thickness", "m", (0.5, 0.05)),
    "barrel-vault": ("thickness", "m", (0.5, 0.05)),
    "vault": ("thickness", "m", (0.4, 0.01)),
    "dome": ("thickness", "m", (0.5, 0.05)),
}
"""Parameter that is thickness, its unit, and the range that is searched, by family."""


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
    asked: Annotated[
        Analysis,
        Of(
            "drystone.limits.limit_thickness",
            without=("find", "parameter", "unit"),
            shown=("friction",),
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
    asked = asked.instead(limit_thickness, parameter=name, unit=unit)
    found = asked.of(waiting, made, start, last if thin is None else thin)
    return Told(found, subject=family, files=partial(pictures.of, found))


@command(
    "drystone limit imperfections arch.json --offset 0.01 --draws 10",
    "drystone limit imperfections arch.json --tolerance 0.002 --draws 2 --order ramp",
)
def imperfections(
    *,
    subject: Subject,
    imperfect: Annotated[
        Imperfections,
        Of(
            "drystone.limits.Imperfections",
            shown=("friction", "tolerance"),
            flags={"friction": "--friction-range", "tilt_deg": "--turn"},
            metavars={"friction": "LOW,HIGH"},
        ),
    ],
    asked: Annotated[
        Analysis,
        Of(
            "drystone.limits.imperfections",
            shown=("draws", "loading"),
            flags={"loading": "--order"},
        ),
    ],
    files: Drawn,
    waiting: Waiting,
) -> Told:
    """The share of random imperfect copies of a model that stand.

    Exit code 0: all of them. 1: not all.
    """
    if imperfect == type(imperfect)():
        raise InputError(
            "nothing is imperfect",
            remedy="give --tolerance, --friction-range, --corner-loss, --offset or --turn",
        )
    model = subject.prepared(waiting)
    found = asked.of(waiting, model, imperfect, doing="drawing")
    draws = asked.given.get("draws", found.draws)
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
