"""Local collapse mechanisms in earthquakes, compared with a spectrum.

Source: linear and non-linear kinematic analysis of the Italian code, by Circolare 617/2009, C8A.4,
or Circolare 7/2019, C8.7.1.2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Unpack

import numpy as np

from drystone.answer import Answer, Layer, LayerKind, Role, Scene, SceneStage, Sentence, State
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.answer.drawing import interface_layers, load_layers, marks, seen, state_of
from drystone.answer.question import UP
from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Bools, Floats, Ints, lengths
from drystone.base.declared import Offered
from drystone.base.display import named
from drystone.base.errors import InputError, counted, located
from drystone.base.progress import Clock
from drystone.base.ragged import linked
from drystone.base.settings import checked_call
from drystone.base.table import Table
from drystone.checks import block_speed, corner_motion, moving_joints
from drystone.geometry.frames import axis_vector
from drystone.geometry.kern import level_hull
from drystone.io.opening import Given, LongHow, kept_of, supported_model
from drystone.limits import limit_load
from drystone.loads import LoadCase
from drystone.loads.applied import applied_loads
from drystone.loads.case import STANDARD_GRAVITY
from drystone.loads.earthquake import Shaken
from drystone.model import Model
from drystone.seismic.spectrum import (
    LimitState,
    Oscillator,
    SeismicDemand,
    Turning,
    weights_that_move,
)
from drystone.settlement import LargeDisplacement, push
from drystone.settlement.large_displacement import MOVES

_CLOSE = 1e-3
"""How far a line may lie off a part by its size. Chosen: coordinates rounded to millimetres."""


@dataclass(frozen=True)
class _Asked:
    """What was asked beside the model, in words."""

    direction: str = ""
    part: str = ""
    line: str = ""
    site: str = ""


@dataclass(frozen=True, eq=False)
class LocalMechanism(Answer):
    """A mechanism, its capacity, and what a site asks.

    Attributes
    ----------
    model
    motion : (n, 6) [m, rad]
        Virtual motion of the blocks.
    oscillator
    displacement, load : (s,)
        Mean displacement [m] of the weights that move, and the multiplier there; empty where the
        blocks were not followed.
    how
        How it was found.
    site
        ``None`` where no spectrum was given.
    options
        What was asked beside the model.
    remarks
        Where the stiffness of joints decides; a part above the ground with no demand of its storey.
    moments
        About the line of a part; ``None`` of a mechanism that is found.
    """

    model: Model
    motion: Floats
    oscillator: Oscillator
    displacement: Floats
    load: Floats
    how: str
    site: SeismicDemand | None = None
    options: Any = None
    remarks: tuple[str, ...] = ()
    moments: Table | None = None

    def _summary(self) -> str:
        return f"alpha0={self.oscillator.multiplier:.4g}, e*={self.oscillator.share:.4g}"

    @property
    def confidence(self) -> float:
        """Factor by which the capacity is divided."""
        return 1.0 if self.site is None else self.site.confidence

    @property
    def acceleration(self) -> float:
        """a0* [m/s2]."""
        return self.oscillator.acceleration(self.confidence)

    @property
    def state(self) -> LimitState:
        """The limit state of the site; without one SLV of Circolare 617/2009."""
        return LimitState.named() if self.site is None else self.site.state

    @property
    def ultimate(self) -> float:
        """du* [m], a share of d0*; NaN where displacements are not compared."""
        return (self.state.ultimate or float("nan")) * self.oscillator.displacement

    @property
    def secant_period(self) -> float:
        """Ts [s], at ds*, a share of du*, on the line from a0* to d0*."""
        there = self.state.secant * self.ultimate
        level = self.acceleration * (1.0 - there / self.oscillator.displacement)
        factor = self.state.factor * math.pi
        return factor * math.sqrt(there / level) if level > 0.0 else float("nan")

    @property
    def verifications(self) -> Sequence[tuple[str, str, float, float, str]]:
        """Method, formula of the demand, demand, capacity and unit; empty without a site."""
        if self.site is None:
            return ()
        linear = self.site.accelerations().items()
        told = [("linear", name, value, self.acceleration, "m/s2") for name, value in linear]
        if math.isfinite(self.secant_period):
            asked = self.site.displacements(self.secant_period).items()
            told += [("non-linear", name, value, self.ultimate, "m") for name, value in asked]
        return told

    def fulfils(self, method: str) -> bool:
        """Whether the demands of a method, ``linear`` or ``non-linear``, are met."""
        own = [one for one in self.verifications if one[0] == method]
        return bool(own) and all(capacity >= demand for _, _, demand, capacity, _ in own)

    @property
    def title(self) -> str:
        """The multiplier, and whether the site asks for no more."""
        begins = f"A mechanism begins at {self.oscillator.multiplier:.4g} g"
        methods = dict.fromkeys(one for one, *_ in self.verifications)
        told = [f"{one} {'' if self.fulfils(one) else 'not '}fulfilled" for one in methods]
        return f"{begins}: verification {', '.join(told)}" if told else begins

    def sentences(self) -> Sequence[Sentence]:
        """The same, what moves, and how it was found."""
        good = self.oscillator.multiplier > 0.0
        if self.site is not None:
            good = self.fulfils("linear") or self.fulfils("non-linear")
        moving = counted(int(np.count_nonzero(self._moving)), "block moves", "blocks move")
        said = [Sentence(self.title, Role.GOOD if good else Role.BAD)]
        said.append(Sentence(f"{moving}; {self.how}"))
        quake = LoadCase.seismic(self.model.assembly, 1.0)
        shaken = Shaken.of(self.model.assembly, self.model.load + quake, self._moving)
        said += [Sentence(shaken.words, Role.REMARK)] if shaken else []
        said += [Sentence(one, Role.REMARK) for one in self.remarks]
        if self.site is not None and self.site.confidence == 1.0:
            full = "FC = 1: full knowledge of the building is taken (confidence in the site file)"
            said.append(Sentence(full, Role.REMARK))
        if not math.isfinite(self.oscillator.reach):
            said.append(Sentence("its displacement at overturning is not known", Role.REMARK))
        return said

    def tables(self) -> Sequence[Table]:
        """The numbers of the method, and the verifications."""
        one, state = self.oscillator, self.state
        secant = f"{state.factor:g} pi (ds*/as*)^0.5, ds* = {state.secant:g} du*"
        line = "sum of what holds by what 1 g turns" if self.moments else "virtual work"
        told = [
            ("multiplier alpha0", one.multiplier, "", line),
            ("weight that moves, P", one.weight / 1e3, "kN", ""),
            ("mass M*", one.mass / 1e3, "t", "(sum P d)^2 / (g sum P d^2)"),
            ("share e*", one.share, "", "g M* / P"),
            ("acceleration a0*", self.acceleration, "m/s2", "alpha0 g / (e* FC)"),
            ("displacement d0*", one.displacement, "m", "where alpha is zero"),
        ]
        if state.ultimate:
            told.append(("displacement du*", self.ultimate, "m", f"{state.ultimate:g} d0*"))
            told.append(("period Ts", self.secant_period, "s", secant))
        columns: dict[str, Any] = {
            "quantity": [name for name, *_ in told],
            "value": ["-" if math.isnan(value) else f"{value:.4g}" for _, value, *_ in told],
            "unit": [unit for _, _, unit, _ in told],
            "from": [source for *_, source in told],
        }
        tables = [Table("kinematic method", columns)]
        tables += [_summed(each) for each in (self.moments, one.masses) if each is not None]
        if self.verifications:
            tables.append(_verified(self.verifications))
        if self.site is not None:
            tables.append(self.site.table())
        return tables

    def table(self) -> Table:
        """The capacity curve: d* [m] and a* [m/s2]."""
        share = self.oscillator.share
        level = self.load * STANDARD_GRAVITY / (share * self.confidence)
        columns = {"displacement": self.displacement / share, "acceleration": level}
        return Table("capacity curve", columns, {"displacement": "m", "acceleration": "m/s2"})

    def numbers(self) -> Mapping[str, Any]:
        """The numbers of the method and of the site."""
        own = "acceleration", "ultimate", "secant_period"
        of = "multiplier", "weight", "mass", "share", "displacement"
        return {
            **{name: getattr(self.oscillator, name) for name in of},
            **{name: getattr(self, name) for name in own},
            "linear": self.fulfils("linear") if self.site else None,
            "nonlinear": self.fulfils("non-linear") if self.site else None,
            "site": None if self.site is None else self.site.told(),
            "curve": {"displacement": self.displacement, "multiplier": self.load},
        }

    @property
    def _moving(self) -> np.ndarray:
        speed = block_speed(self.model.assembly, self.motion)
        return np.asarray(speed > MOVES * float(speed.max(initial=0.0)))

    def layers(self) -> Scene:
        """What moves, and the capacity curve beside it."""
        assembly, contacts = self.model.assembly, self.model.contacts
        state = state_of(assembly)
        state[self._moving] = State.FALLING
        stage = SceneStage(
            "mechanism", self.title, self.how, state, motion=seen(assembly, self.motion),
            motion_name="Mechanism", plays=True,
            layers=(*interface_layers(contacts), *load_layers(assembly, self._with_pulls()),
                    *self._earthquake(), *self._hinges()),
        )  # fmt: skip
        charts = (self.chart(),) if len(self.displacement) else ()
        title = f"drystone: {self.title[0].lower()}{self.title[1:]}"
        return Scene(assembly, contacts, (stage,), title, self.asked.facts(), charts=charts,
                     preset="solid")  # fmt: skip

    def _with_pulls(self) -> LoadCase:
        """The load, and the pulls of the ties of a part."""
        if self.moments is None:
            return self.model.load
        pulls = _pulls(self.model, np.flatnonzero(self._moving), self.motion)
        one = partial(LoadCase.point_load, self.model.assembly)
        return sum((one(block, force, at) for block, at, force in pulls), self.model.load)

    def _earthquake(self) -> tuple[Layer, ...]:
        """The force of the earthquake on what moves, as one arrow that ends in its middle."""
        alpha = self.oscillator.multiplier
        place, weight, *_ = _masses(self.model, np.flatnonzero(self._moving))
        along = np.array(self.options.direction.split(","), dtype=float)
        force, middle = alpha * weight.sum() * along, weight @ place / weight.sum()
        return (
            Layer("acceleration", f"earthquake, {alpha:.4g} g", LayerKind.ARROWS, "load",
                  middle[None], force[None], single=True, width=4.0, group="acceleration"),
        )  # fmt: skip

    def _hinges(self) -> tuple[Layer, ...]:
        """The line about which a part turns; of a mechanism that is found the joints."""
        hinge, slide, place = moving_joints(self.model, self.motion)
        if self.moments is None:
            turns = "hinges", "turns about an edge", hinge
            return marks(place, turns, ("sliding", "slides", slide))
        blocks, moving = self.model.assembly.blocks, np.flatnonzero(self._moving)
        move, axis = np.split(self.motion[moving[0]], 2)
        start = self.model.assembly.centroid[moving[0]] + np.cross(axis, move)
        along = (np.vstack([blocks[i].vertices for i in moving]) - start) @ axis
        span = along.max() - along.min()
        line = start + along.min() * axis, span * axis
        return (
            Layer("line", "turns about this line", LayerKind.LINES, "hinge", line[0][None],
                  line[1][None], width=4.0, group="hinges"),
        )  # fmt: skip

    def chart(self) -> Chart:
        """The capacity curve, its line, and the spectrum as displacement and acceleration."""
        curve, end = self.table(), self.oscillator.displacement
        marks = [
            Marks(MarkKind.LINE, curve["displacement"], curve["acceleration"], "ink", "capacity")
        ]
        if math.isfinite(end):
            line = np.array([0.0, end]), np.array([self.acceleration, 0.0])
            marks.insert(0, Marks(MarkKind.DASHED, *line, "accent", "a0* to d0*"))
        there = self.state.secant * self.ultimate
        ends: tuple[tuple[float, str], ...] = ()
        if math.isfinite(self.secant_period):
            level = self.acceleration * (1.0 - there / end)
            secant = np.array([0.0, there]), np.array([0.0, level])
            marks.append(Marks(MarkKind.LINE, *secant, "good", f"Ts = {self.secant_period:.3g} s"))
            ends = ((self.ultimate, "du*"),)
        if self.site is not None:
            period, spectrum = np.linspace(0.0, 4.0, 201), self.site.verified
            label = f"elastic spectrum, {10.0 / spectrum.damping**2 - 5.0:.3g} %"
            across = np.array([spectrum.displacement(one) for one in period])
            up = np.array([spectrum.acceleration(one) for one in period])
            marks.append(Marks(MarkKind.LINE, across, up, "bad", label))
        return Chart(
            "Capacity curve", tuple(marks), "d*", "a*", ("m", "m/s\N{SUPERSCRIPT TWO}"), lines=ends
        )


@checked_call
def local_mechanism(
    given: Given,
    *,
    direction: Floats | Sequence[float] | str = "x",
    part: str | Sequence[str] = (),
    line: Sequence[float] | None = None,
    site: str | SeismicDemand | None = None,
    **how: Unpack[LongHow],
) -> LocalMechanism:
    """The local collapse mechanism of masonry in an earthquake, by the kinematic method.

    Of a part that turns about a line as one rigid body, or, where no part is named, of all blocks:
    then the multiplier and the mechanism are those of the largest horizontal load at which it
    stands, and the capacity curve follows the blocks (:func:`drystone.settlement.push`).

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    direction : (3,) or a name
        Of the earthquake, level.
    part
        Blocks that turn as one body, by names and patterns separated by commas.
    line : (6,) [m]
        Two points of the line about which the part turns, level, under the part; when left out, the
        edge of the hull of its foot with the least multiplier, or where it turns about a corner
        alone, the line there across the direction.
    site
        TOML file with a spectrum and the factors q and FC, such as ``code``, ``ag``, ``soil``.

    Raises
    ------
    InputError
        The part has no free block or a tie without a strength; the line is vertical, along the
        direction or not under the part.

    Examples
    --------
    A wall 0.5 m thick and 3 m high turns about its edge at 0.5/3 g:

    >>> import drystone
    >>> from drystone.models import box
    >>> blocks = (box((4, 4, 1), (-2, -2, -1), "base"), box((0.5, 2, 3), (0, 0, 0), "wall"))
    >>> wall = drystone.Assembly(blocks).with_fixed(["base"])
    >>> found = local_mechanism(wall, part="wall", friction=0.6)
    >>> round(found.oscillator.multiplier, 4), round(found.oscillator.displacement, 4)
    (0.1667, 0.25)
    """
    told = "" if site is None else site if isinstance(site, str) else "given"
    site = SeismicDemand.named(site) if isinstance(site, str) else site
    clock = Clock.of(how)
    model = supported_model(given, **how)
    model.require_ends_as_drawn("the kinematic method")
    along = axis_vector(direction, "direction") * np.array([1.0, 1.0, 0.0])
    if not along.any():
        raise InputError("is vertical", where="direction", remedy="give x, y or another level one")
    along /= np.linalg.norm(along)
    part = part if isinstance(part, str) else tuple(part)
    asked = _Asked(
        direction=", ".join(f"{x:.4g}" for x in along + 0.0),
        part=part if isinstance(part, str) else ", ".join(part),
        line=", ".join(f"{x:g}" for x in (() if line is None else line)),
        site=told,
    )
    if part:
        turning, motion, remarks = _turning(model, along, part, line)
        found = turning.oscillator()
        moved, load = turning.curve()
        told = "a rigid part that turns about a line; its joints neither slide, pull nor crush"
        if (model.contacts.crushes & ~model.contacts.ties).any():
            what = "is of rigid bodies that do not crush"
            raise InputError(what, where="part", remedy="leave the strength or the part out")
        return LocalMechanism(
            model, motion, found, moved, load, told, site, asked,
            remarks=(*remarks, *_above_ground(model, turning, site)), moments=turning.moments(),
        )  # fmt: skip
    if line is not None:
        raise InputError("is for a part", where="line", remedy="name its blocks: --part")
    late: dict[str, Any] = {"progress": clock.progress, "stop": clock.late}
    return replace(_found(model, along, site, late), options=asked)


def _above_ground(model: Model, turning: Turning, site: SeismicDemand | None) -> tuple[str, ...]:
    """What is missing where a part stands above the ground and its storey shakes it."""
    assembly = model.assembly
    ground = min(assembly.blocks[i].vertices[:, 2].min() for i in assembly.free)
    height = float(turning.origin[2] - ground)
    if site is None or site.period or height <= 1e-6 * assembly.size.max():
        return ()
    return (
        f"the part turns {height:.3g} m above the ground and is compared with the ground's motion "
        "alone: give T1, psi and gamma of the building in the site file",
    )


def _summed(table: Table) -> Table:
    """The table with a last row of sums; place and displacement are means by weight there."""
    if len(table) == 1:
        return table
    columns: dict[str, Any] = {}
    for name, values in table.columns.items():
        last: Any = "all"
        if name in ("place", "d"):
            last = table["P"] @ values / table["P"].sum()
        elif name in ("behind", "above"):
            last = float("nan")
        elif values.dtype.kind == "f":
            last = values.sum(axis=0)
        columns[name] = np.concatenate([values, [last]])
    return Table(table.title, columns, table.units)


def _verified(rows: Sequence[tuple[Any, ...]]) -> Table:
    names = ("method", "demand", "asked", "capacity", "unit")
    columns: dict[str, Any] = {name: [row[i] for row in rows] for i, name in enumerate(names)}
    return Table("verification", columns | {"fulfilled": [row[3] >= row[2] for row in rows]})


def _found(
    model: Model,
    along: Floats,
    site: SeismicDemand | None,
    late: dict[str, Any],
) -> LocalMechanism:
    """The mechanism of all blocks."""
    assembly = model.assembly
    live = replace(LoadCase.seismic(assembly, *along[:2]), name="earthquake of 1 g")
    place, weight, block, _ = _masses(model, np.arange(len(assembly)))
    limit = limit_load(model, live, upper=100.0, **late)
    best = limit.best
    if best.stands is None or best.falling is None or best.falling.mechanism is None:
        raise InputError(limit.title, where="direction", remedy="ask drystone limit load seismic")
    # between what stands and what falls nothing is known, but where the limit was computed
    begins = best.stands if best.computed is None else best.computed
    motion, pushed, even = best.falling.mechanism, None, False
    told = "the mechanism just beyond the largest load at which it stands"
    if best is limit.equilibrium:
        told = "the mechanism of the largest load at which forces balance"
    remarks = [f"joints decide: {one}" for one in limit.remarks]
    reach, moved, load = float("nan"), np.zeros(0), np.zeros(0)
    if (model.contacts.plain | model.contacts.ties).all():
        pushed = push(model, live, **late)
        moved, load, reach = pushed.displacement, pushed.load, pushed.capacity or reach
        told += f"; followed: {pushed.message}"
    else:
        told += "; not followed: its joints are not dry; a part (--part) has d0*"
    if moving_joints(model, motion)[1].any():  # a proof opens the joints that slide
        begun = None if pushed is None else _begun(pushed, begins)
        if begun is None:
            even = True
            remarks.append("joints slide, and how blocks move is not known: e* = 1, the least a0*")
        else:
            motion = begun
            told += "; joints slide: d as followed"
    arms, free = place - assembly.centroid[block], len(assembly.free)
    each = (motion[block, :3] + np.cross(motion[block, 3:], arms)) @ along
    # a load that is shaken keeps a place of its own
    body = np.append(_bodies(model, motion)[block[:free]], -1 - np.arange(len(block) - free))
    _, body = np.unique(body, return_inverse=True)
    carried = np.bincount(body, weight)
    virtual = np.bincount(body, weight * each) / carried
    middle = np.column_stack([np.bincount(body, weight * x) / carried for x in place.T])
    moving = np.abs(virtual) > MOVES * np.abs(virtual).max(initial=0.0)
    virtual = np.where(moving & even, 1.0, virtual)
    each_of = (block[body == one] for one in np.flatnonzero(moving))
    names = [named([assembly.names[i] for i in one], 1) for one in each_of]
    masses = weights_that_move(names, carried[moving], middle[moving], virtual[moving])
    found = Oscillator(begins, masses, reach)
    return LocalMechanism(model, motion, found, moved, load, told, site, remarks=tuple(remarks))


def _begun(pushed: LargeDisplacement, begins: float) -> Floats | None:
    """How blocks (n, 6) move from the load factor on at which a mechanism begins.

    By at least a hundredth of their mean size. ``None`` where they were not followed so far.
    """
    assembly, begun = pushed.assembly, None
    least = MOVES * float(assembly.size[assembly.free].mean())
    for state in pushed.states:
        if begun is None and state.load >= (1.0 - MOVES) * begins:
            begun = state.positions
        moved = None if begun is None else state.positions - begun
        if moved is not None and block_speed(assembly, moved).max() >= least:
            return moved
    return None


def _bodies(model: Model, motion: Floats) -> Ints:
    """Numbers (n,) of the bodies of blocks that move as one in a motion (n, 6)."""
    assembly, contacts = model.assembly, model.contacts
    apart = contacts.corners.max(lengths(corner_motion(assembly, contacts, motion)))
    whole = apart <= MOVES * block_speed(assembly, motion).max(initial=0.0)
    return linked(contacts.block_a[whole], contacts.block_b[whole], len(assembly))


def _masses(model: Model, part: Ints) -> tuple[Floats, Floats, Ints, list[str]]:
    """Places (p, 3), weights (p,), blocks and names of masses: of blocks, then what they carry."""
    assembly = model.assembly
    part = part[~assembly.fixed[part]]
    place, mass, block = [assembly.centroid[part]], [assembly.mass[part]], [part]
    names = [assembly.names[i] for i in part]
    for one in model.load.masses:
        here = part[one.mass[part] != 0.0]
        place.append(one.place(assembly)[here])
        mass.append(one.mass[here])
        block.append(here)
        names += [f"{one.kind} on {assembly.names[i]}" for i in here]
    weight = STANDARD_GRAVITY * np.concatenate(mass)
    return np.vstack(place), weight, np.concatenate(block), names


def _turning(
    model: Model,
    along: Floats,
    part: str | Sequence[str],
    line: Sequence[float] | None,
) -> tuple[Turning, Floats, list[str]]:
    """A part that turns about a line, its virtual motion (n, 6), and remarks."""
    assembly = model.assembly
    with located("part"):
        chosen = kept_of(assembly, part)
    chosen = chosen[~assembly.fixed[chosen]]
    if not len(chosen):
        raise InputError("has no free block", where="part", remedy="name blocks that can move")
    remarks = _whole(model, chosen)
    if line is not None:
        origin, axis = _line(line, along)
        remarks += _under(assembly, chosen, origin, axis)
        return *_about(model, chosen, along, origin, axis), remarks
    least, ends, found = _soonest(model, chosen, along)
    remarks += [f"the part turns about the edge of its foot from {ends}"] if ends else []
    return *found, [*remarks, *_upper_ones(model, chosen, along, least)]


def _upper_ones(model: Model, part: Ints, along: Floats, least: float) -> list[str]:
    """That what stands on level beds of a part turns sooner than the part, at ``least``."""
    assembly, contacts, told = model.assembly, model.contacts, []
    bottom = np.full(len(assembly), -np.inf)
    bottom[part] = [assembly.blocks[i].vertices[:, 2].min() for i in part]
    rise, height = np.abs(contacts.frame[:, 0, 2]), contacts.centroid[:, 2]
    for level in np.unique(bottom[part])[1:]:
        upper = bottom >= level
        cut = (upper[contacts.block_a] != upper[contacts.block_b]) & (rise > _CLOSE)
        uneven = (rise < 1.0 - _CLOSE) | (np.abs(height - level) > _CLOSE * assembly.size.max())
        if (cut & uneven & ~contacts.ties).any():
            continue
        with suppress(InputError):  # a tie without a strength holds it
            sooner, *_ = _soonest(model, np.flatnonzero(upper), along)
            if sooner < (1.0 - _CLOSE) * least:
                names, least = named([assembly.names[i] for i in np.flatnonzero(upper)]), sooner
                told = [f"what is above {level:.4g} m turns sooner, at {sooner:.4g} g: {names}"]
    return told


def _soonest(model: Model, part: Ints, along: Floats) -> tuple[float, str, tuple[Turning, Floats]]:
    """How a part turns about its foot: the least multiplier, the edge unless a corner, and that."""
    lines = _lowest_edges(model.assembly, part, along)
    found = [_about(model, part, along, start, end - start) for start, end in lines]
    alpha = np.array([turning.multiplier(0.0) for turning, _ in found])
    best = int(np.argmax(alpha <= alpha.min() + SAME))  # about a corner all are the same
    edge = " to ".join(", ".join(f"{x + 0.0:.4g}" for x in end) for end in lines[best])
    return float(alpha[best]), edge if best else "", found[best]


def _about(
    model: Model, chosen: Ints, along: Floats, origin: Floats, axis: Floats
) -> tuple[Turning, Floats]:
    """A part that turns about a line, and its virtual motion (n, 6)."""
    assembly, axis = model.assembly, axis / np.linalg.norm(axis)
    applied = applied_loads(assembly, model.load.beside_masses)
    mine = np.isin(applied.block, chosen)
    couple = applied.moment[mine].sum(axis=0)
    at, weight, _, names = _masses(model, chosen)
    own, others = weight[: len(chosen)], weight[len(chosen) :]  # the part is one body
    masses = np.vstack([own @ at[: len(chosen)] / own.sum(), at[len(chosen) :]])
    weight = np.concatenate([[own.sum()], others])
    motion = np.zeros((len(assembly), 6))
    motion[chosen, :3] = np.cross(axis, assembly.centroid[chosen] - origin)
    motion[chosen, 3:] = axis
    pulls = _pulls(model, chosen, motion)
    place = [masses, applied.point[mine], *(x[None] for _, x, _ in pulls)]
    carried = [one.wrench[chosen[one.mass[chosen] != 0.0], :3] for one in model.load.masses]
    mass = assembly.mass[chosen].sum()
    force = [mass * applied.acceleration[None], *carried, applied.force[mine],
             *(x[None] for *_, x in pulls)]  # fmt: skip
    loads = [f"load on {assembly.names[i]}" for i in applied.block[mine]]
    shaken = ("own weight", *names[len(chosen) :])
    name = (*shaken, *loads, *(f"tie {one}" for one, *_ in pulls))
    turning = Turning(
        origin, axis, along, name, np.vstack(place), np.vstack(force), couple, shaken, masses,
        weight,
    )  # fmt: skip
    return turning, motion


def _whole(model: Model, part: Ints) -> list[str]:
    """Refuse a part of several pieces, or without what stands on it alone; say what else is on it.

    Joints whose normal rises carry what is above them.
    """
    assembly, contacts = model.assembly, model.contacts
    names = np.array(assembly.names)
    mine = np.isin(np.arange(len(assembly)), part)
    a, b = contacts.block_a, contacts.block_b
    within = mine[a] & mine[b]
    first = part[np.unique(linked(a[within], b[within], len(assembly))[part], return_index=True)[1]]
    if len(first) > 1:
        told = f"is {len(first)} pieces that do not touch: of {named(names[first].tolist())}"
        raise InputError(told, where="part", remedy="name what is between, or ask for each alone")
    rise = contacts.frame[:, 0, 2]
    rests = ~contacts.ties & (np.abs(rise) > _CLOSE)
    below, above = np.where(rise > 0.0, (a, b), (b, a))[:, rests]

    def raised(start: Bools, through: Bools) -> Bools:
        """What stands on some blocks, at once or through others."""
        reached = start
        while len(more := above[reached[below] & ~reached[above] & through[above]]):
            reached = reached.copy()
            reached[more] = True
        return reached

    held = raised(assembly.fixed, ~mine)
    left = np.flatnonzero(raised(mine, ~held) & ~mine)
    if len(left):
        told = f"leaves out what stands on it alone: {named(names[left].tolist())}"
        raise InputError(told, where="part", remedy="name it too")
    both = np.unique(above[mine[below] & held[above] & ~assembly.fixed[above]])
    if not len(both):
        return []
    told = named(names[both].tolist())
    return [f"what {told} lays on the part is not counted: name it too, or give it as a load"]


def _lowest_edges(assembly: Assembly, part: Ints, along: Floats) -> list[tuple[Floats, Floats]]:
    """Lines about which a part falls along a direction, by two points of each.

    The first is across the direction, through the lowest corner that is farthest along; the others
    are the edges of the hull of its lowest corners, its foot, over which it is pushed.
    """
    corners = np.vstack([assembly.blocks[i].vertices for i in part])
    low = corners[corners[:, 2] <= corners[:, 2].min() + SAME * assembly.size.max()]
    across, far = np.cross(UP, along), low[np.argmax(low @ along)]
    foot, found = level_hull(low), [(far, far + across)]
    for start, end in zip(foot, np.roll(foot, -1, axis=0), strict=True):
        if len(foot) > 2 and (end - start) @ across > _CLOSE * np.linalg.norm(end - start):
            found.append((start, end))
    return found


def _line(line: Sequence[float], along: Floats) -> tuple[Floats, Floats]:
    """A point of the line that was asked for, and its direction: the part falls along."""
    ends = np.reshape(np.asarray(line, dtype=np.float64), (-1,))
    if len(ends) != 6:
        raise InputError(f"has {len(ends)} numbers", where="line", remedy="give X,Y,Z,X,Y,Z")
    axis = ends[3:] - ends[:3]
    size = float(np.linalg.norm(axis))
    forward = float(axis @ np.cross(UP, along))
    if abs(forward) <= 1e-6 * size:
        what = "is vertical or along the direction: nothing overturns"
        raise InputError(what, where="line", remedy="give a level line across the direction")
    if abs(axis[2]) > _CLOSE * size:
        raise InputError("is not level", where="line", remedy="give its two ends the same height")
    return ends[:3], axis / size * np.sign(forward)


def _under(assembly: Assembly, part: Ints, origin: Floats, axis: Floats) -> list[str]:
    """Refuse a line that is not under a part; say where it is behind the lowest edge."""
    bottom = np.array([assembly.blocks[i].vertices[:, 2].min() for i in part])
    corners = np.vstack([assembly.blocks[i].vertices for i in part])
    near = _CLOSE * float(np.linalg.norm(np.ptp(corners, axis=0)))
    lowest = float(bottom.min())
    rise = float(origin[2]) - lowest
    if abs(rise) > near:
        remedy = f"give z = {lowest:.4g}"
        above = [assembly.names[i] for i in part[bottom >= origin[2] - near]]
        if 0 < len(above) < len(part):
            remedy += f", or name the blocks above it alone: {named(above)} (--part)"
        side = "above" if rise > 0.0 else "below"
        told = f"lies {abs(rise):.4g} m {side} the lowest edge of the part"
        raise InputError(told, where="line", remedy=remedy)
    ahead = np.cross(axis, UP)
    feet = (corners[corners[:, 2] <= lowest + near] - origin) @ ahead
    beside = float(np.clip(0.0, feet.min(), feet.max()))
    if abs(beside) > near:
        edge = origin + ahead * feet.max()
        told = f"lies {abs(beside):.4g} m beside the part's lowest edges"
        remedy = f"give one through {', '.join(f'{x + 0.0:.4g}' for x in edge)}"
        raise InputError(told, where="line", remedy=remedy)
    behind = float(feet.max())
    return [f"the line lies {behind:.4g} m behind the part's edge"] if behind > near else []


def _pulls(model: Model, part: Ints, motion: Floats) -> list[tuple[str, Floats, Floats]]:
    """Block, place (3,) [m] and pull (3,) [N] of each tie that a motion (n, 6) of a part stretches.

    Others go slack.
    """
    contacts, assembly = model.contacts, model.assembly
    stretched = contacts.corners.min(corner_motion(assembly, contacts, motion)[:, 0]) < 0.0
    found = []
    for i in np.flatnonzero(contacts.ties & stretched).tolist():
        blocks = contacts.block_a[i], contacts.block_b[i]
        inside = np.isin(blocks, part)
        if inside.all():
            continue
        name, strength = assembly.names[blocks[int(inside[1])]], contacts.tie_strength[i]
        if not np.isfinite(strength):
            remedy = "give it one: --tie BLOCK:BLOCK:20kN"
            raise InputError(f"the tie of '{name}' has no strength", where="part", remedy=remedy)
        pull = strength * contacts.frame[i, 0]
        found.append((name, contacts.centroid[i], pull if inside[1] else -pull))
    return found


OFFERED = Offered(
    local_mechanism,
    "arch.json --part 'voussoir-*'",
    ("direction", "part", "site"),
    names=("direction", "part", "line", "site", "time_limit_s"),
)
