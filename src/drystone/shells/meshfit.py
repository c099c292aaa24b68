"""A patch through an open triangle or quadrilateral mesh, and its distance from the mesh.

Vaults from support to support through an open mesh that stands on three or more: the mesh is mapped
to a regular polygon whose sides are its supports and its open sides in turn. Lines from the middle
of each support to the middle of the polygon divide it into vaults, one at each open side. Their
courses are arches from one support to the next.

An open mesh with one border: its vertices merged, its border, and the mesh laid flat.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline, CloughTocher2DInterpolator
from scipy.sparse.linalg import spsolve

from drystone.base.arrays import SAME, Floats, dot, frozen_points
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.geometry.coincidence import first_coincident
from drystone.geometry.polyhedron import edges_of, loop_edges, rings
from drystone.shells.formfinding import find_form
from drystone.shells.patch import Edge, Patch, Shape, Side, arc_lengths, check_patch
from drystone.shells.shell_families import vaults_between
from drystone.shells.sources import patch_from_grid

_NODES = 25
"""Points along u and v of each vault, as of a form that is found."""


def vaults_from_mesh(
    vertices: object,
    faces: Sequence[Sequence[int]],
    *,
    corners: Sequence[int] | None = None,
    name: str = "mesh",
) -> Shape:
    """Vaults through an open mesh with one border, one at each open side.

    Parameters
    ----------
    vertices : (p, 3) [m]
    faces
        Loops of vertices.
    corners
        The two ends of each support, three supports or more, in their order along the border. When
        left out: the turns of the border, of which the lower sides are the supports.
    name

    Raises
    ------
    InputError
        The mesh is closed or has several borders, or its corners are not those of three supports
        or more.

    Notes
    -----
    Every inner vertex lies at the mean of its neighbours, weighted by inverse length (source:
    Floater 1997). Between the vertices the surface is a smooth interpolation.
    """
    points = frozen_points(vertices, (None, 3), "vertices")
    points, loops, named = welded(points, faces, corners, name)
    border = border_of(loops, name)
    chosen = named if named is not None else _support_ends(points, loops, border)
    if len(chosen) < 6 or len(chosen) % 2:
        raise InputError(
            f"its border has {len(chosen)} corners",
            where=f"mesh '{name}'",
            remedy="name the two ends of each support, three supports or more, along the border",
        )
    angle = 2.0 * np.pi * np.arange(len(chosen)) / len(chosen)
    polygon = np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)
    place = mapped(points, loops, border, chosen, polygon[:, :2], name)
    surface = CloughTocher2DInterpolator(place, points)
    open_sides = 0.5 * (polygon[1::2] + np.roll(polygon[0::2], -1, axis=0))
    plan = vaults_between(polygon.reshape(-1, 2, 3), open_sides, name="vaults")
    borders = [Edge(k, Side.BOTTOM) for k in range(len(plan.patches))]
    held = plan.supported_on(*plan.supports, *borders)  # a net over it has smooth lines
    flat = find_form(held, height=1.0, rows=_NODES, columns=_NODES).shape
    share = np.linspace(0.0, 1.0, _NODES)
    patches = []
    for k, vault in enumerate(flat.patches):
        inside = (1.0 - 1e-9) * vault.point(share[:, None], share[None, :])[..., :2]  # of the hull
        grid = surface(inside.reshape(-1, 2)).reshape(_NODES, _NODES, 3)
        patches.append(patch_from_grid(grid, breaks=[_NODES // 2], name=f"vault {k} of {name}"))
    return Shape(tuple(patches), plan.seams, plan.supports, name=name)


def several_supports(vertices: object, faces: Sequence[Sequence[int]]) -> bool:
    """Whether the border of a mesh turns outwards as sharply at six corners or more.

    Raises
    ------
    InputError
        The mesh is closed or has several borders.
    """
    points, loops, _ = welded(frozen_points(vertices, (None, 3), "vertices"), faces, None, "mesh")
    return bool(_support_ends(points, loops, border_of(loops, "surface")))


def _support_ends(points: Floats, loops: list[list[int]], border: list[int]) -> list[int]:
    """The ends of the supports, along the border; none where these are not three or more.

    Corners are the outward turns at least half as sharp as the sharpest one: an open side may turn
    inwards between two legs. Of the sides between the corners every other one is a support, the
    lower ones.
    """
    turn = turns_of(points, border) * _outward(points, loops, border)
    ends = [border[i] for i in np.flatnonzero(turn >= 0.5 * turn.max()).tolist()]
    if len(ends) < 6 or len(ends) % 2:
        return []
    heights = [
        float(points[side_between(border, one, other), 2].mean())
        for one, other in zip(ends, [*ends[1:], ends[0]], strict=True)
    ]
    return ends if sum(heights[0::2]) <= sum(heights[1::2]) else [*ends[1:], ends[0]]


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
    deviation_max, deviation_rms : [m]
        Distance of the mesh from the patch, at its vertices and the middles of its edges and faces.
    deviation_vertices : [m] largest distance of a vertex
    corners : (4, 3) [m] bottom left, bottom right, top right, top left
    """

    patch: Patch
    deviation_max: float
    deviation_rms: float
    deviation_vertices: float
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
    chosen = named if named is not None else _sharpest(points, border, name)
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
    distance = distances(patch, np.column_stack([u, v, points]), loops)
    farthest = float(distance.max())
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if not farthest <= _FARTHEST_FIT * size:
        raise InputError(
            f"is up to {farthest:.3g} m from the patch fitted to it, more than "
            f"{_FARTHEST_FIT:.0%} of its size",
            where=f"mesh '{name}'",
            remedy=_REMEDY,
        )
    try:
        check_patch(patch)
    except InputError as error:
        raise error.located(f"mesh '{name}'", _REMEDY) from error
    return MeshFit(
        patch,
        farthest,
        float(np.sqrt((distance**2).mean())),
        float(distance[: len(points)].max()),
        points[chosen],
    )


def _sharpest(points: Floats, border: list[int], name: str) -> list[int]:
    """Four corners by the turn of the border, the lowest side first."""
    turn = turns_of(points, border)
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
    inner = np.linspace(0.0, 1.0, count - _DEGREE + 1)
    knots = np.concatenate([np.zeros(_DEGREE), inner, np.ones(_DEGREE)])
    return sparse.csr_matrix(BSpline.design_matrix(np.clip(at, 0.0, 1.0), knots, _DEGREE))


def _on_spline(control: Floats, u: Floats, v: Floats) -> Floats:
    """Points (k, 3) on the surface of control points (rows, columns, 3)."""
    by_u, by_v = (_basis(at, n).toarray() for at, n in zip((u, v), control.shape[:2], strict=True))
    points: Floats = np.einsum("ki,kj,ijc->kc", by_u, by_v, control)
    return points


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
    control: Floats = np.asarray(solution).reshape(rows, columns, 3)
    return control


def _second(count: int) -> sparse.csr_matrix:
    return sparse.diags([1.0, -2.0, 1.0], [0, 1, 2], shape=(count - 2, count)).tocsr()


def distances(patch: Patch, at: Floats, loops: Sequence[Sequence[int]]) -> Floats:
    """Distance (k,) [m] from the patch of the vertices, then of the middles of edges and faces.

    ``at`` (p, 5) holds u, v and the position of every vertex. A few Gauss-Newton steps correct the
    parameters to those of the nearest point of the patch.
    """
    ends = edges_of([tuple(loop) for loop in loops])
    middles = np.array([at[list(loop)].mean(axis=0) for loop in loops])
    sample = np.concatenate([at, 0.5 * (at[ends[:, 0]] + at[ends[:, 1]]), middles])
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
    loops = [loop for loop in loops if len(loop) > 2]
    used = sorted({i for loop in loops for i in loop})
    new = {old: i for i, old in enumerate(used)}
    named = None
    if corners is not None:
        unknown = [c for c in corners if not 0 <= int(c) < len(points) or first[c] not in new]
        wrong = [f"{c} is no vertex of its faces" for c in unknown]
        wrong += [f"{c} is named twice" for c in corners if list(corners).count(c) > 1]
        if wrong:
            remedy = f"give different numbers of vertices, from 0 to {len(points) - 1}"
            raise InputError(wrong[0], where=f"corners of mesh '{name}'", remedy=remedy)
        named = [new[int(first[c])] for c in corners]
    return points[used], [[new[i] for i in loop] for loop in loops], named


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
            "the mesh is closed", where=f"mesh '{name}'", remedy="give an open surface"
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


def turns_of(points: Floats, border: list[int]) -> Floats:
    """Turn (b,) [degrees] of the border at each of its vertices."""
    run = points[border]
    before, after = run - np.roll(run, 1, axis=0), np.roll(run, -1, axis=0) - run
    cosine = dot(before, after)
    cosine /= np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    turn: Floats = np.rad2deg(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return turn


def _outward(points: Floats, loops: list[list[int]], border: list[int]) -> Floats:
    """(b,) 1 where the border turns around the mesh, seen along its normal, -1 where inwards."""
    normal = np.zeros_like(points)
    for loop in loops:
        across = points[loop] - points[loop[0]]
        normal[loop] += np.cross(across[:-1], across[1:]).sum(axis=0)
    run = points[border]
    before, after = run - np.roll(run, 1, axis=0), np.roll(run, -1, axis=0) - run
    outward: Floats = np.sign(dot(np.cross(before, after), normal[border]))
    return outward


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
    where = f"corners of mesh '{name}'"
    inside = [k for k, corner in enumerate(corners, 1) if corner not in border]
    if inside:
        raise InputError(
            f"number {inside[0]} of {len(corners)} is not on the border", where=where,
            remedy="name vertices of the border",
        )  # fmt: skip
    if not _cyclic([border.index(c) for c in corners]):  # given in the opposite direction
        corners, polygon = [corners[0], *corners[:0:-1]], np.roll(polygon[::-1], 1, axis=0)
        if not _cyclic([border.index(c) for c in corners]):
            raise InputError(
                "they do not follow each other", where=where,
                remedy="name them in their order along the border",
            )  # fmt: skip
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


def _cyclic(order: list[int]) -> bool:
    """Whether four positions ascend cyclically."""
    start = int(np.argmin(order))
    turned = order[start:] + order[:start]
    return turned == sorted(turned)
