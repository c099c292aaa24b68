"""Joints that stay plane and shared while vertices move.

The vertices of faces that touch in one plane stay in one plane. Three of them give the plane; the
distance of each other one from it is kept,

    c(u) = det(b - a, c - a, d - a) / area = c(0),    vertex = as given + S u,    u = x + N m.

The columns of N span the moves that would bend a joint, the rows of dc/du where u is zero. The
variables x are given, and m is solved for by Newton's method. With J = dc/du,

    du/dx = I - N (J N)^+ J.

What may move: groups of vertices, each along directions of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from scipy import sparse

from drystone.base.arrays import ROUNDING, SAME, Bools, Floats, Ints, cross, dot, marked, number
from drystone.base.display import OneLine, named
from drystone.base.errors import InputError
from drystone.base.ragged import linked
from drystone.design.corner_following import NEAR
from drystone.design.mends import kept_blocks
from drystone.design.vertex_places import (
    AXES,
    Places,
    axis_of,
    is_prism,
    on_side,
    owners_of,
    places_of,
    require_prisms,
    slides,
)
from drystone.geometry.frames import unit
from drystone.model import Model

_CLOSE = 1e-13
"""Distance from a plane, by the size of the model, at which it is reached: rounding."""

_TRIAL = 1e-3
"""Share of the largest moves with which it is tried whether joints stay plane, chosen."""

_STEPS = 30
"""Newton steps at most, chosen: they converge in 3 to 6 where they converge."""


@dataclass(frozen=True, eq=False)
class SharedPlanes(OneLine):
    """Planes of joints: vertices whose distances from planes through three other ones are kept.

    Attributes
    ----------
    corner : (r, 4)
        The three vertices that give the plane, and the one that keeps its distance.
    area : (r,) [m2]
        Twice that of the triangle, as given.
    """

    corner: Ints
    area: Floats

    @classmethod
    def of(cls, model: Model, still: Bools) -> SharedPlanes:
        """The joints of a model; those whose vertices (v,) all stay are left out."""
        point = model.assembly.faces.point
        place = places_of(point, SAME * float(np.ptp(point, axis=0).max()))
        rows: list[list[int]] = []
        for one in _plane_sets(model):
            if still[one].all():
                continue
            some = one[np.unique(place[one], return_index=True)[1]]
            if len(some) > 3:
                rows += _rows(point, some)
        corner = np.array(rows, dtype=np.intp).reshape(-1, 4)
        a, b, c = (point[corner[:, k]] for k in range(3))
        return cls(corner, np.linalg.norm(cross(b - a, c - a), axis=1))

    def distances(self, vertex: Floats) -> Floats:
        """Of the fourth vertices from the planes of the others (r,) [m]."""
        one, other, last = self._edges(vertex)
        return dot(cross(one, other), last) / self.area

    def slopes(self, vertex: Floats, matrix: sparse.csr_matrix) -> Floats:
        """Their derivative (r, p), where the vertices move with ``matrix`` (3 v, p)."""
        one, other, last = self._edges(vertex)
        by = np.stack([cross(other, last), cross(last, one), cross(one, other)], axis=1)
        by = np.concatenate([-by.sum(axis=1, keepdims=True), by], axis=1) / self.area[:, None, None]
        count = len(self.corner)
        row = np.repeat(np.arange(count), 12)
        column = (3 * self.corner[:, :, None] + np.arange(3)).ravel()
        slope = sparse.csr_matrix((by.ravel(), (row, column)), (count, matrix.shape[0]))
        return (slope @ matrix).toarray()

    def _edges(self, vertex: Floats) -> tuple[Floats, Floats, Floats]:
        a, b, c, d = (vertex[self.corner[:, k]] for k in range(4))
        return b - a, c - a, d - a


@dataclass(frozen=True, eq=False)
class Moves(OneLine):
    """The variables of a shape, whose joints stay plane and shared.

    Each variable moves vertices along directions of their own. Where that would bend a joint,
    vertices of the same joint follow as far as that takes. Faces without a joint may be warped.

    Attributes
    ----------
    matrix : (3 v, p)
        Moves of the vertices of all blocks by each variable, before joints are made plane [m].
    most : (p,) [m]
        Largest size of each variable.
    vertex : (v, 3) [m]
        Of the model as given.
    planes
        ``None`` where no move bends a joint.
    bending : (p, r)
        Orthonormal moves that would bend a joint, N.
    """

    matrix: sparse.csr_matrix
    most: Floats
    vertex: Floats
    planes: SharedPlanes | None = None
    bending: Floats | None = None

    @classmethod
    def of(
        cls, matrix: sparse.csr_matrix, most: float, vertex: Floats, planes: SharedPlanes | None
    ) -> Moves:
        """The moves, each of them at most so large, with those that would bend a joint found.

        Raises
        ------
        InputError
            The largest move is not above zero, or every move would bend a joint. Or joints stay
            plane for small moves only to the first order, as in rings of an even number of equal
            blocks.
        """
        if not 0.0 < number(most, "the largest move") < np.inf:
            raise InputError(f"the largest move is {most} m", remedy="give metres above zero")
        each = np.full(matrix.shape[1], float(most))
        if planes is None:
            return cls(matrix, each, vertex)
        slope = planes.slopes(vertex, matrix)
        size, way = np.linalg.svd(slope, full_matrices=False)[1:]
        bending = way[size > ROUNDING * size.max(initial=1.0)].T
        if not bending.shape[1]:
            return cls(matrix, each, vertex)
        if bending.shape[1] == len(each):
            raise InputError(
                "every move would bend a joint",
                remedy="keep fewer blocks, or allow more directions",
            )
        made = cls(matrix, each, vertex, planes, bending)
        some = np.random.default_rng(0).uniform(-1.0, 1.0, len(each))
        try:
            made.moved(vertex, _TRIAL * most * some)
        except InputError as error:
            raise InputError(
                "joints do not stay plane when vertices move freely",
                remedy="keep its symmetry: name its sectors, a mirror axis, or both",
            ) from error
        return made

    def _summary(self) -> str:
        kept = "" if self.bending is None else f", {self.bending.shape[1]} of which follow"
        return f"{self.count} variables of {len(self.vertex)} vertices{kept}"

    @property
    def count(self) -> int:
        """Number of variables, p."""
        return len(self.most)

    def moved(self, vertex: Floats, x: Floats) -> Floats:
        """The vertices (v, 3) with variables (p,).

        Raises
        ------
        InputError
            The moves are those of a model with other vertices, or no move of this size keeps the
            joints plane.
        """
        if vertex.shape != self.vertex.shape:
            raise InputError(
                f"the moves are of {len(self.vertex)} vertices, the model has {len(vertex)}",
                remedy="make the moves of this model",
            )
        return vertex + self._step(self._plane(x))

    def matrix_at(self, x: Floats) -> sparse.csr_matrix:
        """Derivative (3 v, p) of the vertices by the variables."""
        if self.planes is None or self.bending is None:
            return self.matrix
        slope = self.planes.slopes(self.vertex + self._step(self._plane(x)), self.matrix)
        follow = self.bending @ np.linalg.lstsq(slope @ self.bending, slope, rcond=ROUNDING)[0]
        return sparse.csr_matrix(self.matrix - sparse.csr_matrix(self.matrix @ follow))

    def _plane(self, x: Floats) -> Floats:
        """The moves u (p,) that keep joints plane, for variables (p,)."""
        moves = np.array(x, dtype=np.float64)
        if self.planes is None or self.bending is None:
            return moves
        goal = self.planes.distances(self.vertex)
        close = _CLOSE * float(np.ptp(self.vertex, axis=0).max())
        for _ in range(_STEPS):
            here = self.vertex + self._step(moves)
            off = self.planes.distances(here) - goal
            if float(np.abs(off).max(initial=0.0)) <= close:
                return moves
            slope = self.planes.slopes(here, self.matrix) @ self.bending
            moves = moves - self.bending @ np.linalg.lstsq(slope, off, rcond=ROUNDING)[0]
        raise InputError(
            "joints do not stay plane with moves of this size", remedy="allow smaller moves"
        )

    def _step(self, moves: Floats) -> Floats:
        return (self.matrix @ moves).reshape(-1, 3)


def _plane_sets(model: Model) -> Iterator[Ints]:
    """The vertices of faces that touch in one plane, for each such plane."""
    faces = model.assembly.faces
    loops = [faces.loop[rows] for rows in faces.corners]
    contacts, size = model.contacts, model.assembly.size
    links: list[tuple[int, int]] = []
    for k in np.flatnonzero(np.diff(contacts.start) > 2).tolist():
        normal, middle = contacts.frame[k, 0], contacts.centroid[k]
        touching = [
            j
            for i in (int(contacts.block_a[k]), int(contacts.block_b[k]))
            for j in np.flatnonzero(faces.owner == i).tolist()
            if abs(float(faces.normals[j] @ normal)) > 1.0 - SAME
            and np.abs((faces.point[loops[j]] - middle) @ normal).max() < NEAR * float(size[i])
        ]
        links += [(touching[0], j) for j in touching[1:]]
    pair = np.array(links, dtype=np.intp).reshape(-1, 2)
    label = linked(pair[:, 0], pair[:, 1], len(loops))
    for one in np.unique(label[pair]):
        yield np.unique(np.concatenate([loops[j] for j in np.flatnonzero(label == one)]))


def _rows(vertex: Floats, some: Ints) -> list[list[int]]:
    """Three vertices of some (w,) that are far apart, with each of the others."""
    point = vertex[some]
    first = int(np.argmax(np.linalg.norm(point - point.mean(axis=0), axis=1)))
    second = int(np.argmax(np.linalg.norm(point - point[first], axis=1)))
    along = point[second] - point[first]
    third = int(np.argmax(np.linalg.norm(np.cross(along, point - point[first]), axis=1)))
    base = [first, second, third]
    return [[*some[base].tolist(), int(some[j])] for j in range(len(some)) if j not in base]


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
    keep: str | Sequence[int | str] = (),
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
    kept = marked(list(kept_blocks(model, keep)), len(model))
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
    return Moves.of(matrix, most, model.assembly.faces.point, SharedPlanes.of(model, still))


def thickening(model: Model, middle: Sequence[float], most: float) -> Moves:
    """One variable: by how much an arch about a line along y through a point (3,) gets thicker [m].

    Vertices of free blocks that are farther from the line than the mean move outward by half of it,
    nearer ones inward; vertices of fixed blocks at the same places go with them.

    Parameters
    ----------
    model
        Is not changed.
    middle : (3,) [m]
        A point on the line; its y has no effect.
    most : [m]
        Largest size of the variable.

    Raises
    ------
    InputError
        A vertex is on the line.
    """
    vertex = model.assembly.faces.point
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
    """One variable for each block, which moves as a whole along a direction (3,).

    Parameters
    ----------
    model
        Is not changed.
    blocks
        Names or numbers of the blocks that move, p of them.
    direction : (3,)
        Of any length.
    most : [m]
        Largest size of each variable.
    """
    along = unit(np.asarray(direction, dtype=np.float64), "the direction")
    owner = owners_of(model.assembly)
    some = model.assembly.indices(list(blocks))
    matrix = ((owner[:, None] == some)[:, None, :] * along[:, None]).reshape(-1, len(some))
    return Moves.of(sparse.csr_matrix(matrix), most, model.assembly.faces.point, None)
