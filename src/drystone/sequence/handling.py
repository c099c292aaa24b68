"""A plan as data for robots: place and path of each block, the robot that places it, and the holds.

The joint angles of a robot arm are not calculated. The frame of a block has its origin at the
centroid; in place its axes are the world axes. All poses refer to that frame.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from itertools import combinations
from typing import Any, Unpack

import numpy as np
import shapely

from drystone.answer import Answer, Question, Role, Scene, Sentence, plain
from drystone.assembly import Assembly, Block
from drystone.base.arrays import Bools, Floats, dot
from drystone.base.display import OneLine, named
from drystone.base.errors import counted
from drystone.base.files import PathLike, write_text
from drystone.base.settings import Clock, LongWork, checked_call
from drystone.base.table import Table
from drystone.detection.patches import Patches, patches_of
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.planar import inside
from drystone.model import Model
from drystone.sequence.freedom import FACING, Joints
from drystone.sequence.margins import Margin, Margins
from drystone.sequence.path_search import NoPath, PathFinder, PathOptions, RemovalPath
from drystone.sequence.plan_steps import assigned
from drystone.sequence.plans import Plan
from drystone.sequence.robots import Robot, check_robots, why_not
from drystone.sequence.scaffolding import Scaffolding, item_numbers
from drystone.sequence.stages import members
from drystone.sequence.sweeps import Pose

COVERED = 0.01
"""Largest share of a face that joints may cover while it counts as free to grip. Chosen: a
neighbour may touch its edge."""
OPPOSITE = 0.996
"""Cosine between one face and the opposite of another above which a gripper can hold both: 5
degrees, chosen."""


@dataclass(frozen=True, eq=False)
class GripFace(OneLine):
    """A face without contact when the block is in place.

    Attributes
    ----------
    face
        Position in ``block.faces``; the first of those that lie in one plane, as triangles do.
    centre : (3,) [m]
        On the face: where it is widest, if its middle lies in a hole or beside it.
    normal : (3,) unit
        Outward. Both in the frame of the block.
    area : [m2]
    """

    face: int
    centre: Floats
    normal: Floats
    area: float


def grip_faces(body: Block, joints: Joints) -> list[GripFace]:
    """Faces of a block without any of the given joints, the largest first.

    Neighbours in one plane are one face.

    Parameters
    ----------
    body
    joints
        With the blocks that are in place.
    """
    flat = patches_of(Assembly((body,)))
    covered = np.zeros(flat.count)
    for joint in range(len(joints.other)):
        corner = joints.corner[joints.interface == joint]
        away = np.abs(dot(corner.mean(axis=0) - flat.origin - flat.centre, flat.normal))
        away[flat.normal @ joints.normal[joint] > -FACING] = np.inf
        area = np.cross(corner[1:-1] - corner[0], corner[2:] - corner[0]).sum(axis=0)
        covered[np.argmin(away)] += max(0.5 * float(np.linalg.norm(area)), 1e-300)
    found = [
        GripFace(
            int(flat.face[i]), _on_face(flat, int(i)) + flat.origin - body.centroid,
            flat.normal[i], float(flat.area[i]),
        )
        for i in np.flatnonzero((covered <= COVERED * flat.area) & (flat.area > 0.0))
    ]  # fmt: skip
    return sorted(found, key=lambda one: -one.area)


def _on_face(flat: Patches, patch: int) -> Floats:
    """The middle of a patch (3,) [m], else where it is widest.

    Opposite ones are seen alike, to a nanometre: rounding does not choose between equal places.
    """
    normal, centre = np.round(flat.normal[patch], 9), flat.centre[patch]
    frame = frames_from_normals(np.array([max(normal.tolist(), (-normal).tolist())]))[0, 1:]
    first, end = flat.first_ring[patch : patch + 2]
    rings = [
        np.round((flat.corner[flat.ring_start[k] : flat.ring_start[k + 1]] - centre) @ frame.T, 9)
        for k in range(first, end)
    ]
    shape = shapely.normalize(shapely.Polygon(rings[0], rings[1:]))
    return np.asarray(centre + inside(shape, np.zeros(2)) @ frame)


def grip_pairs(grips: Sequence[GripFace]) -> list[tuple[int, int, float]]:
    """Pairs of opposite faces, the largest first, and their distance."""
    out = []
    for (i, one), (j, other) in combinations(enumerate(grips), 2):
        width = float((one.centre - other.centre) @ one.normal)
        if one.normal @ other.normal < -OPPOSITE and width > 0.0:
            out.append((i, j, width))
    return out


@dataclass(frozen=True, eq=False)
class Placement(OneLine):
    """The placement of one block.

    Attributes
    ----------
    step
        Number of the step in the plan, from 1.
    name
    status
        How it is placed: free, held or propped (:class:`drystone.sequence.Status`).
    robot
        The robot that places it; empty if no robots were given, or none can place it.
    reach_spare : [m]
        What that robot could reach farther than to the block in place; infinite without limit.
    frame : (4, 4)
        Frame of the block in place.
    approach : (p, 4, 4)
        Frames on the path into place, the last one in place; empty if no path was found. The first
        is where the path enters the reach of the robot.
    clearance : (p,) [m]
        Distance from the blocks in place at each of them, at least.
    insertion : (3,) unit
        Direction in which its centroid moves into place: that of the end of the path; where no path
        was found, a direction that the joints leave free.
    turning
        Whether the block rotates on the path.
    mass : [kg]
    grips
        Faces to grip, the largest first.
    pairs
        Pairs of opposite faces: positions in ``grips``, and the distance [m] that a gripper must
        open.
    props
        Names of the blocks that are propped after the step.
    friction_used
        Largest share of its friction that a joint uses after the step.
    margins
        Of the stage after the step; None where it was not asked.
    """

    step: int
    name: str
    status: str
    robot: str
    reach_spare: float
    frame: Floats
    approach: Floats
    clearance: Floats
    insertion: Floats
    turning: bool
    mass: float
    grips: tuple[GripFace, ...]
    pairs: tuple[tuple[int, int, float], ...]
    props: tuple[str, ...]
    friction_used: float
    margins: Margin | None = None


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
        Largest force and moment of the hold, about the centroid; less may hold it too.
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
    scaffolding
        What holds the blocks that are propped, where it was found.
    """

    plan: Plan
    robots: tuple[Robot, ...]
    placements: tuple[Placement, ...]
    holds: tuple[Hold, ...]
    notes: tuple[str, ...]
    scaffolding: Scaffolding | None = None

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
        placed = sum(bool(one.robot) for one in self.placements)
        share = f"{placed} of " if self.robots and placed < len(self.placements) else ""
        return f"{share}{counted(len(self.placements), 'block')} placed{robots}"

    def sentences(self) -> Sequence[Sentence]:
        """How many blocks are placed, and what no robot can do."""
        role = Role.BAD if self.notes or not self.plan.stable else Role.GOOD
        told = [*self.notes, *(["less than the forces of the holds may do"] if self.holds else [])]
        return [Sentence(self.title, role), *(Sentence(one, Role.REMARK) for one in told)]

    def layers(self) -> Scene:
        """The stages of the plan, with the robots."""
        rules = replace(self.plan.rules, robots=self.robots)
        return replace(self.plan, rules=rules).layers()

    def props_during(self, hold: Hold) -> tuple[str, ...]:
        """Names of the blocks in place before a hold that stay propped until it ends."""
        names, steps = self.model.assembly.names, self.plan.steps
        number = self.plan.step_of[names.index(hold.name)]
        before = steps[number - 1].props if number else ()
        stay = dict.fromkeys((*before, *steps[number].props))
        return tuple(names[block] for block in stay if block not in steps[number].blocks)

    def props_removed(self, placement: Placement) -> tuple[str, ...]:
        """Names of the blocks whose props are taken away after a placement, before the next one."""
        names, steps = self.model.assembly.names, self.plan.steps
        step, before = steps[placement.step - 1], steps[placement.step - 2]
        if placement.step == 1 or placement.name != names[step.blocks[-1]]:
            return ()
        return tuple(names[b] for b in before.props if b not in step.props)

    def _items(self) -> list[dict[str, Any]]:
        """The items of the scaffolding, with the first and last step after which each stands."""
        names = self.model.assembly.names
        when = {at: one for one in self.plan.props for at in (one.block, names[one.block])}
        return [
            {
                "kind": type(item).__name__.lower(),
                **item_numbers(item),
                "block": names[when[item.block].block],
                "first_step": when[item.block].first + 1,
                "last_step": when[item.block].last + 1,
            }
            for item in (() if self.scaffolding is None else self.scaffolding.items)
        ]

    def numbers(self) -> Mapping[str, Any]:
        """Robots, placements, holds and props; lengths in m, masses in kg, forces in N."""
        return {
            "format": "drystone-handling",
            "version": 4,
            "robots": plain(self.robots),
            "placements": [
                {**plain(one), "props_removed": self.props_removed(one)} for one in self.placements
            ],
            "holds": [{**plain(one), "props": self.props_during(one)} for one in self.holds],
            "props": plain(self.plan.numbers()["props"]),
            "scaffold": plain(self._items()),
            "notes": list(self.notes),
        }

    def tables(self) -> Sequence[Table]:
        """A row per placement: robot, mass, position, path, grips, hold, props and margins."""
        held = {one.name: (one, " ".join(self.props_during(one))) for one in self.holds}
        rows = [
            {
                **_row(one, *held.get(one.name, (None, ""))),
                "props_removed": " ".join(self.props_removed(one)),
                **({} if one.margins is None else asdict(one.margins)),
            }
            for one in self.placements
        ]
        columns = {key: [row[key] for row in rows] for key in rows[0]} if rows else {"step": []}
        units = dict.fromkeys(("reach_spare", "at", "grip"), "m")
        units |= {"mass": "kg", "hold": "N", "tilt": "deg"}
        return [Table("handling", columns, {key: units[key] for key in columns if key in units})]

    def save_json(self, path: PathLike) -> None:
        """Write everything as JSON, to a temporary name beside it that is then renamed."""
        text = json.dumps(self.to_dict(), indent=1, allow_nan=False)
        write_text(path, text + "\n")


@checked_call
def handling(
    plan: Plan,
    robots: Sequence[Robot] = (),
    *,
    margins: Margins | None = None,
    scaffolding: Scaffolding | None = None,
    options: PathOptions | None = None,
    **work: Unpack[LongWork],
) -> Handling:
    """The placements and holds of a plan, for robots.

    It ends before the first stage that is not known to stand, and a note says so. Robots take
    turns as far as they reach and carry the blocks; one that holds a block places none. A note
    names each block that has no robot. Ended early, the first placements are there, and a note
    says so.

    Parameters
    ----------
    plan
        A plan; without steps it has no placements.
    robots
        When left out, placements have no robot.
    margins
        Of the stages of the plan, from :func:`margins`, to be told with the placements.
    scaffolding
        Of the plan, from :func:`scaffolding`, to be told beside its props.
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
    clock = Clock.of(work)
    paths = list(clock.answers(partial(_path, finder), jobs, "paths of insertion"))
    notes = list(plan.notes)
    ends = plan.steps[plan.known_steps :]
    if ends:
        name, answers = model.assembly.names[ends[0].blocks[0]], (*ends[0].during, ends[0].answer)
        why = next(one.message for one in answers if not one.stands)
        notes.append(f"ends before '{name}' is placed: {why}")
    if len(paths) < len(jobs):
        notes.append(f"{clock.reason} after {len(paths)} of {counted(len(jobs), 'path')}")
    placements: list[Placement] = []
    holds: list[Hold] = []
    chosen = assigned(plan, team)
    notes += without_robot(plan, team)
    for (number, block, here), found in zip(jobs, paths, strict=False):
        step, body = plan.steps[number], model.assembly.blocks[block]
        arm = team[chosen[block]] if block in chosen else None
        robot = "" if arm is None else arm.name
        if isinstance(found, NoPath):
            notes.append(f"'{body.name}': no path was found: {found.reason}")
        elif arm is not None:
            found = _within(arm, found, finder, here)
        grips = grip_faces(body, Joints.of(model.contacts, block, here))
        margin = None if margins is None else margins.stages[number]
        placements.append(_placed(plan, number, block, arm, found, grips, margin))
        if block != step.blocks[-1]:
            most = step.hold(block)
            last = model.assembly.names[step.blocks[-1]]
            holds.append(Hold(body.name, robot, last, most[:3], most[3:]))
    return Handling(plan, team, tuple(placements), tuple(holds), tuple(notes), scaffolding)


def _in_order(plan: Plan) -> Iterator[tuple[int, int, Bools]]:
    """Step of each block in the order of placement, the block, and the blocks (n,) in place."""
    for number, step in enumerate(plan.steps[: plan.known_steps]):
        here = np.array(plan.model.assembly.fixed)
        here[list(members(plan.before(number)))] = True
        for block in step.blocks:
            here[block] = True
            yield number, block, here.copy()


def _path(finder: PathFinder, job: tuple[int, int, Bools]) -> RemovalPath | NoPath:
    return finder.path(*job[1:])


def without_robot(plan: Plan, robots: Sequence[Robot]) -> list[str]:
    """A line for each block of a plan that no robot can place while the others hold theirs.

    Parameters
    ----------
    plan
        Its steps that are known are looked at.
    robots
        The team; no two have one name.
    """
    team, notes = check_robots(robots), []
    chosen = assigned(plan, team)
    for step in plan.steps[: plan.known_steps]:
        for block in {*step.blocks} - {*chosen} if team else ():
            body = plan.model.assembly.blocks[block]
            able = [
                f"'{one.name}'" for one in team if one.manages(body.centroid, np.array(body.mass))
            ]
            why = f"{named(able)} could place it, and must hold another block"
            why = why if able else why_not(team, body.name, body.centroid, body.mass)
            notes.append(f"'{body.name}': {why}")
    return notes


def _within(robot: Robot, path: RemovalPath, finder: PathFinder, here: Bools) -> RemovalPath:
    """A path of removal as far as the reach of a robot goes; blocks ``here`` (n,) are in place."""
    from scipy.spatial.transform import Rotation, Slerp  # slow to import

    centroid = finder.model.assembly.centroid[path.block]
    places = np.array([pose.turn @ centroid + pose.shift for pose in path.poses])
    outside = np.flatnonzero(robot.distance(places) > robot.reach)
    if not len(outside):
        return path
    first = int(outside[0])
    start, end = places[first - 1 : first + 1] - np.array(robot.base)
    way = end - start
    squared, along = way @ way, start @ way
    part = (-along + np.sqrt(along**2 - squared * (start @ start - robot.reach**2))) / squared
    turns = Rotation.from_matrix(
        np.stack([pose.turn for pose in path.poses[first - 1 : first + 1]])
    )
    turn = Slerp([0.0, 1.0], turns)(part).as_matrix()
    last = Pose(turn, places[first - 1] + part * way - turn @ centroid)
    gap = finder.clearance(path.block, here, last)
    poses = (*path.poses[:first], last)
    return replace(path, poses=poses, clearance=np.append(path.clearance[:first], gap))


def _placed(
    plan: Plan,
    number: int,
    block: int,
    robot: Robot | None,
    found: RemovalPath | NoPath,
    grips: list[GripFace],
    margins: Margin | None,
) -> Placement:
    assembly = plan.model.assembly
    step, body, names = plan.steps[number], assembly.blocks[block], assembly.names
    frame = np.eye(4)
    frame[:3, 3] = body.centroid
    approach, clearance, turning = np.zeros((0, 4, 4)), np.zeros(0), False
    insertion = step.motion[step.blocks.index(block)]
    if isinstance(found, RemovalPath):
        approach, clearance, turning = found.approach @ frame, found.clearance[::-1], found.turning
        last = np.diff(approach[-2:, :3, 3], axis=0).sum(axis=0)
        insertion = last / np.linalg.norm(last) if last.any() else insertion
    return Placement(
        step=number + 1,
        name=body.name,
        status=plan.status[block].value,
        robot="" if robot is None else robot.name,
        reach_spare=np.inf if robot is None else robot.reach - float(robot.distance(body.centroid)),
        frame=frame,
        approach=approach,
        clearance=clearance,
        insertion=insertion,
        turning=turning,
        mass=body.mass,
        grips=tuple(grips),
        pairs=tuple(grip_pairs(grips)),
        props=tuple(names[b] for b in step.props),
        friction_used=step.answer.used,
        margins=margins,
    )


def _row(one: Placement, hold: Hold | None, kept: str) -> dict[str, object]:
    return {
        "step": one.step,
        "block": one.name,
        "status": one.status,
        "robot": one.robot,
        "mass": one.mass,
        "at": tuple(one.frame[:3, 3].tolist()),
        "insertion": tuple(one.insertion.tolist()),
        "reach_spare": one.reach_spare,
        "turning": one.turning,
        "poses": len(one.approach),
        "grip_faces": " ".join(str(grip.face) for grip in one.grips),
        "grip": one.pairs[0][2] if one.pairs else np.nan,
        "held_until": "" if hold is None else hold.until,
        "hold": 0.0 if hold is None else float(np.linalg.norm(hold.force)),
        "props_during_hold": kept,
        "props": " ".join(one.props),
        "friction_used": one.friction_used,
    }
