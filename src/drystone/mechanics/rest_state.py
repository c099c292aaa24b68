"""Rest states, initial states and options of the iteration."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.mechanics.law import Compliance
from drystone.mechanics.statics import Statics

STALL = 20
"""Steps without progress. Measured: of 1,143 converging runs, near and far from the limits of their
models, 11 had more."""


@dataclass(frozen=True)
class RestOptions:
    """Options of :func:`find_rest`; all dimensionless.

    Attributes
    ----------
    ground
        g: share of the mean weight that the ground takes per unit of scaled displacement.
    relaxation
        Relative tau to stop at.
    tolerance
        Largest unbalanced wrench of a block, by the forces that act on it.
    iteration_limit
        Largest number of Newton steps; each is one sparse factorisation.
    band
        Products fn s are kept between band * tau and tau / band. The band is wider than one
        reduction of tau.
    warm_relaxation
        First tau from a given start.
    stall
        Steps at one tau that do not halve the merit function, after which the iteration stops.
    give_up
        The iteration stops if a step must be reduced below this share.
    polish
        Relative tau at which the unrelaxed law is tried first. Measured: walls, vaults and domes at
        rest take 9 to 14 factorisations from nothing where they took 11 to 22 with 1e-7.
    end
        Ground and tolerance of the first try of the unrelaxed law, where the ground carries little.
        With weaker ground, the state that is found there is the last one. Other options are not
        used.
    """

    ground: float = 1e-8
    relaxation: float = 1e-22
    tolerance: float = 1e-10
    iteration_limit: int = 80
    band: float = 1e-3
    warm_relaxation: float = 1e-4
    stall: int = STALL
    give_up: float = 0.0
    polish: float = 1e-3
    end: RestOptions | None = field(default=None, repr=False)


@dataclass(frozen=True, eq=False)
class Start:
    """Initial state of an iteration.

    Attributes
    ----------
    motion : (n, 6) q
    normal : (k,) fn, zero or more
    """

    motion: Floats
    normal: Floats


@dataclass(frozen=True, eq=False)
class RestState:
    """Result of the iteration.

    Attributes
    ----------
    motion : (n, 6) q
    normal : (k,) fn, strictly positive (relaxed)
    force : (k, 3) the unrelaxed law at q: a corner is either closed or open
    tension : (k,) tension of the glue
    ground : (n, 6) wrench of the ground springs, g M q
    unbalanced
        Largest unbalanced wrench of a block under ``force`` and the ground springs, by the
        forces that act on it.
    converged
    iterations
    ended
        Whether it has the ground and the tolerance of :attr:`RestOptions.end`.
    """

    motion: Floats
    normal: Floats
    force: Floats
    tension: Floats
    ground: Floats
    unbalanced: float
    converged: bool
    iterations: int
    ended: bool = False


def start_from(statics: Statics, compliance: Compliance, motion: Floats) -> Start:
    """A start with the shape of a motion (n, 6), such as the rest state of a similar model.

    Without an initial overlap the contact law is homogeneous of degree one: the motion is scaled so
    that its forces fit the loads best.
    """
    moved = statics.displacement(motion)
    normal = compliance.normal * np.maximum(0.0, -moved[:, 0])
    slide = compliance.friction(normal, moved[:, 1:]).force
    force = np.concatenate([normal[:, None], -slide], axis=1)
    scale = statics.load_scale[:, None]
    carried = statics.wrench(force) / scale
    size = float((carried**2).sum())
    fit = -float((carried * (statics.load / scale)).sum()) / size if size > 0.0 else 0.0
    fit = max(fit, 0.0)
    return Start(fit * motion, fit * normal)


def block_scale(statics: Statics, force: Floats) -> Floats:
    """Size (n,) of the forces on each block: its load and its corner forces (k, 3)."""
    total = statics.load_size + statics.on_blocks(lengths(force))
    total[total <= 0.0] = 1.0
    return total
