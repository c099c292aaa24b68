"""Mending blocks on request: what is done is said in the block's ``repairs``, nothing is filled."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly, Block, replace_block
from drystone.base.arrays import Floats, frozen_points
from drystone.base.errors import InputError, counted
from drystone.geometry import coincidence
from drystone.geometry.backing import backed
from drystone.geometry.parts import separate_parts
from drystone.geometry.polyhedron import Loop

_MERGE = 1e-6
"""Vertices nearer than this share of a block's size are merged when asked to; chosen, the digits of
single precision."""
_BACKING = 0.25
"""Thickness behind an open surface, by the size of the median block. Chosen: tolerances, which are
relative to the thinner of two blocks, stay those of the blocks."""


def mended_block(
    vertices: Floats,
    faces: Sequence[Sequence[int]],
    name: str = "block",
    density: float = DEFAULT_DENSITY,
    *,
    merge: float = _MERGE,
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
    density : [kg/m3]
    merge
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
    if not 0.0 <= merge <= 0.01:
        raise InputError(f"merge is {merge}", remedy="give a share of the block size up to 0.01")
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
    kept, again = coincidence.once(kept)
    if again:
        notes.append(f"{counted(again, 'face')} that occurred twice dropped")
    return Block(points, tuple(kept), name, density, repairs=tuple(notes))


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
    used = sorted({i for loop in loops for i in loop})
    place = {old: new for new, old in enumerate(used)}
    return replace_block(
        block,
        vertices=block.vertices[used],
        faces=tuple(tuple(place[i] for i in loop) for loop in loops),
        name=name,
        repairs=repairs,
    )


__all__ = ["mended_block", "split_components", "support_from_surface"]
