"""The proof of a verdict, recomputed from points and cross products.

Nothing here uses the matrices of the solvers. A force residual is divided by what acts on its
block: the load and the forces at its corners. A length is divided by the largest displacement at a
corner of the block. A small block on a large one is therefore checked at its own scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import ROUNDING, Bools, Floats, cross, dot, lengths
from drystone.base.display import OneLine
from drystone.contacts import Contacts
from drystone.geometry.stress_block import cut_off, stress_block
from drystone.joint_capacity import NO_LIMIT
from drystone.model import Model

FORCE_TOLERANCE = 1e-8
"""Largest residual of a claim of equilibrium, dimensionless."""
_PRESSED = 1e-7
"""A corner that carries force overlaps by at least this share of the largest displacement at the
blocks that meet there, or in proportion. Less is rounding, and a force there would be prestress."""

_STIFFEST = 100.0
"""Share of the forces on a block that a corner may carry by such an overlap. In rest states of a
pile with 23,000 corners it is 0.05 to 25: among so many, some only just touch."""


_LARGEST = 1e130
"""[N, N m, m, rad] Beyond it squares and products of forces and motions do not fit a float. Loads
are 1e100 at most."""

MOVING = 0.05
"""Motions of a corner below this share of the largest of its joint count as zero, to distinguish
hinges from sliding joints in pictures. Chosen."""


@dataclass(frozen=True)
class Residuals(OneLine):
    """How well each condition is met, recomputed from points and cross products.

    All dimensionless: forces by mean block weight, lengths by block size.

    Attributes
    ----------
    equilibrium
        Largest unbalanced component on any block.
    tension
        Largest pull.
    cone
        Largest excess of friction over the coefficient times the normal force.
    crushing
        Largest excess of the normal force over what a stress block centred there carries.
    complementarity
        Largest product of normal force and opening.
    alignment
        Largest component of friction that does not act against the displacement.
    overlap
        Largest difference of the overlaps of pressed corners, by their mean (eq. 5.6 only).
    """

    equilibrium: float = 0.0
    tension: float = 0.0
    cone: float = 0.0
    crushing: float = 0.0
    complementarity: float = 0.0
    alignment: float = 0.0
    overlap: float = 0.0

    @property
    def largest(self) -> float:
        """The worst of them."""
        return max(vars(self).values())


def corner_motion(assembly: Assembly, contacts: Contacts, motion: Floats) -> Floats:
    """Relative displacement (k, 3) of block b against a at each corner, local n, u, v.

    Parameters
    ----------
    motion : (n, 6) translation of the centroid and rotation vector of each block, world axes
    """
    of_a, of_b = corner_motions(assembly, contacts, motion)
    return np.einsum("kij,kj->ki", contacts.frame.take(contacts.interface, axis=0), of_b - of_a)


def unbalanced_wrench(model: Model, force: Floats) -> tuple[Floats, Floats]:
    """Sum of all wrenches (n, 6) on each block about its centroid, and the size (n,) of its forces.

    Parameters
    ----------
    force : (k, 3) [N], local n, u, v, on block b

    Returns
    -------
    wrench : (n, 6) [N, N m]; the moments are divided by the block's size: [N]
    scale : (n,) [N]
    """
    assembly, contacts, load = model.assembly, model.contacts, model.load
    world = np.einsum("ki,kij->kj", force, contacts.frame.take(contacts.interface, axis=0))
    size = assembly.size
    wrench = np.concatenate([load.wrench[:, :3], load.wrench[:, 3:] / size[:, None]], axis=1)
    scale = lengths(wrench[:, :3]) + lengths(wrench[:, 3:])
    total = np.concatenate([wrench, scale[:, None]], axis=1)
    joints = contacts.corners
    pushed, strength = joints.sum(world), joints.sum(lengths(force))
    # moments about the first corner of each joint, which are then taken to the centroids
    first = contacts.point[contacts.start[:-1]]
    arm = contacts.point - first.take(contacts.interface, axis=0)
    about_first = joints.sum(cross(arm, world))
    block = np.concatenate([contacts.block_a, contacts.block_b])
    onto = np.concatenate([-pushed, pushed])
    arms = np.concatenate([first, first]) - assembly.centroid.take(block, axis=0)
    turned = np.concatenate([-about_first, about_first]) + cross(arms, onto)
    turned /= size[block, None]
    each = np.concatenate([strength, strength])[:, None]
    added = np.concatenate([onto, turned, each], axis=1)
    place = 7 * block[:, None] + np.arange(7)
    np.add.at(total.reshape(-1), place.ravel(), added.ravel())  # one by one is fast in numpy
    scale = total[:, 6]
    return total[:, :6], np.where(scale > 0.0, scale, 1.0)


def check_forces(
    model: Model,
    force: Floats,
    displacement: Floats | None = None,
    *,
    prop: Floats | None = None,
    pull: Floats | None = None,
) -> Residuals:
    """Residuals of a claim of equilibrium, with a compatible motion when one is given.

    Numbers that are not finite, or whose products are not, prove nothing: their residual is
    infinite.

    Parameters
    ----------
    force : (k, 3) [N], local n, u, v, on block b
    displacement : (n, 6) [m, rad], optional
        Virtual motion of the blocks; fixed blocks rest.
    prop : (n, 6) [N, N m], optional
        What props supply to the blocks.
    pull : (k,) [N], optional
        What pulls at corners of faces that crush, within the capacity, so that others press more;
        left out, the negative normal forces.
    """
    assembly, contacts = model.assembly, model.contacts
    claimed = [one for one in (force, displacement, prop) if one is not None and one.size]
    if not all(np.abs(one).max() <= _LARGEST for one in claimed):
        return Residuals(equilibrium=np.inf)
    free = ~assembly.fixed
    total, scale = unbalanced_wrench(model, force)
    if prop is not None:
        total[:, :3] += prop[:, :3]
        total[:, 3:] += prop[:, 3:] / assembly.size[:, None]
    equilibrium = _most(lengths(total[free]) / scale[free])
    if not contacts.corner_count:
        return Residuals(equilibrium)
    a, b = contacts.corner_blocks
    local = np.minimum(scale[a], scale[b])
    normal = force[:, 0]
    tangential = lengths(force[:, 1:])
    friction = contacts.friction[contacts.interface]
    most, cohesion, shear = contacts.corner_capacity
    tension = _most(np.maximum(0.0, -normal - most) / local)
    bound = friction * np.maximum(normal, -most) + cohesion
    cone = _most(np.maximum(0.0, tangential - np.minimum(bound, shear)) / local)
    pulled = np.maximum(0.0, -normal) if pull is None else np.clip(pull.ravel(), 0.0, most)
    excess = normal_force_by_strength(contacts, normal + pulled)[1]
    crushing = _most(excess / contacts.corners.min(local))
    if displacement is None:
        return Residuals(equilibrium, tension, cone, crushing)
    of_motion = _motion_residuals(model, force / local[:, None], displacement)
    return Residuals(equilibrium, tension, cone, crushing, *of_motion)


def normal_force_by_strength(contacts: Contacts, normal: Floats) -> tuple[Floats, Floats]:
    """Normal force by what a stress block centred there carries, and its excess over that [N].

    Parameters
    ----------
    normal : (k,) [N]
        What presses at each corner.

    Returns
    -------
    use : (m,)
        1 crushes; 0 for joints without a finite strength, and where only rounding presses.
    excess : (m,) [N]
        Zero at least.
    """
    use, excess = np.zeros((2, contacts.count))
    finite = np.flatnonzero(contacts.crushes)
    if not len(finite) or contacts.capacity is None:
        return use, excess
    loops, corner, flat = contacts.flat_corners(finite)
    whole = loops.sum(normal[corner])
    pressed = whole > 0.0
    at = loops.sum(normal[corner, None] * flat) / np.where(pressed, whole, 1.0)[:, None]
    area = contacts.area[finite]
    share = stress_block(flat, loops.start, at)[0] / np.where(area > 0.0, area, 1.0)
    carried = contacts.capacity.compression[finite] * share
    loaded = whole > ROUNDING * whole.max(initial=0.0)
    use[finite] = np.where(loaded, whole / np.maximum(carried, 1e-300), 0.0)
    excess[finite] = np.where(pressed, np.maximum(whole - carried, 0.0), 0.0)
    return use, excess


def _motion_residuals(model: Model, force: Floats, displacement: Floats) -> tuple[float, float]:
    """Complementarity and alignment of forces (k, 3), each by that of its corner, and a motion."""
    assembly, contacts = model.assembly, model.contacts
    a, b = contacts.corner_blocks
    normal, tangential = force[:, 0], lengths(force[:, 1:])
    moved = corner_motion(assembly, contacts, displacement)
    reach = lengths(moved)
    largest = np.zeros(len(assembly))
    farthest = contacts.corners.max(reach)
    np.maximum.at(largest, contacts.block_a, farthest)
    np.maximum.at(largest, contacts.block_b, farthest)
    length = np.minimum(largest[a], largest[b])
    safe = np.where(length > 0.0, length, 1.0)
    opening = np.maximum(0.0, moved[:, 0]) / safe
    overlap = np.maximum(0.0, -moved[:, 0]) / safe
    unpressed = np.clip(1.0 - overlap / _PRESSED, 0.0, 1.0)
    prestress = np.maximum(0.0, normal - _STIFFEST * overlap) * np.maximum(opening, unpressed)
    pulled = np.maximum(0.0, -normal) * (moved[:, 0] <= 0.0)
    slide = lengths(moved[:, 1:])
    still = slide <= 1e-13 * safe
    direction = moved[:, 1:] / np.where(still, 1.0, slide)[:, None]
    wrong = lengths(force[:, 1:] + tangential[:, None] * direction)
    wrong = np.where(still, tangential, wrong)
    alignment = np.where(tangential > ROUNDING, wrong, 0.0)
    return _most(np.maximum(prestress, pulled)), _most(alignment)


def _most(values: Floats) -> float:
    """The largest; 0 if there are none."""
    return float(values.max(initial=0.0))


def mechanism_defects(model: Model, motion: Floats) -> tuple[float, float]:
    """Residuals of a motion as a collapse mechanism (Farkas certificate).

    Where every corner opens at least as fast as friction times its slide and the loads do work,
    no contact forces can balance the loads. Source: Livesley 1978 for the associated
    flow rule. Joints that pull or cohere resist: the loads must do more work than the most that
    any admissible forces of these joints can take up (the kinematic theorem). A corner that only
    slides while its shear is limited need not open. A joint that crushes may close: its stress
    block resists.

    Returns
    -------
    violation
        Largest ``mu |slide| - opening`` at a corner, by the largest speed of the two blocks there.
    power
        Work of the loads, less what joints resist, by the sum of its absolute parts: positive for
        a proof, at most 1.
    """
    assembly, contacts = model.assembly, model.contacts
    moved, crushed = _less_crushing(contacts, corner_motion(assembly, contacts, motion))
    violation = float(_closing(model, moved, motion).max(initial=0.0))
    free = ~assembly.fixed
    parts = model.load.wrench[free] * motion[free]
    opening, slide = np.maximum(moved[:, 0], 0.0), lengths(moved[:, 1:])
    resisted = float(_resistance(contacts, opening, slide).sum() + crushed.sum())
    gross = float(np.abs(parts).sum()) + resisted
    return violation, (float(parts.sum()) - resisted) / gross if gross > 0.0 else 0.0


def closing(model: Model, motion: Floats) -> Floats:
    """``mu |slide| - opening`` (k,) at each corner, by the largest speed of the two blocks there.

    Zero where it opens fast enough; see :func:`mechanism_defects`.
    """
    moved = corner_motion(model.assembly, model.contacts, motion)
    return _closing(model, _less_crushing(model.contacts, moved)[0], motion)


def crushed_most(model: Model, motion: Floats) -> int | None:
    """The interface that takes most power to crush in a mechanism (n, 6); None where none does."""
    power = _less_crushing(model.contacts, corner_motion(model.assembly, model.contacts, motion))[1]
    return int(np.argmax(power)) if power.max(initial=0.0) > 0.0 else None


def crushing_share(model: Model, motion: Floats) -> float:
    """The share that crushing takes of what resists a mechanism (n, 6); weights take the rest."""
    moved = corner_motion(model.assembly, model.contacts, motion)
    crushed = float(_less_crushing(model.contacts, moved)[1].sum())
    free = ~model.assembly.fixed
    lifted = -np.minimum((model.load.wrench[free] * motion[free]).sum(axis=1), 0.0).sum()
    return crushed / (crushed + float(lifted)) if crushed > 0.0 else 0.0


def _less_crushing(contacts: Contacts, moved: Floats) -> tuple[Floats, Floats]:
    """Corner motions (k, 3) less what faces are crushed by, and the power (m,) that this takes.

    A face is crushed by a plane w over it: no forces within the strength f do more work on it than
    ``f integral(max(0, w))``. It is chosen so that all corners open as fast as friction asks.
    """
    finite = np.flatnonzero(contacts.crushes)
    power = np.zeros(contacts.count)
    if not len(finite) or contacts.capacity is None:
        return moved, power
    loops, corner, flat = contacts.flat_corners(finite)
    bounded = contacts.corner_capacity[2][corner] < NO_LIMIT
    friction = np.where(bounded, 0.0, contacts.friction[contacts.interface[corner]])
    short = friction * lengths(moved[corner, 1:]) - moved[corner, 0]
    plane = np.zeros((len(finite), 3))
    for i in range(len(finite)):
        rows = loops[i]
        lever = np.column_stack([np.ones(rows.stop - rows.start), flat[rows]])
        plane[i] = np.linalg.lstsq(lever, short[rows], rcond=None)[0]
    height = loops.spread(plane[:, 0]) + dot(flat, loops.spread(plane[:, 1:]))
    plane[:, 0] += np.maximum(loops.max(short - height), 0.0)
    pulls = loops.max(contacts.corner_capacity[0][corner]) > 0.0
    plane[(loops.max(short) <= 0.0) & ~pulls] = 0.0
    height = loops.spread(plane[:, 0]) + dot(flat, loops.spread(plane[:, 1:]))
    area = contacts.area[finite]
    stress = contacts.capacity.compression[finite] / np.where(area > 0.0, area, 1.0)
    power[finite] = stress * dot(cut_off(flat, loops.start, plane), plane)
    most = np.where(contacts.corner_capacity[0] < NO_LIMIT, contacts.corner_capacity[0], 0.0)
    power[finite] += loops.sum(most[corner] * np.maximum(-height, 0.0))
    less = moved.copy()
    less[corner, 0] += height
    return less, power


def _closing(model: Model, moved: Floats, motion: Floats) -> Floats:
    """The same for known corner displacements (k, 3)."""
    assembly, contacts = model.assembly, model.contacts
    friction = contacts.friction[contacts.interface]
    slide = lengths(moved[:, 1:])
    pull, cohesion, shear = contacts.corner_capacity
    short = np.where(shear < NO_LIMIT, 0.0, friction * slide) - moved[:, 0]
    # joints without limits do not move
    short = np.where(pull >= NO_LIMIT, np.abs(moved[:, 0]), short)
    short = np.where(np.minimum(cohesion, shear) >= NO_LIMIT, np.maximum(short, slide), short)
    speed = block_speed(assembly, motion)
    a, b = contacts.corner_blocks
    local = np.maximum(speed[a], speed[b])
    reference = np.maximum(local, 1e-9 * max(float(speed.max(initial=0.0)), 1e-300))
    return np.maximum(0.0, short) / reference


def _resistance(contacts: Contacts, opening: Floats, slide: Floats) -> Floats:
    """(k,) most power that admissible forces of each corner take up, of one that opens and slides.

    The largest of ``-fn dn + |ft| |dt|``, at the ends of the edges of the admissible set: pulled as
    far as it can be, and pressed until friction reaches the limit of shear.
    """
    pull, cohesion, shear = (np.where(c < NO_LIMIT, c, 0.0) for c in contacts.corner_capacity)
    bounded = contacts.corner_capacity[2] < NO_LIMIT
    shear = np.where(bounded, shear, np.inf)
    friction = contacts.friction[contacts.interface]
    torn = np.minimum(cohesion - friction * pull, shear)
    least: Floats = np.where(pull > 0.0, pull * opening, 0.0) + np.where(
        torn > 0.0, torn * slide, 0.0
    )
    pressed = bounded & (shear > cohesion) & (friction > 0.0)
    shear = np.where(pressed, shear, 0.0)
    normal = np.where(pressed, shear - cohesion, 0.0) / np.where(friction > 0.0, friction, 1.0)
    return np.where(pressed, np.maximum(least, shear * slide - normal * opening), least)


def moving_joints(
    model: Model, motion: Floats, toward: Floats | None = None
) -> tuple[Bools, Bools, Floats]:
    """Joints at which a first motion hinges about an edge, and joints at which it slides.

    Parameters
    ----------
    motion : (n, 6) [m, rad]
    toward : (3,)
        Where an eye is that is to see the places of hinges, which else are inside.

    Returns
    -------
    hinge, slide : (m,)
        Interfaces whose blocks turn about corners that stay closed; whose blocks slide along each
        other. Those that slide on an edge are both, those that lift off wholly are neither.
    place : (m, 3) [m]
        Middle of the corners that stay closed, or the one nearest to the eye; where there are
        none, of all corners.
    """
    contacts = model.contacts
    if contacts.count == 0:
        return np.zeros(0, dtype=bool), np.zeros(0, dtype=bool), np.zeros((0, 3))
    moved = corner_motion(model.assembly, contacts, motion)
    reach, interface = lengths(moved), contacts.interface
    corners = contacts.corners
    most = corners.max(reach)
    moving = most > MOVING * float(most.max())
    small = MOVING * most[interface]
    still = reach < small
    resting = corners.any(still)
    closed = np.abs(moved[:, 0]) < small
    hinge = moving & (resting | (corners.any(closed) & corners.any(moved[:, 0] > small)))
    sliding = lengths(moved[:, 1:])
    friction = contacts.friction[interface]
    along = (sliding > small) & (np.abs(moved[:, 0]) < friction * sliding + small)
    slide = moving & ~resting & corners.any(along)
    edge = np.where(resting[interface], still, closed)
    if toward is not None:
        near = np.where(edge, contacts.point @ toward, -np.inf)
        edge = near >= corners.max(near)[interface]
    kept = np.where(hinge[interface], edge, True).astype(float)
    place: Floats = corners.sum(kept[:, None] * contacts.point) / corners.sum(kept)[:, None]
    return hinge, slide, place


def turning_joints(model: Model, motion: Floats, slide: Bools) -> Bools:
    """Which of the joints that slide (m,) turn about a point within them, in a first motion (n, 6).

    Their corners then slide in directions that no half of all directions holds.
    """
    contacts = model.contacts
    moved = corner_motion(model.assembly, contacts, motion)[:, 1:]
    angle = np.arctan2(moved[:, 1], moved[:, 0])
    turns = np.zeros(contacts.count, dtype=bool)
    for i in np.flatnonzero(slide & (np.diff(contacts.start) > 2)).tolist():
        around = np.sort(angle[contacts.start[i] : contacts.start[i + 1]])
        between = np.diff(around, append=around[0] + 2.0 * np.pi)
        turns[i] = between.max() < np.pi - MOVING
    return turns


def block_speed(assembly: Assembly, motion: Floats) -> Floats:
    """(n,) translation plus rotation times size: a bound on the speed of a block's corners."""
    return lengths(motion[:, :3]) + assembly.size * lengths(motion[:, 3:])


def accelerations(assembly: Assembly, wrench: Floats) -> Floats:
    """Accelerations (n, 6) of the free blocks under wrenches (n, 6) [N, N m] about their centroids.

    A block turns as the box around it does.
    """
    free, mass = assembly.free, assembly.mass
    bounds = assembly.bounds[free]
    turning = mass[free] * ((bounds[:, 1] - bounds[:, 0]) ** 2).sum(axis=1) / 12.0
    motion = np.zeros((len(assembly), 6))
    motion[free, :3] = wrench[free, :3] / mass[free, None]
    motion[free, 3:] = wrench[free, 3:] / turning[:, None]
    return motion


def first_motion_of(model: Model, prop: Floats) -> Floats:
    """The first motion (n, 6) of blocks when props that exert wrenches (n, 6) are removed.

    The wrench of a prop is the mass of the block times its acceleration without the prop. The
    fastest corner moves by the mean size of a block.
    """
    return normalised(model.assembly, accelerations(model.assembly, 0.0 - prop))


def normalised(assembly: Assembly, motion: Floats) -> Floats:
    """The same motion (n, 6), its fastest block moving by the mean size of a free block."""
    fastest = float(block_speed(assembly, motion).max(initial=0.0))
    size = assembly.size[assembly.free]
    return motion * (float(size.mean()) / fastest) if fastest > 0.0 else motion


def corner_motions(assembly: Assembly, contacts: Contacts, motion: Floats) -> Floats:
    """Displacements (2, k, 3), world axes, of each corner as a point of block a and of block b."""
    blocks = contacts.corner_blocks
    of_block = np.where(assembly.fixed[:, None], 0.0, motion).take(blocks, axis=0)
    arm = contacts.point - assembly.centroid.take(blocks, axis=0)
    return of_block[..., :3] + cross(of_block[..., 3:], arm)
