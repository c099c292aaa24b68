"""The limit of rest, searched inside the limit of equilibrium."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from drystone.base.errors import InputError
from drystone.base.progress import Progress
from drystone.limits.bounds import bisected_bound
from drystone.limits.limit_families import Family
from drystone.limits.limit_types import Limit, LimitOptions
from drystone.limits.search import (
    CONVEX_SEARCH,
    SEARCHED,
    STANDS,
    STANDS_OR_NOT,
    Bracket,
    Check,
    Found,
    Search,
    Stop,
    Stopped,
    any_stiffness,
    one_stiffness,
    some_stiffness,
)
from drystone.results import Result, Verdict
from drystone.stability.problem import Clock
from drystone.statics import build_statics

COARSE = 1.0 / 96.0
"""Default width on larger models, by the way to the limit of equilibrium. A finer bracket would
depend on the iteration more than on the structure. It is a scan of six steps, each halved four
times."""


@dataclass(frozen=True, eq=False)
class Means:
    """What a search works with. Without a check, drystone's own is made in two steps."""

    check: Check | None
    options: LimitOptions
    executor: Executor | None
    progress: Progress | None
    stop: Stop | None
    time_limit_s: float = float("inf")

    @cached_property
    def clock(self) -> Clock:
        """The time since the start; remembers the wish to stop."""
        return Clock(self.time_limit_s, self.stop)

    def search(
        self,
        family: Family,
        check: Callable[..., Result],
        meaning: Mapping[Verdict, bool | None] = STANDS,
    ) -> Search:
        """A search with one of our own checks, which can be stopped where it runs here."""
        limited = self.stop is not None or np.isfinite(self.time_limit_s)
        if limited and self.executor is None:
            check = partial(check, stop=self.clock.late)
        return Search(family, check, self.executor, meaning, self.clock.late)

    def tell(self, stage: str, done: int) -> None:
        """Report one of three steps."""
        if self.progress is not None:
            self.progress(stage, done, 3)


def bisected(family: Family, start: float, end: float, width: float, means: Means) -> Limit:
    """A limit whose convex bound has to be bisected; the width of the options comes first."""
    chosen = width if means.options.width is None else means.options.width
    cone = means.options.cone
    return searched(
        family,
        start,
        end,
        lambda stop: (
            bisected_bound(family, start, end, width=chosen, cone=cone, stop=stop),
            chosen,
        ),
        means,
    )


def searched(
    family: Family,
    start: float,
    end: float,
    bound: Callable[[Stop], tuple[Bracket, float]],
    means: Means,
) -> Limit:
    """The convex bound and its width first, then the full verdict inside it.

    Raises
    ------
    InputError
        Nothing is free, or nothing is loaded.
    """
    _refuse_nothing_to_do(family, start)
    began = time.perf_counter()
    means.tell("limit of equilibrium", 0)
    outer, width = bound(means.clock.late)
    between = time.perf_counter()
    uniform: Found | None = None
    rest: Found | None = None
    if means.options.full and not means.clock.late():
        means.tell("limit of rest", 1)
        if outer.stands is None:
            rest = Found(outer, (), ())
        elif means.check is not None:
            scan = means.options.scan
            search = Search(family, means.check, means.executor, stop=means.clock.late)
            rest = search.run(start, outer.stands, width=width, scan=scan, beyond=outer)
        else:
            uniform, rest = _in_two_steps(family, (start, outer.stands), outer, width, means)
    means.tell("done", 3)
    tried = {one.value: one for found in (uniform, rest) if found for one in found.evaluations}
    return Limit(
        family.parameter,
        family.unit,
        start,
        end,
        outer,
        None if rest is None else rest.bracket,
        None if uniform is None else uniform.bracket,
        () if rest is None else rest.islands,
        tuple(tried[value] for value in sorted(tried)),
        {"equilibrium": between - began, "rest": time.perf_counter() - between},
        means.clock.reason,
    )


def _in_two_steps(
    family: Family, span: tuple[float, float], outer: Bracket, width: float, means: Means
) -> tuple[Found, Found]:
    """Limits for uniform stiffness and for some stiffness.

    The scan and the bisection use uniform stiffness, which is cheap. The cascade is computed at the
    first value where uniform stiffness falls. Where that stands, the range beyond is searched too.
    """
    (start, last), scan = span, means.options.scan
    corners = family(start).contacts.corner_count
    large, coarse = corners > SEARCHED, width
    if corners > CONVEX_SEARCH and means.options.width is None:
        coarse = max(width, COARSE * abs(last - start))
    width = coarse if large else width
    search = means.search(family, one_stiffness, STANDS_OR_NOT)
    uniform = search.run(start, last, width=width, scan=scan, beyond=outer)
    edge = uniform.bracket.stands
    if edge == last:
        return uniform, replace(uniform, evaluations=())
    means.tell("other stiffnesses", 2)
    falls = uniform.bracket.falls
    first = start if falls is None else falls
    full = means.search(family, some_stiffness, STANDS_OR_NOT if large else STANDS)
    try:
        if large:
            farther = _farther(full, first, last, width)
        elif full.stands(first) is True:
            some = full.run(first, last, width=coarse, scan=scan, beyond=outer)
            return uniform, _searched_once(family, some, outer, means)
        else:
            farther = None
    except Stopped:
        so_far = full.so_far(first).bracket
        inside = uniform.bracket if so_far.stands is None else so_far
        bracket = Bracket(inside.stands, outer.falls, inside.standing, outer.falling)
        return uniform, Found(bracket, uniform.islands, full.evaluations())
    if farther is None:
        inside = uniform.bracket
        bracket = Bracket(inside.stands, first, inside.standing, full.results[first])
    else:
        bracket = farther
    if bracket.falling is None or bracket.falling.verdict is not Verdict.UNSTABLE:
        bracket = replace(bracket, falls=outer.falls, falling=outer.falling)
    found = Found(bracket, uniform.islands, full.evaluations())
    return uniform, found if large else _searched_once(family, found, outer, means)


def _searched_once(family: Family, found: Found, outer: Bracket, means: Means) -> Found:
    """Confirm the first falling value by a search, where only samples were tried."""
    bracket = found.bracket
    value = bracket.falls
    if value is None or value == outer.falls:
        return found
    if family(value).contacts.corner_count <= CONVEX_SEARCH:
        return found
    search = means.search(family, any_stiffness)
    try:
        stands = search.stands(value)
    except Stopped:
        stands = None
    if stands is True:
        bracket = replace(outer, computed=None, stands=value, standing=search.results[value])
    elif stands is None:
        bracket = replace(bracket, falls=outer.falls, falling=outer.falling)
    else:
        bracket = replace(bracket, falling=search.results[value])
    tried = {one.value: one for one in (*found.evaluations, *search.evaluations())}
    return replace(found, bracket=bracket, evaluations=tuple(tried[v] for v in sorted(tried)))


def _farther(search: Search, first: float, last: float, width: float) -> Bracket | None:
    """The limit from ``first`` on by growing steps; ``None`` where that does not stand.

    A check of a large model that falls is slow, so no value far beyond the limit is tried.
    """
    if not search.stands(first):
        return None
    inside, step = first, width if last > first else -width
    while inside != last:
        there = inside + step
        there = last if (last - there) * step <= 0.0 else there
        if not search.stands(there):
            return search.run(inside, there, width=width, scan=1).bracket
        inside, step = there, 2.0 * step
    return Bracket(last, standing=search.results[last])


def _refuse_nothing_to_do(family: Family, start: float) -> None:
    statics = build_statics(family(start))
    if statics.free_count == 0:
        raise InputError("every block is fixed", remedy="free some blocks")
    if not statics.load.any():
        raise InputError("nothing loads the free blocks", remedy="give a load")


__all__ = ["Means", "bisected", "searched"]
