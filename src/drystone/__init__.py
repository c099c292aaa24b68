"""drystone: does a structure of loose blocks stand by contact and friction alone?

The names below are the public API: types, errors, and the main job from a file to a picture. Each
is loaded when it is first asked for, so that ``import drystone`` does no work and pulls in no
solver, plotting or CAD package. Model families are in :mod:`drystone.models`, voussoirs from a
surface in :mod:`drystone.shells`, and every option and report beside the function that takes or
gives it.

>>> import drystone
>>> from drystone.models import tower
>>> drystone.check(tower(3), friction=0.6).verdict
<Verdict.STABLE: 'stable'>
"""

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

from drystone.base.display import draw_with
from drystone.base.forks import watch_forks

if TYPE_CHECKING:
    from drystone.assembly import Assembly as Assembly
    from drystone.assembly import Block as Block
    from drystone.base.errors import DrystoneError as DrystoneError
    from drystone.base.errors import FormatError as FormatError
    from drystone.base.errors import InputError as InputError
    from drystone.base.errors import MissingDependency as MissingDependency
    from drystone.contacts import Contacts as Contacts
    from drystone.design import diagnose as diagnose
    from drystone.detection import find_contacts as find_contacts
    from drystone.io import read as read
    from drystone.io import write as write
    from drystone.joint_capacity import JointCapacity as JointCapacity
    from drystone.limits import limit_friction as limit_friction
    from drystone.limits import limit_load as limit_load
    from drystone.limits import limit_shrink as limit_shrink
    from drystone.limits import limit_strength as limit_strength
    from drystone.limits import limit_thickness as limit_thickness
    from drystone.limits import limit_tilt as limit_tilt
    from drystone.loads import LoadCase as LoadCase
    from drystone.model import Model as Model
    from drystone.poses import find_poses as find_poses
    from drystone.programs import solve_cra as solve_cra
    from drystone.programs import solve_cra_penalty as solve_cra_penalty
    from drystone.programs import solve_rbe as solve_rbe
    from drystone.results import Result as Result
    from drystone.results import Verdict as Verdict
    from drystone.sequence.planner import plan as plan
    from drystone.sequence.structure import Structure as Structure
    from drystone.settlement import settle as settle
    from drystone.stability import CheckOptions as CheckOptions
    from drystone.stability import check as check
    from drystone.stability import check_many as check_many
    from drystone.view import save_figure as save_figure
    from drystone.view import save_page as save_page
    from drystone.view import show as show

if not getattr(sys, "_is_gil_enabled", lambda: True)():
    raise ImportError(
        "drystone shares what it computed between threads and needs the interpreter lock of Python:"
        " start python with -X gil=1, or take a build that is not free-threaded"
    )

__version__ = "0.2.0"

_NAMES = {
    "assembly": "Assembly Block",
    "base.errors": "DrystoneError FormatError InputError MissingDependency",
    "contacts": "Contacts",
    "design": "diagnose",
    "detection": "find_contacts",
    "io": "read write",
    "joint_capacity": "JointCapacity",
    "limits": "limit_friction limit_load limit_shrink limit_strength limit_thickness limit_tilt",
    "loads": "LoadCase",
    "model": "Model",
    "poses": "find_poses",
    "programs": "solve_cra solve_cra_penalty solve_rbe",
    "results": "Result Verdict",
    "sequence": "Structure plan",
    "settlement": "settle",
    "stability": "CheckOptions check check_many",
    "view": "save_figure save_page show",
}
"""The public names of each module."""

_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}
"""The module that each public name lives in."""

_ROOMS = (
    "design",
    "detection",
    "fall",
    "limits",
    "models",
    "report",
    "seismic",
    "sequence",
    "settlement",
    "shells",
    "stability",
    "studies",
    "view",
)
"""Packages that are there as attributes after ``import drystone``."""

__all__ = list(_HOME)


def _beside(value: object) -> str:
    """A small picture of a value as HTML; drawing is loaded when one is asked for."""
    from drystone.view.notebook import beside

    return beside(value)


draw_with(_beside)
watch_forks()


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(import_module(f"drystone.{_HOME[name]}"), name)
        globals()[name] = value
        return value
    if name in _ROOMS:
        return import_module(f"drystone.{name}")
    raise AttributeError(f"module 'drystone' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted([*__all__, *_ROOMS, "__version__"])
