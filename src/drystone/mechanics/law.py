"""The contact law: forces at corners from gaps and slides, with derivatives.

With the gap g, the slide dt, and the friction T0 that is there already:

    fn = kn max(0, -g),    ft = -T,    |T| <= b(fn)

A friction law gives the tangential force T that opposes the slide. Every law here stays within a
:class:`FrictionBound`, which is ``mu fn`` at a dry joint. Where nothing was there before it is
parallel to ``dt``: every rest state satisfies the friction conditions of coupled rigid-block
analysis (Kao et al. 2022, eq. 5.6: ``ft = -alpha dt``, ``alpha >= 0``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Bools, Floats, lengths
from drystone.mechanics.statics import Statics

COHESIVE_FRICTION = 0.1
"""Least friction coefficient in the slip length of cohesive joints: it keeps the length finite."""

MOBILISED = 0.999
"""Share of the bound from which on friction says nothing of how far a corner has slid."""

BLURRED = 0.1
"""How near, by the overlap under its load and what is unbalanced, a corner is about to open or
close. Measured on samples of eight walls and two vaults of 2,000 to 4,500 blocks: from 0 three of
16 samples are given up and begun anew, from 0.05 one, from 0.03, 0.1 and 0.15 none; with 0.1 they
take 126 factorisations, and 141 with 0, which do not end. Where blocks are followed, on 29 arches,
vaults, walls and domes near their limits: 24 take fewer Newton steps, an arch a third, all a tenth
fewer, and all end alike; the dome of 640 blocks at its least friction takes 78 in place of 245."""

FEW_JOINTS = 120
"""Joints up to which a second random distribution is tried. Measured, most near their limits: of
2,535 models with fewer joints it alone does not hold 15; of 533 with more three, which most other
random ones hold as well."""


@dataclass(eq=False)
class FrictionResponse:
    """Tangential force and its derivatives, per corner.

    Attributes
    ----------
    force : (k, 2) T
    slope
        Function that computes the derivatives, since most responses need only the force: with
        respect to slide, dT / d dt (k, 2, 2), and to normal force, dT / d fn (k, 2). When given
        True, those of the secant: with T / dt as it is.
    """

    force: Floats
    slope: Callable[..., tuple[Floats, Floats]]


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
            return self.friction * (normal > 0.0)
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
        along = np.array(slide.T, order="C")  # two components (k,), side by side in memory
        reach = np.sqrt(self.slip**2 + along[0] ** 2 + along[1] ** 2)
        stiffness = self.bound(normal) / reach

        def slope(secant: bool = False) -> tuple[Floats, Floats]:
            way, lost = along / reach, float(not secant)
            growth = lost * self.bound.growth(normal)
            return _across(stiffness, lost * stiffness, *way), (growth * way).T

        return FrictionResponse((stiffness * along).T, slope)

    def slide_of(self, normal: Floats, held: Floats, slide: Floats) -> Floats:
        """The slide (k, 2) at which T is ``held`` (k, 2); ``slide`` where there is no bound."""
        bound = self.bound(normal)
        some = bound > 0.0
        safe = np.where(some, bound, 1.0)
        share = np.minimum(lengths(held) / safe, MOBILISED)
        stiffness = safe * np.sqrt(1.0 - share**2) / self.slip
        return np.where(some[:, None], held / stiffness[:, None], slide)


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
        trial = np.multiply(self.stiffness, slide.T, order="C")
        if before is not None:
            trial += before.T
        square = trial * trial
        size = np.sqrt(square[0] + square[1])
        bound = self.bound(normal)
        slips = size > bound
        size = np.where(size > 0.0, size, 1.0)
        ratio = np.where(slips, bound / size, 1.0)

        def slope(secant: bool = False) -> tuple[Floats, Floats]:
            way, stiffness, lost = trial / size, self.stiffness * ratio, slips & (not secant)
            growth = lost * self.bound.growth(normal)
            return _across(stiffness, stiffness * lost, *way), (growth * way).T

        return FrictionResponse((ratio * trial).T, slope)

    def slide_of(self, normal: Floats, held: Floats, slide: Floats) -> Floats:
        """The slide (k, 2) at which T is ``held`` (k, 2); where it slips, a longer ``slide``."""
        elastic = held / self.stiffness[:, None]
        slips = lengths(held) >= MOBILISED * self.bound(normal)
        longer = slips & (lengths(slide) > lengths(elastic))
        return np.where(longer[:, None], slide, elastic)


def _across(stiffness: Floats, along: Floats, x: Floats, y: Floats) -> Floats:
    """(k, 2, 2) stiffness (k,) in the plane, less some (k,) along a unit direction x, y (k,)."""
    lost = along * x
    out = np.empty((2, 2, *stiffness.shape))
    np.subtract(stiffness, lost * x, out=out[0, 0])
    out[0, 1] = out[1, 0] = -lost * y
    np.subtract(stiffness, along * y * y, out=out[1, 1])
    return out.T


FrictionLaw = SlipLength | StickSlip


@dataclass(frozen=True, eq=False)
class Compliance:
    """Springs at the corners.

    Attributes
    ----------
    normal : (k,) kn
    friction : law of the tangential force
    overlap
        Overlap at which compression begins. Zero for springs. A positive value with stiff springs
        gives all corners in compression equal overlaps, as in eq. 5.6.
    glue
        Stiffness against opening, by kn, of a pull without limit. Zero but in the penalty form.
    tension : (k,)
        Largest pull of each corner. A joint that opens by s pulls with
        ``kn s / sqrt(1 + (kn s / tension)^2)``. ``None`` for dry joints.
    most : (k,)
        Largest force that presses, at which it yields. ``None`` where there is no limit.
    """

    normal: Floats
    friction: FrictionLaw
    overlap: float = 0.0
    glue: float = 0.0
    tension: Floats | None = None
    most: Floats | None = None

    def press(self, gap: Floats) -> tuple[Floats, Floats]:
        """What presses (k,) at gaps (k,) below zero, and its stiffness (k,)."""
        elastic = -self.normal * gap
        if self.most is None:
            return elastic, self.normal
        return np.minimum(elastic, self.most), np.where(elastic < self.most, self.normal, 0.0)

    def pull(self, opening: Floats) -> tuple[Floats, Floats]:
        """Pull (k,) of corners that open by some lengths (k,), zero or more, and its slope (k,)."""
        if self.tension is None:
            return _NOTHING, _NOTHING
        elastic = self.normal * opening
        size = np.sqrt(self.tension**2 + elastic**2)
        share = self.tension / np.where(size > 0.0, size, 1.0)
        return elastic * share, self.normal * share**3

    def gap_of(self, normal: Floats, gap: Floats) -> Floats:
        """The gap (k,) at which the force is ``normal`` (k,), a pull below zero; else ``gap``."""
        pressed = -normal / self.normal
        if self.tension is None:
            return np.where(normal > 0.0, pressed, np.maximum(gap, 0.0))
        pulls = (normal < 0.0) & (self.tension > 0.0)
        share = np.where(pulls, -normal / np.where(pulls, self.tension, 1.0), 0.0)
        opened = pressed / np.sqrt(1.0 - np.minimum(share, MOBILISED) ** 2)
        return np.where(pulls, opened, np.where(normal > 0.0, pressed, np.maximum(gap, 0.0)))

    def resisted(self, bearing: Floats, slide: Floats, before: Floats | None) -> FrictionResponse:
        """Friction at normal forces (k,). Only stick and slip remembers what was before."""
        law = self.friction
        if before is None or not isinstance(law, StickSlip):
            return law(bearing, slide)
        return law(bearing, slide, before)


_NOTHING = np.zeros(1)


@dataclass(eq=False)
class ContactResponse:
    """Forces at corners.

    Attributes
    ----------
    force : (k, 3) local n, u, v, on block b
    gap : (k,)
    tension : (k,) pull of the glue
    """

    force: Floats
    gap: Floats
    tension: Floats
    _friction: FrictionResponse
    _press: Floats
    _pull: Floats
    _glue: Floats

    @property
    def pressed(self) -> Bools:
        """Corners (k,) that blocks press."""
        return self.gap < 0.0

    @property
    def tangent(self) -> Floats:
        """(k, 3, 3) minus the derivative of the force by the displacement of b over a."""
        return self._tangent(self.pressed)

    def blurred(self, width: Floats | float) -> Floats:
        """The same with part of the stiffness of corners within a width (k,) of their change."""
        return self._tangent(0.5 - 0.5 * self.gap / np.hypot(self.gap, width))

    def _tangent(self, pressed: Floats | Bools) -> Floats:
        bearing = pressed * self._press
        out = np.empty((3, 3, *bearing.shape))  # the numbers of many corners lie side by side
        out[0, 0] = bearing
        if self._pull is not _NOTHING or self._glue is not _NOTHING:
            apart = 1.0 - pressed
            bearing += apart * self._pull
            np.add(bearing, apart * self._glue, out=out[0, 0])
        out[0, 1:] = 0.0
        by_slide, by_normal = self._friction.slope()
        np.multiply(-by_normal.T, bearing, out=out[1:, 0])
        out[1:, 1:] = by_slide.transpose(1, 2, 0)
        return out.transpose(2, 0, 1)


def pressing(normal: Floats, friction: FrictionResponse) -> Floats:
    """Forces (k, 3) of normal forces (k,) and friction against the slide."""
    force = np.empty((len(normal), 3))
    force[:, 0] = normal
    np.negative(friction.force, out=force[:, 1:])
    return force


def respond(
    springs: Compliance, gap: Floats, slide: Floats, before: Floats | None = None
) -> ContactResponse:
    """The contact law: ``fn = kn max(0, -g)`` up to the most, less what pulls; friction.

    Parameters
    ----------
    springs
    gap : (k,) g, negative where blocks overlap
    slide : (k, 2) of block b over block a
    before : (k, 2)
        Friction T0 with which the slide began, against it; zero if left out.
    """
    presses, press = springs.press(gap)
    bearing = net = np.maximum(presses, 0.0)
    tension = pull = glue = _NOTHING
    if springs.tension is not None or springs.glue:
        opening = np.maximum(0.0, gap)
        held, pull = springs.pull(opening)
        glue = springs.glue * springs.normal
        bearing, tension = bearing - held, glue * opening
        net = bearing - tension
    friction = springs.resisted(bearing, slide, before)
    force = pressing(net, friction)
    return ContactResponse(force, gap, tension, friction, press, pull, glue)


def uniform(
    statics: Statics, *, slip: float | None = None, tangential: float = 0.1, glue: float = 0.0
) -> Compliance:
    """Normal stiffness proportional to tributary area, with one factor for all joints.

    Parameters
    ----------
    statics
    slip
        Slip length of the smooth law, relative to the local overlap; the stick-slip law when left
        out.
    tangential
        kt / kn of the stick-slip law. With a low value friction stays below its limit where
        possible.
    glue
        Stiffness against opening, by kn.
    """
    normal = statics.normal_stiffness
    law: FrictionLaw = StickSlip(_bound(statics), tangential * normal)
    if slip is not None:
        law = SlipLength(_bound(statics), slip * _slip_load(statics) / normal)
    return Compliance(normal, law, glue=glue, tension=_tension(statics))


def samples(
    statics: Statics,
    count: int,
    seed: int,
    *,
    tangential: float,
) -> tuple[list[Compliance], list[Compliance]]:
    """Other stiffness distributions: alike in all joints with other friction laws, and random ones.

    The first one of all has the springs with which blocks are followed. A random distribution has a
    stiffness within one decade for every interface, like joints of one building, and one slip
    length for all. Over many joints one of them is tried: a second one changed 3 of 533 answers.

    Parameters
    ----------
    statics
    count
        Of them at most.
    seed
    tangential
        kt / kn of the first one.
    """
    slips = (None, 10.0, 0.1, 100.0)[: (count + 1) // 2]
    even = [uniform(statics, slip=slip, tangential=tangential) for slip in slips]
    uneven: list[Compliance] = []
    if count < 2:
        return even, uneven
    rng = np.random.default_rng(seed)
    base = statics.normal_stiffness
    load, bound, tension = _slip_load(statics), _bound(statics), _tension(statics)
    place = statics.interface
    joints = int(place.max(initial=-1)) + 1
    for _ in range(count // 2 if joints <= FEW_JOINTS else 1):
        normal = base * (10.0 ** rng.uniform(-0.5, 0.5, joints))[place]
        law = SlipLength(bound, 10.0 ** rng.uniform(-0.5, 1.0) * load / base)
        uneven.append(Compliance(normal, law, tension=tension))
    return even, uneven


def _bound(statics: Statics) -> FrictionBound:
    if statics.dry:
        return FrictionBound(statics.friction)
    return FrictionBound(statics.friction, statics.cohesion, statics.shear)


def _tension(statics: Statics) -> Floats | None:
    return statics.tension if statics.tension.any() else None


def _slip_load(statics: Statics) -> Floats:
    """The force (k,) by which slip lengths are measured: a joint's cohesion counts as load."""
    divisor = np.maximum(statics.friction, COHESIVE_FRICTION)
    return statics.corner_load + np.minimum(statics.cohesion, statics.shear) / divisor


def wrench_size(wrench: Floats) -> Floats:
    """(..., n) length of the force plus length of the moment of scaled wrenches (..., n, 6)."""
    return lengths(wrench[..., :3]) + lengths(wrench[..., 3:])
