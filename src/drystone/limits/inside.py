"""The limit of rest, searched inside the limit of equilibrium."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from drystone.base.errors import InputError
from drystone.base.progress import Stop, Stopped
from drystone.base.workers import WorkerPool
from drystone.limits.bounds import bisected_bound
from drystone.limits.brackets import Bracket, FoundBracket
from drystone.limits.limit_checks import (
    SEARCHED,
    STANDS_OR_NOT,
    RestStates,
    every_stiffness,
    one_stiffness,
    verdict,
)
from drystone.limits.limit_families import Family, ModelsOnce
from drystone.limits.limit_types import Limit
from drystone.limits.own_size import by_its_own_size
from drystone.limits.search import VerdictSearch
from drystone.limits.search_settings import COARSE, FOLLOWED, Brackets, SearchSettings
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.statics import build_statics

_CLOSING = 2.0
"""Default widths between a value that stands and a proven fall at which these are the answer for
larger models. Between them blocks would be followed very near to the limit of equilibrium, where it
takes longest: 50 s for a cross vault of 188 blocks."""


def answers_at_start(
    model: Model, stop: Callable[[], bool] | None
) -> tuple[Result | None, Result | None]:
    """What uniform stiffness says, and the verdict where that does not hold the blocks.

    None where the analysis was stopped.
    """
    uniform = one_stiffness(model, stop=stop)
    full = None if uniform.stable else verdict(model, stop=stop)
    return (None, None) if stop is not None and stop() else (uniform, full)


def bisected(
    family: Family, start: float, end: float, width: float, means: SearchSettings
) -> Limit:
    """A limit whose convex bound is found by bisection; uses the width of the options."""
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
    means: SearchSettings,
    share: float | None = None,
) -> Limit:
    """The convex bound and its width, then the limit of the full verdict inside it.

    ``share``: of the limit, which is the default width.

    Raises
    ------
    InputError
        No block is free, or no free block is loaded.
    """
    _refuse_nothing_to_do(family, start)
    with WorkerPool(means.given) as pool:
        return _searched(family, start, end, bound, replace(means, executor=pool.executor), share)


def _searched(
    family: Family,
    start: float,
    end: float,
    bound: Callable[[Stop], tuple[Bracket, float]],
    means: SearchSettings,
    share: float | None,
) -> Limit:
    began = time.perf_counter()
    means.tell("limit of equilibrium", 0)
    outer, width = bound(means.clock.late)
    between = time.perf_counter()
    uniform: FoundBracket | None = None
    rest: FoundBracket | None = None
    robust: Bracket | None = None
    if means.options.full and not means.clock.late():
        means.tell("limit of rest", 1)
        if outer.stands is None:
            rest = FoundBracket(outer, (), ())
        else:
            found = _inside(family, (start, outer.stands), outer, width, means)
            if means.options.width is None:
                least = width if share is None else 0.0
                found = by_its_own_size(
                    family, start, found, outer, (least, share or 0.0), means, _inside
                )
            uniform, rest, robust = found
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
        robust,
        () if rest is None else rest.islands,
        tuple(tried[value] for value in sorted(tried)),
        {"equilibrium": between - began, "rest": time.perf_counter() - between},
        means.clock.reason,
        means.options,
    )


def _inside(
    family: Family, span: tuple[float, float], outer: Bracket, width: float, means: SearchSettings
) -> Brackets:
    """The brackets for uniform stiffness, of the verdict, and for every stiffness."""
    if means.check is None:
        return _in_two_steps(family, span, outer, width, means)
    search = VerdictSearch(family, means.check, means.executor, stop=means.clock.late)
    scan = means.options.scan
    return None, search.run(*span, width=width, scan=scan, beyond=outer), None


def _in_two_steps(
    family: Family, span: tuple[float, float], outer: Bracket, width: float, means: SearchSettings
) -> tuple[FoundBracket, FoundBracket, Bracket | None]:
    """Limits for uniform stiffness, of the verdict, and of standing for every stiffness.

    The scan and the first bisection use uniform stiffness, which is fast. The verdict is computed
    on both sides of that limit, and beyond them only if these do not close the bracket. Where
    contact stiffness decides at that limit, the limit of standing for every stiffness comes first:
    it is cheaper than following the blocks, and if they fall just beyond it, it is the answer.
    """
    (start, last), scan = span, means.options.scan
    family, closing = ModelsOnce(family), 0.0
    # each value begins at the rest states of the last one that stands for every stiffness, and what
    # was tried at a value is not tried there again
    near_states = RestStates()
    if family(start).contacts.corner_count > SEARCHED and means.options.width is None:
        width = max(width, COARSE * abs(last - start))
        closing = _CLOSING * width
    uniformly, verdict_there = means.at_start
    known = {start: uniformly}
    search = means.search(family, partial(one_stiffness, near=near_states), STANDS_OR_NOT, known)
    uniform = search.from_start(start, last, width=width, scan=scan, beyond=outer)
    edge, falls = uniform.bracket.stands, uniform.bracket.falls
    means.tell("verdict where stiffness decides", 2)
    full = means.search(family, partial(verdict, near=near_states), known={start: verdict_there})
    every = means.search(family, partial(every_stiffness, near=near_states), STANDS_OR_NOT)
    near = start if edge is None else edge
    far = last if edge is None or falls in (None, outer.falls) else falls
    if means.options.width is None:
        followed = means.followed
        width = max(width, FOLLOWED * abs(last - start) if followed is None else followed)
    try:
        if edge is not None and not every.stands(near):
            first = every.around(near, near, (start, near), width=width).bracket
            robust = start if first.stands is None else first.stands
            if first.stands is not None and outer.closes(robust, closing):
                near = robust
            elif first.falls is not None and full.stands(first.falls) is False:
                near, far = robust, first.falls
        full.results.update({v: one for v, one in every.results.items() if _is_robust(one)})
        # where uniform stiffness holds nothing, blocks settle almost up to the limit of equilibrium
        rest = full.around(
            near, far, span, width=width, beyond=outer, closing=closing, inward=edge is None
        )
        stands_again = [all(full.stands(end) is True for end in run) for run in uniform.islands]
        islands = tuple(run for run, yes in zip(uniform.islands, stands_again, strict=True) if yes)
        rest = replace(rest, islands=islands, evaluations=full.evaluations())
        return uniform, rest, _robust(every, full, rest.bracket, start, width)
    except Stopped:
        so_far = full.so_far(start).bracket
        inside = uniform.bracket if so_far.stands is None else so_far
        # a fall nearer than the limit of equilibrium counts, beyond what stands
        outside = outer if so_far.stands is None or so_far.falls is None else so_far
        bracket = Bracket(inside.stands, outside.falls, inside.standing, outside.falling)
        return uniform, FoundBracket(bracket, uniform.islands, full.evaluations()), None


def _robust(
    every: VerdictSearch, full: VerdictSearch, rest: Bracket, start: float, width: float
) -> Bracket | None:
    """The limit of standing for every stiffness, from known values of the verdict."""
    for value, result in full.results.items():
        robust = _is_robust(result)
        every.results[value] = result if robust else replace(result, verdict=Verdict.UNDECIDED)
    if rest.stands is None or _is_robust(full.results[rest.stands]):
        return every.so_far(start).bracket
    in_order = sorted(every.results, key=lambda value: abs(value - start))
    sensitive = next(value for value in in_order if every.stands(value) is False)
    try:
        return every.around(in_order[0], sensitive, (start, rest.stands), width=width).bracket
    except Stopped:
        return every.so_far(start).bracket


def _is_robust(result: Result) -> bool:
    """Whether it stands for every stiffness that was tried."""
    samples = result.samples
    return result.stable and result.settlement is None and samples.standing == samples.tried


def _refuse_nothing_to_do(family: Family, start: float) -> None:
    statics = build_statics(family(start))
    if statics.free_count == 0:
        raise InputError("every block is fixed", remedy="free some blocks")
    if not statics.load.any():
        raise InputError("nothing loads the free blocks", remedy="give a load")
