"""Friction laws of a compliant contact: force from slide, with derivatives.

A law gives the tangential force ``ft = -T(fn, dt)`` that opposes the slide ``dt``. Every law here
keeps inside the Coulomb cone, ``|T| <= mu fn``, and points along ``dt``: whatever rest state it
leads to satisfies the friction conditions of coupled rigid-block analysis (Kao et al. 2022,
eq. 5.6: ``ft = -alpha dt``, ``alpha >= 0``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.geometry.arrays import Floats


@dataclass(frozen=True, eq=False)
class FrictionResponse:
    """Tangential force and its derivatives, per corner.

    Attributes
    ----------
    force : (k, 2) T
    by_slide : (k, 2, 2) dT / d dt
    by_normal : (k, 2) dT / d fn
    """

    force: Floats
    by_slide: Floats
    by_normal: Floats


@dataclass(frozen=True, eq=False)
class SlipLength:
    """``T = mu fn dt / sqrt(delta^2 + |dt|^2)``: smooth, and proportional to the normal force.

    Attributes
    ----------
    friction : (k,) mu
    slip : (k,) delta, the slide at which 71 % of the friction is mobilised
    """

    friction: Floats
    slip: Floats

    def __call__(self, normal: Floats, slide: Floats) -> FrictionResponse:
        """Response to normal forces (k,) and slides (k, 2)."""
        reach = np.sqrt(self.slip**2 + slide[:, 0] ** 2 + slide[:, 1] ** 2)
        direction = slide / reach[:, None]
        stiffness = self.friction * normal / reach
        by_slide = stiffness[:, None, None] * (
            np.eye(2) - direction[:, :, None] * direction[:, None, :]
        )
        by_normal = self.friction[:, None] * direction
        return FrictionResponse(normal[:, None] * by_normal, by_slide, by_normal)


@dataclass(frozen=True, eq=False)
class StickSlip:
    """``T = kt dt`` while that is inside the cone, else ``mu fn dt / |dt|``: elastic, then Coulomb.

    This is the law of discrete-element programs (Cundall 1971).

    Attributes
    ----------
    friction : (k,) mu
    stiffness : (k,) kt
    """

    friction: Floats
    stiffness: Floats

    def __call__(self, normal: Floats, slide: Floats) -> FrictionResponse:
        """Response to normal forces (k,) and slides (k, 2)."""
        length = np.sqrt(slide[:, 0] ** 2 + slide[:, 1] ** 2)
        bound = self.friction * normal
        slips = self.stiffness * length > bound
        safe = np.where(length > 0.0, length, 1.0)
        direction = slide / safe[:, None]
        secant = np.where(slips, bound / safe, self.stiffness)
        across = direction[:, :, None] * direction[:, None, :]
        by_slide = secant[:, None, None] * (np.eye(2) - slips[:, None, None] * across)
        by_normal = (slips * self.friction)[:, None] * direction
        return FrictionResponse(secant[:, None] * slide, by_slide, by_normal)


FrictionLaw = SlipLength | StickSlip
