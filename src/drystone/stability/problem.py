"""The model of an analysis, its conversion to physical numbers, and proofs that it falls."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, dot, lengths, marked
from drystone.base.ragged import linked
from drystone.checks import (
    FORCE_TOLERANCE,
    accelerations,
    block_speed,
    check_forces,
    corner_motions,
    mechanism_defects,
    normalised,
)
from drystone.contacts import Contacts
from drystone.formulations.equilibrium import EquilibriumSolution, held_still
from drystone.mechanics.bodies import LIGHT
from drystone.mechanics.increments import FEW
from drystone.mechanics.rest_state import RestState
from drystone.mechanics.statics import Statics, build_statics
from drystone.model import Model
from drystone.results import Result, Samples, Verdict

APPROACH = 1e-3
"""A corner is pressed when free blocks approach it by more than this share of their speed: it then
overlaps by as much of their motion, and the source bounds slides by a thousand overlaps."""

NO_APPROACH = 1e-7
"""The same for faces along which blocks fall freely: less is rounding of their coordinates."""


def closing_blocks(assembly: Assembly, contacts: Contacts, motion: Floats) -> Bools:
    """The blocks (n,) of which a corner closes by a share of their way in a motion (n, 6)."""
    away_a, away_b = _along_normals(assembly, contacts, motion)
    speed = block_speed(assembly, motion)
    found = np.zeros(len(assembly), dtype=bool)
    blocks = contacts.corner_blocks
    found[blocks[away_b - away_a < -APPROACH * speed[blocks]]] = True
    return found


def _along_normals(assembly: Assembly, contacts: Contacts, motion: Floats) -> Floats:
    """(2, k) motion of each corner along the normal of its joint, with block a and with block b."""
    moved = corner_motions(assembly, contacts, motion)
    return dot(moved, contacts.frame[contacts.interface, 0])


def beside_supports(assembly: Assembly, contacts: Contacts, falling: Bools) -> bool:
    """Whether blocks (n,) that fall touch none but each other and supports.

    A free block that stands without them may still settle against them.
    """
    a, b = contacts.block_a, contacts.block_b
    other = np.where(falling[a], b, a)[falling[a] != falling[b]]
    return bool(assembly.fixed[other].all())


@dataclass(frozen=True, eq=False)
class Problem:
    """A model, and its statics without the interfaces between two fixed blocks."""

    model: Model

    @classmethod
    def build(cls, model: Model) -> Problem:
        """The problem of a model.

        Raises
        ------
        InputError
            The load moves supports.
        """
        model.require_still()
        return cls(model)

    @cached_property
    def corners(self) -> Bools:
        """(k,) corners that take part."""
        return self.model.active[self.model.contacts.interface]

    @cached_property
    def statics(self) -> Statics:
        """Built where they are needed: what falls freely is known without."""
        contacts, active = self.model.contacts, self.model.active
        return build_statics(self.model, contacts if active.all() else contacts.select(active))

    @classmethod
    def of(cls, given: Model | Problem) -> Problem:
        """A problem as it is, or that of a model."""
        return given if isinstance(given, Problem) else cls.build(given)

    def without(self, falling: Bools) -> Problem | None:
        """The model without some blocks (n,); None if no free block is left."""
        if self.model.assembly.fixed[~falling].all():
            return None
        return Problem.build(self.model.without(np.flatnonzero(falling).tolist()))

    def with_others_fixed(self, free: Bools) -> Problem:
        """The same model with all blocks but some (n,) fixed."""
        fixed = np.flatnonzero(~free).tolist()
        return Problem.build(replace(self.model, assembly=self.model.assembly.with_fixed(fixed)))

    def with_felt(self, force: Floats) -> Problem | None:
        """The same for blocks that feel some forces (k, 3) [N].

        The joints of those that feel hardly any are softer; None where no block differs so much.
        """
        statics = self.statics.with_felt(force[self.corners] / self.statics.force_unit)
        other = replace(self)
        vars(other)["statics"] = statics
        return None if statics is None else other

    def __getstate__(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("model", "corners", "statics")}

    @property
    def equilibrium_first(self) -> bool:
        """Whether it is cheaper to ask first whether any forces balance the loads.

        Of a small model with dry joints the nearest mechanism takes as long as a third of the path
        to a rest state; where there is no rest state, that path takes twice as long.
        """
        return self.statics.dry and self.statics.free_count <= FEW

    @property
    def has_light(self) -> bool:
        """Whether the load of a block is hardly any of the mean one."""
        return bool(self.statics.load_size.min() < LIGHT)

    @cached_property
    def acceleration(self) -> Floats:
        """Acceleration (n, 6) of each free block under its load alone."""
        return accelerations(self.model.assembly, self.model.load.wrench)

    @cached_property
    def unpressed(self) -> Bools:
        """The free blocks (n,) on which nothing presses."""
        return self.approaching_none(APPROACH)

    def approaching_none(self, least: float) -> Bools:
        """The largest set (n,) of free blocks whose free motion approaches no corner.

        Blocks outside the set rest.

        Parameters
        ----------
        least
            Share of its speed by which a block that is pressed approaches a corner. A block at a
            joint that is not dry counts as pressed.
        """
        assembly, contacts = self.model.assembly, self.model.contacts
        opening, speed = self._free_opening
        falling = ~assembly.fixed & (speed > 0.0)
        a, b, joint = contacts.block_a, contacts.block_b, contacts.interface
        reach = np.array([np.maximum(speed[a], speed[b]), speed[a], speed[b]])
        near = opening < -least * reach[:, joint]
        near |= ~contacts.dry[joint]  # a joint that pulls or coheres need not be pressed
        both, only_a, only_b = contacts.corners.any(near.T).T
        pressed = both & falling[a] & falling[b]
        falling[a[pressed]] = falling[b[pressed]] = False
        rests, loose = np.append(b[only_a], a[only_b]), np.append(a[only_a], b[only_b])
        while (pressed := falling[loose] & ~falling[rests]).any():
            falling[loose[pressed]] = False
        return falling

    @cached_property
    def _free_opening(self) -> tuple[Floats, Floats]:
        """What opens (3, k) if both blocks, a or b fall freely; and the speed of each block."""
        assembly = self.model.assembly
        of_a, of_b = _along_normals(assembly, self.model.contacts, self.acceleration)
        return np.array([of_b - of_a, -of_a, of_b]), block_speed(assembly, self.acceleration)

    def force(self, scaled: Floats) -> Floats:
        """Physical values (k, c) [N] of all corners from scaled ones of those that take part."""
        out = np.zeros((self.model.contacts.corner_count, scaled.shape[1]))
        out[self.corners] = self.statics.physical_force(scaled)
        return out

    def wrench(self, scaled: Floats) -> Floats:
        """Physical wrenches (n, 6) [N, N m] of all blocks."""
        return self.statics.physical_wrench(scaled, len(self.model.assembly))

    def displacement(self, scaled: Floats) -> Floats:
        """Virtual motion (n, 6) [m, rad] for a displacement unit of the mean block size."""
        return self.statics.physical_motion(
            scaled, len(self.model.assembly), self.statics.mean_length
        )

    def mechanism(self, scaled: Floats) -> Floats:
        """Motion (n, 6) whose fastest block moves by the mean size of a block."""
        return self.normalised(self.displacement(scaled))

    def normalised(self, motion: Floats) -> Floats:
        """The same physical motion, its fastest block moving by the mean size of a block."""
        return normalised(self.model.assembly, motion)

    def slides_by_overlap(self, displacement: Floats, times: float) -> bool:
        """Whether a pressed corner slides so many times the largest overlap of its part.

        What stands beside a part and does not touch it says nothing of it. The overlap at a block
        is no larger than that of its part: mostly it is enough already, and soon known.

        Parameters
        ----------
        displacement : (n, 6) [m, rad]
        times
        """
        statics = self.statics
        moved = statics.displacement(statics.scaled_motion(displacement, statics.mean_length))
        pressed = moved[:, 0] < 0.0
        a, b = statics.block_a, statics.block_b
        block, overlap = np.maximum(a, b)[pressed], -moved[pressed, 0]
        slide = lengths(moved[pressed, 1:])

        def within(group: Ints) -> bool:
            most = np.zeros(statics.free_count)
            np.maximum.at(most, group, overlap)
            return bool((slide <= times * most[group]).all())

        if within(block):
            return False
        touch = (a >= 0) & (b >= 0)
        return not within(linked(a[touch], b[touch], statics.free_count)[block])

    def ground_share(self, ground: Floats) -> Floats:
        """Share (n free,) of each block's load that the ground springs (n free, 6) carry."""
        load = self.statics.load
        size = np.linalg.norm(load[:, :3], axis=1) + np.linalg.norm(load[:, 3:], axis=1)
        carried = np.linalg.norm(ground[:, :3], axis=1) + np.linalg.norm(ground[:, 3:], axis=1)
        return carried / np.where(size > 0.0, size, 1.0)


UNBALANCED = "no contact forces can balance the loads"

MECHANISM_TOLERANCE = 1e-5
"""Largest closing of a gap in a claimed mechanism, by the speed of its blocks: ten times what the
certificates of the interior point come to on slender overlaps. A first motion is blurred by the
compliance of the contacts: about 1e-7, the weakness of the ground, times the stiffness."""

FALLING_SHARE = 1e-3
"""A block falls when it moves, or leans on the ground springs, more than this share of the one that
does so most."""


def sound_mechanism(problem: Problem, velocity: Floats) -> Floats | None:
    """A scaled velocity (n, 6) of the free blocks as a physical mechanism, if it is one.

    It is a proof whatever found it: every corner opens at least as fast as friction times its
    slide, and the loads do work.
    """
    largest = float(np.abs(velocity).max(initial=0.0))
    if not 0.0 < largest < np.inf:
        return None
    # the size of a certificate is arbitrary, and its square may overflow
    motion = problem.mechanism(velocity / largest)
    return motion if proves_fall(problem.model, motion) else None


def proves_fall(model: Model, motion: Floats) -> bool:
    """Whether a motion (n, 6) is a collapse mechanism of a model."""
    violation, power = mechanism_defects(model, motion)
    return violation <= MECHANISM_TOLERANCE and power > 1e-9


def checked_mechanism(problem: Problem, solution: EquilibriumSolution) -> Floats | None:
    """The multiplier of an infeasible equilibrium as a physical mechanism, if it is one.

    Beside blocks that hardly move its rounding counts as closing: these are then held still.
    """
    found = sound_mechanism(problem, solution.multiplier)
    if found is None:
        found = sound_mechanism(problem, held_still(problem.statics, solution).multiplier)
    return found


def balanced(problem: Problem, force: Floats) -> bool:
    """Whether scaled corner forces (k, 3) balance the loads within friction, without pull."""
    if not np.isfinite(force).all():
        return False
    found = check_forces(problem.model, problem.force(force))
    return max(found.equilibrium, found.tension, found.cone) <= FORCE_TOLERANCE


def moving_blocks(assembly: Assembly, mechanism: Floats | None) -> tuple[int, ...]:
    """Positions of the blocks that take part in a mechanism (n, 6), if there is one."""
    if mechanism is None:
        return ()
    speed = block_speed(assembly, mechanism)
    return tuple(int(i) for i in np.flatnonzero(speed > FALLING_SHARE * speed.max(initial=0.0)))


def part_of_fall(found: Result) -> Bools:
    """The blocks (n,) that fall or take part in the motion that proves it."""
    moving = marked(list(found.falling), len(found.assembly))
    moving[list(moving_blocks(found.assembly, found.mechanism))] = True
    return moving


def withdrawn(found: Result, message: str) -> Result:
    """UNDECIDED in place of a fall whose proof does not hold, and nothing of that proof."""
    return replace(
        found,
        verdict=Verdict.UNDECIDED,
        message=message,
        mechanism=None,
        prop=None,
        force_with_props=None,
        falling=(),
    )


def undone(found: Result, message: str) -> Result:
    """UNDECIDED in place of any verdict, and nothing of what showed it."""
    return replace(
        withdrawn(found, message),
        force=None,
        displacement=None,
        residuals=None,
        settlement=None,
        samples=Samples(),
        sensitive_to=(),
    )


def first_motion(problem: Problem, state: RestState) -> Floats | None:
    """The motion (n, 6) with which a state on weak ground springs begins to fall, if it is one.

    The ground carries what the contacts do not, ``g M q = p + A f``: an acceleration. Checked from
    points and cross products: that equation, friction in its cone and against the slide, no pull;
    and of the blocks that move, that no gap closes and that the loads do work.
    """
    share = problem.ground_share(state.ground)
    moving = (share > FALLING_SHARE * share.max())[:, None]
    motion = problem.mechanism(np.where(moving, state.motion, 0.0))
    residuals = check_forces(
        problem.model,
        problem.force(state.force),
        problem.displacement(state.motion),
        prop=-problem.wrench(state.ground),
    )
    left = (residuals.equilibrium, residuals.tension, residuals.cone, residuals.alignment)
    dry = problem.model.with_capacity(None).with_friction(0.0)
    violation, power = mechanism_defects(dry, motion)
    admissible = violation <= MECHANISM_TOLERANCE and power > 0.0
    return motion if admissible and max(left) <= MECHANISM_TOLERANCE else None
