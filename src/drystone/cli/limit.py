"""``drystone limit``: by how much does it stand?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import typer

from drystone.cli import limit_answer, limit_options, loading, options
from drystone.cli.limit_models import thickness, tolerance
from drystone.cli.limit_options import search_options, working
from drystone.cli.session import Prepared, prepare
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

limit = typer.Typer(
    help="By how much does it stand: largest tilt or load, least friction, thickness, joint size.",
    no_args_is_help=True,
)
limit.command()(thickness)
limit.command()(tolerance)


@limit.command()
def tilt(
    model: options.ModelArgument,
    axis: Annotated[
        str | None, typer.Option(help="Turned counter-clockwise about: x, y, -x, -y or X,Y,Z (x).")
    ] = None,
    polar: Annotated[
        int | None, typer.Option(help="Number of directions to lean towards, instead of an axis.")
    ] = None,
    upper: Annotated[float, typer.Option(help="Angle at which the search ends.")] = 180.0,
    supports: options.Supports = None,
    friction: options.Friction = None,
    density: options.Density = None,
    units: options.Units = None,
    gravity: options.Gravity = None,
    loads: loading.Loads = None,
    width: limit_options.Width = None,
    scan: limit_options.Scan = 6,
    cone: limit_options.Cone = "exact",
    equilibrium_only: limit_options.EquilibriumOnly = False,
    workers: limit_options.Workers = 1,
    html: options.Html = None,
    png: options.Png = None,
    as_json: options.Json = False,
) -> int:
    """The largest angle by which a model can be turned; --polar in all directions."""
    if axis is not None and polar is not None:
        raise InputError("--axis and --polar contradict each other", remedy="give one of them")
    if png is not None and polar is None:
        raise InputError("is a plot of a sweep", where="--png", remedy="add --polar 16")
    if html is not None and polar is not None:
        raise InputError("shows one fall", where="--html", remedy="give an --axis, not --polar")
    files = limit_answer.Files.checked(html, png)
    search = search_options(width, scan, cone, equilibrium_only)
    with Waiting() as waiting:
        from drystone import limits

        direction = _axis(axis)
        prepared = _prepared(model, waiting, supports, friction, density, units, gravity, loads)
        waiting.stage("solve", "searching")
        arguments: dict[str, Any] = {"upper": upper, "options": search, "progress": waiting}
        with working(workers) as executor:
            if polar is not None:
                sweep = limits.tilt_sweep(
                    prepared.assembly,
                    prepared.contacts,
                    polar,
                    prepared.load,
                    executor=executor,
                    **arguments,
                )
            else:
                found = limits.limit_tilt(
                    prepared.assembly,
                    prepared.contacts,
                    direction,
                    prepared.load,
                    executor=executor,
                    **arguments,
                )
    if polar is not None:
        return limit_answer.tell_sweep(sweep, model, prepared, files, waiting, as_json)
    return limit_answer.tell(found, model, prepared.notes, files, waiting, as_json)


@limit.command(name="friction")
def friction_(
    model: options.ModelArgument,
    upper: Annotated[
        float | None, typer.Option(help="Coefficient at which the search starts (--friction).")
    ] = None,
    scaled: Annotated[
        bool, typer.Option("--scaled", help="Search the share of each joint's own coefficient.")
    ] = False,
    supports: options.Supports = None,
    friction: options.Friction = None,
    density: options.Density = None,
    units: options.Units = None,
    gravity: options.Gravity = None,
    loads: loading.Loads = None,
    seismic: loading.Seismic = None,
    width: limit_options.Width = None,
    scan: limit_options.Scan = 6,
    cone: limit_options.Cone = "exact",
    equilibrium_only: limit_options.EquilibriumOnly = False,
    workers: limit_options.Workers = 1,
    html: options.Html = None,
    as_json: options.Json = False,
) -> int:
    """The least friction coefficient at which a model stands."""
    files = limit_answer.Files.checked(html, None)
    search = search_options(width, scan, cone, equilibrium_only)
    with Waiting() as waiting:
        from drystone import limits

        prepared = _prepared(
            model, waiting, supports, friction, density, units, gravity, loads, seismic
        )
        waiting.stage("solve", "searching")
        with working(workers) as executor:
            found = limits.limit_friction(
                prepared.assembly,
                prepared.contacts,
                prepared.load,
                upper=upper,
                scaled=scaled,
                options=search,
                executor=executor,
                progress=waiting,
            )
    return limit_answer.tell(found, model, prepared.notes, files, waiting, as_json)


@limit.command()
def load(
    model: options.ModelArgument,
    case: Annotated[
        str,
        typer.Argument(
            metavar="CASE",
            help="The load that grows: the name of a load case of the file, seismic:KX,KY, or "
            "BLOCK:FX,FY,FZ[@X,Y,Z] (also BLOCK:80kg, BLOCK:m=MX,MY,MZ).",
        ),
    ],
    upper: Annotated[float, typer.Option(help="Factor at which the search ends.")] = 1000.0,
    supports: options.Supports = None,
    friction: options.Friction = None,
    density: options.Density = None,
    units: options.Units = None,
    gravity: options.Gravity = None,
    loads: loading.Loads = None,
    seismic: loading.Seismic = None,
    width: limit_options.Width = None,
    scan: limit_options.Scan = 6,
    cone: limit_options.Cone = "exact",
    equilibrium_only: limit_options.EquilibriumOnly = False,
    workers: limit_options.Workers = 1,
    html: options.Html = None,
    as_json: options.Json = False,
) -> int:
    """The largest factor of a load on top of the weight and of --load."""
    files = limit_answer.Files.checked(html, None)
    search = search_options(width, scan, cone, equilibrium_only)
    with Waiting() as waiting:
        from drystone import limits

        prepared = _prepared(
            model, waiting, supports, friction, density, units, gravity, loads, seismic
        )
        live = loading.chosen_case(case, prepared.assembly, prepared.cases)
        waiting.stage("solve", "searching")
        with working(workers) as executor:
            found = limits.limit_load(
                prepared.assembly,
                prepared.contacts,
                live,
                prepared.load,
                upper=upper,
                options=search,
                executor=executor,
                progress=waiting,
            )
    notes = (*prepared.notes, *live.notes)
    return limit_answer.tell(found, model, notes, files, waiting, as_json)


@limit.command()
def shrink(
    model: options.ModelArgument,
    supports: options.Supports = None,
    friction: options.Friction = None,
    density: options.Density = None,
    units: options.Units = None,
    gravity: options.Gravity = None,
    loads: loading.Loads = None,
    seismic: loading.Seismic = None,
    width: limit_options.Width = None,
    scan: limit_options.Scan = 6,
    cone: limit_options.Cone = "exact",
    equilibrium_only: limit_options.EquilibriumOnly = False,
    workers: limit_options.Workers = 1,
    html: options.Html = None,
    as_json: options.Json = False,
) -> int:
    """The least share of the size of all joints; its inverse is a geometric safety factor."""
    files = limit_answer.Files.checked(html, None)
    search = search_options(width, scan, cone, equilibrium_only)
    with Waiting() as waiting:
        from drystone import limits

        prepared = _prepared(
            model, waiting, supports, friction, density, units, gravity, loads, seismic
        )
        waiting.stage("solve", "searching")
        with working(workers) as executor:
            found = limits.limit_shrink(
                prepared.assembly,
                prepared.contacts,
                prepared.load,
                options=search,
                executor=executor,
                progress=waiting,
            )
    return limit_answer.tell(found, model, prepared.notes, files, waiting, as_json)


def _prepared(
    model: str,
    waiting: Waiting,
    supports: str | None,
    friction: float | None,
    density: float | None,
    units: str | None,
    gravity: str | None,
    loads: Sequence[str] | None,
    seismic: str | None = None,
) -> Prepared:
    return prepare(
        model,
        waiting,
        supports=supports,
        friction=friction,
        density=density,
        units=units,
        gravity=gravity,
        loads=loads,
        seismic=seismic,
    )


def _axis(text: str | None) -> Any:
    from drystone.limits.limits import axis_vector

    given = "x" if text is None else text
    try:
        return axis_vector(options.vector(given, "--axis") if "," in given else given)
    except InputError as error:
        if error.where:
            raise
        raise InputError(error.what, where="--axis", remedy=error.remedy) from error
