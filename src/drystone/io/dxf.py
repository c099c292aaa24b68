"""DXF of CAD programs: closed outlines with a thickness, faces and meshes, in layers.

Outlines alone are a section: the y axis of the drawing is up, and each becomes a block of one
thickness. Where there are bodies, or outlines with a thickness of their own, the z axis is up.

Source: Autodesk, DXF Reference (2018). A bulge is the tangent of a quarter of the angle of an arc.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise, product
from pathlib import Path
from typing import TypeAlias

import numpy as np
import shapely

from drystone.base.arrays import FARTHEST, ROUNDING, SAME, Floats
from drystone.base.errors import FormatError, InputError, counted
from drystone.base.files import lines_of
from drystone.base.units import scale_of
from drystone.geometry.frames import area_vector
from drystone.geometry.polyhedron import Loop, prism_faces
from drystone.io.draft import (
    Draft,
    DraftBlock,
    FaceSoup,
    hidden_notes,
    holds,
    moved,
    named_apart,
    require_blocks,
    shapes_of,
)
from drystone.io.glb import Z_UP
from drystone.io.outside import Unfolded, unfold

_UNITS = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m"}
"""By the value of $INSUNITS."""
_CODE = re.compile(r"-?\d{1,4}", re.ASCII)
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d{1,3})?", re.ASCII)
_UPRIGHT = 1.0 / 64.0
"""Below it both x and y of a normal count as zero, in the arbitrary axis algorithm."""


@dataclass(frozen=True, eq=False)
class Entity:
    """An entity with its tags; a polyline with its vertices; a block with its entities.

    Attributes
    ----------
    kind
    tags
        Group codes with their texts.
    inner
    line
        Of the file, where it begins.
    """

    kind: str
    tags: list[tuple[int, str]] = field(default_factory=list)
    inner: list[Entity] = field(default_factory=list)
    line: int = 0

    def text(self, code: int) -> str:
        """The first text of a code, or nothing."""
        return self._first.get(code, "")

    @cached_property
    def _first(self) -> dict[int, str]:
        """By code; a block with a large polyline is placed very often."""
        return dict(reversed(self.tags))

    def number(self, code: int, default: float = 0.0) -> float:
        """The first number of a code."""
        return float(self.text(code) or default)

    def numbers(self, code: int) -> list[float]:
        """All numbers of a code."""
        return [float(text) for key, text in self.tags if key == code]

    @property
    def place(self) -> str:
        """Its line, and its handle if it has one, for errors."""
        handle = self.text(5)
        return f"line {self.line}" + (f", handle {handle[:16]}" if handle else "")

    @property
    def flags(self) -> int:
        """Bits of code 70."""
        return int(self.number(70))

    def point(self, code: int = 10) -> Floats:
        """The point (3,) of a code and those 10 and 20 above it."""
        return np.array([self.number(code + step) for step in (0, 10, 20)])

    def frame(self) -> Floats:
        """Axes (3, 3) of its plane, in columns."""
        normal = self.point(210)
        size = float(np.linalg.norm(normal))
        normal = normal / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
        upright = np.abs(normal[:2]).max() < _UPRIGHT
        x = np.cross([0.0, 1.0, 0.0] if upright else [0.0, 0.0, 1.0], normal)
        x /= np.linalg.norm(x)
        return np.stack([x, np.cross(normal, x), normal], axis=1)


@dataclass(frozen=True, eq=False)
class Drawing:
    """What a file holds.

    Attributes
    ----------
    units
        ``None`` if it has none, or none that is known.
    visible
        By layer.
    entities
        Each with the matrix (4, 4) that moves it to its place, and its layer.
    """

    units: str | None
    visible: dict[str, bool]
    entities: list[tuple[Entity, Floats, str]]


def drawing(data: bytes, path: Path) -> Drawing:
    """The drawing in the bytes of a file.

    Raises
    ------
    FormatError
        No DXF, binary, cut off, with a number that is none, or with too many entities.
    """
    if data.startswith(b"AutoCAD Binary DXF"):
        raise FormatError(
            "is a binary DXF", where=str(path), remedy="save it as a text (ASCII) DXF"
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:  # before 2007; only names have other letters than ASCII
        text = data.decode("latin-1")
    units = None
    visible: dict[str, bool] = {}
    blocks: dict[str, Entity] = {}
    entities: list[Entity] = []
    section = ""
    target: list[Entity] = []
    for entity in _entities(text, path):
        if entity.kind == "SECTION":
            section = entity.text(2)
            target = entities if section == "ENTITIES" else []
            units = _units(entity) if section == "HEADER" else units
        elif entity.kind == "BLOCK":
            target = blocks.setdefault(entity.text(2).lower(), entity).inner
        elif entity.kind == "LAYER" and section == "TABLES":
            frozen = entity.flags & 1 or entity.number(62) < 0
            visible[entity.text(2)] = not frozen
        elif entity.kind == "VERTEX" and target and target[-1].kind == "POLYLINE":
            target[-1].inner.append(entity)
        elif entity.kind in ("ENDSEC", "ENDBLK"):
            target = []
        elif entity.kind != "SEQEND" and not entity.number(67):  # else it is of the paper
            target.append(entity)
    return Drawing(units, visible, [*_placed(entities, blocks, path)])


def _entities(text: str, path: Path) -> Iterator[Entity]:
    """Entities in the order of the file, each until the next code 0."""
    lines = [*lines_of(text)]
    while lines and not lines[-1].strip():
        lines.pop()
    entity: Entity | None = None
    for at in range(0, len(lines) - 1, 2):
        code, value = lines[at].strip(), lines[at + 1].strip()
        if not _CODE.fullmatch(code):
            raise FormatError(
                f"'{code[:40]}' is no group code of DXF",
                where=f"{path}, line {at + 1}",
                remedy="save it again as DXF",
            )
        key = int(code)
        if key == 0:
            if entity is not None:
                yield entity
            entity = Entity(value, line=at + 1)
        elif entity is not None:
            if 10 <= key < 100 or 210 <= key < 240:
                _require_number(value, f"{path}, line {at + 2}")
            entity.tags.append((key, value))
    if entity is None or entity.kind != "EOF":
        raise FormatError("ends too early", where=str(path), remedy="save it again as DXF")


def _require_number(value: str, where: str) -> None:
    if not _NUMBER.fullmatch(value) or not abs(float(value)) <= FARTHEST:
        raise FormatError(
            f"'{value[:40]}' is no number", where=where, remedy="save it again as DXF"
        )


def _units(header: Entity) -> str | None:
    tags = header.tags
    for (_, name), (_, value) in pairwise(tags):
        if name == "$INSUNITS":
            return _UNITS.get(int(float(value)) if _NUMBER.fullmatch(value) else 0)
    return None


_Placed: TypeAlias = tuple[Entity, Floats, str]


def _placed(entities: list[Entity], blocks: dict[str, Entity], path: Path) -> Iterator[_Placed]:
    """Entities with their matrices and layers, those of inserted blocks at each of their places."""

    def block_of(entity: Entity) -> Entity | None:
        return blocks.get(entity.text(2).lower()) if entity.kind == "INSERT" else None

    def inside(placed: _Placed) -> Iterator[_Placed]:
        insert, matrix, layer = placed
        block = block_of(insert)
        if block is not None and block.inner:
            for place in _places(insert, block):
                with np.errstate(all="ignore"):  # overflow is found with the points
                    at = matrix @ place
                yield from ((one, at, _layer(one, layer)) for one in block.inner)

    roots = [(one, np.eye(4), _layer(one, "0")) for one in entities]
    every = unfold(
        roots, inside, path, things="entities", name=lambda one: f"block '{one[0].text(2)[:40]}'"
    )
    yield from (one for one in every if block_of(one[0]) is None)


def _layer(entity: Entity, above: str) -> str:
    """Layer of an entity: that of the insertion around it where it is 0."""
    own = entity.text(8)
    return above if own in ("", "0") else own


def _places(insert: Entity, block: Entity) -> Iterator[Floats]:
    """Matrices (4, 4) of a block at an insertion, in columns and rows."""
    grid = int(insert.number(70, 1)), int(insert.number(71, 1))
    turn, grow = np.deg2rad(insert.number(50)), [insert.number(code, 1.0) for code in (41, 42, 43)]
    spin = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    frame, apart = insert.frame(), np.array([insert.number(44), insert.number(45), 0.0])
    turned = frame @ spin @ np.diag(grow)
    first = frame @ insert.point() - turned @ block.point()
    for i, j in product(range(grid[0]), range(grid[1])):
        place = np.eye(4)
        place[:3, :3] = turned
        place[:3, 3] = first + frame @ spin @ (apart * [i, j, 0])
        yield place


_CHORD = np.deg2rad(5.0)
"""Largest angle of a chord: it lies within 0.001 of the radius from its arc. Corners are at
multiples of it about the centre, so that arcs that lie on each other have the same ones."""
_USUAL = 1.0
"""[m] Thickness of a section when none is given."""
_Mesh: TypeAlias = tuple[Floats, list[Loop]]
_Own: TypeAlias = tuple[_Mesh | None, Floats | None, bool]
_CLOSED, _IN_SPACE, _GRID, _FACES = 1, 8, 16, 64
"""Flags of a polyline."""
_FRAME, _FACE = 16, 128
"""Flags of a vertex: of the frame of a spline; of a face of a mesh."""


def read(
    data: bytes,
    path: Path,
    *,
    layers: Sequence[str] = (),
    hidden: bool = False,
    thickness: float | None = None,
    units: str | None = None,
) -> Draft:
    """Blocks of a DXF file: of visible layers, of ``layers``, or of hidden ones too.

    A section becomes ``thickness`` [m] thick. ``units`` are those of the drawing, where they are
    not those of the file.
    """
    found = drawing(data, path)
    wanted, unread = _wanted(found, layers, hidden)
    skipped: Counter[str] = Counter()
    outlines: list[_Outline] = []
    soups: list[FaceSoup] = []
    faces: dict[str, list[Floats]] = {}
    unfolded = Unfolded(path)
    known: dict[Entity, _Own] = {}
    for entity, matrix, layer in wanted:
        if entity not in known:  # a block may be inserted very often
            known[entity] = _own(entity, _place(entity, layer, path))
        part = _part(entity, known[entity], matrix, layer, path)
        if part is None:
            skipped[entity.kind] += 1
        elif isinstance(part, FaceSoup):
            unfolded.take(len(part.vertices), len(part.faces))
            soups.append(part)
        elif isinstance(part, _Outline):
            unfolded.take(2 * len(part.corner), len(part.corner))
            outlines.append(part)
        else:
            faces.setdefault(layer, []).append(part)
    soups += [
        FaceSoup(np.concatenate(own), [_corners(k, at) for k, at in enumerate(own)], layer, layer)
        for layer, own in faces.items()
    ]
    scale = scale_of(units or found.units or "m")
    prisms, notes = _prisms(outlines, bool(soups), thickness, scale, path)
    made, said = shapes_of(soups, ROUNDING, path)
    shapes = [*prisms, *(replace(one, where="", metadata={"layer": one.where}) for one in made)]
    shapes = [replace(one, fixed=holds(one.metadata["layer"])) for one in shapes]
    notes += [*said, *hidden_notes(unread)]
    notes += [f"{count} x {kind[:40]} left out" for kind, count in skipped.items()]
    require_blocks(shapes, layers, found.visible, unread, path)
    if not shapes and skipped:
        raise FormatError(
            f"holds no closed polyline, face or mesh, but {'; '.join(notes)}"[:200],
            where=str(path),
            remedy="join lines to closed polylines, and save solids as meshes or STEP",
        )
    return Draft(tuple(named_apart(shapes)[0]), found.units, notes=tuple(notes))


def read_polyline(data: bytes, path: Path) -> Floats:
    """Corners (p, 2) [m] of the only open polyline of a DXF file, those on its arcs included.

    Raises
    ------
    FormatError
        It has none, or several.
    """
    found = drawing(data, path)
    lines = [
        _chained(_bends(one) if one.kind == "LWPOLYLINE" else _corners_of(one)) @ matrix[:2, :2].T
        + matrix[:2, 3]
        for one, matrix, _ in _wanted(found, (), False)[0]
        if one.kind in ("LWPOLYLINE", "POLYLINE") and not one.flags & (_CLOSED | _GRID | _FACES)
    ]
    if len(lines) != 1:
        raise FormatError(
            f"holds {counted(len(lines), 'open polyline')}",
            where=str(path),
            remedy="draw the intrados alone, as one open polyline",
        )
    return lines[0] * scale_of(found.units or "m")


def _corners_of(entity: Entity) -> Floats:
    """Corners and the bulges after them (c, 3) of a polyline with vertices of its own."""
    own = [one for one in entity.inner if not one.flags & _FRAME]
    return np.array([[*one.point()[:2], one.number(42)] for one in own]).reshape(-1, 3)


def _chained(bends: Floats) -> Floats:
    """Corners (c, 2) of an open line of corners with bulges (b, 3)."""
    parts = [_arc(a, b) for a, b in pairwise(bends)]
    return np.concatenate([*parts, bends[-1:, :2]])


@dataclass(frozen=True, eq=False)
class _Outline:
    """A closed outline: its corners (c, 3), and its own thickness as a vector (3,)."""

    corner: Floats
    depth: Floats
    layer: str
    where: str
    crossed: bool


def _wanted(
    found: Drawing, layers: Sequence[str], hidden: bool
) -> tuple[list[tuple[Entity, Floats, str]], Counter[str]]:
    """The entities that are read, and the number of others by layer."""
    wanted = []
    unread: Counter[str] = Counter()
    for entity, matrix, layer in found.entities:
        seen = found.visible.get(layer, True) and not entity.number(60)
        if layer in layers if layers else (seen or hidden):
            wanted.append((entity, matrix, layer))
        else:
            unread[layer] += 1
    return wanted, unread


def _part(
    entity: Entity, own: _Own, matrix: Floats, layer: str, path: Path
) -> FaceSoup | _Outline | Floats | None:
    """A mesh, an outline or the corners (4, 3) of a face, in its place; ``None`` if it is none."""
    where = _place(entity, layer, path)
    if entity.kind == "3DFACE":
        corner = np.array([entity.point(code) for code in (10, 11, 12, 13)])
        return _moved(corner, matrix, where)
    mesh, outline, crossed = own
    if mesh is not None:
        turn = -1 if np.linalg.det(matrix[:3, :3]) < 0.0 else 1
        point = _moved(mesh[0], matrix, where)
        return FaceSoup(point, [one[::turn] for one in mesh[1]], layer, layer)
    if outline is None:
        return None
    frame = np.eye(3) if entity.flags & _IN_SPACE else entity.frame()
    depth = frame[:, 2:].T * entity.number(39)
    both = _moved(np.concatenate([outline @ frame.T, depth]), matrix, where)
    return _Outline(both[:-1], both[-1] - matrix[:3, 3], layer, entity.place, crossed)


def _place(entity: Entity, layer: str, path: Path) -> str:
    return f"{path}, {entity.place}, layer '{layer}'"


def _own(entity: Entity, where: str) -> _Own:
    """The mesh or the outline (c, 3) of an entity, and whether the outline crosses itself."""
    mesh = _mesh(entity, where)
    outline = _outline(entity) if mesh is None else None
    return mesh, outline, outline is not None and _crosses(outline)


def _crosses(outline: Floats) -> bool:
    """Whether an outline (c, 3) crosses or touches itself, seen along its least extent."""
    middle = outline - outline.mean(axis=0)
    along = np.linalg.svd(middle, full_matrices=False)[2]
    return not shapely.Polygon(middle @ along[:2].T).is_valid


def _moved(points: Floats, matrix: Floats, where: str) -> Floats:
    placed = moved(points, (), matrix)[0]
    if not (np.abs(placed) <= FARTHEST).all():
        raise FormatError("a point is too far away", where=where)
    return placed


def _corners(number: int, face: Floats) -> Loop:
    """Corners of a face of four, whose last two may be one."""
    first = 4 * number
    if np.array_equal(face[2], face[3]):
        return (first, first + 1, first + 2)
    return (first, first + 1, first + 2, first + 3)


def _outline(entity: Entity) -> Floats | None:
    """Corners (c, 3) of a closed polyline or a circle, in its plane; ``None`` if it is neither."""
    if entity.kind == "CIRCLE":
        angle = np.arange(0.0, 2.0 * np.pi - 0.5 * _CHORD, _CHORD)
        ring = np.c_[np.cos(angle), np.sin(angle), np.zeros(len(angle))]
        return entity.point() + entity.number(40) * ring
    if entity.kind == "LWPOLYLINE":
        return _closed(_bends(entity), entity.number(38), entity)
    if entity.kind != "POLYLINE" or entity.flags & (_GRID | _FACES):
        return None
    if entity.flags & _IN_SPACE:
        own = [one for one in entity.inner if not one.flags & _FRAME]
        at = np.array([one.point() for one in own]).reshape(-1, 3)
        return at if entity.flags & _CLOSED and len(at) > 2 else None
    return _closed(_corners_of(entity), entity.number(30), entity)


def _closed(bends: Floats, height: float, entity: Entity) -> Floats | None:
    """Corners (c, 3) of corners with bulges (c, 3), with those on arcs; ``None`` if it is open."""
    if len(bends) < 2:
        return None
    same = np.abs(bends[0, :2] - bends[-1, :2]).max() <= ROUNDING * np.abs(bends[:, :2]).max()
    if not entity.flags & _CLOSED and not same:
        return None
    flat = np.concatenate(
        [_arc(*pair) for pair in zip(bends, np.roll(bends, -1, axis=0), strict=True)]
    )
    apart = np.abs(flat - np.roll(flat, 1, axis=0)).max(axis=1) > ROUNDING * np.abs(flat).max()
    flat = flat[apart]
    return np.c_[flat, np.full(len(flat), height)] if len(flat) > 2 else None


def _bends(entity: Entity) -> Floats:
    """Corners and the bulges after them (c, 3) of a light polyline."""
    rows: list[list[float]] = []
    for code, text in entity.tags:
        if code == 10:
            rows.append([float(text), 0.0, 0.0])
        elif code in (20, 42) and rows:
            rows[-1][1 if code == 20 else 2] = float(text)
    return np.array(rows).reshape(-1, 3)


def _arc(start: Floats, end: Floats) -> Floats:
    """The first corner and those on the arc after it (c, 2); its bulge is the last number."""
    a, b, bulge = start[:2], end[:2], float(start[2])
    chord = b - a
    if abs(bulge) < SAME or not chord.any():
        return a[None]
    middle = 0.5 * (a + b) + np.array([-chord[1], chord[0]]) * (1.0 - bulge**2) / (4.0 * bulge)
    first = float(np.arctan2(*(a - middle)[::-1]))
    sweep = 4.0 * float(np.arctan(bulge))
    low, high = sorted((first / _CHORD, (first + sweep) / _CHORD))
    inside = np.arange(np.floor(low) + 1, np.ceil(high))
    inside = inside[(inside > low + 1e-3) & (inside < high - 1e-3)]
    angle = _CHORD * (inside if sweep > 0.0 else inside[::-1])
    radius = float(np.linalg.norm(a - middle))
    return np.vstack([a, middle + radius * np.c_[np.cos(angle), np.sin(angle)]])


def _mesh(entity: Entity, where: str) -> _Mesh | None:
    """Vertices and faces of a mesh or a polyface mesh; ``None`` if it is neither."""
    if entity.kind == "MESH":
        columns = zip(*(entity.numbers(code) for code in (10, 20, 30)), strict=False)
        points = np.array([*columns]).reshape(-1, 3)
        loops = _listed([int(one) for one in entity.numbers(90)][: int(entity.number(93))])
    elif entity.kind == "POLYLINE" and entity.flags & _FACES:
        own = [one.point() for one in entity.inner if one.flags & _FACES]
        points = np.array(own).reshape(-1, 3)
        faces = [one for one in entity.inner if one.flags & (_FACE | _FACES) == _FACE]
        corners = [[int(abs(face.number(code))) for code in (71, 72, 73, 74)] for face in faces]
        loops = [tuple(corner - 1 for corner in face if corner) for face in corners]
    else:
        return None
    if not loops or not all(0 <= i < len(points) for loop in loops for i in loop):
        raise FormatError("a mesh has a vertex that does not exist, or no face", where=where)
    return points, loops


def _listed(told: Sequence[int]) -> list[Loop]:
    """Faces from a list with the number of corners before each; nothing where it ends early."""
    loops: list[Loop] = []
    at = 0
    while at < len(told):
        end = at + 1 + told[at]
        if not at + 3 < end <= len(told):
            return []
        loops.append(tuple(told[at + 1 : end]))
        at = end
    return loops


def _prisms(
    outlines: Sequence[_Outline],
    bodies: bool,
    thickness: float | None,
    scale: float,
    path: Path,
) -> tuple[list[DraftBlock], list[str]]:
    """A body for each outline, and notes; ``thickness`` [m] for those without one."""
    thick = [one for one in outlines if one.depth.any()]
    if not bodies and not thick and outlines:
        return _section(outlines, thickness, scale)
    if thickness is not None:
        raise FormatError(
            "is no section: its bodies have a thickness", where=str(path), remedy="leave it out"
        )
    left = counted(len(outlines) - len(thick), "outline")
    notes = [f"{left} without a thickness left out beside bodies"]
    return [_prism(one, one.corner, one.depth) for one in thick], notes if len(thick) < len(
        outlines
    ) else []


def _section(
    outlines: Sequence[_Outline], thickness: float | None, scale: float
) -> tuple[list[DraftBlock], list[str]]:
    """Blocks of one thickness [m], and notes; upright where the outlines lie in the plan."""
    depth = (_USUAL if thickness is None else thickness) / scale
    normals = [area_vector(one.corner) for one in outlines]
    flat = all(abs(normal[2]) >= 0.999 * np.linalg.norm(normal) for normal in normals)
    turn = Z_UP if flat else np.eye(3)
    notes = ["a section: the y axis of the drawing is up"] if flat else []
    if thickness is None:
        notes.append(f"no thickness is given: its blocks are {_USUAL:g} m thick (--thickness)")
    made = []
    for one, normal in zip(outlines, normals, strict=True):
        along = normal * np.sign(normal[np.argmax(np.abs(normal))])
        way = depth * along / (float(np.linalg.norm(along)) or 1.0)
        made.append(_prism(one, one.corner @ turn.T, turn @ way))
    return made, notes


def _prism(outline: _Outline, corner: Floats, depth: Floats) -> DraftBlock:
    """The body that an outline with corners (c, 3) covers when it is moved by ``depth`` (3,)."""
    told = {"layer": outline.layer}
    if outline.crossed:
        error = InputError(
            f"its outline on layer '{outline.layer}' crosses itself",
            remedy="draw it as one loop, or as two polylines",
        )
        return DraftBlock(outline.layer, corner, (), outline.where, metadata=told, defect=error)
    if depth @ area_vector(corner) < 0.0:
        corner = corner[::-1]
    points, faces = np.concatenate([corner, corner + depth]), prism_faces(len(corner))
    return DraftBlock(outline.layer, points, faces, outline.where, metadata=told)
