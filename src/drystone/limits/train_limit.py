"""Trains that move over a bridge: the search for the largest load factor at every place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Unpack

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.base.settings import Clock, checked_call
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, LongHow, supported_model
from drystone.limits.crossing import Crossing, Known, PlacedTrain, factor_of
from drystone.limits.limit_types import LimitOptions, verdict
from drystone.limits.limits import limit_load
from drystone.limits.train_answer import TrainEnvelope
from drystone.loads import Fill, Train
from drystone.loads.fill import Tops
from drystone.model import Model
from drystone.results import Verdict
from drystone.stability.problem import Problem


@checked_call
def limit_train(
    given: Given,
    *,
    train: Train | None = None,
    fill: Fill | None = None,
    steps: int = 50,
    options: LimitOptions | None = None,
    **how: Unpack[LongHow],
) -> TrainEnvelope:
    """The largest load factor of a train at every place on a bridge.

    One conic program at each place gives the largest factor that forces balance; at the worst place
    the full verdict is searched as well, and asked at all others. Where a mechanism of one place
    ends the train elsewhere at less than the least factor, that place is tried as well, until this
    changes by less than 0.1 %. A line load acts on the stretches where it is adverse. Fill is added
    to the load, spreads the axles, and resists what moves into it. A train that is not symmetric
    moves both ways, and the lesser factor counts.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    train
        Of the library: ``axle`` (1 kN), ``lm1``, ``lm1-axle``, ``lm2``, ``lm71``, ``bogie``; or a
        TOML file (axle).
    fill
        Such as ``cover=0.3m,weight=20kN/m3,spread=2:1,k=0.3,passive=1``; that of the load, or
        none, when left out: then axles do not spread.
    steps
        Places of its middle, from where its first axle comes to where its last one leaves. Each is
        a conic program: more take longer, and may find other mechanisms.
    options
        Of the limit at the worst place.

    Raises
    ------
    InputError
        The train is longer than the bridge, or the load has fill already.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import segmental_bridge
    >>> model = drystone.Model.of(segmental_bridge(voussoirs=12), friction=0.6)
    >>> found = limit_train(model, fill=Fill(cover=0.3, weight=2e4), steps=5)
    >>> found.places[found.worst].round(2)
    np.float64(1.51)
    """
    clock = Clock.of(how)
    model = supported_model(given, **how)
    carried = Train.named("axle") if train is None else train
    known = model.load.fills
    lost = not known and any(one.kind.endswith("fill") for one in model.load.masses)
    if lost or len(known) + (fill is not None) > 1:
        why = "the load has fill already, of a file, twice or times a negative factor"
        remedy = "give one fill, with --load or --fill; --case weight leaves out what a file has"
        raise InputError(why, where="load", remedy=remedy)
    added, fill = fill is not None, known[0] if known else fill
    if steps < 1:
        raise InputError(f"{steps} places", where="steps", remedy="give one or more")
    tops = Tops.of(model.assembly, fill or Fill(0.0, 0.0, spread=0.0))
    low, high = tops.road.ends
    if carried.length > high - low:
        raise InputError(
            f"'{carried.name}' is {carried.length:g} m long, the bridge {high - low:.3g} m",
            where="train",
            remedy="take a shorter one, or the axles of it that fit",
        )
    if added:
        model = model.with_load(model.load + tops.load)
    model.load.refuse_turned_fill()
    chosen = LimitOptions.of(options)
    crossing = Crossing(Problem.build(model), tops, carried, chosen)
    share = (np.arange(steps) + 0.5) / steps
    reach = 0.5 * carried.length
    places = low - reach + share * (high - low + 2.0 * reach)
    found = _placed(crossing, places.tolist(), clock)
    late = clock.late()
    envelope = TrainEnvelope(
        np.array([one.at.place for one in found]),
        np.array([one.found.factor for one in found]),
        None,
        steps,
        crossing,
        tuple(found),
        chosen,
        stopped=clock.reason,
    )
    if late or not found or len(crossing.resisted):
        return envelope
    if envelope.falls_alone or not np.isfinite(envelope.factors[envelope.worst]):
        return envelope
    return _with_verdict(envelope, clock)


def _with_verdict(envelope: TrainEnvelope, clock: Clock) -> TrainEnvelope:
    """With the limit of the verdict at the place where that is least.

    It is searched at the worst place by equilibrium, then where it does not stand under what was
    found so far.
    """
    placed, model, at = envelope._placed, envelope.model, envelope.worst
    upper, others = max(2.0 * float(envelope.factors[at]), 1e-3), list(range(len(placed)))
    with WorkerPool(clock.workers) as pool:
        while True:
            limit = limit_load(
                model, placed[at].live, upper=upper, options=envelope.options, stop=clock.late
            )
            envelope = replace(envelope, limit=limit, _governs=at, stopped=clock.reason)
            upper = 0.0 if limit.rest is None else limit.rest.stands or 0.0
            others.remove(at)
            under = (model.with_load(model.load + upper * placed[i].live) for i in others)
            each = list(pool.answers(_verdict, under, clock.late)) if upper else []
            said = dict(zip(others, each, strict=False))
            unknown = (i for i, one in said.items() if one is Verdict.UNDECIDED)
            envelope = replace(envelope, _undecided=tuple(unknown), stopped=clock.reason)
            falls = [i for i, one in said.items() if one is Verdict.UNSTABLE]
            if not falls or clock.late():
                return envelope
            others = [i for i, one in said.items() if one is not Verdict.STABLE]
            at = min(falls, key=lambda i: factor_of(placed[i]))


def _verdict(model: Model) -> Verdict:
    return verdict(model).verdict


def _placed(
    crossing: Crossing, places: list[float], clock: Clock, fine: float = 1e-3
) -> list[PlacedTrain]:
    """The train at places [m], and at more where it carries less, from left to right.

    ``fine``: share of the least factor by which more places must lower it to go on.
    """
    found: dict[float, PlacedTrain] = {}
    begun: set[tuple[float, bytes]] = set()  # a mechanism's own rounding would ask for ever
    asked = list(zip(places, crossing.lines(len(places)), strict=True))
    with WorkerPool(clock.workers) as pool:
        least = np.inf
        while asked:
            for one in pool.answers(crossing, asked, clock.late):
                found[one.at.place] = min(one, found.get(one.at.place, one), key=factor_of)
                clock.tell("places", min(len(found), len(places)), len(places))
            every = list(found.values())
            if clock.late() or not 0.0 < _least(every) < np.inf:
                break
            known = crossing.known(every)
            sooner = {(at, line.tobytes()): (at, [line])
                      for at, line in _sooner(known, every, fine)}  # fmt: skip
            asked = [one for key, one in sooner.items() if key not in begun]
            begun |= sooner.keys()
            if not asked and _least(every) < (1.0 - fine) * least:
                least = _least(every)
                asked = _lower(crossing, known, least, fine)
    return sorted(found.values(), key=lambda one: one.at.place)


def _least(found: Sequence[PlacedTrain]) -> float:
    return min((one.factor for one in found), default=np.inf)


def _sooner(known: Known, found: Sequence[PlacedTrain], fine: float) -> list[tuple[float, Floats]]:
    """Places [m] known at which mechanisms of others end the train sooner, and by which line."""
    places = np.array([one.at.place for one in found])
    factor, lines = known(places)
    each = zip(found, factor.tolist(), lines, strict=True)
    return [(one.at.place, line) for one, least, line in each
            if least < (1.0 - fine) * one.factor]  # fmt: skip


def _lower(
    crossing: Crossing, known: Known, least: float, fine: float
) -> list[tuple[float, list[Floats]]]:
    """Places [m] where mechanisms known of others end the train below the least factor.

    The worst one of each stretch of such places, with the line load by which it is.
    """
    (low, high), reach = crossing.tops.road.ends, 0.5 * crossing.train.length
    places = np.linspace(low - reach, high + reach, 401)  # 801 lower 12 factors by 0.02 % at most
    factor, last = known(places)[0], len(places) - 1
    room = 1.0 + 10.0 * fine  # it may be lower between two: a beam's by 0.6 %
    runs = np.split(np.arange(last + 1), np.flatnonzero(np.diff(factor < room * least)) + 1)
    near = [
        _lowest(known, *places[[max(at - 1, 0), min(at + 1, last)]])
        for at in (run[factor[run].argmin()] for run in runs)
        if factor[at] < room * least
    ]
    new = [(at, line) for at, lower, line in near if lower < (1.0 - fine) * least]
    each = zip(new, crossing.lines(len(new)), strict=True)
    return [(at, [*more, line]) for (at, line), more in each]


def _lowest(known: Known, low: float, high: float) -> tuple[float, float, Floats]:
    """The place [m] of the least factor between two, to a 128th of what is between them.

    With the factor, and the stretches of the line load by which it is.
    """
    for _ in range(2):
        places = np.linspace(low, high, 17)
        factor, lines = known(places)
        at = int(factor.argmin())
        low, high = places[[max(at - 1, 0), min(at + 1, 16)]]
    return float(places[at]), float(factor[at]), lines[at]
