"""A bridge under a train: the largest factor at a place, its forces, and a proof of no more."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from drystone.answer import Verdict
from drystone.base.arrays import Floats, Ints
from drystone.base.errors import InputError
from drystone.checks import check_forces, mechanism_defects
from drystone.formulations.equilibrium import FactorSolution, solve_load_factor
from drystone.formulations.projection import held_still
from drystone.limits.bounds import scaled_wrench
from drystone.limits.limit_types import LimitOptions
from drystone.loads import LoadCase, Train
from drystone.loads.fill import Tops
from drystone.results import Result
from drystone.stability.problem import Problem
from drystone.stability.proofs import MECHANISM_TOLERANCE

_BALANCED = 1e-6
"""Largest residual of forces that count, dimensionless."""
_BEYOND = 1e-3
"""Share of the factor beyond it at which the mechanism is checked."""


class PlacedTrain(NamedTuple):
    """A train with its middle at a place [m], and the largest factor of it by equilibrium."""

    place: float
    train: Train
    found: FactorSolution


@dataclass(frozen=True, eq=False)
class Crossing:
    """A bridge under a train, wherever it is.

    Attributes
    ----------
    problem
        With its weight and that of the fill.
    tops
    train
    options
    """

    problem: Problem
    tops: Tops
    train: Train
    options: LimitOptions

    @cached_property
    def resisting(self) -> Floats:
        """Wrench (n, 6) of all that the fill resists beyond its pressure by ``k``."""
        fill = self.tops.fill
        return self.tops.pressed(0.0, max(fill.passive - fill.k, 0.0))

    @cached_property
    def resisted(self) -> Ints:
        """Positions of the free blocks on which fill resists."""
        free = ~self.problem.model.assembly.fixed
        return np.flatnonzero(free & self.resisting.any(axis=1))

    def live(self, place: float, train: Train) -> LoadCase:
        """A train with its middle at a place."""
        return LoadCase(train.on(self.tops, place), f"{train.name} at x = {place:.4g} m")

    def __call__(self, place: float) -> PlacedTrain:
        """The largest factor of the train at a place: the lesser one of both ways it may move."""
        both = [PlacedTrain(place, train, self._largest(place, train)) for train in self.train.ways]
        return min(both, key=lambda one: np.nan_to_num(one.found.factor, nan=np.inf))

    def _largest(self, place: float, train: Train) -> FactorSolution:
        statics = self.problem.statics
        count, each = len(self.problem.model.assembly), []
        for block in self.resisted.tolist():
            alone = np.zeros((count, 6))
            alone[block] = self.resisting[block]
            each.append(scaled_wrench(statics, LoadCase(alone)).ravel())
        live = scaled_wrench(statics, self.live(place, train))
        if not live.any():
            raise InputError("no axle is on a free block", remedy="give fewer steps")
        return solve_load_factor(
            statics,
            live,
            cone=self.options.cone,
            reserve=sparse.csc_matrix(np.array(each).T) if each else None,
        )

    def result(self, placed: PlacedTrain) -> Result | None:
        """The forces and the mechanism at the limit; None where they are not balanced."""
        found = placed.found
        if not np.isfinite(found.factor):
            return None
        problem = self.problem
        model = problem.model.with_load(self._loaded(placed, found.factor, found.reserve))
        force = problem.force(found.state.force)
        residuals = check_forces(model, force)
        if max(residuals.equilibrium, residuals.tension) > _BALANCED:
            return None
        mechanism = problem.mechanism(found.state.multiplier)
        return Result(
            method="rbe",
            verdict=Verdict.EQUILIBRIUM_EXISTS,
            model=model,
            message="the largest load that forces balance, and how it gives way beyond",
            force=force,
            mechanism=mechanism,
            residuals=residuals,
            solver=found.state.raw.solver,
            iterations=found.state.raw.iterations,
        )

    def falls(self, placed: PlacedTrain) -> bool:
        """Whether the mechanism proves that no forces balance a thousandth more.

        Whatever share of its reserve the fill resists with: the whole where it is moved against.
        """
        problem, found = self.problem, placed.found
        beyond = found.factor + _BEYOND * abs(found.factor)
        for state in (found.state, held_still(problem.statics, found.state)):
            motion = problem.mechanism(state.multiplier)
            against = (self.resisting[self.resisted] * motion[self.resisted]).sum(axis=1) < 0.0
            load = self._loaded(placed, beyond, against.astype(np.float64))
            violation, power = mechanism_defects(problem.model.with_load(load), motion)
            if violation <= MECHANISM_TOLERANCE and power > 0.0:
                return True
        return False

    def _loaded(self, placed: PlacedTrain, factor: float, reserve: Floats) -> LoadCase:
        dead = self.problem.model.load
        wrench = np.zeros_like(dead.wrench)
        wrench[self.resisted] = reserve[:, None] * self.resisting[self.resisted]
        acts = LoadCase(wrench, "what the fill resists") if reserve.any() else None
        load = dead + factor * self.live(placed.place, placed.train)
        return load if acts is None else load + acts
