"""New cuts of a joint: both blocks change together and share the new faces exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from drystone.assembly import Block, replace_block
from drystone.base.arrays import Floats, frozen
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.design.surgery.changed_model import changed
from drystone.geometry.body.glue import cut_cell, glue
from drystone.geometry.body.polyhedron import Loop
from drystone.geometry.body.split import Piece
from drystone.geometry.plane.polygon import area_vectors
from drystone.model import Model

WHOLE = 0.999
"""A block ends at a joint when the joint covers at least this share of its face, chosen."""

ON = 1e-4
"""A vertex is on the plane of a joint when it is nearer than this share of the size of the block,
chosen: contacts are found within a gap of 5e-3, files give coordinates to 1e-6."""

KEPT = 1e-9
"""Volumes below this share of the block are rounding."""


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


@dataclass(frozen=True, eq=False)
class Cell(OneLine):
    """A convex part of space: where ``normal @ x <= offset``.

    Attributes
    ----------
    normal : (p, 3) unit
    offset : (p,) [m]
    """

    normal: Floats
    offset: Floats

    @classmethod
    def below(cls, normals: Floats, points: Floats) -> Cell:
        """The space behind planes, given by normals and a point of each."""
        unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        return cls(frozen(unit), frozen(np.einsum("pi,pi->p", unit, points)))

    def within(self, other: Cell) -> Cell:
        """The intersection of both."""
        return Cell(
            frozen(np.concatenate([self.normal, other.normal])),
            frozen(np.concatenate([self.offset, other.offset])),
        )

    def holds(self, points: Floats, near: float) -> bool:
        """Whether all points (p, 3) are inside."""
        return bool((points @ self.normal.T <= self.offset + near).all())


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
    if hull.area > found.area / WHOLE:
        raise InputError("is not convex", where=where, remedy="cut one of the blocks first")
    ring = np.array(shapely.geometry.polygon.orient(hull).exterior.coords)[:-1]
    return JointPlane(int(interface), a, b, frame, contacts.centroid[interface], frozen(ring))


def recut(
    model: Model, joint: JointPlane, to_a: Sequence[Cell], to_b: Sequence[Cell], what: str
) -> Model:
    """The model with parts of block b given to block a, and of block a to block b.

    Only parts that touch the joint are exchanged. If a block extends beyond the joint, the part is
    bounded by the extended sides of the other block.

    Parameters
    ----------
    model
    joint
    to_a, to_b
        Cells of the parts; those of one block do not overlap.
    what
        The change in words, for errors.

    Raises
    ------
    InputError
        The change would remove a face, cut a block in two, or change only the joint of a fixed
        block.
    """
    a, b = joint.block_a, joint.block_b
    names = model.assembly.names
    where = f"{what} of the joint of '{names[a]}' and '{names[b]}'"
    one, other = (snapped(body_of(model.assembly.blocks[i]), joint) for i in (a, b))
    ends = _ends(one, joint), _ends(other, joint)
    walls_b = _walls(joint, one if ends[0] else None)
    walls_a = _walls(joint, other if ends[1] else None)
    given, kept_b = _taken(other, to_a, None if ends[1] else walls_b, joint, 1.0)
    taken, kept_a = _taken(one, to_b, None if ends[0] else walls_a, joint, -1.0)
    for block, parts, cells in ((other, given, to_a), (one, taken, to_b)):
        _refuse_swallowed(block, parts, cells, joint, where)
    new: dict[int, Block] = {}
    for i, pieces in ((a, [*kept_a, *given]), (b, [*kept_b, *taken])):
        bodies = glue(pieces)
        if len(bodies) != 1:
            raise InputError(
                f"would cut '{names[i]}' into {len(bodies)} parts",
                where=where,
                remedy="make it smaller",
            )
        new[i] = block_with(model.assembly.blocks[i], bodies[0])
    return changed(model, new)


def block_with(block: Block, body: Piece) -> Block:
    """A block with another body and the same name, density and metadata."""
    return replace_block(block, vertices=body[0], faces=tuple(body[1]), repairs=())


def body_of(block: Block) -> Piece:
    """The vertices and faces of a block."""
    return np.array(block.vertices), list(block.faces)


def snapped(body: Piece, joint: JointPlane) -> Piece:
    """A body with its face at the joint exactly in the plane of the joint."""
    vertices = np.array(body[0])
    for loop in _joint_faces(body, joint):
        some = list(loop)
        height = (vertices[some] - joint.centre) @ joint.normal
        vertices[some] -= height[:, None] * joint.normal
    return vertices, body[1]


def _joint_faces(body: Piece, joint: JointPlane) -> list[Loop]:
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
    return _ends(one, joint), _ends(other, joint)


def _ends(body: Piece, joint: JointPlane) -> bool:
    """Whether the joint covers the whole face of a body."""
    own = sum(_area(body[0][list(face)]) for face in _joint_faces(body, joint))
    return bool(shapely.Polygon(joint.outline).area >= WHOLE * own)


def _area(corner: Floats) -> float:
    return float(np.linalg.norm(area_vectors(corner, np.array([0, len(corner)]))[0]))


def _walls(joint: JointPlane, ending: Piece | None) -> Cell:
    """The space beyond a joint within the sides of the block that ends there.

    If a side has an unsuitable inclination, or no block ends there, the side is normal to the
    joint.

    Parameters
    ----------
    joint
    ending
    """
    corner = joint.centre + joint.outline @ joint.frame[1:]
    normals, points = [], []
    for start, end in zip(corner, np.roll(corner, -1, axis=0), strict=True):
        along = (end - start) / np.linalg.norm(end - start)
        square = np.cross(along, joint.normal)
        normals.append(square if ending is None else _side(ending, start, end, square))
        points.append(start)
    return Cell.below(np.array(normals), np.array(points))


def _side(body: Piece, start: Floats, end: Floats, square: Floats) -> Floats:
    """Normal of the side face of a body at an edge of its joint; ``square`` where there is none."""
    vertices, faces = body
    near = ON * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    best = square
    for face in faces:
        corner = vertices[list(face)]
        area = area_vectors(corner, np.array([0, len(corner)]))[0]
        normal = area / np.linalg.norm(area)
        if np.abs((np.array([start, end]) - corner[0]) @ normal).max() > near:
            continue
        if normal @ square > 0.3 and _touches(corner, start, end, near):
            best = normal
    return best


def _touches(corner: Floats, start: Floats, end: Floats, near: float) -> bool:
    """Whether an edge of a face runs along a segment."""
    middle = 0.5 * (start + end)
    for p, q in zip(corner, np.roll(corner, -1, axis=0), strict=True):
        along = q - p
        share = np.clip((middle - p) @ along / (along @ along), 0.0, 1.0)
        if np.linalg.norm(middle - p - share * along) <= near:
            return True
    return False


def _taken(
    body: Piece, cells: Sequence[Cell], walls: Cell | None, joint: JointPlane, onward: float
) -> tuple[list[Piece], list[Piece]]:
    """The parts of a body in cells that touch the joint, and the rest.

    Parameters
    ----------
    body, cells, walls, joint
    onward
        1 where the body lies along n, -1 against it.
    """
    beyond = Cell.below(-onward * joint.normal[None], joint.centre[None])
    taken: list[Piece] = []
    kept: list[Piece] = [body]
    for cell in cells:
        whole = cell.within(beyond) if walls is None else cell.within(beyond).within(walls)
        inside, kept = cut_cell(kept, whole.normal, whole.offset)
        for piece in inside:
            (taken if _joint_faces_over(piece, joint) else kept).append(piece)
    return taken, kept


def _joint_faces_over(piece: Piece, joint: JointPlane) -> bool:
    """Whether a piece has a face on the joint itself."""
    outline = shapely.Polygon(joint.outline)
    for face in _joint_faces(piece, joint):
        flat = (piece[0][list(face)] - joint.centre) @ joint.frame[1:].T
        if shapely.intersection(shapely.Polygon(flat).buffer(0.0), outline).area > 0.0:
            return True
    return False


def _refuse_swallowed(
    body: Piece, parts: Sequence[Piece], cells: Sequence[Cell], joint: JointPlane, where: str
) -> None:
    """Refuse a change that removes a whole face of a block."""
    if not parts:
        return
    vertices, faces = body
    near = KEPT * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    own = _joint_faces(body, joint)
    low = np.min([piece[0].min(axis=0) for piece in parts], axis=0) - near
    high = np.max([piece[0].max(axis=0) for piece in parts], axis=0) + near
    for face in faces:
        corner = vertices[list(face)]
        if face in own or (corner < low).any() or (corner > high).any():
            continue
        if any(cell.holds(corner, near) for cell in cells):
            raise InputError("would remove a whole face", where=where, remedy="make it smaller")


__all__ = [
    "Cell",
    "JointPlane",
    "block_with",
    "body_of",
    "ends_of",
    "joint_plane",
    "recut",
    "snapped",
]
