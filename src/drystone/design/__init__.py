"""Stability-aware design: why a structure falls, and what to change until it stands."""

from drystone.design.diagnosis import Diagnosis, DiagnosisOptions, Region, diagnose
from drystone.design.joint_motion import JointMotion, JointState
from drystone.design.needs import Ballast, Needs, Pull
from drystone.design.props import PropForce

__all__ = [
    "Ballast",
    "Diagnosis",
    "DiagnosisOptions",
    "JointMotion",
    "JointState",
    "Needs",
    "PropForce",
    "Pull",
    "Region",
    "diagnose",
]
