"""What may move: groups of vertices, each along directions of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np
from scipy import sparse

from drystone.base.arrays import SAME, Bools, Floats
from drystone.base.display import named
from drystone.base.errors import InputError
from drystone.design.mends import kept_blocks
from drystone.design.shared_planes import Moves, SharedPlanes
from drystone.design.vertex_measures import owners_of, vertices_of
from drystone.design.vertex_places import (
    AXES,
    Places,
    axis_of,
    is_prism,
    on_side,
    places_of,
    require_prisms,
    slides,
)
from drystone.geometry.frames import unit
from drystone.model import Model

Prisms: TypeAlias = Literal["x", "y", "z", "none"] | None
"""The axis along which blocks are prisms."""


def prism_axis(model: Model, keep: Sequence[int | str] = ()) -> Prisms:
    """The first of y, x and z along which all free blocks but those to keep are prisms."""
    stay = {*np.flatnonzero(model.assembly.fixed).tolist(), *kept_blocks(model, keep)}
    some = [block for i, block in enumerate(model.assembly.blocks) if i not in stay]
    for axis in ("y", "x", "z"):
        if all(is_prism(block, axis) for block in some):
            return axis
    return None


def free_vertices(
    model: Model,
    most: float,
    directions: str | None = None,
    along: Prisms = "y",
    mirror: Literal["x", "y", "z"] | None = None,
    keep: Sequence[int | str] = (),
    keep_side: Literal["intrados", "extrados"] | None = None,
    sectors: int = 1,
) -> Moves:
    """Vertices that move freely; those at one place move together, so that joints stay shared.

    Joints stay plane: where a move would bend a joint, other vertices of the joint follow it
    (:class:`Moves`). Faces that no joint covers may be warped; a warped face is its fan about
    the mean of its corners.

    Parameters
    ----------
    model
    most : [m] > 0
        Largest move of each vertex along each direction. On the command line, a tenth of a block
        when left out.
    directions
        Axes along which they move, such as ``xz``; when left out, all but ``along``.
    along
        Vertices that differ along this axis only move together: blocks that are prisms along it
        stay prisms; ``none`` for other blocks, such as those of domes and shells. On the command
        line, the axis of all blocks when left out.
    mirror
        Vertices that are mirror images along this axis, about the middle of the model, move as
        mirror images.
    keep
        Names, patterns or positions of blocks whose vertices stay. Those of fixed blocks stay in
        any case.
    keep_side
        ``intrados`` or ``extrados``: the vertices of that side stay.
    sectors : >= 1
        Equal sectors about a vertical axis through the middle of the model that stay equal.

    Raises
    ------
    InputError
        An axis or a side is unknown, the model does not have the symmetry, every move would bend a
        joint, or nothing is left to move.
    """
    along = None if along == "none" else along
    if directions is None:
        directions = "".join(axis for axis in AXES if axis != along)
    ways = np.eye(3)[[axis_of(axis) for axis in directions]]
    if along is not None and along in directions:
        raise InputError(
            f"vertices along {along} cannot move along {along}",
            remedy="leave that direction out, or name no axis of prisms",
        )
    kept = model.assembly.fixed.copy()
    kept[list(kept_blocks(model, keep))] = True
    if along is not None:
        require_prisms(model, along, kept)
    places = Places.of(model, along, mirror, sectors)
    still = kept[owners_of(model.assembly)]
    if keep_side is not None:
        still |= on_side(model, keep_side, along)
    return _moves(model, places, [ways] * places.count, kept, most, still)


def joint_moves(
    model: Model,
    most: float,
    along: Prisms = "y",
    mirror: Literal["x", "y", "z"] | None = None,
    keep: Sequence[int | str] = (),
) -> Moves:
    """Joint planes that turn and move: the ends of each joint slide along the sides of its blocks.

    At each end a joint slides along the mean direction of the two sides that meet there: along the
    intrados at one end, along the extrados at the other one. Joints with supports move too.

    Parameters
    ----------
    model
    most : [m]
        Largest move of each end of a joint.
    along, mirror
        As for :func:`free_vertices`.
    keep
        Names, patterns or positions of blocks whose vertices stay.

    Raises
    ------
    InputError
        An axis is unknown, a face would not stay plane, or no joint has ends that two blocks share.
    """
    along = None if along == "none" else along
    kept = np.zeros(len(model), dtype=bool)
    kept[list(kept_blocks(model, keep))] = True
    if along is not None:
        require_prisms(model, along, kept)
    places = Places.of(model, along, mirror)
    still = kept[owners_of(model.assembly)]
    return _moves(model, places, slides(model, places), kept, most, still)


def _moves(
    model: Model,
    places: Places,
    ways: Sequence[Floats],
    kept: Bools,
    most: float,
    still: Bools,
) -> Moves:
    """The moves of places along ways (w, 3) each; blocks (n,), or vertices (v,), may stay."""
    matrix = places.matrix(ways, still)
    if not matrix.shape[1]:
        names = [model.assembly.names[i] for i in np.flatnonzero(kept)]
        stay = f": the blocks {named(names)} stay" if names else ""
        raise InputError(
            f"no vertex may move{stay}",
            remedy="keep fewer blocks, or allow more directions",
        )
    return Moves.of(matrix, most, vertices_of(model.assembly), SharedPlanes.of(model, still))


def thickening(model: Model, middle: Sequence[float], most: float) -> Moves:
    """One variable: by how much an arch about a line along y through a point (3,) gets thicker [m].

    Vertices of free blocks that are farther from the line than the mean move outward by half of it,
    nearer ones inward; vertices of fixed blocks at the same places go with them.

    Raises
    ------
    InputError
        A vertex is on the line.
    """
    vertex = vertices_of(model.assembly)
    free = ~model.assembly.fixed[owners_of(model.assembly)]
    away = (vertex - np.asarray(middle, dtype=np.float64)) * np.array([1.0, 0.0, 1.0])
    radius = np.linalg.norm(away, axis=1)
    if not radius[free].min() > 0.0:
        raise InputError("a vertex is on the line in the middle", remedy="give another point")
    group = places_of(vertex, SAME * float(np.ptp(vertex, axis=0).max()))
    takes_part = np.isin(group, group[free])
    mean = 0.5 * (radius[free].min() + radius[free].max())
    side = np.where(takes_part, np.where(radius > mean, 0.5, -0.5), 0.0)
    step = away * (side / np.where(takes_part, radius, 1.0))[:, None]
    return Moves.of(sparse.csr_matrix(step.reshape(-1, 1)), most, vertex, None)


def block_moves(
    model: Model, blocks: Sequence[int | str], direction: Sequence[float], most: float
) -> Moves:
    """One variable for each block, which moves as a whole along a direction (3,)."""
    along = unit(np.asarray(direction, dtype=np.float64), "the direction")
    owner = owners_of(model.assembly)
    some = model.assembly.indices(list(blocks))
    matrix = ((owner[:, None] == some)[:, None, :] * along[:, None]).reshape(-1, len(some))
    return Moves.of(sparse.csr_matrix(matrix), most, vertices_of(model.assembly), None)
