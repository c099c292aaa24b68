"""Flat plans for form finding."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.shells.surface.lengths import refuse_unless_positive
from drystone.shells.surface.patch import Patch, Side
from drystone.shells.surface.shape import Edge, Seam, Shape


def rectangular_plan(
    width: float, depth: float, *, open_sides: Sequence[Side] = (Side.TOP,)
) -> Shape:
    """A flat rectangle, v along x over ``width`` [m], u along y over ``depth`` [m].

    It is supported on all sides except the open ones.
    """
    refuse_unless_positive(width=width, depth=depth)

    def point(u: Floats, v: Floats) -> Floats:
        return np.stack([width * v, depth * u, np.zeros_like(u)], axis=-1)

    supports = tuple(Edge(0, side) for side in Side if side not in open_sides)
    return Shape((Patch(point, name="rectangle"),), (), supports, name="rectangular plan")


def three_legged_plan(reach: float = 6.0, waist: float = 2.5, foot: float = 2.4) -> Shape:
    """A flat plan of three legs that meet in the middle: three patches, three open sides.

    Parameters
    ----------
    reach : [m]
        From the middle to the foot of a leg.
    waist : [m]
        From the middle to the middle of an open side.
    foot : [m]
        Width of a leg at its foot.
    """
    refuse_unless_positive(reach=reach, waist=waist, foot=foot)
    if waist >= reach:
        raise InputError(
            f"the waist, {waist:g} m, is not less than the reach, {reach:g} m",
            where="three-legged plan",
        )

    def leg(angle: float) -> Patch:
        def at(degrees: float, radius: float) -> Floats:
            turn = np.deg2rad(angle + degrees)
            return radius * np.array([np.cos(turn), np.sin(turn), 0.0])

        out, side = at(0.0, 1.0), at(90.0, 1.0)
        left, right = reach * out - 0.5 * foot * side, reach * out + 0.5 * foot * side
        waist_left, waist_right = at(-60.0, waist), at(60.0, waist)

        def point(u: Floats, v: Floats) -> Floats:
            U, V = u[:, None], v[:, None]
            low = (1.0 - V) * left + V * right
            high = np.where(V < 0.5, (1.0 - 2.0 * V) * waist_left, (2.0 * V - 1.0) * waist_right)
            result: Floats = (1.0 - U) * low + U * high
            return result

        return Patch(point, name=f"leg at {angle:g} degrees", breaks=(0.5,))

    seams = tuple(
        Seam(Edge(k, Side.TOP, 0.5, 1.0), Edge((k + 1) % 3, Side.TOP, 0.5, 0.0)) for k in range(3)
    )
    supports = tuple(Edge(k, Side.BOTTOM) for k in range(3))
    legs = tuple(leg(90.0 + 120.0 * k) for k in range(3))
    return Shape(legs, seams, supports, name="three vaults")
