"""Limits of tilt, load, friction and thickness; imperfections."""

from drystone.base import declared
from drystone.base.settings import hold
from drystone.limits.imperfections import Imperfections as Imperfections
from drystone.limits.imperfections import StandingShare as StandingShare
from drystone.limits.imperfections import imperfect as imperfect
from drystone.limits.imperfections import imperfections as imperfections
from drystone.limits.limit_answer import Limit as Limit
from drystone.limits.limit_types import Bracket as Bracket
from drystone.limits.limit_types import Check as Check
from drystone.limits.limit_types import Evaluation as Evaluation
from drystone.limits.limit_types import Family as Family
from drystone.limits.limit_types import Friction as Friction
from drystone.limits.limit_types import LimitOptions as LimitOptions
from drystone.limits.limit_types import LoadFactor as LoadFactor
from drystone.limits.limit_types import Parametric as Parametric
from drystone.limits.limit_types import Quantity as Quantity
from drystone.limits.limit_types import Shrunk as Shrunk
from drystone.limits.limit_types import Tilt as Tilt
from drystone.limits.limit_types import Weakened as Weakened
from drystone.limits.limits import limit_friction as limit_friction
from drystone.limits.limits import limit_load as limit_load
from drystone.limits.limits import limit_shrink as limit_shrink
from drystone.limits.limits import limit_strength as limit_strength
from drystone.limits.limits import limit_thickness as limit_thickness
from drystone.limits.limits import limit_tilt as limit_tilt
from drystone.limits.polar import TiltSweep as TiltSweep
from drystone.limits.polar import tilt_sweep as tilt_sweep
from drystone.limits.thrust import ThrustBounds as ThrustBounds
from drystone.limits.thrust import thrust_bounds as thrust_bounds
from drystone.limits.train_answer import TrainEnvelope as TrainEnvelope
from drystone.limits.train_limit import limit_train as limit_train
from drystone.settlement import large_displacement

LIMITS = {
    "decay": declared.Offered(
        large_displacement.reduce_friction, "arch.json", names=("options.pace", "time_limit_s")
    ),
    "friction": declared.Offered(limit_friction, "arch.json", ("scaled",)),
    "imperfections": declared.Offered(
        imperfections,
        "arch.json --offset 0.01 --draws 2",
        ("draws", "loading", "kinds.friction_range", "kinds.tolerance"),
    ),
    "load": declared.Offered(limit_load, "arch.json voussoir-05:1kN", ("upper",)),
    "shrink": declared.Offered(limit_shrink, "arch.json --seismic 0.05"),
    "strength": declared.Offered(limit_strength, "arch.json --strength 1MPa"),
    "sweep": declared.Offered(tilt_sweep, "arch.json --directions 3", ("directions",)),
    "thrust": declared.Offered(thrust_bounds, "arch.json springer-right", ("direction",)),
    "tilt": declared.Offered(limit_tilt, "arch.json --axis y", ("axis",)),
    "train": declared.Offered(
        limit_train, "arch.json --steps 5", ("train", "fill", "steps"), "train"
    ),
}
"""The limits of a model, by what the command line and other programs call them."""

__all__ = hold(globals())
