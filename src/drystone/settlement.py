"""Settlement: which way the load goes when supports move, and which joints open."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.checks import block_speed, check_forces, corner_motion
from drystone.contacts import Contacts
from drystone.errors import InputError
from drystone.formulations.settlement import solve_settlement
from drystone.geometry.arrays import Floats, Ints
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
    opening : (k,) [m], at the corners; negative where they press
    slide : (k,) [m]
    size : [m], largest motion of a support
    """

    result: Result
    opening: Floats
    slide: Floats
    size: float

    def open_joints(self, share: float = 0.05) -> Ints:
        """Interfaces with a corner that opens by more than a share of the support's motion."""
        opened = self.opening > share * self.size
        return np.unique(self.result.contacts.interface[opened])

    def sliding_joints(self, share: float = 0.05) -> Ints:
        """Interfaces that press and slide by more than a share of the support's motion."""
        moving = (self.slide > share * self.size) & (self.opening <= share * self.size)
        return np.unique(self.result.contacts.interface[moving])


def settle(
    assembly: Assembly,
    contacts: Contacts,
    motion: Mapping[int | str, Any],
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
        its centroid; world axes. Supports that are not named rest.
    load
        Self-weight when left out.
    options

    Raises
    ------
    InputError
        A block that is not fixed, or nothing that moves.

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
    began = time.perf_counter()
    case = LoadCase.gravity(assembly) if load is None else load
    prescribed = _prescribed(assembly, motion)
    size = float(block_speed(assembly, prescribed).max())
    active = ~(assembly.fixed[contacts.block_a] & assembly.fixed[contacts.block_b])
    part = contacts.select(active)
    statics = build_statics(assembly, part, case)
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
        residuals = _residuals(assembly, contacts, case, force, moved)
        message = f"Coulomb friction is met to {solution.defect:.1e} of the mean load only"
        if residuals.largest <= CHECKED:
            verdict = Verdict.STABLE
            message = "the blocks follow the supports and come to rest"
    result = Result(
        method="settlement",
        verdict=verdict,
        assembly=assembly,
        contacts=contacts,
        load=case,
        message=message,
        force=force if solved else None,
        displacement=moved if solved else None,
        residuals=residuals,
        options=chosen,
        solver=solution.raw.solver,
        iterations=solution.steps,
        time_s={"solve": time.perf_counter() - began},
    )
    relative = corner_motion(loose, contacts, moved)
    return Settlement(result, relative[:, 0], np.linalg.norm(relative[:, 1:], axis=1), size)


def _prescribed(assembly: Assembly, motion: Mapping[int | str, Any]) -> Floats:
    prescribed = np.zeros((len(assembly), 6))
    for block, given in motion.items():
        i = int(assembly.indices([block])[0])
        if not assembly.fixed[i]:
            raise InputError(
                f"block '{assembly.names[i]}' is not fixed, so its motion is not prescribed",
                remedy="move a support, or load the block",
            )
        values = np.asarray(given, dtype=np.float64)
        if values.shape not in ((3,), (6,)) or not np.isfinite(values).all():
            raise InputError(
                f"the motion of block '{assembly.names[i]}' is not 3 or 6 finite numbers",
                remedy="give a translation, or a translation and a rotation vector",
            )
        prescribed[i, : len(values)] = values
    if not prescribed.any():
        raise InputError("no support moves", remedy="give a motion")
    return prescribed


def _residuals(
    assembly: Assembly, contacts: Contacts, load: LoadCase, force: Floats, moved: Floats
) -> Residuals:
    """Equilibrium of the free blocks, and contact conditions with the supports in motion."""
    at_rest = check_forces(assembly, contacts, load, force)
    following = check_forces(Assembly(assembly.blocks), contacts, load, force, moved)
    return replace(following, equilibrium=at_rest.equilibrium)


__all__ = ["Settlement", "SettlementOptions", "settle"]
