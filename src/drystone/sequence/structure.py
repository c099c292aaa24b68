"""The complete structure, and the verdict on its stages.

Blocks that are not connected through free blocks do not influence each other. So a stage is divided
into connected parts. Each part is checked and cached separately: after the removal of a block only
its part is checked again.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.checks import unbalanced_wrench
from drystone.contacts import Contacts
from drystone.loads import LoadCase
from drystone.model import Model, OfModel
from drystone.results import Result, Verdict
from drystone.sequence.stage_checks import Check, check_both, check_both_near
from drystone.sequence.stages import Stage, StageAnswer, mask_of, members
from drystone.stability import PATIENT, Screening, try_rest
from drystone.stability.attempts import Candidate
from drystone.stability.problem import Problem
from drystone.stability.verdict.following import SETTLES_ALIKE

LOADED = 1e-6
"""Corners with less than this share of the largest force of their part are ignored in the required
friction."""

KEPT = 20_000
"""Corners of all parts that are kept with their matrices: about 50 MB."""


@dataclass(frozen=True, eq=False)
class _Part:
    """Blocks of a connected part and its supports, the interfaces (m,) among them, its problem."""

    blocks: Ints
    chosen: Bools
    problem: Problem

    @property
    def corners(self) -> int:
        return self.problem.model.contacts.corner_count


@dataclass(frozen=True, eq=False)
class Structure(OfModel, OneLine):
    """The complete model, and the checks of its stages.

    Attributes
    ----------
    model
    check
        Function that gives the verdict on a stage.
    quick
        How a stage is looked at before its check; None: it is checked at once.
    """

    model: Model
    check: Check = check_both
    quick: Screening | None = None

    def __post_init__(self) -> None:
        self.model.require_still()
        if not self.assembly.fixed.any():
            raise InputError("no block is fixed", remedy="fix the supports")

    @property
    def load(self) -> LoadCase:
        """The load of the model."""
        return self.model.load

    @cached_property
    def everything(self) -> int:
        """The set of all free blocks."""
        return mask_of(self.assembly.free.tolist())

    @cached_property
    def neighbours(self) -> tuple[int, ...]:
        """Per block the set of free blocks that touch it."""
        out = [0] * len(self.assembly)
        fixed = self.assembly.fixed
        pairs = zip(self.contacts.block_a.tolist(), self.contacts.block_b.tolist(), strict=True)
        for a, b in pairs:
            if not fixed[b]:
                out[a] |= 1 << b
            if not fixed[a]:
                out[b] |= 1 << a
        return tuple(out)

    @cached_property
    def grounds(self) -> tuple[tuple[int, ...], ...]:
        """Per block the supports that it touches."""
        out: list[set[int]] = [set() for _ in range(len(self.assembly))]
        fixed = self.assembly.fixed
        pairs = zip(self.contacts.block_a.tolist(), self.contacts.block_b.tolist(), strict=True)
        for a, b in pairs:
            if fixed[b]:
                out[a].add(b)
            if fixed[a]:
                out[b].add(a)
        return tuple(tuple(sorted(one)) for one in out)

    @cached_property
    def up(self) -> Floats:
        """Unit vector (3,) opposite to the total load; z if there is no load."""
        total = self.load.wrench[self.assembly.free, :3].sum(axis=0)
        size = float(np.linalg.norm(total))
        return -total / size if size > 0.0 else np.array([0.0, 0.0, 1.0])

    @cached_property
    def height(self) -> Floats:
        """Heights (n,) [m] of the centroids, opposite to the load."""
        out: Floats = self.assembly.centroid @ self.up
        return out

    def parts(self, stage: Stage) -> list[Stage]:
        """The connected parts of a stage, each with its adjacent held blocks."""
        moving = stage.placed & ~stage.held
        out = []
        while moving:
            reached = frontier = moving & -moving
            touched = 0
            while frontier:
                near = 0
                for block in members(frontier):
                    near |= self.neighbours[block]
                touched |= near
                frontier = near & moving & ~reached
                reached |= frontier
            held = touched & stage.held
            out.append(Stage(reached | held, held, stage.quick, stage.near))
            moving &= ~reached
        return out

    @cached_property
    def largest(self) -> tuple[int, int]:
        """Most free blocks and most corners of a connected part of the complete structure."""
        part = np.full(len(self.assembly), -1)
        for number, one in enumerate(self.parts(Stage(self.everything))):
            part[list(members(one.placed))] = number
        joined = np.maximum(part[self.contacts.block_a], part[self.contacts.block_b])
        corners = joined[self.contacts.interface]
        blocks, points = np.bincount(part[part >= 0]), np.bincount(corners[corners >= 0])
        return int(blocks.max(initial=0)), int(points.max(initial=0))

    def floating(self, placed: int) -> int:
        """Blocks in place that are not connected to a support through blocks in place."""
        reached = frontier = placed & self.grounded
        while frontier:
            near = 0
            for block in members(frontier):
                near |= self.neighbours[block]
            frontier = near & placed & ~reached
            reached |= frontier
        return placed & ~reached

    @cached_property
    def grounded(self) -> int:
        """Free blocks that touch a support."""
        return mask_of(b for b in self.assembly.free.tolist() if self.grounds[b])

    def solve(
        self,
        part: Stage,
        known: Mapping[int, Floats] | None = None,
        rest: Candidate | None = None,
    ) -> StageAnswer:
        """The answer of one connected part. Stages are checked and screened only here.

        Parameters
        ----------
        part
        known : (n, 6) [m, rad] each
            Displacements of all blocks in rest states to start from, by the number of the contact
            stiffness; empty where none was found.
        rest
            The rest state with uniform stiffness that a quick look at this part found.
        """
        found = self._part(part.placed, part.held)
        if found is None:
            moving = tuple(members(part.placed & ~part.held))
            return StageAnswer(Verdict.UNSTABLE, "touches no support", moving)
        blocks, chosen, stage = found.blocks, found.chosen, found.problem.model
        some, contacts, held = stage.assembly, stage.contacts, list(members(part.held))
        near = {n: motion[blocks] if len(motion) else motion for n, motion in (known or {}).items()}
        rests: Mapping[int, Floats] = {}
        uniform = None
        if part.quick:
            level = PATIENT if self.quick is None else self.quick
            result = try_rest(found.problem, screening=level, start=near.get(0))
            uniform = _rest_of(result)
        elif self.check is check_both:
            within = self.joints[chosen], int(self.joints[-1]) + 1
            result, rests = check_both_near(found.problem, near, within, rest)
        else:
            result = self.check(stage)
        if not rests and result.displacement is not None:
            rests = {0: result.displacement}
        falling = tuple(int(blocks[i]) for i in result.falling)
        settled = "" if result.settlement is None else result.settlement.message
        if result.message.startswith(SETTLES_ALIKE):
            settled = SETTLES_ALIKE
        if not result.stable or result.force is None:
            return StageAnswer(result.verdict, result.message, falling, settled=settled)
        reaction = {}
        if held:
            unloaded = stage.with_load(LoadCase(np.zeros_like(stage.load.wrench)))
            pressing, _ = unbalanced_wrench(unloaded, result.force)
            pressing[:, 3:] *= some.size[:, None]
            place = np.searchsorted(blocks, held)
            reaction = {b: -pressing[i] for b, i in zip(held, place.tolist(), strict=True)}
        used = _friction_used(contacts, result.force)
        corner = np.flatnonzero(chosen[self.contacts.interface])
        force = np.array(result.force)
        moved = {n: motion[~some.fixed] if len(motion) else motion for n, motion in rests.items()}
        return StageAnswer(
            result.verdict,
            result.message,
            (),
            reaction,
            used,
            corner,
            force,
            moved,
            settled,
            uniform,
        )

    @cached_property
    def joints(self) -> Ints:
        """Number (m,) of each interface among those that do not join two fixed blocks."""
        return np.cumsum(self.model.active) - 1

    def _part(self, placed: int, held: int) -> _Part | None:
        """A connected part as a problem; None if nothing supports it.

        The last ones are kept: a part is screened, then checked.
        """
        key, kept = (placed, held), self._kept
        found = kept.pop(key, None) or self._made(placed, held)
        if found is not None:
            kept[key] = found
            # a copy at once: threads of an executor may share the structure
            before = list(kept.items())
            corners = np.cumsum([one.corners for _, one in before[::-1]])[::-1]
            for (old, _), behind in zip(before[:-1], corners[:-1].tolist(), strict=True):
                if behind > KEPT:
                    kept.pop(old, None)
        return found

    def _made(self, placed: int, held: int) -> _Part | None:
        moving = list(members(placed & ~held))
        ground = sorted({g for block in moving for g in self.grounds[block]})
        if not held and not ground:
            return None
        fixed = [*members(held), *ground]
        blocks = np.array(sorted([*moving, *fixed]), dtype=np.intp)
        resting = self.assembly.fixed[blocks] | np.isin(blocks, fixed)
        some = Assembly(tuple(self.assembly.blocks[b] for b in blocks.tolist()), resting)
        contacts, chosen = self._contacts_of(blocks, resting)
        load = LoadCase(self.load.wrench[blocks], self.load.name)
        return _Part(blocks, chosen, Problem.build(Model(some, contacts, load)))

    @cached_property
    def _kept(self) -> dict[tuple[int, int], _Part]:
        """The parts that were used last, the latest at the end."""
        return {}

    def __getstate__(self) -> dict[str, Any]:
        """What travels to another process: without the parts that are kept."""
        return {name: value for name, value in self.__dict__.items() if name != "_kept"}

    def _contacts_of(self, blocks: Ints, resting: Bools) -> tuple[Contacts, Bools]:
        """Contacts of some blocks, at least one movable, and which (m,) of the model they are."""
        n = len(self.assembly)
        new = np.full(n, -1, dtype=np.intp)
        new[blocks] = np.arange(len(blocks))
        still = np.ones(n, dtype=bool)
        still[blocks] = resting
        a, b = self.contacts.block_a, self.contacts.block_b
        chosen = (new[a] >= 0) & (new[b] >= 0) & ~(still[a] & still[b])
        return self.contacts.select(chosen, new), chosen

    def combine(self, stage: Stage, parts: Iterable[StageAnswer]) -> StageAnswer:
        """The answer of a stage from those of its parts."""
        found = list(parts)
        reaction = {b: -self.load.wrench[b] for b in members(stage.held)}
        for one in found:
            for block, wrench in one.reaction.items():
                reaction[block] = reaction[block] + wrench
        bad = [one for one in found if not one.stands]
        falling = tuple(sorted({b for one in bad for b in one.falling}))
        if bad:
            undecided = next((one for one in bad if one.verdict is not Verdict.UNSTABLE), None)
            worst = bad[0] if undecided is None else undecided
            return StageAnswer(
                worst.verdict, worst.message, falling, reaction, settled=worst.settled
            )
        return StageAnswer(
            Verdict.STABLE,
            "",
            (),
            reaction,
            max((one.used for one in found), default=0.0),
            np.concatenate([np.zeros(0, dtype=np.intp), *(one.corner for one in found)]),
            np.concatenate([np.zeros((0, 3)), *(one.force for one in found)]),
            settled="; ".join(one.settled for one in found if one.settled),
        )


def _rest_of(result: Result) -> Candidate | None:
    """The rest state of a result that stands."""
    force, displacement, residuals = result.force, result.displacement, result.residuals
    if not result.stable or force is None or displacement is None or residuals is None:
        return None
    return Candidate(force, displacement, residuals)


def _friction_used(contacts: Contacts, force: Floats) -> float:
    """Largest share of the friction coefficient used by a loaded corner, beside its cohesion."""
    normal = force[:, 0]
    loaded = normal > LOADED * float(normal.max(initial=0.0))
    friction = contacts.friction[contacts.interface]
    cohesion = contacts.corner_capacity[1]
    sliding = np.maximum(np.linalg.norm(force[:, 1:], axis=1) - cohesion, 0.0)
    counted = loaded & (friction > 0.0)
    return float((sliding[counted] / (friction[counted] * normal[counted])).max(initial=0.0))


__all__ = ["Structure"]
