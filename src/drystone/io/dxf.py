"""DXF of CAD programs: closed outlines with a thickness, faces and meshes, in layers.

Outlines alone are a section: the y axis of the drawing is up, and each becomes a block of one
thickness. Where there are bodies, or outlines with a thickness of their own, the z axis is up.

Source: Autodesk, DXF Reference (2018). A bulge is the tangent of a quarter of the angle of an arc.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from drystone.base.arrays import FARTHEST, Floats
from drystone.base.errors import FormatError, counted
from drystone.base.units import scale_of
from drystone.geometry.polygon import area_vector
from drystone.geometry.polyhedron import Loop
from drystone.io.draft import Draft, DraftBlock
from drystone.io.dxf_entities import Entity, drawing
from drystone.io.face_soup import FaceSoup, moved, named_apart, shapes_of
from drystone.io.layers import hidden_notes, holds, require_blocks

_CHORD = np.deg2rad(5.0)
"""Largest angle of a chord: it lies within 0.001 of the radius from its arc. Corners are at
multiples of it about the centre, so that arcs that lie on each other have the same ones."""
_STRAIGHT = 1e-6
"""Smaller bulges are none."""
_USUAL = 1.0
"""[m] Thickness of a section when none is given."""
_SAME = 1e-9
"""Distance of coincident points, relative to the extent."""
_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
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
    unread: Counter[str] = Counter()
    skipped: Counter[str] = Counter()
    outlines: list[tuple[Floats, Floats, str]] = []
    soups: list[FaceSoup] = []
    faces: dict[str, list[Floats]] = {}
    for entity, matrix, layer in found.entities:
        seen = found.visible.get(layer, True) and not entity.number(60)
        if layer not in layers if layers else not (seen or hidden):
            unread[layer] += 1
        elif entity.kind == "3DFACE":
            corner = np.array([entity.point(code) for code in (10, 11, 12, 13)])
            faces.setdefault(layer, []).append(_moved(corner, matrix, layer, path))
        elif (mesh := _mesh(entity, path)) is not None:
            point = _moved(mesh[0], matrix, layer, path)
            turn = -1 if np.linalg.det(matrix[:3, :3]) < 0.0 else 1
            soups.append(FaceSoup(point, [one[::turn] for one in mesh[1]], layer, layer))
        elif (outline := _outline(entity)) is not None:
            frame = np.eye(3) if entity.flags & _IN_SPACE else entity.frame()
            depth = frame[:, 2:].T * entity.number(39)
            both = _moved(np.concatenate([outline @ frame.T, depth]), matrix, layer, path)
            outlines.append((both[:-1], both[-1] - matrix[:3, 3], layer))
        else:
            skipped[entity.kind] += 1
    soups += [
        FaceSoup(np.concatenate(own), [_corners(k, at) for k, at in enumerate(own)], layer, layer)
        for layer, own in faces.items()
    ]
    scale = scale_of(units or found.units or "m")
    prisms, notes = _prisms(outlines, bool(soups), thickness, scale, path)
    made = shapes_of(soups, _SAME, path) if soups else ([], [])
    shapes = [
        replace(one, fixed=holds(one.where), where="", metadata={"layer": one.where})
        for one in (*prisms, *made[0])
    ]
    notes += [*made[1], *hidden_notes(unread)]
    notes += [f"{count} x {kind[:40]} left out" for kind, count in skipped.items()]
    require_blocks(shapes, layers, found.visible, unread, path)
    if not shapes and skipped:
        raise FormatError(
            f"holds no closed polyline, face or mesh, but {'; '.join(notes)}"[:200],
            where=str(path),
            remedy="join lines to closed polylines, and save solids as meshes or STEP",
        )
    return Draft(tuple(named_apart(shapes)[0]), found.units, notes=tuple(notes))


def _moved(points: Floats, matrix: Floats, layer: str, path: Path) -> Floats:
    placed = moved(points, matrix)[0]
    if not (np.abs(placed) <= FARTHEST).all():
        raise FormatError("a point is too far away", where=f"{path}, layer '{layer}'")
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
        height, bends = entity.number(38), _bends(entity)
    elif entity.kind == "POLYLINE" and not entity.flags & (_GRID | _FACES):
        own = [one for one in entity.inner if not one.flags & _FRAME]
        at = np.array([one.point() for one in own]).reshape(-1, 3)
        if entity.flags & _IN_SPACE:
            return at if entity.flags & _CLOSED and len(at) > 2 else None
        height = entity.number(30)
        bends = np.c_[at[:, :2], [one.number(42) for one in own]]
    else:
        return None
    if len(bends) < 2:
        return None
    same = np.abs(bends[0, :2] - bends[-1, :2]).max() <= _SAME * np.abs(bends[:, :2]).max()
    if not entity.flags & _CLOSED and not same:
        return None
    flat = np.concatenate(
        [_arc(*pair) for pair in zip(bends, np.roll(bends, -1, axis=0), strict=True)]
    )
    apart = np.abs(flat - np.roll(flat, 1, axis=0)).max(axis=1) > _SAME * np.abs(flat).max()
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
    if abs(bulge) < _STRAIGHT or not chord.any():
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


def _mesh(entity: Entity, path: Path) -> tuple[Floats, list[Loop]] | None:
    """Vertices and faces of a mesh or a polyface mesh; ``None`` if it is neither."""
    if entity.kind == "MESH":
        columns = zip(*(entity.numbers(code) for code in (10, 20, 30)), strict=False)
        points = np.array([*columns]).reshape(-1, 3)
        told = [int(one) for one in entity.numbers(90)][: int(entity.number(93))]
        loops = []
        while told:
            size, told = told[0], told[1:]
            if not 2 < size <= len(told):
                raise FormatError("a MESH has a face without an end", where=str(path))
            loops.append(tuple(told[:size]))
            told = told[size:]
    elif entity.kind == "POLYLINE" and entity.flags & _FACES:
        own = [one.point() for one in entity.inner if one.flags & _FACES]
        points = np.array(own).reshape(-1, 3)
        faces = [one for one in entity.inner if one.flags & _FACE and not one.flags & _FACES]
        corners = [[int(abs(face.number(code))) - 1 for code in (71, 72, 73, 74)] for face in faces]
        loops = [tuple(corner for corner in face if corner >= 0) for face in corners]
    else:
        return None
    if not loops or not all(0 <= i < len(points) for loop in loops for i in loop):
        raise FormatError("a mesh has a vertex that does not exist, or no face", where=str(path))
    return points, loops


def _prisms(
    outlines: Sequence[tuple[Floats, Floats, str]],
    bodies: bool,
    thickness: float | None,
    scale: float,
    path: Path,
) -> tuple[list[DraftBlock], list[str]]:
    """A body for each outline, and notes; ``thickness`` [m] for those without one."""
    flat = [not depth.any() for _, depth, _ in outlines]
    in_space = bodies or not all(flat)
    if thickness is not None and (in_space or not flat):
        raise FormatError(
            "is no section: its bodies have a thickness", where=str(path), remedy="leave it out"
        )
    notes = []
    if in_space and any(flat):
        left = counted(sum(flat), "outline")
        notes.append(f"{left} without a thickness left out beside bodies")
    depth_of_all = (_USUAL if thickness is None else thickness) / scale
    normals = [area_vector(corner) for corner, _, _ in outlines]
    upright = not in_space and all(abs(n[2]) >= 0.999 * np.linalg.norm(n) for n in normals)
    if upright and flat:
        notes.append("a section: the y axis of the drawing is up")
    if not in_space and thickness is None and flat:
        notes.append(f"no thickness is given: its blocks are {_USUAL:g} m thick (--thickness)")
    made = []
    for (corner, depth, layer), normal, bare in zip(outlines, normals, flat, strict=True):
        if bare and in_space:
            continue
        if bare:
            size = float(np.linalg.norm(normal)) or 1.0
            depth = depth_of_all * normal / size * np.sign(normal[np.argmax(np.abs(normal))])
        if depth @ normal < 0.0:
            corner = corner[::-1]
        count = len(corner)
        ring = range(count)
        points = np.concatenate([corner, corner + depth])
        loops = [
            tuple(ring)[::-1],
            tuple(count + i for i in ring),
            *((i, (i + 1) % count, count + (i + 1) % count, count + i) for i in ring),
        ]
        made.append(DraftBlock(layer, points @ _Y_UP.T if upright else points, loops, layer))
    return made, notes
