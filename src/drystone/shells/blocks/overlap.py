"""No block of a shell stands in another."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from drystone.arrays import Floats, Ints, dot
from drystone.assembly import Assembly
from drystone.errors import InputError
from drystone.geometry import boxes
from drystone.geometry.body.depth import depths
from drystone.geometry.body.polyhedron import Faces
from drystone.geometry.plane.polygon import area_vectors
from drystone.shells.bond.tessellation import Tessellation

TOLERANCE = 1e-6
"""Largest depth of one block in another, by the width of a block."""

UPWARDS = np.array([0.0, 0.0, 1.0])
"""In place of the direction between the middles of two bodies at the same place."""


def refuse_overlaps(assembly: Assembly, mesh: Tessellation, width: float) -> None:
    """Look over the blocks of a shell for pairs that stand in each other.

    Parameters
    ----------
    assembly
        A block for each cell of the mesh.
    mesh
    width : [m]
        Of a block.

    Raises
    ------
    InputError
        There are such pairs: the surface crosses itself, or comes closer to itself than the shell
        is thick, or a block is bent so far that it grows into its neighbour.
    """
    a, b, depth = overlaps(assembly.faces, TOLERANCE * width, _meeting(mesh))
    if len(a) == 0:
        return
    ground = np.array([name.startswith("ground-") for name in mesh.names])
    beneath = ground[a] | ground[b]
    worst = int(np.lexsort((-depth, beneath))[0])
    one, other = int(a[worst]), int(b[worst])
    if set(mesh.cells[one]) & set(mesh.cells[other]):
        remedy = "use a smaller thickness or wedge, or larger blocks"
    elif beneath[worst]:
        remedy = "give a smaller ground depth, or move the supports apart"
    else:
        remedy = (
            "the surface must not cross itself, nor come closer to itself than the shell is thick"
        )
    more = len(a) - 1
    rest = f", and {more} more pair{'' if more == 1 else 's'}" if more else ""
    raise InputError(
        f"stand in each other, {depth[worst]:.2g} m deep{rest}",
        where=f"blocks '{mesh.names[one]}' and '{mesh.names[other]}'",
        remedy=remedy,
    )


def _meeting(mesh: Tessellation) -> Ints:
    """Pairs of blocks that share a vertex of the surface, as ``first * number + second``."""
    size = [len(cell) for cell in mesh.cells]
    vertex = np.concatenate([np.asarray(cell, dtype=np.intp) for cell in mesh.cells])
    row = np.repeat(np.arange(len(size)), size)
    within = sparse.csr_matrix((np.ones(len(vertex)), (row, vertex)))
    pairs = sparse.coo_matrix(within @ within.T)
    return pairs.row.astype(np.intp) * len(size) + pairs.col


def overlaps(faces: Faces, least: float, meeting: Ints) -> tuple[Ints, Ints, Floats]:
    """Pairs of bodies, first before second, that stand in each other deeper than ``least`` [m].

    Most neighbours are parted by a plane square to the line between their middles, or along the
    faces with which they look at each other; the depth of the others is measured. Blocks that meet
    on the surface are not copies of each other: only their edges are looked at.

    Returns
    -------
    first, second : (p,)
    depth : (p,) [m]
    """
    first_face = np.searchsorted(faces.owner, np.arange(int(faces.owner[-1]) + 2))
    first = faces.start[first_face]
    corner = faces.point[faces.loop]
    low = np.minimum.reduceat(corner, first[:-1], axis=0) + 0.5 * least
    high = np.maximum.reduceat(corner, first[:-1], axis=0) - 0.5 * least
    a, b = boxes.overlapping(low, high)
    middle = 0.5 * (low + high)
    normal = area_vectors(corner, faces.start)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    for facing in (None, 0, 1):
        direction = middle[b] - middle[a]
        length = np.linalg.norm(direction, axis=1, keepdims=True)
        direction = np.where(length > least, direction / np.maximum(length, 1e-300), UPWARDS)
        if facing is not None:
            direction = normal[_facing(normal, first_face, (a, b)[facing], direction)]
        near = _overlap(corner, first, a, b, direction) > least
        a, b, direction = a[near], b[near], direction[near]
    beside = np.isin(a * (int(faces.owner[-1]) + 1) + b, meeting)
    depth = depths(faces, a, b, np.full(len(a), least), direction, edges_only=beside)
    deep = depth > 0.0
    return a[deep], b[deep], depth[deep]


def _facing(normal: Floats, first_face: Ints, body: Ints, direction: Floats) -> Ints:
    """(p,) the face of each body that is most nearly square to a direction (p, 3)."""
    pair, face = boxes.expand(first_face[body], first_face[body + 1] - first_face[body])
    square = np.abs(dot(normal[face], direction[pair]))
    order = np.lexsort((square, pair))
    last = np.searchsorted(pair, np.arange(len(body)), side="right") - 1
    chosen: Ints = face[order[last]]
    return chosen


def _overlap(corner: Floats, first: Ints, a: Ints, b: Ints, direction: Floats) -> Floats:
    """(p,) [m] overlap of two bodies along a direction (p, 3); negative where they are apart."""
    low, high = [], []
    for body in (a, b):
        pair, at = boxes.expand(first[body], first[body + 1] - first[body])
        along = dot(corner[at], direction[pair])
        start = np.searchsorted(pair, np.arange(len(body)))
        low.append(np.minimum.reduceat(along, start) if len(body) else along)
        high.append(np.maximum.reduceat(along, start) if len(body) else along)
    overlap: Floats = np.minimum(high[0] - low[1], high[1] - low[0])
    return overlap
