"""Patches from sections, control grids and functions; meshes from files."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from drystone.base.arrays import Floats, frozen_floats
from drystone.base.errors import FormatError, InputError
from drystone.base.files import PathLike, read_bytes
from drystone.base.units import scale_of
from drystone.io import format_of
from drystone.io.draft import UP
from drystone.shells.patch import Patch, arc_lengths, check_patch, numbers

if TYPE_CHECKING:
    from scipy.interpolate import NdBSpline


def patch_from_function(
    function: Any, *, closed: bool = False, name: str = "patch", breaks: Sequence[float] = ()
) -> Patch:
    """A patch from ``function(u, v)``, checked for folds; see :class:`Patch`.

    Parameters
    ----------
    function
        Points (k, 3) [m] for u (k,) and v (k,), each in [0, 1].
    closed
        Whether v = 1 is the same as v = 0.
    name
        Of the patch, as errors name it.
    breaks
        Positions in v at which its lines along v may have a corner.

    Raises
    ------
    InputError
        Not finite, or folded.
    """
    patch = Patch(function, closed, name, tuple(breaks))
    check_patch(patch)
    return patch


def curve_through(points: Any) -> Callable[[Floats], Any]:
    """A cubic curve through points (p, 3) [m], by chord length; two points give a line.

    It gives points (k, 3) [m] for s (k,) in [0, 1].

    Parameters
    ----------
    points : (p, 3) [m]
        Two or more, in order; none repeats the one before.
    """
    from scipy.interpolate import CubicSpline  # slow to import

    corners = frozen_floats(points, (None, 3), "curve points")
    if len(corners) < 2:
        raise InputError("a curve needs two or more points")
    at = arc_lengths(corners)
    chord = np.diff(at)
    if not (chord > 0.0).all():
        raise InputError(f"curve point {int(np.argmin(chord)) + 1} repeats the one before")
    return CubicSpline(at / at[-1], corners)


def patch_from_sections(sections: Sequence[Any], *, name: str = "patch") -> Patch:
    """A patch lofted through sections, each (p, 3) points [m] along v, one after another along u.

    Parameters
    ----------
    sections
        Two or more, each of points (p, 3) [m].
    name
        Of the patch, as errors name it.

    Raises
    ------
    InputError
        Fewer than two sections, or a folded loft.

    Examples
    --------
    >>> patch = patch_from_sections([[(0, 0, 0), (0, 1, 0)], [(1, 0, 1), (1, 1, 1)]])
    >>> patch.point(1.0, 0.5).tolist()
    [1.0, 0.5, 1.0]
    """
    if len(sections) < 2:
        raise InputError("a loft needs two or more sections", where=f"patch '{name}'")
    curves = [curve_through(section) for section in sections]
    count = max(len(np.asarray(section)) for section in sections)
    along = np.linspace(0.0, 1.0, count if count == 2 else 8 * count)
    return patch_from_grid(np.stack([curve(along) for curve in curves]), name=name)


def patch_from_grid(
    grid: Any, *, closed: bool = False, breaks: Sequence[int] = (), name: str = "patch"
) -> Patch:
    """A spline patch through a grid of points.

    Parameters
    ----------
    grid : (p, q, 3) [m]
        Rows along u, columns along v. Cubic where there are four or more. A closed grid repeats its
        first column at the end.
    closed
        Whether v is closed.
    breaks
        Columns at which the patch may have an edge: each side has its own spline.
    name
        Of the patch, as errors name it.

    Raises
    ------
    InputError
        Fewer than two rows or columns, or a folded patch.
    """
    points = numbers(grid, "points of a control grid", f"patch '{name}'")
    if points.ndim != 3 or points.shape[2] != 3 or min(points.shape[:2]) < 2:
        raise InputError(
            f"the control grid has shape {points.shape}",
            where=f"patch '{name}'",
            remedy="give (rows, columns, 3) with two or more rows and columns",
        )
    if not np.isfinite(points).all():
        raise InputError("the control grid is not finite", where=f"patch '{name}'")
    rows, columns = points.shape[:2]
    if closed:  # three more columns at each end make the spline smooth across the closure
        pad = min(3, columns - 1)
        points = np.concatenate([points[:, -1 - pad : -1], points, points[:, 1 : 1 + pad]], axis=1)
        at_v = (np.arange(points.shape[1]) - pad) / (columns - 1)
        cuts = [0, points.shape[1] - 1]
    else:
        at_v = np.linspace(0.0, 1.0, columns)
        cuts = [0, *sorted(breaks), columns - 1]
    at_u = np.linspace(0.0, 1.0, rows)
    pieces = [
        _spline(at_u, at_v[lo : hi + 1], points[:, lo : hi + 1])
        for lo, hi in itertools.pairwise(cuts)
    ]
    inner = at_v[cuts[1:-1]]
    point = partial(_on_splines, pieces, inner)
    return patch_from_function(point, closed=closed, name=name, breaks=inner.tolist())


def _on_splines(pieces: Sequence[NdBSpline], inner: Floats, u: Floats, v: Floats) -> Floats:
    """Points on splines beside each other, the second one from the first inner v on."""
    at = np.clip(np.stack([u, v], axis=1), 0.0, 1.0)
    piece = np.searchsorted(inner, v, side="right")
    out = np.empty((len(u), 3))
    for i, spline in enumerate(pieces):
        chosen = piece == i
        out[chosen] = spline(at[chosen])
    return out


def _spline(at_u: Floats, at_v: Floats, points: Floats) -> NdBSpline:
    """Through the points; all three coordinates at once take half the time of one by one."""
    from scipy.interpolate import NdBSpline, make_interp_spline  # slow to import

    by_u = make_interp_spline(at_u, points, min(3, len(at_u) - 1))
    by_v = make_interp_spline(at_v, by_u.c.swapaxes(0, 1), min(3, len(at_v) - 1))
    return NdBSpline((by_u.t, by_v.t), by_v.c.swapaxes(0, 1), (by_u.k, by_v.k))


def read_surface(
    path: PathLike, *, units: str | None = None, up: Literal["z", "y"] | None = None
) -> tuple[Floats, list[tuple[int, ...]]]:
    """Vertices (p, 3) [m] and faces of an open mesh, from any format that has faces.

    Parameters
    ----------
    path
        Its suffix determines the format.
    units
        Of the numbers in the file: mm, cm, m, in or ft. When left out: the unit in the file, else
        metres.
    up
        Axis that points up in the file (y in GLB, else z).

    Raises
    ------
    FormatError
        The file cannot be read.
    InputError
        The unit is not known.
    """
    points, faces, _ = surface_in_file(path, units, up)
    return points, faces


def surface_in_file(
    path: PathLike, units: str | None, up: Literal["z", "y"] | None
) -> tuple[Floats, list[tuple[int, ...]], str | None]:
    """As :func:`read_surface`, and the unit that was asked for or is in the file, if any."""
    chosen = format_of(path)
    turn = UP[up or chosen.up or "z"].T
    draft = chosen.read(read_bytes(path), Path(path))
    vertices, faces, offset = [], [], 0
    for shape in draft.shapes:
        points = np.asarray(shape.vertices, dtype=np.float64).reshape(-1, 3)
        vertices.append(points)
        faces += [tuple(int(i) + offset for i in face) for face in shape.faces]
        offset += len(points)
    if not faces:
        remedy = "mesh the surface (in Rhino: the command Mesh) and save the mesh"
        raise FormatError("holds no mesh", where=str(path), remedy=remedy)
    unit = units or draft.units
    return scale_of(unit or "m") * np.concatenate(vertices) @ turn, faces, unit
