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

An assembly interlocks when, with some blocks fixed and without friction, it is in equilibrium under
every load. It is if and only if no motion of its blocks is free, that is, opens joints or slides
along them:

    B q >= 0  has no solution but q = 0,

with a row of B for each corner of a joint: the speed at which it opens. A linear program searches
for a motion that opens some joint. If there is none, a free motion can only slide; it lies in the
null space of B. Source: Wang, Song, Pauly 2018 ("DESIA", ACM Trans. Graph. 37 (6)); Wang, Song,
Isvoranu, Pauly 2019 ("Design and structural optimization of topological interlocking assemblies",
ACM Trans. Graph. 38 (6)), who show that this is the same as equilibrium under every load.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np
from scipy import sparse

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.answer.drawing import bare_scene, seen
from drystone.assembly import Assembly, Block
from drystone.base.arrays import SAME, Bools, Floats, Ints, places
from drystone.base.declared import Offered
from drystone.base.display import OneLine, named
from drystone.base.errors import InputError, SolverError, counted
from drystone.contacts import Contacts
from drystone.io.opening import Given, How, as_model
from drystone.model import Model
from drystone.solvers.program import ConicStatus, ProgramBuilder

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
    from scipy.optimize import nnls  # slow to import

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
        Largest part of a unit direction along a normal, against it, that is allowed.

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
    from scipy.optimize import nnls  # slow to import

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


SLIDES = 1e-7
"""Squares of singular values of B below this share of the largest are zero. Chosen: well above
rounding."""


@dataclass(frozen=True, eq=False)
class Interlocking(Answer):
    """Whether an assembly interlocks.

    Attributes
    ----------
    model
        With the key fixed.
    holds
        Whether no motion is free: it carries every load without friction.
    motion : (n, 6) or None
        Translation [m] and rotation vector [rad] of each block in a free motion; the fastest block
        moves by 1 m. None where it holds.
    moving
        Positions of the blocks that move in it.
    first
        Positions of the blocks that can move while all others are at rest. They can be removed
        first.
    """

    model: Model
    holds: bool
    motion: Floats | None
    moving: tuple[int, ...]
    first: tuple[int, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the blocks that can move alone."""
        return tuple(self.model.assembly.names[b] for b in self.first)

    @property
    def title(self) -> str:
        """Whether it interlocks."""
        return "Interlocks" if self.holds else "Does not interlock"

    def sentences(self) -> Sequence[Sentence]:
        """Whether it interlocks, and what can move."""
        if self.holds:
            told = "no motion opens its joints or slides along them: it carries every load"
            return [Sentence(self.title, Role.GOOD), Sentence(told)]
        alone = f"blocks that can move alone: {named(self.names) or 'none'}"
        told = f"{counted(len(self.moving), 'block')} can move together without friction"
        return [Sentence(self.title, Role.BAD), Sentence(told), Sentence(alone)]

    def layers(self) -> Scene:
        """The free motion."""
        scene = bare_scene(self.model)
        motion = None if self.motion is None else seen(self.assembly, self.motion)
        told = "; ".join(one.text for one in self.sentences()[1:])
        stage = replace(
            scene.stages[0], headline=self.title, message=told, motion=motion,
            motion_name="Free motion", plays=motion is not None,
        )  # fmt: skip
        return replace(scene, title=self.title, stages=(stage,))

    def numbers(self) -> Mapping[str, Any]:
        """Whether it holds, what moves, and how."""
        names = self.assembly.names
        return {
            "holds": self.holds,
            "moving": [names[block] for block in self.moving],
            "can_move_alone": self.names,
            "motion": self.motion,
        }


def interlocking(
    given: Given, key: int | str | Sequence[int | str] | None = None, **how: Unpack[How]
) -> Interlocking:
    """Whether an assembly with a fixed key holds under every load without friction.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    key
        The block or blocks that are held; the supports of the model when left out. For a puzzle
        with a sliding key, hold the key and one other piece: with the key alone fixed, all other
        pieces may slide away together.

    Raises
    ------
    InputError
        Nothing is fixed, or a name is not known.

    Examples
    --------
    >>> from drystone.models import tower
    >>> found = interlocking(tower(3))
    >>> found.holds, found.names
    (False, ('block-1', 'block-2'))
    """
    model = as_model(given, **how)
    model.require_ends_as_drawn("a search for motions")
    if key is not None:
        model = model.with_supports([key] if isinstance(key, int | str) else list(key))
    assembly = model.assembly
    if not assembly.fixed.any():
        raise InputError("nothing is fixed", where="key", remedy="name the block that is held")
    first = tuple(b for b in assembly.free.tolist() if not _alone(model, b))
    rows = opening_rows(model)
    motion = _opening(rows) if rows.shape[1] else None
    if motion is None:
        motion = _sliding(rows)
    if motion is None:
        return Interlocking(model, True, None, (), first)
    whole = np.zeros((len(assembly), 6))
    whole[assembly.free] = motion.reshape(-1, 6)
    whole[:, :3] *= assembly.size[:, None]
    speed = np.linalg.norm(whole[:, :3], axis=1) + np.linalg.norm(
        whole[:, 3:] * assembly.size[:, None], axis=1
    )
    moving = tuple(np.flatnonzero(speed > 1e-6 * speed.max()).tolist())
    return Interlocking(model, False, whole / speed.max(), moving, first)


def opening_rows(model: Model) -> sparse.csr_matrix:
    """Rows (k, 6 f) that give the opening speed of each corner from the twists of f free blocks.

    Velocities are relative to the size of each block. Corners between two fixed blocks are omitted.
    """
    assembly, contacts = model.assembly, model.contacts
    place = places(assembly.free, len(assembly))
    corner = np.flatnonzero(model.active[contacts.interface])
    joint = contacts.interface[corner]
    normal = contacts.frame[joint, 0]
    row, column, value = [], [], []
    for side, sign in ((contacts.block_b[joint], 1.0), (contacts.block_a[joint], -1.0)):
        size = assembly.size[side][:, None]
        arm = (contacts.point[corner] - assembly.centroid[side]) / size
        entries = sign * np.column_stack([normal, np.cross(arm, normal)]) * size
        some = np.flatnonzero(place[side] >= 0)
        row.append(np.repeat(some, 6))
        column.append((6 * place[side[some]][:, None] + np.arange(6)).ravel())
        value.append(entries[some].ravel())
    scale = float(assembly.size.mean())
    return sparse.csr_matrix(
        (np.concatenate(value) / scale, (np.concatenate(row), np.concatenate(column))),
        shape=(len(corner), 6 * len(assembly.free)),
    )


def _alone(model: Model, block: int) -> bool:
    """Whether the joints with all other blocks block every motion of one block."""
    here = np.ones(len(model.assembly), dtype=bool)
    joints = Joints.of(model.contacts, block, here)
    body = model.assembly.blocks[block]
    return free_twists(joints.rows(body)).blocked


def _opening(rows: sparse.csr_matrix) -> Floats | None:
    """A motion that opens some corners and closes none; None where there is none."""
    count, size = rows.shape
    if not count:
        return np.ones(size)
    # openings are between zero and one
    program = ProgramBuilder()
    motion = program.variable("motion", size, quadratic=1e-9)
    opening = program.variable("opening", count, linear=-1.0)
    program.at_most("speed", np.zeros(count), (motion, -rows), (opening, 1.0))
    program.at_most("largest opening", np.ones(count), (opening, 1.0))
    program.at_most("least opening", np.zeros(count), (opening, -1.0))
    found = program.build().solve()
    if found.status is not ConicStatus.SOLVED:
        raise SolverError("the linear program of interlocking was not solved")
    speed = found.x[motion.place]
    opened = float(np.minimum(rows @ speed, 1.0).sum())
    return speed if opened > SAME * count else None


def _sliding(rows: sparse.csr_matrix) -> Floats | None:
    """A motion that slides along all joints and opens none; None where there is none."""
    gram = (rows.T @ rows).toarray()
    if not len(gram):
        return None
    square, vector = np.linalg.eigh(gram)
    return vector[:, 0] if square[0] < SLIDES * max(square[-1], 1e-300) else None


OFFERED = Offered(interlocking, "arch.json --supports springer-left,springer-right", names=())
