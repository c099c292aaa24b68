"""Mending blocks on request: what is done is said in the ``repairs`` of the block.

An open surface that stands still gets a body behind it: it needs no volume of its own.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly, Block, replace_block
from drystone.base.arrays import ROUNDING, SAME, Floats, frozen_points, unit
from drystone.base.errors import InputError, counted
from drystone.base.settings import hold
from drystone.geometry import coincidence
from drystone.geometry.coincidence import first_coincident
from drystone.geometry.frames import area_vector
from drystone.geometry.polyhedron import (
    Loop,
    enclosed_volume,
    fan_triangles,
    loop_edges,
    rings,
    stack_faces,
    used_vertices,
)
from drystone.geometry.selfcontact import self_contacts
from drystone.geometry.solid import winding_number
from drystone.geometry.soup import (
    plane_lids,
    pulled_apart,
    separate_parts,
    with_joints,
    without_membranes,
)
from drystone.geometry.surface import edge_defects, edge_uses, face_components, orient

_SLOPE = 0.1
"""A surface is a field of heights when the sine of the slope of each face is above this. Chosen."""
_TRIES = 6
"""So often the thickness is halved before a surface is refused."""

Body = tuple[Floats, list[Loop]]


def backed(
    vertices: Floats, faces: Sequence[Loop], beside: Floats, thickness: float
) -> tuple[Body, list[str]]:
    """A closed body with a given open surface, and what was done.

    Each connected part of the surface is treated alone. A mesh with holes around a body that has
    nothing inside gets its holes closed. Any other surface, such as a face, a terrain or a frame,
    gets a body of a given thickness behind it, on the side away from what is beside it.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops in any orientation.
    beside : (n, 3) [m]
        Centroids of the blocks that rest on the surface; may be empty.
    thickness : [m]
        Halved where the body would touch itself.

    Raises
    ------
    InputError
        More than two faces meet at an edge, a face has no area, or no body fits behind the surface.

    Examples
    --------
    >>> floor = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> (points, loops), done = backed(floor, [(0, 1, 2, 3)], np.array([[0.5, 0.5, 2.0]]), 0.25)
    >>> float(points[:, 2].min()), len(loops), done
    (-0.25, 6, ['an open surface backed by 0.25 m'])
    """
    extent = float(np.linalg.norm(np.ptp(vertices, axis=0))) if len(vertices) else 0.0
    first = first_coincident(vertices, ROUNDING * extent).tolist()
    loops = [tuple(dict.fromkeys(first[i] for i in face)) for face in faces]
    loops = orient([loop for loop in loops if len(loop) >= 3])[0]
    points: list[Floats] = []
    every: list[Loop] = []
    done: list[str] = []
    for part in face_components(loops):
        body, how = _closed([loops[i] for i in part], vertices, beside, thickness)
        offset, step = sum(map(len, points)), -1 if enclosed_volume(*body) < 0.0 else 1
        points.append(body[0])
        every += [tuple(i + offset for i in loop)[::step] for loop in body[1]]
        done.append(how)
    if not every:
        raise InputError("it has no face with an area")
    return (np.concatenate(points), every), list(dict.fromkeys(done))


def _closed(
    loops: list[Loop], vertices: Floats, beside: Floats, thickness: float
) -> tuple[Body, str]:
    """One connected surface as a closed body, and how."""
    used, loops = used_vertices(loops)
    points = vertices[used]
    border = _border(loops)
    if not border:
        return (points, loops), "a closed part kept"
    vector = np.array([area_vector(points[list(loop)]) for loop in loops])
    normal, area = unit(vector)
    if not (area > 0.0).all():
        raise InputError(f"face {int(np.argmin(area))} of its open surface has no area")
    front = _front(points, loops, beside)
    across = unit(vector.sum(axis=0)[None])[0][0]
    if (normal @ across).min() > _SLOPE:
        back = points - front * thickness * across
        return _sheet(points, back, loops, border), f"an open surface backed by {thickness:.3g} m"
    filled = _filled(points, loops, border)
    inside_out = enclosed_volume(*filled) < 0.0
    if (front < 0.0) == inside_out and _sound(filled):
        return filled, "the holes of a surface closed"
    at_vertex = np.zeros(points.shape)
    for loop, one in zip(loops, vector, strict=True):
        at_vertex[list(loop)] += one
    outward = unit(at_vertex)[0]
    for _ in range(_TRIES):
        sheet = _sheet(points, points - front * thickness * outward, loops, border)
        if _sound(sheet):
            return sheet, f"an open surface backed by {thickness:.3g} m"
        thickness *= 0.5
    raise InputError("no body fits behind its open surface", remedy="give it a thickness")


def _border(loops: Sequence[Loop]) -> list[tuple[int, int]]:
    """Edges of one face only, as that face runs them."""
    uses = edge_uses(loops).values()
    if any(len(runs) > 2 for runs in uses):
        raise InputError("more than two faces meet at an edge of its open surface")
    return [runs[0][1] for runs in uses if len(runs) == 1]


def _front(points: Floats, loops: Sequence[Loop], beside: Floats) -> float:
    """1 where what is beside a surface sees its front, the side of its normals, else -1."""
    fans = fan_triangles(stack_faces([points], [loops]))[0]
    behind = winding_number(beside, fans).sum()
    return -1.0 if behind > 0.0 else 1.0


def _sheet(
    points: Floats, back: Floats, loops: Sequence[Loop], border: Sequence[tuple[int, int]]
) -> Body:
    """The body between a surface and a copy of it."""
    count = len(points)
    behind = [tuple(i + count for i in loop[::-1]) for loop in loops]
    sides: list[Loop] = [(b, a, a + count, b + count) for a, b in border]
    return np.concatenate([points, back]), [*loops, *behind, *sides]


def _filled(points: Floats, loops: Sequence[Loop], border: Sequence[tuple[int, int]]) -> Body:
    """The surface with a fan of triangles over each hole."""
    fans, middles = list[Loop](), list[Floats]()
    for ring in rings({b: a for a, b in border}):
        apex = len(points) + len(middles)
        middles.append(points[ring].mean(axis=0))
        fans += [(a, b, apex) for a, b in loop_edges(tuple(ring))]
    return np.concatenate([points, np.array(middles)]), [*loops, *fans]


def _sound(body: Body) -> bool:
    """Whether a closed body has a volume and does not touch itself."""
    points, loops = body
    if abs(enclosed_volume(*body)) < 3e-4 * float(np.linalg.norm(np.ptp(points, axis=0))) ** 3:
        return False
    return not self_contacts([points], [loops])


_NEAR = 1e-5
"""Vertices as near to an edge, and holes as near to a plane, lie on it; relative to the size.
Chosen: the rounding of a file with five digits."""
_THIN = 100.0
"""A part is none when its volume is less than this multiple of the distance of merged vertices
times the square of the size of the mesh. Chosen: parts that only pulling apart gave a volume."""
_BACKING = 0.25
"""Thickness behind an open surface, by the size of the median block. Chosen: tolerances, which are
relative to the thinner of two blocks, stay those of the blocks."""


def mended_block(
    vertices: Floats,
    faces: Sequence[Sequence[int]],
    name: str = "block",
    density: float = DEFAULT_DENSITY,
    *,
    merge: float = SAME,
) -> Block:
    """A block from faces that do not share their vertices, or lie twice in one place.

    Coincident vertices are merged. Faces that have no area afterwards, or occur a second time, are
    dropped. Turned faces are turned back. Holes are not filled: what stays open is refused.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops of vertex indices.
    name
        Of the block.
    density : [kg/m3]
    merge : >= 0, <= 0.01
        Distance relative to the size of the block.

    Returns
    -------
    Block
        With a note in ``repairs`` for everything that was done.

    Raises
    ------
    InputError
        Still open, non-manifold or flat.

    Examples
    --------
    >>> from drystone.models import box
    >>> cube = box((1.0, 1.0, 1.0))
    >>> loose = cube.vertices[[i for face in cube.faces for i in face]]
    >>> mended = mended_block(loose, [range(4 * i, 4 * i + 4) for i in range(6)])
    >>> len(mended.vertices), mended.repairs
    (8, ('16 coincident vertices merged', '16 unused vertices dropped'))
    """
    points, kept, notes = _welded(vertices, faces, name, merge)
    return Block(points, tuple(kept), name, density, repairs=tuple(notes))


def mended_blocks(
    vertices: Floats,
    faces: Sequence[Sequence[int]],
    name: str = "block",
    density: float = DEFAULT_DENSITY,
) -> tuple[Block, ...]:
    """The blocks that a broken mesh stands for; more is mended than by :func:`mended_block`.

    Further to what that does, vertices on open edges of neighbours are joined with them, faces
    inside the body are removed, plane holes get a face, and parts of the surface that touch each
    other along an edge or at a corner are pulled apart by a millionth of the size. Closed parts
    become blocks, called ``x-0``, ``x-1``, ... where there are several.

    Parameters
    ----------
    vertices, faces, name, density
        As for :func:`mended_block`.

    Returns
    -------
    blocks
        With notes in ``repairs`` for everything that was done, and the volume before and after.

    Raises
    ------
    InputError
        It stays open, or a part of it has no volume.

    Examples
    --------
    >>> from drystone.models import box
    >>> cube = box((1.0, 1.0, 1.0))
    >>> (mended,) = mended_blocks(cube.vertices, cube.faces[1:])
    >>> mended.repairs
    ('1 plane hole closed', 'volume 1 m3, 0.833333 m3 before')
    """
    try:
        return _mended(vertices, faces, name, density, sided=True)
    except InputError:  # a wall between two bodies has two faces, and so has a sheet drawn twice
        return _mended(vertices, faces, name, density, sided=False)


def _mended(
    vertices: Floats,
    faces: Sequence[Sequence[int]],
    name: str,
    density: float,
    *,
    sided: bool,
) -> tuple[Block, ...]:
    """See :func:`mended_blocks`; with ``sided``, faces may coincide with opposite orientations."""
    points, loops, notes = _welded(vertices, faces, name, SAME, sided=sided)
    used = points[sorted({i for loop in loops for i in loop})]
    size = float(np.linalg.norm(np.ptp(used, axis=0))) if len(used) else 0.0

    def done(number: int, one: str, many: str, what: str) -> None:
        if number:
            notes.append(f"{counted(number, one, many)} {what}")

    loops, joints = with_joints(points, loops, _NEAR * size)
    done(joints, "vertex", "vertices", "joined with the edges that they lie on")
    loops, turned = orient(loops)
    done(len(turned), "face", "faces", "turned to agree with the others")
    loops, inside = without_membranes(points, loops)
    done(inside, "face", "faces", "inside removed")
    lids, holes = plane_lids(points, loops, _NEAR * size)
    loops += lids
    done(holes, "plane hole", "plane holes", "closed")
    if not loops:
        raise InputError("no face of it is left", where=f"block '{name}'")
    before = enclosed_volume(points, [tuple(map(int, face)) for face in faces])
    open_edges = edge_defects(loops)[0]
    if open_edges:
        raise InputError(
            f"it stays open at {counted(len(open_edges), 'edge')}", where=f"block '{name}'"
        )
    points, loops, parted = pulled_apart(points, loops, SAME * size)
    done(parted, "vertex", "vertices", "at which it touched itself parted")
    parts, shells = separate_parts(points, loops)
    if sided and shells:
        raise InputError("a sheet is drawn twice", where=f"block '{name}'")
    done(shells, "closed surface", "closed surfaces", "turned")
    made = []
    for number, part in enumerate(parts):
        own = name if len(parts) == 1 else f"{name}-{number}"
        block = Block(points, tuple(part), own, density)
        if block.volume <= _THIN * SAME * size**3:
            raise InputError("a part of it has no volume", where=f"block '{own}'")
        made.append(Block(block.vertices, block.faces, own, density))
    if len(parts) > 1:
        notes.append(f"split into its {len(parts)} parts")
    if not notes:
        return tuple(made)
    after = sum(block.volume for block in made)
    notes.append(f"volume {after:.6g} m3, {abs(before):.6g} m3 before")
    return tuple(replace_block(block, repairs=tuple(notes)) for block in made)


def _welded(
    vertices: Floats,
    faces: Sequence[Sequence[int]],
    name: str,
    merge: float,
    *,
    sided: bool = False,
) -> tuple[Floats, list[Loop], list[str]]:
    """Points, faces with coincident vertices merged and each once, and notes."""
    points = frozen_points(vertices, (None, 3), "vertices")
    given = [tuple(int(i) for i in face) for face in faces]
    for number, face in enumerate(given):
        if face and not 0 <= min(face) <= max(face) < len(points):
            raise InputError(f"face {number} names no vertex", where=f"block '{name}'")
    welded, merged = coincidence.weld(points, given, merge)
    one, many = "coincident vertex", "coincident vertices"
    notes = [f"{counted(merged, one, many)} merged"] if merged else []
    kept = [loop for loop in welded if len(set(loop)) == len(loop)]
    if len(kept) < len(given):
        notes.append(f"{counted(len(given) - len(kept), 'face')} without area dropped")
    kept, again = coincidence.once(kept, sided=sided)
    if again:
        notes.append(f"{counted(again, 'face')} that occurred twice dropped")
    return points, kept, notes


def support_from_surface(
    vertices: Floats,
    faces: Sequence[Sequence[int]],
    blocks: Sequence[Block],
    name: str = "support",
    density: float = DEFAULT_DENSITY,
) -> Block:
    """A block that stands still, from an open surface: a face, a terrain, a frame.

    A mesh with holes gets them closed where that makes a body. The side of any other surface on
    which most of the blocks are stays as it is. Behind it the block is a quarter as
    thick as the median block is large.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops of vertex indices, in any orientation.
    blocks
        Those that rest on it.
    name
        Of the block.
    density : [kg/m3]

    Returns
    -------
    Block
        With a note in ``repairs``.

    Raises
    ------
    InputError
        More than two faces meet at an edge, or no block fits behind the surface.

    Examples
    --------
    >>> from drystone.models import box
    >>> floor = np.array([[-1.0, -1, 0], [2, -1, 0], [2, 2, 0], [-1, 2, 0]])
    >>> support_from_surface(floor, [(0, 1, 2, 3)], [box((1.0, 1.0, 1.0))]).repairs
    ('an open surface backed by 0.433 m',)
    """
    points = frozen_points(vertices, (None, 3), "vertices")
    loops = [tuple(map(int, face)) for face in faces]
    if any(not 0 <= min(loop) <= max(loop) < len(points) for loop in loops if loop):
        raise InputError("a face names no vertex", where=f"block '{name}'")
    size = float(np.median([block.size for block in blocks])) if blocks else np.ptp(points)
    middle = np.array([block.centroid for block in blocks]).reshape(-1, 3)
    (corner, body), done = backed(points, loops, middle, _BACKING * float(size))
    made = Block(corner, tuple(body), name, density)
    return Block(corner, made.faces, name, density, repairs=tuple(done))


def split_components(assembly: Assembly) -> Assembly:
    """The assembly with every block that consists of separate parts split into blocks.

    A part is a closed surface with the cavities in it; a surface that is inside out is turned. The
    parts of ``x`` are called ``x-0``, ``x-1``, ... and keep its density, metadata and support;
    ``repairs`` says what was done.

    Parameters
    ----------
    assembly
        Is not changed.

    Examples
    --------
    >>> from drystone.models import tower
    >>> split_components(tower(2)).names
    ('block-0', 'block-1')
    """
    blocks: list[Block] = []
    fixed: list[bool] = []
    for block, held in zip(assembly.blocks, assembly.fixed.tolist(), strict=True):
        parts, turned = separate_parts(block.vertices, block.faces)
        notes = (*block.repairs, *([f"{turned} of its closed surfaces turned"] if turned else []))
        if len(parts) == 1 and not turned:
            blocks.append(block)
        elif len(parts) == 1:
            blocks.append(replace_block(block, faces=tuple(parts[0]), repairs=notes))
        else:
            for number, part in enumerate(parts):
                origin = f"part {number + 1} of {len(parts)} of '{block.name}'"
                blocks.append(_part(block, part, f"{block.name}-{number}", (*notes, origin)))
        fixed += [held] * len(parts)
    return Assembly(tuple(blocks), np.array(fixed, dtype=bool))


def _part(block: Block, loops: Sequence[Loop], name: str, repairs: tuple[str, ...]) -> Block:
    """A block of some faces of another, with only the vertices that they use."""
    used, own = used_vertices(loops)
    points = block.vertices[used]
    return replace_block(block, vertices=points, faces=tuple(own), name=name, repairs=repairs)


__all__ = ["mended_block", "mended_blocks", "split_components", "support_from_surface"]

hold(globals())
