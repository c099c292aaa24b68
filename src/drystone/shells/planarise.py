"""Make polygons with shared corners planar, with the smallest moves of the corners.

Newton steps: the smallest move that satisfies the linearised planarity conditions. Each step
doubles the number of correct digits.

Source: Tang et al. 2014, "Form-finding with polyhedral meshes made simple".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from drystone.base.arrays import Floats, Ints, dot
from drystone.base.progress import Progress

_TOLERANCE = 1e-10
"""Largest distance of a corner from its polygon's plane, relative to the length scale: far below
the 1e-6 that joints need, far above rounding."""

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
    steps
        Newton steps taken.
    reached
        Whether the tolerance was reached.
    """

    warp_before: float
    warp_after: float
    drift: float
    steps: int
    reached: bool


def planarise(
    points: Floats,
    polygons: list[tuple[int, ...]],
    *,
    scale: float,
    tolerance: float = _TOLERANCE,
    most: int = 30,
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
    most
        Newton steps.
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
    warp, steps = before, 0
    goal = tolerance * scale
    while warp > goal and steps < most:
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
            progress("planarise", steps, most)
    drift = float(np.linalg.norm(x - start, axis=1).max(initial=0.0))
    report = PlanarReport(
        float(before / scale), float(warp / scale), drift / scale, steps, bool(warp <= goal)
    )
    return x, report


def _groups(polygons: list[tuple[int, ...]]) -> list[Ints]:
    """Points (m, k) of the polygons with the same number k of corners, above three."""
    by_size: dict[int, list[tuple[int, ...]]] = {}
    for polygon in polygons:
        if len(polygon) > 3:
            by_size.setdefault(len(polygon), []).append(polygon)
    return [np.array(by_size[k], dtype=np.intp) for k in sorted(by_size)]


def _warp(x: Floats, groups: list[Ints]) -> float:
    """Largest distance of a corner from the least-squares plane of its polygon."""
    largest = 0.0
    for group in groups:
        centred = x[group] - x[group].mean(axis=1, keepdims=True)
        normal = np.linalg.eigh(np.einsum("mki,mkj->mij", centred, centred))[1][:, :, 0]
        largest = max(largest, float(np.abs(np.einsum("mki,mi->mk", centred, normal)).max()))
    return largest


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
