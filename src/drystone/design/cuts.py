"""A shape cut into blocks that stand: cut, check, plan, and cut again where the plan needs help.

The cuts are made from the bottom up. All blocks below a cut are fixed. The part above is one block;
it must stand on the cut face by contact and friction. Each place has a list of cuts, in the order
of preference: the horizontal plane, planes turned about the horizontal edge across the lean,
notches, and the same at other heights. A place takes its first cut on which the part above stands.
The blocks are planned; where one is not free, the loop goes back to the cut under it and takes the
next one. Where a place has no cut left, the place below takes its next one.

Source: Kao et al. 2022 (design loop of stability-aware blocks); Kao 2023, chapter 7.3 (discretise,
check, modify, sequence, and back).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from drystone.answer import Answer, Question, Role, Scene, Sentence
from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, frozen_floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import Options, checked_call
from drystone.base.table import Table
from drystone.geometry.frames import rotation_about, unit
from drystone.geometry.glue import cut_cell, glue
from drystone.geometry.polyhedron import Piece
from drystone.model import Model
from drystone.results import Result
from drystone.sequence import Plan, PlanOptions, Status, check_both, plan

UP = np.array([0.0, 0.0, 1.0])
UPRIGHT = 1e-3
"""Lean, as a share of the height, below which the edge of turned cuts lies along y."""


@dataclass(frozen=True, eq=False)
class Cut(OneLine):
    """A plane, or a wedge of two planes, between a part below and a part above.

    Attributes
    ----------
    point : (3,) [m]
        On the plane; on the edge of the wedge.
    normal : (3,)
        Towards the part above.
    wedge_deg : [degrees]
        Angle of each plane of a wedge to the plane of ``normal``. Positive: the part above sits in
        a groove. Zero for a plane, negative for a ridge.
    edge : (3,)
        Direction of the wedge's edge.
    """

    point: Floats
    normal: Floats
    wedge_deg: float = 0.0
    edge: Floats | None = None

    def planes(self) -> tuple[Floats, Floats]:
        """Normals and points (p, 3) of the half spaces of the part above a plane or a groove."""
        point = frozen_floats(self.point, (3,), "point of a cut")
        normal = unit(self.normal, "normal of a cut")
        if self.wedge_deg == 0.0:
            return normal[None], point[None]
        if not abs(self.wedge_deg) < 60.0:
            raise InputError(f"a wedge of {self.wedge_deg} degrees", remedy="give -60 to 60")
        edge = np.zeros(3) if self.edge is None else np.asarray(self.edge, dtype=np.float64)
        edge = edge - (edge @ normal) * normal
        if np.linalg.norm(edge) < 1e-9:
            raise InputError("a wedge needs an edge across the normal", remedy="give its direction")
        sides = [rotation_about(edge, s * abs(self.wedge_deg)) @ normal for s in (1.0, -1.0)]
        return np.array(sides), np.stack([point, point])


@dataclass(frozen=True, eq=False)
class Trial(OneLine):
    """A cut that was tried at a place, and the result for the part above it."""

    place: int
    cut: Cut
    result: Result

    @property
    def accepted(self) -> bool:
        """Whether the part above stands on it."""
        return self.result.stable


@dataclass(frozen=True, eq=False)
class CutDesign(OneLine):
    """Blocks cut from one shape.

    Attributes
    ----------
    assembly
        From the bottom up; the lowest is fixed.
    trials
        In the order in which they were made; per place the last one was accepted.
    """

    assembly: Assembly
    trials: tuple[Trial, ...]

    @property
    def cuts(self) -> tuple[Cut, ...]:
        """The accepted cuts."""
        return tuple(trial.cut for trial in self.trials if trial.accepted)


@dataclass(frozen=True)
class CutOptions(Options):
    """Which cuts are tried at each place.

    Attributes
    ----------
    blocks
        Number of blocks; the lowest is the support.
    friction
    tilts_deg : [degrees]
        Angles by which the plane is turned, each to both sides, after the horizontal plane.
    notches_deg : [degrees]
        Angles of the grooves in which the part above sits, after the planes.
    shifts
        Shares of the height of a block by which the cuts are moved, after those at the place.
    most
        Number of plans after which the loop ends.
    plan
        Options of the plans.
    """

    blocks: int = 4
    friction: float = 0.6
    tilts_deg: tuple[float, ...] = (10.0, 20.0, 30.0)
    notches_deg: tuple[float, ...] = (20.0,)
    shifts: tuple[float, ...] = (-0.2, 0.2)
    most: int = 40
    plan: PlanOptions = field(default_factory=PlanOptions)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._refuse_below(2, "blocks")
        self._refuse_below(1, "most")
        self._refuse_below(0.0, "friction")
        for name in ("tilts_deg", "notches_deg"):
            angles = frozen_floats(getattr(self, name), (None,), name)
            if not ((angles > 0.0) & (angles < 60.0)).all():
                raise InputError("angles must lie between 0 and 60 degrees", where=name)
        if not (np.abs(frozen_floats(self.shifts, (None,), "shifts")) < 0.5).all():
            raise InputError("shares must lie between -0.5 and 0.5", where="shifts")


@dataclass(frozen=True, eq=False)
class CutLoop(Answer):
    """Blocks cut from one shape, and their plan.

    Attributes
    ----------
    design
        The last blocks; None if no cut lets the parts above stand.
    plan
        Of the last blocks; None without ``design``.
    recuts
        Why the loop went back, one sentence each, with the place, from 0.
    message
        How it ended.
    """

    design: CutDesign | None
    plan: Plan | None
    recuts: tuple[tuple[int, str], ...]
    message: str

    @property
    def free(self) -> bool:
        """Whether every block is placed alone and stands at once."""
        return self.plan is not None and not _helped(self.plan)

    def _summary(self) -> str:
        return self.message

    @property
    def model(self) -> Model:
        """The last blocks.

        Raises
        ------
        InputError
            There are none.
        """
        if self.plan is None:
            raise InputError("there are no blocks", remedy="try other cuts")
        return self.plan.model.model

    @cached_property
    def asked(self) -> Question:
        """What was asked, of the last blocks."""
        return Question.of_nothing(made=self.when) if self.plan is None else super().asked

    @property
    def title(self) -> str:
        """How it ended."""
        return self.message[0].upper() + self.message[1:]

    def sentences(self) -> Sequence[Sentence]:
        """Whether every block is free, how it ended, and why it went back."""
        role = Role.GOOD if self.free else Role.BAD
        said = [Sentence("FREE" if self.free else "NOT FREE", role), Sentence(self.message)]
        return [*said, *(Sentence(f"cut {place} changed: {why}") for place, why in self.recuts)]

    def tables(self) -> Sequence[Table]:
        """The cuts that were accepted."""
        trials = () if self.design is None else self.design.trials
        kept = [one for one in trials if one.accepted]
        normal = np.array([one.cut.normal for one in kept]).reshape(-1, 3)
        slope = np.rad2deg(np.arctan2(np.hypot(normal[:, 0], normal[:, 1]), normal[:, 2]))
        columns = {
            "place": [one.place for one in kept],
            "point": np.array([one.cut.point for one in kept]).reshape(-1, 3),
            "normal": normal,
            "slope": slope,
            "notch_deg": [float(one.cut.wedge_deg) for one in kept],
        }
        return [Table("cuts", columns, {"point": "m", "slope": "deg", "notch_deg": "deg"})]

    def layers(self) -> Scene:
        """The plan."""
        if self.plan is None:
            raise InputError("there is no picture: no cut lets the parts above stand")
        return self.plan.layers()

    def numbers(self) -> Mapping[str, Any]:
        """Whether every block is free, why it went back, and the plan."""
        return {
            "free": self.free,
            "message": self.message,
            "recuts": [{"place": place, "why": why} for place, why in self.recuts],
            "plan": None if self.plan is None else self.plan.numbers(),
        }


@checked_call
def cut_until_free(
    block: Block,
    *,
    options: CutOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
) -> CutLoop:
    """Cut a shape into blocks that are all placed alone and stand at once.

    Parameters
    ----------
    block
        The shape; its lowest part becomes the support.
    options

    Examples
    --------
    >>> from drystone.models import prism
    >>> tower = prism([(0, 0), (1, 0), (1.7, 4), (0.7, 4)], (0, 1), "tower")
    >>> found = cut_until_free(tower)
    >>> found.free, len(found.design.assembly)
    (True, 4)
    """
    chosen = CutOptions.of(options)
    choices = proposed_cuts(block, chosen)
    clock = Clock(time_limit_s, stop)
    first = [0] * len(choices)
    recuts: list[tuple[int, str]] = []
    design: CutDesign | None = None
    found: Plan | None = None
    words = f"not every block is free after {counted(chosen.most, 'plan')}"
    for done in range(chosen.most):
        if clock.late():
            words = f"{clock.reason} before all was free"
            break
        if progress is not None:
            progress("cutting", done, chosen.most)
        made, used = _cut(block, choices, first, chosen.friction)
        if made is None:
            place, why = len(used), "on none of its cuts the part above stands"
        else:
            design = made
            model = Model.of(design.assembly, friction=chosen.friction)
            found = plan(model, options=chosen.plan, executor=executor, stop=clock.late)
            helped = _helped(found)
            if not helped:
                count = counted(len(recuts), "recut")
                words = f"every block of {len(design.assembly)} is free after {count}"
                break
            place, why = helped
        recuts.append((place, why))
        # without a design, no further cut of this place is left
        used = [*used, *[len(one) for one in choices[len(used) :]]]
        while place >= 0 and used[place] + 1 >= len(choices[place]):
            place -= 1
        if place < 0:
            words = "no proposed cuts make every block free"
            break
        first[place:] = [used[place] + 1, *[0] * (len(choices) - place - 1)]
    return CutLoop(design, found, tuple(recuts), words)


def design_cuts(
    block: Block, proposals: Sequence[Sequence[Cut]], *, friction: float = 0.6
) -> CutDesign:
    """Cut a shape from the bottom up, at each place with the first cut that is accepted.

    A cut that misses the shape, or divides it into more than two parts, is passed over.

    Parameters
    ----------
    block
        The shape; its lowest part becomes the support.
    proposals
        Per place, from the bottom up, cuts in the order of preference.
    friction

    Raises
    ------
    InputError
        With no cut of a place the part above stands.
    """
    if not proposals:
        raise InputError("no place to cut at", where="proposals")
    made, used = _cut(block, proposals, [0] * len(proposals), friction)
    if made is None:
        place = len(used)
        raise InputError(
            f"none of {len(proposals[place])} cuts at place {place} lets the part above stand",
            remedy="propose other cuts, or more friction",
        )
    return made


def _cut(
    block: Block, choices: Sequence[Sequence[Cut]], first: Sequence[int], friction: float
) -> tuple[CutDesign | None, list[int]]:
    """Blocks, and the number of the cut taken at each place; up to one where none is accepted."""
    pieces: list[Block] = []
    trials: list[Trial] = []
    used: list[int] = []
    rest = block
    for place, some in enumerate(choices):
        for number in range(first[place], len(some)):
            try:
                above, below = split_block(rest, some[number])
            except InputError:  # it misses what is left of the block
                continue
            if len(above) > 1 or len(below) > 1:
                continue
            both = (below[0].renamed("below"), above[0].renamed("above"))
            pair = Assembly(both, np.array([True, False]))
            result = check_both(Model.of(pair, friction=friction))
            trials.append(Trial(place, some[number], result))
            if result.stable:
                pieces.append(below[0].renamed(f"c{place:02d}-block"))
                rest = above[0]
                used.append(number)
                break
        else:
            return None, used
    pieces.append(rest.renamed(f"c{len(choices):02d}-block"))
    assembly = Assembly(tuple(pieces), np.arange(len(pieces)) == 0)
    return CutDesign(assembly, tuple(trials)), used


def _helped(found: Plan) -> tuple[int, str] | None:
    """The cut under the lowest block that is not free, and why; None if all are free."""
    names = found.model.assembly.names
    if not found.steps:
        falling = found.complete.falling
        place = min(falling) if falling else len(names) - 1
        return max(0, place - 1), f"{names[place]}: {found.message}"
    for block, status in enumerate(found.status):
        if status in (Status.HELD, Status.PROPPED, Status.IMPOSSIBLE):
            why = found.impossible.get(block, found.steps[found.step_of.get(block, 0)].why)
            return max(0, block - 1), f"{names[block]} is {status.value}: {why}"
    bad = next((one for one in found.steps if not one.answer.stands), None)
    if bad is None:
        return None
    return max(0, bad.blocks[-1] - 1), f"{names[bad.blocks[-1]]}: {bad.answer.message}"


def proposed_cuts(block: Block, options: CutOptions) -> list[list[Cut]]:
    """Per place, from the bottom up, the cuts in the order of preference."""
    low, high = float(block.vertices[:, 2].min()), float(block.vertices[:, 2].max())
    height = (high - low) / options.blocks
    heights = low + height * np.arange(1, options.blocks)
    middles = [_middle(block, float(z)) for z in heights]
    lean = middles[-1] - _middle(block, low + 0.01 * height)
    lean[2] = 0.0
    leans = float(np.linalg.norm(lean)) > UPRIGHT * (high - low)
    edge = np.cross(UP, lean) if leans else np.array([0.0, 1.0, 0.0])
    turns = [0.0, *(sign * tilt for tilt in options.tilts_deg for sign in (1.0, -1.0))]
    out = []
    for z in heights:
        some: list[Cut] = []
        for shift in (0.0, *options.shifts):
            point = _middle(block, float(z) + shift * height)
            some += tilted_cuts(point, UP, edge, turns)
            some += [Cut(point, UP, notch, edge) for notch in options.notches_deg]
        out.append(some)
    return out


def tilted_cuts(
    point: Floats, normal: Floats, edge: Floats, tilts_deg: Sequence[float], wedge_deg: float = 0.0
) -> tuple[Cut, ...]:
    """The cut rotated by several angles about an edge through its point."""
    axis, base = unit(edge, "edge"), unit(normal, "normal")
    return tuple(
        Cut(point, rotation_about(axis, tilt) @ base, wedge_deg, axis) for tilt in tilts_deg
    )


def _middle(block: Block, z: float) -> Floats:
    """The mean corner of the section of a block at a height."""
    above, _ = split_block(block, Cut(np.array([0.0, 0.0, z]), UP))
    corners = np.concatenate([piece.vertices for piece in above])
    near = np.abs(corners[:, 2] - z) <= 1e-6 * float(np.ptp(block.vertices[:, 2]))
    return np.asarray(np.append(corners[near, :2].mean(axis=0), z))


def split_block(block: Block, cut: Cut) -> tuple[list[Block], list[Block]]:
    """The pieces above and below a cut, as blocks with names derived from the whole.

    Raises
    ------
    InputError
        The cut misses the block, or only touches it.

    Examples
    --------
    >>> from drystone.models import box
    >>> above, below = split_block(box((1.0, 1.0, 2.0)), Cut((0.5, 0.5, 0.5), (0.0, 0.0, 1.0)))
    >>> [float(piece.volume) for piece in (*above, *below)]
    [1.5, 0.5]
    """
    normals, points = cut.planes()
    ridge = cut.wedge_deg < 0.0  # the groove of the part below, seen upside down
    normals = normals if ridge else -normals
    offsets = (normals * points).sum(axis=1)
    inside, outside = cut_cell([(block.vertices, list(block.faces))], normals, offsets)
    if len(normals) > 1:
        outside = glue(outside)
    above, below = (outside, inside) if ridge else (inside, outside)
    if not above or not below:
        raise InputError(f"the cut misses block '{block.name}'", remedy="move it into the block")
    return _blocks(above, block, "above"), _blocks(below, block, "below")


def _blocks(pieces: Sequence[Piece], whole: Block, side: str) -> list[Block]:
    out = []
    for number, (vertices, faces) in enumerate(pieces):
        suffix = f"-{number}" if len(pieces) > 1 else ""
        used = sorted({i for face in faces for i in face})
        new = {old: i for i, old in enumerate(used)}
        loops = tuple(tuple(new[i] for i in face) for face in faces)
        name = f"{whole.name}-{side}{suffix}"
        out.append(Block(vertices[used], loops, name, whole.density, whole.metadata))
    return out
