"""Search for the change of a verdict: a scan, then bisection. The verdict need not be monotone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from operator import itemgetter

import numpy as np

from drystone.base.progress import Stop, Stopped
from drystone.base.workers import WorkerPool
from drystone.limits.brackets import Bracket, Evaluation, FoundBracket
from drystone.limits.limit_checks import STANDS, Check
from drystone.limits.limit_families import Family
from drystone.results import Result, Verdict

_GROWTH = 4.0
"""Of a step from a guess to the next: less than the bisections that follow."""


class VerdictSearch:
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
        pool = WorkerPool(self.executor if len(new) > 1 else None)
        late = self.stop if self.executor is not None else bool
        for value, answer in zip(new, pool.answers(task, new, late), strict=False):
            stopped = self.stop()
            if not (stopped and answer.verdict is Verdict.UNDECIDED):
                self.results[value] = answer
            if stopped:
                raise Stopped
        if new and new[-1] not in self.results:
            raise Stopped

    def run(
        self, start: float, end: float, *, width: float, scan: int, beyond: Bracket | None = None
    ) -> FoundBracket:
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
        FoundBracket
            If the search was stopped: the result of the values tried so far.
        """
        try:
            return self._run(start, end, width, scan, beyond)
        except Stopped:
            return self.so_far(start, beyond)

    def from_start(
        self, start: float, end: float, *, width: float, scan: int, beyond: Bracket | None = None
    ) -> FoundBracket:
        """As :meth:`run`; where it falls at the start no other value is tried."""
        try:
            held = self.stands(start)
        except Stopped:
            return self.so_far(start, beyond)
        if held is False:
            return self.so_far(start)
        return self.run(start, end, width=width, scan=scan, beyond=beyond)

    def so_far(self, start: float, beyond: Bracket | None = None) -> FoundBracket:
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
        closing: float = 0.0,
        inward: bool = False,
    ) -> FoundBracket:
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
        closing
            Distance from a guess that stands to the fall ``beyond`` within which nothing is tried.
        inward
            Whether steps then grow from the fall towards the start, where the change is expected
            near the fall although ``near`` is far from it.

        Raises
        ------
        Stopped
            The search was asked to stop.
        """
        start, end = span
        self._walk(near, start, width, True)
        held = self.stands(near)
        if held and beyond is not None and beyond.closes(near, closing):
            return self.so_far(start, beyond)
        if held is not False:
            self._walk(far, end, width, False)
        bracket = self.so_far(start, beyond).bracket
        if inward and bracket.stands is not None and bracket.falls is not None:
            self._walk(bracket.falls, bracket.stands, width, True)
            bracket = self.so_far(start, beyond).bracket
        inside, outside = bracket.stands, bracket.falls
        if inside is not None and inside != end:
            ends = abs(inside - start), np.inf if outside is None else abs(outside - start)
            in_order = sorted(self.results, key=lambda value: abs(value - start))
            doubtful = [value for value in in_order if ends[0] < abs(value - start) < ends[1]]
            self._close(inside, outside, doubtful, width)
        return self.so_far(start, beyond)

    def _walk(self, guess: float, towards: float, step: float, stands: bool) -> None:
        """Growing steps from a guess to the first value that stands, or that falls."""
        here = guess
        while self.stands(here) is not stands and here != towards:
            left = towards - here
            here = towards if abs(left) <= step else here + float(np.copysign(step, left))
            step *= _GROWTH

    def _run(
        self, start: float, end: float, width: float, scan: int, beyond: Bracket | None
    ) -> FoundBracket:
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

    def _found(self, bracket: Bracket, islands: tuple[tuple[float, float], ...]) -> FoundBracket:
        return FoundBracket(bracket, islands, self.evaluations())

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
