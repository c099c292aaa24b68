"""The joints of one block with those in place: corners, normals, and the faces that they lie on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.display import OneLine
from drystone.contacts import Contacts

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
        fits = normal @ towards > 0.7
        away = np.where(fits, away, np.inf) if fits.any() else away
    face = int(np.argmin(away))
    x, y, z = (normal[face].round(6) + 0.0).tolist()
    return face, (x, y, z)


def _outward(loop: Floats) -> Floats:
    """Unit normal (3,) of a planar loop (c, 3)."""
    area = np.cross(loop[1:-1] - loop[0], loop[2:] - loop[0]).sum(axis=0)
    unit: Floats = area / np.linalg.norm(area)
    return unit


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
