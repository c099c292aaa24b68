"""Limits of tilt, load, friction and thickness; imperfections."""

from drystone.limits.brackets import Bracket, Evaluation
from drystone.limits.imperfections import (
    Imperfections,
    StandingShare,
    imperfect,
    imperfections,
)
from drystone.limits.limit_checks import Check
from drystone.limits.limit_families import (
    Family,
    Friction,
    LoadFactor,
    Parametric,
    Quantity,
    Shrunk,
    Tilt,
)
from drystone.limits.limit_types import Limit, LimitOptions
from drystone.limits.limits import (
    LIMITS,
    limit_friction,
    limit_load,
    limit_shrink,
    limit_thickness,
    limit_tilt,
)
from drystone.limits.polar import TiltSweep, tilt_sweep
from drystone.limits.thrust import ThrustBounds, thrust_bounds

__all__ = [
    "LIMITS",
    "Bracket",
    "Check",
    "Evaluation",
    "Family",
    "Friction",
    "Imperfections",
    "Limit",
    "LimitOptions",
    "LoadFactor",
    "Parametric",
    "Quantity",
    "Shrunk",
    "StandingShare",
    "ThrustBounds",
    "Tilt",
    "TiltSweep",
    "imperfect",
    "imperfections",
    "limit_friction",
    "limit_load",
    "limit_shrink",
    "limit_thickness",
    "limit_tilt",
    "thrust_bounds",
    "tilt_sweep",
]
