"""``drystone limit``: where the verdict changes; ``drystone push``: load against displacement."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli.command import command
from drystone.cli.model_input import OneFile, Subject
from drystone.cli.offered import Analysis, Argument, Of, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Curves, Pictures

if TYPE_CHECKING:
    from drystone.answer import Answer
    from drystone.model import Model

_GROWS = (
    "The load that grows: a load case of the file by name, seismic:KX,KY, or BLOCK:WHAT[@X,Y,Z] as "
    "for --load"
)


def _prepared(subject: Subject, files: Pictures, waiting: Waiting) -> Model:
    model = subject.prepared(waiting)
    files.require_through(model.assembly)
    return model


def _told(found: Answer, model: Model, files: Pictures, notes: tuple[str, ...] = ()) -> Told:
    return Told(found, notes=(*model.notes, *notes), files=partial(files.of, found))


@command(
    "drystone limit tilt arch.json --axis y",
    "drystone limit tilt arch.json --polar 4 --png polar.png",
)
def tilt(
    *,
    polar: Annotated[
        int | None, Option("Number of directions to lean towards, instead of an axis.")
    ] = None,
    subject: Subject,
    asked: Annotated[
        Analysis,
        Of("drystone.limits.limit_tilt", shown=("axis",), metavars={"axis": "AXIS|X,Y,Z"}),
    ],
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The largest angle by which a model can be turned; --polar in all directions.

    The page shows both sides of the limit, in the weakest direction of --polar; the figure of
    --polar is a plot of all directions.
    """
    if polar is not None:
        if "axis" in asked.given:
            raise InputError("--axis and --polar contradict each other", remedy="give one of them")
        from drystone.limits import tilt_sweep

        asked = asked.instead(tilt_sweep, directions=polar)
    model = _prepared(subject, pictures, waiting)
    return _told(asked.of(waiting, model), model, pictures)


@command(
    "drystone limit friction arch.json",
    "drystone limit friction arch.json --seismic 0.1 --html fall.html",
)
def friction(
    *,
    subject: Subject,
    asked: Annotated[Analysis, Of("drystone.limits.limit_friction", shown=("scaled",))],
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The least friction coefficient at which a model stands."""
    model = _prepared(subject, pictures, waiting)
    return _told(asked.of(waiting, model), model, pictures)


@command(
    "drystone limit load arch.json voussoir-10:1kN",
    "drystone limit load arch.json seismic:1,0 --html fall.html",
)
def load(
    *,
    subject: Subject,
    live: Annotated[str, Argument("CASE", f"{_GROWS}.")],
    asked: Annotated[Analysis, Of("drystone.limits.limit_load", shown=("upper",))],
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The largest factor of a load on top of the weight and of --load."""
    model = _prepared(subject, pictures, waiting)
    grows = subject.case_of(live, model)
    return _told(asked.of(waiting, model, grows), model, pictures, grows.notes)


@command(
    "drystone limit shrink arch.json",
    "drystone limit shrink arch.json --seismic 0.05 --html fall.html",
)
def shrink(
    *,
    subject: Subject,
    asked: Annotated[Analysis, Of("drystone.limits.limit_shrink")],
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The least share of the size of all joints; its inverse is a geometric safety factor."""
    model = _prepared(subject, pictures, waiting)
    return _told(asked.of(waiting, model), model, pictures)


@command(
    "drystone limit thrust arch.json springer-right",
    "drystone limit thrust arch.json springer-left --direction x --html thrust.html",
)
def thrust(
    *,
    subject: OneFile,
    block: Annotated[str, Argument("BLOCK", "On which block, usually a support.")],
    asked: Annotated[
        Analysis,
        Of(
            "drystone.limits.thrust_bounds",
            shown=("direction",),
            metavars={"direction": "AXIS|X,Y,Z"},
        ),
    ],
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The least and the largest thrust on a block, by equilibrium alone.

    The page shows the forces at both. Exit code 1: no forces balance the loads.
    """
    model = _prepared(subject, pictures, waiting)
    return _told(asked.of(waiting, model, block), model, pictures)


@command(
    "drystone push arch.json --png push.png --html push.html",
    "drystone push arch.json seismic:0,1 --to 0.01 --curve push.csv",
)
def push(
    *,
    subject: OneFile,
    live: Annotated[str | None, Argument("CASE", f"{_GROWS} (seismic:1,0).")] = None,
    lose_friction: Annotated[
        bool, Option("Let all friction decay to zero instead of a load that grows.")
    ] = False,
    asked: Annotated[
        Analysis,
        Of("drystone.settlement.push", ("to", "options.pace", "time_limit_s"), shown=("to",)),
    ],
    wanted: Curves,
    waiting: Waiting,
) -> Told:
    """Load against displacement, until the load is zero again: the displacement capacity.

    Exit code 0: that displacement, or the fall, was found. 1: it was not reached, or the model does
    not stand at the beginning.
    """
    if lose_friction and (live is not None or "to" in asked.given):
        raise InputError(
            "--lose-friction and a load that grows contradict each other",
            remedy="leave out CASE and --to",
        )
    model = _prepared(subject, wanted, waiting)
    subjects: list[Any] = [model]
    notes: tuple[str, ...] = ()
    if lose_friction:
        from drystone.settlement import reduce_friction

        asked = asked.instead(reduce_friction)
    else:
        case = subject.case_of("seismic:1,0" if live is None else live, model)
        subjects.append(case)
        notes = case.notes
    found = asked.of(waiting, *subjects, doing="pushing")
    return Told(found, notes=(*model.notes, *notes), files=partial(wanted.with_curve, found))
