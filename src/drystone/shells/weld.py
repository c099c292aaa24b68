"""Patterns of several patches merged into one cell complex in space."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import InputError
from drystone.geometry.polyhedron import loop_edges, rings
from drystone.shells.patch import Edge, Seam, Shape, Side, arc_lengths
from drystone.shells.pattern import Pattern, Tessellation

_SNAP = 0.15
"""Joints from the two sides of a seam are merged when they are closer than this share of the
shorter neighbouring stretch. Chosen: below the least lap within a patch."""


class _Weld:
    """Working state: all patterns, their borders, and the merged vertex of each vertex."""

    def __init__(self, shape: Shape, patterns: Sequence[Pattern]) -> None:
        self.shape = shape
        self.offset = np.cumsum([0, *(len(p.uv) for p in patterns)])
        self.site: list[list[tuple[int, float, float]]] = [
            [(k, *row)] for k, p in enumerate(patterns) for row in p.uv.tolist()
        ]
        self.cells = [
            [i + int(self.offset[k]) for i in cell]
            for k, p in enumerate(patterns)
            for cell in p.cells
        ]
        self.border: dict[tuple[int, Side], list[tuple[float, int]]] = {
            (k, side): [(float(a), int(i + self.offset[k])) for i, a in zip(on, along, strict=True)]
            for k, p in enumerate(patterns)
            for side, (on, along) in p.borders.items()
        }
        self.parent = list(range(int(self.offset[-1])))
        self.cell_of = {edge: c for c, cell in enumerate(self.cells) for edge in loop_edges(cell)}

    def root(self, i: int) -> int:
        """The vertex with which vertex ``i`` was merged."""
        while self.parent[i] != i:
            i = self.parent[i]
        return i

    def insert(self, key: tuple[int, Side], along: float, vertex: int) -> None:
        """Insert ``vertex`` into the border and into the cell there."""
        run = self.border[key]
        place = next((n for n, (a, _) in enumerate(run) if a > along), len(run))
        low, high = run[max(place - 1, 0)][1], run[min(place, len(run) - 1)][1]
        run.insert(place, (along, vertex))
        for a, b in ((low, high), (high, low)):
            cell = self.cell_of.pop((a, b), None)
            if cell is not None:
                loop = self.cells[cell]
                loop.insert(loop.index(a) + 1, vertex)
                self.cell_of[a, vertex] = self.cell_of[vertex, b] = cell
                return

    def stretch(self, edge: Edge) -> list[tuple[float, int]]:
        """Border vertices within a stretch, from its start to its end."""
        run = self.border[edge.patch, edge.side]
        inside = [(a, i) for a, i in run if edge.low - 1e-9 <= a <= edge.high + 1e-9]
        return inside if edge.start <= edge.end else inside[::-1]

    def end_at(self, edge: Edge, along: float) -> None:
        """Insert a vertex at one end of a stretch if there is none."""
        run = self.border[edge.patch, edge.side]
        spacing = np.diff([a for a, _ in run])
        gaps = np.abs(np.array([a for a, _ in run]) - along)
        n = int(np.argmin(gaps))
        if gaps[n] <= _SNAP * spacing[max(n - 1, 0) : n + 1].min() and 0.0 < along < 1.0:
            vertex = run[n][1]
            run[n] = (along, vertex)
            self._place(vertex, edge, along)
        elif gaps[n] > 1e-9:
            vertex = len(self.site)
            self.site.append([])
            self.parent.append(vertex)
            self._place(vertex, edge, along)
            self.insert((edge.patch, edge.side), along, vertex)

    def _place(self, vertex: int, edge: Edge, along: float) -> None:
        u, v = edge.side.parameters(np.array([along]))
        self.site[vertex] = [(edge.patch, float(u[0]), float(v[0]))]


def weld(shape: Shape, patterns: Sequence[Pattern]) -> Tessellation:
    """One cell complex from the patterns of the patches.

    Every joint that ends at a seam becomes a corner of the blocks on both sides. Joints that nearly
    meet are merged.

    Parameters
    ----------
    shape
    patterns
        One per patch.
    """
    state = _Weld(shape, patterns)
    for seam in shape.seams:
        for edge in (seam.one, seam.other):
            for along in (edge.start, edge.end):
                state.end_at(edge, along)
    for edge in (*shape.supports, *shape.keystone):
        for along in (edge.start, edge.end):
            if not shape.patches[edge.patch].closed:
                state.end_at(edge, along)
    for seam in shape.seams:
        _join(state, seam)
    return _assemble(state, patterns)


def _join(state: _Weld, seam: Seam) -> None:
    one, other = state.stretch(seam.one), state.stretch(seam.other)
    to_share = [_arc_length(state.shape, edge) for edge in (seam.one, seam.other)]
    share_one = np.interp([a for a, _ in one], *_ascending(*to_share[0]))
    share_other = np.interp([a for a, _ in other], *_ascending(*to_share[1]))
    gap = np.abs(share_one[:, None] - share_other[None])
    nearest_one, nearest_other = gap.argmin(axis=1), gap.argmin(axis=0)
    limit_one, limit_other = _spacing(share_one), _spacing(share_other)
    met_other = set()
    for i, (_, vertex) in enumerate(one):
        j = int(nearest_one[i])
        limit = _SNAP * min(limit_one[i], limit_other[j])
        if nearest_other[j] == i and gap[i, j] <= max(limit, 1e-9):
            met_other.add(j)
            _unite(state, vertex, other[j][1])
        else:
            along = float(np.interp(share_one[i], to_share[1][1], to_share[1][0]))
            _share(state, vertex, seam.other, along)
    for j, (_, vertex) in enumerate(other):
        if j not in met_other:
            along = float(np.interp(share_other[j], to_share[0][1], to_share[0][0]))
            _share(state, vertex, seam.one, along)


def _unite(state: _Weld, keep: int, drop: int) -> None:
    keep, drop = state.root(keep), state.root(drop)
    if keep != drop:
        state.parent[drop] = keep
        state.site[keep] = state.site[keep] + state.site[drop]


def _share(state: _Weld, vertex: int, edge: Edge, along: float) -> None:
    u, v = edge.side.parameters(np.array([along]))
    root = state.root(vertex)
    state.site[root] = [*state.site[root], (edge.patch, float(u[0]), float(v[0]))]
    state.insert((edge.patch, edge.side), along, vertex)


def _arc_length(shape: Shape, edge: Edge) -> tuple[Floats, Floats]:
    """Positions along the side and the share of the stretch's length there."""
    length = arc_lengths(shape.points_along(edge, 513))
    return np.linspace(edge.start, edge.end, 513), length / length[-1]


def _ascending(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    return (x, y) if x[0] <= x[-1] else (x[::-1], y[::-1])


def _spacing(share: Floats) -> Floats:
    """Distance to the nearer neighbour along the seam."""
    if len(share) < 2:
        return np.ones(len(share))
    step = np.abs(np.diff(share))
    return np.minimum(np.append(step, step[-1]), np.append(step[0], step))


def _assemble(state: _Weld, patterns: Sequence[Pattern]) -> Tessellation:
    shape = state.shape
    roots = [state.root(i) for i in range(len(state.parent))]
    used = sorted(set(roots))
    new = {old: i for i, old in enumerate(used)}
    renumber = np.array([new[r] for r in roots], dtype=np.intp)
    sites = [(i, *site) for i, old in enumerate(used) for site in dict.fromkeys(state.site[old])]
    table = np.array(sites, dtype=np.float64).reshape(-1, 4)
    vertex = table[:, 0].astype(np.intp)
    point, normal, up = _in_space(shape, vertex, table[:, 1:])
    inner = np.zeros(len(used), dtype=bool)
    for k, pattern in enumerate(patterns):
        at = renumber[np.flatnonzero(pattern.inner) + state.offset[k]]
        inner[at] = np.bincount(vertex, minlength=len(used))[at] == 1
    cells = tuple(tuple(dict.fromkeys(renumber[cell].tolist())) for cell in state.cells)
    heads = frozenset(
        (min(a, b), max(a, b))
        for k, pattern in enumerate(patterns)
        for a, b in renumber[pattern.heads + state.offset[k]].tolist()
    )
    of_patch = np.concatenate([np.full(len(p.cells), k) for k, p in enumerate(patterns)])
    prefix = [f"p{k}-" if len(patterns) > 1 else "" for k in range(len(patterns))]
    return _with_keystone(
        state,
        renumber,
        Tessellation(
            point=point,
            normal=normal,
            up=up,
            inner=inner,
            cells=cells,
            names=tuple(prefix[k] + name for k, p in enumerate(patterns) for name in p.names),
            course=np.concatenate([p.course for p in patterns]),
            position=np.concatenate([p.position for p in patterns]),
            of_patch=of_patch.astype(np.intp),
            crest=np.concatenate(
                [
                    surface.point(pattern.centre[:, 0], pattern.centre[:, 1])
                    for surface, pattern in zip(shape.patches, patterns, strict=True)
                ]
            ),
            heads=heads,
            supported=_edges_on(state, renumber, shape.supports, cells),
        ),
    )


def _in_space(shape: Shape, vertex: Ints, site: Floats) -> tuple[Floats, Floats, Floats]:
    """Points, normals and upward tangents (v, 3) of vertices.

    Parameters
    ----------
    shape
    vertex : (s,)
        Ascending; a vertex on a seam has several sites.
    site : (s, 3)
        Patch, u and v.
    """
    each = np.empty((3, len(vertex), 3))
    for k, surface in enumerate(shape.patches):
        here = site[:, 0] == k
        u, v = site[here, 1], site[here, 2]
        each[:, here] = surface.point(u, v), surface.normal(u, v), surface.tangents(u, v)[0]
    _, first = np.unique(vertex, return_index=True)
    normal, up = np.add.reduceat(each[1], first), each[2, first]
    return (
        each[0, first],
        normal / np.linalg.norm(normal, axis=1, keepdims=True),
        up / np.linalg.norm(up, axis=1, keepdims=True),
    )


def _edges_on(
    state: _Weld, renumber: Ints, edges: Sequence[Edge], cells: Sequence[Sequence[int]]
) -> tuple[tuple[int, int], ...]:
    """Edges of cells along stretches of border, directed as in their cells."""
    wanted: set[frozenset[int]] = set()
    for edge in edges:
        run = [int(renumber[i]) for _, i in state.stretch(edge)]
        if state.shape.patches[edge.patch].closed and edge.high - edge.low >= 1.0:
            run.append(run[0])
        wanted |= {frozenset(pair) for pair in itertools.pairwise(run)}
    return tuple(e for cell in cells for e in loop_edges(cell) if frozenset(e) in wanted)


def _with_keystone(state: _Weld, renumber: Ints, mesh: Tessellation) -> Tessellation:
    """The mesh with a cell that closes the opening, where the shape has a keystone."""
    if not state.shape.keystone:
        return mesh
    around = _edges_on(state, renumber, state.shape.keystone, mesh.cells)
    after = {b: a for a, b in around}
    loop, *more = rings(after)
    if more or len(after) != len(around) or after.get(loop[-1]) != loop[0]:
        raise InputError(
            "the border that a keystone should close is not one ring",
            where=f"shape '{state.shape.name}'",
            remedy="name stretches that follow each other all around the opening",
        )
    last = int(mesh.course.max()) + 1
    return replace(
        mesh,
        cells=(*mesh.cells, tuple(loop)),
        names=(*mesh.names, "keystone"),
        course=np.append(mesh.course, last),
        position=np.append(mesh.position, 0),
        of_patch=np.append(mesh.of_patch, -1),
        crest=np.concatenate([mesh.crest, np.full((1, 3), np.nan)]),
    )
