"""Local collapse mechanisms in earthquakes, compared with a spectrum.

Source: linear and non-linear kinematic analysis of the Italian code, by Circolare 617/2009, C8A.4,
or Circolare 7/2019, C8.7.1.2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from drystone.answer import Answer, Layer, LayerKind, Role, Scene, SceneStage, Sentence, State
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.answer.drawing import interface_layers, load_layers, marks, seen, state_of, tie_layer
from drystone.base.arrays import SAME, Floats, Ints, lengths
from drystone.base.declared import Offered
from drystone.base.display import named
from drystone.base.errors import InputError, counted
from drystone.base.ragged import linked
from drystone.base.settings import Clock, checked_call
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.checks import block_speed, corner_motion, moving_joints
from drystone.geometry.frames import axis_vector
from drystone.io.opening import Given, LongHow, supported_model
from drystone.limits import limit_load
from drystone.loads import LoadCase
from drystone.loads.applied import Shaken
from drystone.loads.case import STANDARD_GRAVITY
from drystone.model import Model
from drystone.seismic.spectrum import LimitState, SeismicDemand
from drystone.seismic.turning_part import (
    Oscillator,
    Turning,
    masses_of,
    turning_of,
    weights_that_move,
)
from drystone.settlement import LargeDisplacement, push
from drystone.settlement.large_displacement import MOVES


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
        """The limit state of the site; without one SLV of Circolare 7/2019."""
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
            layers=(*interface_layers(contacts), *load_layers(assembly, self.model.load),
                    *tie_layer(assembly, contacts, self._tied), *self._earthquake(),
                    *self._hinges()),
        )  # fmt: skip
        charts = (self.chart(),) if len(self.displacement) else ()
        title = f"drystone: {self.title[0].lower()}{self.title[1:]}"
        return Scene(assembly, contacts, (stage,), title, self.asked.facts(), charts=charts,
                     preset="solid")  # fmt: skip

    @property
    def _tied(self) -> str:
        """Ties with their strength, for a legend."""
        strength = self.model.contacts.tie_strength[self.model.contacts.ties]
        most = strength[np.isfinite(strength)].max(initial=0.0)
        return "tie" + (f", yields at {quantity(float(most), 'N')}" if most else "")

    def _earthquake(self) -> tuple[Layer, ...]:
        """The force of the earthquake on each mass that moves, as an arrow that ends in it."""
        alpha = self.oscillator.multiplier
        place, weight, block, _ = masses_of(self.model, np.flatnonzero(self._moving))
        along = np.array(self.options.direction.split(","), dtype=float)
        return (
            Layer("acceleration", f"earthquake, {alpha:.4g} g", LayerKind.ARROWS, "load",
                  place, np.outer(alpha * weight, along), block=block, single=True, width=2.4,
                  group="acceleration"),
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
            Layer("hinges", "its ends", LayerKind.MARKERS, "hinge",
                  line[0] + np.array([[0.0], [1.0]]) * line[1],
                  group="hinges"),
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
        The direction is not level; the part has no free block or a tie without a strength; the line
        is vertical, along the direction or not under the part.

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
    along = axis_vector(direction, "direction")
    if abs(along[2]) > SAME:
        raise InputError("is not level", where="direction", remedy="give x, y or X,Y,0")
    part = part if isinstance(part, str) else tuple(part)
    asked = _Asked(
        direction=", ".join(f"{x:.4g}" for x in along + 0.0),
        part=part if isinstance(part, str) else ", ".join(part),
        line=", ".join(f"{x:g}" for x in (() if line is None else line)),
        site=told,
    )
    if part:
        turning, motion, remarks = turning_of(model, along, part, line)
        told = "a rigid part that turns about a line; its joints neither slide, pull nor crush"
        if (model.contacts.crushes & ~model.contacts.ties).any():
            what = "is of rigid bodies that do not crush"
            raise InputError(what, where="part", remedy="leave the strength or the part out")
        found = LocalMechanism(
            model, motion, turning.oscillator(), *turning.curve(), told, site, asked,
            remarks=(*remarks, *_above_ground(model, turning, site)), moments=turning.moments(),
        )  # fmt: skip
        return replace(found, remarks=(*found.remarks, *_drawn_out(found, turning)))
    if line is not None:
        raise InputError("is for a part", where="line", remedy="name its blocks: --part")
    late: dict[str, Any] = {"progress": clock.progress, "stop": clock.late}
    return replace(_found(model, along, site, late), options=asked)


def _drawn_out(found: LocalMechanism, turning: Turning) -> tuple[str, ...]:
    """How far du* draws out a tie, of which the method asks nothing."""
    if not turning.ties or not math.isfinite(found.ultimate):
        return ()
    name, far = turning.drawn_out(found.ultimate * found.oscillator.share)
    return (
        f"at du* the {name} is drawn out by {far:.2g} m, at its strength all the way: ask whether "
        "a rod of its length, and its ends, bear that",
    )


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
    place, weight, block, _ = masses_of(model, np.arange(len(assembly)))
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


OFFERED = Offered(
    local_mechanism,
    "arch.json --part 'voussoir-*'",
    ("direction", "part", "site"),
    names=("direction", "part", "line", "site", "time_limit_s"),
)
