"""Follow the blocks of one model, or of many, until they rest or fall."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from os import PathLike
from typing import Any, Unpack

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.base.display import shortened
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, How, supported_model
from drystone.model import Model
from drystone.results import Residuals
from drystone.settlement.faces.corners import Carrier
from drystone.settlement.faces.meeting import Apart, faces_apart
from drystone.settlement.follow import Follower
from drystone.settlement.loading_order import earlier_loads
from drystone.settlement.outcomes import outcome_of
from drystone.settlement.path import (
    STIFFER,
    carriers_of,
    follower_of,
    path_of,
    support_motion,
    too_soft,
    with_outcome,
)
from drystone.settlement.settlement_types import (
    Outcome,
    Settlement,
    SettlementOptions,
    SettlementPath,
)
from drystone.settlement.together import tracks_of

SMALL, AT_ONCE = 8, 32
"""Free blocks up to which models are computed together, and models at once: from timings."""


@checked_call
def settle(
    given: Given,
    motion: Mapping[int | str, Any] | None = None,
    *,
    options: SettlementOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Settlement:
    """Follow the blocks step by step until they rest or fall.

    Contacts are stiff springs with path-dependent Coulomb friction. Translations and rotations are
    finite: corners and faces move with their blocks. Wrenches of the load keep their direction and
    act about the moved centroids. Besides the interfaces of the model, faces act that blocks meet
    while they move: those that are parallel to 2 degrees and face each other at up to ``fall`` of a
    block's size.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    motion
        Motion of supports after rest under the load: per fixed block its translation [m] (3,),
        or translation and rotation [m, rad] (6,) about its centroid; world axes. It is added to the
        motion in the load (:meth:`drystone.LoadCase.settlement`).
    options

    Raises
    ------
    InputError
        A block that is not fixed is to be moved, or what was given cannot be made into a model.

    Examples
    --------
    A wedge that no uniform stiffness holds slides by half a percent of its size, turns and jams:

    >>> import drystone
    >>> from drystone.models import wedge
    >>> from drystone.settlement import SettlementOptions
    >>> tilted = drystone.LoadCase.tilt(wedge("b"), (1.0, 0.0, 0.0), 50.0)
    >>> model = drystone.Model.of(wedge("b"), friction=0.84, load=tilted)
    >>> settled = drystone.settle(model, options=SettlementOptions(carrier="moving"))
    >>> settled.outcome, round(settled.travel, 3)
    (<Outcome.RESTS: 'comes to rest'>, 0.005)
    """
    chosen = SettlementOptions.of(options)
    model = supported_model(given, **how)
    model.require_dry("settlement", "what a joint still carries after it has moved is not known")
    clock = Clock(time_limit_s, stop)
    moving = support_motion(model, motion)
    model = model.with_load(replace(model.load, motion=None))
    if not len(model.assembly.free):
        return _nothing_free(model, chosen, clock.elapsed_s)
    carriers = carriers_of(model, chosen)
    apart = faces_apart(model, chosen.fall)
    task = partial(path_of, model, apart, motion=moving, chosen=chosen, clock=clock)
    paths: tuple[SettlementPath, ...]
    if executor is None or len(carriers) == 1:
        paths = ()
        for one in carriers:
            paths += (task(one, progress=progress),)
            if paths[-1].outcome is Outcome.UNKNOWN:
                break  # then the outcome is unknown, whatever the other one does
    else:
        with WorkerPool(executor) as pool:
            paths = tuple(pool.answers(task, carriers, clock.late))
        # where it was ended early: the beginning of the others
        paths += tuple(task(one, progress=progress) for one in carriers[len(paths) :])
    return _told(paths, chosen, clock, clock.elapsed_s)


@checked_call
def settle_many(
    models: Iterable[Given],
    *,
    options: SettlementOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> tuple[Settlement, ...]:
    """:func:`settle` of many models; small ones with equal numbers of corners are computed at once.

    64 runs of one block are four times as fast as one after another.

    Parameters
    ----------
    models
        As :func:`settle` takes them, in order.
    options
        Of every settlement.

    Raises
    ------
    InputError
        As for :func:`settle`, or ``models`` is a single model.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import wedge
    >>> from drystone.settlement import settle_many
    >>> block = drystone.Model.of(wedge("b"), friction=0.84)
    >>> tilts = [drystone.LoadCase.tilt(block.assembly, (1.0, 0.0, 0.0), at) for at in (40, 70)]
    >>> [one.outcome.value for one in settle_many([block.with_load(tilt) for tilt in tilts])]
    ['comes to rest', 'falls']
    """
    one = isinstance(models, str | bytes | PathLike | Assembly | Model)
    if one or not isinstance(models, Iterable):
        said = f"the models are {shortened(repr(models), 60)}"
        raise InputError(said, remedy="give a list of models, such as [model]")
    chosen = SettlementOptions.of(options)
    clock = Clock(time_limit_s, stop)
    ready = [_ready(one, how) for one in models]
    groups = [ready[at : at + AT_ONCE] for at in range(0, len(ready), AT_ONCE)]
    found: list[Settlement] = []
    with WorkerPool(executor) as pool:
        for some in pool.answers(partial(_settled, chosen, clock), groups):
            found += some
            if progress is not None:
                progress("models", len(found), len(ready))
    return tuple(found)


def _ready(given: Given, how: How) -> tuple[Model, Floats | None]:
    """A model without the motion of its supports, and that motion."""
    model = supported_model(given, **how)
    model.require_dry("settlement", "what a joint still carries after it has moved is not known")
    return model.with_load(replace(model.load, motion=None)), support_motion(model, None)


def _settled(
    chosen: SettlementOptions, clock: Clock, models: Sequence[tuple[Model, Floats | None]]
) -> list[Settlement]:
    """The settlements of some models; runs of one shape are computed together."""
    began = clock.elapsed_s
    runs: list[tuple[int, Carrier, Apart, Follower]] = []
    paths: dict[tuple[int, Carrier], SettlementPath] = {}
    for number, (model, motion) in enumerate(models):
        if not len(model.assembly.free):
            continue
        apart = faces_apart(model, chosen.fall)
        for carrier in carriers_of(model, chosen):
            if motion is None and len(model.assembly.free) <= SMALL:
                follower = follower_of(model, apart, carrier, chosen, clock, chosen.overlap)
                runs.append((number, carrier, apart, follower))
            else:
                paths[number, carrier] = path_of(model, apart, carrier, motion, chosen, clock)
    tracks = tracks_of(
        [(one, one.whole_run(None, earlier_loads(one.bodies, chosen.loading))) for *_, one in runs]
    )
    for (number, carrier, apart, one), track in zip(runs, tracks, strict=True):
        model = models[number][0]
        if too_soft(track, chosen.overlap):
            stiffer = STIFFER * chosen.overlap
            path = path_of(model, apart, carrier, None, chosen, clock, overlap=stiffer)
        else:
            path = with_outcome(model, apart, carrier, False, chosen, clock, one.bodies, track)
        paths[number, carrier] = path
    each = (clock.elapsed_s - began) / max(len(models), 1)
    found = []
    for number, (model, _) in enumerate(models):
        mine = tuple(paths[number, one] for one in Carrier if (number, one) in paths)
        found.append(
            _told(mine, chosen, clock, each) if mine else _nothing_free(model, chosen, each)
        )
    return found


def _told(
    paths: tuple[SettlementPath, ...], chosen: SettlementOptions, clock: Clock, spent_s: float
) -> Settlement:
    outcome, message = outcome_of(paths, clock)
    return Settlement(outcome, message, paths, clock.reason, chosen, {"solve": spent_s})


def _nothing_free(model: Model, chosen: SettlementOptions, spent_s: float) -> Settlement:
    """Every block is a support."""
    contacts, count = model.contacts, len(model.assembly)
    corners = contacts.corner_count
    path = SettlementPath(
        Carrier.MOVING,
        Outcome.RESTS,
        model,
        np.zeros((1, count, 6)),
        np.zeros(count),
        np.zeros((corners, 3)),
        contacts.point,
        contacts.frame[contacts.interface],
        np.zeros(corners),
        Residuals(),
        0.0,
        0,
        0,
    )
    said = {"solve": spent_s}
    return Settlement(Outcome.RESTS, "every block is fixed", (path,), "", chosen, said)


__all__ = ["settle", "settle_many"]
