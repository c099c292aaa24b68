"""Stability-aware design: why a structure falls, and which changes make it stand.

Each name is loaded when it is first asked for: a diagnosis needs neither shells nor plans.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from drystone.base.settings import hold

if TYPE_CHECKING:
    from drystone.design.allowance import joint_allowance as joint_allowance
    from drystone.design.bench import Tried as Tried
    from drystone.design.buildable import BuildableOptions as BuildableOptions
    from drystone.design.buildable import make_buildable as make_buildable
    from drystone.design.changed import Buildable as Buildable
    from drystone.design.changed import Changed as Changed
    from drystone.design.changed import Help as Help
    from drystone.design.changed import Kept as Kept
    from drystone.design.cuts import CutOptions as CutOptions
    from drystone.design.cuts import RecutOptions as RecutOptions
    from drystone.design.cuts import cut_until_free as cut_until_free
    from drystone.design.cuts import recut_joints as recut_joints
    from drystone.design.diagnosis import Diagnosis as Diagnosis
    from drystone.design.diagnosis import DiagnosisOptions as DiagnosisOptions
    from drystone.design.diagnosis import Region as Region
    from drystone.design.diagnosis import diagnose as diagnose
    from drystone.design.joint_motion import JointMotion as JointMotion
    from drystone.design.joint_motion import JointState as JointState
    from drystone.design.margin import DesignMargin as DesignMargin
    from drystone.design.mends import MendOptions as MendOptions
    from drystone.design.mends import Mends as Mends
    from drystone.design.mends import find_mends as find_mends
    from drystone.design.mends import mend as mend
    from drystone.design.needs import Need as Need
    from drystone.design.needs import Needs as Needs
    from drystone.design.needs import Pull as Pull
    from drystone.design.props import PropForce as PropForce
    from drystone.design.shape_values import FamilyMoves as FamilyMoves
    from drystone.design.shape_values import ShapeAim as ShapeAim
    from drystone.design.shape_values import ShapeOptions as ShapeOptions
    from drystone.design.shaping import shape as shape
    from drystone.design.shared_planes import Moves as Moves
    from drystone.design.shared_planes import block_moves as block_moves
    from drystone.design.shared_planes import free_vertices as free_vertices
    from drystone.design.shared_planes import joint_moves as joint_moves
    from drystone.design.shared_planes import thickening as thickening
    from drystone.design.sharpening import SharpenOptions as SharpenOptions
    from drystone.design.sharpening import sharpen as sharpen
    from drystone.design.surgery import Cut as Cut
    from drystone.design.surgery import cut_block as cut_block
    from drystone.design.surgery import faces_toward as faces_toward
    from drystone.design.surgery import hook_joint as hook_joint
    from drystone.design.surgery import insert_block as insert_block
    from drystone.design.surgery import key_joint as key_joint
    from drystone.design.surgery import merge_blocks as merge_blocks
    from drystone.design.surgery import move_face as move_face
    from drystone.design.surgery import move_joint as move_joint
    from drystone.design.surgery import split_block as split_block
    from drystone.design.surgery import still_edge as still_edge
    from drystone.design.surgery import thicken_blocks as thicken_blocks
    from drystone.design.surgery import tilted_cuts as tilted_cuts
    from drystone.design.surgery import turn_joint as turn_joint
    from drystone.design.surgery import wedge_joint as wedge_joint
    from drystone.design.tuning import Parameter as Parameter
    from drystone.design.tuning import Tuned as Tuned
    from drystone.design.tuning import TuneOptions as TuneOptions
    from drystone.design.tuning import TuneTrial as TuneTrial
    from drystone.design.tuning import tune as tune

_NAMES = {
    "changed": "Buildable Changed Help Kept",
    "surgery": "Cut cut_block faces_toward hook_joint insert_block key_joint merge_blocks "
    "move_face move_joint split_block still_edge thicken_blocks tilted_cuts turn_joint wedge_joint",
    "cuts": "CutOptions RecutOptions cut_until_free recut_joints",
    "buildable": "BuildableOptions make_buildable",
    "diagnosis": "Diagnosis DiagnosisOptions Region diagnose",
    "allowance": "joint_allowance",
    "joint_motion": "JointMotion JointState",
    "needs": "Need Needs Pull",
    "props": "PropForce",
    "bench": "Tried",
    "margin": "DesignMargin",
    "mends": "MendOptions Mends find_mends mend",
    "shape_values": "FamilyMoves ShapeAim ShapeOptions",
    "shaping": "shape",
    "shared_planes": "Moves block_moves free_vertices joint_moves thickening",
    "tuning": "Parameter TuneOptions TuneTrial Tuned tune",
    "sharpening": "SharpenOptions sharpen",
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
    hold(globals())
    return globals()[name]


def __dir__() -> list[str]:
    return sorted(__all__)
