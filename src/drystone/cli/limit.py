"""``drystone limit``: by how much does it stand?"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drystone.cli import limit_answer, loading, options, verdict
from drystone.cli.groups import Subject, expanded
from drystone.cli.limit_models import thickness, tolerance
from drystone.cli.limit_options import Search
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

if TYPE_CHECKING:
    from drystone.limits import Limit
    from drystone.model import Model

limit = typer.Typer(
    help="By how much does it stand: largest tilt or load, least friction, thickness, joint size.",
    no_args_is_help=True,
)
limit.command()(thickness)
limit.command()(tolerance)


@limit.command()
@expanded
def tilt(
    *,
    axis: Annotated[
        str | None, typer.Option(help="Turned counter-clockwise about: x, y, -x, -y or X,Y,Z (x).")
    ] = None,
    polar: Annotated[
        int | None, typer.Option(help="Number of directions to lean towards, instead of an axis.")
    ] = None,
    upper: Annotated[float, typer.Option(help="Angle at which the search ends.")] = 180.0,
    subject: Subject,
    search: Search,
    html: options.Html = None,
    png: options.Png = None,
    as_json: options.Json = False,
) -> int:
    """The largest angle by which a model can be turned; --polar in all directions."""
    if axis is not None and polar is not None:
        raise InputError("--axis and --polar contradict each other", remedy="give one of them")
    files = verdict.Files.checked(html, png)
    search.options()
    with Waiting() as waiting:
        from drystone import limits

        direction = _axis(axis)
        prepared = subject.prepared(waiting)
        with search.under_way(waiting) as common:
            if polar is not None:
                sweep = limits.tilt_sweep(prepared, polar, upper=upper, **common)
            else:
                found = limits.limit_tilt(prepared, direction, upper=upper, **common)
    if polar is not None:
        return limit_answer.tell_sweep(sweep, subject.model, prepared, files, waiting, as_json)
    return limit_answer.tell(found, subject.model, prepared.notes, files, waiting, as_json)


@limit.command(name="friction")
@expanded
def friction_(
    *,
    upper: Annotated[
        float | None, typer.Option(help="Coefficient at which the search starts (--friction).")
    ] = None,
    scaled: Annotated[
        bool, typer.Option("--scaled", help="Search the share of each joint's own coefficient.")
    ] = False,
    subject: Subject,
    seismic: loading.Seismic = None,
    search: Search,
    html: options.Html = None,
    as_json: options.Json = False,
) -> int:
    """The least friction coefficient at which a model stands."""

    def find(prepared: Model, common: dict[str, Any]) -> Limit:
        from drystone.limits import limit_friction  # work is imported when there is some

        return limit_friction(prepared, upper=upper, scaled=scaled, **common)

    return _answer(subject, search, seismic, find, html, as_json)


@limit.command()
@expanded
def load(
    *,
    case: Annotated[
        str,
        typer.Argument(
            metavar="CASE",
            help="The load that grows: the name of a load case of the file, seismic:KX,KY, or "
            "BLOCK:FX,FY,FZ[@X,Y,Z] (also BLOCK:80kg, BLOCK:m=MX,MY,MZ).",
        ),
    ],
    upper: Annotated[float, typer.Option(help="Factor at which the search ends.")] = 1000.0,
    subject: Subject,
    seismic: loading.Seismic = None,
    search: Search,
    html: options.Html = None,
    as_json: options.Json = False,
) -> int:
    """The largest factor of a load on top of the weight and of --load."""
    notes: list[str] = []

    def find(prepared: Model, common: dict[str, Any]) -> Limit:
        from drystone.limits import limit_load  # as above

        live = loading.chosen_case(case, prepared.assembly, prepared.cases)
        notes.extend(live.notes)
        return limit_load(prepared, live, upper=upper, **common)

    return _answer(subject, search, seismic, find, html, as_json, notes)


@limit.command()
@expanded
def shrink(
    *,
    subject: Subject,
    seismic: loading.Seismic = None,
    search: Search,
    html: options.Html = None,
    as_json: options.Json = False,
) -> int:
    """The least share of the size of all joints; its inverse is a geometric safety factor."""

    def find(prepared: Model, common: dict[str, Any]) -> Limit:
        from drystone.limits import limit_shrink  # as above

        return limit_shrink(prepared, **common)

    return _answer(subject, search, seismic, find, html, as_json, more=limit_answer.safety_factor)


def _answer(
    subject: Subject,
    search: Search,
    seismic: str | None,
    find: Callable[[Model, dict[str, Any]], Limit],
    html: str | None,
    as_json: bool,
    notes: list[str] | None = None,
    more: Callable[[Limit], dict[str, float]] | None = None,
) -> int:
    """Prepare the model, find the limit, tell it.

    What ``find`` adds to the notes is told too, and the figures of ``more``.
    """
    files = verdict.Files.checked(html, None)
    search.options()  # refused before the model is read
    with Waiting() as waiting:
        prepared = subject.prepared(waiting, seismic=seismic)
        with search.under_way(waiting) as common:
            found = find(prepared, common)
    told = (*prepared.notes, *(notes or ()))
    others = {} if more is None else more(found)
    return limit_answer.tell(found, subject.model, told, files, waiting, as_json, others)


def _axis(text: str | None) -> Any:
    from drystone.limits.limits import axis_vector

    given = "x" if text is None else text
    try:
        return axis_vector(options.vector(given, "--axis") if "," in given else given)
    except InputError as error:
        if error.where:
            raise
        raise InputError(error.what, where="--axis", remedy=error.remedy) from error
