"""The kinematic method: a mechanism as one oscillator, and a part that turns about a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from drystone.base.arrays import Floats, dot
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.base.table import Table
from drystone.geometry.frames import rotation_about
from drystone.loads.case import STANDARD_GRAVITY


@dataclass(frozen=True, eq=False)
class Oscillator(OneLine):
    """A mechanism as one oscillator.

    Attributes
    ----------
    multiplier
        Alpha 0: the horizontal acceleration by g at which the mechanism begins.
    masses
        The weights P that move, their places and their virtual displacements d along the
        earthquake: one for each body that moves as a whole, at its centroid, as the Circolare
        counts them. A body that is divided into more blocks is the same oscillator.
    reach : [m]
        Mean displacement of the weights at which no push is needed any more; NaN if not known.
    """

    multiplier: float
    masses: Table
    reach: float

    def _summary(self) -> str:
        return f"alpha0={self.multiplier:.4g}, {counted(len(self.masses), 'weight')}"

    @property
    def weight(self) -> float:
        """Of all masses that move [N]."""
        return float(self.masses["P"].sum())

    @property
    def share(self) -> float:
        """e*, the share of these masses that takes part."""
        carried, moved = self.masses["P"], self.masses["d"]
        second = float(carried @ moved**2)
        first = float(carried @ moved)
        return first**2 / (self.weight * second) if second > 0.0 else float("nan")

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
    name, place, force : (f,), (f, 3) [m], (f, 3) [N]
        Forces that keep their direction, where they act on the part.
    couple : (3,) [N m]
    mass_name, mass_place, weight : (p,), (p, 3) [m], (p,) [N]
        Masses that are shaken.
    """

    origin: Floats
    axis: Floats
    along: Floats
    name: tuple[str, ...]
    place: Floats
    force: Floats
    couple: Floats
    mass_name: tuple[str, ...]
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
        moved = np.cross(self.axis, self.mass_place - self.origin) @ self.along
        masses = weights_that_move(self.mass_name, self.weight, self.mass_place, moved)
        return Oscillator(self.multiplier(0.0), masses, reach)

    def moments(self) -> Table:
        """What holds the part and what 1 g turns it by, as moments about the line.

        Each force acts so far behind the line, along the earthquake, and above it there. The sum of
        what holds by that of what turns is alpha 0.
        """
        shaken = self.weight[:, None] * self.along
        force, place = np.vstack([self.force, shaken]), np.vstack([self.place, self.mass_place])
        across = np.cross([0.0, 0.0, 1.0], self.along)
        arm = place - self.origin  # from the point of the line that is along the earthquake
        arm = arm - np.outer(arm @ across / (self.axis @ across), self.axis)
        turned = np.cross(arm, force) @ self.axis
        pushes = np.arange(len(force)) >= len(self.force)
        held, turned = np.where(pushes, 0.0, -turned), np.where(pushes, turned, 0.0)
        names = [*self.name, *(f"1 g on {one}" for one in self.mass_name)]
        if self.couple.any():
            names.append("moments that are applied")
            force, arm = np.vstack([force, np.zeros(3)]), np.vstack([arm, np.full(3, np.nan)])
            held, turned = np.append(held, -self.couple @ self.axis), np.append(turned, 0.0)
        columns = {"of": names, "force": force, "behind": -arm @ self.along, "above": arm[:, 2],
                   "holds": held, "turns": turned}  # fmt: skip
        units = {"force": "N", "behind": "m", "above": "m", "holds": "N m", "turns": "N m"}
        return Table("moments about the line", columns, units)


def weights_that_move(names: Sequence[str], weight: Floats, place: Floats, moved: Floats) -> Table:
    """The table of weights (p,) at places (p, 3) that are moved by (p,), the largest by 1."""
    moved = moved / max(float(np.abs(moved).max(initial=0.0)), 1e-300)
    columns = {"of": list(names), "P": weight, "place": place, "d": moved,
               "P_d": weight * moved, "P_d2": weight * moved**2}  # fmt: skip
    return Table("weights that move", columns, {"P": "N", "place": "m", "P_d": "N", "P_d2": "N"})
