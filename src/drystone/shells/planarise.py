"""Make polygons with shared corners planar, with the smallest moves of the corners.

Two stages. First local/global projection: every polygon is projected onto its best plane (local);
then the corners that fit all projections best are found (global), with one sparse positive definite
matrix, factorised once. This is robust, but slow near the solution. Then Newton steps: the smallest
move that satisfies the linearised planarity conditions. Each step doubles the number of correct
digits.

Source: Bouaziz et al. 2012, "Shape-Up", section 3; Deuss et al. 2015, "ShapeOp"; for the second
stage Tang et al. 2014, "Form-finding with polyhedral meshes made simple".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from drystone.base.arrays import Floats, Ints, dot
from drystone.base.errors import SolverError
from drystone.base.progress import Progress

_TOLERANCE = 1e-10
"""Largest distance of a corner from its polygon's plane, relative to the length scale: far below
the 1e-6 that joints need, far above rounding."""

_STAY = 0.05
"""Weight of the distance from the starting point, relative to that of a projection. Chosen."""

_REGULAR = 1e-12
"""Added to the diagonal of the Newton system, relative: conditions may depend on each other."""


@dataclass(frozen=True)
class PlanarReport:
    """Result of the planarisation; lengths are relative to the given length scale.

    Attributes
    ----------
    warp_before, warp_after
        Largest distance of a corner from the plane of its polygon.
    drift
        Largest move of a corner.
    projections, newton
        Rounds and steps taken.
    reached
        Whether the tolerance was reached.
    """

    warp_before: float
    warp_after: float
    drift: float
    projections: int
    newton: int
    reached: bool


def planarise(
    points: Floats,
    polygons: list[tuple[int, ...]],
    *,
    scale: float,
    tolerance: float = _TOLERANCE,
    projections: int = 10,
    newton: int = 30,
    progress: Progress | None = None,
) -> tuple[Floats, PlanarReport]:
    """Points near the given ones that make every polygon planar.

    Parameters
    ----------
    points : (p, 3) [m]
    polygons
        Loops of points; triangles are planar already.
    scale : [m]
        Length to which warp and drift are related, such as the size of a block.
    tolerance
        Largest warp in the end, relative to the length scale.
    projections, newton
        Rounds of local/global projection, and Newton steps, at most.
    progress

    Returns
    -------
    moved : (p, 3) [m]
    report

    Examples
    --------
    >>> import numpy as np
    >>> square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.1], [0, 1, 0]], dtype=float)
    >>> moved, report = planarise(square, [(0, 1, 2, 3)], scale=1.0)
    >>> report.reached, round(report.drift, 3)
    (True, 0.025)
    """
    groups = _groups(polygons)
    start = np.asarray(points, dtype=np.float64)
    x = start.copy()
    before = _warp(x, groups)
    warp, rounds, steps = before, 0, 0
    goal = tolerance * scale
    if warp > goal and projections > 0:
        x, rounds = _project(x, groups, goal, projections)
        warp = _warp(x, groups)
    while warp > goal and steps < newton:
        move = _newton_move(x, groups, scale)
        trial = x + move
        new = _warp(trial, groups)
        length = 1.0
        while not new < warp and length > 1e-3:  # the step is too long for the linearisation
            length *= 0.5
            trial = x + length * move
            new = _warp(trial, groups)
        steps += 1
        if not new < warp:
            break
        x, warp = trial, new
        if progress is not None:
            progress("planarise", steps, newton)
    drift = float(np.linalg.norm(x - start, axis=1).max(initial=0.0))
    report = PlanarReport(
        float(before / scale), float(warp / scale), drift / scale, rounds, steps, bool(warp <= goal)
    )
    return x, report


def _groups(polygons: list[tuple[int, ...]]) -> list[Ints]:
    """Points (m, k) of the polygons with the same number k of corners, above three."""
    by_size: dict[int, list[tuple[int, ...]]] = {}
    for polygon in polygons:
        if len(polygon) > 3:
            by_size.setdefault(len(polygon), []).append(polygon)
    return [np.array(by_size[k], dtype=np.intp) for k in sorted(by_size)]


def _planes(corners: Floats) -> tuple[Floats, Floats]:
    """Corners (m, k, 3) about their means, and unit normals (m, 3) of the least-squares planes."""
    centred = corners - corners.mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("mki,mkj->mij", centred, centred))
    return centred, vectors[:, :, 0]


def _warp(x: Floats, groups: list[Ints]) -> float:
    largest = 0.0
    for group in groups:
        centred, normal = _planes(x[group])
        largest = max(largest, float(np.abs(np.einsum("mki,mi->mk", centred, normal)).max()))
    return largest


def _project(x: Floats, groups: list[Ints], goal: float, rounds: int) -> tuple[Floats, int]:
    """Rounds of local/global projection, near the starting points."""
    centring = sparse.vstack([_centring(g, len(x)) for g in groups]).tocsr()
    system = (centring.T @ centring + _STAY * sparse.eye(len(x))).tocsc()
    try:
        factor = splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    except RuntimeError as error:
        raise SolverError("the projection's matrix is singular") from error
    start = x
    for done in range(rounds):
        flat = []
        for group in groups:
            centred, normal = _planes(x[group])
            off = np.einsum("mki,mi->mk", centred, normal)
            flat.append((centred - off[..., None] * normal[:, None]).reshape(-1, 3))
        x = factor.solve(centring.T @ np.concatenate(flat) + _STAY * start)
        if _warp(x, groups) <= goal:
            return x, done + 1
    return x, rounds


def _centring(corner: Ints, count: int) -> sparse.csr_matrix:
    """Matrix (m k, count) that gives the corners of each polygon relative to their mean."""
    m, k = corner.shape
    block = np.eye(k) - 1.0 / k
    rows = np.repeat(np.arange(m * k), k)
    columns = np.repeat(corner, k, axis=0).ravel()
    return sparse.csr_matrix((np.tile(block, (m, 1)).ravel(), (rows, columns)), (m * k, count))


def _newton_move(x: Floats, groups: list[Ints], scale: float) -> Floats:
    """The smallest move that satisfies the linearised conditions.

    One condition per corner beyond three, c = (x_j - x_0) . n with n the unit normal of a triangle
    of the polygon: minimise ``sum |move|^2`` subject to ``J move = -c``.
    """
    rows, columns, values, residual = [], [], [], []
    offset = 0
    for group in groups:
        m, k = group.shape
        a, b = k // 3, (2 * k) // 3
        rest = [j for j in range(k) if j not in (0, a, b)]
        o, p, q = x[group[:, 0]], x[group[:, a]], x[group[:, b]]
        raw = np.cross(p - o, q - o)
        area = np.linalg.norm(raw, axis=1, keepdims=True)
        n = raw / np.maximum(area, 1e-30 * scale**2)
        for j in rest:
            r = x[group[:, j]] - o
            # r . n with r = s (p - o) + t (q - o) + c n: the plane follows its three corners
            s = dot(np.cross(r, q - o), n)[:, None] / area
            t = dot(np.cross(p - o, r), n)[:, None] / area
            for at, weight in ((j, 1.0), (a, -s), (b, -t), (0, s + t - 1.0)):
                rows.append(np.repeat(offset + np.arange(m), 3))
                columns.append((3 * group[:, at, None] + np.arange(3)).ravel())
                values.append((weight * n).ravel())
            residual.append(dot(r, n))
            offset += m
    J = sparse.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        (offset, 3 * len(x)),
    )
    normal_matrix = (J @ J.T).tocsc()
    normal_matrix = normal_matrix + _REGULAR * float(normal_matrix.diagonal().mean()) * sparse.eye(
        offset, format="csc"
    )
    factor = splu(
        normal_matrix,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    multiplier = factor.solve(-np.concatenate(residual))
    move: Floats = (J.T @ multiplier).reshape(-1, 3)
    return move
