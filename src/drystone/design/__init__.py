"""Stability-aware design: why a structure falls, and what to change until it stands."""

from drystone.design.bench import Tried
from drystone.design.diagnosis import Diagnosis, DiagnosisOptions, Region, diagnose
from drystone.design.joint_motion import JointMotion, JointState
from drystone.design.margin import DesignMargin
from drystone.design.mending import Mending, mend
from drystone.design.mends import Mend, MendOptions, Mends, find_mends
from drystone.design.needs import Ballast, Needs, Pull
from drystone.design.props import PropForce

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
    "Tried",
    "diagnose",
    "find_mends",
    "mend",
]
