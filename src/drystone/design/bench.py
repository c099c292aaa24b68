"""The bench on which changes of one region are tried, and the least values that hold it."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.settings import Stopped
from drystone.design.changes import Change, Surgery
from drystone.design.margin import (
    LARGE_REGION,
    SMALL_REGION,
    SPARE,
    DesignMargin,
    quick_check,
    rest_found,
    soon_at_rest,
)
from drystone.design.regions import interfaces_of, local_model
from drystone.design.search import bracket, least, least_from_above
from drystone.design.words import joint_name, names_of
from drystone.model import Model
from drystone.results import Result
from drystone.stability.problem import proves_fall

Near: TypeAlias = list[dict[int, Floats]]
"""Rest states of the last model that stood, in each case of the margin."""

Held: TypeAlias = tuple[Change, float]
"""A change and the least value with which it holds a region."""


@dataclass(frozen=True)
class Tried(OneLine):
    """A kind of mend that does not hold a region.

    Attributes
    ----------
    kind
    what
        What was tried, and how far.
    skipped
        Where it was not tried: on so many blocks, or with blocks that are kept.
    less
        The mend that holds with a smaller margin, and that margin; empty where none was found.
    only
        Where it holds the region, what is then said of the whole: that it falls, or how its joints
        would have to fit; else empty.
    """

    kind: str
    what: str
    skipped: str = ""
    less: str = ""
    only: str = ""


_HARD = 3.0
"""A region jams where a joint presses with this many times its load, and it falls with
:data:`SPARE` of the friction."""


ALIKE = 1e-3
"""What is alike differs by less than this share: joints, blocks, mends. Chosen."""


def first_alike(numbers: Sequence[Floats]) -> list[int]:
    """Of each row the position of the first row whose numbers are alike."""
    firsts: dict[int, Floats] = {}
    found = []
    for i, row in enumerate(numbers):
        same = (k for k, one in firsts.items() if np.allclose(one, row, rtol=ALIKE, atol=0.0))
        found.append(next(same, i))
        firsts.setdefault(found[-1], row)
    return found


class Jam(NamedTuple):
    """How a region jams: its joints press each other, and friction alone holds it.

    Attributes
    ----------
    times
        Largest force of a joint by the load of the region.
    less
        Share by which its friction is less where it falls.
    """

    times: float
    less: float

    def __str__(self) -> str:
        less = f"falls with {100.0 * self.less:.0f} % less friction"
        return f", but jams: it presses with {self.times:.2g} times the weight, and {less}"


class Bench:
    """The local model of a region, on which changes are tried.

    Parameters
    ----------
    model
    region
        Positions of its blocks.
    motion : (n, 6)
        First motion of the blocks of the model.
    margin
    keep
        Positions of blocks that may not be changed.
    stop
        Called often; True ends the search.
    fall
        A mechanism (r, 6) of the local model, if it is known: what falls by it is not tried.
    """

    def __init__(
        self,
        model: Model,
        region: Sequence[int],
        motion: Floats,
        margin: DesignMargin | None = None,
        keep: frozenset[int] = frozenset(),
        stop: Callable[[], bool] | None = None,
        fall: Floats | None = None,
    ) -> None:
        self.model, self.region, self.keep, self.stop = model, tuple(region), keep, stop
        self.margin = DesignMargin() if margin is None else margin
        self.local, self.blocks = local_model(model, region)
        self.interfaces: Ints = np.flatnonzero(interfaces_of(model, region))
        self.motion = motion[self.blocks]
        self.own = list(range(len(region)))
        self.large = len(region) > LARGE_REGION
        self.tried: list[Tried] = []
        self.near = False  # whether a change holds the region without the margin
        self.rests: Near = []
        self.fall = fall

    def stands(self, make: Surgery, near: Near | None = None, beyond: Sequence[int] = ()) -> bool:
        """Whether the local model stands after a change; False if the change is impossible."""
        try:
            changed = self.changed(make, beyond)
        except InputError:
            return False
        return not self._falls(changed) and self.keeps_margin(changed, quick=True, near=near)

    def _falls(self, changed: Model) -> bool:
        """Whether a changed model falls by the known mechanism, what was added at rest."""
        if self.fall is None or len(changed) < len(self.fall):
            return False
        motion = np.zeros((len(changed), 6))
        motion[: len(self.fall)] = self.fall
        motion[changed.assembly.fixed] = 0.0
        return proves_fall(changed, motion)

    def keeps_margin(self, model: Model, *, quick: bool = False, near: Near | None = None) -> bool:
        """Whether a model stands at the margin; ``near`` as for :meth:`DesignMargin.stands`.

        Raises
        ------
        Stopped
            The search is to end; what was found by then says nothing.
        """
        stands = self.margin.stands(model, quick=quick, stop=self.stop, near=near)
        if not stands and self.stop is not None and self.stop():
            raise Stopped
        return stands

    def holds(self, model: Model, margin: DesignMargin, near: Near | None = None) -> Result:
        """The check of a model at a margin; ``near`` as for :meth:`DesignMargin.holds`.

        Raises
        ------
        Stopped
            As above.
        """
        result = margin.holds(model, self.stop, near=near)
        if result.stopped:
            raise Stopped
        return result

    def changed(self, make: Surgery, beyond: Sequence[int] = ()) -> Model:
        """The local model after a change, with blocks beyond the region where it uses them."""
        local, count = self.local, len(self.blocks)
        if beyond:
            local = self.model.subset([*self.blocks.tolist(), *beyond])
            local = local.with_supports(list(range(len(self.own), len(local))))
        return make(local, np.arange(count), np.arange(len(self.interfaces)))

    def least(self, change: Change, below: float = np.inf) -> float | None:
        """The least value of a change with which the local model stands, below another one."""
        self.rests, steps = [] if change.rest is None else [{0: change.rest}], change.steps
        if np.isfinite(below):
            steps = (*(x for x in steps if x < below), below - change.close)
            steps = tuple(x for x in steps if x >= change.low)

        def stands(value: float) -> bool:
            if not self.large:  # few blocks are at rest as soon from nothing
                self.rests = []
            return self.stands(change.make(value), self.rests, change.beyond)

        search = least_from_above if self.large and change.grows else least
        found = search(stands, steps, change.close, change.low)
        return None if found is None or found >= below else found

    def smallest(self, changes: Iterable[Change]) -> Held | None:
        """The change that holds the region with the smallest value."""
        best: Held | None = None
        for change in changes:
            value = self.least(change, np.inf if best is None else best[1])
            best = best if value is None else (change, value)
        return best

    def largest_forces(self, change: Change) -> tuple[Floats, Floats]:
        """The largest force at the joints that a single change adds, which was tried last.

        Returns
        -------
        force : (count, 3) [N]
            On the blocks that were there.
        point : (count, 3) [m]
            Where it acts.
        """
        before = self.changed(lambda model, *_: model, change.beyond)
        made = self.changed(change.make(0.0), change.beyond)
        count = made.contacts.count - before.contacts.count
        force, point = np.zeros((2, count, 3))
        for number, case in enumerate((made, *self.margin.cases(made))):
            start = self.rests[number].get(0) if self.rests else None
            found = rest_found(case, self.stop, start).resultants
            now, at = found.force[-count:], found.position[-count:]
            larger = np.linalg.norm(now, axis=1) > np.linalg.norm(force, axis=1)
            force[larger], point[larger] = now[larger], at[larger]
        return force, point

    def jam(self, change: Change, value: float) -> Jam | None:
        """How the local model jams after a change that holds it; a large one is not examined."""
        if self.large:
            return None
        try:
            made = self.changed(change.make(value), change.beyond)
        except InputError:  # it is possible on the whole model only
            return None
        load = np.linalg.norm(made.load.wrench[made.assembly.free, :3].sum(axis=0))
        forces = rest_found(made, self.stop).resultants.force
        most = np.linalg.norm(forces, axis=1).max(initial=0.0)

        def stands(share: float) -> bool:
            rough = share * made.contacts.friction
            return soon_at_rest(made.with_friction(rough), self.stop).stable

        if most <= _HARD * load or not load or stands(SPARE):
            return None
        return Jam(float(most / load), 1.0 - bracket(stands, SPARE, 1.0, 0.01)[0])

    def kept_at(self, interfaces: Sequence[int]) -> str:
        """The names of blocks at interfaces of the local model that may not be changed."""
        contacts = self.local.contacts
        some = list(interfaces)
        return self.kept([*contacts.block_a[some].tolist(), *contacts.block_b[some].tolist()])

    def kept(self, blocks: Sequence[int]) -> str:
        """The names of those of some blocks of the local model that may not be changed."""
        some = {int(self.blocks[i]) for i in blocks} & self.keep
        return names_of(self.model, sorted(some)) if some else ""

    def joint_name(self, interface: int) -> str:
        """A joint as text: lower, upper or inner, its block, and the other block."""
        return joint_name(self.local, self.own, interface, whole=True)

    def alike(self) -> list[dict[int, float]]:
        """Joints of a small region that are alike, two or more, as those at both ends of a board.

        They may be changed, have one area, and their blocks are of equal volumes. Each has its
        side: 1 where its first block is of the region, and the other is not, or is smaller; else
        -1.
        """
        count = self.local.contacts.count if len(self.own) <= SMALL_REGION else 0
        sided = [self._sided(k) for k in range(count)]
        groups: dict[int, dict[int, float]] = {}
        for k, first in enumerate(first_alike([numbers for numbers, _ in sided])):
            groups.setdefault(first, {})[k] = sided[k][1]
        return [one for one in groups.values() if len(one) > 1 and not self.kept_at(list(one))]

    def _sided(self, interface: int) -> tuple[Floats, float]:
        """What joints that are alike have in common (4,), and the side of one, as above."""
        contacts, volume = self.local.contacts, self.local.assembly.volume
        a, b = int(contacts.block_a[interface]), int(contacts.block_b[interface])
        inner, outer = (int(i < len(self.own)) for i in (a, b))
        first = (inner, volume[a]) > (outer, (1.0 - ALIKE) * volume[b])
        ends = [a, b] if first else [b, a]
        like = np.array([contacts.area[interface], *volume[ends], inner + outer])
        return like, 1.0 if first else -1.0

    def joints_named(self, interfaces: Sequence[int]) -> str:
        """Joints that are alike as text: two by their names, more by the first one."""
        first, *others = (self.joint_name(k).rstrip(",") for k in interfaces)
        return f"{first} and {others[0]}" if len(others) == 1 else (
            f"{len(others) + 1} joints like {first}"
        )  # fmt: skip

    def fail(self, kind: str, what: str, *nearest: Surgery) -> None:
        """Note a kind of mend that does not hold the region, and how close it came.

        Parameters
        ----------
        kind, what
        nearest
            The changes that went farthest; of a large region they are not examined, which would
            take as long as the search of the kind.
        """
        some = () if self.large else nearest
        shares = [share for share in map(self._not_carried, some) if share is not None]
        if shares:
            least = 100.0 * min(shares)
            if least >= 1.0:
                what += f"; {least:.0f} % of its load is then still not carried"
            else:
                what += "; its load is then carried, but it is not at rest"
        self.tried.append(Tried(kind, what))

    def _not_carried(self, make: Surgery) -> float | None:
        """Share of the load of the region that nothing carries after a change, if it then falls."""
        try:
            changed = self.changed(make)
        except InputError:
            return None
        result = quick_check(changed, self.stop)
        self.near, prop = self.near or result.stable, result.prop
        load = np.linalg.norm(changed.load.wrench[changed.assembly.free, :3], axis=1).sum()
        if prop is None or load == 0.0:
            return None
        return min(float(np.linalg.norm(prop[:, :3], axis=1).sum() / load), 1.0)


class Take(enum.Enum):
    """Which of some changes that hold a region are told."""

    EACH = enum.auto()
    FIRST = enum.auto()
    SMALLEST = enum.auto()


@dataclass(frozen=True, eq=False)
class Tries:
    """Changes of one kind that are tried, and what is said if none of them holds the region.

    Attributes
    ----------
    changes
    why
        Empty where nothing is said.
    take
    known
        The least values that the diagnosis found without a margin, ``None`` where it found none;
        where left out it did not look for them. Searches that begin there save a tenth of the time
        of all mends.
    last
        Whether they are tried only where none before them holds it.
    told
        Makes the change that is said from the one that holds it.
    """

    changes: Sequence[Change]
    why: str
    take: Take = Take.EACH
    known: Sequence[float | None] | None = None
    last: bool = False
    told: Callable[[Change], Held] | None = None


Proposals: TypeAlias = Iterator[Tries | Tried | str]
"""Changes to try, and why others are not tried."""


def held_by(bench: Bench, kind: str, proposals: Proposals, known: bool) -> Iterator[Held]:
    """The changes of a kind that hold a region, with their least values; else it is noted why.

    ``known``: whether the least values without a margin are those of its local model.
    """
    holds = False
    for tries in proposals:
        if isinstance(tries, Tried):
            bench.tried.append(tries)
        elif isinstance(tries, str):
            bench.fail(kind, tries)
        elif not (tries.last and holds):
            found = _held(bench, tries, known)
            holds = holds or bool(found)
            yield from found
            if not found and tries.why:
                bench.fail(kind, tries.why, *(one.make(one.steps[-1]) for one in tries.changes))


def _held(bench: Bench, tries: Tries, known: bool) -> list[Held]:
    """Those of some changes that hold a region."""
    changes = list(tries.changes)
    if known and tries.known is not None:
        pairs = zip(changes, tries.known, strict=True)
        changes = [change.above(value) for change, value in pairs if value is not None]
    if tries.take is Take.SMALLEST:
        best = bench.smallest(changes)
        return [] if best is None else [best]
    found: list[Held] = []
    for change in changes:
        value = bench.least(change)
        if value is not None:
            found.append((change, value) if tries.told is None else tries.told(change))
            if tries.take is Take.FIRST:
                break
    return found
