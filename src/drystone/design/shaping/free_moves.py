"""What may move: groups of vertices, each along directions of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from drystone.base.arrays import Floats, Ints, number
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.design.shaping.vertex_measures import vertices_of
from drystone.model import Model

TOGETHER = 1e-6
"""Vertices are at the same place when they are nearer than this share of the size of the model."""

AXES = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True, eq=False)
class Moves(OneLine):
    """The variables of a shape: ``vertex = as given + matrix @ x``.

    Attributes
    ----------
    matrix : (3 v, p)
        Moves of the vertices of all blocks, one after the other, by each variable [m].
    most : (p,) [m]
        Largest size of each variable.
    """

    matrix: sparse.csr_matrix
    most: Floats

    def _summary(self) -> str:
        return f"{self.matrix.shape[1]} variables of {self.matrix.shape[0] // 3} vertices"

    @property
    def count(self) -> int:
        """Number of variables, p."""
        return int(self.matrix.shape[1])

    def moved(self, vertex: Floats, x: Floats) -> Floats:
        """The vertices (v, 3) moved by variables (p,).

        Raises
        ------
        InputError
            The moves are those of a model with other vertices.
        """
        if self.matrix.shape[0] != vertex.size:
            raise InputError(
                f"the moves are of {self.matrix.shape[0] // 3} vertices, the model has "
                f"{len(vertex)}",
                remedy="make the moves of this model",
            )
        out: Floats = vertex + (self.matrix @ x).reshape(-1, 3)
        return out

    def matrix_at(self, x: Floats) -> sparse.csr_matrix:  # noqa: ARG002
        """Derivative (3 v, p) of the vertices by the variables: the same everywhere."""
        return self.matrix


def free_vertices(
    model: Model,
    most: float,
    directions: str = "xz",
    along: str | None = "y",
    mirror: str | None = None,
    keep: Sequence[int | str] = (),
) -> Moves:
    """Vertices that move freely; those at one place move together, so that joints stay shared.

    Parameters
    ----------
    model
    most : [m]
        Largest move of each vertex along each direction.
    directions
        Axes along which they move, such as ``xz``.
    along
        Vertices that differ along this axis only move together: blocks that are prisms along it
        stay prisms, and their faces plane. ``None`` where faces are triangles.
    mirror
        Vertices that are mirror images along this axis, about the middle of the model, move as
        mirror images.
    keep
        Names or positions of blocks whose vertices stay. Those of fixed blocks stay in any case.

    Raises
    ------
    InputError
        An axis is unknown, a face would not stay plane, or nothing is left to move.
    """
    vertex, owner = vertices_of(model.assembly), _owners(model)
    size = float(np.ptp(vertex, axis=0).max())
    axes = [_axis(axis) for axis in directions]
    kept = model.assembly.fixed.copy()
    kept[model.assembly.indices(list(keep))] = True
    group = _places(_flattened(vertex, along), TOGETHER * size)
    _require_plane(model, along)
    stays = np.zeros(group.max() + 1, dtype=bool)
    stays[group[kept[owner]]] = True
    image, sign = np.arange(len(stays)), np.ones((len(stays), 3))
    if mirror is not None:
        image, sign = _images(_flattened(vertex, along), group, _axis(mirror), TOGETHER * size)
        stays |= stays[image]
    rows: list[int] = []
    columns: list[int] = []
    values: list[float] = []
    count = 0
    for one in np.flatnonzero(~stays & (np.arange(len(stays)) <= image)).tolist():
        for axis in axes:
            if image[one] == one and sign[one, axis] == 0.0:
                continue  # on the mirror plane, and moving off it
            for place, turn in {one: 1.0, int(image[one]): float(sign[one, axis])}.items():
                some = np.flatnonzero(group == place)
                rows += (3 * some + axis).tolist()
                columns += [count] * len(some)
                values += [turn if place != one else 1.0] * len(some)
            count += 1
    if not count:
        raise InputError("no vertex may move", remedy="keep fewer blocks, or allow more directions")
    matrix = sparse.csr_matrix((values, (rows, columns)), shape=(vertex.size, count))
    return Moves(matrix, _largest(most, count))


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
    free = ~model.assembly.fixed[_owners(model)]
    away = (vertex - np.asarray(middle, dtype=np.float64)) * np.array([1.0, 0.0, 1.0])
    radius = np.linalg.norm(away, axis=1)
    if not radius[free].min() > 0.0:
        raise InputError("a vertex is on the line in the middle", remedy="give another point")
    group = _places(vertex, TOGETHER * float(np.ptp(vertex, axis=0).max()))
    takes_part = np.isin(group, group[free])
    mean = 0.5 * (radius[free].min() + radius[free].max())
    side = np.where(takes_part, np.where(radius > mean, 0.5, -0.5), 0.0)
    step = away * (side / np.where(takes_part, radius, 1.0))[:, None]
    return Moves(sparse.csr_matrix(step.reshape(-1, 1)), _largest(most, 1))


def block_moves(
    model: Model, blocks: Sequence[int | str], direction: Sequence[float], most: float
) -> Moves:
    """One variable for each block, which moves as a whole along a direction (3,)."""
    owner = _owners(model)
    unit = np.asarray(direction, dtype=np.float64)
    size = float(np.linalg.norm(unit))
    if not 0.0 < size < np.inf:
        raise InputError("the direction has no length", remedy="give three numbers, not all zero")
    columns = []
    for i in model.assembly.indices(list(blocks)).tolist():
        columns.append(((owner == i)[:, None] * unit / size).reshape(-1, 1))
    return Moves(sparse.csr_matrix(np.hstack(columns)), _largest(most, len(columns)))


def _largest(most: float, count: int) -> Floats:
    """The largest move of each variable (p,) [m]."""
    if not 0.0 < number(most, "the largest move") < np.inf:
        raise InputError(f"the largest move is {most} m", remedy="give metres above zero")
    return np.full(count, float(most))


def _owners(model: Model) -> Ints:
    counts = [len(block.vertices) for block in model.assembly.blocks]
    return np.repeat(np.arange(len(counts)), counts)


def _axis(name: str) -> int:
    if name not in AXES:
        raise InputError(f"there is no axis '{name}'", remedy="give x, y or z")
    return AXES[name]


def _flattened(vertex: Floats, along: str | None) -> Floats:
    """The vertices with the coordinate along an axis left out."""
    out = vertex.copy()
    if along is not None:
        out[:, _axis(along)] = 0.0
    return out


def _places(point: Floats, near: float) -> Ints:
    """A number (v,) for each place: points that are nearer than this have the same."""
    pairs = cKDTree(point).query_pairs(near, output_type="ndarray")
    links = sparse.coo_matrix(
        (np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(point),) * 2
    )
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.intp)


def _images(point: Floats, group: Ints, axis: int, near: float) -> tuple[Ints, Floats]:
    """The mirror image of each place, and the signs of its moves; zero off a plane it is on."""
    first = np.unique(group, return_index=True)[1]
    place = point[first]
    middle = 0.5 * (place[:, axis].min() + place[:, axis].max())
    other = place.copy()
    other[:, axis] = 2.0 * middle - other[:, axis]
    away = np.linalg.norm(place[:, None] - other[None], axis=2)
    image = away.argmin(axis=0)
    if away.min(axis=0).max() > 10.0 * near:
        raise InputError("the model is not its own mirror image", remedy="leave the mirror out")
    sign = np.ones((len(place), 3))
    sign[:, axis] = np.where(image == np.arange(len(place)), 0.0, -1.0)
    return image, sign


def _require_plane(model: Model, along: str | None) -> None:
    """Refuse where free vertices would bend a face: it is neither a triangle nor lies along."""
    if all(len(loop) == 3 for block in model.assembly.blocks for loop in block.faces):
        return
    if along is None:
        raise InputError(
            "faces with more than three corners would not stay plane",
            remedy="name an axis along which the blocks are prisms",
        )
    axis = _axis(along)
    for i in np.flatnonzero(~model.assembly.fixed):
        block = model.assembly.blocks[i]
        level = np.unique(np.round(block.vertices[:, axis] / (TOGETHER * block.size)))
        ends = _flattened(block.vertices, along)
        if len(np.unique(_places(ends, TOGETHER * block.size))) * 2 != len(ends) or len(level) != 2:
            raise InputError(
                f"is no prism along {along}: its faces would not stay plane",
                where=f"block '{block.name}'",
                remedy="keep it, or name another axis",
            )


__all__ = ["Moves", "block_moves", "free_vertices", "thickening"]
