"""A patch through an open triangle or quadrilateral mesh, and its distance from the mesh.

Vaults from support to support through an open mesh: in plan they meet on the spine of its open
sides, one vault at each. Their courses are arches from one support to the next.

An open mesh with one border: its vertices merged, its border, and the mesh laid flat.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import shapely
from scipy import sparse
from scipy.sparse.linalg import spsolve

from drystone.base.arrays import SAME, Floats, dot, frozen_points, lengths, unit
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted, located
from drystone.base.ragged import Ragged
from drystone.geometry.coincidence import first_coincident
from drystone.geometry.frames import area_vectors, frames_from_normals
from drystone.geometry.polyhedron import edges_of, loop_edges, rings, used_vertices
from drystone.shells.patch import (
    Edge,
    Patch,
    Seam,
    Shape,
    Side,
    arc_lengths,
    at_lengths,
    check_patch,
)
from drystone.shells.sources import patch_from_grid
from drystone.shells.spine import Spine, SpineNode, spine_of

_NODES = 13
"""Points of each vault from its open side to the spine, and from one node of that to the next."""

_NAME_ENDS = "name the two ends of each support, two supports or more, along the border"

_UNDIVIDED = "its open sides do not face each other all along its supports"

_BEND = 0.5
"""Least turn of the border at a bend or a corner, by that of the sharpest corner. Chosen."""


def vaults_from_mesh(
    vertices: object,
    faces: Sequence[Sequence[int]],
    *,
    corners: Sequence[int] | None = None,
    name: str = "mesh",
) -> tuple[Shape, float]:
    """Vaults through an open mesh with one border, one at each open side.

    Parameters
    ----------
    vertices : (p, 3) [m]
    faces
        Loops of vertices.
    corners
        The two ends of each support, two supports or more, in their order along the border. When
        left out: the sides of the border that are lower than those before and after them.
    name
        Of the shape, as errors name it.

    Returns
    -------
    shape
    deviation : [m] largest distance of a vertex from it

    Raises
    ------
    InputError
        The mesh is closed or has several borders, its corners are not those of two supports or
        more, or it overhangs, seen along its mean normal.

    Notes
    -----
    In plan, seen along the mean normal of the mesh, the vaults meet on the spine of its open sides.
    Between the vertices the surface is a smooth interpolation.
    """
    from scipy.interpolate import CloughTocher2DInterpolator  # slow to import

    points = frozen_points(vertices, (None, 3), "vertices")
    points, loops, named = welded(points, faces, corners, name)
    border = border_of(loops, name)
    ends = named if named is not None else _support_ends(points, loops, border)
    if len(ends) < 4 or len(ends) % 2:
        raise InputError(
            f"its border has {len(ends)} ends of supports",
            where=f"mesh '{name}'",
            remedy=_NAME_ENDS,
        )
    if not along_border(border, ends, name):
        ends = ends[::-1]
    plan = _in_plan(points, loops, name)
    surface = CloughTocher2DInterpolator(plan, points)
    middle = plan.mean(axis=0)

    def lifted(place: Floats) -> Floats:
        return surface(middle + (1.0 - 1e-9) * (place - middle))  # inside the hull

    count = len(ends) // 2
    feet = [plan[side_between(border, ends[2 * k], ends[2 * k + 1])] for k in range(count)]
    runs = [side_between(border, ends[2 * k - 1], ends[2 * k]) for k in range(count)]
    sides = [plan[run] for run in runs[1:] + runs[:1]]  # each after the foot of its number
    sharp = _bends(points, loops, border)
    bends = [arc_lengths(plan[run])[1:-1][np.isin(run[1:-1], sharp)] for run in runs]
    bends = bends[1:] + bends[:1]
    spine = spine_of(plan[border], sides, bends)
    with located(f"mesh '{name}'", _NAME_ENDS):
        shape = _vaults(spine, sides, feet, lifted, name)
    return shape, _farthest(points, shape, name)


def _vaults(
    spine: Spine,
    sides: list[Floats],
    feet: list[Floats],
    lifted: Callable[[Floats], Floats],
    name: str,
) -> Shape:
    """A vault between each open side and the spine, in plan ruled from bend to bend."""
    count, patches = len(sides), []
    seams: dict[tuple[object, ...], list[Edge]] = {}
    for k, side in enumerate(sides):
        beside = spine.beside(k)
        nodes, length = [None, *beside, None], arc_lengths(side)
        cuts = [0.0, *(node.near[k] for node in beside), length[-1]]
        high, low = [], []
        for i, (start, end) in enumerate(itertools.pairwise(nodes)):
            other, line = _on_spine(spine, k, (start, end), feet)
            high.append(_evenly(line, lifted)[i > 0 :])
            own = length[(length > cuts[i]) & (length < cuts[i + 1])]
            part = at_lengths(side, np.array([cuts[i], *own, cuts[i + 1]]))
            low.append(_evenly(part, lifted)[i > 0 :])
            shares = i / (len(nodes) - 1), (i + 1) / (len(nodes) - 1)
            key = (k, other, id(start), id(end)) if k < other else (other, k, id(end), id(start))
            edge = Edge(k, Side.TOP, *(shares if k < other else shares[::-1]))
            seams.setdefault(key, []).append(edge)
        up = np.linspace(0.0, 1.0, _NODES)[:, None, None]
        grid = lifted((1.0 - up) * np.concatenate(low) + up * np.concatenate(high))
        breaks = [i * (_NODES - 1) for i in range(1, len(nodes) - 1)]
        patches.append(patch_from_grid(grid, breaks=breaks, name=f"vault {k} of {name}"))
    supports = tuple(Edge(k, side) for k in range(count) for side in (Side.LEFT, Side.RIGHT))
    return Shape(tuple(patches), _joined(seams.values()), supports, name=name)


def _joined(stretches: Iterable[list[Edge]]) -> tuple[Seam, ...]:
    """The seams of the stretches that lie on one line."""
    pairs = list(stretches)
    if any(len(pair) != 2 for pair in pairs):
        raise InputError(_UNDIVIDED)
    return tuple(Seam(*pair) for pair in pairs)


def _on_spine(
    spine: Spine, side: int, ends: tuple[SpineNode | None, SpineNode | None], feet: list[Floats]
) -> tuple[int, Floats]:
    """The open side across a line of the spine, and that line; an end that is None is on a foot."""
    start, end = ends
    before, after = (side - 1) % len(feet), (side + 1) % len(feet)
    if start is None or end is None:
        other = before if start is None else after
    else:
        other = next(iter(start.near.keys() & end.near.keys() - {side}), side)
    if not spine.has_line(side, other, start, end):
        raise InputError(_UNDIVIDED)
    line = spine.line(side, other, start, end)
    if start is None:
        line = np.concatenate([_nearest(feet[side], line[0])[None], line])
    if end is None:
        line = np.concatenate([line, _nearest(feet[after], line[-1])[None]])
    return other, line


def _nearest(line: Floats, point: Floats) -> Floats:
    """The nearest point to another of a polyline (p, 2)."""
    whole = shapely.LineString(line)
    return np.array(whole.interpolate(whole.project(shapely.Point(point))).coords[0])


def _evenly(line: Floats, lifted: Callable[[Floats], Floats]) -> Floats:
    """Places along a line in plan (p, 2), evenly on the surface."""
    length = arc_lengths(line)
    fine = at_lengths(line, np.linspace(0.0, length[-1], 8 * _NODES))
    raised = arc_lengths(lifted(fine))
    at = np.interp(np.linspace(0.0, raised[-1], _NODES), raised, arc_lengths(fine))
    return at_lengths(fine, at)


def _in_plan(points: Floats, loops: list[list[int]], name: str) -> Floats:
    """Places (p, 2) of the vertices, seen along the mean normal of the mesh."""
    corners = Ragged.of(loops)
    area = area_vectors(points[np.concatenate(loops)], corners.start)
    total = area.sum(axis=0)
    frame = frames_from_normals(unit(total[None])[0])[0]
    turned = np.flatnonzero(area @ frame[0] <= 0.0)
    if len(turned):
        raise InputError(
            f"it overhangs in {counted(len(turned), 'face')}, seen along its mean normal",
            where=f"mesh '{name}'",
            remedy="cut it into meshes with four corners, or give one that does not overhang",
        )
    return points @ frame[1:].T


def _farthest(points: Floats, shape: Shape, name: str) -> float:
    """Largest distance [m] of a vertex from the nearest patch of a shape."""
    from scipy.spatial import cKDTree  # slow to import

    at = np.linspace(0.0, 1.0, 8 * _NODES)
    u, v = (a.ravel() for a in np.meshgrid(at, at, indexing="ij"))
    nearest = np.full(len(points), np.inf)
    for patch in shape.patches:
        _, sample = cKDTree(patch.point(u, v)).query(points)
        found = distances(patch, np.column_stack([u[sample], v[sample], points]))
        nearest = np.minimum(nearest, found)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if (farthest := float(nearest.max())) > _FARTHEST_FIT * size:
        raise InputError(
            f"is up to {farthest:.3g} m from its vaults, more than {_FARTHEST_FIT:.0%} of its size",
            where=f"mesh '{name}'",
            remedy=f"{_NAME_ENDS}, or give a finer mesh",
        )
    return farthest


def several_supports(
    vertices: object, faces: Sequence[Sequence[int]], *, corners: Sequence[int] | None = None
) -> bool:
    """Whether a mesh stands on three supports or more, or on two with a bend between them.

    Parameters
    ----------
    vertices, faces, corners
        As of :func:`vaults_from_mesh`.

    Raises
    ------
    InputError
        The mesh is closed or has several borders.
    """
    points = frozen_points(vertices, (None, 3), "vertices")
    points, loops, named = welded(points, faces, corners, "mesh")
    border = border_of(loops, "mesh")
    ends = named if named is not None else _support_ends(points, loops, border)
    return len(ends) > 4 or (len(ends) == 4 and not {*_bends(points, loops, border)} <= {*ends})


def _bends(points: Floats, loops: list[list[int]], border: list[int]) -> list[int]:
    """The vertices at which the border turns sharply, outwards or inwards."""
    turn = turns_of(points, loops, border)
    least = max(_BEND * turn.max(), 2.0 * _CORNER_TURN)  # more than a round border of a few edges
    return [border[i] for i in np.flatnonzero(np.abs(turn) >= least).tolist()]


def _support_ends(points: Floats, loops: list[list[int]], border: list[int]) -> list[int]:
    """The ends of the supports, along the border: sides between outward turns, the lower ones.

    A support is lower than the sides before and after it, seen along the mean normal.
    """
    turn = turns_of(points, loops, border)
    ends = [border[i] for i in np.flatnonzero(turn >= _BEND * turn.max()).tolist()]
    pairs = list(zip(ends, [*ends[1:], *ends[:1]], strict=True))
    area = area_vectors(points[np.concatenate(loops)], Ragged.of(loops).start).sum(axis=0)
    up = unit(np.where(area[2] < 0.0, -1.0, 1.0) * area[None])[0][0]
    height = np.array([(points[side_between(border, *pair)] @ up).mean() for pair in pairs])
    lower = (height < np.roll(height, 1)) & (height < np.roll(height, -1))
    return [end for k in np.flatnonzero(lower).tolist() for end in pairs[k]]


_DEGREE = 3

_SMOOTHING = 1e-6
"""Weight of the second differences of the control points, relative to that of a mesh vertex.
Chosen: it has an effect only where there are too few vertices."""

_CORNER_TURN = 20.0
"""[degrees] Least angle of the border at a corner, when corners are searched. Chosen."""

_FARTHEST_FIT = 0.05
"""Largest distance of a mesh from its patch, relative to the size of the mesh. Chosen: beyond it
the corners are wrong, or the mesh is too coarse."""

_REMEDY = "give a finer mesh, name its corners, or use more control points"

_PROJECTED = 2_000
"""Number of mesh points, those farthest from the patch, for which the nearest point of the patch is
searched. Chosen: bounds the time on large meshes."""


@dataclass(frozen=True, eq=False)
class MeshFit(OneLine):
    """A patch, and the distance of the mesh from it.

    Attributes
    ----------
    patch
    deviation_max : [m]
        Largest distance of the mesh from the patch, at its vertices and the middles of its edges
        and faces.
    corners : (4, 3) [m] bottom left, bottom right, top right, top left
    """

    patch: Patch
    deviation_max: float
    corners: Floats


def patch_from_mesh(
    vertices: object,
    faces: Sequence[Sequence[int]],
    *,
    corners: Sequence[int] | None = None,
    control: tuple[int, int] = (10, 10),
    name: str = "mesh",
) -> MeshFit:
    """Fit a bicubic patch to an open mesh with one border.

    Parameters
    ----------
    vertices : (p, 3) [m]
    faces
        Loops of vertices.
    corners
        Four border vertices: bottom left, bottom right, top right, top left. When left out: the
        four sharpest turns of the border, with the lowest side as the bottom.
    control
        Control points along u and v.
    name
        Of the patch, as errors name it.

    Raises
    ------
    InputError
        The mesh is closed, has several borders or no four corners, or is farther from the patch
        than a twentieth of its size.

    Notes
    -----
    The mesh is mapped to the unit square. Every inner vertex lies at the mean of its neighbours,
    weighted by inverse length (source: Floater 1997). The patch is the least-squares B-spline
    through it.
    """
    points = frozen_points(vertices, (None, 3), "vertices")
    points, loops, named = welded(points, faces, corners, name)
    border = border_of(loops, name)
    chosen = named if named is not None else _sharpest(points, loops, border, name)
    if len(chosen) != 4:
        raise InputError(
            f"{len(chosen)} corners are named, a patch has four", where=f"mesh '{name}'",
            remedy="name four, or the two ends of each of three or more supports",
        )  # fmt: skip
    square = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])  # u, v of the corners
    u, v = np.clip(mapped(points, loops, border, chosen, square, name), 0.0, 1.0).T
    rows, columns = (max(_DEGREE + 1, int(c)) for c in control)
    control_points = _fit(points, u, v, rows, columns)
    patch = Patch(partial(_on_spline, control_points), name=name)
    at = np.column_stack([u, v, points])
    ends = edges_of([tuple(loop) for loop in loops])
    middles = np.array([at[loop].mean(axis=0) for loop in loops])
    farthest = float(distances(patch, np.concatenate([at, at[ends].mean(axis=1), middles])).max())
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if not farthest <= _FARTHEST_FIT * size:
        raise InputError(
            f"is up to {farthest:.3g} m from the patch fitted to it, more than "
            f"{_FARTHEST_FIT:.0%} of its size",
            where=f"mesh '{name}'",
            remedy=_REMEDY,
        )
    with located(f"mesh '{name}'", _REMEDY):
        check_patch(patch)
    return MeshFit(patch, farthest, points[chosen])


def _sharpest(points: Floats, loops: list[list[int]], border: list[int], name: str) -> list[int]:
    """Four corners by the turn of the border, the lowest side first."""
    turn = turns_of(points, loops, border)
    picked = np.sort(np.argsort(-turn, kind="stable")[:4])
    if len(picked) < 4 or turn[picked].min() < _CORNER_TURN:
        raise InputError(
            "its border has no four corners",
            where=f"mesh '{name}'",
            remedy="name four vertices of the border as corners",
        )
    heights = []
    for k in range(4):
        side = side_between(border, border[picked[k]], border[picked[(k + 1) % 4]])
        heights.append(float(points[side, 2].mean()))
    start = int(np.argmin(np.round(heights, 9)))
    return [border[picked[(start + k) % 4]] for k in range(4)]


def _basis(at: Floats, count: int) -> sparse.csr_matrix:
    """(k, count) values of the cubic B-splines on even knots in [0, 1]."""
    from scipy.interpolate import BSpline  # slow to import

    inner = np.linspace(0.0, 1.0, count - _DEGREE + 1)
    knots = np.concatenate([np.zeros(_DEGREE), inner, np.ones(_DEGREE)])
    return sparse.csr_matrix(BSpline.design_matrix(np.clip(at, 0.0, 1.0), knots, _DEGREE))


def _on_spline(control: Floats, u: Floats, v: Floats) -> Floats:
    """Points (k, 3) on the surface of control points (rows, columns, 3)."""
    by_u, by_v = (_basis(at, n).toarray() for at, n in zip((u, v), control.shape[:2], strict=True))
    return np.einsum("ki,kj,ijc->kc", by_u, by_v, control)


def _fit(points: Floats, u: Floats, v: Floats, rows: int, columns: int) -> Floats:
    """Control points (rows, columns, 3) of the least-squares surface."""
    by_u, by_v = _basis(u, rows), _basis(v, columns)
    design = sparse.csr_matrix(
        (by_u.toarray()[:, :, None] * by_v.toarray()[:, None, :]).reshape(len(u), -1)
    )
    bend_u = sparse.kron(_second(rows), sparse.eye(columns))
    bend_v = sparse.kron(sparse.eye(rows), _second(columns))
    system = design.T @ design + _SMOOTHING * (bend_u.T @ bend_u + bend_v.T @ bend_v)
    solution = spsolve(sparse.csc_matrix(system), design.T @ points)
    return np.asarray(solution).reshape(rows, columns, 3)


def _second(count: int) -> sparse.csr_matrix:
    return sparse.diags([1.0, -2.0, 1.0], [0, 1, 2], shape=(count - 2, count)).tocsr()


def distances(patch: Patch, sample: Floats) -> Floats:
    """Distance (k,) [m] of points from the patch.

    ``sample`` (k, 5) holds u, v near every point, and its position. A few Gauss-Newton steps
    correct the parameters to those of the nearest point of the patch.
    """
    distance: Floats = np.linalg.norm(patch.point(*sample[:, :2].T) - sample[:, 2:], axis=1)
    worst = np.argsort(-distance, kind="stable")[:_PROJECTED]
    uv, place = sample[worst, :2].copy(), sample[worst, 2:]
    for _ in range(4):
        tangent = np.stack(patch.tangents(*uv.T), axis=1)
        off = np.einsum("kai,ki->ka", tangent, place - patch.point(*uv.T))
        gram = np.einsum("kai,kbi->kab", tangent, tangent)
        determinant = gram[:, 0, 0] * gram[:, 1, 1] - gram[:, 0, 1] ** 2
        safe = np.where(determinant > 0.0, determinant, np.inf)
        step_u = (gram[:, 1, 1] * off[:, 0] - gram[:, 0, 1] * off[:, 1]) / safe
        step_v = (gram[:, 0, 0] * off[:, 1] - gram[:, 0, 1] * off[:, 0]) / safe
        uv = np.clip(uv + np.stack([step_u, step_v], axis=1), 0.0, 1.0)
        nearer = np.linalg.norm(patch.point(*uv.T) - place, axis=1)
        distance[worst] = np.minimum(distance[worst], nearer)
    return distance


def welded(
    points: Floats, faces: Sequence[Sequence[int]], corners: Sequence[int] | None, name: str
) -> tuple[Floats, list[list[int]], list[int] | None]:
    """Used vertices, coincident ones merged; the faces and the named corners among them."""
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    first = first_coincident(points, SAME * size)
    loops = [list(dict.fromkeys(int(first[i]) for i in face)) for face in faces]
    used, made = used_vertices(loop for loop in loops if len(loop) > 2)
    new = dict(zip(used, range(len(used)), strict=True))
    named = None
    if corners is not None:
        unknown = [c for c in corners if not 0 <= int(c) < len(points) or first[c] not in new]
        wrong = [f"{c} is no vertex of its faces" for c in unknown]
        wrong += [f"{c} is named twice" for c in corners if list(corners).count(c) > 1]
        if wrong:
            remedy = f"give different numbers of vertices, from 0 to {len(points) - 1}"
            raise InputError(wrong[0], where=f"corners of mesh '{name}'", remedy=remedy)
        named = [new[int(first[c])] for c in corners]
    return points[used], [list(loop) for loop in made], named


def border_of(loops: list[list[int]], name: str) -> list[int]:
    """The border's vertices in order, the mesh on their left."""
    after: dict[int, int] = {}
    runs = [edge for loop in loops for edge in loop_edges(loop)]
    edges = set(runs)
    if len(edges) < len(runs):
        raise InputError(
            "neighbouring faces have opposite normals, or three meet at an edge",
            where=f"mesh '{name}'",
            remedy="orient its faces consistently, and leave one surface",
        )
    for a, b in edges:
        if (b, a) not in edges:
            if a in after:
                raise InputError("its border touches itself", where=f"mesh '{name}'")
            after[a] = b
    if not after:
        raise InputError(
            "the mesh is closed",
            where=f"mesh '{name}'",
            remedy="of a vault with a thickness delete all faces but those of one side",
        )
    run, *more = rings(after)
    if more:
        raise InputError(
            "the mesh has several borders: it has a hole, or it is closed to a ring like a dome",
            where=f"mesh '{name}'",
            remedy="close its holes; for a ring use patch_from_grid with closed=True, or cut the "
            "mesh open from border to border",
        )
    first = run.index(min(run))
    return [*run[first:], *run[:first]]


def turns_of(points: Floats, loops: list[list[int]], border: list[int]) -> Floats:
    """Turn (b,) [degrees] of the border at each of its vertices, in the surface; inwards below 0.

    It is 180 degrees less the angles of the faces there.
    """
    angle = np.zeros(len(points))
    for loop in loops:
        run = points[loop]
        after, before = np.roll(run, -1, axis=0) - run, np.roll(run, 1, axis=0) - run
        cosine = dot(after, before) / (lengths(after) * lengths(before))
        angle[loop] += np.arccos(np.clip(cosine, -1.0, 1.0))
    return 180.0 - np.rad2deg(angle[border])


def side_between(border: list[int], start: int, end: int) -> list[int]:
    """The border from one vertex to another."""
    i = border.index(start)
    turned = border[i:] + border[:i]
    return turned[: turned.index(end) + 1]


def mapped(
    points: Floats,
    loops: list[list[int]],
    border: list[int],
    corners: list[int],
    polygon: Floats,
    name: str,
) -> Floats:
    """Place (p, 2) of every vertex in a convex polygon (k, 2) whose corners are some of the border.

    Every inner vertex lies at the mean of its neighbours, weighted by inverse length. Source:
    Floater 1997.
    """
    if not along_border(border, corners, name):
        corners, polygon = [corners[0], *corners[:0:-1]], np.roll(polygon[::-1], 1, axis=0)
    place = np.full((len(points), 2), np.nan)
    for k in range(len(corners)):
        after = (k + 1) % len(corners)
        side = side_between(border, corners[k], corners[after])
        share = arc_lengths(points[side])
        place[side] = polygon[k] + share[:, None] / share[-1] * (polygon[after] - polygon[k])
    ends = edges_of([tuple(loop) for loop in loops])
    weight = 1.0 / np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    shape = (len(points), len(points))
    joined = sparse.coo_matrix((weight, (ends[:, 0], ends[:, 1])), shape).tocsr()
    joined = joined + joined.T
    stiffness = (sparse.diags(np.asarray(joined.sum(axis=1)).ravel()) - joined).tocsc()
    known = ~np.isnan(place[:, 0])
    inner = np.flatnonzero(~known)
    if len(inner):
        pull = -(stiffness[inner][:, np.flatnonzero(known)] @ place[known])
        place[inner] = spsolve(stiffness[inner][:, inner], pull).reshape(-1, 2)
    return place


def along_border(border: list[int], corners: list[int], name: str) -> bool:
    """Whether corners follow each other along the border, rather than against it."""
    where = f"corners of mesh '{name}'"
    inside = [k for k, corner in enumerate(corners, 1) if corner not in border]
    if inside:
        raise InputError(
            f"number {inside[0]} of {len(corners)} is not on the border", where=where,
            remedy="name vertices of the border",
        )  # fmt: skip
    order = [border.index(c) for c in corners]
    if not (_cyclic(order) or _cyclic(order[::-1])):
        raise InputError(
            "they do not follow each other", where=where,
            remedy="name them in their order along the border",
        )  # fmt: skip
    return _cyclic(order)


def _cyclic(order: list[int]) -> bool:
    """Whether positions ascend cyclically."""
    start = int(np.argmin(order))
    turned = order[start:] + order[:start]
    return turned == sorted(turned)
