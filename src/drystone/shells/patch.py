"""Four-sided parametric surface patches: a point for every (u, v) in the unit square.

u runs across the courses, from the springing (0) to the crown or the free edge (1); v runs along a
course. A closed patch, such as a dome, has the same points at v = 0 and v = 1.

Lengths along lines, and checks of lengths and numbers.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from drystone.base.arrays import Floats, dot, floats, number
from drystone.base.display import OneLine
from drystone.base.errors import InputError, located

PatchFunction: TypeAlias = Callable[[Floats, Floats], Any]
"""u (k,), v (k,) in [0, 1] to points (k, 3) [m]."""

STEP = 2e-3
"""Parameter step of the five-point derivative, chosen: truncation and rounding both below 1e-10 on
the analytic families."""

PARTS = 64
"""Along u and v for areas and volumes. Chosen: the error for a dome is 1e-4."""

SAMPLES = 33
"""Along u and v when a patch is checked for folds, and its sides for crossings. Chosen: finer than
any course."""


class Side(enum.Enum):
    """A border of a patch."""

    BOTTOM = "bottom"
    """u = 0, run along v."""
    TOP = "top"
    """u = 1, run along v."""
    LEFT = "left"
    """v = 0, run along u."""
    RIGHT = "right"
    """v = 1, run along u."""

    def parameters(self, along: Floats) -> tuple[Floats, Floats]:
        """(u, v) of the positions ``along`` (k,) in [0, 1] on this side."""
        zero, one = np.zeros_like(along), np.ones_like(along)
        return {
            Side.BOTTOM: (zero, along),
            Side.TOP: (one, along),
            Side.LEFT: (along, zero),
            Side.RIGHT: (along, one),
        }[self]


@dataclass(frozen=True, eq=False)
class Patch(OneLine):
    """A surface patch.

    Parameters
    ----------
    function
        Points (k, 3) [m] for u (k,) and v (k,), each in [0, 1].
    closed
        Whether v = 1 is the same as v = 0.
    name
    breaks
        Positions in v at which its lines along v may have a corner.

    Raises
    ------
    InputError
        The function does not return finite points.

    Examples
    --------
    >>> import numpy as np
    >>> plane = Patch(lambda u, v: np.stack([2.0 * u, v, 0.0 * u], axis=-1))
    >>> plane.point(0.5, 1.0).tolist()
    [1.0, 1.0, 0.0]
    >>> plane.normal(0.5, 0.5).round(6).tolist()
    [0.0, 0.0, 1.0]
    """

    function: PatchFunction
    closed: bool = False
    name: str = "patch"
    breaks: tuple[float, ...] = ()

    def point(self, u: Any, v: Any) -> Floats:
        """Points (..., 3) [m]; u and v broadcast."""
        u, v = np.broadcast_arrays(np.asarray(u, dtype=np.float64), np.asarray(v, np.float64))
        along = v.ravel() % 1.0 if self.closed else v.ravel()
        values = np.asarray(self.function(u.ravel(), along), dtype=np.float64)
        if values.shape != (u.size, 3):
            raise InputError(
                f"its function gave shape {values.shape} for {u.size} parameters",
                where=f"patch '{self.name}'",
                remedy=f"return ({u.size}, 3)",
            )
        if not np.isfinite(values).all():
            k = int(np.flatnonzero(~np.isfinite(values).all(axis=1))[0])
            raise InputError(
                f"is not finite at u {u.ravel()[k]:.3f}, v {along[k]:.3f}",
                where=f"patch '{self.name}'",
                remedy="the function must hold on the whole unit square",
            )
        return values.reshape(*u.shape, 3)

    def tangents(self, u: Any, v: Any) -> tuple[Floats, Floats]:
        """Derivatives (..., 3) [m] of the point by u and by v, by five-point differences."""
        u, v = np.broadcast_arrays(np.asarray(u, dtype=np.float64), np.asarray(v, np.float64))
        u_node, u_weight = _stencil(u, bounded=True)
        v_node, v_weight = _stencil(v, bounded=not self.closed)
        by_u = (u_weight[..., None] * self.point(u_node, v[..., None])).sum(axis=-2)
        by_v = (v_weight[..., None] * self.point(u[..., None], v_node)).sum(axis=-2)
        return by_u, by_v

    def normal(self, u: Any, v: Any) -> Floats:
        """Unit normals (..., 3), outwards: to the side that faces up on average.

        Raises
        ------
        InputError
            The patch has no tangent plane there.
        """
        by_u, by_v = self.tangents(u, v)
        raw = self.turn * np.cross(by_u, by_v)
        length = np.linalg.norm(raw, axis=-1, keepdims=True)
        scale = np.linalg.norm(by_u, axis=-1) * np.linalg.norm(by_v, axis=-1)
        if not (length[..., 0] > 1e-9 * np.maximum(scale, 1e-300)).all():
            raise InputError(
                "has no tangent plane somewhere on it",
                where=f"patch '{self.name}'",
                remedy="no side may shrink to a point and no two sides may run together",
            )
        return raw / length

    @cached_property
    def turn(self) -> float:
        """1 where the outward normal is du x dv, -1 where it is dv x du."""
        grid = (np.arange(9) + 0.5) / 9.0
        by_u, by_v = self.tangents(*np.meshgrid(grid, grid, indexing="ij"))
        raw = np.cross(by_u, by_v).reshape(-1, 3)
        upwards = float(raw[:, 2].sum())
        return -1.0 if upwards < -1e-6 * float(np.linalg.norm(raw, axis=1).sum()) else 1.0

    @cached_property
    def size(self) -> float:
        """[m], diagonal of its bounding box."""
        grid = np.linspace(0.0, 1.0, 17)
        points = self.point(*np.meshgrid(grid, grid, indexing="ij")).reshape(-1, 3)
        return float(np.linalg.norm(np.ptp(points, axis=0)))

    @cached_property
    def parts(self) -> tuple[Floats, Floats, Floats]:
        """Middles (p, 1) and (1, p) in u and v of small parts, and their areas (p, p) [m2]."""
        grid = (np.arange(PARTS) + 0.5) / PARTS
        u, v = grid[:, None], grid[None, :]
        return u, v, np.linalg.norm(np.cross(*self.tangents(u, v)), axis=2) / PARTS**2

    @cached_property
    def fold(self) -> tuple[float, ...]:
        """First u and v, of even samples, where the next normal is reversed; empty without one."""
        grid = (np.arange(SAMPLES) + 0.5) / SAMPLES
        normal = self.normal(*np.meshgrid(grid, grid, indexing="ij"))
        along_u = dot(normal[1:], normal[:-1]) < 0.0
        along_v = dot(normal[:, 1:], normal[:, :-1]) < 0.0
        folded = np.argwhere(along_u).tolist() or np.argwhere(along_v).tolist()
        return tuple(grid[folded[0]].tolist()) if folded else ()

    def border(self, side: Side, along: Any) -> Floats:
        """Points (k, 3) [m] at the positions ``along`` (k,) of a side."""
        return self.point(*side.parameters(np.asarray(along, dtype=np.float64)))


def curvatures(patch: Patch, u: Any, v: Any) -> Floats:
    """Principal curvatures (..., 2) [1/m], positive where the surface bends away from its normal.

    They are the eigenvalues of the Weingarten map, the derivative of the unit normal in the tangent
    plane. Source: do Carmo 1976, section 3-3.
    """
    (E, F, G), (e, f, g) = _forms(patch, u, v)
    determinant = E * G - F * F
    mean = (e * G - 2.0 * f * F + g * E) / (2.0 * determinant)
    gauss = (e * g - f * f) / determinant
    root = np.sqrt(np.maximum(mean**2 - gauss, 0.0))
    return np.stack([mean - root, mean + root], axis=-1)


def line_curvatures(patch: Patch, u: Any, v: Any) -> tuple[Floats, Floats]:
    """Normal curvatures (...) [1/m] along the lines of u and of v, signed as by `curvatures`."""
    (E, _, G), (e, _, g) = _forms(patch, u, v)
    return e / E, g / G


def _forms(patch: Patch, u: Any, v: Any) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
    """First and second fundamental form: E, F, G and e, f, g."""
    u, v = np.broadcast_arrays(np.asarray(u, dtype=np.float64), np.asarray(v, np.float64))
    step = STEP
    low_u, high_u = np.clip(u - step, 0.0, 1.0), np.clip(u + step, 0.0, 1.0)
    low_v, high_v = (v - step, v + step)
    if not patch.closed:
        low_v, high_v = np.clip(low_v, 0.0, 1.0), np.clip(high_v, 0.0, 1.0)
    by_u, by_v = patch.tangents(u, v)
    du_n = (patch.normal(high_u, v) - patch.normal(low_u, v)) / (high_u - low_u)[..., None]
    dv_n = (patch.normal(u, high_v) - patch.normal(u, low_v)) / (high_v - low_v)[..., None]

    first = dot(by_u, by_u), dot(by_u, by_v), dot(by_v, by_v)
    second = dot(du_n, by_u), 0.5 * (dot(du_n, by_v) + dot(dv_n, by_u)), dot(dv_n, by_v)
    return first, second


def check_patch(patch: Patch) -> None:
    """Check a patch for folds and for sides without length.

    Raises
    ------
    InputError
        The normal reverses between two neighbouring samples: the patch is folded there.
    """
    if patch.fold:
        u, v = patch.fold
        raise InputError(
            f"is folded on itself near u {u:.2f}, v {v:.2f}",
            where=f"patch '{patch.name}'",
            remedy="its opposite sides must not cross, nor its control points change order",
        )


def _stencil(at: Floats, *, bounded: bool) -> tuple[Floats, Floats]:
    """Nodes (..., 5) around ``at`` and the weights of the derivative there.

    When bounded, all nodes are inside [0, 1]: near the ends the derivative of the same
    interpolating polynomial is taken off centre.
    """
    centre = np.clip(at, 2.0 * STEP, 1.0 - 2.0 * STEP) if bounded else at
    offset = np.arange(-2.0, 3.0)
    t = ((at - centre) / STEP)[..., None]
    powers = np.concatenate(
        [np.zeros_like(t), np.ones_like(t), 2.0 * t, 3.0 * t**2, 4.0 * t**3], axis=-1
    )
    vandermonde = np.vander(offset, 5, increasing=True)
    weight = powers @ np.linalg.inv(vandermonde) / STEP
    return centre[..., None] + STEP * offset, weight


_SEAM_GAP = 1e-4
"""Largest distance between the two sides of a seam, relative to the size of the patch. Chosen: far
below any block, far above the rounding of a spline."""

_SLENDERNESS = 30.0
"""Size of a patch divided by its thickness, where none is given. Chosen: a thick masonry shell."""


@dataclass(frozen=True)
class Edge:
    """A stretch of a patch's border.

    Parameters
    ----------
    patch
        Position of the patch in the shape.
    side
    start, end
        Positions along the side, in [0, 1]; start above end reverses the direction.
    """

    patch: int
    side: Side
    start: float = 0.0
    end: float = 1.0

    @property
    def low(self) -> float:
        """The smaller of start and end."""
        return min(self.start, self.end)

    @property
    def high(self) -> float:
        """The larger of start and end."""
        return max(self.start, self.end)


@dataclass(frozen=True)
class Seam:
    """Two stretches of border that are one curve, run in the same direction."""

    one: Edge
    other: Edge


@dataclass(frozen=True, eq=False)
class Shape(OneLine):
    """Patches joined along seams, supported on some of their sides.

    Parameters
    ----------
    patches
    seams
        Where patches meet; checked.
    supports
        Stretches of border on which the shell is supported.
    keystone
        Stretches of border around an opening that one block closes; empty for an open eye.
    name
    thickness : [m]
        Thickness of the shape, if known: that of form finding.

    Raises
    ------
    InputError
        A folded patch, a seam whose sides do not meet, or an edge of a patch or side that does not
        exist.
    """

    patches: tuple[Patch, ...]
    seams: tuple[Seam, ...] = ()
    supports: tuple[Edge, ...] = ()
    keystone: tuple[Edge, ...] = ()
    name: str = "shell"
    thickness: float | None = None

    def __post_init__(self) -> None:
        if not self.patches:
            raise InputError("a shape needs a patch")
        edges = [e for seam in self.seams for e in (seam.one, seam.other)]
        for edge in (*edges, *self.supports, *self.keystone):
            if not isinstance(edge, Edge):
                raise InputError(
                    f"a border stretch is {edge!r}",
                    where=f"shape '{self.name}'",
                    remedy="give Edge(patch, side)",
                )
            if not 0 <= edge.patch < len(self.patches):
                raise InputError(f"there is no patch {edge.patch}", where=f"shape '{self.name}'")
            if not (0.0 <= edge.low < edge.high <= 1.0):
                raise InputError(
                    f"a border stretch from {edge.start} to {edge.end} is not within 0 to 1",
                    where=f"shape '{self.name}', patch {edge.patch}, side {edge.side.value}",
                )
            if self.patches[edge.patch].closed and edge.side in (Side.LEFT, Side.RIGHT):
                raise InputError(
                    f"a closed patch has no side '{edge.side.value}'",
                    where=f"shape '{self.name}', patch {edge.patch}",
                    remedy="name its bottom or its top",
                )
        for patch in self.patches:
            check_patch(patch)
        for seam in self.seams:
            self._check_seam(seam)

    def _check_seam(self, seam: Seam) -> None:
        lines = [self.points_along(e, 257) for e in (seam.one, seam.other)]
        one, other = (at_lengths(x, np.linspace(0.0, arc_lengths(x)[-1], 33)) for x in lines)
        gap = float(np.linalg.norm(one - other, axis=1).max())
        size = max(self.patches[e.patch].size for e in (seam.one, seam.other))
        if gap > _SEAM_GAP * size:
            raise InputError(
                f"the sides of a seam are {gap:.3g} m apart",
                where=(
                    f"shape '{self.name}', patches {seam.one.patch} ({seam.one.side.value}) and "
                    f"{seam.other.patch} ({seam.other.side.value})"
                ),
                remedy="give both patches the same border curve, run in the same direction",
            )

    @property
    def default_thickness(self) -> float:
        """[m], the thickness of the shape, else 1/30 of the size of its largest patch."""
        if self.thickness is not None:
            return self.thickness
        return max(patch.size for patch in self.patches) / _SLENDERNESS

    def points_along(self, edge: Edge, count: int) -> Floats:
        """(count, 3) [m] points of a stretch of border, evenly in its parameter."""
        along = np.linspace(edge.start, edge.end, count)
        return self.patches[edge.patch].border(edge.side, along)

    def supported_on(self, *supports: Edge) -> Shape:
        """The same shape on other supports."""
        return replace(self, supports=tuple(supports))


def at_lengths(line: Floats, at: Floats | float) -> Floats:
    """Points (k, d), or one, of a polyline (p, d) at lengths along it."""
    length = arc_lengths(line)
    return np.stack([np.interp(at, length, axis) for axis in line.T], axis=-1)


def arc_lengths(points: Floats) -> Floats:
    """Length (p, ...) [m] of polylines (p, ..., 3) from their first point to each one."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=-1)
    return np.concatenate([np.zeros_like(step[:1]), np.cumsum(step, axis=0)])


def refuse_unless_positive(where: str = "", **metres: float) -> None:
    """Refuse lengths that are not numbers above zero.

    Raises
    ------
    InputError
        There is such a length; it is named.
    """
    for name, value in metres.items():
        said = f"the {name.replace('_', ' ')}"
        if not 0.0 < number(value, said, finite=False) < math.inf:
            raise InputError(f"{said} is {value}", where=where, remedy="give metres above zero")


def numbers(values: object, what: str, where: str = "") -> Floats:
    """Values as an array of numbers.

    Raises
    ------
    InputError
        They are no numbers, or ragged.
    """
    with located(where):
        return floats(values, what)
