"""Small free motions of a block at its joints: straight directions, and twists that rotate it.

A block is free to move along d when no joint closes: ``n . d >= 0`` for every joint with a block in
place, n pointing from that block into this one. All such d form a cone. With rotation a block moves
with the velocity v of its centroid and the angular velocity w. At a corner r of a joint, the joint
does not close when

    n . (v + w x (r - centroid)) >= 0.

All such twists (v, w) form a cone in six dimensions. It contains more than the zero motion if and
only if one of the twelve unit twists has a non-zero projection on it.

Source: Wilson and Latombe 1994 (directional blocking, and blocking graphs for infinitesimal
motions); the projection by nonnegative least squares is Moreau's decomposition.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.display import OneLine
from drystone.contacts import Contacts

TOLERANCE = 1e-3
"""Largest closing speed of a joint, relative to the size of the motion: 0.06 degrees for a
translation. Above the rounding of CAD files and well below any intended taper."""

FACING = 0.7
"""Cosine above which a face looks in a direction: 45 degrees, chosen."""
OPEN = 0.1
"""Least length of a projection that is not rounding. If the cone contains a motion, one of its six
components is at least 0.4, so some unit twist has a projection of at least 0.4."""


@dataclass(frozen=True, eq=False)
class FreeTwists:
    """Twists that close no joint.

    Attributes
    ----------
    twist : (t, 6)
        Velocity [size / s] and angular velocity [rad / s], unit; one for each unit twist with a
        projection on the cone. Empty if the block cannot move.
    blocking : (b,)
        Rows that together block every motion; empty if a motion is free.
    """

    twist: Floats
    blocking: Ints

    @property
    def blocked(self) -> bool:
        """Whether no small motion is free."""
        return not len(self.twist)


def twist_rows(corner: Floats, normal: Floats, centre: Floats, size: float) -> Floats:
    """Rows (c, 6); each row times a twist is the opening speed of a corner.

    Parameters
    ----------
    corner : (c, 3) [m]
    normal : (c, 3) unit
        Into the moving block.
    centre : (3,) [m]
        Of the moving block.
    size : [m]
        Size of the moving block; velocities are divided by it, so both parts of a twist have one
        unit.
    """
    return np.column_stack([normal, np.cross((corner - centre) / size, normal)])


def free_twists(rows: Floats) -> FreeTwists:
    """Twists x with ``rows @ x >= 0``, within the tolerance.

    Parameters
    ----------
    rows : (c, 6)
        Or (c, 3), normals only, for translations.

    Examples
    --------
    A block in a corner of three walls can be removed; in a closed box it cannot:

    >>> corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> up = twist_rows(corner, np.tile([0.0, 0.0, 1.0], (4, 1)), np.full(3, 0.5), 1.0)
    >>> free_twists(up).blocked
    False
    >>> both = np.concatenate([up, -up])
    >>> free_twists(np.concatenate([both, -both, np.eye(6), -np.eye(6)])).blocked
    True
    """
    size = rows.shape[1]
    units = np.concatenate([np.eye(size), -np.eye(size)])
    if not len(rows):
        return FreeTwists(units, np.zeros(0, dtype=np.intp))
    grid = 0.1 * TOLERANCE
    whole, first = np.unique(np.round(rows / grid), axis=0, return_index=True)
    distinct = whole * grid
    found, used = [], np.zeros(len(distinct), dtype=bool)
    for seed in units:
        factor, _ = nnls(distinct.T, -seed)
        rest = seed + distinct.T @ factor
        length = float(np.linalg.norm(rest))
        used |= factor > 0.0
        if length > OPEN and (distinct @ rest >= -TOLERANCE * length).all():
            found.append(rest / length)
    if not found:
        return FreeTwists(np.zeros((0, size)), first[used])
    twist = np.array(found)
    kept = np.sort(np.unique(np.round(twist, 4), axis=0, return_index=True)[1])
    return FreeTwists(twist[kept], np.zeros(0, dtype=np.intp))


def opens(rows: Floats, twist: Floats) -> bool:
    """Whether a twist (6,) closes no joint by more than the tolerance."""
    return bool((rows @ twist >= -TOLERANCE * np.linalg.norm(twist)).all())


@dataclass(frozen=True, eq=False)
class Freedom(OneLine):
    """Directions in which a block can be removed.

    Attributes
    ----------
    generators : (g, 3) unit
        Every free direction is a sum of these with non-negative factors; empty when blocked.
    preferred : (3,) unit, or None when blocked
        The free direction nearest to up.
    """

    generators: Floats
    preferred: Floats | None

    @property
    def blocked(self) -> bool:
        """Whether no translation is free."""
        return self.preferred is None


def freedom(normals: Floats, up: Floats, tolerance: float = TOLERANCE) -> Freedom:
    """The cone of directions d with ``normals @ d >= 0``.

    Parameters
    ----------
    normals : (j, 3) unit
    up : (3,) unit
    tolerance

    Examples
    --------
    A block on the floor can move up and sideways; a block between two walls only along them:

    >>> up = np.array([0.0, 0.0, 1.0])
    >>> freedom(np.array([[0.0, 0.0, 1.0]]), up).preferred.tolist()
    [0.0, 0.0, 1.0]
    >>> walls = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    >>> (freedom(walls, up).generators.round(6) + 0.0).tolist()
    [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]
    >>> freedom(np.concatenate([np.eye(3), -np.eye(3)]), up).blocked
    True
    """
    if not len(normals):
        axes = np.eye(3)
        return Freedom(np.concatenate([axes, -axes]), up)
    rounded = np.round(normals / (0.1 * tolerance))
    distinct = np.array(sorted({tuple(one) for one in rounded.tolist()})) * (0.1 * tolerance)
    squared, axes = np.linalg.eigh(distinct.T @ distinct)
    rank = int((squared > tolerance**2 * len(distinct)).sum())
    lineality = axes[:, : 3 - rank].T
    if rank == 1:
        candidates = np.concatenate([axes[:, 2:].T, -axes[:, 2:].T])
    elif rank == 2:
        across = np.cross(lineality[0], distinct)
        candidates = np.concatenate([across, -across])
    else:
        i, j = np.triu_indices(len(distinct), 1)
        across = np.cross(distinct[i], distinct[j])
        across = across[np.linalg.norm(across, axis=1) > tolerance]
        candidates = np.concatenate([across, -across])
    rays = np.concatenate([lineality, -lineality, _unit(candidates)])
    free = rays[(rays @ distinct.T >= -tolerance).all(axis=1)]
    if not len(free):
        return Freedom(free, None)
    alike: dict[tuple[float, ...], int] = {}
    for number, one in enumerate(np.round(free, 6).tolist()):
        alike.setdefault(tuple(one), number)
    free = free[list(alike.values())]
    if (distinct @ up >= -tolerance).all():
        return Freedom(free, up)
    share, _ = nnls(free.T, up)
    steepest = free.T @ share
    length = float(np.linalg.norm(steepest))
    if length < tolerance:
        steepest, length = free[int(np.argmax(free @ up))], 1.0
    return Freedom(free, steepest / length)


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors[length[:, 0] > 0.0] / length[length[:, 0] > 0.0]


NAMED = 6
"""Number of faces named in a reason. Chosen. The others are counted."""


@dataclass(frozen=True, eq=False)
class Joints:
    """Interfaces of a block with others, normals into the block.

    Attributes
    ----------
    other : (j,)
        The block on the other side.
    normal : (j, 3) unit
    corner : (c, 3) [m]
    interface : (c,)
        Joint of each corner.
    """

    other: Ints
    normal: Floats
    corner: Floats
    interface: Ints

    @classmethod
    def of(cls, contacts: Contacts, block: int, here: Bools) -> Joints:
        """The joints of one block with the blocks (n,) that are in place."""
        as_b = (contacts.block_b == block) & here[contacts.block_a]
        as_a = (contacts.block_a == block) & here[contacts.block_b]
        chosen = as_a | as_b
        sign = np.where(as_b, 1.0, -1.0)[:, None]
        kept = chosen[contacts.interface]
        return cls(
            np.where(as_b, contacts.block_a, contacts.block_b)[chosen],
            (sign * contacts.frame[:, 0])[chosen],
            contacts.point[kept],
            (np.cumsum(chosen) - 1)[contacts.interface[kept]].astype(np.intp),
        )

    def rows(self, body: Block) -> Floats:
        """Rows (c, 6) of :func:`twist_rows` of the block, one for each corner."""
        return twist_rows(self.corner, self.normal[self.interface], body.centroid, body.size)


@dataclass(frozen=True)
class Obstacle(OneLine):
    """A face of a block that blocks a motion.

    Attributes
    ----------
    block
        Position of the block.
    face
        Position of the face in ``block.faces``.
    name
        Of the block.
    towards
        Outward unit normal of the face.
    """

    block: int
    face: int
    name: str
    towards: tuple[float, float, float]

    def __str__(self) -> str:
        return f"face {self.face} of '{self.name}' (facing {looking(self.towards)})"


def obstacles(assembly: Assembly, joints: Joints, which: Iterable[int]) -> tuple[Obstacle, ...]:
    """The faces of the other blocks at some joints, each once, in the order of blocks."""
    found = set()
    for joint in which:
        other = int(joints.other[joint])
        middle = joints.corner[joints.interface == joint].mean(axis=0)
        face, normal = face_at(assembly.blocks[other], middle, joints.normal[joint])
        found.add(Obstacle(other, face, assembly.names[other], normal))
    return tuple(sorted(found, key=lambda one: (one.block, one.face)))


def in_words(faces: Sequence[Obstacle]) -> str:
    """The first of some faces by name, and the number of others."""
    text = "; ".join(str(face) for face in faces[:NAMED])
    more = len(faces) - NAMED
    return f"{text}; and {more} more" if more > 0 else text


def face_at(
    block: Block, point: Floats, towards: Floats | None = None
) -> tuple[int, tuple[float, float, float]]:
    """The face of a block whose plane is nearest to a point, and its outward normal.

    Parameters
    ----------
    block
    point : (3,) [m]
    towards : (3,) unit, optional
        If possible, only faces with a normal within 45 degrees of this direction.
    """
    corners = [block.vertices[list(face)] for face in block.faces]
    normal = np.array([_outward(loop) for loop in corners])
    away = np.abs((np.array([loop[0] - point for loop in corners]) * normal).sum(axis=1))
    if towards is not None:
        fits = normal @ towards > FACING
        away = np.where(fits, away, np.inf) if fits.any() else away
    face = int(np.argmin(away))
    x, y, z = (normal[face].round(6) + 0.0).tolist()
    return face, (x, y, z)


def _outward(loop: Floats) -> Floats:
    """Unit normal (3,) of a planar loop (c, 3)."""
    area = np.cross(loop[1:-1] - loop[0], loop[2:] - loop[0]).sum(axis=0)
    return area / np.linalg.norm(area)


def looking(towards: Iterable[float]) -> str:
    """A direction as text: up, down, or the nearest axis.

    Examples
    --------
    >>> looking((0.0, 0.1, 0.99)), looking((-1.0, 0.0, 0.0))
    ('up', '-x')
    """
    vector = np.asarray(tuple(towards))
    axis = int(np.argmax(np.abs(vector)))
    if axis == 2:
        return "up" if vector[2] > 0.0 else "down"
    return f"{'+' if vector[axis] > 0.0 else '-'}{'xy'[axis]}"
