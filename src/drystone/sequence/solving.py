"""The verdict on connected parts of stages.

A part becomes a model of its blocks and the supports that they touch, held blocks fixed. It is
built once for the quick look and the check that may follow.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, lengths, places
from drystone.base.display import OneLine
from drystone.checks import unbalanced_wrench
from drystone.contacts import Contacts
from drystone.joints import FAINT, bearable
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.sequence.stages import Stage, StageAnswer, StageCheck, StagedModel, members
from drystone.stability import PATIENT, try_rest
from drystone.stability.attempts import QUICK, Candidate
from drystone.stability.problem import Problem

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


class PartSolver(OneLine):
    """Checks connected parts of the stages of one structure.

    The parts that were used last are kept as problems; they do not travel to other processes.
    """

    def __init__(self, structure: StagedModel) -> None:
        self.structure = structure
        self._kept: dict[tuple[int, int], _Part] = {}
        self._lock = threading.Lock()  # threads of an executor may share it

    def __reduce__(self) -> tuple[Any, ...]:
        return PartSolver, (self.structure,)

    def _summary(self) -> str:
        return repr(self.structure)

    def solve(
        self,
        part: Stage,
        near: Floats | None = None,
        rest: Candidate | None = None,
        missing: Sequence[Floats] = (),
    ) -> StageAnswer:
        """The answer of one connected part. Stages are checked, and looked at, only here.

        Parameters
        ----------
        part
        near : (n, 6) [m, rad]
            Displacements of all blocks in a rest state to start from.
        rest
            The rest state with uniform stiffness that a quick look at this part found.
        missing : each (n, 6) [N, N m]
            What blocks missed that fell in similar parts.
        """
        found = self._part(part.placed, part.held)
        if found is None:
            moving = tuple(members(part.placed & ~part.held))
            return StageAnswer(Verdict.UNSTABLE, "touches no support", moving)
        blocks, chosen, stage = found.blocks, found.chosen, found.problem.model
        start, missed = None if near is None else near[blocks], [one[blocks] for one in missing]
        result = self._result(part, found.problem, start, rest, missed)
        falling = tuple(int(blocks[i]) for i in result.falling)
        settled = "" if result.settlement is None else result.settlement.message
        if not result.stable or result.force is None:
            moved = np.zeros((0, 6))
            if result.falls and result.mechanism is not None:
                moved = result.mechanism[~stage.assembly.fixed]
            return StageAnswer(
                result.verdict, result.message, falling, settled=settled, motion=moved,
                missing=_missing(result),
            )  # fmt: skip
        moved = np.zeros((0, 6))
        if result.displacement is not None:
            moved = result.displacement[~stage.assembly.fixed]
        held = list(members(part.held))
        # where it came to rest after settling it has the joints that it met as well
        pressing = _pressing(result.model, result.force) if held else np.zeros((0, 6))
        place = np.searchsorted(blocks, held).tolist()
        return StageAnswer(
            result.verdict,
            result.message,
            reaction={b: -pressing[i] for b, i in zip(held, place, strict=True)},
            used=most_used(result.contacts, result.force),
            corner=np.flatnonzero(chosen[self.structure.contacts.interface]),
            force=np.array(result.force[: stage.contacts.corner_count]),
            rest=moved,
            settled=settled,
            uniform=_rest_of(result) if part.quick else None,
            sensitive=result.sensitive,
        )

    def _result(
        self,
        part: Stage,
        problem: Problem,
        start: Floats | None,
        rest: Candidate | None,
        missing: Sequence[Floats],
    ) -> Result:
        """A quick look at a part, or its check."""
        if part.quick:
            level = PATIENT if self.structure.quick is None else self.structure.quick
            hopeless = partial(self._loose, part)
            return try_rest(problem, screening=level, start=start, hopeless=hopeless)
        check = self.structure.check
        if isinstance(check, StageCheck):
            return check.begun_at(problem, start, rest, missing)
        return check(problem.model)

    def _loose(self, part: Stage) -> bool:
        """Whether what touched the blocks that are gone rests nowhere, were all others held."""
        gone = 0 if part.near is None else part.near[0] & ~part.placed
        moving = self.structure.around(gone) & part.placed & ~part.held
        held = self.structure.around(moving) & part.placed & ~moving
        found = self._part(moving | held, held) if moving and held & ~part.held else None
        return found is not None and not try_rest(found.problem, screening=QUICK).stable

    def _part(self, placed: int, held: int) -> _Part | None:
        """A connected part as a problem; None if nothing supports it."""
        key = (placed, held)
        with self._lock:
            found = self._kept.pop(key, None)
        found = found or self._made(placed, held)
        if found is not None:
            with self._lock:
                self._kept[key] = found
                corners = sum(one.corners for one in self._kept.values())
                while len(self._kept) > 1 and corners > KEPT:
                    corners -= self._kept.pop(next(iter(self._kept))).corners
        return found

    def _made(self, placed: int, held: int) -> _Part | None:
        moving = list(members(placed & ~held))
        grounds = 0
        for block in moving:
            grounds |= self.structure.grounds[block]
        ground = list(members(grounds))
        if not held and not ground:
            return None
        fixed = [*members(held), *ground]
        blocks = np.array(sorted([*moving, *fixed]), dtype=np.intp)
        resting = self.structure.assembly.fixed[blocks] | np.isin(blocks, fixed)
        some = Assembly(tuple(self.structure.assembly.blocks[b] for b in blocks.tolist()), resting)
        contacts, chosen = self._contacts_of(blocks, resting)
        load = self.structure.load.of_blocks(blocks)
        part = Model(some, contacts, load, ends=self.structure.model.ends)
        return _Part(blocks, chosen, Problem.build(part))

    def _contacts_of(self, blocks: Ints, resting: Bools) -> tuple[Contacts, Bools]:
        """Contacts of some blocks, at least one movable, and which (m,) of the model they are."""
        n = len(self.structure.assembly)
        new = places(blocks, n)
        still = np.ones(n, dtype=bool)
        still[blocks] = resting
        a, b = self.structure.contacts.block_a, self.structure.contacts.block_b
        chosen = (new[a] >= 0) & (new[b] >= 0) & ~(still[a] & still[b])
        return self.structure.contacts.select(chosen, new), chosen


def combined(structure: StagedModel, stage: Stage, parts: Iterable[StageAnswer]) -> StageAnswer:
    """The answer of a stage from those of its parts."""
    found = list(parts)
    reaction = {b: -structure.load.wrench[b] for b in members(stage.held)}
    for one in found:
        for block, wrench in one.reaction.items():
            reaction[block] = reaction[block] + wrench
    bad = [one for one in found if not one.stands]
    if bad:
        # one part that falls is a proof for the stage; one that was only looked at may be checked
        worst = min(bad, key=lambda one: (one.verdict is Verdict.UNSTABLE) == stage.quick)
        falling = tuple(sorted({b for one in bad for b in one.falling}))
        return StageAnswer(worst.verdict, worst.message, falling, reaction, settled=worst.settled)
    return StageAnswer(
        Verdict.STABLE,
        "",
        (),
        reaction,
        max((one.used for one in found), default=0.0),
        np.concatenate([np.zeros(0, dtype=np.intp), *(one.corner for one in found)]),
        np.concatenate([np.zeros((0, 3)), *(one.force for one in found)]),
        settled="; ".join(one.settled for one in found if one.settled),
        sensitive=any(one.sensitive for one in found),
    )


def _missing(result: Result) -> Floats:
    """What moving blocks (b, 6) [N, N m] missed at first; none if others than fall moved far."""
    found = result.settlement
    if found is None or result.prop is None:
        return np.zeros((0, 6))
    alone = all({*path.moving} <= {*result.falling} for path in found.paths)
    return result.prop[~result.assembly.fixed] if alone else np.zeros((0, 6))


def _pressing(stage: Model, force: Floats) -> Floats:
    """What contact forces press (n, 6) [N, N m] each block with."""
    unloaded = stage.with_load(LoadCase(np.zeros_like(stage.load.wrench)))
    pressing, _ = unbalanced_wrench(unloaded, force)
    pressing[:, 3:] *= stage.assembly.size[:, None]
    return pressing


def _rest_of(result: Result) -> Candidate | None:
    """The rest state of a result that stands."""
    force, displacement, residuals = result.force, result.displacement, result.residuals
    if not result.stable or force is None or displacement is None or residuals is None:
        return None
    return Candidate(force, displacement, residuals)


def most_used(contacts: Contacts, force: Floats) -> float:
    """Largest share of what a joint bears along its face that the sum of its forces needs.

    What a joint that carries hardly anything uses of its friction says nothing.
    """
    total = contacts.corners.sum(force)
    bound = bearable(contacts, total[:, 0])
    loaded = (total[:, 0] > FAINT * float(total[:, 0].max(initial=0.0))) & (bound > 0.0)
    share = lengths(total[loaded, 1:]) / bound[loaded]
    return round(float(share.max(initial=0.0)), 6)  # the rest is rounding
