"""Thrust bounds: the least and the largest thrust of a structure on a support."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.answer.drawing import bare_scene
from drystone.base.arrays import Floats
from drystone.base.display import BOUND
from drystone.base.errors import InputError
from drystone.base.settings import checked_call
from drystone.base.units import quantity
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import EquilibriumSolution, solve_extreme_force
from drystone.geometry.frames import axis_vector
from drystone.io.opening import Given, How, as_model
from drystone.limits.bounds import balanced
from drystone.mechanics.statics import build_statics
from drystone.model import Model
from drystone.programs.rbe import BALANCE_TOLERANCE
from drystone.results import Result
from drystone.solvers.program import ConicStatus

_BALANCED = (
    "'{0}' is free, or the only support: what the others exert on it balances the loads, whatever "
    "the forces; fix the block that bears one side, as a wall below an arch, beside the ground"
)


@dataclass(frozen=True, eq=False)
class ThrustBounds(Answer):
    """Least and largest thrust on a block along a direction.

    Attributes
    ----------
    model
    block
    direction : (3,) unit
    least, most : [N]
        NaN if there is no equilibrium; infinite if prestress has no bound.
    least_state, most_state
        Results with the forces, if they exist.
    """

    model: Model
    block: str
    direction: Floats
    least: float
    most: float
    least_state: Result | None
    most_state: Result | None

    @property
    def title(self) -> str:
        """Both bounds."""
        if np.isnan(self.least):
            return f"No forces balance the loads, so there is no thrust on '{self.block}'"
        least, most = (
            quantity(one, "N", digits=BOUND) if np.isfinite(one) else "any force"
            for one in (self.least, self.most)
        )
        return f"Thrust on '{self.block}' from {least} to {most}"

    def sentences(self) -> Sequence[Sentence]:
        """Both bounds, and along what they are measured."""
        along = ", ".join(f"{x:.3g}" for x in self.direction)
        said = [Sentence(self.title, Role.BAD if np.isnan(self.least) else Role.GOOD)]
        other = ", negative the other way" if self.least < 0.0 else ""
        other += " (as at the far end of an arch, or where earth pushes more)" if other else ""
        said.append(Sentence(f"measured along ({along}){other}; forces by equilibrium alone"))
        fixed, which = self.model.assembly.fixed, self.model.assembly.index(self.block)
        if not np.isnan(self.least) and (not fixed[which] or fixed.sum() == 1):
            said.append(Sentence(_BALANCED.format(self.block), Role.REMARK))
        if np.isinf(self.most):
            said.append(Sentence("blocks wedged between supports can be pressed without limit"))
        return said

    def layers(self) -> Scene:
        """The forces at the least and at the largest thrust."""
        states = (("least thrust", self.least_state), ("largest thrust", self.most_state))
        stages = [one.stage(label) for label, one in states if one is not None]
        scene = bare_scene(self.model)
        shown = [replace(one, headline=f"{self.title}: {one.label}") for one in stages]
        return replace(scene, title=self.title, stages=tuple(shown) or scene.stages)

    def numbers(self) -> Mapping[str, Any]:
        """The bounds."""
        return {
            "block": self.block,
            "direction": self.direction,
            "least": self.least,
            "most": self.most,
            "unit": "N",
        }


@checked_call
def thrust_bounds(
    given: Given,
    block: int | str,
    direction: Floats | Sequence[float] | str = "x",
    *,
    cone: FrictionCone | None = None,
    **how: Unpack[How],
) -> ThrustBounds:
    """The least and the largest force that the others exert on a block along a direction.

    One conic program each. Source: Heyman 1966, minimum and maximum thrust.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    block
        Any block, usually a support.
    direction : (3,) or a name
        ``x``, ``y``, ``z``, ``-x``, ``-y`` or a vector.
    cone
        Exact when left out.

    Raises
    ------
    InputError
        The block touches nothing, or the direction has no length.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import arch
    >>> model = drystone.Model.of(arch(0.2, 10), friction=0.8)
    >>> bounds = thrust_bounds(model, "springer-right", (1.0, 0.0, 0.0))
    >>> bounds.least < bounds.most
    True
    """
    model = as_model(given, **how)
    assembly, contacts = model.assembly, model.contacts
    which = int(assembly.indices([block])[0])
    along = axis_vector(direction, "direction")
    touching = (contacts.block_a == which) | (contacts.block_b == which)
    if not touching.any():
        raise InputError(f"block '{assembly.names[which]}' touches nothing", remedy="name another")
    active = model.active
    part = contacts.select(active)
    statics = build_statics(model, part)
    corner = part.interface
    sign = (part.block_b == which).astype(np.float64) - (part.block_a == which)
    price = sign[corner][:, None] * np.einsum("kij,j->ki", part.frame[corner], along)
    chosen = FrictionCone.of(cone)

    def extreme(sense: float) -> tuple[float, Result | None]:
        solution = solve_extreme_force(statics, sense * price, cone=chosen)
        if solution.raw.status is ConicStatus.UNBOUNDED:
            return -sense * float("inf"), None
        state = _state(model, active, solution, statics.force_unit)
        if state is None:
            return float("nan"), None
        value = float((price * solution.force).sum())
        if abs(value) < BALANCE_TOLERANCE:  # as far from equilibrium as the forces may be
            value = 0.0
        return statics.force_unit * value, state

    least, most = extreme(1.0), extreme(-1.0)
    return ThrustBounds(model, assembly.names[which], along, least[0], most[0], least[1], most[1])


def _state(
    model: Model,
    active: np.ndarray,
    solution: EquilibriumSolution,
    force_unit: float,
) -> Result | None:
    """The state as a result, if its residuals pass the checks."""
    if solution.raw.status is not ConicStatus.SOLVED:
        return None
    force = np.zeros((model.contacts.corner_count, 3))
    force[active[model.contacts.interface]] = force_unit * solution.force
    return balanced(model, force, solution.raw, "an extreme of the forces that balance the loads")
