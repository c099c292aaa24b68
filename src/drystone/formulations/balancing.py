"""Corner forces that nearly balance the loads, changed so that they do."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import SolverError
from drystone.mechanics.statics import Statics
from drystone.solvers.cone_scaling import inner

BALANCED = 1e-9
"""Acceleration left, by that of free fall, at which forces balance the loads."""

LIGHTER = 1e-9
"""Share of the mass that holds motions which no force resists."""


def balancing_forces(
    statics: Statics, scale: Floats, force: Floats, tangent: Floats
) -> Floats | None:
    """Forces that balance the loads, by the least change in the metric of a scaling.

    None where they leave their cones, or do not balance the loads: this shows no fall.

    Parameters
    ----------
    statics
    scale : (k, 3)
        Corner forces by these.
    force : (k, 3)
        Inside the cones.
    tangent : (k, 3, 3)
        Inverse of the squared scaling: small across the boundary of a cone that is near.
    """
    scaled = scale[:, :, None] * tangent * scale[:, None, :]
    try:
        solve = statics.maps.factorise(scaled, LIGHTER * statics.mass_matrix)
    except SolverError:
        return None
    left = statics.load + statics.wrench(scale * force)
    for _ in range(2):  # the second time for what rounding left
        moved = scale * statics.displacement(solve(left))
        force = force - (tangent @ moved[:, :, None])[:, :, 0]
        left = statics.load + statics.wrench(scale * force)
    balanced = np.abs(left / statics.mass_matrix).max(initial=0.0) <= BALANCED
    return force if balanced and inner(force).min(initial=0.0) >= 0.0 else None
