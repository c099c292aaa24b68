"""Search for the change of a verdict: a scan, then bisection. The verdict need not be monotone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from operator import itemgetter
from typing import Any, TypeAlias

import numpy as np

from drystone import stability
from drystone.base.display import OneLine
from drystone.limits.limit_families import Family
from drystone.model import Model
from drystone.results import Result, Samples, Verdict
from drystone.settlement import Outcome

Check: TypeAlias = Callable[[Model], Result]
"""A function that gives the verdict on a model."""

Stop: TypeAlias = Callable[[], bool]
"""Whether to stop. Once True, it must stay True."""

SEARCHED = 500
"""Largest number of corners with which uniform stiffness is checked as thoroughly as by
:func:`drystone.check`. Chosen: for larger models that fall one such try takes seconds; two quick
ones are made instead."""

ONE_STIFFNESS = stability.CheckOptions(samples=0, settle=False)
STIFFNESSES = stability.CheckOptions(settle=False)

UNIFORM = stability.QUICK.with_slip_lengths(None, 1.0)
"""Screening of large models, for the limit of uniform stiffness. Measured on the Armadillo vault:
the quick level gives the same limits as the patient one in half of the time."""


def one_stiffness(model: Model, *, stop: Stop | None = None) -> Result:
    """Whether it stands with uniform contact stiffness: the fastest proof."""
    if model.contacts.corner_count > SEARCHED:
        return stability.try_rest(model, screening=UNIFORM, stop=stop)
    return stability.check(model, options=ONE_STIFFNESS, stop=stop)


def every_stiffness(model: Model, *, stop: Stop | None = None) -> Result:
    """Whether it stands with every contact stiffness that is tried: robust."""
    found = stability.check(model, options=STIFFNESSES, stop=stop)
    if found.stable and found.samples.standing < found.samples.tried:
        return replace(found, verdict=Verdict.UNDECIDED)
    return found


def verdict(model: Model, *, stop: Stop | None = None) -> Result:
    """The verdict of :func:`drystone.check`: settlement where contact stiffness decides."""
    return stability.check(model, stop=stop)


STANDS: Mapping[Verdict, bool | None] = {
    Verdict.STABLE: True,
    Verdict.EQUILIBRIUM_EXISTS: True,
    Verdict.UNSTABLE: False,
    Verdict.UNDECIDED: None,
}
"""Whether a verdict counts as standing; ``None`` counts as neither."""

STANDS_OR_NOT: Mapping[Verdict, bool | None] = {
    kind: stands is True for kind, stands in STANDS.items()
}
"""As above, but an undecided value counts as falling."""


@dataclass(frozen=True)
class Evaluation:
    """One value that was tried.

    Attributes
    ----------
    value
    verdict
    samples
    settled
        How it ended where the blocks were followed by finite steps, because contact stiffness
        decides; else ``None``.
    """

    value: float
    verdict: Verdict
    samples: Samples = field(default_factory=Samples)
    settled: Outcome | None = None


@dataclass(frozen=True, eq=False)
class Bracket(OneLine):
    """Both sides of a limit.

    Attributes
    ----------
    stands
        The last value at which it stands; ``None`` if none was found.
    falls
        The first value beyond at which it falls; ``None`` if it stands at all tried values.
    standing, falling
        The states there; the falling one has the mechanism.
    computed
        The limit from a convex program, if there is one.
    """

    stands: float | None = None
    falls: float | None = None
    standing: Result | None = None
    falling: Result | None = None
    computed: float | None = None

    def _summary(self) -> str:
        return f"stands={self.stands}, falls={self.falls}, computed={self.computed}"

    @property
    def value(self) -> float | None:
        """The limit: computed, or the middle of the bracket; ``None`` where a side is missing."""
        if self.stands is None or self.falls is None:
            return None
        if self.computed is not None:
            return self.computed
        return 0.5 * (self.stands + self.falls)


@dataclass(frozen=True, eq=False)
class Found:
    """Result of a search.

    Attributes
    ----------
    bracket
        Around the first change of the verdict, seen from the start.
    islands
        Values beyond it between which the structure stands again, as far as they were tried.
    evaluations
        In ascending order of the value.
    """

    bracket: Bracket
    islands: tuple[tuple[float, float], ...]
    evaluations: tuple[Evaluation, ...]


GROWTH = 4.0
"""Of a step from a guess to the next: less than the bisections that follow."""


class Stopped(Exception):
    """The search was asked to stop. It keeps what it found."""


class Search:
    """A search along one family; keeps all tried values.

    Parameters
    ----------
    family
    check
    executor
        Computes the values of a scan in parallel.
    meaning
        What each verdict counts as.
    stop
        Called before and after every value.
    """

    def __init__(
        self,
        family: Family,
        check: Check,
        executor: Executor | None = None,
        meaning: Mapping[Verdict, bool | None] = STANDS,
        stop: Stop | None = None,
    ) -> None:
        self.family = family
        self.check = check
        self.executor = executor
        self.meaning = meaning
        self.stop = stop if stop is not None else lambda: False
        self.results: dict[float, Result] = {}

    def stands(self, value: float) -> bool | None:
        """Whether the structure stands at a value."""
        self.evaluate([value])
        return self.meaning[self.results[value].verdict]

    def evaluate(self, values: Iterable[float]) -> None:
        """Try values that were not tried yet.

        Raises
        ------
        Stopped
            The request to stop. An undecided answer then may be incomplete and is not kept.
        """
        new = [value for value in dict.fromkeys(values) if value not in self.results]
        if new and self.stop():
            raise Stopped
        task = partial(evaluate, self.family, self.check)
        if self.executor is None or len(new) < 2:
            answers: Iterable[Result] = map(task, new)
        else:
            answers = self.executor.map(task, new)
        for value, answer in zip(new, answers, strict=True):
            stopped = self.stop()
            if not (stopped and answer.verdict is Verdict.UNDECIDED):
                self.results[value] = answer
            if stopped:
                raise Stopped

    def run(
        self, start: float, end: float, *, width: float, scan: int, beyond: Bracket | None = None
    ) -> Found:
        """Bracket the first change of the verdict between ``start`` and ``end``.

        Parameters
        ----------
        start
            Value at which the structure should stand.
        end
            Either above or below it.
        width
            Width of the bracket, if no value in it is undecided.
        scan
            Number of steps of the scan; 1 tries the two ends only.
        beyond
            Proof of falling just beyond ``end``: closes the bracket when all up to it stand.

        Returns
        -------
        Found
            If the search was stopped: the result of the values tried so far.
        """
        try:
            return self._run(start, end, width, scan, beyond)
        except Stopped:
            return self.so_far(start, beyond)

    def so_far(self, start: float, beyond: Bracket | None = None) -> Found:
        """The result of the values tried so far, in order from the start."""
        tried = sorted(self.results, key=lambda value: abs(value - start))
        held = [self.meaning[self.results[value].verdict] for value in tried]
        first = next((i for i, stands in enumerate(held) if stands is not True), len(tried))
        inside = tried[first - 1] if first else None
        outside = next((tried[i] for i, s in enumerate(held) if i >= first and s is False), None)
        bracket = Bracket(
            inside,
            outside,
            None if inside is None else self.results[inside],
            None if outside is None else self.results[outside],
        )
        if outside is None and beyond is not None:
            bracket = replace(bracket, falls=beyond.falls, falling=beyond.falling)
        return self._found(bracket, _runs(tried, held, first))

    def around(
        self,
        near: float,
        far: float,
        span: tuple[float, float],
        *,
        width: float,
        beyond: Bracket | None = None,
    ) -> Found:
        """Bracket the change of the verdict by growing steps from two guesses.

        No value far from the change is tried: a check that falls is slow.

        Parameters
        ----------
        near, far
            Where it should stand, and where it should fall.
        span
            The start, from where it should stand, and the end.
        width, beyond
            As for :meth:`run`.

        Raises
        ------
        Stopped
            The search was asked to stop.
        """
        start, end = span
        self._walk(near, start, width, True)
        if self.stands(near) is not False:
            self._walk(far, end, width, False)
        bracket = self.so_far(start, beyond).bracket
        inside, outside = bracket.stands, bracket.falls
        if inside is not None and inside != end:
            ends = abs(inside - start), np.inf if outside is None else abs(outside - start)
            by_way = sorted(self.results, key=lambda value: abs(value - start))
            doubtful = [value for value in by_way if ends[0] < abs(value - start) < ends[1]]
            self._close(inside, outside, doubtful, width)
        return self.so_far(start, beyond)

    def _walk(self, guess: float, towards: float, step: float, stands: bool) -> None:
        """Growing steps from a guess to the first value that stands, or that falls."""
        here = guess
        while self.stands(here) is not stands and here != towards:
            left = towards - here
            here = towards if abs(left) <= step else here + float(np.copysign(step, left))
            step *= GROWTH

    def _run(
        self, start: float, end: float, width: float, scan: int, beyond: Bracket | None
    ) -> Found:
        grid = np.linspace(start, end, max(scan, 1) + 1).tolist()
        self.evaluate(grid)
        held = [self.stands(value) for value in grid]
        first = next((i for i, stands in enumerate(held) if stands is not True), len(grid))
        if first == len(grid):
            falls = None if beyond is None else beyond.falls
            falling = None if beyond is None else beyond.falling
            bracket = Bracket(grid[-1], falls, self.results[grid[-1]], falling)
            return self._found(bracket, ())
        fallen = next((i for i, s in enumerate(held) if i >= first and s is False), None)
        if first == 0:
            at = None if fallen is None else grid[fallen]
            bracket = Bracket(None, at, None, None if at is None else self.results[at])
            return self._found(bracket, _runs(grid, held, 0))
        if fallen is None:
            falls = None if beyond is None else beyond.falls
            inside, outside = self._close(grid[first - 1], falls, grid[first:], width)
        else:
            inside, outside = self._close(grid[first - 1], grid[fallen], grid[first:fallen], width)
        falling = None
        if outside is not None:
            proof = None if beyond is None else beyond.falling
            falling = self.results.get(outside, proof)
        bracket = Bracket(inside, outside, self.results[inside], falling)
        return self._found(bracket, _runs(grid, held, first))

    def _close(
        self, inside: float, outside: float | None, doubtful: list[float], width: float
    ) -> tuple[float, float | None]:
        """Bisect between a value that stands and one that falls.

        Undecided values between them are enclosed from both sides.
        """
        doubtful = list(doubtful)
        while True:
            near = doubtful[0] if doubtful else outside
            gaps = [] if near is None else [(inside, near)]
            if doubtful and outside is not None:
                gaps.append((doubtful[-1], outside))
            low, high = max(gaps, key=lambda gap: abs(gap[1] - gap[0]))
            middle = 0.5 * (low + high)
            if abs(high - low) <= width * (1.0 + 1e-9) or middle in (low, high):
                return inside, outside
            stands = self.stands(middle)
            if low == inside:
                if stands is True:
                    inside = middle
                elif stands is False:
                    outside, doubtful = middle, []
                else:
                    doubtful.insert(0, middle)
            elif stands is True:
                inside, doubtful = middle, []
            elif stands is False:
                outside = middle
            else:
                doubtful.append(middle)

    def _found(self, bracket: Bracket, islands: tuple[tuple[float, float], ...]) -> Found:
        return Found(bracket, islands, self.evaluations())

    def evaluations(self) -> tuple[Evaluation, ...]:
        """Tried values, in ascending order."""
        return tuple(
            Evaluation(
                value,
                result.verdict,
                result.samples,
                None if result.settlement is None else result.settlement.outcome,
            )
            for value, result in sorted(self.results.items(), key=itemgetter(0))
        )


def evaluate(family: Family, check: Check, value: float) -> Result:
    """The answer at one value of a family."""
    return check(family(value))


def _runs(
    grid: Sequence[float], held: Sequence[bool | None], first: int
) -> tuple[tuple[float, float], ...]:
    """Ends of the runs of standing values after position ``first``."""
    runs: list[tuple[float, float]] = []
    previous = False
    for value, stands in zip(grid[first:], held[first:], strict=True):
        if stands is True:
            runs.append((runs.pop()[0] if previous else value, value))
        previous = stands is True
    return tuple(runs)


def plain(bracket: Bracket | None) -> dict[str, Any] | None:
    """A bracket as plain values."""
    if bracket is None:
        return None
    return {"stands": bracket.stands, "falls": bracket.falls, "value": bracket.value}
