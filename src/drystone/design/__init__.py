"""Stability-aware design: why a structure falls, and which changes make it stand."""

from drystone.design.causes.diagnosed import Diagnosis, Region
from drystone.design.causes.diagnosis import DiagnosisOptions, diagnose
from drystone.design.causes.joint_motion import JointMotion, JointState
from drystone.design.causes.missing import Ballast, Needs, Pull
from drystone.design.causes.prop_forces import PropForce
from drystone.design.mends.bench import Tried
from drystone.design.mends.margin import DesignMargin
from drystone.design.mends.mending import Mending, mend
from drystone.design.mends.mends import Mend, MendOptions, Mends, find_mends
from drystone.design.wedges.sharpening import Sharpened, SharpenOptions, sharpen

__all__ = [
    "Ballast",
    "DesignMargin",
    "Diagnosis",
    "DiagnosisOptions",
    "JointMotion",
    "JointState",
    "Mend",
    "MendOptions",
    "Mending",
    "Mends",
    "Needs",
    "PropForce",
    "Pull",
    "Region",
    "SharpenOptions",
    "Sharpened",
    "Tried",
    "diagnose",
    "find_mends",
    "mend",
    "sharpen",
]
