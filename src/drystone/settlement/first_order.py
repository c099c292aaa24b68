"""SupportResponse: forces and opening joints when supports move, to first order."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Unpack

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, of_type
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.settings import Options, checked_call
from drystone.checks import block_speed, check_forces, corner_motion
from drystone.io.opening import Given, How, as_model
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.results import Residuals, Result, Verdict
from drystone.settlement.response import solve_response
from drystone.solvers.conic import ConicStatus
from drystone.statics import build_statics

CHECKED = 1e-5
"""Largest residual of a state that is reported as standing, dimensionless: that of an interior
point on a problem whose compliance is small against the motion."""


@dataclass(frozen=True)
class SupportResponseOptions(Options):
    """Options of :func:`support_response`.

    Attributes
    ----------
    compliance
        Overlap of a corner under the mean weight of a block, relative to the largest motion of a
        support. Small for stiff blocks.
    step_limit
        Largest number of steps of the fixed-point iteration for Coulomb's law.
    """

    compliance: float = 1e-3
    step_limit: int = 60

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.compliance < float("inf"):
            raise InputError(f"compliance is {self.compliance}", remedy="give a number above zero")
        self._refuse_below(1, "step_limit")


@dataclass(frozen=True, eq=False)
class SupportResponse(OneLine):
    """First-order answer to a motion of supports.

    Attributes
    ----------
    result
        Forces and displacements; those of the supports are the prescribed ones.
    before
        The same model before its supports move, by the same method.
    opening : (k,) [m], at the corners; negative in compression
    slide : (k,) [m]
    size : [m], largest motion of a support
    """

    result: Result
    before: Result
    opening: Floats
    slide: Floats
    size: float

    def _summary(self) -> str:
        opened = counted(len(self.open_joints()), "joint")
        return f"{self.result.verdict.value}, {opened} open, supports move {self.size:.3g} m"

    def open_joints(self, share: float = 0.05) -> Ints:
        """Interfaces with a corner that opens by more than a share of the support's motion.

        Joints between two supports carry nothing and are omitted, here and in ``sliding_joints``.
        """
        opened = self._between_blocks() & (self.opening > share * self.size)
        return np.unique(self.result.contacts.interface[opened])

    def sliding_joints(self, share: float = 0.05) -> Ints:
        """Interfaces in compression that slide by more than a share of the support's motion."""
        moving = (self.slide > share * self.size) & (self.opening <= share * self.size)
        return np.unique(self.result.contacts.interface[self._between_blocks() & moving])

    def _between_blocks(self) -> Bools:
        """Corners (k,) of joints that have a free block."""
        contacts, fixed = self.result.contacts, self.result.assembly.fixed
        both: Bools = fixed[contacts.block_a] & fixed[contacts.block_b]
        return ~both[contacts.interface]

    def change(self) -> Floats:
        """Change of the force of each interface on its block b, (m, 3) [N], world axes.

        Raises
        ------
        InputError
            There are no forces before or after.
        """
        if self.before.force is None or self.result.force is None:
            raise InputError("there are no forces to compare", remedy="see whether it stands")
        return self.result.resultants.force - self.before.resultants.force


def support_forces(result: Result) -> Floats:
    """The force (n, 3) [N] of each fixed block on the free ones; zero for free blocks."""
    assembly, contacts = result.assembly, result.contacts
    force = result.resultants.force
    total = np.zeros((len(assembly), 3))
    np.add.at(total, contacts.block_a, force)
    np.subtract.at(total, contacts.block_b, force)
    return np.where(assembly.fixed[:, None], total, 0.0)


@checked_call
def support_response(
    given: Given,
    motion: Mapping[int | str, Any] | None = None,
    *,
    options: SupportResponseOptions | None = None,
    **how: Unpack[How],
) -> SupportResponse:
    """Forces and joint openings due to small motions of supports, in stiff, compliant blocks.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    motion
        Per fixed block its translation [m] (3,), or translation and rotation [m, rad] (6,) about
        its centroid; world axes. Other supports do not move. It is added to the motion in the load
        (:meth:`drystone.LoadCase.settlement`).
    options

    Raises
    ------
    InputError
        A block that is not fixed, nothing that moves, or nothing that loads the free blocks.

    Examples
    --------
    A plank on three supports loses contact with the middle one when that moves down:

    >>> import drystone
    >>> from drystone.settlement import support_response
    >>> from drystone.models import box
    >>> feet = [box((0.2, 1.0, 0.2), (x, 0.0, 0.0), n) for n, x in zip("abc", (0.0, 1.9, 3.8))]
    >>> plank = box((4.0, 1.0, 0.2), (0.0, 0.0, 0.2), "plank")
    >>> assembly = drystone.Assembly((*feet, plank)).with_fixed(list("abc"))
    >>> model = drystone.Model.of(assembly)
    >>> settled = support_response(model, {"b": (0.0, 0.0, -0.01)})
    >>> [assembly.names[model.contacts.block_a[i]] for i in settled.open_joints()]
    ['b']
    """
    chosen = SupportResponseOptions.of(options)
    given = as_model(given, **how)
    assembly, contacts = given.assembly, given.contacts
    case = _case(assembly, motion, given.load)
    prescribed = np.zeros((len(assembly), 6)) if case.motion is None else case.motion
    size = float(block_speed(assembly, prescribed).max())
    task = _Task(given.with_load(case), chosen, size)
    before, after = _state(task, np.zeros_like(prescribed)), _state(task, prescribed)
    moved = prescribed if after.displacement is None else after.displacement
    relative = corner_motion(Assembly(assembly.blocks), contacts, moved)
    slide = np.linalg.norm(relative[:, 1:], axis=1)
    return SupportResponse(after, before, relative[:, 0], slide, size)


class _Task(NamedTuple):
    model: Model
    options: SupportResponseOptions
    size: float


def _state(task: _Task, prescribed: Floats) -> Result:
    """Forces and motions under a prescribed motion (n, 6) of the supports."""
    model, chosen, size = task
    assembly, contacts, load = model.assembly, model.contacts, model.load
    began = time.perf_counter()
    active = model.active
    part = contacts.select(active)
    statics = build_statics(Model(assembly, part, replace(load, motion=None)))
    if not statics.load.any():
        raise InputError("nothing loads the free blocks", remedy="add their weight")
    loose = Assembly(assembly.blocks)  # moving supports are free in the kinematics
    imposed = corner_motion(loose, part, prescribed) / size
    solution = solve_response(
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
        residuals = _residuals(model, force, moved)
        message = f"Coulomb friction is met to {solution.defect:.1e} of the mean load only"
        if residuals.largest <= CHECKED:
            verdict = Verdict.STABLE
            follow = "the blocks follow the supports and come to rest"
            message = follow if prescribed.any() else "the supports have not moved"
    return Result(
        method="settlement",
        verdict=verdict,
        model=model if prescribed.any() else model.with_load(replace(load, motion=None)),
        message=message,
        force=force if solved else None,
        displacement=moved if solved else None,
        residuals=residuals,
        options=chosen,
        solver=solution.raw.solver,
        iterations=solution.steps,
        time_s={"solve": time.perf_counter() - began},
    )


def _case(assembly: Assembly, motion: Mapping[int | str, Any] | None, load: LoadCase) -> LoadCase:
    """The load with every motion in it."""
    case = load
    remedy = 'give translations by name of the block, such as {"base": (0.0, 0.0, -0.01)}'
    motions = {} if motion is None else motion
    of_type(motions, Mapping, "the motion", remedy)  # type: ignore[type-abstract]
    for block, given in motions.items():
        case = case + LoadCase.settlement(assembly, block, given)
    if case.motion is None:
        raise InputError("no support moves", remedy="give a motion")
    for i in np.flatnonzero(case.motion.any(axis=1) & ~assembly.fixed):
        raise InputError(
            f"block '{assembly.names[i]}' is not fixed, so its motion is not prescribed",
            remedy="move a support, or load the block",
        )
    return case


def _residuals(model: Model, force: Floats, moved: Floats) -> Residuals:
    """Equilibrium of the free blocks, and contact conditions with the supports in motion."""
    at_rest = check_forces(model, force)
    loose = replace(model, assembly=Assembly(model.assembly.blocks))
    following = check_forces(loose, force, moved)
    return replace(following, equilibrium=at_rest.equilibrium)
