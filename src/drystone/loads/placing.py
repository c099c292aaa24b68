"""Points and faces of a block on which a load acts, and masses that blocks carry.

Those are fill, masses in kg, and weights that are told to be shaken.
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import (
    SAME,
    Bools,
    Floats,
    Ints,
    frozen,
    frozen_floats,
    lengths,
    places,
    whole,
)
from drystone.base.display import OneLine, shortened
from drystone.base.errors import InputError
from drystone.base.units import mass
from drystone.geometry.frames import unit
from drystone.geometry.polyhedron import Faces, fan_triangles, stack_faces
from drystone.geometry.solid import outside_distance
from drystone.geometry.triangulate import triangulate

_FACING = np.cos(np.deg2rad(30.0))
"""A face faces a direction when its normal is within 30 degrees of it. Chosen: the inclined top of
a voussoir still counts as its top."""


def free_block(assembly: Assembly, block: int | str) -> int:
    """Position of a free block.

    Raises
    ------
    InputError
        There is no such block, or it is fixed.
    """
    i = int(assembly.indices([block])[0])
    if assembly.fixed[i]:
        raise InputError(
            f"block '{assembly.names[i]}' is fixed: a load on it changes nothing",
            remedy="load a free block",
        )
    return i


def wrench_at(assembly: Assembly, block: int, force: Floats, point: Floats) -> Floats:
    """Wrenches (n, 6) of forces (f, 3) at points (f, 3) on one block."""
    wrench = np.zeros((len(assembly), 6))
    wrench[block, :3] = force.sum(axis=0)
    wrench[block, 3:] = np.cross(point - assembly.centroid[block], force).sum(axis=0)
    return wrench


def filled(rows: Floats, count: int) -> Floats:
    """Rows (c, ...), and zeros after them up to ``count``."""
    return np.concatenate([rows, np.zeros((count - len(rows), *rows.shape[1:]))])


def at_points(assembly: Assembly, block: int, force: Floats, point: Floats) -> Floats:
    """A force (3,) at a point (3,) of one block: (n, 4, 3), it and its arm from the centroid.

    The first row is the force, the others the arm along x, y and z times it.
    """
    given = np.zeros((len(assembly), 4, 3))
    given[block] = np.outer([1.0, *(point - assembly.centroid[block])], force)
    return given


def turned_points(given: Floats, rotation: Floats) -> Floats:
    """Of forces at points, after arms were turned by the transpose of (3, 3) or (n, 3, 3)."""
    turned = np.swapaxes(rotation, -1, -2) @ given[:, 1:]
    return np.concatenate([given[:, :1], turned], axis=1)


def moved_points(given: Floats, shift: Floats) -> Floats:
    """Of forces at points, about centroids that were a ``shift`` (n, 3) [m] away."""
    arms = given[:, 1:] + shift[:, :, None] * given[:, :1]
    return np.concatenate([given[:, :1], arms], axis=1)


def moved_wrench(wrench: Floats, shift: Floats) -> Floats:
    """Wrenches (n, 6) about centroids that were a ``shift`` (n, 3) [m] away."""
    return np.column_stack([wrench[:, :3], wrench[:, 3:] + np.cross(shift, wrench[:, :3])])


def turned_wrench(wrench: Floats, rotation: Floats) -> Floats:
    """Wrenches (n, 6) in the axes of a model that was turned by a matrix (3, 3)."""
    return (wrench.reshape(-1, 2, 3) @ rotation).reshape(-1, 6)


def wrench_of_points(given: Floats) -> Floats:
    """Wrenches (n, 6) of forces at points."""
    return np.column_stack([given[:, 0], torques(given[:, 1:])])


def torques(arms: Floats) -> Floats:
    """Cross products (n, 3) of arms and forces, by sums (n, 3, 3) of their outer products."""
    each = arms.reshape(-1, 9)
    return np.asarray(each[:, [5, 6, 1]] - each[:, [7, 2, 3]])


def wrench_of_masses(assembly: Assembly, acceleration: Floats) -> Floats:
    """Wrenches (n, 6) of an acceleration (3,) [m/s2] of all masses.

    Raises
    ------
    InputError
        A force is larger than a float can hold.
    """
    wrench = np.zeros((len(assembly), 6))
    with np.errstate(over="ignore", invalid="ignore"):
        wrench[:, :3] = assembly.mass[:, None] * acceleration
    for i in np.flatnonzero(~np.isfinite(wrench).all(axis=1))[:1]:
        raise InputError(
            f"block '{assembly.names[i]}' has a mass of {assembly.mass[i]:.3g} kg: its weight is "
            "too large for a floating-point number",
            remedy="check its density, its size and the acceleration of gravity",
        )
    return wrench


def off_block(block: Block, points: Floats) -> tuple[str, ...]:
    """A note on each of the points (p, 3) that lies outside a block."""
    _, triangles = _surface(block)
    away = outside_distance(points, triangles, SAME * block.size)
    told = [(", ".join(f"{x:g}" for x in points[i]), away[i]) for i in np.flatnonzero(away)]
    return tuple(f"the point {at} is {far:.3g} m off block '{block.name}'" for at, far in told)


@functools.lru_cache(maxsize=64)
def _surface(block: Block) -> tuple[Faces, Floats]:
    """The faces of a block, and triangles (t, 3, 3) that cover them; kept for its next load."""
    faces = stack_faces([block.vertices], [block.faces])
    corner = faces.point[faces.loop]
    return faces, frozen(corner[triangulate(corner, faces.start)[0]])


@dataclass(frozen=True, eq=False)
class GivenLoad(OneLine):
    """One load as it was asked for, beside those of masses; for tables and sums by hand.

    Attributes
    ----------
    words
        What it is.
    block : (a,)
        On which it acts.
    wrench : (a, 6) [N, N m]
        About the centroid of each.
    given : (a, 4, 3) [N, N m]
        Of a force at a point; see :func:`at_points`. Zero of others.
    """

    words: str
    block: Ints
    wrench: Floats
    given: Floats

    @classmethod
    def of(cls, words: str, wrench: Floats, given: Floats | None = None) -> tuple[GivenLoad, ...]:
        """That of wrenches (n, 6), if it acts, and of a force at a point (n, 4, 3)."""
        block = np.flatnonzero(wrench.any(axis=1))
        at = np.zeros((len(wrench), 4, 3)) if given is None else given
        return (cls(words, block, wrench[block], at[block]),) if len(block) else ()

    def on(self, count: int) -> dict[str, Any]:
        """Its wrenches (n, 6), and it at points (n, 4, 3), of so many blocks, for a load case."""
        wrench, given = np.zeros((count, 6)), np.zeros((count, 4, 3))
        wrench[self.block], given[self.block] = self.wrench, self.given
        return {"wrench": wrench, "given": given}

    def by(self, factor: float) -> GivenLoad:
        """The same times a factor."""
        words = self.words if factor == 1.0 else multiplied(factor, self.words)
        return GivenLoad(words, self.block, factor * self.wrench, factor * self.given)

    def turned(self, rotation: Floats) -> GivenLoad:
        """The same in the axes of a model that was turned by a matrix (3, 3)."""
        given = turned_points(self.given, rotation) @ rotation
        return replace(self, wrench=turned_wrench(self.wrench, rotation), given=given)

    def of_blocks(self, chosen: Ints, count: int, shift: Floats | None = None) -> GivenLoad:
        """That of some blocks of ``count``; their centroids were a ``shift`` (c, 3) [m] away."""
        position = places(chosen, count)[self.block]
        kept = position >= 0
        block, wrench, given = position[kept], self.wrench[kept], self.given[kept]
        if shift is not None:
            wrench, given = moved_wrench(wrench, shift[block]), moved_points(given, shift[block])
        return GivenLoad(self.words, block, wrench, given)


def multiplied(by: float, words: str) -> str:
    """A factor before the words of a load."""
    words = f"({words})" if " + " in words else words
    return f"{by:g} {'* ' * words.startswith(tuple('-0123456789'))}{words}"  # of a vector


@dataclass(frozen=True, eq=False)
class SurfaceLoad(OneLine):
    """Tractions on lines of the surface of blocks, for pictures.

    Attributes
    ----------
    block : (q,)
    point : (q, 2, 3) [m]
        Both ends of each line.
    traction : (q, 2, 3) [Pa]
        There.
    wrench : (n, 6) [N, N m]
        Of all of it on the blocks.
    """

    block: Ints
    point: Floats
    traction: Floats
    wrench: Floats

    @classmethod
    def of_all(cls, several: Sequence[SurfaceLoad]) -> SurfaceLoad | None:
        """The sum of some: on lines that lie on each other the tractions are added."""
        return functools.reduce(cls._with, several) if several else None

    def _with(self, other: SurfaceLoad) -> SurfaceLoad:
        wrench = self.wrench + other.wrench
        if np.array_equal(self.block, other.block) and np.array_equal(self.point, other.point):
            return replace(self, traction=self.traction + other.traction, wrench=wrench)
        mine, more = self._cut_at(other), other._cut_at(self)
        apart = SAME * max(float(np.abs(mine.point).max(initial=0.0)), 1e-300)
        known = {key: i for i, key in enumerate(mine._keys(apart))}
        at = np.array([known.get(key, -1) for key in more._keys(apart)], dtype=np.intp)
        mine.traction[at[at >= 0]] += more.traction[at >= 0]
        both = (
            (getattr(one, name) for one in (mine, more)) for name in ("block", "point", "traction")
        )
        block, point, traction = (np.concatenate([a, b[at < 0]]) for a, b in both)
        return SurfaceLoad(block, point, traction, wrench)

    def _cut_at(self, other: SurfaceLoad) -> SurfaceLoad:
        """The same with its own arrays, and with lines cut where lines of another end on them."""
        if not len(self.block):
            return self
        cuts = []
        for block, (start, end) in zip(self.block.tolist(), self.point, strict=True):
            way, ends = end - start, other.point[other.block == block].reshape(-1, 3) - start
            share = ends @ way / max(float(way @ way), 1e-300)
            on = lengths(ends - share[:, None] * way) <= SAME * np.sqrt(way @ way)
            on &= (share > SAME) & (share < 1.0 - SAME)
            places = np.sort([0.0, *share[on], 1.0])
            cuts.append(places[np.append(True, np.diff(places) > SAME)])
        of = np.repeat(np.arange(len(cuts)), [len(one) - 1 for one in cuts])
        part = np.concatenate([np.stack([one[:-1], one[1:]], axis=1) for one in cuts])[..., None]
        point, traction = (
            one[of, :1] + part * (one[of, 1:] - one[of, :1]) for one in (self.point, self.traction)
        )
        return replace(self, block=self.block[of], point=point, traction=traction)

    def _keys(self, apart: float) -> Iterator[tuple[float, ...]]:
        """What lines of two loads that are less than a length [m] apart have alike."""
        ends = np.rint(self.point / apart).reshape(-1, 6)
        times: Counter[tuple[float, ...]] = Counter()
        for key in map(tuple, np.column_stack([self.block, ends]).tolist()):
            yield *key, times[key]  # a side of two triangles has two lines
            times[key] += 1

    def lies_on(self, block: int, normal: Floats, offset: Floats, near: float) -> Bools:
        """Whether a line of it on a block is in each plane: normals (f, 3), offsets (f,) [m]."""
        off = np.abs(self.point[self.block == block] @ normal.T - offset)
        return np.asarray((off.max(axis=1) < near).any(axis=0))

    def by(self, factor: float) -> SurfaceLoad:
        """With its tractions multiplied."""
        return replace(self, traction=factor * self.traction, wrench=factor * self.wrench)

    def turned(self, rotation: Floats) -> SurfaceLoad:
        """In the axes of a model that was turned by a matrix (3, 3)."""
        wrench = turned_wrench(self.wrench, rotation)
        return replace(self, traction=self.traction @ rotation, wrench=wrench)

    def of_blocks(self, chosen: Ints, count: int) -> SurfaceLoad:
        """Those of some blocks, which are the first of ``count``."""
        position = places(chosen, len(self.wrench))
        wrench = filled(self.wrench[chosen], count)
        kept = position[self.block] >= 0
        return SurfaceLoad(
            position[self.block[kept]], self.point[kept], self.traction[kept], wrench
        )

    @classmethod
    def of_triangles(
        cls, block: int, force: Floats, triangle: Floats, wrench: Floats
    ) -> SurfaceLoad:
        """Even ones of forces (t, 3) [N] on triangles (t, 3, 3) [m], along their sides."""
        sides = triangle[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2, 3)
        across = np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0])
        even = force / (0.5 * lengths(across)[:, None])
        traction = np.repeat(even, 6, axis=0).reshape(-1, 2, 3)
        return cls(np.full(len(sides), block), sides, traction, wrench)


def surface_forces(
    block: Block, traction: Any, faces: Sequence[int] | None, facing: Any
) -> tuple[Floats, Floats]:
    """Forces (t, 3) [N] on triangles of a block's surface, and these (t, 3, 3) [m].

    Parameters
    ----------
    block
    traction, faces, facing
        See :meth:`LoadCase.surface_load`.
    """
    part, _ = _surface(block)
    chosen = _chosen_faces(part, faces, facing, block.name)
    triangles, face = fan_triangles(part)
    triangles = triangles[np.isin(face, chosen)]
    area = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    if np.ndim(traction) == 0:
        force = -float(frozen_floats(traction, (), "pressure")) * area
    else:
        size = np.linalg.norm(area, axis=1)
        force = size[:, None] * frozen_floats(traction, (3,), "traction")
    return force, triangles


def _chosen_faces(part: Faces, faces: Sequence[int] | None, facing: Any, name: str) -> Ints:
    where = f"block '{name}'"
    if faces is not None and facing is not None:
        raise InputError("faces are chosen twice", where=where, remedy="by number or by direction")
    if faces is not None:
        listed = faces if isinstance(faces, Iterable) else [faces]
        numbers = [whole(face, "a face", least=0) for face in listed]
        if not numbers or max(numbers) >= part.count:
            raise InputError(
                f"some of the faces {shortened(str(numbers), 60)} do not exist",
                where=where,
                remedy=f"they are numbered 0 to {part.count - 1}",
            )
        return np.array(numbers, dtype=np.intp)
    if facing is None:
        return np.arange(part.count, dtype=np.intp)
    area = part.area_vectors
    along = area @ unit(facing, "facing")
    chosen = np.flatnonzero(along > (_FACING - 1e-12) * np.linalg.norm(area, axis=1))
    if len(chosen) == 0:
        raise InputError("no face has this direction", where=where, remedy="choose faces by number")
    return chosen


@dataclass(frozen=True, eq=False)
class CarriedMass(OneLine):
    """Masses that move with the blocks on which they lie.

    Attributes
    ----------
    kind
        ``fill``, ``resisting fill`` (beyond its pressure), ``mass`` or ``load``.
    mass : (n,) [kg]
        On each block.
    moment : (n, 3) [kg m]
        Mass times its place, from the centroid of the block.
    gravity, shake : (3,) [m/s2]
        Of them: their forces by these are among those of a load case.
    """

    kind: str
    mass: Floats
    moment: Floats
    gravity: Floats
    shake: Floats = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", frozen_floats(self.mass, (None,), "mass"))
        moment = frozen_floats(self.moment, (len(self.mass), 3), "moment")
        object.__setattr__(self, "moment", moment)
        for name in ("gravity", "shake"):
            object.__setattr__(self, name, frozen_floats(getattr(self, name), (3,), name))

    def _summary(self) -> str:
        return f"{self.kind}, {self.mass.sum():.4g} kg"

    @classmethod
    def at(
        cls,
        assembly: Assembly,
        kind: str,
        block: Ints,
        mass: Floats,
        place: Floats,
        gravity: Floats,
    ) -> CarriedMass:
        """Those of some masses (p,) [kg] on blocks (p,) at places (p, 3) [m]."""
        count = len(assembly)
        moment = np.zeros((count, 3))
        np.add.at(moment, block, mass[:, None] * (place - assembly.centroid[block]))
        total: Floats = np.bincount(block, mass, count).astype(np.float64)
        return cls(kind, total, moment, gravity)

    @property
    def wrench(self) -> Floats:
        """Their wrenches (n, 6)."""
        return self.pushed(self.gravity + self.shake)

    def pushed(self, acceleration: Floats) -> Floats:
        """Wrenches (n, 6) of an acceleration (3,) [m/s2] of them."""
        turned = np.cross(self.moment, acceleration)
        return np.column_stack([self.mass[:, None] * acceleration, turned])

    def as_given(self, chosen: Ints) -> GivenLoad:
        """Their weight on some blocks, at its places."""
        kind = {"load": "shaken load"}.get(self.kind, self.kind)
        arms = np.concatenate([self.mass[:, None], self.moment], axis=1)[chosen]
        wrench, given = self.pushed(self.gravity)[chosen], arms[:, :, None] * self.gravity
        words = f"{kind} of {mass(float(self.mass[chosen].sum()))}"
        return GivenLoad(words, chosen, wrench, given)

    def place(self, assembly: Assembly) -> Floats:
        """Their middle (n, 3) [m] on each block; its centroid where there are none."""
        by = np.where(self.mass == 0.0, 1.0, self.mass)
        return np.asarray(assembly.centroid + self.moment / by[:, None])

    def shaken(self, more: Floats) -> CarriedMass:
        """The same with one more acceleration (3,) [m/s2] of an earthquake."""
        return replace(self, shake=self.shake + more)

    def turned(self, rotation: Floats) -> CarriedMass:
        """The same in the axes of a model that was turned by a matrix (3, 3)."""
        return replace(self, gravity=self.gravity @ rotation, shake=self.shake @ rotation)

    def by(self, factor: float) -> CarriedMass:
        """The same times a factor."""
        return replace(self, mass=factor * self.mass, moment=factor * self.moment)

    def weighing_by(self, g: float) -> CarriedMass:
        """Masses that weigh the same by another gravity [m/s2]."""
        less = g / float(np.linalg.norm(self.gravity))
        return replace(self.by(1.0 / less), gravity=less * self.gravity)

    def of_blocks(self, chosen: Ints, count: int, shift: Floats | float = 0.0) -> CarriedMass:
        """Those of some blocks, the first of ``count``; ``shift`` (c, 3) [m] is added to places."""
        moment = filled(self.moment[chosen] + self.mass[chosen, None] * shift, count)
        return replace(self, mass=filled(self.mass[chosen], count), moment=moment)
