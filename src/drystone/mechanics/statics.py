"""Rigid-body statics of blocks in contact: the dimensionless problem, equilibrium, residuals.

Here, and only here, a model becomes dimensionless and answers become physical again. Each block has
its own length (the size of the block) and all share one force (the mean load of a free block):

- wrench rows of block i: force / W, moment / (W l_i);
- motion of block i: translation / D, rotation * l_i / D, with D any displacement scale;
- corner forces / W; corner displacements / D.

Power is conserved: ``wrench . motion`` in scaled numbers is power / (W D).
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from drystone.base.arrays import Bools, Floats, Ints, dot, lengths, places
from drystone.base.ragged import Ragged
from drystone.contacts import Contacts
from drystone.geometry.stress_block import cut_off, stress_block
from drystone.mechanics.maps import Maps, maps_between
from drystone.model import Model


def transfer(frame: Floats, lever: Floats, block: Ints) -> Floats:
    """Wrench on a block per unit force at each corner (k, 6, 3): the axes, and lever x axis.

    Parameters
    ----------
    frame : (k, 3, 3) rows n, u, v
    lever : (k, 3) from the block's centroid to the corner
    block : (k,) number of the block, -1 for a fixed one: its entries are zero
    """
    axes = np.swapaxes(frame, 1, 2)
    out = np.empty((len(block), 6, 3))
    out[:, :3] = axes
    arm = lever[:, :, None]
    for i, j, m in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, 3 + i] = arm[:, j] * axes[:, m] - arm[:, m] * axes[:, j]
    out[block < 0] = 0.0
    return out


def sparse_rows(pair: Ints, transfers: Floats, count: int) -> sparse.csr_matrix:
    """A^T (3 k, 6 n): three rows for each corner, with six numbers for each free block there.

    Parameters
    ----------
    pair : (k, 2) numbers of the blocks of each corner, -1 for a fixed one
    transfers : (k, 2, 6, 3) wrench on each block per unit force
    count
        Number of free blocks, n.
    """
    k, shape = len(pair), (3 * len(pair), 6 * count)
    values = transfers.transpose(0, 3, 1, 2).copy()
    pair, descending = pair.copy(), np.flatnonzero(pair[:, 0] > pair[:, 1])
    pair[descending] = pair[descending, ::-1]
    values[descending] = values[descending, :, ::-1]
    wide = max(36 * k, *shape) >= 2**31
    index: np.dtype[np.signedinteger] = np.dtype(np.int64 if wide else np.int32)
    column = np.empty(values.shape, dtype=index)
    column[:] = (6 * pair[:, :, None] + np.arange(6))[:, None]
    meets = pair >= 0
    if not meets.all():
        kept = np.broadcast_to(meets[:, None], (k, 3, 2))
        values, column = values[kept], column[kept]
    start = np.zeros(3 * k + 1, dtype=index)
    np.cumsum(np.repeat(6 * meets.sum(axis=1), 3), out=start[1:])
    return sparse.csr_matrix((values.ravel(), column.ravel(), start), shape=shape)


UNLIMITED = 1e9
"""Capacity of a corner, by the mean load of a block, that counts as none that can be reached."""

_SPECK = 1e-4
"""Least area of a corner by the squared size of its block: 0.2 % of what a cube's corner has."""

_LIGHT = 1e-4
"""Forces on a block, by the mean load, below which its joints are softer, in proportion. Their
overlap is then no less than with such forces. A block of 3e-13 of the others' weight would overlap
by 3e-13 of what the blocks below it move: rounding changes that by parts of a thousand, and a proof
allows 1e-8."""

_SOFTEST = 1e-100
"""Least share of the stiffness of such a joint: a float holds its square."""


@dataclass(frozen=True, eq=False)
class Statics:
    """The dimensionless problem of n free blocks and k corners.

    Attributes
    ----------
    free : (n,) position of each free block in the assembly
    block_a, block_b : (k,) free number of the blocks of each corner, -1 for a fixed one
    lever_a, lever_b : (k, 3) from the block's centroid to the corner, by the block's length
    frame : (k, 3, 3) rows n, u, v
    friction : (k,)
    tributary : (k,) area by the mean area of a corner
    block_area : (k,) squared size of the smaller of the two blocks, by the same area
    interface : (k,)
    tension, cohesion, shear : (k,)
        Largest pull, cohesion and largest shear, :data:`UNLIMITED` at most; see
        :class:`drystone.JointCapacity`. Zero, zero and without limit for dry joints.
    load : (n, 6) scaled wrench
    mass : (n,) by the mean mass of a free block
    inertia : (n,) radius of gyration squared, by the block's length squared
    length : (n,) [m]
    position : (n, 3) [m] centroids, for the order of elimination
    force_unit : [N]
    mean_length : [m]
    crushing
        Faces of finite strength; None where there are none.
    felt : (k,)
        Force on the block at each corner that feels less, if known. See :meth:`with_felt`.
    """

    free: Ints
    block_a: Ints
    block_b: Ints
    lever_a: Floats
    lever_b: Floats
    frame: Floats
    friction: Floats
    tributary: Floats
    block_area: Floats
    interface: Ints
    tension: Floats
    cohesion: Floats
    shear: Floats
    load: Floats
    mass: Floats
    inertia: Floats
    length: Floats
    position: Floats
    force_unit: float
    mean_length: float
    crushing: Crushing | None = None
    felt: Floats | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @property
    def free_count(self) -> int:
        """Number of free blocks, n."""
        return len(self.free)

    @cached_property
    def dry(self) -> bool:
        """Whether no joint pulls, coheres, has a limit of shear or crushes."""
        return self.crushing is None and not (
            self.tension.any() or self.cohesion.any() or (self.shear < UNLIMITED).any()
        )

    @property
    def corner_count(self) -> int:
        """Number of corners, k."""
        return len(self.interface)

    @cached_property
    def blocks(self) -> Ints:
        """(k, 2) free numbers of both blocks of each corner, -1 for a fixed one."""
        return np.stack([self.block_a, self.block_b], axis=1)

    @cached_property
    def transfers(self) -> Floats:
        """(k, 2, 6, 3) wrench on both blocks per unit local corner force; zero for a fixed one."""
        on_a = transfer(self.frame, self.lever_a, self.block_a)
        return np.stack([-on_a, transfer(self.frame, self.lever_b, self.block_b)], axis=1)

    @cached_property
    def maps(self) -> Maps:
        """The maps between blocks and corners, and the elimination order of the tangent."""
        made = maps_between(self.block_a, self.block_b, self.length, self.position)
        made.at(self.frame, self.lever_a, self.lever_b)
        return made

    @cached_property
    def matrix(self) -> sparse.csr_matrix:
        """Equilibrium matrix A (6 n, 3 k): at rest ``A @ force + load`` vanishes (both raveled)."""
        return self.matrix_transposed.T.tocsr()

    @cached_property
    def matrix_transposed(self) -> sparse.csr_matrix:
        """A^T (3 k, 6 n): corner displacements from block motions."""
        return sparse_rows(self.blocks, self.transfers, self.free_count)

    def wrench(self, force: Floats) -> Floats:
        """A f: the wrench (n, 6) that corner forces (k, 3) exert on the free blocks."""
        return self.maps.wrench(force)

    def displacement(self, motion: Floats) -> Floats:
        """A^T q: relative displacement (k, 3) of b against a at each corner, local n, u, v."""
        return self.maps.moved(motion)

    @cached_property
    def normal_stiffness(self) -> Floats:
        """(k,) tributary area, at least 5 % of its interface's mean and a small share of the block.

        Slivers would make the system ill-conditioned; lines and points have no area. Points that
        are spread over a face have their own: else small ones press as much as large ones.
        """
        area = self.tributary
        if not len(area):
            return area
        count = np.bincount(self.interface)
        mean = np.bincount(self.interface, area) / np.maximum(count, 1)
        least = np.maximum(0.05 * mean[self.interface], _SPECK * self.block_area)
        spread = (count[self.interface] == 1) & (area > 0.0)
        stiff = np.where(spread, area, np.maximum(area, least))
        return stiff if self.felt is None else stiff * np.clip(self.felt / _LIGHT, _SOFTEST, 1.0)

    def with_felt(self, force: Floats) -> Statics | None:
        """The same where each block feels its load and corner forces (k, 3).

        None where no block feels less than _LIGHT, or so much more than its load.
        """
        block = np.append(self.load_size + self.on_blocks(lengths(force)), np.inf)
        felt = np.minimum(block[self.block_a], block[self.block_b])
        if not ((felt < _LIGHT) | (self.corner_load < _LIGHT * felt)).any():
            return None
        return replace(self, felt=np.where(felt > 0.0, felt, 1.0))

    def with_free(self, moving: Bools) -> Statics:
        """The same in which only some of the free blocks (n,) are free, for dry joints.

        It has the corners of these blocks, and the units of the whole.
        """
        slot = np.append(np.where(moving, np.cumsum(moving) - 1, -1), -1)
        block_a, block_b = slot[self.block_a], slot[self.block_b]
        kept = (block_a >= 0) | (block_b >= 0)
        of_blocks = ("free", "load", "mass", "inertia", "length", "position")
        parts = {
            one.name: getattr(self, one.name)[moving if one.name in of_blocks else kept]
            for one in fields(self)
            if isinstance(getattr(self, one.name), np.ndarray)
        }
        return replace(self, **{**parts, "block_a": block_a[kept], "block_b": block_b[kept]})

    @cached_property
    def load_size(self) -> Floats:
        """(n,) length of the force plus length of the moment of the load of each free block."""
        return lengths(self.load[:, :3]) + lengths(self.load[:, 3:])

    @cached_property
    def load_scale(self) -> Floats:
        """(n,) the same; 1 for a block without a load."""
        return np.where(self.load_size > 0.0, self.load_size, 1.0)

    @cached_property
    def corner_load(self) -> Floats:
        """Typical force (k,) of a corner: the load of the lighter of its free blocks, or felt."""
        if self.felt is not None:
            return self.felt
        load = np.append(self.load_scale, np.inf)
        return np.minimum(load[self.block_a], load[self.block_b])

    @cached_property
    def mass_matrix(self) -> Floats:
        """Diagonal (n, 6): mass, and mass times radius of gyration squared."""
        turning = self.mass * self.inertia
        return np.stack([self.mass] * 3 + [turning] * 3, axis=1)

    def on_blocks(self, values: Floats) -> Floats:
        """(n,) sums of values (k,) over the corners of each free block."""
        both = np.concatenate([values, values])
        return np.bincount(self._ends, both, len(self.free) + 1)[1:].astype(np.float64)

    @cached_property
    def _ends(self) -> Ints:
        """(2 k,) 1 and the free number of the blocks of each corner, 0 for a fixed one."""
        return 1 + np.concatenate([self.block_a, self.block_b])

    # -- back to physical numbers -------------------------------------------------------------
    def physical_force(self, force: Floats) -> Floats:
        """Corner forces (k, 3) [N]."""
        return force * self.force_unit

    def physical_wrench(self, wrench: Floats, count: int) -> Floats:
        """Wrenches (count, 6) [N, N m] of all blocks from those of the free ones."""
        out = np.zeros((count, 6))
        out[self.free, :3] = wrench[:, :3] * self.force_unit
        out[self.free, 3:] = wrench[:, 3:] * (self.force_unit * self.length[:, None])
        return out

    def scaled_wrench(self, wrench: Floats) -> Floats:
        """Scaled wrenches (n, 6) of the free blocks, from physical ones of all blocks."""
        scaled = wrench[self.free] / self.force_unit
        return np.concatenate([scaled[:, :3], scaled[:, 3:] / self.length[:, None]], axis=1)

    def physical_motion(self, motion: Floats, count: int, unit: float) -> Floats:
        """Motions (count, 6) [m, rad] of all blocks, for a displacement unit [m]."""
        out = np.zeros((count, 6))
        out[self.free, :3] = motion[:, :3] * unit
        out[self.free, 3:] = motion[:, 3:] * (unit / self.length[:, None])
        return out

    def scaled_motion(self, motion: Floats, unit: float) -> Floats:
        """Scaled motions (n, 6) of the free blocks, from physical ones of all blocks."""
        out = np.empty((self.free_count, 6))
        out[:, :3] = motion[self.free, :3] / unit
        out[:, 3:] = motion[self.free, 3:] * (self.length[:, None] / unit)
        return out


def build_statics(model: Model, contacts: Contacts | None = None) -> Statics:
    """The dimensionless problem of a model, or of its blocks with other contacts.

    Raises
    ------
    InputError
        The load moves supports.
    """
    assembly, load = model.assembly, model.load
    contacts = model.contacts if contacts is None else contacts
    count = len(assembly)
    model.require_still()
    free = assembly.free
    slot = places(free, count)
    of_a, of_b = contacts.corner_blocks
    length = assembly.size
    loads = load.wrench[free]
    size = length[free]
    magnitude = lengths(loads[:, :3]) + lengths(loads[:, 3:]) / size
    mean = float(magnitude.sum()) / len(free) if len(free) else 0.0
    force_unit = mean if mean > 0.0 else 1.0
    scaled = np.concatenate(
        [loads[:, :3] / force_unit, loads[:, 3:] / (force_unit * size[:, None])], axis=1
    )
    mass = assembly.mass[free]
    area = contacts.tributary
    mean_area = float(area.sum()) / len(area) if area.any() else 1.0
    capacity = (np.minimum(one / force_unit, UNLIMITED) for one in contacts.corner_capacity)
    tension, cohesion, shear = capacity
    bounds = assembly.bounds[free]
    extent = bounds[:, 1] - bounds[:, 0]
    return Statics(
        free=free,
        block_a=slot[of_a],
        block_b=slot[of_b],
        lever_a=(contacts.point - assembly.centroid.take(of_a, axis=0)) / length[of_a, None],
        lever_b=(contacts.point - assembly.centroid.take(of_b, axis=0)) / length[of_b, None],
        frame=contacts.frame.take(contacts.interface, axis=0),
        friction=contacts.friction[contacts.interface],
        tributary=area / mean_area,
        block_area=np.minimum(length[of_a], length[of_b]) ** 2 / mean_area,
        interface=contacts.interface,
        tension=tension,
        cohesion=cohesion,
        shear=shear,
        load=scaled,
        mass=mass / (mass.sum() / len(free)) if len(free) else mass,
        inertia=(extent**2).sum(axis=1) / (12.0 * size**2),
        length=size,
        position=assembly.centroid[free],
        force_unit=force_unit,
        mean_length=float(size.sum()) / len(free) if len(free) else 1.0,
        crushing=Crushing.of(contacts, force_unit),
    )


@dataclass(frozen=True, eq=False)
class Crushing:
    """The faces of finite strength, and the parts of them that a program knows.

    What a face carries is the convex hull of the parts beyond a line under its strength; see
    :mod:`drystone.geometry.stress_block`. A program has some of these parts, so its forces never
    exceed the strength. The multipliers of its rows are planes over the faces. The part where a
    plane is positive is the one that is missing most, and the work that it takes up bounds what all
    missing parts can add. Parts are added until that is negligible.

    Attributes
    ----------
    corner : (c,)
        Corners of the problem, face after face.
    start : (j + 1,)
        Face i has the corners ``start[i]`` to ``start[i + 1] - 1`` of them.
    place : (c, 2)
        Of each corner from the centroid of its face, by the root of its area.
    strength : (j,)
        Force that the whole face carries, by the unit of force.
    face : (g,)
        The face of each part.
    part : (g, 3)
        Area and first moments of each part, by those of a face of unit area.
    """

    corner: Ints
    start: Ints
    place: Floats
    strength: Floats
    face: Ints
    part: Floats

    @classmethod
    def of(cls, contacts: Contacts, force_unit: float) -> Crushing | None:
        """That of some joints; None where none has a finite strength."""
        finite = np.flatnonzero(contacts.crushes)
        if not len(finite) or contacts.capacity is None:
            return None
        loops, corner, flat = contacts.flat_corners(finite)
        area = contacts.area[finite]
        flat /= loops.spread(np.sqrt(np.where(area > 0.0, area, 1.0)))[:, None]
        strength = contacts.capacity.compression[finite] / force_unit
        none = np.zeros(0, dtype=np.intp), np.zeros((0, 3))
        made = cls(corner, loops.start, flat, strength, *none)
        made = made._with(np.arange(len(finite)), np.tile([1.0, 0.0, 0.0], (len(finite), 1)))
        # strips along the longest edge and across it, as those of arches and walls are
        edge = flat[loops.following] - flat
        longest = np.lexsort((-lengths(edge), loops.owner))[loops.first]
        along = edge[longest] / np.maximum(lengths(edge[longest]), 1e-300)[:, None]
        for side in (along, -along, along[:, ::-1] * (1.0, -1.0), along[:, ::-1] * (-1.0, 1.0)):
            height = dot(flat, loops.spread(side))
            high, low = loops.max(height), loops.min(height)
            for share in (0.01, 0.03, 0.1, 0.2, 0.35, 0.55, 0.8):
                plane = np.column_stack([share * (high - low) - high, side])
                made = made._with(np.arange(len(finite)), plane)
        return made

    def __len__(self) -> int:
        """Number of faces, j."""
        return len(self.strength)

    def _with(self, faces: Ints, plane: Floats) -> Crushing:
        """The same with the parts where planes (f, 3) over some faces (f,) are positive."""
        loops, row = Ragged(self.start).take(faces)
        part = cut_off(self.place[row], loops.start, plane)
        return replace(
            self,
            face=np.concatenate([self.face, faces]),
            part=np.concatenate([self.part, part]),
        )

    def missing(self, plane: Floats) -> Floats:
        """What the whole faces take up more than the known parts (j,), on planes (j, 3)."""
        known = np.zeros(len(self))
        np.maximum.at(known, self.face, dot(self.part, plane[self.face]))
        all_of_it = dot(cut_off(self.place, self.start, plane), plane)
        return self.strength * np.maximum(all_of_it - known, 0.0)

    def refined(self, plane: Floats, normal: Floats | None = None) -> Crushing:
        """The same with the parts where planes (j, 3) are positive, of faces that miss them.

        Also with the stress blocks of normal forces (c,): hinges move from face to face. With them
        the bridge of the tests takes 7 to 10 rounds, without them 14 to 18.
        """
        gap = self.missing(plane)
        short = np.flatnonzero(gap > 1e-3 * gap.max())
        made = self._with(short, plane[short])
        if normal is None:
            return made
        loops = Ragged(self.start)
        whole = loops.sum(normal)
        some = np.flatnonzero(whole > 1e-3 * self.strength)
        part, row = loops.take(some)
        at = part.sum(normal[row, None] * self.place[row]) / whole[some, None]
        return made._with(some, stress_block(self.place[row], part.start, at)[1])
