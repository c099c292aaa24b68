"""The limit of rest, searched inside the limit of equilibrium."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from drystone.base.errors import InputError
from drystone.base.settings import Clock, Stop, Stopped
from drystone.base.workers import WorkerPool
from drystone.limits.bounds import bisected_bound, rbe
from drystone.limits.limit_answer import Limit
from drystone.limits.limit_search import VerdictSearch, Width, evaluate, in_line
from drystone.limits.limit_types import (
    SEARCHED,
    STANDS,
    STANDS_OR_NOT,
    Bracket,
    Check,
    Family,
    FoundBracket,
    LimitOptions,
    every_stiffness,
    one_stiffness,
    verdict,
)
from drystone.mechanics.statics import build_statics
from drystone.results import Result, Verdict

COARSE = 1.0 / 96.0
"""Default width for larger models, as a share of the limit. A finer bracket would depend more on
the iteration than on the structure."""

FOLLOWED = 1e-3
"""Default width where blocks are followed by finite steps, as a share of the limit: three digits.
The limit itself depends on the joints by more."""

_CLOSING = 2.0
"""Default widths between a value that stands and a proven fall at which these are the answer for
larger models. Between them blocks would be followed very near to the limit of equilibrium, where it
takes longest: 50 s for a cross vault of 188 blocks."""

MANY = 50_000
"""Corners from which the start and a value near it are tried first. Measured: 7 s for a wall of
119,000, of which nothing is known before the convex program ends, after 63 s; a wall of 19,000 is
done in 5 s. To go on to the first value that does not stand took 27 s more."""

_FIRST = 2.5e-3
"""Share of the range that this value is from the start. Chosen."""

_LEAST = 1e-15
"""Width of a bracket by the range of the search, however small the limit is."""


@dataclass(frozen=True, eq=False)
class Means:
    """How a limit is searched.

    Attributes
    ----------
    check
        Gives the verdict; when left out, that of drystone is asked where uniform stiffness decides.
    options
    clock
        The time since the start, a request to stop, and the workers.
    """

    check: Check | None
    options: LimitOptions
    clock: Clock

    @property
    def asks(self) -> bool:
        """Whether uniform stiffness is asked, and not equilibrium only or another check."""
        return self.check is None and not self.options.equilibrium_only

    def tell(self, stage: str, done: int) -> None:
        """Report one of three steps."""
        self.clock.tell(stage, done, 3)


def bisected(
    family: Family,
    start: float,
    end: float,
    width: float,
    means: Means,
    found_by: Callable[..., Bracket] = bisected_bound,
    first: VerdictSearch | None = None,
) -> Limit:
    """A limit whose convex bound is found by bisection, or otherwise; ``width`` is the default.

    ``first`` as in :func:`searched`.
    """
    chosen = width if means.options.width is None else means.options.width

    def bound(stop: Stop) -> tuple[Bracket, float]:
        cone = means.options.cone
        return found_by(family, start, end, width=chosen, cone=cone, stop=stop), chosen

    return searched(family, start, end, bound, means, first=first)


def resting(family: Family, means: Means) -> VerdictSearch:
    """A search by uniform stiffness."""
    late = means.clock.late
    ask = partial(one_stiffness, stop=late)
    return VerdictSearch(family, ask, meaning=STANDS_OR_NOT, stop=late, starts={})


def rests_up_to(
    first: VerdictSearch, start: float, means: Means, last: float
) -> Mapping[float, Result]:
    """Rest states of a scan up to a value."""
    with WorkerPool(means.clock.workers) as pool:
        first.executor = pool.executor
        first.run(start, last, width=Width(np.inf), scan=means.options.scan)
    return {value: result for value, result in first.results.items() if result.stable}


def searched(
    family: Family,
    start: float,
    end: float,
    bound: Callable[[Stop], tuple[Bracket, float]],
    means: Means,
    share: float | None = None,
    first: VerdictSearch | None = None,
) -> Limit:
    """The convex bound and its width, then the limit of the full verdict inside it.

    ``share``: of the limit, which is the default width. ``first``: see :func:`resting`.

    Raises
    ------
    InputError
        No block is free, or no free block is loaded.
    """
    _refuse_nothing_to_do(family, start)
    began = time.perf_counter()
    first = resting(family, means) if first is None else first
    found: Mapping[str, FoundBracket] = {}
    if means.asks and family(start).contacts.corner_count > MANY:
        means.tell("what stands near the start", 0)
        with suppress(Stopped):
            first.evaluate([start, start + _FIRST * (end - start)])
    means.tell("limit of equilibrium", 0)
    late = means.clock.late
    outer, least = (Bracket(), 0.0) if late() else bound(late)  # to begin takes long
    between = time.perf_counter()
    if first.results:  # in case that time is up
        near = first.so_far(start)
        sides = replace(near.bracket, falls=outer.falls, falling=outer.falling)
        held = tuple(one for one in near.evaluations if STANDS[one.verdict])
        found = {"rest": FoundBracket(sides, (), held)}
    if not means.options.equilibrium_only and not means.clock.late():
        means.tell("limit of rest", 1)
        width = Width(least)
        if means.options.width is None and share is not None:
            width = Width(_LEAST * abs(end - start), share)
        last, known = outer.stands, outer
        if last is None and outer.falls != start:  # the program leaves the start open
            at = (means.check or partial(verdict, stop=means.clock.late))(family(start))
            last = end if STANDS[at.verdict] else None
            known = Bracket(falls=start if at.falls else None, falling=at)
        found = {"rest": FoundBracket(known, (), ())}
        if last is not None:
            far, within = abs(last - start), outer
            first.results = {v: r for v, r in first.results.items() if abs(v - start) <= far}
            own, falls = means.check, outer.falls
            if own is not None and falls is not None and STANDS[own(family(falls)).verdict]:
                last, within = end, Bracket()  # it allows more than the cone of the options
            found = _inside(family, (start, last), within, width, means, first)
    means.tell("done", 3)
    rest = found.get("rest")
    if rest is not None and rest.bracket.falls == start and outer.stands is not None:
        at = rbe(means.options.cone, means.clock.late, family(start))
        if at.falls:  # forces balance it farther on only: no limit from the start
            outer = Bracket(falls=start, falling=at)
    tried = {one.value: one for each in found.values() for one in each.evaluations}
    return Limit(
        family.quantity,
        start,
        end,
        outer,
        **{name: each.bracket for name, each in found.items()},
        islands=() if rest is None else rest.islands,
        evaluations=tuple(tried[value] for value in sorted(tried)),
        time_s={"equilibrium": between - began, "rest": time.perf_counter() - between},
        stopped=means.clock.reason,
        options=means.options,
    )


def stands_up_to(family: Family, end: float, means: Means, rest: Result | None) -> bool:
    """Whether what stands at 0 does so up to ``end``, as far as a scan tells.

    ``rest``: of uniform stiffness at 0.
    """
    late, known = means.clock.late, {} if rest is None else {0.0: rest}
    for value in np.linspace(0.0, end, means.options.scan + 1)[1:-1].tolist():
        start = in_line(known, value)
        known[value] = evaluate(family, partial(one_stiffness, stop=late), (value, start))
        if known[value].stable:
            continue
        if not evaluate(family, partial(verdict, stop=late), (value, start)).stable:
            return False
    return evaluate(family, partial(verdict, stop=late), (end, in_line(known, end))).stable


def _inside(
    family: Family,
    span: tuple[float, float],
    outer: Bracket,
    width: Width,
    means: Means,
    first: VerdictSearch,
) -> Mapping[str, FoundBracket]:
    """The brackets ``rest``, ``uniform`` and, if asked for, ``robust``.

    Uniform stiffness is fast, so it is scanned and bisected first. The verdict is asked on both
    sides of its limit, and beyond them only where these do not close the bracket.
    """
    (start, last), options, late = span, means.options, means.clock.late

    def search(
        check: Callable[..., Result],
        meaning: Mapping[Verdict, bool | None] = STANDS,
        starts: Mapping[float, Result] | None = None,
    ) -> VerdictSearch:
        return VerdictSearch(family, partial(check, stop=late), None, meaning, late, starts)

    if means.check is not None:
        with WorkerPool(means.clock.workers) as pool:
            other = VerdictSearch(family, means.check, pool.executor, stop=late)
            return {"rest": other.run(start, last, width=width, scan=options.scan, beyond=outer)}
    closing = 0.0
    if options.width is None and family(start).contacts.corner_count > SEARCHED:
        width = Width(width.least, max(width.share, COARSE))
        closing = _CLOSING
    with WorkerPool(means.clock.workers) as pool:
        first.executor = pool.executor
        uniform = first.run(start, last, width=width, scan=options.scan, beyond=outer)
    if options.width is None:
        width = Width(width.least, max(width.share, FOLLOWED))
    means.tell("verdict where stiffness decides", 2)
    edge, falls = uniform.bracket.stands, uniform.bracket.falls
    near = start if edge is None else edge
    far = last if edge is None or falls in (None, outer.falls) else falls
    full = search(verdict, starts=first.results)
    rest = full.around(near, far, span, width=width, beyond=outer, closing=closing)
    if late() and rest.bracket.stands is None:  # what uniform stiffness holds stands
        held = uniform.bracket
        known = replace(rest.bracket, stands=held.stands, standing=held.standing)
        rest = replace(rest, bracket=known)
    reached = abs((start if rest.bracket.stands is None else rest.bracket.stands) - start)
    beyond = [run for run in uniform.islands if min(abs(end - start) for end in run) > reached]
    islands = tuple(run for run in beyond if _stands_again(full, run))
    rest = replace(rest, islands=islands, evaluations=full.evaluations())
    settled = rest.bracket.standing is None or rest.bracket.standing.settlement is not None
    if not settled and edge is not None and reached > abs(edge - start):
        # a quick level missed that uniform stiffness holds it there
        uniform = replace(uniform, bracket=rest.bracket)
    found = {"uniform": uniform, "rest": rest}  # where both were asked the verdict is told
    if options.robust and rest.bracket.stands is not None:
        inner = min(near, rest.bracket.stands, key=lambda value: abs(value - start))
        every = search(every_stiffness, STANDS_OR_NOT, full.results | first.results)
        outside = replace(rest.bracket, standing=None)
        found["robust"] = every.around(
            inner, rest.bracket.stands, (start, rest.bracket.stands), width=width, beyond=outside
        )
    return found


def _stands_again(full: VerdictSearch, run: tuple[float, float]) -> bool:
    """Whether the verdict is that it stands at both ends of a run of uniform stiffness."""
    try:
        full.evaluate(run)
    except Stopped:
        return True
    return all(full.stands(end) is True for end in run)


def _refuse_nothing_to_do(family: Family, start: float) -> None:
    statics = build_statics(family(start))
    if statics.free_count == 0:
        raise InputError("every block is fixed", remedy="free some blocks")
    if not statics.load.any():
        raise InputError("nothing loads the free blocks", remedy="give a load")
