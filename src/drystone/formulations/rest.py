"""The rest state of blocks on unilateral contact springs with Coulomb friction.

For given normal stiffnesses kn and a friction law T the unknowns are the motions q of the free
blocks. With ``d = A' q = (dn, dt)`` at each corner:

    fn = kn max(0, -dn),    ft = -T(fn, dt),    A (fn, ft) + p - g M q = 0

g M is a weak ground spring proportional to mass. Where a rest state exists its share of the load
tends to zero with g; where none exists ``g q`` tends to an acceleration: the blocks that fall.

The contact law is the complementarity ``fn >= 0, s = dn + fn / kn >= 0, fn s = 0``; it is relaxed
to ``fn s = tau`` and followed to tau = 0 by a primal-dual Newton method. Per corner the product
fn s is kept within a band around tau, which replaces the usual ratio test: no corner can block a
step. Some 20 steps are enough for 4 blocks or 10,000.

Sources: complementarity by interior points, Wright 1997; the law as the compatible state of coupled
rigid-block analysis, Kao et al. 2022, eq. 5.6.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from drystone.formulations.friction import FrictionLaw, FrictionResponse, SlipLength, StickSlip
from drystone.geometry.arrays import Floats
from drystone.statics import Statics


@dataclass(frozen=True, eq=False)
class Compliance:
    """Assumed stiffness of the corners, in scaled units.

    Attributes
    ----------
    normal : (k,) kn
    friction : law of the tangential force
    """

    normal: Floats
    friction: FrictionLaw


@dataclass(frozen=True)
class RestOptions:
    """Numerics of :func:`find_rest`; all dimensionless.

    Attributes
    ----------
    ground
        g: share of the mean weight that the ground takes per unit of scaled displacement.
    relaxation
        Relative tau to stop at.
    tolerance
        Largest unbalanced wrench of a block, by the forces that act on it.
    iteration_limit
        Newton steps, each one sparse factorisation.
    band
        Products fn s are kept between band * tau and tau / band. Chosen: wide enough that a cut of
        tau moves nothing.
    warm_relaxation
        tau to begin with from a given start.
    """

    ground: float = 1e-8
    relaxation: float = 1e-22
    tolerance: float = 1e-10
    iteration_limit: int = 80
    band: float = 1e-3
    warm_relaxation: float = 1e-4


@dataclass(frozen=True, eq=False)
class RestState:
    """Where the iteration ended.

    Attributes
    ----------
    motion : (n, 6) q
    normal : (k,) fn, strictly positive (relaxed)
    force : (k, 3) the unrelaxed law at q
    ground : (n, 6) wrench of the ground springs, g M q
    unbalanced
        Largest unbalanced wrench of a block under ``force`` and the ground springs, by the
        forces that act on it.
    converged
    iterations
    """

    motion: Floats
    normal: Floats
    force: Floats
    ground: Floats
    unbalanced: float
    converged: bool
    iterations: int
    history: tuple[float, ...] = field(default=(), repr=False)


def uniform_compliance(
    statics: Statics, *, slip: float | None = None, tangential: float = 0.1
) -> Compliance:
    """Normal stiffness proportional to tributary area, the same everywhere.

    Parameters
    ----------
    statics
    slip
        Slip length by the local overlap for the smooth law; left out, the stick-slip law is used.
    tangential
        kt / kn of the stick-slip law. Chosen: 0.1 keeps friction below its limit wherever it can.
    """
    normal = normal_stiffness(statics)
    if slip is None:
        return Compliance(normal, StickSlip(statics.friction, tangential * normal))
    reach = slip * corner_load(statics) / normal
    return Compliance(normal, SlipLength(statics.friction, reach))


def normal_stiffness(statics: Statics) -> Floats:
    """Tributary area, no less than 5 % of the interface's mean, and never zero.

    Slivers spoil the conditioning; lines and points have no area at all.
    """
    area = statics.tributary
    if not len(area):
        return area
    count = np.bincount(statics.interface)
    mean = np.bincount(statics.interface, area) / np.maximum(count, 1)
    floor = np.maximum(0.05 * mean[statics.interface], 1e-3 * np.median(area))
    return np.maximum(np.maximum(area, floor), 1e-9)


def corner_load(statics: Statics) -> Floats:
    """Typical force (k,) of a corner: the load of the lighter of its free blocks."""
    load = np.linalg.norm(statics.load[:, :3], axis=1) + np.linalg.norm(statics.load[:, 3:], axis=1)
    load = np.append(np.where(load > 0.0, load, 1.0), np.inf)
    return np.minimum(load[statics.block_a], load[statics.block_b])


def mass_matrix(statics: Statics) -> Floats:
    """Diagonal (n, 6) of the ground spring: mass, and mass times radius of gyration squared."""
    turning = statics.mass * statics.inertia
    return np.stack([statics.mass] * 3 + [turning] * 3, axis=1)


def find_rest(
    statics: Statics,
    compliance: Compliance,
    options: RestOptions | None = None,
    *,
    start: RestState | None = None,
    stop: Callable[[], bool] | None = None,
) -> RestState:
    """Follow the relaxed contact law to a rest state.

    Parameters
    ----------
    statics
        No corner may join two fixed blocks.
    compliance
    options
    start
        A state of a neighbouring problem.
    stop
        Asked before every step; True ends the iteration with what is there.
    """
    chosen = options if options is not None else RestOptions()
    return _Path(statics, compliance, chosen).follow(start, stop)


class _Path:
    """One run of the primal-dual iteration; holds what does not change on the way."""

    def __init__(self, statics: Statics, compliance: Compliance, options: RestOptions) -> None:
        self.statics = statics
        self.law = compliance.friction
        self.kn = compliance.normal
        self.options = options
        self.mass = mass_matrix(statics)
        load = corner_load(statics)
        self.unit = load**2 / self.kn
        self.row_scale = _block_magnitude(statics.load)

    def follow(self, start: RestState | None, stop: Callable[[], bool] | None) -> RestState:
        options = self.options
        statics = self.statics
        if start is None:
            motion = np.zeros((statics.free_count, 6))
            tau = 1.0
            normal = self.relaxed_normal(np.zeros(statics.corner_count), tau * self.unit)
        else:
            motion, tau = start.motion, options.warm_relaxation
            gap = statics.displacement(motion)[:, 0]
            normal = np.clip(start.normal, *self.limits(gap, tau))
        history: list[float] = []
        converged, iterations, stalled = False, 0, 0
        state = self.evaluate(motion, normal, tau)
        while iterations < options.iteration_limit and not (stop is not None and stop()):
            history.append(state.merit)
            if tau <= options.relaxation or state.merit < 1e-6:
                exact = self.unrelaxed(state.motion, history, iterations, False)
                if exact.unbalanced <= options.tolerance:
                    converged = True
                    break
            iterations += 1
            step = self.newton_step(state, tau)
            following, length = self.search(state, step, tau)
            reduced = following.merit < 0.1 * state.merit
            stalled = stalled + 1 if length < 0.01 else 0
            state = following
            if stalled > 8:
                break
            if state.merit < tau * np.sqrt(len(normal) + 1.0) or (length > 0.9 and reduced):
                # near the end of the path the error left is far below tau: cut deeper
                cut = 0.1 if tau > 1e-6 else 0.01
                tau = max(cut * tau, options.relaxation)
                state = self.evaluate(state.motion, state.normal, tau)
            elif state.merit < 1e-11:
                tau = max(0.01 * tau, options.relaxation)
                state = self.evaluate(state.motion, state.normal, tau)
        return replace(
            self.unrelaxed(state.motion, history, iterations, converged), normal=state.normal
        )

    def limits(self, gap: Floats, tau: float) -> tuple[Floats, Floats]:
        """Normal forces between which the product fn s stays in the band around tau."""
        band = self.options.band
        return (
            self.relaxed_normal(gap, band * tau * self.unit),
            self.relaxed_normal(gap, tau / band * self.unit),
        )

    def relaxed_normal(self, gap: Floats, product: Floats) -> Floats:
        """The positive root fn of ``fn (gap + fn / kn) = product``, without cancellation."""
        root = np.sqrt(gap**2 + 4.0 * product / self.kn)
        pressing = gap < 0.0
        return np.where(
            pressing, 0.5 * self.kn * (root - gap), 2.0 * product / (root + np.abs(gap) + 1e-300)
        )

    def evaluate(self, motion: Floats, normal: Floats, tau: float) -> _Point:
        statics = self.statics
        moved = statics.displacement(motion)
        friction = self.law(normal, moved[:, 1:])
        force = np.concatenate([normal[:, None], -friction.force], axis=1)
        unbalanced = statics.wrench(force) + statics.load - self.options.ground * self.mass * motion
        slack = moved[:, 0] + normal / self.kn
        centring = (normal * slack) / self.unit - tau
        merit = float(
            np.sqrt(((unbalanced / self.row_scale[:, None]) ** 2).sum() + (centring**2).sum())
        )
        return _Point(motion, normal, moved, friction, unbalanced, slack, merit)

    def newton_step(self, point: _Point, tau: float) -> tuple[Floats, Floats, Floats]:
        statics = self.statics
        rigidity = point.slack + point.normal / self.kn
        stiffness = point.normal / rigidity
        shift = (tau * self.unit - point.normal * point.slack) / rigidity
        by_normal = point.friction.by_normal
        tangent = np.zeros((len(stiffness), 3, 3))
        tangent[:, 0, 0] = stiffness
        tangent[:, 1:, 0] = -by_normal * stiffness[:, None]
        tangent[:, 1:, 1:] = point.friction.by_slide
        correction = np.concatenate([shift[:, None], -by_normal * shift[:, None]], axis=1)
        right = point.unbalanced + statics.wrench(correction)
        motion = self.solve(tangent, right)
        moved = statics.displacement(motion)
        return motion, moved, shift - stiffness * moved[:, 0]

    def solve(self, tangent: Floats, right: Floats) -> Floats:
        """``(A D A' + g M) x = right`` for block-diagonal D (k, 3, 3)."""
        statics = self.statics
        k = statics.corner_count
        blocks = sparse.bsr_matrix((tangent, np.arange(k), np.arange(k + 1)), shape=(3 * k, 3 * k))
        diagonal = sparse.diags((self.options.ground * self.mass).ravel() + 1e-14)
        matrix = (statics.matrix @ blocks @ statics.matrix_transposed + diagonal).tocsc()
        factor = splu(
            matrix,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=1e-3,
            options={"SymmetricMode": True},
        )
        solution: Floats = factor.solve(right.ravel()).reshape(-1, 6)
        return solution

    def search(
        self, point: _Point, step: tuple[Floats, Floats, Floats], tau: float
    ) -> tuple[_Point, float]:
        """Halve the step until the merit falls; the last try is taken in any case."""
        motion, moved, normal = step
        length = 1.0
        while True:
            gap = point.moved[:, 0] + length * moved[:, 0]
            target = np.clip(point.normal + length * normal, *self.limits(gap, tau))
            trial = self.evaluate(point.motion + length * motion, target, tau)
            if trial.merit < (1.0 - 1e-4 * length) * point.merit or length < 2e-3:
                return trial, length
            length *= 0.5

    def unrelaxed(
        self, motion: Floats, history: list[float], iterations: int, converged: bool
    ) -> RestState:
        statics = self.statics
        moved = statics.displacement(motion)
        normal = self.kn * np.maximum(0.0, -moved[:, 0])
        force = np.concatenate([normal[:, None], -self.law(normal, moved[:, 1:]).force], axis=1)
        ground = self.options.ground * self.mass * motion
        rest = statics.wrench(force) + statics.load - ground
        unbalanced = float((_block_magnitude(rest, 0.0) / block_scale(statics, force)).max())
        return RestState(
            motion, normal, force, ground, unbalanced, converged, iterations, tuple(history)
        )


@dataclass(frozen=True, eq=False)
class _Point:
    motion: Floats
    normal: Floats
    moved: Floats
    friction: FrictionResponse
    unbalanced: Floats
    slack: Floats
    merit: float


def _block_magnitude(wrench: Floats, empty: float = 1.0) -> Floats:
    size = np.linalg.norm(wrench[:, :3], axis=1) + np.linalg.norm(wrench[:, 3:], axis=1)
    return np.where(size > 0.0, size, empty)


def block_scale(statics: Statics, force: Floats) -> Floats:
    """(n,) what acts on each block: its load and the corner forces on it."""
    size = np.linalg.norm(force, axis=1)
    total = _block_magnitude(statics.load, 0.0)
    for block in (statics.block_a, statics.block_b):
        here = block >= 0
        total = total + np.bincount(block[here], size[here], minlength=statics.free_count)
    return np.where(total > 0.0, total, 1.0)
