"""Check that no two blocks of a shell overlap."""

from __future__ import annotations

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools
from drystone.base.errors import InputError, counted
from drystone.geometry import boxes
from drystone.geometry.selfcontact import convex_bodies
from drystone.geometry.shared_volume import shared_volumes
from drystone.shells.pattern import Tessellation

_TOLERANCE = 1e-6
"""Largest overlap of two blocks, relative to the width of a block."""


def refuse_overlaps(assembly: Assembly, mesh: Tessellation, width: float, ground: Bools) -> None:
    """Refuse a shell with blocks that overlap.

    Parameters
    ----------
    assembly
        A block for each cell of the mesh.
    mesh
    width : [m]
        Mean width of a block.
    ground : (c,)
        Which cells are ground.

    Raises
    ------
    InputError
        The surface crosses itself; two parts of it are closer than the thickness; or a strongly
        curved block reaches into its neighbour.
    """
    least, bounds, blocks = _TOLERANCE * width, assembly.bounds, assembly.blocks
    a, b = boxes.overlapping(bounds[:, 0] + 0.5 * least, bounds[:, 1] - 0.5 * least)
    convex = convex_bodies([block.vertices for block in blocks], [block.faces for block in blocks])
    found = shared_volumes(assembly.faces, a, b, np.full(len(a), least), convex)
    if not len(found.row):
        return
    a, b, depth = a[found.row], b[found.row], found.depth
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
    rest = f", and {counted(len(a) - 1, 'more pair')}" if len(a) > 1 else ""
    raise InputError(
        f"overlap, {depth[worst]:.2g} m deep{rest}",
        where=f"blocks '{mesh.names[one]}' and '{mesh.names[other]}'",
        remedy=remedy,
    )
