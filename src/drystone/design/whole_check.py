"""Changes that hold a region, checked on the whole structure."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import named
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Stopped
from drystone.design.bench import Bench, Tried, volume_changed
from drystone.design.changed import Changed, Kept
from drystone.design.changes import Change
from drystone.design.diagnosed import Region
from drystone.design.margin import DesignMargin
from drystone.design.mend_kinds import MAKERS
from drystone.design.search import bracket
from drystone.model import Model
from drystone.results import Result

JOINT, ADDED, VOLUME, FRICTION = 1.0, 2.0, 10.0, 5.0
"""Costs: of a changed joint, of an added part, of a change of the whole volume of a region, and of
an increase of a friction coefficient by 1. Chosen: to change a joint costs less than an additional
part, and a tenth of the volume costs as much as a joint."""

SETTLED = 2.0
"""Cost of standing only after settling, where standing for all contact stiffnesses is asked for and
no value gives it. As much as an additional part: a mend that does is preferred."""


def mends_of_kind(
    model: Model,
    motion: Floats,
    region: Region,
    margin: DesignMargin,
    keep: frozenset[int],
    held: list[int],
    clock: Clock,
    kind: str,
) -> tuple[list[Changed], list[Tried]]:
    """The mends of one kind for a region, and what was tried without success."""
    bench = Bench(model, motion, region, margin, keep, clock.late)
    made = []
    with contextlib.suppress(Stopped):
        for change, value in MAKERS[kind](bench):
            found = WholeCheck(model, bench, change, value, held).mend()
            if found is not None:
                made.append(found)
    return made, bench.tried


class _Held(NamedTuple):
    """The structure with a change that holds it, at least after settling where it ``settles``."""

    value: float
    model: Model
    result: Result
    settles: bool


class WholeCheck:
    """The check of a change on the whole structure.

    If the least value of the local model is not sufficient for the whole structure, a larger one is
    searched.

    Parameters
    ----------
    model, bench, candidate
    value
        The least one with which the region alone stands.
    held
        Blocks of other regions, which are held meanwhile.
    """

    def __init__(
        self, model: Model, bench: Bench, candidate: Change, value: float, held: list[int]
    ) -> None:
        self.model = model
        self.bench = bench
        self.candidate = candidate
        self.held = tuple(model.assembly.names[i] for i in held)
        self.near = bench.nearby()
        # a large model that does not stand for all stiffnesses is not followed while it settles
        self.sieved = bench.margin.robust and self.near is not None
        self.why: dict[float, str] = {}
        self.least = self.largest = value

    def mend(self) -> Changed | None:
        """The change with the least value that holds the structure; ``None`` if it falls."""
        found = self._least()
        if found is None:
            self.bench.tried.append(Tried(self.candidate.kind, self._falls()))
            return None
        model, candidate, made = self.model, self.candidate, found.model
        blocks = self.bench.region.blocks
        volume = volume_changed(model, made)
        whole = float(model.assembly.volume[list(blocks)].sum())
        cost = SETTLED if found.settles else 0.0
        cost += JOINT * candidate.joints + ADDED * candidate.added + VOLUME * volume / whole
        if candidate.kind == "friction":
            gained = np.asarray(made.contacts.friction) - np.asarray(model.contacts.friction)
            cost += FRICTION * float(gained.sum())
        how = ", which holds only after settling" if found.settles else ""
        kept = Kept(
            candidate.kind,
            tuple(model.assembly.names[i] for i in blocks),
            candidate.words(found.value) + how,
            found.value,
            candidate.joints,
            candidate.added,
            volume,
            cost,
            self._still(made),
        )
        held = f" ({named(kept.held)} held meanwhile)" if kept.held else ""
        words = kept.description + held
        return Changed(model, made, found.result, found.result.stable, words, (kept,))

    def _least(self) -> _Held | None:
        """The least value with which the structure stands."""
        low = self.least
        # cheap first: what falls with uniform stiffness does not stand for all
        if self.sieved and not self._stands(low, quick=True):
            high = self._larger(low, quick=True)
            if high is None:
                return self._settled(low)
            low = high
        found = self._checked(low)
        if found is None:
            high = self._larger(low, quick=False)
            found = None if high is None else self._checked(high)
        return found or self._settled(low)

    def _falls(self) -> str:
        """Why no value holds the structure."""
        first, why = self.least, self.why
        if first not in why:
            self._checked(first)
        what = f"{self.candidate.words(first)} holds the region, but of the whole: {why[first]}"
        if self.largest > first:
            last = f" ({why[self.largest]})" if self.largest in why else ""
            words = self.candidate.words(self.largest)
            what += f"; larger values do not hold it either, up to: {words}{last}"
        return what

    def _changed(self, value: float) -> tuple[Model, Model] | None:
        """The whole model with the change, and the same with other regions held."""
        self.largest = max(self.largest, value)
        try:
            change = self.candidate.make(value)
            made = change(self.model, self.bench.blocks, self.bench.interfaces)
        except InputError as error:
            self.why[value] = str(error)
            return None
        still = self._still(made)
        fixed = [made.assembly.names[i] for i in np.flatnonzero(made.assembly.fixed)]
        return made, made.with_supports([*fixed, *still]) if still else made

    def _still(self, made: Model) -> tuple[str, ...]:
        """Those of the held blocks that are left after the change."""
        return tuple(name for name in self.held if name in made.assembly)

    def _stands(self, value: float, *, quick: bool) -> bool:
        both = self._changed(value)
        return both is not None and self.bench.keeps_margin(both[1], quick=quick, near=self.near)

    def _checked(self, value: float, *, settles: bool = False) -> _Held | None:
        """The structure at a value, if it stands at the margin, or at least after settling."""
        both, bench = self._changed(value), self.bench
        if both is None:
            return None
        if self.sieved and not settles and not bench.keeps_margin(both[1], near=self.near):
            return None
        margin = replace(bench.margin, robust=False) if settles else bench.margin
        result = bench.holds(both[1], margin)
        self.why[value] = result.message
        return _Held(value, both[0], result, settles) if margin.meets(result) else None

    def _larger(self, low: float, *, quick: bool) -> float | None:
        """The least value above one that falls."""
        most, close = self.candidate.steps[-1], self.candidate.close

        def stands(value: float) -> bool:
            return self._stands(value, quick=quick)

        while low + close < most:
            high = min(2.0 * low + close, most)
            if stands(high):
                return bracket(stands, low, high, close)[1]
            low = high
        return None

    def _settled(self, low: float) -> _Held | None:
        """A value above one that falls with which the structure stands after settling.

        A large structure is followed at that value only.
        """
        most, close = self.candidate.steps[-1], self.candidate.close
        if not self.bench.margin.robust:
            return None
        if self.sieved:
            return self._checked(low, settles=True)
        found, high = None, low
        while found is None and high + close < most:
            low, high = high, min(2.0 * high + close, most)
            found = self._checked(high, settles=True)
        if found is None:
            return None
        return self._checked(0.5 * (low + high), settles=True) or found
