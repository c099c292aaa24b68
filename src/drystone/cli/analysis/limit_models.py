"""``drystone limit thickness`` of parametric models, ``drystone limit imperfections`` of any."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli.analysis import limit_answer
from drystone.cli.base import kinds
from drystone.cli.base.answer import Answer
from drystone.cli.base.command import Argument, Option, command
from drystone.cli.base.output import Screen
from drystone.cli.base.waiting import Waiting
from drystone.cli.base.written import Pictures
from drystone.cli.inputs import families, limit_options, loading, options
from drystone.cli.inputs.limit_options import Search, working
from drystone.cli.inputs.model_input import Subject

if TYPE_CHECKING:
    from drystone.assembly import Assembly
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


ZERO_OR_MORE = kinds.number(least=0.0)


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
        float | None, Option("Where the search starts: it should stand.", flags=("--from",))
    ] = None,
    thin: Annotated[float | None, Option("Where the search ends.", flags=("--to",))] = None,
    friction: options.Friction = None,
    search: Search,
    pictures: Pictures,
    waiting: Waiting,
) -> Answer:
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

    with search.under_way(waiting) as common:
        found = limit_thickness(
            partial(_built, build, name, fixed),
            first if thick is None else thick,
            last if thin is None else thin,
            friction=0.6 if friction is None else friction,
            parameter=name,
            unit=unit,
            **common,
        )
    return limit_answer.answer(found, family, (), pictures, waiting)


@command(
    "drystone limit imperfections arch.json --offset 0.01 --draws 10",
    "drystone limit imperfections arch.json --friction-range 0.5,0.7 --turn 0.5 --draws 10",
)
def imperfections(
    *,
    subject: Subject,
    draws: Annotated[int, Option("Number of random structures (100).")] = 100,
    seed: Annotated[int, Option("The same seed gives the same draws (0).", expert=True)] = 0,
    friction_range: Annotated[
        tuple[float, float] | None,
        Option("Friction of each joint, uniform.", kind=kinds.Kind("LOW,HIGH", _pair)),
    ] = None,
    corner_loss: Annotated[
        float,
        Option(
            "Probability that a corner of a joint has broken off.", kind=ZERO_OR_MORE, expert=True
        ),
    ] = 0.0,
    offset: Annotated[
        float,
        Option("Shift of joints in their plane by the root of their area.", kind=ZERO_OR_MORE),
    ] = 0.0,
    turn: Annotated[
        float, Option("Turn of joints out of their plane, degrees.", kind=ZERO_OR_MORE)
    ] = 0.0,
    seismic: loading.Seismic = None,
    workers: limit_options.Workers = 1,
    waiting: Waiting,
) -> Answer:
    """The share of imperfect structures that stand, drawn at random.

    Exit code 0: all of them. 1: not all.
    """
    from drystone import limits

    imperfect = limits.Imperfections(
        friction=friction_range, corner_loss=corner_loss, offset=offset, tilt_deg=turn
    )
    if imperfect == limits.Imperfections():
        raise InputError(
            "nothing is imperfect",
            remedy="give --friction-range, --corner-loss, --offset or --turn",
        )
    model = subject.prepared(waiting, seismic=seismic)
    waiting.stage("solve", "drawing")
    with working(workers, waiting) as common:
        found = limits.imperfections(model, imperfect, draws=draws, seed=seed, **common)
    data = {"model": subject.model, **found.to_dict()}
    notes = list(model.notes)
    if len(found.verdicts) < draws:
        notes.append(f"interrupted after {len(found.verdicts)} of {draws} draws")
    if data["undecided"]:
        notes.append(f"{data['undecided']} draws are undecided")
    return Answer(data, partial(_show, found, data), 0 if found.share == 1.0 else 1, notes)


def _show(found: StandingShare, data: dict[str, Any], screen: Screen) -> None:
    low, high = found.interval
    stand = f"{data['standing']} of {data['draws']}"
    screen.line(f"imperfect structures stand  {data['model']}", stand, gap=" ")
    screen.line(
        f"share {found.share:.1%}, between {low:.1%} and {high:.1%} at {found.confidence:.0%} "
        "confidence"
    )


def _built(
    build: Callable[..., Assembly], name: str, fixed: dict[str, Any], value: float
) -> Assembly:
    return build(**fixed, **{name: value})
