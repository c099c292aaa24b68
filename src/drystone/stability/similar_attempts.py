"""Rest states that are looked for from those of similar springs first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import SolverError
from drystone.formulations.rest.compliance import Compliance
from drystone.formulations.rest.friction import SlipLength
from drystone.formulations.rest.rest_state import RestOptions, RestState, Start
from drystone.formulations.rest.same_forces import (
    FAR,
    sliding_share,
    start_of_forces,
    unbalanced_share,
)
from drystone.stability.attempts import Attempts, Candidate, after_newton
from drystone.stability.screening import AT_REST, PROVED

STRAIGHT = replace(AT_REST, iteration_limit=16)
"""From nothing, where the model stands with other stiffnesses: no state on stronger ground is
needed. Measured: far from the limits of their models 8 to 13 steps lead so near that the unrelaxed
law converges. Very near the limits it takes 40, and stronger ground saves some."""

FROM_OTHER = replace(AT_REST, warm_relaxation=1e-4, stall=8, give_up=0.02)
"""From the rest state of other stiffnesses: given up early. Measured: where it converges, on walls
and domes, it takes 6 to 16 steps, from nothing 12 to 18; elsewhere it ends after 3 or 4."""

FROM_PATH = replace(AT_REST, stall=8, give_up=0.02)
"""From the last iterate of the relaxed law with uniform stiffness. With another friction law
Newton's method on the unrelaxed law converges after one to three steps there."""

SLOW = 0.35
"""Share of the merit function after two such steps from which on other normal stiffnesses begin
from nothing. Measured on 15 arches, walls, vaults and domes: 650 factorisations for all stiffnesses
in place of 667 without it, and of 717 without starts on the path."""

HALFWAY = 0.3
"""Unbalanced share of a block up to which the relaxed law begins there, where Newton's method did
not converge."""

NEARLY_RESTS = 0.01
"""Unbalanced share of a block up to which other springs begin at the rest state itself, in place of
its forces. Walls at rest slide nowhere: with every friction law they rest there at once."""

FEW_SLIDE = 0.02
"""Share of the normal force at corners that slide up to which they begin there as well. Where all
stick, the first step of Newton's method is exact. Measured on 11 models, tilted or not: up to 0.019
it takes 0 to 2 factorisations, from the forces 2 to 4; from 0.028 on up to 23, from them 3."""

SHARES = (0.0, 0.5, 1.0)
"""Steps of the stiffness, by the logarithm, from the uniform one to another. Measured on the
bridge and on vaults: of 8 rest states that were not found from the uniform one at once or from
nothing, all are found, in a tenth of the time that it takes to follow the blocks."""

LONGER = (10.0, 3.0)
"""Slip lengths, by its own, that lead to a law whose path did not converge. Chosen: each rest state
of an arch of 100 blocks near its least thickness is then four to seven steps from the last one."""


def _on_path(start: Start, same: bool) -> RestOptions:
    """Options for an iterate of the relaxed law, with the same normal stiffnesses or others."""
    below = 0.5 * (start.relaxation or 1.0)
    return replace(FROM_PATH, polish=below, slow=np.inf if same else SLOW)


class Rest(NamedTuple):
    """A rest state from which another one begins.

    Attributes
    ----------
    displacement : (n, 6) [m, rad]
    same
        Whether the normal stiffnesses are the same. Newton's method on the unrelaxed law reaches
        the other one then in a few steps, or it stops soon.
    path
        The last iterate of the relaxed law before it.
    """

    displacement: Floats
    same: bool
    path: Start | None = None


class SimilarAttempts(Attempts):
    """Tries that begin at rest states of the same model with similar springs."""

    def attempt_from(
        self,
        springs: Compliance,
        rests: Sequence[Rest],
        *,
        lead: bool = False,
        briefly: bool = False,
    ) -> Candidate:
        """As :meth:`attempt`, first from similar rest states.

        With ``lead``, where nothing is found from nothing either, the last of them, of uniform
        stiffness, is led to these springs. ``briefly``: from those states only.
        """
        for one in rests:
            if one.same and not one.path:
                start = self.start(springs, one.displacement)
                found = self.nearby(springs, start, onwards=False)
                if found is not None:
                    return found
        if rests:
            displacement, same, path = rests[-1]
            ways: list[tuple[RestOptions, Start | None]] = []
            if path and not briefly:
                near, onwards = self._with_forces(springs, path, displacement if same else None)
                if near is not None:
                    return near
                ways = [(_on_path(onwards, same), onwards), (STRAIGHT, None)]
            from_other = after_newton(FROM_OTHER) if same and not path else FROM_OTHER
            ways.append((from_other, self.start(springs, displacement)))
            if not path and not briefly:
                ways.append((STRAIGHT, None))
            for options, begin in ways:
                state = self.find(springs, options, begin)
                found = self.stood(state) if state.converged else None
                if found is not None:
                    return found
            if briefly:
                self.tried += 1
                return self.examine(state.motion, state.force)
        afresh = Attempts(self.problem, self.clock)
        found = afresh.attempt(springs)
        if lead and rests and not (found.stands or rests[-1].same):
            led = self._led(springs, rests[-1].displacement)
            if led is not None:
                self.iterations += afresh.iterations
                return led
        self.add(afresh)
        if found.stands or afresh.falling or self.clock.late():
            return found
        return self._by_longer_slips(springs) or found

    def _with_forces(
        self, springs: Compliance, path: Start, rest: Floats | None
    ) -> tuple[Candidate | None, Start]:
        """The rest state that Newton's method reaches from the forces of another one.

        Where these springs nearly rest at the displacement (n, 6) [m, rad] of the other ``rest``
        state, or stick there, it begins there. With the start for the relaxed law where it does not
        converge.
        """
        system = self.problem.system
        if rest is not None:
            statics = system.statics
            motion = statics.scaled_motion(rest, statics.mean_length)
            moved = statics.displacement(motion)
            nearly = unbalanced_share(system, springs, moved) <= NEARLY_RESTS
            if nearly or sliding_share(springs, moved) <= FEW_SLIDE:
                begin = Start(motion, springs.normal * np.maximum(0.0, -moved[:, 0]))
                found = self.nearby(springs, begin, PROVED, onwards=False)
                if found is not None or nearly:
                    return found, path
        try:
            start, steps, share = start_of_forces(system, springs, AT_REST, path)
        except SolverError:
            return None, path
        self.iterations += steps
        if share > FAR:
            return None, path
        found = self.nearby(springs, start, PROVED, onwards=False)
        return found, start if share <= HALFWAY else path

    def _by_longer_slips(self, springs: Compliance) -> Candidate | None:
        """The rest state where a path from nothing did not converge, from those of longer slips.

        With a longer slip friction changes more smoothly, and each rest state is a few steps from
        the next one.
        """
        law = springs.friction
        if not isinstance(law, SlipLength):
            return None
        state: RestState | None = None
        for factor in (*LONGER, 1.0):
            smoother = replace(springs, friction=replace(law, slip=factor * law.slip))
            state = self.find(smoother, AT_REST, state)
            if not state.converged:
                return None
        candidate = None if state is None else self.examine(state.motion, state.force)
        if candidate is None or not candidate.stands:
            return None
        self.standing.append(candidate)
        return candidate

    def _led(self, springs: Compliance, displacement: Floats) -> Candidate | None:
        """The rest state to which one of uniform stiffness leads while the stiffness changes."""
        base = self.problem.statics.normal_stiffness
        for share in SHARES:
            between = replace(springs, normal=base ** (1.0 - share) * springs.normal**share)
            state = self.find(between, AT_REST, self.start(between, displacement))
            candidate = self.examine(state.motion, state.force)
            if not candidate.stands:
                return None
            displacement = candidate.displacement
        return self.stood(state)
