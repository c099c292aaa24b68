"""Search for the change of a verdict: a scan, then bisection. The verdict need not be monotone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.settings import Stop, Stopped
from drystone.base.workers import WorkerPool
from drystone.limits.limit_types import STANDS, Bracket, Check, Evaluation, Family, FoundBracket
from drystone.results import Result, Verdict

_GROWTH = 4.0
"""Of a step from a guess to the next: less than the bisections that follow."""


class Width(NamedTuple):
    """How wide a bracket may be: the larger of a length, and a share of its value."""

    least: float
    share: float = 0.0

    def at(self, *values: float) -> float:
        """The width at some values."""
        return max(self.least, self.share * max(abs(value) for value in values))


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
    starts
        Results by value at whose rest states ``check`` begins, if it is one of drystone. Values of
        a scan begin in line with what stands before them; with an executor, at that of its start.
    """

    def __init__(
        self,
        family: Family,
        check: Check,
        executor: Executor | None = None,
        meaning: Mapping[Verdict, bool | None] = STANDS,
        stop: Stop | None = None,
        starts: Mapping[float, Result] | None = None,
    ) -> None:
        self.family = family
        self.check = check
        self.executor = executor
        self.meaning = meaning
        self.stop = stop if stop is not None else lambda: False
        self.starts = None if starts is None else dict(starts)
        self.results: dict[float, Result] = {}

    def stands(self, value: float) -> bool | None:
        """Whether the structure stands at a value."""
        self.evaluate([value])
        return self.meaning[self.results[value].verdict]

    def evaluate(self, values: Iterable[float], start: Floats | None = None) -> None:
        """Try values that were not tried yet, from a rest state (n, 6) near them.

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
        begun = [(value, self._start(value) if start is None else start) for value in new]
        for value, answer in zip(new, pool.answers(task, begun, late), strict=False):
            stopped = self.stop()
            if not (stopped and answer.verdict is Verdict.UNDECIDED):
                self.results[value] = answer
            if stopped:
                raise Stopped
        if new and new[-1] not in self.results:
            raise Stopped

    def _start(self, value: float) -> Floats | None:
        known = (self.starts or {}).get(value)
        return None if known is None else known.displacement

    def run(
        self, start: float, end: float, *, width: Width, scan: int, beyond: Bracket | None = None
    ) -> FoundBracket:
        """Bracket the first change of the verdict between ``start`` and ``end``.

        Where it falls at the start no other value is tried.

        Parameters
        ----------
        start
            Value at which the structure should stand.
        end
            Either above or below it.
        width
            Of the bracket, if no value in it is undecided.
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
            first, *inner, last = np.linspace(start, end, max(scan, 1) + 1).tolist()
            if self.stands(first) is False:
                return self.so_far(start)
            if self.starts is None:
                self.evaluate([*inner, last])
            elif self.executor is not None:
                self.evaluate([*inner, last], in_line(self.results, first))
            else:
                for value in (*inner, last):
                    self.evaluate([value], in_line(self.results, value))
            return self._closed((start, end), width, beyond)
        except Stopped:
            return self.so_far(start, beyond)

    def around(
        self,
        near: float,
        far: float,
        span: tuple[float, float],
        *,
        width: Width,
        beyond: Bracket | None = None,
        closing: float = 0.0,
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
            Widths from a guess that stands to the fall ``beyond`` within which nothing is tried;
            with any, undecided values are enclosed from where it stands only.

        Returns
        -------
        FoundBracket
            If the search was stopped: the result of the values tried so far.
        """
        start, end = span
        try:
            self._walk(near, start, width.at(near), True)
            held = self.stands(near)
            if held and beyond is not None and beyond.closes(near, closing * width.at(near)):
                return self.so_far(start, beyond)
            if held is not False:
                last = beyond if closing else None
                proven = last is not None and last.closes(end, width.at(end))
                self._walk(far, end, width.at(far), False, proven)
            return self._closed(span, width, beyond, both=not closing)
        except Stopped:
            return self.so_far(start, beyond)

    def so_far(self, start: float, beyond: Bracket | None = None) -> FoundBracket:
        """The result of the values tried so far, in order from the start."""
        tried, held = self._in_order(start)
        first = next((i for i, stands in enumerate(held) if stands is not True), len(tried))
        inside = tried[first - 1] if first else None
        outside = next((tried[i] for i, s in enumerate(held) if i >= first and s is False), None)
        return self._found(start, inside, outside, beyond)

    def _in_order(self, start: float) -> tuple[list[float], list[bool | None]]:
        tried = sorted(self.results, key=lambda value: abs(value - start))
        return tried, [self.meaning[self.results[value].verdict] for value in tried]

    def _walk(
        self, guess: float, towards: float, step: float, stands: bool, proven: bool = False
    ) -> None:
        """Growing steps from a guess to the first value that stands, or that falls.

        From an undecided value none leads to the end where it falls just beyond: ``proven``.
        """
        here = guess
        while self.stands(here) is not stands and here != towards:
            left = towards - here
            if abs(left) <= step and proven and self.stands(here) is None:
                return
            here = towards if abs(left) <= step else here + float(np.copysign(step, left))
            step *= _GROWTH

    def _closed(
        self,
        span: tuple[float, float],
        width: Width,
        beyond: Bracket | None,
        *,
        both: bool = True,
    ) -> FoundBracket:
        """Bisect between the last value that stands and the first beyond it that falls.

        Undecided values between them are enclosed from both sides, or from where it stands only.
        """
        start, end = span
        known = self.so_far(start, beyond).bracket
        inside, outside = known.stands, known.falls
        if inside is None or inside == end:
            return self.so_far(start, beyond)
        ends = abs(inside - start), np.inf if outside is None else abs(outside - start)
        in_order, _ = self._in_order(start)
        doubtful = [value for value in in_order if ends[0] < abs(value - start) < ends[1]]
        while True:
            near = doubtful[0] if doubtful else outside
            gaps = [] if near is None else [(inside, near)]
            if doubtful and outside is not None and both:
                gaps.append((doubtful[-1], outside))
            low, high = max(gaps, key=lambda gap: abs(gap[1] - gap[0]))
            middle = 0.5 * (low + high)
            if abs(high - low) <= width.at(low, high) * (1.0 + 1e-9) or middle in (low, high):
                return self._found(start, inside, outside, beyond)
            stands = self.stands(middle)
            if stands is True:
                doubtful = doubtful if low == inside else []
                inside = middle
            elif stands is False:
                outside = middle
                doubtful = [one for one in doubtful if abs(one - start) < abs(middle - start)]
            else:
                doubtful = sorted([*doubtful, middle], key=lambda value: abs(value - start))

    def _found(
        self,
        start: float,
        inside: float | None,
        outside: float | None,
        beyond: Bracket | None,
    ) -> FoundBracket:
        """The bracket between two values, and the runs of standing values beyond it."""
        proof = beyond if beyond is not None and outside in (None, beyond.falls) else Bracket()
        falls = proof.falls if outside is None else outside
        bracket = Bracket(
            inside,
            falls,
            None if inside is None else self.results[inside],
            proof.falling if falls is None else self.results.get(falls, proof.falling),
            undecided=self._unsure(inside, falls),
        )
        tried, held = self._in_order(start)
        after = 0 if inside is None else tried.index(inside) + 1
        return FoundBracket(bracket, _runs(tried, held, after), self.evaluations())

    def _unsure(self, inside: float | None, falls: float | None) -> str:
        """Why the farthest undecided value between two is that; empty where there is none."""
        if inside is None or falls is None:
            return ""
        low, high = sorted((inside, falls))
        tried = [at for at, one in self.results.items() if one.verdict is Verdict.UNDECIDED]
        within = [at for at in tried if low < at < high]
        farthest = max(within, key=lambda at: abs(at - inside), default=None)
        return "" if farthest is None else self.results[farthest].message

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


def in_line(results: Mapping[float, Result], value: float) -> Floats | None:
    """Where the rest states (n, 6) of the last two results that have one lead at a value.

    Between changes of contacts they are linear in the loads. Measured on scans up to the limits of
    tilt of walls and vaults: 5 to 40 iterations where it takes 15 to 59 from the last one.
    """
    held = [(at, one.displacement) for at, one in results.items() if one.stable]
    known = [(at, state) for at, state in held if state is not None][-2:]
    if not known:
        return None
    (first, before), (last, state) = known[0], known[-1]
    if first == last or before.shape != state.shape:
        return state
    return state + (value - last) / (last - first) * (state - before)


def evaluate(
    family: Family, check: Callable[..., Result], begun: tuple[float, Floats | None]
) -> Result:
    """The answer at one value of a family, from a rest state (n, 6) there."""
    value, start = begun
    model = family(value)
    # a model of a parameter may have other blocks
    alike = start is not None and len(start) == len(model.assembly)
    return check(model, start=start) if alike else check(model)


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
