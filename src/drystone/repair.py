"""Mending blocks on request: what is done is said in the block's ``repairs``, nothing is filled."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly, Block, replace_block
from drystone.errors import InputError
from drystone.geometry import coincidence, polyhedron, solid
from drystone.geometry.arrays import Floats, frozen_floats
from drystone.geometry.polyhedron import Loop

MERGE = 1e-6
"""Vertices nearer than this share of a block's size are merged when asked to; chosen, the digits of
single precision."""


def mended_block(
    vertices: Floats,
    faces: Sequence[Sequence[int]],
    name: str = "block",
    density: float = DEFAULT_DENSITY,
    *,
    merge: float = MERGE,
) -> Block:
    """A block from faces that do not share their vertices, or lie twice in one place.

    Coincident vertices are merged, faces that have no area afterwards are dropped, turned faces are
    turned back. Holes are not filled: what stays open is refused.

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
    points = frozen_floats(vertices, (None, 3), "vertices")
    given = [tuple(int(i) for i in face) for face in faces]
    for number, face in enumerate(given):
        if face and not 0 <= min(face) <= max(face) < len(points):
            raise InputError(f"face {number} names no vertex", where=f"block '{name}'")
    welded, merged = coincidence.weld(points, given, merge)
    notes = [f"{merged} coincident vertices merged"] if merged else []
    kept = [loop for loop in welded if len(set(loop)) == len(loop)]
    if len(kept) < len(given):
        notes.append(f"{len(given) - len(kept)} faces without area dropped")
    return Block(points, tuple(kept), name, density, repairs=tuple(notes))


def shells(block: Block) -> tuple[tuple[int, ...], ...]:
    """Faces of the parts of a block that hang together, each with the cavities inside it.

    Examples
    --------
    >>> from drystone.models import box
    >>> shells(box((1.0, 1.0, 1.0)))
    ((0, 1, 2, 3, 4, 5),)
    """
    parts = polyhedron.face_components(block.faces)
    if len(parts) == 1:
        return (tuple(parts[0]),)
    loops: list[list[Loop]] = [[block.faces[f] for f in part] for part in parts]
    faces = polyhedron.stack_faces([block.vertices] * len(parts), loops)
    volume, _ = polyhedron.mass_properties(faces, len(parts))
    outer = [i for i in range(len(parts)) if volume[i] > 0.0]
    members = {i: list(parts[i]) for i in outer}
    triangles, face = polyhedron.fan_triangles(faces)
    for i in np.flatnonzero(volume <= 0.0).tolist():
        corner = block.vertices[[loops[i][0][0]]]
        around = [j for j in outer if solid.inside(corner, triangles[faces.owner[face] == j])[0]]
        members[min(around, key=lambda j: float(volume[j])) if around else outer[0]] += parts[i]
    return tuple(tuple(sorted(members[i])) for i in outer)


def split_shells(assembly: Assembly) -> Assembly:
    """The assembly with every block that consists of separate parts split into blocks.

    A part is a closed surface with the cavities in it. The parts of ``x`` are called ``x/0``,
    ``x/1``, ... and keep its density, metadata and support; ``repairs`` says where they are from.

    Examples
    --------
    >>> from drystone.models import tower
    >>> split_shells(tower(2)).names
    ('block-0', 'block-1')
    """
    blocks: list[Block] = []
    fixed: list[bool] = []
    for block, held in zip(assembly.blocks, assembly.fixed.tolist(), strict=True):
        parts = shells(block)
        if len(parts) == 1:
            blocks.append(block)
        for number, part in enumerate(parts if len(parts) > 1 else ()):
            own, loops = _own(block, part)
            note = f"part {number + 1} of {len(parts)} of '{block.name}'"
            blocks.append(
                replace_block(
                    block,
                    vertices=own,
                    faces=loops,
                    name=f"{block.name}/{number}",
                    repairs=(*block.repairs, note),
                )
            )
        fixed += [held] * len(parts)
    return Assembly(tuple(blocks), np.array(fixed, dtype=bool))


def _own(block: Block, part: Sequence[int]) -> tuple[Floats, tuple[Loop, ...]]:
    """Vertices and faces of some faces of a block."""
    loops = [block.faces[f] for f in part]
    used = sorted({i for loop in loops for i in loop})
    place = {old: new for new, old in enumerate(used)}
    return block.vertices[used], tuple(tuple(place[i] for i in loop) for loop in loops)


__all__ = ["mended_block", "shells", "split_shells"]
