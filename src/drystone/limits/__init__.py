"""Limits of tilt, load, friction and thickness; imperfections."""

from collections.abc import Mapping

from drystone.base.declared import Offered
from drystone.base.settings import hold
from drystone.limits.imperfections import (
    Imperfections,
    StandingShare,
    imperfect,
    imperfections,
)
from drystone.limits.limit_answer import Limit
from drystone.limits.limit_types import (
    Bracket,
    Check,
    Evaluation,
    Family,
    Friction,
    LimitOptions,
    LoadFactor,
    Parametric,
    Quantity,
    Shrunk,
    Tilt,
    Weakened,
)
from drystone.limits.limits import (
    limit_friction,
    limit_load,
    limit_shrink,
    limit_strength,
    limit_thickness,
    limit_tilt,
)
from drystone.limits.polar import TiltSweep, tilt_sweep
from drystone.limits.thrust import ThrustBounds, thrust_bounds
from drystone.limits.train_limit import TrainEnvelope, limit_train
from drystone.settlement import reduce_friction

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
    "TrainEnvelope",
    "Weakened",
    "imperfect",
    "imperfections",
    "limit_friction",
    "limit_load",
    "limit_shrink",
    "limit_strength",
    "limit_thickness",
    "limit_tilt",
    "limit_train",
    "thrust_bounds",
    "tilt_sweep",
]

LIMITS: Mapping[str, Offered] = {
    "decay": Offered(reduce_friction, "arch.json", names=("options.pace", "time_limit_s")),
    "friction": Offered(limit_friction, "arch.json", ("scaled",)),
    "imperfections": Offered(
        imperfections,
        "arch.json --offset 0.01 --draws 2",
        ("draws", "loading", "kinds.friction_range", "kinds.tolerance"),
    ),
    "load": Offered(limit_load, "arch.json voussoir-05:1kN", ("upper",)),
    "shrink": Offered(limit_shrink, "arch.json --seismic 0.05"),
    "strength": Offered(limit_strength, "arch.json --strength 1MPa"),
    "sweep": Offered(tilt_sweep, "arch.json --directions 3", ("directions",)),
    "thrust": Offered(thrust_bounds, "arch.json springer-right", ("direction",)),
    "tilt": Offered(limit_tilt, "arch.json --axis y", ("axis",)),
    "train": Offered(limit_train, "arch.json --steps 5", ("train", "fill", "steps"), "train"),
}
"""The limits of a model, by what the command line and other programs call them."""

hold(globals())
