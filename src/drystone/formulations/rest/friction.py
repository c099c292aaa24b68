"""Friction laws of a compliant contact: force from slide, with derivatives.

A law gives the tangential force ``ft = -T(fn, dt)`` that opposes the slide ``dt``. Every law here
stays within a :class:`FrictionBound`, which is ``|T| <= mu fn`` at a dry joint, and is parallel to
``dt``: every rest state satisfies the friction conditions of coupled rigid-block analysis (Kao et
al. 2022, eq. 5.6: ``ft = -alpha dt``, ``alpha >= 0``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from drystone.base.arrays import Floats


@dataclass(frozen=True, eq=False)
class FrictionResponse:
    """Tangential force and its derivatives, per corner.

    Attributes
    ----------
    force : (k, 2) T
    slope
        Function that computes the derivatives, since most responses need only the force.
    """

    force: Floats
    slope: Callable[[], tuple[Floats, Floats]]

    @cached_property
    def derivatives(self) -> tuple[Floats, Floats]:
        """With respect to slide, dT / d dt (k, 2, 2), and to normal force, dT / d fn (k, 2)."""
        return self.slope()

    @property
    def by_slide(self) -> Floats:
        """(k, 2, 2) dT / d dt"""
        return self.derivatives[0]

    @property
    def by_normal(self) -> Floats:
        """(k, 2) dT / d fn"""
        return self.derivatives[1]


@dataclass(frozen=True, eq=False)
class FrictionBound:
    """The largest tangential force, ``b = min(mu fn + c, s)`` (Mohr and Coulomb; Tresca's limit).

    Attributes
    ----------
    friction : (k,) mu
    cohesion : (k,) c
    shear : (k,) s
        Both left out: a dry joint, which never pulls.
    """

    friction: Floats
    cohesion: Floats | float = 0.0
    shear: Floats | float = np.inf

    def __call__(self, normal: Floats) -> Floats:
        """B (k,), for normal forces that are negative where the joint pulls."""
        if isinstance(self.cohesion, float):
            return self.friction * normal
        bound = self.friction * normal + self.cohesion
        return np.minimum(np.maximum(bound, 0.0), self.shear)

    def growth(self, normal: Floats) -> Floats:
        """Its derivative (k,) by the normal force."""
        if isinstance(self.cohesion, float):
            return np.where(normal > 0.0, self.friction, 0.0)
        bound = self.friction * normal + self.cohesion
        return np.where((bound > 0.0) & (bound < self.shear), self.friction, 0.0)


@dataclass(frozen=True, eq=False)
class SlipLength:
    """``T = b dt / sqrt(delta^2 + |dt|^2)``: smooth, and proportional to the bound.

    Attributes
    ----------
    bound : b
    slip : (k,) delta, the slide at which 71 % of the bound is mobilised
    """

    bound: FrictionBound
    slip: Floats

    def __call__(self, normal: Floats, slide: Floats) -> FrictionResponse:
        """Response to normal forces (k,) and slides (k, 2)."""
        reach = np.sqrt(self.slip**2 + slide[..., 0] ** 2 + slide[..., 1] ** 2)
        bound = self.bound(normal)
        stiffness = bound / reach

        def slope() -> tuple[Floats, Floats]:
            direction, growth = slide / reach[..., None], self.bound.growth(normal)
            return _across(stiffness, stiffness, direction), growth[..., None] * direction

        return FrictionResponse(stiffness[..., None] * slide, slope)


@dataclass(frozen=True, eq=False)
class StickSlip:
    """``T = T0 + kt dt`` within the bound, else as far along it: elastic, then Coulomb.

    The law of discrete-element programs (Cundall 1971). T0 is what was resisted before; dt is the
    slide since then.

    Attributes
    ----------
    bound : b
    stiffness : (k,) kt
    """

    bound: FrictionBound
    stiffness: Floats

    def __call__(
        self, normal: Floats, slide: Floats, before: Floats | None = None
    ) -> FrictionResponse:
        """Response to normal forces (k,) and slides (k, 2) after T0 (k, 2), zero if left out."""
        trial = self.stiffness[..., None] * slide
        if before is not None:
            trial += before
        size = np.sqrt(trial[..., 0] ** 2 + trial[..., 1] ** 2)
        bound = self.bound(normal)
        slips = size > bound
        safe = np.where(size > 0.0, size, 1.0)
        ratio = np.where(slips, bound / safe, 1.0)

        def slope() -> tuple[Floats, Floats]:
            direction, secant = trial / safe[..., None], self.stiffness * ratio
            return (
                _across(secant, secant * slips, direction),
                (slips * self.bound.growth(normal))[..., None] * direction,
            )

        return FrictionResponse(ratio[..., None] * trial, slope)


def _across(stiffness: Floats, along: Floats, direction: Floats) -> Floats:
    """(k, 2, 2) stiffness (k,) in the plane, less some (k,) along a unit direction (k, 2)."""
    x, y = direction[..., 0], direction[..., 1]
    lost = along * x
    out = np.empty((*stiffness.shape, 2, 2))
    out[..., 0, 0] = stiffness - lost * x
    out[..., 0, 1] = out[..., 1, 0] = -lost * y
    out[..., 1, 1] = stiffness - along * y * y
    return out


FrictionLaw = SlipLength | StickSlip
