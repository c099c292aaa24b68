"""The kinematic method: a mechanism as one oscillator, and a part that turns about a line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from drystone.base.arrays import Floats, dot
from drystone.base.display import OneLine
from drystone.geometry.frames import rotation_about
from drystone.loads.case import STANDARD_GRAVITY


@dataclass(frozen=True)
class Oscillator(OneLine):
    """A mechanism as one oscillator.

    Attributes
    ----------
    multiplier
        Alpha 0: the horizontal acceleration by g at which the mechanism begins.
    weight : [N]
        Of all masses that move.
    share
        e*, the share of these masses that takes part.
    reach : [m]
        Mean displacement of the weights at which no push is needed any more; NaN if not known.
    """

    multiplier: float
    weight: float
    share: float
    reach: float

    @classmethod
    def of(cls, multiplier: float, weights: Floats, moved: Floats, reach: float) -> Oscillator:
        """From weights (p,) [N] and their virtual displacements (p,) along the earthquake.

        One weight for each body that moves as a whole, at its centroid, as the Circolare counts
        them: a body that is divided into more blocks is the same oscillator.
        """
        total, first, second = weights.sum(), weights @ moved, weights @ moved**2
        share = float(first**2 / (total * second)) if second > 0.0 else float("nan")
        return cls(multiplier, float(total), share, reach)

    @property
    def mass(self) -> float:
        """M* [kg]."""
        return self.share * self.weight / STANDARD_GRAVITY

    def acceleration(self, confidence: float) -> float:
        """a0* [m/s2]."""
        return self.multiplier * STANDARD_GRAVITY / (self.share * confidence)

    @property
    def displacement(self) -> float:
        """d0* [m]."""
        return self.reach / self.share


@dataclass(frozen=True, eq=False)
class Turning(OneLine):
    """A rigid part that turns about a line.

    Attributes
    ----------
    origin, axis : (3,)
        A point of the line, and its direction: the part turns counter-clockwise about it.
    along : (3,) unit
        Of the earthquake, level.
    place, force : (f, 3) [m, N]
        Forces that keep their direction, where they act on the part.
    couple : (3,) [N m]
    mass_place, weight : (p, 3) [m], (p,) [N]
        Masses that are shaken.
    """

    origin: Floats
    axis: Floats
    along: Floats
    place: Floats
    force: Floats
    couple: Floats
    mass_place: Floats
    weight: Floats

    def _summary(self) -> str:
        return f"about ({', '.join(f'{x:.4g}' for x in self.axis)}), {self.weight.sum():.4g} N"

    def multiplier(self, angle: float) -> float:
        """Alpha [1] at an angle [rad], by virtual work."""
        turn = rotation_about(self.axis, np.rad2deg(angle)).T
        arms = (self.place - self.origin) @ turn
        work = dot(self.force, np.cross(self.axis, arms)).sum() + self.couple @ self.axis
        shaken = self.weight @ (np.cross(self.axis, (self.mass_place - self.origin) @ turn))
        return float(-work / (shaken @ self.along))

    def moved(self, angle: float) -> float:
        """Mean displacement [m] of the weights along the earthquake at an angle [rad]."""
        arms = self.mass_place - self.origin
        away = arms @ rotation_about(self.axis, np.rad2deg(angle)).T - arms
        return float(self.weight @ (away @ self.along) / self.weight.sum())

    @property
    def virtual(self) -> Floats:
        """Virtual displacements (p,) of the masses along the earthquake."""
        turned: Floats = np.cross(self.axis, self.mass_place - self.origin) @ self.along
        return turned

    def overturned(self) -> float:
        """The angle [rad] at which no push is needed any more; NaN where there is none."""
        steps = np.linspace(0.0, 0.5 * np.pi, 181)[:-1]
        values = np.array([self.multiplier(one) for one in steps])
        after = np.flatnonzero(values <= 0.0)
        if not len(after) or after[0] == 0:
            return float("nan")
        end = int(after[0])
        return float(brentq(self.multiplier, steps[end - 1], steps[end], xtol=1e-12))

    def curve(self) -> tuple[Floats, Floats]:
        """Mean displacements [m] and multipliers, both (s,), until it overturns."""
        angles = np.linspace(0.0, np.nan_to_num(self.overturned()), 21)
        moved = np.array([self.moved(one) for one in angles])
        return moved, np.array([self.multiplier(one) for one in angles])

    def oscillator(self) -> Oscillator:
        """The mechanism as one oscillator."""
        end = self.overturned()
        reach = self.moved(end) if np.isfinite(end) else float("nan")
        return Oscillator.of(self.multiplier(0.0), self.weight, self.virtual, reach)
