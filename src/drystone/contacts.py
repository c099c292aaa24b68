"""Contacts: the planar interfaces between blocks, as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drystone.base.arrays import (
    Bools,
    Floats,
    Ints,
    frozen,
    frozen_floats,
    frozen_ints,
    frozen_points,
    lengths,
    one_or_each,
    whole,
)
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.ragged import Ragged, sum_by_owner
from drystone.geometry import facets
from drystone.geometry.frames import frames_from_normals, tributary_areas
from drystone.joint_capacity import DRY, NO_LIMIT, JointCapacity

DEFAULT_FRICTION = 0.6
"""Friction coefficient, chosen: the cautious end of dry stone on stone (0.6 to 0.75)."""
MOST_FRICTION = 1e50
"""Largest friction coefficient, chosen: the square of such a friction force fits a float."""
NOT_UNIT = 1e-4
"""Largest error of the products of the rows of a frame, chosen: forces are as wrong as that."""
DRAWN = 0.01
"""Size of the corners of a tie by that of its plate, chosen. Of what fill resists it is half."""


@dataclass(frozen=True, eq=False)
class Interface(OneLine):
    """One interface, as ``contacts[i]`` gives it.

    Attributes
    ----------
    blocks
        Positions of blocks a and b.
    frame : (3, 3)
        Rows n, u, v; n points from a to b.
    area : [m2]
    friction
    corners : (c, 3) [m]
        Counter-clockwise about n.
    """

    blocks: tuple[int, int]
    frame: Floats
    area: float
    friction: float
    corners: Floats


@dataclass(frozen=True, eq=False)
class Contacts(OneLine):
    """Planar interfaces between pairs of blocks; several per pair are normal.

    Parameters
    ----------
    block_a, block_b : (m,)
        Positions of the two blocks of each interface.
    frame : (m, 3, 3)
        Rows n, u, v: right-handed, unit, n from block a to block b.
    area : (m,) [m2]
    friction : (m,)
        Coulomb coefficient of each interface.
    point : (k, 3) [m]
        Interface corners, interface after interface, counter-clockwise about n: each interface is a
        simple polygon (three or more corners), a line (two) or a point (one). An overlap
        with a hole is stored as several interfaces.
    interface : (k,)
        Interface of each corner, ascending.
    capacity
        What joints carry beyond friction; ``None`` where all are dry.
    rod : (m,) [m], optional
        Length of each tie, from its corners on block b along n to its end on block a. Zero of
        others, and of what fill resists.

    Examples
    --------
    >>> from drystone import find_contacts
    >>> from drystone.models import tower
    >>> contacts = find_contacts(tower(3)).contacts
    >>> len(contacts), contacts[1].blocks, contacts[1].area
    (2, (1, 2), 1.0)
    """

    block_a: Ints
    block_b: Ints
    frame: Floats
    area: Floats
    friction: Floats
    point: Floats
    interface: Ints
    capacity: JointCapacity | None = None
    rod: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        block_a = frozen_ints(self.block_a, (None,), "block_a")
        m = len(block_a)
        checked: dict[str, Any] = {
            "block_a": block_a,
            "block_b": frozen_ints(self.block_b, (m,), "block_b"),
            "frame": _checked_frames(self.frame, m),
            "area": frozen_floats(self.area, (m,), "area"),
            "friction": check_friction(self.friction, m),
            "point": frozen_points(self.point, (None, 3), "point"),
            "interface": frozen_ints(self.interface, (None,), "interface"),
            "rod": frozen_floats(self.rod, (None,), "rod"),
        }
        rod, interface = checked["rod"], checked["interface"]
        checked["rod"] = frozen_floats(rod if len(rod) else np.zeros(m), (m,), "rod")
        if len(interface) != len(checked["point"]):
            raise InputError("point and interface differ in length")
        steps = np.diff(interface, prepend=-1, append=m)
        if not (steps[[0, -1]].all() and (steps & 1 == steps).all()):
            raise InputError("interface must be ascending, with a corner of each of the interfaces")
        if (checked["block_a"] == checked["block_b"]).any():
            raise InputError("an interface joins two different blocks")
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        if self.capacity is not None:
            found = len(self.capacity.tension)
            if found != m:
                raise InputError(f"there are {m} interfaces and {found} capacities")

    def _summary(self) -> str:
        return f"{counted(self.count, 'interface')}, {counted(self.corner_count, 'corner')}"

    @classmethod
    def empty(cls) -> Contacts:
        """No interface at all."""
        none = np.zeros(0, dtype=np.intp)
        return cls(
            none, none, np.zeros((0, 3, 3)), np.zeros(0), np.zeros(0), np.zeros((0, 3)), none
        )

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[Interface]:
        return (self[i] for i in range(self.count))

    def __getitem__(self, interface: int) -> Interface:
        """One interface by its position; negative positions count from the end."""
        i = whole(interface, "the position of an interface")
        if not -self.count <= i < self.count:
            raise InputError(f"there is no interface {i}", remedy=f"there are {self.count}")
        i %= self.count
        return Interface(
            (int(self.block_a[i]), int(self.block_b[i])),
            self.frame[i],
            float(self.area[i]),
            float(self.friction[i]),
            self.polygon(i),
        )

    @property
    def count(self) -> int:
        """Number of interfaces, m."""
        return len(self.block_a)

    @property
    def corner_count(self) -> int:
        """Number of interface corners, k."""
        return len(self.interface)

    @cached_property
    def highest_block(self) -> int:
        """Largest block index that occurs; -1 without contacts."""
        return max(int(end.max(initial=-1)) for end in (self.block_a, self.block_b))

    def require_blocks(self, count: int) -> None:
        """Refuse contacts of other blocks than the first ``count``.

        Raises
        ------
        InputError
        """
        if self.highest_block >= count:
            raise InputError(
                "the contacts name blocks that the assembly does not have",
                remedy="pass the contacts that were found on this assembly",
            )

    def flat_corners(self, which: Ints) -> tuple[Ragged, Ints, Floats]:
        """Of some interfaces (t,) the corners, their rows (l,), and places (l, 2) [m] along u, v.

        Places are from the centroids.
        """
        loops, row = self.corners.take(which)
        away = self.point[row] - loops.spread(self.centroid[which])
        return loops, row, np.einsum("kij,kj->ki", loops.spread(self.frame[which, 1:]), away)

    @cached_property
    def corners(self) -> Ragged:
        """Which corners belong to which interface."""
        return Ragged.from_owners(self.interface, self.count)

    @cached_property
    def corner_blocks(self) -> Ints:
        """(2, k) blocks a and b of each corner."""
        return frozen(np.array([self.block_a, self.block_b])[:, self.interface])

    @property
    def start(self) -> Ints:
        """(m + 1,) interface i has the corners start[i] to start[i + 1]."""
        return self.corners.start

    @cached_property
    def tributary(self) -> Floats:
        """(k,) [m2], the share of the interface's area that belongs to each corner.

        Points and lines enclose none: they have what is given, not the rounding of a polygon.
        """
        count = self.corners.counts[self.interface]
        share = tributary_areas(self.point, self.start)
        return frozen(np.where(count > 2, share, self.area[self.interface] / count))

    @cached_property
    def corner_capacity(self) -> tuple[Floats, Floats, Floats]:
        """Largest pull, cohesion and largest shear of each corner, (k,) [N] each; infinite without.

        A corner has the share of its tributary area. No pull exceeds that at which it slides open.
        """
        k = self.corner_count
        if self.capacity is None:
            return frozen(np.zeros(k)), frozen(np.zeros(k)), frozen(np.full(k, np.inf))
        joint, share = self.interface, self.corner_share
        given = self.capacity
        tension, cohesion, shear = (
            np.where(force[joint] >= NO_LIMIT, np.inf, force[joint] * share)
            for force in (given.tension, given.cohesion, given.shear)
        )
        friction = self.friction[joint]
        finite = (friction > 0.0) & (cohesion < NO_LIMIT)
        opens = np.where(finite, cohesion / np.where(finite, friction, 1.0), np.inf)
        return frozen(np.minimum(tension, opens)), frozen(cohesion), frozen(shear)

    @cached_property
    def crushes(self) -> Bools:
        """(m,) interfaces with a finite strength in compression."""
        if self.capacity is None:
            return np.zeros(self.count, dtype=bool)
        return self.capacity.compression < NO_LIMIT

    @cached_property
    def ties(self) -> Bools:
        """(m,) which are ties: faces drawn together, of more area than their corners enclose."""
        return self._drawn_together(4.0 * np.pi)

    @property
    def of_fill(self) -> Bools:
        """(m,) which ties are what fill resists: twice as much drawn together as others are.

        The area of square plates is ``2 / DRAWN**2`` times that square, or 8 with half of it.
        """
        return self._drawn_together(4.0 / DRAWN**2)

    def _drawn_together(self, times: float) -> Bools:
        """(m,) faces of more area than so many times the square of the reach of their corners."""
        away = lengths(self.point - self.centroid[self.interface])
        far = self.corners.max(away)
        return (self.corners.counts > 2) & (self.area > times * far**2)

    @property
    def tie_strength(self) -> Floats:
        """(m,) [N], the pull at which each tie yields: infinite without a limit, and of others."""
        none = np.full(self.count, np.inf)
        if self.capacity is None:
            return none
        whole = self.capacity.compression
        enclosed = self.corners.sum(self.tributary) / np.where(self.area > 0.0, self.area, 1.0)
        return np.where(self.ties & (whole < NO_LIMIT), whole * enclosed, none)

    @cached_property
    def dry(self) -> Bools:
        """(m,) interfaces that neither pull nor cohere, nor have a limit of shear."""
        if self.capacity is None:
            return np.ones(self.count, dtype=bool)
        rubs = ("tension", "cohesion", "shear")
        same = [getattr(self.capacity, name) == DRY[name] for name in rubs]
        return np.all(same, axis=0)

    @property
    def brittle(self) -> bool:
        """Whether some joints pull or cohere, and lose that where they crack."""
        return self.capacity is not None and self.capacity.law == "brittle"

    @property
    def plain(self) -> Bools:
        """(m,) interfaces that press and rub only, without any limit."""
        return self.dry & ~self.crushes

    def carried_to(self, others: Contacts) -> Contacts:
        """The interfaces of others, which are these and more of the same blocks, as strong."""
        if self.capacity is None or others.count == self.count:
            return others.with_capacity(self.capacity)
        more = others.select(np.arange(self.count, others.count)).with_capacity(None)
        return others.with_capacity(_joined_capacity(self, more))

    def with_areas(self, area: Floats, **changed: Any) -> Contacts:
        """The interfaces with other areas (m,) [m2], which bear the same stresses, and corners."""
        kept = self.capacity
        strong = None if kept is None else kept.on_faces(area, self.area)
        return replace(self, area=area, capacity=strong, **changed)

    def with_capacity(self, capacity: JointCapacity | None) -> Contacts:
        """The same interfaces with other capacities; dry ones with ``None``."""
        return replace(self, capacity=capacity)

    @cached_property
    def centroid(self) -> Floats:
        """(m, 3) [m], mean of each interface's corners, weighted with their tributary area."""
        weight = np.where(self.area[self.interface] > 0.0, self.tributary, 1.0)
        total = self.corners.sum(weight)
        return frozen(self.corners.sum(weight[:, None] * self.point) / total[:, None])

    @cached_property
    def corner_share(self) -> Floats:
        """(k,) tributary area of each corner by that of its interface; alike without area."""
        weight = np.where(self.area[self.interface] > 0.0, self.tributary, 1.0)
        return frozen(weight / self.corners.sum(weight)[self.interface])

    @cached_property
    def joint(self) -> Ints:
        """(m,) joint of each interface, numbered in their order.

        Interfaces of the same two blocks are one joint where they are connected along edges without
        a crease: the facets of a curved joint, or the parts of one with a hole. Each tie is one.
        """
        joint = np.arange(self.count, dtype=np.intp)
        pair = self.block_a * (self.highest_block + 1) + self.block_b
        plane = np.flatnonzero((self.corners.counts > 2) & ~self.ties)
        _, place, several = np.unique(pair[plane], return_inverse=True, return_counts=True)
        some = plane[several[place.ravel()] > 1]
        if len(some):
            part, row = self.corners.take(some)
            run = facets.smooth_runs(self.point[row], part.start, pair[some])
            first = np.unique(run, return_index=True)[1]
            joint[some] = some[first][run]
        return frozen(np.unique(joint, return_inverse=True)[1].ravel().astype(np.intp))

    @cached_property
    def joints(self) -> Contacts:
        """The joints as interfaces: of several facets the outline around them, in their mean plane.

        The area is that of all facets, the friction their mean, weighted by area.
        """
        count = np.bincount(self.joint)
        if len(count) == self.count:
            return self
        first = np.unique(self.joint, return_index=True)[1]
        several = np.flatnonzero(count > 1)
        area = self.area[first]
        area[several] = np.bincount(self.joint, self.area)[several]
        total = sum_by_owner(self.area[:, None] * self.frame[:, 0], self.joint, len(count))
        frame, point = self.frame[first], [self.polygon(i) for i in first.tolist()]
        normal = total[several] / np.linalg.norm(total[several], axis=1)[:, None]
        frame[several] = frames_from_normals(normal)
        corner_joint = self.joint[self.interface]
        order = np.argsort(corner_joint, kind="stable")
        of_joint = Ragged.from_owners(corner_joint[order], len(count))
        for i in several.tolist():
            point[i] = facets.outline(self.point[order[of_joint[i]]], frame[i])
        friction = self.friction[first]
        friction[several] = np.bincount(self.joint, self.area * self.friction)[several]
        friction[several] /= area[several]
        corners = Ragged.of(point)
        return Contacts(
            self.block_a[first],
            self.block_b[first],
            frame,
            area,
            friction,
            np.concatenate(point),
            corners.owner,
            None if self.capacity is None else self.capacity.summed(self.joint),
            self.rod[first],
        )

    def polygon(self, interface: int) -> Floats:
        """Corners (c, 3) [m] of one interface."""
        return self.point[self.corners[interface]]

    def with_friction(self, friction: float | Sequence[float] | Floats) -> Contacts:
        """The same interfaces with another friction coefficient, one for all or one each.

        Ties have none.
        """
        chosen = np.where(self.ties, 0.0, check_friction(friction, self.count))
        return replace(self, friction=chosen)

    def select(self, interfaces: Bools | Ints, renumber: Ints | None = None) -> Contacts:
        """Only the given interfaces (mask or positions), in ascending order.

        Parameters
        ----------
        interfaces
        renumber
            New position of each block, where the blocks are renumbered as well.
        """
        mask = np.zeros(self.count, dtype=bool)
        try:
            mask[interfaces] = True
        except (IndexError, OverflowError) as error:
            remedy = f"give positions up to {self.count - 1}, or a mask ({self.count},)"
            raise InputError("no such interfaces", remedy=remedy) from error
        a, b = self.block_a[mask], self.block_b[mask]
        return (
            self._part(mask, a, b)
            if renumber is None
            else self._part(mask, renumber[a], renumber[b])
        )

    def of_blocks(self, blocks: Sequence[int] | Ints, count: int) -> Contacts:
        """Interfaces among some of ``count`` blocks, renumbered as ``Assembly.subset`` does."""
        new = np.full(count, -1, dtype=np.intp)
        new[np.asarray(blocks, dtype=np.intp)] = np.arange(len(blocks))
        return self.select((new[self.block_a] >= 0) & (new[self.block_b] >= 0), new)

    def with_points(self, owner: Ints, place: Floats, area: Floats) -> Contacts:
        """Points in place of the corners of some dry faces, after the other interfaces.

        Parameters
        ----------
        owner : (p,)
            The face of each point, which is an interface of its own.
        place : (p, 3) [m]
        area : (p,) [m2]
            What each stands for.
        """
        stays = np.ones(self.count, dtype=bool)
        stays[owner] = False
        faces = {name: getattr(self, name)[owner] for name in _ALIKE}
        own = {"area": area, "point": place, "tributary": area, "interface": np.arange(len(owner))}
        return joined_contacts(self.select(stays), _unchecked(None, **faces, **own))

    def _part(self, mask: Bools, block_a: Ints, block_b: Ints) -> Contacts:
        """Some interfaces (m,) between these blocks: a part of what was checked needs no check."""
        keep = mask[self.interface]
        return _unchecked(
            None if self.capacity is None else self.capacity.select(mask),
            block_a=block_a,
            block_b=block_b,
            frame=self.frame[mask],
            area=self.area[mask],
            friction=self.friction[mask],
            rod=self.rod[mask],
            point=self.point[keep],
            interface=(np.cumsum(mask) - 1)[self.interface[keep]],
            tributary=self.tributary[keep],
        )


_ALIKE = ("block_a", "block_b", "frame", "friction", "rod")
"""What points have of their face."""


def _unchecked(capacity: JointCapacity | None, **values: NDArray[Any]) -> Contacts:
    """Interfaces of what was checked."""
    made = object.__new__(Contacts)
    for name, value in values.items():
        object.__setattr__(made, name, frozen(value))
    object.__setattr__(made, "capacity", capacity)
    return made


def _checked_frames(frame: Any, count: int) -> Floats:
    """Frames (count, 3, 3) of interfaces.

    Raises
    ------
    InputError
        Rows that are not unit vectors normal to each other.
    """
    given = frozen_floats(frame, (count, 3, 3), "frame")
    sides = np.clip(given, -2.0, 2.0)  # larger ones are wrong anyway, and their squares may not fit
    off = np.abs(sides @ np.swapaxes(sides, 1, 2) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    for i in np.flatnonzero(off > NOT_UNIT)[:1]:
        raise InputError(
            f"the rows of the frame of interface {i} are not unit vectors normal to each other",
            remedy="give the unit normal and two unit vectors in the face",
        )
    return given


def check_friction(friction: Any, count: int) -> Floats:
    """Friction coefficients (count,), zero or more.

    Raises
    ------
    InputError
        Negative, NaN, or larger than :data:`MOST_FRICTION`.
    """
    values = one_or_each(friction, count, "friction")
    single = np.asarray(friction, dtype=np.float64)  # is refused where there is no interface, too
    bad = ~((single >= 0.0) & (single <= MOST_FRICTION))
    if bad.any():
        found = single[bad].ravel()[0]
        remedy = "give a coefficient of zero or more"
        if found > MOST_FRICTION:
            remedy = f"give a coefficient of {MOST_FRICTION:g} at most"
        raise InputError(f"friction is {found}", remedy=remedy)
    return frozen(values)


def joined_contacts(one: Contacts, other: Contacts) -> Contacts:
    """The interfaces of both, those of the first one first."""
    if not len(other):
        return one

    names = (*_ALIKE, "area", "point", "tributary")
    both = {name: np.concatenate([getattr(one, name), getattr(other, name)]) for name in names}
    interface = np.concatenate([one.interface, other.interface + one.count])
    return _unchecked(_joined_capacity(one, other), interface=interface, **both)


def _as_strong(given: Contacts, *others: Contacts) -> JointCapacity:
    """Dry joints that crush under the least strength of others, where that is finite."""
    dry = JointCapacity.dry(given.count)
    least = np.inf
    for contacts in others:
        face = contacts.crushes & (contacts.area > 0.0) & ~contacts.ties
        if contacts.capacity is not None and face.any():
            stress = contacts.capacity.compression[face] / contacts.area[face]
            least = min(least, float(stress.min()))
    return dry if np.isinf(least) else replace(dry, compression=least * given.area)


def _joined_capacity(one: Contacts, other: Contacts) -> JointCapacity | None:
    if one.capacity is None and other.capacity is None:
        return None
    parts = [c.capacity or _as_strong(c, one, other) for c in (one, other)]
    brittle = any(p.brittle for p in parts if p.law)
    values = {name: np.concatenate([getattr(p, name) for p in parts]) for name in DRY}
    return JointCapacity(**values, brittle=brittle)
