"""The blocks of a model as rigid bodies that move by finite amounts, in scaled numbers.

Lengths are divided by the mean size of a free block (the cube root of its volume), forces by the
mean load of a free block. The contacts are springs at the corners of the interfaces. The normal
stiffness is proportional to the tributary area, such that under the mean load the corners of a
block overlap by ``overlap`` block sizes. The tangential stiffness is ``TANGENTIAL`` times the
normal one.

The corners at one position of the blocks: where they are, their directions and gaps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, cross, lengths, places
from drystone.base.ragged import sum_by_owner
from drystone.contacts import Contacts
from drystone.geometry.frames import UNTURNED, rotations
from drystone.geometry.polyhedron import fan_triangles
from drystone.joints import SWAY
from drystone.loads.applied import arms_of_loads
from drystone.loads.placing import torques
from drystone.mechanics.corners import (
    Carrier,
    Ends,
    Rails,
    as_turned,
    joint_ends,
    slid,
    turned_joints,
)
from drystone.mechanics.law import Compliance, FrictionBound, StickSlip
from drystone.model import Model

LEAST_AREA = 0.05
"""Least tributary area of a corner, as a share of the mean of its interface: slivers would make the
system ill-conditioned. Lines and points get this share of the mean of all corners."""

LIGHT = 0.01
"""Force that a block feels, by the mean load, below which it is light. Measured: with 0.003 a block
of 117 N among those of 87 kN is left with 4e-8 of what it feels."""

FIRM = 5.0
"""Stiffness of the joints of light blocks, by that in proportion to what they feel. Measured: with
1 to 3 five of 24 tilts of blocks over five decades of mass end undecided, with 10 one of 24 others.
"""

TURNED = np.array([-1.0, 1.0, -1.0])
"""Signs of the axes n, u and v of a corner whose blocks have changed their roles. The forces along
them, which then act on the other block, have the same signs times -1."""


@dataclass(frozen=True, eq=False)
class Bodies:
    """The constant data of n moving blocks with k corners.

    Attributes
    ----------
    free : (f,) positions of the free blocks
    slot : (n,) number of each block among the free ones, -1 for a support
    centroid : (n, 3) before the motion
    radius : (n,) of gyration about the centroid, the mean over all axes
    mass : (f, 6, 6) of each free block before the motion, by the mean mass and its radius
    load : (f, 6) force, and moment by the radius of gyration
    arms : (f, 3, 3) of its forces, by the radius, times them; see :func:`turned_load`
    size : (n,) cube root of the volume
    block_a, block_b : (k,) positions of the blocks: the corner slides over the face of a
    turned : (k,) whether these are b and a of the interface, see :mod:`.roles`
    arm_a, arm_b : (k, 3) from the centroid to the corner, or to the end of a tie, before the motion
    rod : (k,) length of ties; zero of other corners
    frame : (k, 3, 3) rows n, u, v, before the motion
    ends : where the corners are when blocks slide
    friction : (k,)
    normal, tangential : (k,) stiffness
    most : (k,) at which a tie yields; infinite at other corners
    overlap : of a corner under the mean load
    length_unit : [m]
    force_unit : [N]
    felt : (f,)
        Force that each free block feels, where light ones are told from heavy ones. What is not
        balanced counts by it.
    """

    free: Ints
    slot: Ints
    centroid: Floats
    radius: Floats
    mass: Floats
    load: Floats
    arms: Floats
    size: Floats
    block_a: Ints
    block_b: Ints
    turned: Bools
    arm_a: Floats
    arm_b: Floats
    rod: Floats
    frame: Floats
    ends: Ends
    friction: Floats
    normal: Floats
    tangential: Floats
    most: Floats
    overlap: float
    length_unit: float
    force_unit: float
    felt: Floats | None = None

    @cached_property
    def light(self) -> bool:
        """Whether a block feels much less than the mean load, and this is known."""
        return self.felt is not None and bool((self.felt < LIGHT).any())

    def turned_mass(self, turn: Floats) -> Floats:
        """The mass (f, 6, 6) of blocks that have turned by rotations (n, 3, 3)."""
        mass, turn = self.mass.copy(), turn[self.free]
        mass[:, 3:, 3:] = turn @ mass[:, 3:, 3:] @ turn.swapaxes(1, 2)
        return mass

    def with_felt(self, force: Floats) -> Bodies:
        """The same where blocks feel their load and corner forces (k, 3).

        The joints of those that feel hardly any are softer: their overlap would be lost in the
        rounding of positions.
        """
        felt = np.linalg.norm(self.load[:, :3], axis=1) + np.linalg.norm(self.load[:, 3:], axis=1)
        slots = [self.slot[block] for block in (self.block_a, self.block_b)]
        for slot in slots:
            some = slot >= 0
            felt += np.bincount(slot[some], lengths(force[some]), len(felt))
        felt = np.where(felt > 0.0, felt, 1.0)
        least = np.minimum(*(np.append(felt, np.inf)[slot] for slot in slots))
        share = np.where(least < LIGHT, FIRM * least, 1.0)
        return replace(
            self, felt=felt, normal=share * self.normal, tangential=share * self.tangential
        )

    @cached_property
    def springs(self) -> Compliance:
        """The springs at the corners."""
        law = StickSlip(FrictionBound(self.friction), self.tangential)
        yields = np.isfinite(self.most).any()
        return Compliance(self.normal, law, most=self.most if yields else None)

    @cached_property
    def rails(self) -> Rails:
        """On which the corners slide."""
        return Rails.of(self.ends)

    @cached_property
    def rods(self) -> Ints:
        """The corners of ties."""
        return np.flatnonzero(self.rod)

    @cached_property
    def both(self) -> Ints:
        """(2 k,) block a of each corner, then block b."""
        return np.concatenate([self.block_a, self.block_b])

    @cached_property
    def by_corner(self) -> tuple[Floats, Floats]:
        """With the corner last: ``arm_a`` and ``frame`` (4, 3, k), ``arm_b`` and n (2, 3, k)."""
        of_a = np.concatenate([self.arm_a[:, None], self.frame], axis=1)
        of_b = np.stack([self.arm_b, self.frame[:, 0]], axis=1)
        on_a, on_b = (np.ascontiguousarray(np.moveaxis(one, 0, -1)) for one in (of_a, of_b))
        return on_a, on_b


def build_bodies(
    model: Model,
    carrier: Carrier,
    *,
    overlap: float,
    tangential: float,
    gap: Floats | None = None,
) -> Bodies:
    """The scaled bodies of a model whose interfaces all have a free block.

    Parameters
    ----------
    model
    carrier
    overlap
        Of the corners of a block under the mean load, by the mean size of a free block.
    tangential
        Stiffness by the normal one.
    gap : (k, 2) [m]
        Distance of each corner from the faces of a and b at the beginning, along n; left out, they
        touch.
    """
    assembly, contacts, joint = model.assembly, model.contacts, model.contacts.interface
    free = assembly.free
    slot = places(free, len(assembly))
    size = np.cbrt(assembly.volume)
    length = float(size[free].mean())
    # relative to a point of the model, so a distant origin costs no digits
    origin = assembly.centroid[free].mean(axis=0)
    centroid = (assembly.centroid - origin) / length
    turning, radius = gyration(assembly)
    radius = radius / length
    wrench = model.load.wrench[free]
    by = length * radius[free, None]
    load = np.concatenate([wrench[:, :3], wrench[:, 3:] / by], axis=1)
    arms = arms_of_loads(assembly, model.load)[free] / by[..., None]
    strength = np.linalg.norm(load[:, :3], axis=1) + np.linalg.norm(load[:, 3:], axis=1)
    unit = float(strength.mean()) if strength.any() else 1.0
    turned = turned_joints(model)[joint]
    a, b = contacts.block_a[joint], contacts.block_b[joint]
    a, b = np.where(turned, b, a), np.where(turned, a, b)
    point = (contacts.point - origin) / length
    point += farther_out(contacts, point)
    mass = np.tile(np.eye(6), (len(free), 1, 1))
    mass[:, 3:, 3:] = turning[free]
    mass *= (assembly.mass[free] / assembly.mass[free].mean())[:, None, None]
    rod = contacts.rod[joint] / length
    away = np.zeros((len(point), 2)) if gap is None else np.where(rod[:, None] > 0.0, 0.0, gap)
    ends = as_turned(joint_ends(assembly, contacts, carrier, away), turned)
    away = np.where(turned[:, None], away[:, ::-1], away)
    frame = contacts.frame[joint]
    far, back = rod[:, None] * frame[:, 0], turned[:, None]
    frame = np.where(turned[:, None, None], TURNED[:, None] * frame, frame)
    n = frame[:, 0]
    of_face = contacts.area[joint] * contacts.corner_share
    plates = contacts.ties[joint]
    area = np.where(plates, of_face, contacts.tributary)
    stiffness = _weights(area, joint)
    touching = ~away.any(axis=1)
    # all corners that touch carry the whole load together at the overlap; all, where none touches
    carrying = stiffness[touching].sum() if touching.any() else stiffness.sum()
    if carrying:
        stiffness = stiffness * (len(free) / (overlap * carrying))
    return Bodies(
        free=free,
        slot=slot,
        centroid=centroid,
        radius=radius,
        mass=mass,
        load=load / unit,
        arms=arms / unit,
        size=size / length,
        block_a=a,
        block_b=b,
        turned=turned,
        arm_a=point + np.where(back, 0.0, far) - away[:, :1] / length * n - centroid[a],
        arm_b=point + np.where(back, far, 0.0) + away[:, 1:] / length * n - centroid[b],
        rod=rod,
        frame=frame,
        ends=ends._replace(
            reach=ends.reach / length, place=ends.place / length, drawn=ends.drawn / length
        ),
        friction=contacts.friction[joint],
        normal=stiffness,
        tangential=tangential * stiffness,
        most=contacts.tie_strength[joint] * contacts.corner_share / unit,
        overlap=overlap,
        length_unit=length,
        force_unit=unit,
    )


def farther_out(contacts: Contacts, point: Floats) -> Floats:
    """How far (k, 3) the corners (k, 3) of followed blocks are taken as farther out, by length."""
    middle = contacts.corners.sum(point) / contacts.corners.counts[:, None]
    out = point - middle[contacts.interface]
    return SWAY * out / np.maximum(lengths(out), 1e-300)[:, None]


def turned_load(load: Floats, arms: Floats, turn: Floats) -> Floats:
    """A load (f, 6) on blocks that have turned by rotations (f, 3, 3).

    Forces keep their direction and act where they did on the block; couples stay.

    Parameters
    ----------
    load
    arms : (f, 3, 3)
        :func:`drystone.loads.applied.arms_of_loads`, scaled as the moments of the load.
    turn
    """
    if not arms.any():
        return load
    turned = load.copy()
    turned[:, 3:] += torques((turn - UNTURNED) @ arms)
    return turned


def numbered_axes(bodies: Bodies, axes: Floats) -> Floats:
    """Axes (k, 3, 3) of corners as the interfaces have them: n from block a to block b."""
    return np.where(bodies.turned[:, None, None], TURNED[:, None] * axes, axes)


def numbered_forces(bodies: Bodies, force: Floats) -> Floats:
    """Forces (k, 3) local n, u, v, on block b of the interfaces; or the same way back."""
    return np.where(bodies.turned[:, None], -TURNED * force, force)


def _weights(area: Floats, interface: Ints) -> Floats:
    """Tributary areas (k,), at least a share of the mean for slivers, lines and points."""
    if not area.any():
        return np.ones(len(area))
    count = np.bincount(interface)
    mean = np.bincount(interface, area) / np.maximum(count, 1)
    mean = np.where(mean > 0.0, mean, area.mean())
    return np.maximum(area, LEAST_AREA * mean[interface])


def gyration(assembly: Assembly) -> tuple[Floats, Floats]:
    """Inertia (n, 3, 3) about the centroid, by mass and radius squared, and that radius (n,) [m].

    The radius is that of gyration: root of the mean moment of inertia divided by mass. Independent
    of the axes of the model. No body has less than a ball of its volume; rounding would lead below
    that, and below zero, where a block is so thin that it has hardly a volume: it counts as a ball.
    """
    faces, volume = assembly.faces, assembly.volume[:, None, None]
    triangles, face = fan_triangles(faces)
    owner = faces.owner[face]
    a, b, c = (triangles - assembly.centroid[owner][:, None]).transpose(1, 0, 2)
    six = (a * cross(b, c)).sum(axis=1)
    squares = sum(x[:, :, None] * x[:, None] for x in (a + b + c, a, b, c))
    # of a tetrahedron over the centroid: integral of x x' is V / 20 times this sum
    sums = sum_by_owner((six[:, None, None] * squares).reshape(-1, 9), owner, len(assembly))
    spread = sums.reshape(-1, 3, 3) / (120.0 * volume)
    polar = np.trace(spread, axis1=1, axis2=2)[:, None, None]
    ball = (0.75 / np.pi * volume) ** (2.0 / 3.0)
    square = np.maximum(2.0 / 3.0 * polar, 0.4 * ball)
    known, one = square > 0.4 * ball, np.eye(3)
    inertia = np.where(known, (polar * one - spread) / square, one)
    return inertia, np.sqrt(square[:, 0, 0])


OUT_OF_REACH = 1.0
"""Gap of a corner that slid off a face, by the mean size of a block: it carries nothing."""


@dataclass(frozen=True, eq=False)
class BlockPositions:
    """The positions of all n blocks, scaled.

    Attributes
    ----------
    place : (n, 3) centroids
    turn : (n, 3, 3) rotation from the beginning
    """

    place: Floats
    turn: Floats

    def moved(self, blocks: Ints, motion: Floats) -> BlockPositions:
        """Some blocks moved by translations and rotation vectors (f, 6)."""
        place, turn = self.place.copy(), self.turn.copy()
        place[blocks] += motion[:, :3]
        turn[blocks] = rotations(motion[:, 3:]) @ turn[blocks]
        return BlockPositions(place, turn)


class Placed(NamedTuple):
    """The corners at one pose.

    Attributes
    ----------
    point : (k, 3) where the force acts
    axes : (k, 3, 3) rows n, u, v: n is the direction in which the gap grows
    gap : (k,) between the faces
    """

    point: Floats
    axes: Floats
    gap: Floats


def place_corners(bodies: Bodies, pose: BlockPositions) -> Placed:
    """Corners on the moved faces.

    The corner slides over the face of a by x(s), where s is the slide of b; the gap is that of the
    face of b there. A corner that is no longer on both faces is out of reach. A tie acts from end
    to end, each of which stays on its block.
    """
    # with the corner as the last index sums over k take a fifth of the time of matrix products
    turn = pose.turn.transpose(1, 2, 0).take(bodies.both, axis=-1)
    place = pose.place.T.take(bodies.both, axis=-1)
    k = len(bodies.block_a)
    of_a, of_b = bodies.by_corner
    turned = _product(turn[..., :k], of_a)
    on_a, frame = place[:, :k] + turned[0], turned[1:]
    # from the corner of a to that of b, and the normal of the face of b
    there = _product(turn[..., k:], of_b)
    there[0] += place[:, k:] - on_a
    apart, normal = _product(frame, there)
    carried, tangent, on = slid(bodies.ends, bodies.rails, apart[1:])
    lean, left = normal[1:].copy(), apart[1:] - carried
    gap = normal[0] * apart[0] + lean[0] * left[0] + lean[1] * left[1]
    normal[1:] -= np.einsum("ik,kij->jk", lean, tangent)
    point = on_a + np.einsum("ik,ijk->jk", carried, frame[1:])
    gap, rods = np.where(on, gap, OUT_OF_REACH), bodies.rods
    if len(rods):
        normal[:, rods] = -apart[:, rods]
        gap[rods] = bodies.rod[rods] - lengths(apart[:, rods].T)
        point[:, rods] = on_a[:, rods] + there[0][:, rods]
    axes = _product(frame.swapaxes(0, 1), _inclined(normal))
    last = np.ascontiguousarray(point.T), np.ascontiguousarray(axes.transpose(2, 0, 1))
    return Placed(*last, gap)


def _product(matrix: Floats, vectors: Floats) -> Floats:
    """(m, 3, k) of matrices (3, 3, k) and m vectors of each (m, 3, k)."""
    return np.einsum("ijk,mjk->mik", matrix, vectors)


def _inclined(normal: Floats) -> Floats:
    """Axes n, u, v (3, 3, k), orthonormal: n along (3, k), u in the plane of n and the second axis.

    Every v is normal to the second axis.
    """
    axes = np.zeros((3, *normal.shape))
    n, u, v = axes
    np.divide(normal, lengths(normal.T), out=n)
    np.multiply(-n[1], n, out=u)
    u[1] += 1.0
    size = lengths(u.T)
    u /= size
    np.divide(-n[2], size, out=v[0])
    np.divide(n[0], size, out=v[2])
    return axes


def rotation_vectors(turn: Floats) -> Floats:
    """(n, 3) of rotation matrices (n, 3, 3)."""
    from scipy.spatial.transform import Rotation  # slow to import

    return np.asarray(Rotation.from_matrix(turn).as_rotvec())
