"""Two robots that take turns: one holds the last block while the other places the next one.

There is no other support. A block is released when the next one is in place and held, so in every
stage the last block is held. Source: Kao 2023, section 6.4.2; Parascho et al. 2020 ("Robotic
vault", sequential assembly of an arch by two robots).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Unpack

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, How, as_model
from drystone.results import Verdict
from drystone.sequence.robots import Robot, check_robots
from drystone.sequence.stage_checks import Check, check_both
from drystone.sequence.stages import Stage, StageAnswer, mask_of
from drystone.sequence.structure import Structure

GRAVITY = 9.81
"""[m/s2], converts a payload to a force."""


@dataclass(frozen=True, eq=False)
class Turn(OneLine):
    """One block placed and held.

    Attributes
    ----------
    block, name
    robot
        The robot that places it, and holds it until the next one is in place.
    verdict
        Verdict on the stage with this block held and all earlier ones released.
    falling
        Names of the falling blocks.
    force : (3,) [N]
    moment : (3,) [N m]
        Force and moment of the robot, about the centroid of the block.
    reached, carried
        Whether the robot reaches the block, and whether it can carry the block and that force.
    """

    block: int
    name: str
    robot: str
    verdict: Verdict
    falling: tuple[str, ...]
    force: Floats
    moment: Floats
    reached: bool
    carried: bool

    @property
    def works(self) -> bool:
        """Whether the stage stands and the robot reaches and carries the block."""
        return self.verdict is Verdict.STABLE and self.reached and self.carried


@dataclass(frozen=True, eq=False)
class Turns(OneLine):
    """An assembly by robots that take turns.

    Attributes
    ----------
    turns
        One per block, in the order of assembly, up to the first failure.
    complete
        Verdict on the complete structure without holds; None if it was not reached.
    stopped
        Why it was ended early; empty otherwise.
    """

    turns: tuple[Turn, ...]
    complete: Verdict | None
    stopped: str = ""

    @property
    def works(self) -> bool:
        """Whether every stage works and the complete structure stands."""
        return self.complete is Verdict.STABLE and all(turn.works for turn in self.turns)

    @property
    def largest(self) -> float:
        """[N], the largest force of a robot."""
        return max((float(np.linalg.norm(turn.force)) for turn in self.turns), default=0.0)


@checked_call
def take_turns(
    given: Given,
    order: Sequence[int | str] | None = None,
    robots: Sequence[Robot] = (Robot("left"), Robot("right")),
    *,
    check: Check = check_both,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
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
        Function that gives the verdict on a stage.

    Raises
    ------
    InputError
        Fewer than two robots, or an order with a support, a repeated block or a missing block.

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
    structure = Structure(as_model(given, **how), check)
    assembly = structure.assembly
    blocks = assembly.free.tolist() if order is None else assembly.indices(order).tolist()
    if sorted(blocks) != assembly.free.tolist():
        raise InputError(
            "the order does not name all free blocks",
            where="order",
            remedy="name every block that is not a support once",
        )
    stages = [
        Stage(mask_of(blocks[: number + 1]), mask_of([block]))
        for number, block in enumerate(blocks)
    ]
    stages.append(Stage(structure.everything))
    clock = Clock(time_limit_s, stop)
    with WorkerPool(executor) as pool:
        found = pool.answers(partial(_answer, structure), stages, clock.late)
        return _turns(structure, blocks, team, found, progress, clock)


def _answer(structure: Structure, stage: Stage) -> StageAnswer:
    stage = Stage(*stage)
    return structure.combine(stage, [structure.solve(part) for part in structure.parts(stage)])


def _turns(
    structure: Structure,
    blocks: Sequence[int],
    team: Sequence[Robot],
    answers: Iterator[StageAnswer],
    progress: Progress | None,
    clock: Clock,
) -> Turns:
    """The turns from the answers of their stages, and that of the complete structure."""
    assembly = structure.assembly
    turns: list[Turn] = []
    for number, (block, answer) in enumerate(zip(blocks, answers, strict=False)):
        robot = team[number % len(team)]
        wrench = answer.reaction.get(block, -structure.load.wrench[block])
        body = assembly.blocks[block]
        force = float(np.linalg.norm(wrench[:3]))
        turns.append(
            Turn(
                block,
                body.name,
                robot.name,
                answer.verdict,
                tuple(assembly.names[b] for b in answer.falling),
                wrench[:3],
                wrench[3:],
                bool(robot.distance(body.centroid) <= robot.reach),
                body.mass <= robot.payload and force <= (1.0 + 1e-6) * robot.payload * GRAVITY,
            )
        )
        if progress is not None:
            progress("turns", number + 1, len(blocks))
        if not turns[-1].works:
            return Turns(tuple(turns), None)
    whole = next(answers, None)
    return Turns(tuple(turns), None if whole is None else whole.verdict, clock.reason)
