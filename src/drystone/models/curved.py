"""Models with curved joints, given as strips; both blocks of a joint have the same strips.

Dimensions: Kao 2023, doctoral dissertation, ETH Zurich.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats
from drystone.models.solids import prism, rectangle, require, sections, welded


def resampled(curve: ArrayLike, strips: int) -> Floats:
    """A curve (c, 2) cut into equal steps of its parameter: the given points for c - 1 strips.

    A cubic spline through the points, whose parameter is their number. Source: de Boor 1978.
    """
    points = np.asarray(curve, dtype=np.float64)
    if strips == len(points) - 1:
        return points
    parameter = np.arange(len(points))
    finer: Floats = CubicSpline(parameter, points)(np.linspace(0.0, len(points) - 1.0, strips + 1))
    finer[[0, -1]] = points[[0, -1]]
    return finer


def curve_three_blocks(strips: int = 20) -> Assembly:
    """A roller in the hollow of a block that rests with an S-shaped bed on a fixed one.

    Published tilt limits for a friction of 0.84: 8 degrees about y, 53 about -y, 24 about x,
    12 about x+y, 47 about x-y.

    Parameters
    ----------
    strips
        Plane pieces of each of the two joints.

    Returns
    -------
    Assembly
        ``base``, fixed, ``cradle`` and ``roller``.
    """
    require(strips > 1, f"a curve of {strips} strips", "give two or more")
    curves = sections("curve-three-blocks")
    bed, hollow = resampled(curves["bed"], strips), resampled(curves["hollow"], strips)
    corners = {
        "base": [(0.0, 0.0), (1.0, 0.0), *bed[::-1]],
        "cradle": [(-0.5, bed[0, 1]), *bed, (1.5, 0.7), *hollow[::-1], (-0.5, 2.0)],
        "roller": [*hollow, *_rest_of_roller(hollow, *curves["roller"])],
    }
    blocks = tuple(prism(np.array(c), (0.0, 1.0), name) for name, c in corners.items())
    return Assembly(blocks, np.array([True, False, False]))


def _rest_of_roller(hollow: Floats, x: float, z: float, radius: float) -> Floats:
    """The arc of a circle from the end of the hollow to its start, in equal steps."""
    centre = np.array([x, z])
    end, start = (np.arctan2(*(p - centre)[::-1]) for p in (hollow[-1], hollow[0]))
    inside = (end - start) % (2.0 * np.pi)
    outside = 2.0 * np.pi - inside
    pieces = max(round((len(hollow) - 1) * outside / inside), 3)
    angle = end + outside * np.arange(1, pieces) / pieces
    return centre + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def cube_curve(height: Literal["short", "tall"] = "short", strips: int = 18) -> Assembly:
    """Two hollow blocks, open towards each other, that touch along an S-shaped rim 0.1 m wide.

    The rim is high at two opposite corners, (0, 0) and (1, 1), and low at the two others; across
    the wall its height is constant, with mitred corners.
    Published tilt limits for a friction of 0.84: 70 to 80 degrees (short), 40 to 59 (tall).

    Parameters
    ----------
    height
        ``short``: 1.1 m, corners of the rim at 0.9 and 0.2 m. ``tall``: 2.6 m, at 1.7 and 1.0 m.
    strips
        Plane pieces of the rim along each wall, the two mitred corners included.

    Returns
    -------
    Assembly
        ``lower``, fixed, and ``upper``.
    """
    require(height in ("short", "tall"), f"no model is '{height}'", "short or tall")
    require(strips > 3, f"a rim of {strips} strips", "give four or more")
    first, *curve, last = sections("cube-curve")["rim"]
    rim = np.vstack([first, resampled(curve, strips - 2), last])
    lift, top = (0.0, 1.1) if height == "short" else (0.8, 2.6)
    rim[:, 1] += lift
    lower = _hollow_block(rim, outside=0.0, floor=0.1, name="lower")
    upper = _hollow_block(rim, outside=top, floor=top - 0.1, name="upper")
    return Assembly((lower, upper), np.array([True, False]))


def _hollow_block(rim: Floats, outside: float, floor: float, name: str) -> Block:
    """The block between the rim and a slab with faces z = ``outside`` and z = ``floor``."""
    wall = 0.1
    edge, inside = (0.0, 1.0), (wall, 1.0 - wall)
    loops = [rectangle(2, outside, edge, edge), rectangle(2, floor, inside, inside)]
    for along in (0, 1):
        for far in (False, True):
            strips = rim if not far else np.column_stack([1.0 - rim[::-1, 0], rim[::-1, 1]])
            outer, hollow = (1.0, 1.0 - wall) if far else (0.0, wall)
            within = np.clip(strips[:, 0], wall, 1.0 - wall)
            at_outer = _along(along, strips[:, 0], outer, strips[:, 1])
            at_inner = _along(along, within, hollow, strips[[1, *range(1, len(rim) - 1), -2], 1])
            loops += [
                np.array([at_outer[i], at_outer[i + 1], at_inner[i + 1], at_inner[i]])
                for i in range(len(rim) - 1)
            ]
            ends = np.array([1.0, 0.0])
            loops.append(np.vstack([at_outer, _along(along, ends, outer, outside)]))
            corners = np.array([1.0 - wall, wall])
            loops.append(np.vstack([at_inner[1:-1], _along(along, corners, hollow, floor)]))
    return welded(loops, name)


def _along(axis: int, place: Floats, side: float, z: ArrayLike) -> Floats:
    """Points (p, 3) at ``place`` along x (axis 0) or y (1), at ``side`` along the other."""
    other = np.full(len(place), side)
    level = np.broadcast_to(np.asarray(z, dtype=np.float64), (len(place),))
    return np.column_stack([place, other, level] if axis == 0 else [other, place, level])
