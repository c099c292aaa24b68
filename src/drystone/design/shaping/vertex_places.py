"""Places: vertices of several blocks at one point, which move together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.errors import InputError
from drystone.design.shaping.vertex_measures import vertices_of
from drystone.model import Model

TOGETHER = 1e-6
"""Vertices are at the same place when they are nearer than this share of the size of the model."""

OFF = 1e-6
"""A direction whose part within the mirror plane is below this share leads off the plane."""

AXES = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True, eq=False)
class Places:
    """The places of the vertices of a model, and their mirror images.

    Attributes
    ----------
    point : (g, 3) [m]
        Of each place, with the coordinate along the axis of the prisms left out.
    group : (v,)
        The place of each vertex.
    image : (g,)
        The mirror image of each place; itself without a mirror.
    sign : (g, 3)
        Of the moves of the image; zero off the mirror plane for places on it.
    """

    point: Floats
    group: Ints
    image: Ints
    sign: Floats

    @classmethod
    def of(cls, model: Model, along: str | None, mirror: str | None) -> Places:
        """The places of a model.

        Raises
        ------
        InputError
            An axis is unknown, or the model is not its own mirror image.
        """
        vertex = vertices_of(model.assembly)
        near = TOGETHER * float(np.ptp(vertex, axis=0).max())
        flat = flattened(vertex, along)
        group = places_of(flat, near)
        point = flat[np.unique(group, return_index=True)[1]]
        image, sign = np.arange(len(point)), np.ones((len(point), 3))
        if mirror is not None:
            image, sign = _images(point, axis_of(mirror), near)
        return cls(point, group, image, sign)

    @property
    def count(self) -> int:
        """Number of places, g."""
        return len(self.point)

    def matrix(self, ways: Sequence[Floats], still: Bools) -> sparse.csr_matrix:
        """Moves (3 v, p) of the vertices along ways (w, 3) of each place, but for those that stay.

        Parameters
        ----------
        ways
        still : (v,)
            A place stays where one of its vertices, or of those of its mirror image, stays.
        """
        stays = np.zeros(self.count, dtype=bool)
        stays[self.group[still]] = True
        stays |= stays[self.image]
        members = [np.flatnonzero(self.group == place) for place in range(self.count)]
        rows: list[Ints] = []
        values: list[Floats] = []
        for place in np.flatnonzero(~stays & (np.arange(self.count) <= self.image)).tolist():
            image, sign = int(self.image[place]), self.sign[place]
            for way in ways[place]:
                step = {place: way * sign} if image == place else {place: way, image: way * sign}
                size = float(np.linalg.norm(step[place]))
                if size < OFF:
                    continue  # on the mirror plane, and moving off it
                some = [(members[one], move / size) for one, move in step.items()]
                rows.append(np.concatenate([(3 * m[:, None] + np.arange(3)).ravel()
                                            for m, _ in some]))  # fmt: skip
                values.append(np.concatenate([np.tile(move, len(m)) for m, move in some]))
        shape = (3 * len(self.group), len(rows))
        if not rows:
            return sparse.csr_matrix(shape)
        column = np.repeat(np.arange(len(rows)), [len(one) for one in rows])
        made = sparse.csr_matrix((np.concatenate(values), (np.concatenate(rows), column)), shape)
        made.eliminate_zeros()
        return made


def axis_of(name: str) -> int:
    """The position of an axis.

    Raises
    ------
    InputError
        It is not x, y or z.
    """
    if name not in AXES:
        raise InputError(f"there is no axis '{name}'", remedy="give x, y or z")
    return AXES[name]


def flattened(vertex: Floats, along: str | None) -> Floats:
    """The vertices with the coordinate along an axis left out."""
    out = vertex.copy()
    if along is not None:
        out[:, axis_of(along)] = 0.0
    return out


def places_of(point: Floats, near: float) -> Ints:
    """A number (v,) for each place: points that are nearer than this have the same."""
    pairs = cKDTree(point).query_pairs(near, output_type="ndarray")
    links = sparse.coo_matrix(
        (np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(point),) * 2
    )
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.intp)


def require_plane(model: Model, along: str | None, kept: Bools) -> None:
    """Refuse where free vertices would bend a face of a block that is not among those kept (n,).

    Raises
    ------
    InputError
        A block has a face of more than three corners, and is no prism along the axis.
    """
    some = [model.assembly.blocks[i] for i in np.flatnonzero(~kept)]
    if all(len(loop) == 3 for block in some for loop in block.faces):
        return
    if along is None:
        raise InputError(
            "faces with more than three corners would not stay plane",
            remedy="name an axis along which the blocks are prisms",
        )
    axis = axis_of(along)
    for block in some:
        level = np.unique(np.round(block.vertices[:, axis] / (TOGETHER * block.size)))
        ends = places_of(flattened(block.vertices, along), TOGETHER * block.size)
        if len(np.unique(ends)) * 2 != len(ends) or len(level) != 2:
            raise InputError(
                f"is no prism along {along}: its faces would not stay plane",
                where=f"block '{block.name}'",
                remedy="keep it, or name another axis",
            )


def _images(place: Floats, axis: int, near: float) -> tuple[Ints, Floats]:
    """The mirror image of each place, and the signs of its moves; zero off a plane it is on."""
    middle = 0.5 * (place[:, axis].min() + place[:, axis].max())
    other = place.copy()
    other[:, axis] = 2.0 * middle - other[:, axis]
    away, image = map(np.asarray, cKDTree(other).query(place))
    if away.max() > 10.0 * near:
        raise InputError("the model is not its own mirror image", remedy="leave the mirror out")
    sign = np.ones((len(place), 3))
    sign[:, axis] = np.where(image == np.arange(len(place)), 0.0, -1.0)
    return np.asarray(image, dtype=np.intp), sign


__all__ = ["TOGETHER", "Places", "axis_of", "flattened", "places_of", "require_plane"]
