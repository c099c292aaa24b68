"""The union of closed pieces that touch, and cells cut out of bodies.

A plane divides a body on its faces as loops, where it has no loose faces: the usual case.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from drystone.base.arrays import Floats, unit
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.geometry.coincidence import distinct
from drystone.geometry.frames import area_vector, area_vectors, frames_from_normals
from drystone.geometry.halfedge import merge_coplanar
from drystone.geometry.planar import half_plane, overlay, parts_of, rings_of, valid
from drystone.geometry.polyhedron import Loop, Piece, loop_edges, rings, used_vertices
from drystone.geometry.soup import points_between, split_solids
from drystone.geometry.surface import edge_defects


def halved(
    vertices: Floats, faces: Sequence[Loop], height: Floats, near: float
) -> tuple[Piece, Piece] | None:
    """The parts of a closed body below and above a plane.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops of them, outwards.
    height : (v,) [m]
        Of the vertices above the plane; exactly zero on it, and of both signs.
    near : [m]
        Shortest edge that a cut may make.

    Returns
    -------
    Two bodies; ``None`` where the section is not one simple loop, where a face lies in the plane or
    is cut more than once, or where an edge of the section would be shorter than ``near``.
    """
    points = list(vertices)
    at: dict[tuple[int, int], int] = {}
    sides: tuple[list[Loop], list[Loop]] = ([], [])
    high = height.tolist()
    for face in faces:
        parts = _parts(face, high, vertices, points, at)
        if parts is None:
            return None
        for side, part in zip(sides, parts, strict=True):
            if len(part) > 2:
                side.append(part)
    corner = np.array(points)
    for side in sides:
        lid = _lid(side)
        if lid is None:
            return None
        edge = corner[list(lid)] - corner[[*lid[1:], lid[0]]]
        if np.linalg.norm(edge, axis=1).min() < near:
            return None
        side.append(lid)
    return _used(corner, sides[0]), _used(corner, sides[1])


def _parts(
    face: Loop,
    height: Sequence[float],
    vertices: Floats,
    points: list[Floats],
    at: dict[tuple[int, int], int],
) -> tuple[Loop, Loop] | None:
    """The parts of a face below and above the plane; new points are added to ``points``."""
    below: list[int] = []
    above: list[int] = []
    changes, last = 0, 0.0
    for i, j in loop_edges(face):
        here, then = height[i], height[j]
        if here <= 0.0:
            below.append(i)
        if here >= 0.0:
            above.append(i)
        if here * then < 0.0:
            key = (i, j) if i < j else (j, i)
            if key not in at:
                one, other = key
                share = height[one] / (height[one] - height[other])
                at[key] = len(points)
                points.append(vertices[one] + share * (vertices[other] - vertices[one]))
            below.append(at[key])
            above.append(at[key])
        if here * last < 0.0:
            changes += 1
        last = here or last
    first = next((height[i] for i in face if height[i]), 0.0)
    if first == 0.0 or changes + (first * last < 0.0) > 2:
        return None
    lowest, highest = min(height[i] for i in face), max(height[i] for i in face)
    return tuple(below) if lowest < 0.0 else (), tuple(above) if highest > 0.0 else ()


def _lid(faces: Sequence[Loop]) -> Loop | None:
    """The face that closes a body with one opening; ``None`` where it has another number."""
    edges = {edge for face in faces for edge in loop_edges(face)}
    rim = [(j, i) for i, j in edges if (j, i) not in edges]
    after = dict(rim)
    loop = next(rings(after), [])
    closes = len(rim) == len(loop) > 2 and after[loop[-1]] == loop[0]
    return tuple(loop) if closes else None


def _used(corner: Floats, faces: Sequence[Loop]) -> Piece:
    """The body without vertices that no face has."""
    used, loops = used_vertices(faces)
    return corner[used], loops


_TOUCH = 1e-8
"""Points nearer than this share of the extent are one point. Faces nearer than it touch. Ten times
the difference between pieces of one cut."""


def glue(pieces: Sequence[Piece]) -> list[Piece]:
    """The union of closed pieces that touch along faces and share no volume.

    Where two faces lie in one plane with opposite normals, their common area is removed. Faces in
    one plane are then merged, and vertices on straight edges dropped.

    Parameters
    ----------
    pieces
        Vertices (v, 3) [m], and faces as loops of them, outwards.

    Returns
    -------
    One piece for each connected body.

    Examples
    --------
    >>> from drystone.models import box
    >>> one, two = box((1.0, 1.0, 1.0)), box((1.0, 1.0, 1.0), (0.0, 0.0, 1.0))
    >>> (body,) = glue([(one.vertices, list(one.faces)), (two.vertices, list(two.faces))])
    >>> len(body[0]), len(body[1])
    (8, 6)
    """
    if not pieces:
        return []
    points = np.concatenate([vertices for vertices, _ in pieces])
    extent = float(np.ptp(points, axis=0).max())
    loops = [vertices[list(face)] for vertices, faces in pieces for face in faces]
    owner = [number for number, (_, faces) in enumerate(pieces) for _ in faces]
    left = _uncovered(loops, owner, _TOUCH * extent)
    if not left:
        return []
    found = []
    for vertices, faces in _bodies(left, extent):
        own = merge_coplanar([vertices], [faces], 10.0 * _TOUCH)[0]
        found.append(_straightened(vertices, own, _TOUCH * extent))
    return found


def cut_cell(
    pieces: Sequence[Piece], normals: Floats, offsets: Floats
) -> tuple[list[Piece], list[Piece]]:
    """The parts of bodies where ``normals @ x <= offsets``, and the rest.

    Parameters
    ----------
    pieces
    normals : (p, 3) unit
    offsets : (p,) [m]
    """
    inside: list[Piece] = list(pieces)
    outside: list[Piece] = []
    for normal, offset in zip(normals, offsets, strict=True):
        now: list[Piece] = []
        for piece in inside:
            below, above = _cut(piece, normal, float(offset))
            now += below
            outside += above
        inside = now
    return inside, outside


def _cut(piece: Piece, normal: Floats, offset: float) -> tuple[list[Piece], list[Piece]]:
    """The parts of a body below and above a plane. Vertices near the plane are put onto it."""
    vertices, faces = np.array(piece[0]), piece[1]
    extent = float(np.ptp(vertices, axis=0).max())
    height = vertices @ normal - offset
    on = np.abs(height) <= _TOUCH * extent
    vertices[on] -= height[on, None] * normal
    height[on] = 0.0
    if height.max() <= 0.0:
        return [piece], []
    if height.min() >= 0.0:
        return [], [piece]
    simple = halved(vertices, faces, height, _TOUCH * extent)
    if simple is not None:
        return [simple[0]], [simple[1]]
    below: list[Floats] = []
    above: list[Floats] = []
    for face in faces:
        some = list(face)
        for loops, sign in ((below, -1.0), (above, 1.0)):
            loops += _beyond(vertices[some], sign * height[some], extent)
        if not height[some].any():
            area = area_vector(vertices[some])
            (below if area @ normal > 0.0 else above).append(vertices[some])
    return (
        _bodies([*below, *_lids(below, normal, offset, extent)], extent),
        _bodies([*above, *_lids(above, -normal, -offset, extent)], extent),
    )


def _beyond(corner: Floats, height: Floats, extent: float) -> list[Floats]:
    """The parts of a loop where the height of its corners is above zero."""
    if height.max() <= 0.0:
        return []
    if height.min() >= 0.0:
        return [corner]
    side = np.sign(height[height != 0.0])
    if (side != np.roll(side, 1)).sum() > 2:
        return _beyond_concave(corner, height, extent)
    out = []
    for i in range(len(corner)):
        j = (i + 1) % len(corner)
        if height[i] >= 0.0:
            out.append(corner[i])
        if height[i] * height[j] < 0.0:
            first, last = (i, j) if height[i] < 0.0 else (j, i)
            share = height[first] / (height[first] - height[last])
            out.append(corner[first] + share * (corner[last] - corner[first]))
    return [np.array(out)] if len(out) > 2 else []


def _beyond_concave(corner: Floats, height: Floats, extent: float) -> list[Floats]:
    """As :func:`_beyond`, where a line cuts a loop more than twice."""
    area = area_vector(corner)
    frame = frames_from_normals((area / np.linalg.norm(area))[None])[0]
    flat = (corner - corner[0]) @ frame[1:].T
    slope, *_ = np.linalg.lstsq(np.column_stack([flat, np.ones(len(flat))]), height, rcond=None)
    region = half_plane(slope[:2], float(slope[2]), 4.0 * extent)
    if region is None:
        return [corner] if height.mean() > 0.0 else []
    shape = overlay(shapely.intersection, shapely.Polygon(flat), region)
    return [
        corner[0] + ring @ frame[1:]
        for part in parts_of(shape, "Polygon")
        for ring in rings_of(part, _TOUCH * extent * part.length)
    ]


def _lids(loops: Sequence[Floats], normal: Floats, offset: float, extent: float) -> list[Floats]:
    """The faces in a plane, with its normal, that close a body along its open edges."""
    if not loops:
        return []
    vertices, rounds = _rounds(loops, _TOUCH * extent)
    open_edges: set[tuple[int, int]] = set()
    for loop in rounds:
        for edge in loop_edges(loop):
            if edge[::-1] in open_edges:
                open_edges.remove(edge[::-1])
            else:
                open_edges.add(edge)
    frame = frames_from_normals(normal[None])[0]
    flat = vertices @ frame[1:].T
    lines = [shapely.LineString(flat[list(edge)]) for edge in open_edges]
    section = shapely.Polygon()
    # where a face lies in the plane, an edge may run on along it
    for ring in shapely.get_parts(shapely.polygonize([shapely.union_all(lines)])):
        section = overlay(shapely.symmetric_difference, section, shapely.Polygon(ring.exterior))
    return [
        offset * normal + ring @ frame[1:]
        for part in parts_of(section, "Polygon")
        for ring in rings_of(part, _TOUCH * extent * part.length)
    ]


def _rounds(loops: Sequence[Floats], near: float) -> tuple[Floats, list[Loop]]:
    """The points of some loops, those nearer than this as one, and the loops of them."""
    corners = np.concatenate(loops)
    kept, number = distinct(corners, near)
    rounds = [_simple(number[rows].tolist()) for rows in Ragged.of(loops)]
    return corners[kept], [face for face in rounds if face]


def _bodies(loops: Sequence[Floats], extent: float) -> list[Piece]:
    """Closed bodies from loose faces.

    Raises
    ------
    InputError
        They do not close.
    """
    if not loops:
        return []
    near = _TOUCH * extent
    vertices, rounds = _rounds(loops, near)
    faces = [_simple(face) for face in _with_points_between(rounds, vertices, near)]
    faces = [face for face in faces if face]
    open_edges, _, consistent = edge_defects(faces)
    if open_edges or not consistent:
        raise InputError(
            "the parts of a body do not fit together",
            remedy="make the change a little larger or smaller",
        )
    bodies = []
    for some in split_solids(vertices, faces):
        own = [faces[i] for i in some]
        if edge_defects(own)[1]:
            raise InputError("a body would touch itself", remedy="make the change a little larger")
        bodies.append((vertices, own))
    return bodies


def _uncovered(loops: Sequence[Floats], owner: Sequence[int], near: float) -> list[Floats]:
    """Loops without the area that a face of another piece covers from the other side."""
    start = np.cumsum([0, *(len(loop) for loop in loops)]).astype(np.intp)
    normal = unit(area_vectors(np.concatenate(loops), start))[0]
    low = np.array([loop.min(axis=0) for loop in loops]) - near
    high = np.array([loop.max(axis=0) for loop in loops]) + near
    owners = np.array(owner)
    facing: list[list[int]] = [[] for _ in loops]
    for i in range(len(loops)):
        rest = slice(i + 1, None)
        may = (owners[rest] != owners[i]) & (normal[rest] @ normal[i] <= -0.99)
        may &= (low[i] <= high[rest]).all(axis=1) & (low[rest] <= high[i]).all(axis=1)
        for j in (i + 1 + np.flatnonzero(may)).tolist():
            if (
                max(
                    np.abs((loops[j] - loops[i][0]) @ normal[i]).max(),
                    np.abs((loops[i] - loops[j][0]) @ normal[j]).max(),
                )
                <= 4.0 * near
            ):
                facing[i].append(j)
                facing[j].append(i)
    left: list[Floats] = []
    for i, loop in enumerate(loops):
        if not facing[i]:
            left.append(loop)
            continue
        frame = frames_from_normals(normal[i][None])[0]

        # a loop may run back over itself
        flat = [shapely.Polygon((loops[j] - loop[0]) @ frame[1:].T) for j in (i, *facing[i])]
        shape, *covers = valid(np.array(flat, dtype=object))
        for cover in covers:
            shape = overlay(shapely.difference, shape, cover)
        # narrower than the tolerance: rounding
        with np.errstate(divide="ignore", invalid="ignore"):  # the tip of a spike has no mitre
            core = shape.buffer(-near, join_style="mitre").buffer(near, join_style="mitre")
        if core.is_empty:
            continue
        kept: list[shapely.Polygon] = []
        for one in parts_of(shape, "Polygon"):
            # a strip of rounding may join what a cover divides
            wide = [part for part in parts_of(core, "Polygon") if part.intersects(one)]
            kept += wide if len(wide) > 1 else [one] * len(wide)
        left += [
            loop[0] + ring @ frame[1:] for part in kept for ring in rings_of(part, near * near)
        ]
    return left


def _simple(loop: Sequence[int]) -> Loop:
    """A loop without repeated neighbours and without spikes; empty where nothing is left."""
    kept = list(loop)
    i = 0
    while len(kept) > 2 and i < len(kept):
        before, here, after = kept[i - 1], kept[i], kept[(i + 1) % len(kept)]
        if here in (before, after) or before == after:
            kept.pop(i)
            i = max(i - 2, 0)
        else:
            i += 1
    return tuple(kept) if len(set(kept)) > 2 else ()


def _with_points_between(
    faces: Sequence[Loop], vertices: Floats, near: float
) -> list[tuple[int, ...]]:
    """The loops with every vertex that lies on one of their edges."""
    ends = np.array([edge for face in faces for edge in loop_edges(face)], dtype=np.intp)
    if not faces:
        return []
    found = iter(points_between(vertices, ends, np.arange(len(vertices)), near))
    return [tuple(v for a in face for v in (a, *next(found))) for face in faces]


def _straightened(vertices: Floats, faces: Sequence[Loop], near: float) -> Piece:
    """The body without vertices in the middle of straight edges, and without unused ones."""
    bends = np.zeros(len(vertices), dtype=bool)
    for face in faces:
        corner = vertices[list(face)]
        before, after = np.roll(corner, 1, axis=0), np.roll(corner, -1, axis=0)
        chord = after - before
        length = np.linalg.norm(chord, axis=1)
        height = np.linalg.norm(np.cross(corner - before, chord), axis=1)
        bend = height > near * length
        bend |= ((corner - before) * (after - corner)).sum(axis=1) <= 0.0
        bends[list(face)] |= bend
    new = np.cumsum(bends) - 1
    loops = [tuple(int(new[v]) for v in face if bends[v]) for face in faces]
    return vertices[bends], [loop for loop in loops if len(loop) > 2]
