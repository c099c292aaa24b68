"""Checks of many stages: cached by part, on any executor, resumed from a checkpoint.

A collapse mechanism says of each corner that it opens, and of the loads that they do work. Of
another stage it says the same if the blocks that it would run into are absent, and none of the
blocks that it moves is held: to know that takes no calculation.

Blocks that fell when they were followed, all others at rest, fall in another stage too where they
begin to do so under the same forces between the same blocks.
"""

from __future__ import annotations

import functools
import hashlib
import pickle
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.files import PathLike
from drystone.base.journal import Journal, exactly
from drystone.base.settings import Stopped
from drystone.base.version import version
from drystone.base.workers import ExecutorFactory, WorkerPool
from drystone.checks import block_speed, closing
from drystone.formulations.nearest_mechanism import STILL
from drystone.io.opening import content_of
from drystone.limits.images import Image, own_images
from drystone.model import Model
from drystone.results import Verdict
from drystone.sequence.solving import PartSolver, combined
from drystone.sequence.stages import (
    Check,
    Stage,
    StageAnswer,
    StagedModel,
    check_thoroughly,
    mask_of,
    members,
)
from drystone.settlement import SettlementOptions
from drystone.stability.attempts import Candidate
from drystone.stability.problem import FALLING_SHARE, MECHANISM_TOLERANCE, UNBALANCED
from drystone.stability.touching_edges import may_touch_more
from drystone.stability.verdict import check as check_whole


@dataclass(frozen=True, eq=False)
class Fall(OneLine):
    """A motion of some blocks, all others at rest.

    Attributes
    ----------
    moving
        Set of the blocks that move.
    stopped
        Pairs of blocks, as sets, of which both must not be in place; of a support and a block the
        set has only the block.
    power, gross
        Work of the load of each moving block, and the sum of its absolute parts.
    """

    moving: int
    stopped: tuple[int, ...]
    power: dict[int, float]
    gross: dict[int, float]

    def proves(self, part: Stage) -> bool:
        """Whether a part falls with it."""
        placed = part.placed
        present = self.moving & placed
        if not present or present & part.held:
            return False
        if any(pair & placed == pair for pair in self.stopped):
            return False
        # a proof has 1e-9 or more; where blocks are left out less is not relied upon
        blocks = list(members(present))
        power = sum(self.power[b] for b in blocks)
        return power > FALLING_SHARE * sum(self.gross[b] for b in blocks)

    def at(self, image: Ints) -> Fall:
        """The same of the blocks where each one (n,) goes in an image of the structure."""
        power, gross = ({int(image[b]): of[b] for b in of} for of in (self.power, self.gross))
        stopped = sorted(_there(image, pair) for pair in self.stopped)
        return Fall(_there(image, self.moving), tuple(stopped), power, gross)


def _there(image: Ints, blocks: int) -> int:
    """The set of the blocks where some go."""
    return mask_of(image[list(members(blocks))])


def _image_of(part: Stage, image: Ints) -> Stage:
    """The part that an image makes of one."""
    return Stage(_there(image, part.placed), _there(image, part.held))


class KnownFalls(OneLine):
    """The falls of one model. Joints that pull or cohere may resist, so there nothing is kept."""

    def __init__(self, model: StagedModel) -> None:
        self.model = model
        self._kept: dict[tuple[int, tuple[int, ...]], Fall] = {}
        # by the falling blocks, and those in place and held around them
        self._followed: dict[tuple[int, int, int], Floats] = {}

    @functools.cached_property
    def images(self) -> list[Image]:
        """The images of the structure."""
        return own_images(self.model.model)

    @functools.cached_property
    def _near(self) -> list[int]:
        """The sets of free blocks that each block touches, or may meet until it falls."""
        assembly = self.model.assembly
        low, high = assembly.bounds[:, 0], assembly.bounds[:, 1]
        reach = SettlementOptions().fall * np.cbrt(assembly.volume)[:, None]
        free = ~assembly.fixed
        return [
            mask_of(np.flatnonzero(free & ((low <= top) & (high >= bottom)).all(axis=1)))
            for top, bottom in zip(high + reach, low - reach, strict=True)
        ]

    def add(self, part: Stage, found: StageAnswer) -> None:
        """Keep how a part falls."""
        if not self.model.contacts.dry.all():
            return
        if len(found.motion):
            self._add_mechanism(part, found.motion)
        if len(found.missing):
            falling, moving = mask_of(found.falling), list(members(part.placed & ~part.held))
            missing = np.zeros((len(self.model.assembly), 6))
            missing[moving] = found.missing
            self._followed[self._place(part, falling)] = missing
            for image in self.images:
                there = np.zeros_like(missing)
                there[image.block] = image.of(missing)
                place = self._place(_image_of(part, image.block), _there(image.block, falling))
                self._followed[place] = there

    def _place(self, part: Stage, falling: int) -> tuple[int, int, int]:
        """Falling blocks of a part, and the sets of those in place and held around them."""
        around = 0
        for block in members(falling):
            around |= self._near[block]
        return falling, around & part.placed, around & part.held

    def like(self, part: Stage) -> list[Floats]:
        """What was missing (n, 6) [N, N m] in each fall that was followed in such a place."""
        free = part.placed & ~part.held
        return [
            missing
            for place, missing in reversed(self._followed.items())
            if not place[0] & ~free and self._place(part, place[0]) == place
        ]

    def _add_mechanism(self, part: Stage, motion: Floats) -> None:
        """Keep the mechanism (b, 6) [m, rad] of the moving blocks of a part.

        Blocks that do not touch each other fall alone, so each is kept alone.
        """
        every = np.zeros((len(self.model.assembly), 6))
        every[list(members(part.placed & ~part.held))] = motion
        speed = block_speed(self.model.assembly, every)
        moving = mask_of(np.flatnonzero(speed > STILL * speed.max()).tolist())
        for group in self.model.parts(Stage(moving)):
            alone = np.zeros_like(every)
            alone[list(members(group.placed))] = every[list(members(group.placed))]
            found = self._fall(group.placed, alone)
            if found.proves(part):
                for one in (found, *(found.at(image.block) for image in self.images)):
                    self._kept.setdefault((one.moving, one.stopped), one)

    def _fall(self, moving: int, motion: Floats) -> Fall:
        contacts, free = self.model.contacts, self.model.assembly.free
        work = self.model.load.wrench * motion
        closes = closing(self.model.model, motion) > MECHANISM_TOLERANCE
        joints = np.unique(contacts.interface[closes])
        pairs = zip(
            contacts.block_a[joints].tolist(), contacts.block_b[joints].tolist(), strict=True
        )
        movable = mask_of(free.tolist())
        stopped = {(1 << a | 1 << b) & movable for a, b in pairs}
        blocks = list(members(moving))
        return Fall(
            moving,
            tuple(sorted(stopped)),
            {b: float(work[b].sum()) for b in blocks},
            {b: float(np.abs(work[b]).sum()) for b in blocks},
        )

    def falling(self, part: Stage) -> int:
        """The blocks of a part that are known to fall, as a set; empty where it is not known."""
        found = 0
        for fall in self._kept.values():
            if fall.moving & part.placed & ~found and fall.proves(part):
                found |= fall.moving & part.placed
        return found


_OF_IMAGE = "its image falls: "

_Job: TypeAlias = tuple[Stage, Floats | None, Candidate | None, Sequence[Floats]]
"""A part, its known rest states: of similar stages, and with uniform stiffness; similar falls."""


class Evaluator(OneLine):
    """Answers about stages of one model.

    Parameters
    ----------
    model
    executor
        An executor, or a function that starts one; without it, the work is done in this process. An
        executor started by the function is shut down at the end; a given one is not.
    checkpoint
        File for all answers; if it exists and belongs to this model, the work continues from it.
    late
        Called before parts are checked; True ends the work.
    learns
        Whether checks begin at the rest state of the nearest part that was asked before, and
        mechanisms, what falls alike and images answer other parts. What was asked before then
        changes forces, and which blocks fall, but no verdict.
    kept
        Largest number of parts whose answers are kept, those asked last.

    Attributes
    ----------
    solved
        Number of parts that were checked, without cached ones.
    asked
        Number of parts that were needed for the first time. It does not depend on the workers or
        the checkpoint.
    solve_s
        Time spent on them, seen from this process.

    Raises
    ------
    FormatError
        The checkpoint belongs to another model, or cannot be read.
    """

    def __init__(
        self,
        model: StagedModel,
        *,
        executor: Executor | ExecutorFactory | None = None,
        checkpoint: PathLike | None = None,
        late: Callable[[], bool] = bool,
        learns: bool = False,
        kept: float = float("inf"),
    ) -> None:
        self.model = model
        self.solver = PartSolver(model)
        self.late = late
        self.solved = 0
        self.asked = 0
        self.solve_s = 0.0
        self._falls = KnownFalls(model) if learns else None
        # moving blocks and rest states of the last parts that stood: 50 us to look through
        self._rested: deque[tuple[int, Floats]] = deque(maxlen=200)
        self._kept = kept
        self._known: dict[Stage, StageAnswer] = {}
        # of parts that nobody asked for yet: from the checkpoint, and with where they begin ahead
        self._early: dict[Stage, StageAnswer] = {}
        self._pool = WorkerPool(executor, needed=False)
        self._checkpoint = None if checkpoint is None else Checkpoint(checkpoint, model)
        if self._checkpoint is not None:
            self._early.update(self._checkpoint.known)

    def _summary(self) -> str:
        return f"{self.model!r}, {self.solved} parts checked"

    @functools.cached_property
    def _task(self) -> Callable[[_Job], StageAnswer]:
        """The work on one part in another process; the solver is packed once."""
        return functools.partial(solve_remote, pickle.dumps(self.solver))

    @property
    def batch(self) -> int:
        """Number of stages to request at once."""
        return max(1, self._pool.count)

    def __enter__(self) -> Evaluator:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.end()

    def answer(self, stage: Stage, *, forces: bool = False, checked: bool = False) -> StageAnswer:
        """The answer of a stage; see :meth:`answers`."""
        return self.answers([stage], forces=forces, checked=checked)[0]

    def answers(
        self,
        stages: Sequence[Stage],
        *,
        ahead: Sequence[Stage] = (),
        pool: WorkerPool | None = None,
        forces: bool = False,
        checked: bool = False,
    ) -> list[StageAnswer]:
        """The answers of several stages.

        Parameters
        ----------
        stages
        ahead
            Stages that are likely to be requested next. Their results are stored separately until
            then, so no answer depends on the number of workers.
        pool
            Workers of this call; those of the evaluator when left out.
        forces
            Whether to check again if the forces were not kept.
        checked
            Whether to check stages that were only looked at.

        Raises
        ------
        Stopped
            The time limit is reached; earlier results are kept. The first stage is always checked.
        """
        while len(self._known) > self._kept:
            del self._known[next(iter(self._known))]
        parts = [self.model.parts(stage) for stage in stages]
        asked = dict.fromkeys(part for some in parts for part in some)
        missing = [part for part in asked if self._is_missing(part, forces, checked)]
        if missing and self._known and self.late():
            raise Stopped
        if missing:
            later = [part for stage in ahead for part in self.model.parts(stage)]
            self._solve(missing, later, self._pool if pool is None else pool)
        return [
            combined(self.model, stage, [self._known[self._key(part)] for part in some])
            for stage, some in zip(stages, parts, strict=True)
        ]

    def _is_missing(self, part: Stage, forces: bool, checked: bool) -> bool:
        """Whether a part is to be computed; an early answer to it is known from now on."""

        def enough(found: StageAnswer | None) -> bool:
            return found is not None and not (forces and found.stands and not len(found.corner))

        key = part._replace(near=None)
        if enough(self._known.get(key) if checked else self._find(part)):
            return False
        alike = self._like_others(part)
        if alike is not None and enough(alike):
            self._keep(key._replace(quick=False), alike)
            return False
        self.asked += 1
        early = self._early.get(part, self._early.get(key))
        if early is None or not enough(early):
            return True
        if self._checkpoint is not None and key in self._checkpoint.known:  # it has it already
            self._known[key] = early
        else:
            self._keep(key, early)
        return False

    def _like_others(self, part: Stage) -> StageAnswer | None:
        """The answer of a part that falls by a known mechanism, or whose image is known."""
        if self._falls is None:
            return None
        falling = self._falls.falling(part)
        if falling:
            return StageAnswer(Verdict.UNSTABLE, UNBALANCED, tuple(members(falling)))
        for image in self._falls.images:
            found = self._known.get(_image_of(part, np.argsort(image.block)))
            if found is not None and found.verdict is not Verdict.UNDECIDED:
                return self._seen(found, image)
        return None

    def _seen(self, found: StageAnswer, image: Image) -> StageAnswer:
        """An answer as that of an image."""
        none, falls = np.zeros((0, 6)), _OF_IMAGE if found.verdict is Verdict.UNSTABLE else ""
        reaction = {b: image.of(one[None])[0] for b, one in found.reaction.items()}
        return replace(
            found,
            message=f"{falls}{found.message.removeprefix(falls)}",
            falling=tuple(sorted(image.block[list(found.falling)].tolist())),
            reaction={int(image.block[b]): one for b, one in reaction.items()},
            corner=image.corner[found.corner],
            force=image.of_forces(self.model.contacts, found.corner, found.force),
            rest=none, uniform=None, motion=none, missing=none,
        )  # fmt: skip

    def _solve(self, missing: Sequence[Stage], ahead: Sequence[Stage], pool: WorkerPool) -> None:
        """Compute parts, and where there are workers others too, which are kept until asked for."""
        began = time.perf_counter()
        known = {*missing, *self._early}
        further = [
            part for part in dict.fromkeys(ahead)
            if not {part, part._replace(near=None)} & known and self._find(part) is None
        ]  # fmt: skip
        parts = [*missing, *further]
        for number, (part, found) in enumerate(zip(parts, self._solved(parts, pool), strict=True)):
            if number < len(missing):
                self._keep(part._replace(near=None), found)
            else:
                self._early[part] = found
            self.solved += 1
        self.solve_s += time.perf_counter() - began

    def settled(self, stage: Stage, check: Check) -> StageAnswer:
        """A stage by another check, which is kept where it stands."""
        other = PartSolver(replace(self.model, check=check))
        for part in self.model.parts(stage):
            if not self.answer(part).stands:
                found = other.solve(part)
                self.solved += 1
                if not found.stands:
                    return found
                self._keep(part, found)
        return self.answer(stage)

    def _keep(self, part: Stage, found: StageAnswer) -> None:
        """An answer, for this run and the next one."""
        self._known[part] = found
        if self._falls is not None:
            self._falls.add(part, found)
            if len(found.rest):
                self._rested.append((part.placed & ~part.held, found.rest))
        if self._checkpoint is not None:
            self._checkpoint.add(part, found)

    def _key(self, part: Stage) -> Stage:
        """The part whose answer is that of a part: checked, or where it is enough looked at."""
        part = part._replace(near=None)
        checked, quick = part._replace(quick=False), part._replace(quick=True)
        if checked in self._known or quick not in self._known:
            return checked
        return quick if self._known[quick].stands or part.quick else checked

    def _find(self, part: Stage) -> StageAnswer | None:
        """The known answer of a part: the check, or a quick look that shows that it stands."""
        return self._known.get(self._key(part))

    def _rest_of_nearest(self, part: Stage) -> Floats | None:
        """Displacements (n, 6) of the part that differs in the fewest blocks, the last of several.

        None where it has no block of the part.
        """
        moving = part.placed & ~part.held
        blocks, rest = min(
            reversed(self._rested),
            key=lambda one: (one[0] ^ moving).bit_count(),
            default=(0, np.zeros((0, 6))),
        )
        if not blocks & moving:
            return None
        out = np.zeros((len(self.model.assembly), 6))
        out[list(members(blocks))] = rest
        return out

    def _rest_near(self, part: Stage) -> Floats | None:
        """Displacements (n, 6) of the known rest states of a part and of its similar stage."""
        if self._falls is not None:
            return self._rest_of_nearest(part)
        out: Floats | None = None
        for stage in (part.near, (part.placed, part.held)):
            for other in () if stage is None else self.model.parts(Stage(*stage)):
                moving = other.placed & ~other.held
                found = self._find(other) if moving & part.placed else None
                if found is None or not found.stands:
                    continue
                if not len(found.rest):  # from a checkpoint
                    rest = self.solver.solve(other._replace(quick=True)).rest
                    found = self._known[other] = replace(found, rest=rest)
                out = np.zeros((len(self.model.assembly), 6)) if out is None else out
                if len(found.rest):
                    out[list(members(moving))] = found.rest
        return out

    def _screened(self, part: Stage) -> Candidate | None:
        """The rest state of a part with uniform stiffness that a quick look found."""
        if part.quick:
            return None
        found = self._find(part)
        return None if found is None else found.uniform

    def _solved(self, parts: Sequence[Stage], pool: WorkerPool) -> Iterator[StageAnswer]:
        if len(parts) == 1 or not pool.count:
            return (self._solve_here(self._job(part)) for part in parts)
        jobs = [self._job(part) for part in parts]
        return pool.answers(self._task, jobs, failed=self._solve_here)

    def _job(self, part: Stage) -> _Job:
        like = [] if self._falls is None else self._falls.like(part)
        return part, self._rest_near(part), self._screened(part), like

    def _solve_here(self, job: _Job) -> StageAnswer:
        return self.solver.solve(*job)


def finished(evaluator: Evaluator, placed: int, check: Check | None) -> StageAnswer:
    """Of what is to stand at the end; without a check of its own it may stand after settling."""
    answer = evaluator.answer(Stage(placed))
    if check is None and evaluator.model.small and not answer.stands:
        return evaluator.settled(Stage(placed), check_thoroughly)
    return answer


def finished_whole(evaluator: Evaluator, check: Check | None) -> tuple[StageAnswer, Model | None]:
    """Of the complete structure; and it with the edges that touch, where these hold it.

    Near blocks that do not touch are no proof of a fall.
    """
    model = evaluator.model.model
    complete = finished(evaluator, evaluator.model.everything, check)
    if check is None and complete.verdict is Verdict.UNSTABLE and may_touch_more(model):
        whole = check_whole(model)
        if whole.stable and whole.contacts.count > model.contacts.count:
            return complete, replace(whole.model, report=None)
        if whole.verdict is Verdict.UNDECIDED:
            known = replace(complete, verdict=whole.verdict, message=whole.message, falling=())
            return known, None
    return complete, None


def solve_remote(payload: bytes, job: _Job) -> StageAnswer:
    """The verdict on one part, computed in a worker that unpacks the solver once."""
    part, near, rest, missing = job
    return _unpacked(payload).solve(Stage(*part), near, rest, missing)


@functools.lru_cache(maxsize=2)
def _unpacked(payload: bytes) -> PartSolver:
    solver = pickle.loads(payload)
    if not isinstance(solver, PartSolver):
        raise TypeError(f"a worker was sent a {type(solver).__name__}")
    return solver


FORMAT = "drystone-stages"


def fingerprint(model: StagedModel) -> str:
    """Hash of a model: geometry, contacts and what they carry, load, and the check."""
    told = content_of(replace(model.model, cases=())) + exactly(model.check)
    return hashlib.sha256(told.encode()).hexdigest()


class Checkpoint:
    """Answers about stages in a journal.

    Raises
    ------
    FormatError
        It belongs to another model, check or version, is damaged, or cannot be read or written.
    """

    def __init__(self, path: PathLike, model: StagedModel) -> None:
        about = {"format": FORMAT, "version": version(), "model": fingerprint(model)}
        self._journal = Journal(path, about, partial(_known, len(model.assembly)))
        self.known = dict(self._journal.records)

    def add(self, part: Stage, found: StageAnswer) -> None:
        """Write an answer without its forces."""
        record = {
            "placed": f"{part.placed:x}",
            "held": f"{part.held:x}",
            "quick": part.quick,
            "verdict": found.verdict.name,
            "message": found.message,
            "falling": list(found.falling),
            "reaction": {str(b): wrench.tolist() for b, wrench in found.reaction.items()},
            "used": found.used,
            "settled": found.settled,
        }
        self._journal.add([record])


def _known(blocks: int, record: Any) -> tuple[Stage, StageAnswer]:
    """A stage of a model of so many blocks, and its answer."""
    placed, held = (int(record[name], 16) for name in ("placed", "held"))
    falling = tuple(map(int, record["falling"]))
    reaction = {int(b): np.array(one, dtype=np.float64) for b, one in record["reaction"].items()}
    if not 0 <= held <= placed < 2**blocks or {*falling, *reaction} - {*range(blocks)}:
        raise LookupError("it has other blocks")
    if any(one.shape != (6,) for one in reaction.values()):
        raise ValueError("a reaction has six numbers")
    message, settled, used = str(record["message"]), str(record["settled"]), float(record["used"])
    answer = StageAnswer(
        Verdict[record["verdict"]], message, falling, reaction, used, settled=settled
    )
    return Stage(placed, held, bool(record["quick"])), answer
