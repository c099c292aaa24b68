"""Robots: base, reach and payload; and whether two can build in turn.

Two robots that take turns need no other support: one holds the last block while the other places
the next one. A block is released when the next one is in place and held, so in every stage the last
block is held. Source: Kao 2023, section 6.4.2; Parascho et al. 2020 ("Robotic vault", sequential
assembly of an arch by two robots).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Unpack

import numpy as np

from drystone.base.arrays import Bools, Floats, frozen_floats, number
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Stopped, Workers
from drystone.base.settings import checked_call
from drystone.io.opening import Given, How, as_model
from drystone.loads import STANDARD_GRAVITY
from drystone.results import Verdict
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.stages import Check, Stage, StageAnswer, StagedModel, check_both, mask_of

FAR = "out of reach"
"""How the reason begins where no robot reaches a block."""


@dataclass(frozen=True)
class Robot(OneLine):
    """A robot arm that places blocks and may hold one.

    Attributes
    ----------
    name
    base : (3,) [m]
        Position of its first axis.
    reach : [m]
        Farthest distance from the base at which it can hold the centroid of a block.
    payload : [kg]
        Heaviest block that it carries. The holding force is limited to the weight of this mass.
    """

    name: str
    base: tuple[float, float, float] = (0.0, 0.0, 0.0)
    reach: float = float("inf")
    payload: float = float("inf")

    def __post_init__(self) -> None:
        where = f"robot '{self.name}'"
        if not isinstance(self.name, str) or not self.name:
            raise InputError("a robot needs a name", remedy="give a non-empty string")
        base = frozen_floats(self.base, (3,), f"{where}: its base")
        for word, value in (("reach", self.reach), ("payload", self.payload)):
            if not number(value, f"{where}: its {word}", finite=False) > 0.0:
                raise InputError(f"its {word} is {value}", where=where, remedy="give more than 0")
        object.__setattr__(self, "base", tuple(base.tolist()))

    def distance(self, points: Floats) -> Floats:
        """[m] (p,) from its base to points (p, 3) [m]."""
        out: Floats = np.linalg.norm(np.asarray(points) - np.array(self.base), axis=-1)
        return out

    def manages(self, centroid: Floats, mass: Floats) -> Bools:
        """Whether it reaches and carries blocks with centroids (n, 3) [m] and masses (n,) [kg]."""
        out: Bools = (self.distance(centroid) <= self.reach) & (
            np.asarray(mass) <= self.payload * (1.0 + 1e-9)
        )
        return out


def check_robots(robots: Sequence[Robot]) -> tuple[Robot, ...]:
    """Robots whose names differ.

    Raises
    ------
    InputError
        Two robots have the same name, or one is no robot.
    """
    for robot in robots:
        if not isinstance(robot, Robot):
            raise InputError(f"a {type(robot).__name__} is no robot", where="robots")
    names = [robot.name for robot in robots]
    if len(set(names)) != len(names):
        raise InputError(
            "two robots have the same name", where="robots", remedy="rename one of them"
        )
    return tuple(robots)


def why_not(robots: Sequence[Robot], name: str, centroid: Floats, mass: float) -> str:
    """Why no robot can place a block: it is out of reach, or too heavy."""
    near = [robot for robot in robots if robot.distance(centroid) <= robot.reach]
    if near:
        strong = max(near, key=lambda robot: robot.payload)
        return (
            f"too heavy: '{name}' has {mass:.4g} kg, and '{strong.name}', the strongest robot that "
            f"reaches it, carries {strong.payload:.4g} kg"
        )
    short = min(robots, key=lambda robot: float(robot.distance(centroid)) - robot.reach)
    missing = float(short.distance(centroid)) - short.reach
    return f"{FAR}: '{name}' is {missing:.3g} m too far for '{short.name}', the nearest robot"


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
    structure = StagedModel(as_model(given, **how), check)
    assembly = structure.assembly
    blocks = assembly.free.tolist() if order is None else assembly.indices(order).tolist()
    if sorted(blocks) != assembly.free.tolist():
        raise InputError(
            "the order does not name all free blocks",
            where="order",
            remedy="name every block that is not a support once",
        )
    stages = [Stage(mask_of(blocks[: i + 1]), 1 << block) for i, block in enumerate(blocks)]
    stages.append(Stage(structure.everything))
    clock = Clock(time_limit_s, stop)
    turns: list[Turn] = []
    with Evaluator(structure, executor=executor, late=clock.late) as evaluator, suppress(Stopped):
        for i, stage in enumerate(stages):
            if clock.late():
                break
            answer = evaluator.answers([stage], ahead=stages[i + 1 : i + evaluator.batch])[0]
            if i == len(blocks):
                return Turns(tuple(turns), answer.verdict)
            turns.append(_turn(structure, blocks[i], team[i % len(team)], answer))
            if progress is not None:
                progress("turns", i + 1, len(blocks))
            if not turns[-1].works:
                return Turns(tuple(turns), None)
    return Turns(tuple(turns), None, clock.reason)


def _turn(structure: StagedModel, block: int, robot: Robot, answer: StageAnswer) -> Turn:
    """A block that a robot places and holds, with the answer of its stage."""
    wrench = answer.reaction.get(block, -structure.load.wrench[block])
    body = structure.assembly.blocks[block]
    force = float(np.linalg.norm(wrench[:3]))
    return Turn(
        block,
        body.name,
        robot.name,
        answer.verdict,
        tuple(structure.assembly.names[b] for b in answer.falling),
        wrench[:3],
        wrench[3:],
        bool(robot.distance(body.centroid) <= robot.reach),
        body.mass <= robot.payload and force <= (1.0 + 1e-6) * robot.payload * STANDARD_GRAVITY,
    )
