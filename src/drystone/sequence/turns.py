"""Robots that take turns: each holds its block until the next one is in place.

They need no other support: a block is released when the next one is in place and held, so in every
stage the last block is held. Source: Kao 2023, section 6.4.2; Parascho et al. 2020 ("Robotic
vault", sequential assembly of an arch by two robots).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Unpack

import numpy as np

from drystone.answer import (
    Answer,
    Layer,
    LayerKind,
    Question,
    Role,
    Scene,
    SceneStage,
    Sentence,
    State,
)
from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, Stopped, checked_call
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.io.opening import Given, LongHow, as_model
from drystone.loads import STANDARD_GRAVITY
from drystone.model import Model
from drystone.results import Verdict
from drystone.sequence.evaluation import Evaluator, finished_whole
from drystone.sequence.plan_layers import outlined, stage_of, with_arms, with_reach
from drystone.sequence.plan_steps import falling_words, permanent_words, refusal
from drystone.sequence.robots import Robot, check_robots, why_not
from drystone.sequence.stage_tree import overloads
from drystone.sequence.stages import Check, Stage, StageAnswer, StagedModel, check_both, mask_of

PAIR = (Robot("left"), Robot("right"))
"""Two robots without limits."""


@dataclass(frozen=True, eq=False)
class Turn(OneLine):
    """One block placed and held.

    Attributes
    ----------
    block, name
    robot
        The robot that places it, and holds it until the next one is in place.
    answer
        Of the stage with all earlier blocks released, and this one held; or released too, where it
        stands so and would else be held with more than its weight.
    force : (3,) [N]
    moment : (3,) [N m]
        Largest force and moment of the robot, about the centroid of the block: its weight while it
        is carried, or what holds it if that is more; less may hold it too.
    reached, carried
        Whether the robot reaches the block, and whether it can bear that force.
    """

    block: int
    name: str
    robot: str
    answer: StageAnswer
    force: Floats
    moment: Floats
    reached: bool
    carried: bool

    def _summary(self) -> str:
        return f"'{self.robot}' holds '{self.name}', {self.answer.verdict}"

    @property
    def works(self) -> bool:
        """Whether the stage stands and the robot reaches and carries the block."""
        return self.answer.stands and self.reached and self.carried


@dataclass(frozen=True, eq=False)
class Turns(Answer):
    """An assembly by robots that take turns.

    Attributes
    ----------
    structure
    robots
    turns
        One per block, in the order of assembly, up to the first failure.
    complete
        Answer of the complete structure without holds; None if it was stopped before.
    """

    structure: StagedModel
    robots: tuple[Robot, ...]
    turns: tuple[Turn, ...]
    complete: StageAnswer | None

    @property
    def model(self) -> Model:
        """The complete model."""
        return self.structure.model

    def stage(self, number: int) -> Model:
        """The blocks in place after a turn, counted from 0; the one that is held is a support."""
        blocks = [one.block for one in self.turns[: number + 1]]
        return self.structure.cut_out(Stage(mask_of(blocks), 1 << blocks[-1]))[0]

    @property
    def works(self) -> bool:
        """Whether every stage works and the complete structure stands."""
        return self.complete is not None and self.complete.stands and self.turns[-1].works

    @property
    def largest(self) -> float:
        """[N], the largest force of a robot."""
        return max((one for one in self._holds if one >= 0.0), default=0.0)

    @property
    def _holds(self) -> list[float]:
        """Forces [N] of the robots; not a number where one cannot place its block."""
        nan, rows = float("nan"), self.turns
        return [float(np.linalg.norm(one.force)) if self._placed(one) else nan for one in rows]

    @cached_property
    def asked(self) -> Question:
        """What was asked."""
        asked = Question.of(self.model, None, self.when)
        return replace(asked, options={"robots": ", ".join(one.name for one in self.robots)})

    @property
    def _role(self) -> Role:
        """Good where it works; unsure where a stage is not known."""
        if self.works:
            return Role.GOOD
        last = self.turns[-1]
        fails = self.complete if last.works else last.answer
        unknown = fails is None or fails.verdict is Verdict.UNDECIDED
        return Role.UNSURE if unknown and not self.falls else Role.BAD

    @property
    def falls(self) -> bool:
        """Whether the complete structure falls, so that no order does."""
        return self.complete is not None and self.complete.verdict is Verdict.UNSTABLE

    @property
    def title(self) -> str:
        """Whether it can be built in turn."""
        props = permanent_words(self.structure, [one.block for one in self.turns])
        good = f"Can be assembled {f'with {props}' if props else 'without props'},"
        can = {Role.GOOD: good, Role.BAD: "Cannot be assembled"}
        told = can.get(self._role, "Not known whether it can be assembled")
        return f"{told} by {counted(len(self.robots), 'robot')} in turn"

    def sentences(self) -> Sequence[Sentence]:
        """Whether it can be built, the largest hold, and what the first failure is."""
        held = f"the largest force of a robot is {quantity(self.largest, 'N')}"
        how = "each robot carries its block and holds it until the next one is in place"
        whole = "" if self.complete is None else refusal(self.complete, self.structure)
        told = [
            f"{how}: its hold is the larger of its weight, carried, and the force that holds it "
            "then; a smaller one may do",
            whole if self.falls and not self.turns[-1].works else "",
            held if self.works else self.stopped or self._failure,
        ]
        return [Sentence(self.title, self._role), *map(Sentence, filter(None, told))]

    @property
    def _failure(self) -> str:
        """Why the last stage does not work."""
        names, last = self.model.assembly.names, self.turns[-1]
        if last.works and self.complete is not None:
            return refusal(self.complete, self.structure)
        robot, body = self._arm(last), self.model.assembly.blocks[last.block]
        if not self._placed(last):
            return why_not([robot], body.name, body.centroid, body.mass, turn=True)
        if not last.answer.stands:
            words = falling_words(last.answer, names) + last.answer.message
            return f"when '{last.robot}' holds '{last.name}': {words}"
        force = quantity(float(np.linalg.norm(last.force)), "N")
        most = quantity(robot.payload * STANDARD_GRAVITY, "N")
        return f"'{last.robot}' would hold '{last.name}' with {force}, and its payload is {most}"

    def _arm(self, turn: Turn) -> Robot:
        """The robot of a turn."""
        return next(one for one in self.robots if one.name == turn.robot)

    def _placed(self, turn: Turn) -> bool:
        """Whether the robot of a turn reaches its block and lifts it."""
        body = self.model.assembly.blocks[turn.block]
        return bool(self._arm(turn).manages(body.centroid, np.array(body.mass)))

    def tables(self) -> Sequence[Table]:
        """The turns."""
        rows = self.turns
        columns = {
            "step": [i + 1 for i in range(len(rows))],
            "block": [one.name for one in rows],
            "robot": [one.robot for one in rows],
            "hold": self._holds,
            "works": [one.works for one in rows],
        }
        return [Table("turns", columns, {"hold": "N"})]

    def numbers(self) -> Mapping[str, Any]:
        """Whether it works, and the force and moment of each hold."""
        return {
            "works": self.works,
            "complete": None if self.complete is None else self.complete.verdict,
            "largest_N": self.largest,
            "holds": [
                {"block": one.name, "robot": one.robot, "force": one.force, "moment": one.moment}
                for one in self.turns
                if self._placed(one)
            ],
        }

    def layers(self) -> Scene:
        """A stage for each block, and the complete structure if it was reached."""
        assembly = self.model.assembly
        apart = self.robots if len({one.base for one in self.robots}) > 1 else ()
        *early, last = self._stages(apart)
        told = "; ".join(one.text for one in self.sentences()[2:])
        stages = [
            *early,
            replace(last, headline=self.title, message=told, role=self._role),
        ]
        number = np.zeros(len(assembly), dtype=np.intp)
        number[[one.block for one in self.turns]] = np.arange(1, len(self.turns) + 1)
        return Scene(
            assembly, self.model.contacts, tuple(with_reach(self.structure, apart, stages)),
            f"drystone plan: {self.title}", {**self.asked.facts(), "Turns": self.title},
            number, still=-1, opens=-1, preset="stages" if len(stages) > 1 else "solid",
        )  # fmt: skip

    def _stages(self, apart: Sequence[Robot]) -> Iterator[SceneStage]:
        """A stage for each turn; where nobody places its block, the one before still holds."""
        assembly = self.model.assembly
        state = np.where(assembly.fixed, State.SUPPORT, State.ABSENT)
        arms, seen, answer = dict[int, Robot](), list[int](), StageAnswer(Verdict.STABLE)
        for i, one in enumerate(self.turns):
            label = f"step {i + 1} of {len(assembly.free)}: {one.name}"
            missing = () if self._placed(one) else outlined(
                assembly, [one.block], "left-out", "cannot be placed", "help"
            )  # fmt: skip
            seen.append(one.block)
            if not missing:
                state[state == State.HELD] = State.FREE
                state[one.block], answer = State.HELD, one.answer
                arms = {one.block: self._arm(one)} if apart else {}
            stage = stage_of(self.structure, label, "", state.copy(), answer, True)
            stage = with_arms(assembly, arms, seen, stage)
            yield replace(stage, layers=(*stage.layers, *missing))
        if self.complete is not None and self.turns[-1].works:
            state[state == State.HELD] = State.FREE
            stage = stage_of(self.structure, "all blocks", "", state, self.complete, True)
            yield replace(stage, layers=(*stage.layers, self._hold_layer))

    @property
    def _hold_layer(self) -> Layer:
        """The force of every hold on its block, in one picture."""
        blocks = np.array([one.block for one in self.turns])
        label = "holds, each until the next block is in place"
        return Layer(
            "help", label, LayerKind.ARROWS, "help", self.model.assembly.centroid[blocks],
            np.array([one.force for one in self.turns]), block=blocks, single=True, width=2.4,
            group="help",
        )  # fmt: skip


@checked_call
def take_turns(
    given: Given,
    order: Sequence[int | str] | None = None,
    robots: Sequence[Robot] = PAIR,
    *,
    check: Check | None = None,
    **how: Unpack[LongHow],
) -> Turns:
    """Whether two or more robots can build a structure by holding the last block in turn.

    Parameters
    ----------
    given
        A model of the complete structure; or an assembly or a file that ``how`` turns into one.
    order
        Free blocks in the order of assembly; in numerical order when left out.
    robots
        Two or more. The first places the first block, the second the next one, and so on.
    check
        Function that gives the verdict on a stage. When left out:
        :data:`drystone.sequence.check_both`; the complete structure may also stand after settling.

    Raises
    ------
    InputError
        Fewer than two robots, no free block, or an order with a support, a repeated block or a
        missing block.

    Examples
    --------
    >>> from drystone.models import arch
    >>> found = take_turns(arch(0.3, 7), friction=0.7)
    >>> found.works, [turn.robot for turn in found.turns][:3]
    (True, ['left', 'right', 'left'])
    """
    team = check_robots(robots)
    if len(team) < 2:
        raise InputError(f"{len(team)} robots cannot take turns", remedy="give two or more")
    clock = Clock.of(how)
    structure = StagedModel(as_model(given, **how), check or check_both)
    assembly = structure.assembly
    blocks = assembly.free.tolist() if order is None else assembly.indices(order).tolist()
    if sorted(blocks) != assembly.free.tolist():
        raise InputError(
            "the order does not name all free blocks",
            where="order",
            remedy="name every block that is not a support once",
        )
    if not blocks:
        raise InputError("no block is free", where="supports", remedy="fix the supports only")
    with Evaluator(structure, executor=clock.workers, late=clock.late) as evaluator:
        found = in_turn(evaluator, blocks, team, clock)
        if found.works or found.stopped:
            return found
        with suppress(Stopped):
            complete, touching = finished_whole(evaluator, check)
            if touching is not None:  # these edges count in the turns too
                return take_turns(touching, order, robots, **clock.rest)
            return replace(found, complete=complete)
    return found


def in_turn(
    evaluator: Evaluator,
    blocks: Sequence[int],
    team: Sequence[Robot],
    clock: Clock,
    *,
    quick: bool = False,
) -> Turns:
    """Turns of a team that places blocks in this order, up to the first that fails.

    A ``quick`` look finds less of what stands, and ends at what may fall without a proof.
    """
    structure, turns = evaluator.model, list[Turn]()
    stages = [Stage(mask_of(blocks[: i + 1]), 1 << block, quick) for i, block in enumerate(blocks)]
    stages.append(Stage(structure.everything))
    complete = None
    with suppress(Stopped):
        for i, stage in enumerate(stages):
            if turns and clock.late():
                break
            ahead = stages[i + 1 : i + evaluator.batch]
            answer = evaluator.answers([stage], ahead=ahead, forces=not quick)[0]
            if i == len(blocks):
                complete = answer
                continue
            turns.append(_turn(evaluator, stage, blocks[i], team[i % len(team)], answer))
            clock.tell("turns", i + 1, len(blocks))
            if not turns[-1].works:
                return Turns(structure, tuple(team), tuple(turns), None)
    stopped = "" if complete is not None else clock.reason
    return Turns(structure, tuple(team), tuple(turns), complete, stopped=stopped)


def _turn(
    evaluator: Evaluator, stage: Stage, block: int, robot: Robot, answer: StageAnswer
) -> Turn:
    """A block that a robot places and holds, with the answer of its stage."""
    structure = evaluator.model
    body, carried = structure.assembly.blocks[block], -structure.load.wrench[block]
    wrench = answer.reaction.get(block, carried)
    if np.linalg.norm(wrench[:3]) > np.linalg.norm(carried[:3]):
        alone = evaluator.answer(stage._replace(held=0), forces=not stage.quick)
        answer, wrench = (alone, carried) if alone.stands else (answer, wrench)
    else:
        wrench = carried
    limit = np.full(len(structure.assembly), robot.payload)
    return Turn(
        block,
        body.name,
        robot.name,
        answer,
        wrench[:3],
        wrench[3:],
        bool(robot.distance(body.centroid) <= robot.reach),
        body.mass <= robot.payload and not overloads(answer, [block], limit, structure),
    )
