"""Changes that hold a region, checked on the whole structure."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.base.errors import InputError
from drystone.base.settings import Clock, Stopped
from drystone.base.units import mass, quantity
from drystone.design.bench import Bench, Near, Tried
from drystone.design.changed import Changed, Kept, free_mass
from drystone.design.changed_model import acceleration_of
from drystone.design.changes import Change
from drystone.design.diagnosis import Region
from drystone.design.margin import DesignMargin
from drystone.design.mend_kinds import holding
from drystone.design.needs import KnownNeeds
from drystone.design.search import bracket, least
from drystone.model import Model
from drystone.results import Result, Verdict

JOINT, ADDED, VOLUME, FRICTION = 1.0, 2.0, 10.0, 5.0
"""Costs: of a changed joint, of an added part, of a change of the whole volume of a region, or of
weights as heavy as it, and of an increase of a friction coefficient by 1. Chosen: to change a joint
costs less than an additional part, and a tenth of the volume costs as much as a joint. Where no
value makes it stand for all contact stiffnesses that are asked for, standing after settling costs
as much as an added part."""


_PARTS = 16
"""Parts of a margin of which fewer are tried, where it is not kept. Chosen: four searches."""


def mends_of_kind(
    model: Model,
    motion: Floats,
    region: Region,
    margin: DesignMargin,
    keep: frozenset[int],
    held: list[int],
    crossed: Callable[[Changed, Clock], Changed],
    clock: Clock,
    kind: str,
) -> tuple[list[Changed], list[Tried]]:
    """The mends of one kind for a region, and what was tried without success.

    Where a kind holds it without the margin only, the largest part of the margin that it keeps is
    searched, and told where the model falls without it. ``motion`` (n, 6) is the first one of all
    blocks, ``held`` are those of other regions. ``crossed`` says whether a mend stands elsewhere
    too, under a train that moves.
    """

    def at(part: DesignMargin) -> Bench:
        fall = region.fall_for(kind)
        return Bench(model, region.blocks, motion, part, keep, clock.late, fall)

    clock.tell(f"a mend is sought: {kind}", 0, 1)
    bench = at(margin)
    made = _of_kind(bench, region, held, clock, kind, crossed)
    if made or bench.large or not bench.near or margin == margin.eased(1.0):
        return made, bench.tried
    told = [""]

    def holds(less: float) -> bool:
        part = margin.eased(less)
        found = _of_kind(at(part), region, held, clock, kind)
        if found and not part.stands(model, quick=True, stop=clock.late):
            kept = min((one.change for one in found), key=lambda one: one.cost)
            told.append(f"with {part.words}: {kept.description} (cost {kept.cost:.3g})")
        return bool(found)

    bracket(holds, 0.0, 1.0, 1.0 / _PARTS, clock.late)
    return made, [*bench.tried[:-1], *(replace(one, less=told[-1]) for one in bench.tried[-1:])]


def _of_kind(
    bench: Bench,
    region: Region,
    held: list[int],
    clock: Clock,
    kind: str,
    crossed: Callable[[Changed, Clock], Changed] = lambda made, _: made,
) -> list[Changed]:
    """The mends of one kind that hold a region and the whole."""
    before = region.local
    # where supports have moved, blocks are diagnosed where they fall; what a region that stands
    # alone needs is not known
    known = (
        region.verdict is not Verdict.STABLE
        and before.contacts.count == bench.local.contacts.count
        and np.array_equal(before.assembly.centroid, bench.local.assembly.centroid)
    )
    made = []
    with contextlib.suppress(Stopped):
        for change, value in holding(kind, KnownNeeds(bench, region.needs, known)):
            clock.tell(f"{change.words(value)} holds it alone; now the whole", 0, 1)
            whole = _WholeCheck(bench, change, value, held)
            found = whole.mend()
            if found is not None:
                made.append(whole.crossed(found, lambda one: crossed(one, clock)))
    return made


class _Held(NamedTuple):
    """The structure with a change that holds it, at least after settling where it ``settles``."""

    value: float
    model: Model
    result: Result
    settles: bool


class _WholeCheck:
    """The check of a change on the whole structure.

    If the least value of the local model is not sufficient for the whole structure, a larger one is
    searched.

    Parameters
    ----------
    bench, candidate
    value
        The least one with which the region alone stands.
    held
        Blocks of other regions, which are held meanwhile.
    """

    def __init__(self, bench: Bench, candidate: Change, value: float, held: list[int]) -> None:
        self.bench, self.candidate, self.first = bench, candidate, value
        self.held = tuple(bench.model.assembly.names[i] for i in held)
        self.near = self._rests()
        self.why: dict[float, str] = {}
        self.stood: dict[float, Result] = {}
        self.largest = value
        self.sensitive = False  # whether it stands for some contact stiffnesses

    def _rests(self) -> Near:
        """Where a large region rests after the change, if no other blocks move."""
        bench, model = self.bench, self.bench.model
        if not bench.large or self.candidate.beyond:
            return []

        def placed(local: Floats) -> Floats:
            own, added = np.split(local, [len(bench.blocks)])
            whole = np.concatenate([np.zeros((len(model), 6)), added])
            whole[bench.blocks] = own
            return whole

        return [{k: placed(motion) for k, motion in rests.items()} for rests in bench.rests]

    def mend(self) -> Changed | None:
        """The change with the least value that holds the structure; ``None`` if it falls."""
        found = self._least()
        if found is None:
            self.bench.tried.append(self._falls())
            self.bench.near = True
        return None if found is None else self._made(found)

    def crossed(self, made: Changed, crossed: Callable[[Changed], Changed]) -> Changed:
        """A mend as it stands elsewhere; a little more of it, where that stands there and it not.

        One, three and seven widths of the search more are tried.
        """
        told, most, value = crossed(made), self.candidate.steps[-1], made.change.value
        width = self.candidate.close or 0.01 * value
        for more in (1.0, 3.0, 7.0):
            if told.stands or not made.stands or value + more * width > most:
                break
            found = self._checked(value + more * width)
            larger = told if found is None else crossed(self._made(found))
            told = larger if larger.stands else told
        return told

    def _made(self, found: _Held) -> Changed:
        """The structure with the change, in words and with its cost."""
        bench, candidate, model, made = self.bench, self.candidate, self.bench.model, found.model
        volume = _volume_changed(model, made)
        was, now = mass(free_mass(model)), mass(free_mass(made))
        how = f"; free mass from {was} to {now}" if was != now else ""
        how += ", which holds only after settling" if found.settles else ""
        how += self._sized(found)
        jam = bench.jam(candidate, found.value)
        how += str(jam or "")
        kept = Kept(
            candidate.kind,
            tuple(model.assembly.names[i] for i in bench.region),
            candidate.words(found.value) + how,
            found.value,
            candidate.joints,
            candidate.added,
            volume,
            self._cost(found, volume),
            self._still(made),
            jam.times if jam else 0.0,
        )
        stands = found.result.stable and not kept.held
        return Changed(model, made, found.result, stands, kept.description, (kept,))

    def _cost(self, found: _Held, volume: float) -> float:
        """As :data:`JOINT` and what is beside it; volume [m3] is what changed of it."""
        before, made, one = self.bench.model, found.model, self.candidate
        own = before.assembly.subset(list(self.bench.region))
        cost = JOINT * one.joints + ADDED * (one.added + found.settles)
        cost += VOLUME * (volume + _volume_moved(before, made)) / float(own.volume.sum())
        if one.kind == "friction":
            cost += FRICTION * float((made.contacts.friction - before.contacts.friction).sum())
        if one.kind == "ballast":
            weight = math.hypot(*acceleration_of(before)) * float(own.mass.sum())
            cost += VOLUME * one.added * found.value / weight
        return cost

    def _sized(self, found: _Held) -> str:
        """What posts bear that do not give: the largest force of one in the whole.

        There the blocks around the region give way too. With a margin only if it is more than told.
        """
        if self.candidate.kind != "prop":
            return ""
        count = self.candidate.added
        most = float(lengths(found.result.resultants.force[-count:]).max())
        if self.bench.margin != DesignMargin() and count * most <= 1.005 * found.value:
            return ""
        bears = "bears at most" if count > 1 else "bears"
        return f"; a post that does not give {bears} {quantity(most, 'N')}"

    def _least(self) -> _Held | None:
        """The structure with the least value with which it stands, else stands after settling."""
        found = self._checked(self.first)
        if found is None:
            close = self.candidate.close
            value = least(self._stands, [*self._larger()], close, self.first)
            found = None if value is None else self._checked(value)
        return found or self._settled()

    def _larger(self) -> Iterator[float]:
        """Values above the first one: each doubled, up to the largest one."""
        high, most, close = self.first, self.candidate.steps[-1], self.candidate.close
        while high + close < most:
            high = min(2.0 * high + close, most)
            yield high

    def _settled(self) -> _Held | None:
        """A value with which the structure stands after settling.

        It is halved once only: each check follows the blocks. A large structure is followed at the
        first value only.
        """
        if not self.bench.margin.robust:
            return None
        if self.bench.large:
            return self._checked(self.first, settles=True)
        low = self.first
        for high in self._larger():
            found = self._checked(high, settles=True)
            if found is not None:
                return self._checked(0.5 * (low + high), settles=True) or found
            low = high
        return None

    def _falls(self) -> Tried:
        """Why no value holds the structure."""
        first, why = self.first, self.why
        if first not in why:
            self._checked(first, settles=True)
        only = "the whole still falls"
        if self.sensitive:
            only = "the whole stands only if all its joints fit equally well"
        what = f"{self.candidate.words(first)} holds the region, but {only}: {why[first]}"
        if self.largest > first:
            last = f" ({why[self.largest]})" if self.largest in why else ""
            words = self.candidate.words(self.largest)
            what += f"; larger values do not hold it either, up to: {words}{last}"
        return Tried(self.candidate.kind, what, only=only)

    def _changed(self, value: float) -> tuple[Model, Model] | None:
        """The whole model with the change, and the same with other regions held."""
        self.largest = max(self.largest, value)
        bench = self.bench
        try:
            made = self.candidate.make(value)(bench.model, bench.blocks, bench.interfaces)
        except InputError as error:
            self.why[value] = str(error)
            return None
        still = self._still(made)
        fixed = [made.assembly.names[i] for i in np.flatnonzero(made.assembly.fixed)]
        return made, made.with_supports([*fixed, *still]) if still else made

    def _still(self, made: Model) -> tuple[str, ...]:
        """Those of the held blocks that are left after the change."""
        return tuple(name for name in self.held if name in made.assembly)

    def _stands(self, value: float) -> bool:
        both = self._changed(value)
        return both is not None and self.bench.keeps_margin(both[1], near=self.near)

    def _checked(self, value: float, *, settles: bool = False) -> _Held | None:
        """The structure at a value, if it stands at the margin, or at least after settling."""
        both, bench = self._changed(value), self.bench
        if both is None:
            return None
        margin = replace(bench.margin, robust=False) if settles else bench.margin
        result = self.stood.get(value) if settles else None
        if result is None:
            # a large model that uniform stiffness does not hold is followed only to settle
            quick = bench.large and bench.margin.robust and not settles
            near = self.near if quick else None
            result = bench.holds(both[1], margin, near)
        if not bench.margin.cases(both[1]):
            self.stood[value] = result
        self.why[value] = result.message
        self.sensitive |= result.stable and not margin.meets(result)
        return _Held(value, both[0], result, settles) if margin.meets(result) else None


def _volume_moved(before: Model, after: Model) -> float:
    """Volume [m3] of the blocks that are moved as they are, times the way by the size of each."""
    moved = 0.0
    for block in before.assembly.blocks:
        if block.name in after.assembly:
            now = after.assembly.blocks[after.assembly.index(block.name)]
            if now is not block and len(now.vertices) == len(block.vertices):
                way = now.vertices - block.vertices
                if np.ptp(way, axis=0).max() < 1e-9 * block.size:
                    moved += block.volume * math.hypot(*way[0]) / block.size
    return moved


def _volume_changed(before: Model, after: Model) -> float:
    """Volume [m3] of the differences between equally named blocks, and of other blocks."""
    old = dict(zip(before.assembly.names, before.assembly.volume.tolist(), strict=True))
    new = dict(zip(after.assembly.names, after.assembly.volume.tolist(), strict=True))
    names = set(old) | set(new)
    return float(sum(abs(new.get(name, 0.0) - old.get(name, 0.0)) for name in names))
