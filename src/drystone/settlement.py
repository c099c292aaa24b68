"""Settlement: which way the load goes when supports move, and which joints open."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from drystone.assembly import Assembly
from drystone.checks import block_speed, check_forces, corner_motion
from drystone.contacts import Contacts
from drystone.errors import InputError
from drystone.formulations.settlement import solve_settlement
from drystone.geometry.arrays import Bools, Floats, Ints
from drystone.loads import LoadCase
from drystone.results import Residuals, Result, Verdict
from drystone.solvers.conic import ConicStatus
from drystone.statics import build_statics

CHECKED = 1e-5
"""Largest residual of a state that is reported as standing, dimensionless: that of an interior
point on a problem whose compliance is small against the motion."""


@dataclass(frozen=True)
class SettlementOptions:
    """Options of :func:`settle`.

    Attributes
    ----------
    compliance
        Overlap of a corner under the mean weight of a block, by the largest motion of a support:
        small for stiff blocks, whose own deformation hides no settlement.
    step_limit
        Of the fixed point of Coulomb's law.
    """

    compliance: float = 1e-3
    step_limit: int = 60

    def __post_init__(self) -> None:
        if not 0.0 < self.compliance < float("inf"):
            raise InputError(f"compliance is {self.compliance}", remedy="give a number above zero")


@dataclass(frozen=True, eq=False)
class Settlement:
    """First-order answer to a motion of supports.

    Attributes
    ----------
    result
        Forces and displacements; those of the supports are the prescribed ones.
    before
        The same model before its supports move, found in the same way.
    opening : (k,) [m], at the corners; negative where they press
    slide : (k,) [m]
    size : [m], largest motion of a support
    """

    result: Result
    before: Result
    opening: Floats
    slide: Floats
    size: float

    def open_joints(self, share: float = 0.05) -> Ints:
        """Interfaces with a corner that opens by more than a share of the support's motion.

        Joints between two supports bear nothing and are left out, here and among those that slide.
        """
        opened = self._between_blocks() & (self.opening > share * self.size)
        return np.unique(self.result.contacts.interface[opened])

    def sliding_joints(self, share: float = 0.05) -> Ints:
        """Interfaces that press and slide by more than a share of the support's motion."""
        moving = (self.slide > share * self.size) & (self.opening <= share * self.size)
        return np.unique(self.result.contacts.interface[self._between_blocks() & moving])

    def _between_blocks(self) -> Bools:
        """Corners (k,) of joints that have a free block."""
        contacts, fixed = self.result.contacts, self.result.assembly.fixed
        both: Bools = fixed[contacts.block_a] & fixed[contacts.block_b]
        return ~both[contacts.interface]

    def change(self) -> Floats:
        """By how much the force of each interface on its block b changes, (m, 3) [N], world axes.

        Raises
        ------
        InputError
            There are no forces before or after.
        """
        if self.before.force is None or self.result.force is None:
            raise InputError("there are no forces to compare", remedy="see whether it stands")
        return self.result.resultants().force - self.before.resultants().force


def support_forces(result: Result) -> Floats:
    """The force (n, 3) [N] that each fixed block gives to the free ones, zero for those."""
    assembly, contacts = result.assembly, result.contacts
    force = result.resultants().force
    total = np.zeros((len(assembly), 3))
    np.add.at(total, contacts.block_a, force)
    np.subtract.at(total, contacts.block_b, force)
    return np.where(assembly.fixed[:, None], total, 0.0)


def settle(
    assembly: Assembly,
    contacts: Contacts,
    motion: Mapping[int | str, Any] | None = None,
    load: LoadCase | None = None,
    *,
    options: SettlementOptions | None = None,
) -> Settlement:
    """The load path that small motions of supports cause in stiff, compliant blocks.

    Parameters
    ----------
    assembly, contacts
    motion
        Per fixed block its translation [m] (3,), or translation and rotation [m, rad] (6,) about
        its centroid; world axes. Supports that are not named rest. It is added to what the load
        prescribes (:meth:`drystone.LoadCase.settlement`).
    load
        Self-weight when left out.
    options

    Raises
    ------
    InputError
        A block that is not fixed, nothing that moves, or nothing that loads the free blocks.

    Examples
    --------
    A plank on three supports leaves the middle one when that goes down:

    >>> import drystone
    >>> from drystone.models import box
    >>> feet = [box((0.2, 1.0, 0.2), (x, 0.0, 0.0), n) for n, x in zip("abc", (0.0, 1.9, 3.8))]
    >>> plank = box((4.0, 1.0, 0.2), (0.0, 0.0, 0.2), "plank")
    >>> assembly = drystone.Assembly((*feet, plank)).with_fixed("abc")
    >>> contacts = drystone.find_contacts(assembly).contacts
    >>> settled = settle(assembly, contacts, {"b": (0.0, 0.0, -0.01)})
    >>> [assembly.names[contacts.block_a[i]] for i in settled.open_joints()]
    ['b']
    """
    chosen = options if options is not None else SettlementOptions()
    case = _case(assembly, motion, load)
    prescribed = np.zeros((len(assembly), 6)) if case.motion is None else case.motion
    size = float(block_speed(assembly, prescribed).max())
    model = _Model(assembly, contacts, case, chosen, size)
    before, after = _state(model, np.zeros_like(prescribed)), _state(model, prescribed)
    moved = prescribed if after.displacement is None else after.displacement
    relative = corner_motion(Assembly(assembly.blocks), contacts, moved)
    slide = np.linalg.norm(relative[:, 1:], axis=1)
    return Settlement(after, before, relative[:, 0], slide, size)


class _Model(NamedTuple):
    assembly: Assembly
    contacts: Contacts
    load: LoadCase
    options: SettlementOptions
    size: float


def _state(model: _Model, prescribed: Floats) -> Result:
    """Forces and motions under a prescribed motion (n, 6) of the supports."""
    assembly, contacts, load, chosen, size = model
    began = time.perf_counter()
    active = ~(assembly.fixed[contacts.block_a] & assembly.fixed[contacts.block_b])
    part = contacts.select(active)
    statics = build_statics(assembly, part, replace(load, motion=None))
    if not statics.load.any():
        raise InputError("nothing loads the free blocks", remedy="add their weight")
    loose = Assembly(assembly.blocks)  # supports that move are no supports to the kinematics
    imposed = corner_motion(loose, part, prescribed) / size
    solution = solve_settlement(
        statics, imposed, compliance=chosen.compliance, step_limit=chosen.step_limit
    )
    moved = prescribed + statics.physical_motion(solution.motion, len(assembly), size)
    force = np.zeros((contacts.corner_count, 3))
    force[active[contacts.interface]] = statics.physical_force(solution.force)
    solved = solution.raw.status is ConicStatus.SOLVED
    residuals, verdict, message = None, Verdict.UNDECIDED, solution.raw.message
    if solution.raw.status is ConicStatus.INFEASIBLE:
        message = "no contact forces were found that balance the loads; see whether it stands"
    if solved:
        residuals = _residuals(assembly, contacts, load, force, moved)
        message = f"Coulomb friction is met to {solution.defect:.1e} of the mean load only"
        if residuals.largest <= CHECKED:
            verdict = Verdict.STABLE
            follow = "the blocks follow the supports and come to rest"
            message = follow if prescribed.any() else "the supports have not moved"
    return Result(
        method="settlement",
        verdict=verdict,
        assembly=assembly,
        contacts=contacts,
        load=load if prescribed.any() else replace(load, motion=None),
        message=message,
        force=force if solved else None,
        displacement=moved if solved else None,
        residuals=residuals,
        options=chosen,
        solver=solution.raw.solver,
        iterations=solution.steps,
        time_s={"solve": time.perf_counter() - began},
    )


def _case(
    assembly: Assembly, motion: Mapping[int | str, Any] | None, load: LoadCase | None
) -> LoadCase:
    """The load with every motion in it."""
    case = LoadCase.gravity(assembly) if load is None else load
    for block, given in (motion or {}).items():
        case = case + LoadCase.settlement(assembly, block, given)
    if case.motion is None:
        raise InputError("no support moves", remedy="give a motion")
    for i in np.flatnonzero(case.motion.any(axis=1) & ~assembly.fixed):
        raise InputError(
            f"block '{assembly.names[i]}' is not fixed, so its motion is not prescribed",
            remedy="move a support, or load the block",
        )
    return case


def _residuals(
    assembly: Assembly, contacts: Contacts, load: LoadCase, force: Floats, moved: Floats
) -> Residuals:
    """Equilibrium of the free blocks, and contact conditions with the supports in motion."""
    at_rest = check_forces(assembly, contacts, load, force)
    following = check_forces(Assembly(assembly.blocks), contacts, load, force, moved)
    return replace(following, equilibrium=at_rest.equilibrium)


__all__ = ["Settlement", "SettlementOptions", "settle", "support_forces"]
