"""Newton's method for equations with corners: one loop for all that comes to rest.

What is solved says how large its residual is, what a step is, and where it leads. Contact laws have
corners, where Newton's method may go back and forth: a step may leave as much as one of the last
few did, and a step that leaves more is halved.

Sources: Qi and Sun 1993 (semismooth equations); Grippo, Lampariello and Lucidi 1986 (non-monotone
line search).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from drystone.base.errors import SolverError


class Point(Protocol):
    """An iterate."""

    @property
    def size(self) -> float:
        """Of what is left."""


P = TypeVar("P", bound=Point)
S = TypeVar("S")


class Equation(Generic[P, S]):
    """What is solved, and when to give up."""

    def tolerance(self, point: P) -> float:
        """Size at which the equation is solved."""
        raise NotImplementedError

    def solved(self, point: P) -> bool:
        """Whether an iterate solves it."""
        return point.size <= self.tolerance(point)

    def lost(self, sizes: Sequence[float], point: P) -> bool:
        """Whether to give up after iterates of these sizes, the last one at ``point``."""
        del sizes, point
        return False

    def step(self, point: P, renew: bool) -> S:
        """The step against what is left; not ``renew``: with the factors of the last one.

        Raises
        ------
        SolverError
            The tangent is singular.
        """
        raise NotImplementedError

    def after(self, point: P, step: S, length: float) -> P:
        """The iterate after a share of a step."""
        raise NotImplementedError

    def accepted(self, point: P, trial: P, length: float) -> P:
        """From where to go on, where a share of a step from ``point`` has led to ``trial``.

        An equation that is relaxed becomes less so here.
        """
        del point, length
        return trial


@dataclass(frozen=True)
class Steps:
    """How the steps are taken.

    Attributes
    ----------
    limit
        Most steps.
    shortest
        Share of a step that is taken whatever it leaves; 1 for full steps.
    memory
        A step may leave as much as the largest of so many last iterates.
    bold
        So many first steps are taken in full if they leave less than 1.
    chords
        Factors are used again where so many steps with them will do, as convergence is quadratic in
        the end.
    idle
        Where two steps have left more than this share, they may change between the same corners:
        the next one is half as long.
    grown
        Times what was left at first from which on it ends.
    """

    limit: int
    shortest: float = 1.0
    memory: int = 4
    bold: int = 0
    chords: int = 1
    idle: float = np.inf
    grown: float = np.inf


SUFFICIENT = 1e-3
"""Share of a step's promise that it has to keep."""


def newton(equation: Equation[P, S], point: P, steps: Steps) -> tuple[P, bool, int]:
    """The last iterate, whether it solves the equation, and the number of steps."""
    sizes = [point.size]
    for number in range(steps.limit):
        if equation.solved(point):
            return point, True, number
        if equation.lost(sizes, point):
            return point, False, number
        # nothing may have been left before the law became less relaxed: then no rate is known
        renew = (
            not number
            or not sizes[-2]
            or sizes[-1] * (sizes[-1] / sizes[-2]) ** steps.chords > equation.tolerance(point)
        )
        try:
            step = equation.step(point, renew)
        except SolverError:
            return point, False, number
        idle = len(sizes) > 3 and sizes[-1] > steps.idle * sizes[-3]
        allowed, length = max(sizes[-steps.memory :]), 0.5 if idle else 1.0
        while True:
            trial = equation.after(point, step, length)
            falls = trial.size < (1.0 - SUFFICIENT * length) * allowed
            if falls or length <= steps.shortest or (number < steps.bold and trial.size < 1.0):
                break
            length *= 0.5
        trial = equation.accepted(point, trial, length)
        if not trial.size < steps.grown * (sizes[0] or 1.0):
            return point, False, number + 1
        point = trial
        sizes.append(point.size)
    return point, False, steps.limit
