"""``drystone limit thickness`` of parametric models, ``drystone limit tolerance`` of any."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drystone.cli import limit_answer, limit_options, loading, options, output, verdict
from drystone.cli.groups import Subject, expanded
from drystone.cli.limit_options import Search, working
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

if TYPE_CHECKING:
    from drystone.assembly import Assembly
    from drystone.limits import Tolerance

FAMILIES = {
    "arch": ("thickness_ratio", "", (0.2, 0.05)),
    "buttressed-arch": ("thickness", "m", (0.5, 0.05)),
    "barrel-vault": ("thickness", "m", (0.5, 0.05)),
    "vault": ("thickness", "m", (0.4, 0.01)),
    "dome": ("thickness", "m", (0.5, 0.05)),
}
"""Parameter that is thickness, its unit, and the range that is searched, by family."""


@expanded
def thickness(
    *,
    family: Annotated[str, typer.Argument(metavar="FAMILY", help=f"One of {', '.join(FAMILIES)}.")],
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Another parameter of the family, such as voussoirs=36. Can be given several "
            "times.",
        ),
    ] = None,
    parameter: Annotated[
        str | None, typer.Option(help="Search another parameter than the thickness.")
    ] = None,
    thick: Annotated[
        float | None, typer.Option("--from", help="Where the search starts: it should stand.")
    ] = None,
    thin: Annotated[float | None, typer.Option("--to", help="Where the search ends.")] = None,
    friction: options.Friction = None,
    search: Search,
    html: options.Html = None,
    as_json: options.Json = False,
) -> int:
    """The least thickness at which a parametric model stands."""
    files = verdict.Files.checked(html, None)
    search.options()
    if family not in FAMILIES:
        raise InputError(f"there is no '{family}'", where="FAMILY", remedy=", ".join(FAMILIES))
    name, unit, (first, last) = FAMILIES[family]
    build, kinds = _family(family)
    if parameter is not None and parameter != name:
        if thick is None or thin is None:
            raise InputError(
                "needs a range", where="--parameter", remedy="give --from and --to too"
            )
        _known(parameter, kinds, "--parameter")
        name, unit = parameter, ""
    fixed = dict(_setting(text, kinds, name) for text in settings or ())
    with Waiting() as waiting:
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
    return limit_answer.tell(found, family, (), files, waiting, as_json)


@expanded
def tolerance(
    *,
    draws: Annotated[int, typer.Option(help="Number of random structures.")] = 100,
    seed: Annotated[int, typer.Option(help="The same seed gives the same draws.")] = 0,
    friction_range: Annotated[
        str | None, typer.Option(metavar="LOW,HIGH", help="Friction of each joint, uniform.")
    ] = None,
    corner_loss: Annotated[
        float, typer.Option(help="Probability that a corner of a joint has broken off.")
    ] = 0.0,
    offset: Annotated[
        float, typer.Option(help="Shift of joints in their plane by the root of their area.")
    ] = 0.0,
    turn: Annotated[float, typer.Option(help="Turn of joints out of their plane, degrees.")] = 0.0,
    subject: Subject,
    seismic: loading.Seismic = None,
    workers: limit_options.Workers = 1,
    as_json: options.Json = False,
) -> int:
    """The share of imperfect structures that stand, drawn at random.

    Exit code 0: all of them. 1: not all.
    """
    for value, option in ((offset, "--offset"), (turn, "--turn"), (corner_loss, "--corner-loss")):
        if not 0.0 <= value < float("inf"):
            raise InputError(f"is {value}", where=option, remedy="give zero or more")
    with Waiting() as waiting:
        from drystone import limits

        kinds = limits.Imperfections(
            friction=None if friction_range is None else _pair(friction_range),
            corner_loss=corner_loss,
            offset=offset,
            tilt_deg=turn,
        )
        if kinds == limits.Imperfections():
            raise InputError(
                "nothing is imperfect",
                remedy="give --friction-range, --corner-loss, --offset or --turn",
            )
        prepared = subject.prepared(waiting, seismic=seismic)
        waiting.stage("solve", "drawing")
        with working(workers, waiting) as common:
            answer = limits.tolerance(
                prepared,
                kinds,
                draws=draws,
                seed=seed,
                **common,
            )
    data = {"model": subject.model, **answer.to_dict(), "notes": list(prepared.notes)}
    data["time_s"] = dict(waiting.time_s)
    if as_json:
        output.emit(data)
    else:
        _show(answer, draws, data)
    return waiting.exit_code(0 if answer.share == 1.0 else 1)


def _show(answer: Tolerance, draws: int, data: dict[str, Any]) -> None:
    from rich.markup import escape

    console = output.console()
    low, high = answer.interval
    console.print(
        f"[bold]{data['standing']} of {data['draws']}[/] imperfect structures stand  "
        f"{escape(data['model'])}"
    )
    console.print(
        f"share {answer.share:.1%}, between {low:.1%} and {high:.1%} at {answer.confidence:.0%} "
        "confidence"
    )
    if len(answer.verdicts) < draws:
        console.print(f"[yellow]note:[/] interrupted after {len(answer.verdicts)} of {draws} draws")
    if data["undecided"]:
        console.print(f"[yellow]note:[/] {data['undecided']} draws are undecided")
    for note in data["notes"]:
        console.print(f"[yellow]note:[/] {escape(note)}")


def _family(name: str) -> tuple[Callable[..., Assembly], dict[str, type]]:
    """A family and the types of its plain parameters, from their defaults."""
    from drystone import models

    build: Callable[..., Assembly] = getattr(models, name.replace("-", "_"))
    defaults = {p.name: p.default for p in inspect.signature(build).parameters.values()}
    kinds = {key: type(value) for key, value in defaults.items()}
    return build, {key: float if kind is tuple else kind for key, kind in kinds.items()}


def _known(name: str, kinds: dict[str, type], where: str) -> None:
    if name not in kinds:
        raise InputError(
            f"there is no parameter '{name}'", where=where, remedy=f"use {', '.join(kinds)}"
        )


def _setting(text: str, kinds: dict[str, type], searched: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    name = name.replace("-", "_")
    if not equals:
        raise InputError(f"'{text}' is not NAME=VALUE", where="--set")
    _known(name, kinds, "--set")
    if name == searched:
        raise InputError(f"'{name}' is what is searched", where="--set", remedy="leave it out")
    if kinds[name] is bool:
        if value not in ("true", "false"):
            raise InputError(f"{name} is '{value}'", where="--set", remedy="true or false")
        return name, value == "true"
    try:
        return name, kinds[name](value)
    except ValueError as error:
        kind = "a whole number" if kinds[name] is int else "a number"
        raise InputError(f"{name} is '{value}', not {kind}", where="--set") from error


def _built(
    build: Callable[..., Assembly], name: str, fixed: dict[str, Any], value: float
) -> Assembly:
    return build(**fixed, **{name: value})


def _pair(text: str) -> tuple[float, float]:
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError as error:
        raise InputError(
            f"'{text}' is not LOW,HIGH", where="--friction-range", remedy="write 0.5,0.7"
        ) from error
    return low, high
