"""Stability-aware design: why a structure falls, and which changes make it stand.

Each name is loaded when it is first asked for: a diagnosis needs neither shells nor plans.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from drystone.design.building.buildable import Buildable as Buildable
    from drystone.design.building.buildable import BuildableOptions as BuildableOptions
    from drystone.design.building.buildable import BuildNeeds as BuildNeeds
    from drystone.design.building.buildable import TriedLayout as TriedLayout
    from drystone.design.building.buildable_search import make_buildable as make_buildable
    from drystone.design.building.joint_recuts import Recut as Recut
    from drystone.design.building.joint_recuts import RecutJoint as RecutJoint
    from drystone.design.building.joint_recuts import RecutOptions as RecutOptions
    from drystone.design.building.joint_recuts import recut_joints as recut_joints
    from drystone.design.causes.diagnosed import Diagnosis as Diagnosis
    from drystone.design.causes.diagnosed import Region as Region
    from drystone.design.causes.diagnosis import DiagnosisOptions as DiagnosisOptions
    from drystone.design.causes.diagnosis import diagnose as diagnose
    from drystone.design.causes.joint_motion import JointMotion as JointMotion
    from drystone.design.causes.joint_motion import JointState as JointState
    from drystone.design.causes.missing import Ballast as Ballast
    from drystone.design.causes.missing import Glue as Glue
    from drystone.design.causes.missing import JointTurn as JointTurn
    from drystone.design.causes.missing import Needs as Needs
    from drystone.design.causes.missing import Pull as Pull
    from drystone.design.causes.prop_forces import PropForce as PropForce
    from drystone.design.mends.bench import Tried as Tried
    from drystone.design.mends.margin import DesignMargin as DesignMargin
    from drystone.design.mends.mend_types import Mend as Mend
    from drystone.design.mends.mend_types import MendOptions as MendOptions
    from drystone.design.mends.mend_types import Mends as Mends
    from drystone.design.mends.mending import Mending as Mending
    from drystone.design.mends.mending import mend as mend
    from drystone.design.mends.mends import find_mends as find_mends
    from drystone.design.shaping.free_moves import Moves as Moves
    from drystone.design.shaping.free_moves import block_moves as block_moves
    from drystone.design.shaping.free_moves import free_vertices as free_vertices
    from drystone.design.shaping.free_moves import joint_moves as joint_moves
    from drystone.design.shaping.free_moves import thickening as thickening
    from drystone.design.shaping.shape_options import HelpMeasure as HelpMeasure
    from drystone.design.shaping.shape_options import ShapeAim as ShapeAim
    from drystone.design.shaping.shape_options import Shaped as Shaped
    from drystone.design.shaping.shape_options import ShapeOptions as ShapeOptions
    from drystone.design.shaping.shaping import shape as shape
    from drystone.design.shaping.shared_planes import PlaneMoves as PlaneMoves
    from drystone.design.shaping.variables import FamilyMoves as FamilyMoves
    from drystone.design.tuning.tuned_values import Parameter as Parameter
    from drystone.design.tuning.tuned_values import Tuned as Tuned
    from drystone.design.tuning.tuned_values import TuneTrial as TuneTrial
    from drystone.design.tuning.tuning import TuneOptions as TuneOptions
    from drystone.design.tuning.tuning import tune as tune
    from drystone.design.wedges.sharpening import Sharpened as Sharpened
    from drystone.design.wedges.sharpening import SharpenOptions as SharpenOptions
    from drystone.design.wedges.sharpening import sharpen as sharpen

_NAMES = {
    "building.buildable": "BuildNeeds Buildable BuildableOptions TriedLayout",
    "building.buildable_search": "make_buildable",
    "building.joint_recuts": "Recut RecutJoint RecutOptions recut_joints",
    "causes.diagnosed": "Diagnosis Region",
    "causes.diagnosis": "DiagnosisOptions diagnose",
    "causes.joint_motion": "JointMotion JointState",
    "causes.missing": "Ballast Glue JointTurn Needs Pull",
    "causes.prop_forces": "PropForce",
    "mends.bench": "Tried",
    "mends.margin": "DesignMargin",
    "mends.mend_types": "Mend MendOptions Mends",
    "mends.mending": "Mending mend",
    "mends.mends": "find_mends",
    "shaping.free_moves": "Moves block_moves free_vertices joint_moves thickening",
    "shaping.shape_options": "HelpMeasure ShapeAim ShapeOptions Shaped",
    "shaping.shaping": "shape",
    "shaping.shared_planes": "PlaneMoves",
    "shaping.variables": "FamilyMoves",
    "tuning.tuned_values": "Parameter TuneTrial Tuned",
    "tuning.tuning": "TuneOptions tune",
    "wedges.sharpening": "SharpenOptions Sharpened sharpen",
}
"""The public names of each module."""

_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}
"""The module that each public name lives in."""

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'drystone.design' has no attribute '{name}'")
    value = getattr(import_module(f"drystone.design.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
