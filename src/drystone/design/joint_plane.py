"""The plane joint of two blocks, and the faces of their bodies that lie in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from drystone.assembly import Block, replace_block
from drystone.base.arrays import Floats, frozen
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.geometry.polygon import area_vector
from drystone.geometry.polyhedron import Loop, Piece
from drystone.model import Model

_WHOLE = 0.999
"""A block ends at a joint when the joint covers at least this share of its face, chosen."""

ON = 1e-4
"""A vertex is on the plane of a joint when it is nearer than this share of the size of the block,
chosen: contacts are found within a gap of 5e-3, files give coordinates to 1e-6."""


@dataclass(frozen=True, eq=False)
class JointPlane(OneLine):
    """One plane joint between two blocks, with the data for new cuts.

    Attributes
    ----------
    interface
    block_a, block_b
    frame : (3, 3)
        Rows n, u, v; n from block a to block b; u is horizontal where the joint allows it.
    centre : (3,) [m]
    outline : (c, 2) [m]
        Convex, counter-clockwise, in u and v about the centre.
    """

    interface: int
    block_a: int
    block_b: int
    frame: Floats
    centre: Floats
    outline: Floats

    @property
    def normal(self) -> Floats:
        """(3,) unit, from block a to block b."""
        normal: Floats = self.frame[0]
        return normal

    def reach(self, direction: Floats) -> tuple[float, float]:
        """Extent of the outline backward and forward along a direction (3,) [m]."""
        along = self.outline @ (self.frame[1:] @ direction)
        return float(along.min()), float(along.max())


def joint_plane(model: Model, interface: int, first: int | None = None) -> JointPlane:
    """The joint at an interface.

    Parameters
    ----------
    model
    interface
    first
        Which of the two blocks is block a; left out, that of the contacts.

    Raises
    ------
    InputError
        It is a line, a point, or not convex.
    """
    contacts = model.contacts
    found = contacts[interface]
    a, b = found.blocks
    frame = found.frame
    if first is not None and first != a:
        a, b, frame = b, a, frame * np.array([[-1.0], [-1.0], [1.0]])
    where = f"the joint of '{model.assembly.names[a]}' and '{model.assembly.names[b]}'"
    if len(found.corners) < 3 or found.area <= 0.0:
        raise InputError("has no area", where=where, remedy="choose a joint of two faces")
    flat = (found.corners - contacts.centroid[interface]) @ frame[1:].T
    hull = shapely.MultiPoint(flat).convex_hull
    if hull.area > found.area / _WHOLE:
        raise InputError("is not convex", where=where, remedy="cut one of the blocks first")
    ring = np.array(shapely.geometry.polygon.orient(hull).exterior.coords)[:-1]
    return JointPlane(int(interface), a, b, frame, contacts.centroid[interface], frozen(ring))


def block_with(block: Block, body: Piece) -> Block:
    """A block with another body and the same name, density and metadata."""
    return replace_block(block, vertices=body[0], faces=tuple(body[1]), repairs=())


def body_of(block: Block) -> Piece:
    """The vertices and faces of a block."""
    return np.array(block.vertices), list(block.faces)


def snapped(body: Piece, joint: JointPlane) -> Piece:
    """A body with its face at the joint exactly in the plane of the joint."""
    vertices = np.array(body[0])
    for loop in faces_at(body, joint):
        some = list(loop)
        height = (vertices[some] - joint.centre) @ joint.normal
        vertices[some] -= height[:, None] * joint.normal
    return vertices, body[1]


def faces_at(body: Piece, joint: JointPlane) -> list[Loop]:
    """The faces of a body that lie in the plane of a joint."""
    vertices, faces = body
    near = ON * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    on = np.abs((vertices - joint.centre) @ joint.normal) <= near
    return [face for face in faces if on[list(face)].all()]


def ends_of(model: Model, joint: JointPlane) -> tuple[bool, bool]:
    """Whether block a, and whether block b, ends at a joint: it covers the whole face."""
    one, other = (
        snapped(body_of(model.assembly.blocks[i]), joint) for i in (joint.block_a, joint.block_b)
    )
    return covers_face(one, joint), covers_face(other, joint)


def covers_face(body: Piece, joint: JointPlane) -> bool:
    """Whether the joint covers the whole face of a body."""
    own = sum(_area(body[0][list(face)]) for face in faces_at(body, joint))
    return bool(shapely.Polygon(joint.outline).area >= _WHOLE * own)


def _area(corner: Floats) -> float:
    return float(np.linalg.norm(area_vector(corner)))
