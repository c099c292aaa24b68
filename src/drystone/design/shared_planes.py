"""Joints that stay plane and shared while vertices move.

The vertices of faces that touch in one plane stay in one plane. Three of them give the plane; the
distance of each other one from it is kept,

    c(u) = det(b - a, c - a, d - a) / area = c(0),    vertex = as given + S u,    u = x + N m.

The columns of N span the moves that would bend a joint, the rows of dc/du where u is zero. The
variables x are given, and m is solved for by Newton's method. With J = dc/du,

    du/dx = I - N (J N)^+ J.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from drystone.base.arrays import ROUNDING, SAME, Bools, Floats, Ints, cross, dot, number
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.design.corner_following import NEAR
from drystone.design.vertex_measures import BlockVertices
from drystone.design.vertex_places import places_of
from drystone.geometry.polygon import area_vector
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

    def _summary(self) -> str:
        return f"{len(self.corner)} distances"

    @classmethod
    def of(cls, model: Model, still: Bools) -> SharedPlanes:
        """The joints of a model; those whose vertices (v,) all stay are left out."""
        bodies = BlockVertices.of(model.assembly)
        place = places_of(bodies.vertex, SAME * float(np.ptp(bodies.vertex, axis=0).max()))
        rows: list[list[int]] = []
        for one in _plane_sets(model, bodies):
            if still[one].all():
                continue
            some = one[np.unique(place[one], return_index=True)[1]]
            if len(some) > 3:
                rows += _rows(bodies.vertex, some)
        corner = np.array(rows, dtype=np.intp).reshape(-1, 4)
        a, b, c = (bodies.vertex[corner[:, k]] for k in range(3))
        return cls(corner, np.linalg.norm(cross(b - a, c - a), axis=1))

    def distances(self, vertex: Floats) -> Floats:
        """Of the fourth vertices from the planes of the others (r,) [m]."""
        one, other, last = self._edges(vertex)
        out: Floats = dot(cross(one, other), last) / self.area
        return out

    def slopes(self, vertex: Floats, matrix: sparse.csr_matrix) -> Floats:
        """Their derivative (r, p), where the vertices move with ``matrix`` (3 v, p)."""
        one, other, last = self._edges(vertex)
        by = np.stack([cross(other, last), cross(last, one), cross(one, other)], axis=1)
        by = np.concatenate([-by.sum(axis=1, keepdims=True), by], axis=1) / self.area[:, None, None]
        count = len(self.corner)
        row = np.repeat(np.arange(count), 12)
        column = (3 * self.corner[:, :, None] + np.arange(3)).ravel()
        slope = sparse.csr_matrix((by.ravel(), (row, column)), (count, matrix.shape[0]))
        out: Floats = (slope @ matrix).toarray()
        return out

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
        out: Floats = (self.matrix @ moves).reshape(-1, 3)
        return out


def _plane_sets(model: Model, bodies: BlockVertices) -> Iterator[Ints]:
    """The vertices of faces that touch in one plane, for each such plane."""
    loops: list[Ints] = []
    of_block: list[range] = []
    normals: list[Floats] = []
    for i, block in enumerate(model.assembly.blocks):
        first = len(loops)
        for loop in block.faces:
            corner = block.vertices[list(loop)]
            area = area_vector(corner)
            loops.append(int(bodies.start[i]) + np.array(loop, dtype=np.intp))
            normals.append(area / np.linalg.norm(area))
        of_block.append(range(first, len(loops)))
    contacts, size = model.contacts, model.assembly.size
    links: list[tuple[int, int]] = []
    for k in np.flatnonzero(np.diff(contacts.start) > 2).tolist():
        normal, middle = contacts.frame[k, 0], contacts.centroid[k]
        touching = [
            j
            for i in (int(contacts.block_a[k]), int(contacts.block_b[k]))
            for j in of_block[i]
            if abs(float(normals[j] @ normal)) > 1.0 - SAME
            and np.abs((bodies.vertex[loops[j]] - middle) @ normal).max() < NEAR * float(size[i])
        ]
        links += [(touching[0], j) for j in touching[1:]]
    pair = np.array(links, dtype=np.intp).reshape(-1, 2)
    graph = sparse.coo_matrix(
        (np.ones(len(pair)), (pair[:, 0], pair[:, 1])), shape=(len(loops),) * 2
    )
    label = connected_components(graph, directed=False)[1]
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
