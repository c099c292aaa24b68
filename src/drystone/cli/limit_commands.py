"""``drystone limit``: where the verdict changes; ``drystone push``: load against displacement."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli import kinds, loading
from drystone.cli.command import Argument, Option, command
from drystone.cli.model_input import Subject
from drystone.cli.options import LimitSearch, TimeLimit, vector
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Curves, Pictures

if TYPE_CHECKING:
    from drystone.answer import Answer
    from drystone.limits import Limit
    from drystone.model import Model


_SIDEWAYS = "seismic:1,0"


def _axis(text: str) -> Any:
    from drystone.limits.limits import axis_vector

    return axis_vector(vector(text, "0,1,0") if "," in text else text)


@command(
    "drystone limit tilt arch.json --axis y",
    "drystone limit tilt arch.json --polar 4 --png polar.png",
)
def tilt(
    *,
    axis: Annotated[
        Any,
        Option(
            "Turned counter-clockwise about: x, y, -x, -y or a vector (x).",
            kind=kinds.OptionKind("AXIS|X,Y,Z", _axis),
        ),
    ] = None,
    polar: Annotated[
        int | None, Option("Number of directions to lean towards, instead of an axis.")
    ] = None,
    upper: Annotated[float, Option("Angle at which the search ends (180).", expert=True)] = 180.0,
    subject: Subject,
    search: LimitSearch,
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The largest angle by which a model can be turned; --polar in all directions.

    The page shows both sides of the limit, in the weakest direction of --polar; the figure of
    --polar is a plot of all directions.
    """
    if axis is not None and polar is not None:
        raise InputError("--axis and --polar contradict each other", remedy="give one of them")
    from drystone import limits

    model = subject.prepared(waiting)
    pictures.require_through(model.assembly)
    with search.under_way(waiting) as common:
        if polar is None:
            about = _axis("x") if axis is None else axis
            found: Answer = limits.limit_tilt(model, about, upper=upper, **common)
        else:
            found = limits.tilt_sweep(model, polar, upper=upper, **common)
    return Told(found, notes=model.notes, files=partial(pictures.of, found))


@command(
    "drystone limit friction arch.json",
    "drystone limit friction arch.json --seismic 0.1 --html fall.html",
)
def friction(
    *,
    upper: Annotated[
        float | None,
        Option(
            "Coefficient at which the search starts (--friction).",
            kind=kinds.COEFFICIENT,
            expert=True,
        ),
    ] = None,
    scaled: Annotated[bool, Option("Search the share of each joint's own coefficient.")] = False,
    subject: Subject,
    seismic: loading.Seismic = None,
    search: LimitSearch,
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The least friction coefficient at which a model stands."""

    def find(model: Model, common: dict[str, Any]) -> Limit:
        from drystone.limits import limit_friction  # work is imported when there is some

        return limit_friction(model, upper=upper, scaled=scaled, **common)

    return _answer(subject, search, seismic, find, pictures, waiting)


@command(
    "drystone limit load arch.json voussoir-10:1kN",
    "drystone limit load arch.json seismic:1,0 --html fall.html",
)
def load(
    *,
    subject: Subject,
    live: Annotated[
        str,
        Argument(
            "CASE",
            "The load that grows: a load case of the file by name, seismic:KX,KY, or "
            "BLOCK:WHAT[@X,Y,Z] as for --load.",
        ),
    ],
    upper: Annotated[
        float, Option("Factor at which the search ends (1000).", kind=kinds.POSITIVE)
    ] = 1000.0,
    seismic: loading.Seismic = None,
    search: LimitSearch,
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The largest factor of a load on top of the weight and of --load."""
    notes: list[str] = []

    def find(model: Model, common: dict[str, Any]) -> Limit:
        from drystone.limits import limit_load  # as above

        growing = loading.chosen_case(live, model.assembly, model.cases, subject.gravity)
        notes.extend(growing.notes)
        return limit_load(model, growing, upper=upper, **common)

    return _answer(subject, search, seismic, find, pictures, waiting, notes)


@command(
    "drystone limit shrink arch.json",
    "drystone limit shrink arch.json --seismic 0.05 --html fall.html",
)
def shrink(
    *,
    subject: Subject,
    seismic: loading.Seismic = None,
    search: LimitSearch,
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The least share of the size of all joints; its inverse is a geometric safety factor."""

    def find(model: Model, common: dict[str, Any]) -> Limit:
        from drystone.limits import limit_shrink  # as above

        return limit_shrink(model, **common)

    return _answer(subject, search, seismic, find, pictures, waiting)


def _answer(
    subject: Subject,
    search: LimitSearch,
    seismic: str | None,
    find: Callable[[Model, dict[str, Any]], Limit],
    pictures: Pictures,
    waiting: Waiting,
    notes: list[str] | None = None,
) -> Told:
    """Prepare the model and find the limit; notes that ``find`` adds are printed."""
    model = subject.prepared(waiting, seismic=seismic)
    pictures.require_through(model.assembly)
    with search.under_way(waiting) as common:
        found = find(model, common)
    told = (*model.notes, *(notes or ()))
    return Told(found, notes=told, files=partial(pictures.of, found))


@command(
    "drystone push arch.json --png push.png --html push.html",
    "drystone push arch.json seismic:0,1 --to 0.01 --curve push.csv",
)
def push(
    *,
    subject: Subject,
    live: Annotated[
        str | None,
        Argument(
            "CASE",
            "The load that grows: a load case of the file by name, seismic:KX,KY, or "
            "BLOCK:WHAT[@X,Y,Z] as for --load (seismic:1,0).",
        ),
    ] = None,
    to: Annotated[
        float | None,
        Option("Displacement at which it ends, m (the mean size of a block).", kind=kinds.POSITIVE),
    ] = None,
    lose_friction: Annotated[
        bool, Option("Let all friction decay to zero instead of a load that grows.")
    ] = False,
    pace: Annotated[
        float,
        Option(
            "Length of the steps, divided by the default (1).", kind=kinds.POSITIVE, expert=True
        ),
    ] = 1.0,
    time_limit: TimeLimit = None,
    wanted: Curves,
    waiting: Waiting,
) -> Told:
    """Load against displacement, until the load is zero again: the displacement capacity.

    Exit code 0: that displacement, or the fall, was found. 1: it was not reached, or the model does
    not stand at the beginning.
    """
    if lose_friction and (live is not None or to is not None):
        raise InputError(
            "--lose-friction and a load that grows contradict each other",
            remedy="leave out CASE and --to",
        )
    from drystone.settlement import SettlementOptions, reduce_friction
    from drystone.settlement import push as pushed

    model = subject.prepared(waiting)
    wanted.require_through(model.assembly)
    options = SettlementOptions(pace=pace)
    notes = list(model.notes)
    with waiting.keywords(time_limit) as common:
        waiting.stage("solve", "pushing")
        if lose_friction:
            found = reduce_friction(model, options=options, **common)
        else:
            chosen = _SIDEWAYS if live is None else live
            case = loading.chosen_case(chosen, model.assembly, model.cases, subject.gravity)
            notes += case.notes
            found = pushed(model, case, to=to, options=options, **common)
    return Told(found, notes=notes, files=partial(wanted.with_curve, found))
