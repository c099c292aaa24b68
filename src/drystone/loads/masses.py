"""Masses that blocks carry: fill, masses in kg, and weights that are told to be shaken."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, Ints, frozen_floats
from drystone.base.display import OneLine
from drystone.loads.placing import filled


@dataclass(frozen=True, eq=False)
class CarriedMass(OneLine):
    """Masses that move with the blocks on which they lie.

    Attributes
    ----------
    kind
        ``fill``, ``resisting fill`` (beyond its pressure), ``mass`` or ``load``.
    mass : (n,) [kg]
        On each block.
    moment : (n, 3) [kg m]
        Mass times its place, from the centroid of the block.
    gravity, shake : (3,) [m/s2]
        Of them: their forces by these are among those of a load case.
    """

    kind: str
    mass: Floats
    moment: Floats
    gravity: Floats
    shake: Floats = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", frozen_floats(self.mass, (None,), "mass"))
        moment = frozen_floats(self.moment, (len(self.mass), 3), "moment")
        object.__setattr__(self, "moment", moment)
        for name in ("gravity", "shake"):
            object.__setattr__(self, name, frozen_floats(getattr(self, name), (3,), name))

    def _summary(self) -> str:
        return f"{self.kind}, {self.mass.sum():.4g} kg"

    @classmethod
    def at(
        cls,
        assembly: Assembly,
        kind: str,
        block: Ints,
        mass: Floats,
        place: Floats,
        gravity: Floats,
    ) -> CarriedMass:
        """Those of some masses (p,) [kg] on blocks (p,) at places (p, 3) [m]."""
        count = len(assembly)
        moment = np.zeros((count, 3))
        np.add.at(moment, block, mass[:, None] * (place - assembly.centroid[block]))
        total: Floats = np.bincount(block, mass, count).astype(np.float64)
        return cls(kind, total, moment, gravity)

    @property
    def wrench(self) -> Floats:
        """Their wrenches (n, 6)."""
        return self.pushed(self.gravity + self.shake)

    def pushed(self, acceleration: Floats) -> Floats:
        """Wrenches (n, 6) of an acceleration (3,) [m/s2] of them."""
        turned = np.cross(self.moment, acceleration)
        return np.column_stack([self.mass[:, None] * acceleration, turned])

    def place(self, assembly: Assembly) -> Floats:
        """Their middle (n, 3) [m] on each block; its centroid where there are none."""
        by = np.where(self.mass == 0.0, 1.0, self.mass)
        return np.asarray(assembly.centroid + self.moment / by[:, None])

    def shaken(self, more: Floats) -> CarriedMass:
        """The same with one more acceleration (3,) [m/s2] of an earthquake."""
        return replace(self, shake=self.shake + more)

    def turned(self, rotation: Floats) -> CarriedMass:
        """The same in the axes of a model that was turned by a matrix (3, 3)."""
        return replace(self, gravity=self.gravity @ rotation, shake=self.shake @ rotation)

    def by(self, factor: float) -> CarriedMass:
        """The same times a factor."""
        return replace(self, mass=factor * self.mass, moment=factor * self.moment)

    def weighing_by(self, g: float) -> CarriedMass:
        """Masses that weigh the same by another gravity [m/s2]."""
        less = g / float(np.linalg.norm(self.gravity))
        return replace(self.by(1.0 / less), gravity=less * self.gravity)

    def of_blocks(self, chosen: Ints, count: int, shift: Floats | float = 0.0) -> CarriedMass:
        """Those of some blocks, the first of ``count``; ``shift`` (c, 3) [m] is added to places."""
        moment = filled(self.moment[chosen] + self.mass[chosen, None] * shift, count)
        return replace(self, mass=filled(self.mass[chosen], count), moment=moment)
