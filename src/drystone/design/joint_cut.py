"""New cuts of a plane joint: both blocks change together and share the new faces exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import shapely

from drystone.assembly import Block, replace_block
from drystone.base.arrays import ROUNDING, Floats, dot, frozen
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.design.changed_model import changed
from drystone.detection.patches import EXACT
from drystone.geometry.frames import area_vector
from drystone.geometry.glue import cut_cell, glue
from drystone.geometry.polyhedron import Loop, Piece
from drystone.model import Model

_REMEMBERED = 512
"""Cuts, and blocks, that are kept. The same change is tried in a diagnosis, in a region and in the
whole: of 124 changes in the mends of a shelf 41 are repeated. A wedge in each joint of an arch is
tried some times."""


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
        return cls(frozen(unit), frozen(dot(unit, points)))

    def within(self, other: Cell) -> Cell:
        """The intersection of both."""
        return Cell(
            frozen(np.concatenate([self.normal, other.normal])),
            frozen(np.concatenate([self.offset, other.offset])),
        )

    def holds(self, points: Floats, near: float) -> bool:
        """Whether all points (p, 3) are inside."""
        return bool((points @ self.normal.T <= self.offset + near).all())


@dataclass(frozen=True, eq=False)
class JointRecut(OneLine):
    """A new cut of one joint: parts of block b given to block a, and of block a to block b.

    Attributes
    ----------
    joint
    to_a, to_b
        Cells of the parts; those of one block do not overlap.
    words
        The change in words, for errors.
    """

    joint: JointPlane
    to_a: tuple[Cell, ...]
    to_b: tuple[Cell, ...]
    words: str


def recut(model: Model, recuts: Sequence[JointRecut]) -> Model:
    """The model with some of its joints cut anew, all at once.

    Each block is made of its form before and the new cuts of its own joints. So one joint changes
    two blocks, and contacts are found once for all. Only parts that touch the joint are exchanged.
    If a block extends beyond the joint, the part is bounded by the extended sides of the other
    block.

    Raises
    ------
    InputError
        A change would remove a face, cut a block in two, or change only the joint of a fixed
        block; or two changes would take the same part of a block.
    """
    blocks, names = model.assembly.blocks, model.assembly.names
    own: dict[int, list[tuple[_Exchange, bool]]] = {}
    for one in recuts:
        joint = one.joint
        a, b = joint.block_a, joint.block_b
        parts = [joint.frame, joint.centre, joint.outline]
        parts += [part for cell in (*one.to_a, *one.to_b) for part in (cell.normal, cell.offset)]
        key = (len(one.to_a), tuple(np.ascontiguousarray(part).tobytes() for part in parts))
        where = f"{one.words} of the joint of '{names[a]}' and '{names[b]}'"
        asked = _Exchange((blocks[a], blocks[b]), where, key, one)
        own.setdefault(a, []).append((asked, True))
        own.setdefault(b, []).append((asked, False))
    made = {i: _made(blocks[i], tuple(some)) for i, some in own.items()}
    before = sum(plain.volume for plain, _ in made.values())
    if abs(sum(block.volume for _, block in made.values()) - before) > ROUNDING * before:
        raise InputError(
            "two joints would take the same part of a block", remedy="change them less"
        )
    return changed(model, {i: block for i, (_, block) in made.items()})


@dataclass(frozen=True)
class _Exchange:
    """Two blocks and the parts that they exchange; equal where the key is."""

    blocks: tuple[Block, Block]
    where: str
    key: tuple[int, tuple[bytes, ...]]
    recut: JointRecut = field(compare=False)


@dataclass(frozen=True, eq=False)
class _Part:
    """What a block gives away at a joint: cells within walls, where they touch the joint.

    Attributes
    ----------
    joint
    cells
        They do not overlap.
    walls
        How far they reach to the sides; ``None`` where the block ends at the joint.
    onward
        1 where the block lies along the normal of the joint, -1 against it.
    """

    joint: JointPlane
    cells: tuple[Cell, ...]
    walls: Cell | None
    onward: float

    def of(self, pieces: Sequence[Piece]) -> tuple[list[Piece], list[Piece]]:
        """The part of the pieces of the block, and the rest."""
        joint = self.joint
        beyond = Cell.below(-self.onward * joint.normal[None], joint.centre[None])
        if self.walls is not None:
            beyond = beyond.within(self.walls)
        taken: list[Piece] = []
        kept: list[Piece] = list(pieces)
        for cell in self.cells:
            whole = cell.within(beyond)
            inside, kept = cut_cell(kept, whole.normal, whole.offset)
            for piece in inside:
                (taken if _joint_faces_over(piece, joint) else kept).append(piece)
        return taken, kept


@lru_cache(_REMEMBERED)
def _exchanged(asked: _Exchange) -> tuple[tuple[_Part, list[Piece]], tuple[_Part, list[Piece]]]:
    """Of block a and of block b at one joint: what it gives to the other one, and what it takes."""
    new, joint = asked.recut, asked.recut.joint
    one, other = (snapped(body_of(block), joint) for block in asked.blocks)
    ends = covers_face(one, joint), covers_face(other, joint)
    walls_a = None if ends[0] else _walls(joint, other if ends[1] else None)
    walls_b = None if ends[1] else _walls(joint, one if ends[0] else None)
    of_a = _Part(joint, new.to_b, walls_a, -1.0)
    of_b = _Part(joint, new.to_a, walls_b, 1.0)
    taken, given = of_a.of([one])[0], of_b.of([other])[0]
    for body, parts, cells in ((other, given, new.to_a), (one, taken, new.to_b)):
        _refuse_swallowed(body, parts, cells, joint, asked.where)
    return (of_a, given), (of_b, taken)


@lru_cache(_REMEMBERED)
def _made(block: Block, some: tuple[tuple[_Exchange, bool], ...]) -> tuple[Block, Block]:
    """A block with exactly plane joints, and with new cuts of them; where it is block a."""
    body = body_of(block)
    for asked, _ in some:
        body = snapped(body, asked.recut.joint)
    pieces, taken = [body], list[Piece]()
    for asked, is_a in some:
        part, more = _exchanged(asked)[0 if is_a else 1]
        pieces, taken = part.of(pieces)[1], [*taken, *more]
    bodies = glue([*pieces, *taken])
    if len(bodies) != 1:
        raise InputError(
            f"would cut '{block.name}' into {len(bodies)} parts",
            where=some[0][0].where,
            remedy="make it smaller",
        )
    return block_with(block, body), block_with(block, bodies[0])


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
    near = EXACT * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    best = square
    for face in faces:
        corner = vertices[list(face)]
        area = area_vector(corner)
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


def _joint_faces_over(piece: Piece, joint: JointPlane) -> bool:
    """Whether a piece has a face on the joint itself."""
    outline = shapely.Polygon(joint.outline)
    for face in faces_at(piece, joint):
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
    near = ROUNDING * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    own = faces_at(body, joint)
    low = np.min([piece[0].min(axis=0) for piece in parts], axis=0) - near
    high = np.max([piece[0].max(axis=0) for piece in parts], axis=0) + near
    for face in faces:
        corner = vertices[list(face)]
        if face in own or (corner < low).any() or (corner > high).any():
            continue
        if any(cell.holds(corner, near) for cell in cells):
            raise InputError("would remove a whole face", where=where, remedy="make it smaller")


_WHOLE = 0.999
"""A block ends at a joint when the joint covers at least this share of its face, chosen."""


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
        return self.frame[0]

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
    near = EXACT * float(np.linalg.norm(np.ptp(vertices, axis=0)))
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
