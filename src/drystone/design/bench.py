"""The bench on which changes of one region are tried, and the least value that holds it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.progress import Stopped
from drystone.design.changes import Change, Surgery
from drystone.design.diagnosed import Region
from drystone.design.margin import LARGE_REGION, DesignMargin, quick_check, rest_found
from drystone.design.regions import interfaces_of, local_model
from drystone.design.search import least
from drystone.design.words import joint_name, names_of
from drystone.model import Model
from drystone.results import Result, Verdict

MANY = 4
"""Largest number of blocks of a region with which every joint and every block is tried alone.
Chosen. In a larger region all joints, or all blocks, are changed together."""

ALL = LARGE_REGION
"""Largest number of blocks of a region whose joints or blocks are all cut anew together, and that
is held by several props. Chosen: a cut takes a twentieth of a second, and each prop is checked."""


_Near: TypeAlias = list[dict[int, Floats]] | None
"""Rest states of the last model that stood, in each case of the margin."""


@dataclass(frozen=True)
class Tried(OneLine):
    """A kind of mend that does not hold a region.

    Attributes
    ----------
    kind
    what
        What was tried, and how far.
    """

    kind: str
    what: str


class Bench:
    """Search for the mends of one region.

    Parameters
    ----------
    model
    motion : (n, 6)
        First motion of its blocks.
    region
    margin
    keep
        Positions of blocks that may not be changed.
    stop
        Called often; True ends the search.
    """

    def __init__(
        self,
        model: Model,
        motion: Floats,
        region: Region,
        margin: DesignMargin,
        keep: frozenset[int],
        stop: Callable[[], bool] | None = None,
    ) -> None:
        self.model = model
        self.region = region
        self.margin = margin
        self.local, self.blocks = local_model(self.model, region.blocks)
        self.interfaces: Ints = np.flatnonzero(interfaces_of(self.model, region.blocks))
        self.motion = motion
        self.keep = keep
        self.stop = stop
        self.tried: list[Tried] = []
        self.own = list(range(len(region.blocks)))
        before = region.local
        # where supports have moved, blocks are diagnosed where they fall; what a region that stands
        # alone needs is not known
        self.as_diagnosed = (
            region.verdict is not Verdict.STABLE
            and before.contacts.count == self.local.contacts.count
            and np.array_equal(before.assembly.centroid, self.local.assembly.centroid)
        )

    def nearby(self) -> _Near:
        """Rest states for a search over one value; none in a small region."""
        return [] if len(self.own) > ALL else None

    def stands(self, make: Surgery, near: _Near = None, beyond: Sequence[int] = ()) -> bool:
        """Whether the local model stands after a change; False if the change is impossible."""
        try:
            changed = self.changed(make, beyond)
        except InputError:
            return False
        return self.keeps_margin(changed, quick=True, near=near)

    def keeps_margin(self, model: Model, *, quick: bool = False, near: _Near = None) -> bool:
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

    def holds(self, model: Model, margin: DesignMargin | None = None) -> Result:
        """The check of a model at the margin, or at another one.

        Raises
        ------
        Stopped
            As above.
        """
        result = (margin or self.margin).holds(model, self.stop)
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
        near, steps = self.nearby(), change.steps
        if np.isfinite(below):
            steps = (*(x for x in steps if x < below), below - change.close)

        def stands(value: float) -> bool:
            return self.stands(change.make(value), near, change.beyond)

        return least(stands, steps, change.close, change.low)

    def holding(
        self, kind: str, changes: Sequence[Change], why: str
    ) -> Iterator[tuple[Change, float]]:
        """The changes that hold the region, with their least values; else why none does."""
        held = False
        for change in changes:
            value = self.least(change)
            if value is not None:
                held = True
                yield change, value
        if not held:
            self.fail(kind, why, *(one.make(one.steps[-1]) for one in changes))

    def from_known(self, change: Change, known: float | None) -> list[Change]:
        """The change from what a diagnosis found without a margin; none where it found nothing."""
        if not self.as_diagnosed:
            return [change]
        return [] if known is None else [change.above(known)]

    def largest_forces(self, make: Surgery, count: int) -> tuple[Floats, Floats]:
        """The largest force at the last joints of the local model after a change, at the margin.

        Returns
        -------
        size : (count,) [N]
        point : (count, 3) [m]
            Where it acts.
        """
        made = self.changed(make)
        size, point = np.full(count, -1.0), np.zeros((count, 3))
        for case in (made, *self.margin.cases(made)):
            found = rest_found(case, self.stop).resultants
            now = np.linalg.norm(found.force[-count:], axis=1)
            point[now > size] = found.position[-count:][now > size]
            size = np.maximum(size, now)
        return size, point

    def may_change(self, interface: int) -> bool:
        """Whether both blocks at an interface of the local model may be changed."""
        contacts = self.local.contacts
        ends = (contacts.block_a[interface], contacts.block_b[interface])
        return not any(int(self.blocks[end]) in self.keep for end in ends)

    def kept(self, *blocks: Ints) -> str:
        """The names of those of some blocks of the local model that may not be changed."""
        some = {int(self.blocks[i]) for group in blocks for i in group} & self.keep
        return names_of(self.model, sorted(some)) if some else ""

    def joint_name(self, interface: int) -> str:
        """A joint as text: lower, upper or inner, and the other block."""
        return joint_name(self.local, self.own, interface)

    def fail(self, kind: str, what: str, *nearest: Surgery) -> None:
        """Note a kind of mend that does not hold the region, and how close it came.

        Parameters
        ----------
        kind, what
        nearest
            The changes that went farthest; of a large region only the first one is examined.
        """
        some = nearest if len(self.own) <= ALL else nearest[:1]
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
        prop = quick_check(changed, self.stop).prop
        load = np.linalg.norm(changed.load.wrench[changed.assembly.free, :3], axis=1).sum()
        if prop is None or load == 0.0:
            return None
        return min(float(np.linalg.norm(prop[:, :3], axis=1).sum() / load), 1.0)


def volume_changed(before: Model, after: Model) -> float:
    """Volume [m3] of the differences between equally named blocks, and of other blocks."""
    old = dict(zip(before.assembly.names, before.assembly.volume.tolist(), strict=True))
    new = dict(zip(after.assembly.names, after.assembly.volume.tolist(), strict=True))
    names = set(old) | set(new)
    return float(sum(abs(new.get(name, 0.0) - old.get(name, 0.0)) for name in names))
