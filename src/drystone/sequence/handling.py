"""A plan as data for robots: place and path of each block, the robot that places it, and the holds.

The joint angles of a robot arm are not calculated. The frame of a block has its origin at the
centroid; in place its axes are the world axes. All poses refer to that frame.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from drystone.answer import Answer, Question, Role, Scene, Sentence, plain
from drystone.assembly import Block
from drystone.base.arrays import Bools, Floats
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.base.files import PathLike, write_text
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.table import Table
from drystone.base.workers import WorkerPool
from drystone.model import Model
from drystone.sequence.freedom import Joints
from drystone.sequence.grips import GripFace, grip_faces, grip_pairs
from drystone.sequence.path_search import PathFinder
from drystone.sequence.plans import Plan
from drystone.sequence.removal_paths import NoPath, PathOptions, RemovalPath
from drystone.sequence.robots import Robot, check_robots, why_not
from drystone.sequence.stages import members


@dataclass(frozen=True, eq=False)
class Placement(OneLine):
    """The placement of one block.

    Attributes
    ----------
    step
        Number of the step in the plan, from 0.
    name
    robot
        The robot that places it; empty if no robots were given, or none can place it.
    frame : (4, 4)
        Frame of the block in place.
    approach : (p, 4, 4)
        Frames on the path into place, the last one in place; empty if no path was found.
    clearance : (p,) [m]
        Distance from the blocks in place at each of them.
    turning
        Whether the block rotates on the path.
    mass : [kg]
    grips
        Faces to grip, the largest first.
    pairs
        Pairs of opposite faces: positions in ``grips``, and the distance [m] that a gripper must
        open.
    """

    step: int
    name: str
    robot: str
    frame: Floats
    approach: Floats
    clearance: Floats
    turning: bool
    mass: float
    grips: tuple[GripFace, ...]
    pairs: tuple[tuple[int, int, float], ...]


@dataclass(frozen=True, eq=False)
class Hold(OneLine):
    """A block that is held until another one is in place.

    Attributes
    ----------
    name
    robot
        The robot that holds it; empty if no robots were given.
    until
        Name of the block after whose placement it is released.
    force : (3,) [N]
    moment : (3,) [N m]
        Largest force and moment of the hold, about the centroid.
    """

    name: str
    robot: str
    until: str
    force: Floats
    moment: Floats


@dataclass(frozen=True, eq=False)
class Handling(Answer):
    """All placements and holds of a plan, in their order.

    Attributes
    ----------
    plan
    robots
    placements, holds
    notes
        Placements that no robot can do, blocks without a path, blocks that cannot be placed, and
        why it ends before the plan does, one sentence each.
    """

    plan: Plan
    robots: tuple[Robot, ...]
    placements: tuple[Placement, ...]
    holds: tuple[Hold, ...]
    notes: tuple[str, ...]

    @property
    def model(self) -> Model:
        """That of the plan."""
        return self.plan.model.model

    @cached_property
    def asked(self) -> Question:
        """What was asked of the plan."""
        return self.plan.asked

    @property
    def title(self) -> str:
        """How many blocks are placed, and by how many robots."""
        robots = f" by {counted(len(self.robots), 'robot')}" if self.robots else ""
        return f"{counted(len(self.placements), 'block')} placed{robots}"

    def sentences(self) -> Sequence[Sentence]:
        """How many blocks are placed, and what no robot can do."""
        role = Role.BAD if self.notes or not self.plan.stable else Role.GOOD
        return [Sentence(self.title, role), *(Sentence(one, Role.REMARK) for one in self.notes)]

    def tables(self) -> Sequence[Table]:
        """The placements."""
        return [self.table()]

    def layers(self) -> Scene:
        """The stages of the plan."""
        return self.plan.layers()

    def numbers(self) -> Mapping[str, Any]:
        """Robots, placements, holds and props; lengths in m, masses in kg, forces in N."""
        return {
            "format": "drystone-handling",
            "version": 2,
            "robots": plain(self.robots),
            "placements": plain(self.placements),
            "holds": plain(self.holds),
            "props": plain(self.plan.numbers()["props"]),
            "notes": list(self.notes),
        }

    def table(self) -> Table:
        """A row per placement: robot, mass, position, path and grips, and its hold."""
        keys = (
            "step", "block", "robot", "mass", "at", "turning", "poses", "grip_faces", "grip",
            "held_until", "hold",
        )  # fmt: skip
        held = {one.name: one for one in self.holds}
        rows = [_row(one, held.get(one.name)) for one in self.placements]
        columns = {key: [row[i] for row in rows] for i, key in enumerate(keys)}
        return Table("handling", columns, {"mass": "kg", "at": "m", "grip": "m", "hold": "N"})

    def save_json(self, path: PathLike) -> None:
        """Write everything as JSON, to a temporary name beside it that is then renamed."""
        text = json.dumps(self.to_dict(), indent=1, allow_nan=False)
        write_text(path, text + "\n")


@checked_call
def handling(
    plan: Plan,
    robots: Sequence[Robot] = (),
    *,
    options: PathOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
) -> Handling:
    """The placements and holds of a plan, for robots.

    It ends before the first stage that is not known to stand, and a note says so. Robots take
    turns. The next robot in the list places the next block; robots that hold a block or cannot
    place it are skipped. Ended early, the first placements are there and a note says so.

    Parameters
    ----------
    plan
        A plan; without steps it has no placements.
    robots
        When left out, placements have no robot.
    options
        Options of the search for paths; up is opposite to the load unless given.

    Examples
    --------
    >>> from drystone.models import tower
    >>> from drystone.sequence import plan
    >>> work = handling(plan(tower(3)), [Robot("left"), Robot("right")])
    >>> [(one.name, one.robot) for one in work.placements]
    [('block-1', 'left'), ('block-2', 'right')]
    """
    team = check_robots(robots)
    model = plan.model.model
    up = plan.model.up.tolist()
    finder = PathFinder(model, options if options is not None else PathOptions(up=tuple(up)))
    jobs = list(_in_order(plan))
    clock = Clock(time_limit_s, stop)
    paths: list[RemovalPath | NoPath] = []
    with WorkerPool(executor) as pool:
        for found in pool.answers(partial(_path, finder), jobs, clock.late):
            paths.append(found)
            if progress is not None:
                progress("paths of insertion", len(paths), len(jobs))
    notes = list(plan.notes)
    ends = plan.steps[_known(plan) :]
    if ends:
        name, answers = model.assembly.names[ends[0].blocks[0]], (*ends[0].during, ends[0].answer)
        why = next(one.message for one in answers if not one.stands)
        notes.append(f"ends before '{name}' is placed: {why}")
    if len(paths) < len(jobs):
        notes.append(f"{clock.reason} after {len(paths)} of {counted(len(jobs), 'path')}")
    placements: list[Placement] = []
    holds: list[Hold] = []
    turn, busy = 0, set[int]()
    for (number, block, here), found in zip(jobs, paths, strict=False):
        step, body = plan.steps[number], model.assembly.blocks[block]
        busy = busy if block != step.blocks[0] else set()
        who = _next(team, turn, busy, body)
        if who is None and team:
            free = [robot for i, robot in enumerate(team) if i not in busy]
            notes.append(f"'{body.name}': {_why_none(free, body)}")
        robot = "" if who is None else team[who].name
        if isinstance(found, NoPath):
            notes.append(f"'{body.name}': no path was found: {found.reason}")
        grips = grip_faces(body, Joints.of(model.contacts, block, here))
        placements.append(_placed(number, body, robot, found, grips))
        if block != step.blocks[-1]:
            wrench = [a.reaction[block] for a in step.during if block in a.reaction]
            most = max(wrench, key=lambda w: float(np.linalg.norm(w[:3])), default=np.zeros(6))
            last = model.assembly.names[step.blocks[-1]]
            holds.append(Hold(body.name, robot, last, most[:3], most[3:]))
            busy |= set() if who is None else {who}
        turn = turn if who is None else who + 1
    return Handling(plan, team, tuple(placements), tuple(holds), tuple(notes))


def _known(plan: Plan) -> int:
    """The number of steps before the first stage that is not known to stand."""
    answers = [(*step.during, step.answer) for step in plan.steps]
    stands = [all(one.stands for one in some) for some in answers]
    return [*stands, False].index(False)


def _in_order(plan: Plan) -> Iterator[tuple[int, int, Bools]]:
    """Step of each block in the order of placement, the block, and the blocks (n,) in place."""
    for number, step in enumerate(plan.steps[: _known(plan)]):
        here = np.array(plan.model.assembly.fixed)
        here[list(members(plan.before(number)))] = True
        for block in step.blocks:
            here[block] = True
            yield number, block, here.copy()


def _path(finder: PathFinder, job: tuple[int, int, Bools]) -> RemovalPath | NoPath:
    return finder.path(*job[1:])


def _next(team: Sequence[Robot], turn: int, busy: set[int], body: Block) -> int | None:
    """The next robot that can place a block."""
    for i in range(len(team)):
        who = (turn + i) % len(team)
        if who not in busy and bool(team[who].manages(body.centroid, np.array(body.mass))):
            return who
    return None


def _why_none(free: Sequence[Robot], body: Block) -> str:
    if not free:
        return "every robot holds another block"
    return why_not(free, body.name, body.centroid, body.mass)


def _placed(
    step: int, body: Block, robot: str, found: RemovalPath | NoPath, grips: list[GripFace]
) -> Placement:
    frame = np.eye(4)
    frame[:3, 3] = body.centroid
    approach, clearance, turning = np.zeros((0, 4, 4)), np.zeros(0), False
    if isinstance(found, RemovalPath):
        approach, clearance, turning = found.approach @ frame, found.clearance[::-1], found.turning
    pairs = tuple(grip_pairs(grips))
    return Placement(
        step, body.name, robot, frame, approach, clearance, turning, body.mass, tuple(grips), pairs
    )


def _row(one: Placement, hold: Hold | None) -> tuple[object, ...]:
    faces = " ".join(str(grip.face) for grip in one.grips)
    wide = one.pairs[0][2] if one.pairs else np.nan
    until, force = ("", 0.0) if hold is None else (hold.until, float(np.linalg.norm(hold.force)))
    at = tuple(one.frame[:3, 3].tolist())
    return (
        one.step + 1, one.name, one.robot, one.mass, at, one.turning, len(one.approach), faces,
        wide, until, force,
    )  # fmt: skip
