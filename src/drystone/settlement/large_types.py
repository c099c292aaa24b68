"""What driving blocks by finite amounts answers: states, a curve, a capacity."""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from drystone.answer import (
    Answer,
    Layer,
    LayerKind,
    MarkerShape,
    Role,
    Scene,
    SceneStage,
    Sentence,
    State,
)
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.answer.drawing import interface_layers, load_layers, state_of
from drystone.answer.question import Question, directions
from drystone.base import units
from drystone.base.arrays import Bools, Floats
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.base.table import Table
from drystone.checks import block_speed
from drystone.contacts import Contacts
from drystone.friction_use import utilisation_of
from drystone.geometry.frames import rotations
from drystone.joints import (
    HINGED,
    Resultants,
    hinged,
    joint_table,
    resultants_of,
)
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.settlement.settlement_types import SettlementOptions

CARRIES = 1e-3
"""Joints with less normal force than this share of the largest are neither hinges nor sliding."""

SECONDS = 6.0
"""Time [s] in which a page plays the states. Chosen."""
FALLS = 0.1
"""Of the largest motion of a block that falls: those that move more fall with it. Chosen."""


class Drive(enum.Enum):
    """What grows."""

    LOAD = "load"
    """A load; its factor is found."""
    SUPPORTS = "supports"
    """The motion of supports."""
    FRICTION = "friction"
    """What is lost of all friction coefficients."""


class End(enum.Enum):
    """Why the blocks are followed no farther."""

    SPENT = "pushed over"
    """The load has fallen to zero: the blocks are in an equilibrium from which they fall."""
    FALLS = "falls"
    """Blocks move on while what drives them is held."""
    HELD = "nothing gives way"
    """Some joint carries a thousand times the load of a block."""
    REACHED = "as far as asked for"
    """All that was asked for is done."""
    LOST = "no further position was found"
    """No equilibrium was found farther on."""
    STOPPED = "ended early"
    """Time was up, it was interrupted, or there were too many steps."""

    @property
    def verdict(self) -> Verdict:
        """On supports that move."""
        known = {End.REACHED: Verdict.STABLE, End.FALLS: Verdict.UNSTABLE}
        return known.get(self, Verdict.UNDECIDED)


_NAMES = {
    Drive.LOAD: "Push",
    Drive.SUPPORTS: "Motion of the supports",
    Drive.FRICTION: "Loss of friction",
}
_LABELS = {
    Drive.LOAD: ("displacement of the load", "load factor"),
    Drive.SUPPORTS: ("motion of the support", "force on the moving supports"),
    Drive.FRICTION: ("largest displacement of a block", "share of the friction"),
}


@dataclass(frozen=True, eq=False)
class LargeState(OneLine):
    """The blocks at one moment.

    Attributes
    ----------
    displacement : [m]
    load
        Load factor, force on the moving supports [N], or share of friction; see
        :class:`LargeDisplacement`.
    positions : (n, 6) [m, rad]
        Translation of the centroid and rotation vector of each block from the beginning, world
        axes.
    contacts
        Interfaces where they are now; the normal is the mean one of the pressed corners.
    force : (k, 3) [N], local n, u, v, on block b
    """

    displacement: float
    load: float
    positions: Floats
    contacts: Contacts
    force: Floats

    def _summary(self) -> str:
        told = f"displacement {self.displacement:.4g} m, load {self.load:.4g}"
        hinges, slides = len(self.hinges), len(self.sliding)
        return f"{told}, {counted(hinges, 'hinge')}, {counted(slides, 'sliding joint')}"

    @cached_property
    def resultants(self) -> Resultants:
        """Force and centre of pressure of every interface, where it is now."""
        return resultants_of(self.contacts, self.force)

    @cached_property
    def utilisation(self) -> Floats:
        """(m,) tangential force by friction coefficient times normal force."""
        return utilisation_of(self.contacts, self.resultants)

    @cached_property
    def _carrying(self) -> np.ndarray:
        normal = self.resultants.normal
        return np.asarray(normal > CARRIES * float(normal.max(initial=0.0)))

    @cached_property
    def hinges(self) -> tuple[int, ...]:
        """Interfaces that press along one edge only."""
        found = hinged(self.contacts, self.resultants) & self._carrying
        return tuple(np.flatnonzero(found).tolist())

    @cached_property
    def sliding(self) -> tuple[int, ...]:
        """Interfaces whose friction is spent."""
        found = (self.utilisation > HINGED) & self._carrying
        return tuple(np.flatnonzero(found).tolist())

    def result(self, model: Model, verdict: Verdict, message: str, stopped: str = "") -> Result:
        """The same as a result, with the forces in the joints of the model alone."""
        return Result(
            "settlement", verdict, model, message, force=self.force[: model.contacts.corner_count],
            displacement=self.positions, stopped=stopped,
        )  # fmt: skip

    def placed(self, model: Model) -> Model:
        """The model with its blocks and joints where they are now, without joints met later."""
        own = self.contacts.select(np.arange(self.contacts.count) < model.contacts.count)
        return replace(model, assembly=model.assembly.moved(self.positions), contacts=own)

    def joints(self, names: tuple[str, ...]) -> Table:
        """The table of :meth:`drystone.Result.joints`, of this state."""
        return joint_table(self.contacts, names, self.resultants, self.utilisation)


@dataclass(frozen=True, eq=False)
class LargeDisplacement(Answer):
    """Blocks that were followed while something grew.

    What ``displacement`` and ``load`` are depends on what grows:

    ========  =======================================  ==========================================
    grows     displacement [m]                         load
    ========  =======================================  ==========================================
    load      mean displacement of the forces of the   load factor
              load on the blocks that move, along
              themselves, by their size
    supports  largest motion of a corner of a support  force of the blocks on the moving
                                                       supports, along their motion [N]
    friction  largest displacement of a centroid       share of the friction coefficients
    ========  =======================================  ==========================================

    Attributes
    ----------
    drive
        What grows.
    model
        At the beginning.
    displacement, load : (s,)
        After every increment.
    states
        Of some of the increments, first and last and that of the largest load among them.
    end
        Why they were followed no farther.
    message
        One sentence for a person.
    fallen
        Where blocks were seen to fall, after the last state; None where they do not. It is no
        equilibrium.
    options
    grows
        The load that grows, in words; empty where something else does.
    """

    drive: Drive
    model: Model
    displacement: Floats
    load: Floats
    states: tuple[LargeState, ...]
    end: End
    message: str
    fallen: LargeState | None = None
    options: SettlementOptions = field(default_factory=SettlementOptions)
    grows: str = ""

    def _summary(self) -> str:
        return f"{self.drive.value}, {counted(len(self.states), 'state')}, '{self.message}'"

    def __len__(self) -> int:
        """Number of states."""
        return len(self.states)

    def __getitem__(self, number: int) -> LargeState:
        return self.states[number]

    @property
    def peak(self) -> float:
        """The largest load."""
        return float(self.load.max(initial=-np.inf))

    @property
    def capacity(self) -> float | None:
        """[m], the displacement from which blocks fall without the load, or while it is held.

        None where they were not followed so far.
        """
        if self.end is End.SPENT:
            # the last load is zero or less, the one before it is more
            (first, last), (above, below) = self.displacement[-2:], self.load[-2:]
            return float(first + (last - first) * above / (above - below))
        return float(self.displacement[-1]) if self.end is End.FALLS else None

    @property
    def unit(self) -> str:
        """Of the load."""
        return "N" if self.drive is Drive.SUPPORTS else ""

    def table(self) -> Table:
        """The curve: displacement and load after every increment."""
        named = {"displacement": "m"} | ({"load": self.unit} if self.unit else {})
        columns = {"displacement": self.displacement, "load": self.load}
        return Table(f"load against displacement, {self.drive.value}", columns, named)

    def events(self) -> Table:
        """When a joint becomes a hinge, slides, opens wholly or closes, among the states."""
        names = self.assembly.names
        rows: list[tuple[int, float, float, str, int]] = []
        before: dict[str, set[int]] = {}
        for number, state in enumerate(self.states):
            now = {"hinge": set(state.hinges), "slides": set(state.sliding)}
            for kind, joints in now.items():
                rows += [
                    (number, state.displacement, state.load, kind, joint)
                    for joint in sorted(joints - before.get(kind, set()))
                ]
            before = now
        told = ("state", "displacement", "load", "event", "joint")
        columns: dict[str, Any] = {name: [row[i] for row in rows] for i, name in enumerate(told)}
        for side in ("block_a", "block_b"):
            columns[side] = [names[getattr(self.contacts, side)[row[4]]] for row in rows]
        named = {"displacement": "m"} | ({"load": self.unit} if self.unit else {})
        return Table("events", columns, named)

    @property
    def title(self) -> str:
        """How far it was followed, in words for a person."""
        if self.drive is not Drive.SUPPORTS:
            name = _NAMES[self.drive]
            if self.stopped:
                return f"{name}, ended early: {self.message.partition(';')[0]}"
            return f"{name}: {self.message}"
        last, far = self.states[-1], units.quantity(float(self.displacement[-1]), "m")
        if self.end is End.FALLS:
            return f"Falls when the supports have moved by {far}"
        if self.end is not End.REACHED:
            return f"Not decided: followed until the supports had moved by {far}"
        marks = [(len(last.hinges), "hinge"), (len(last.sliding), "sliding joint")]
        told = " and ".join(counted(count, what) for count, what in marks if count)
        return f"Stands with its supports moved by {far}{': ' if told else ''}{told}"

    def sentences(self) -> Sequence[Sentence]:
        """Why it ends, what was found, and of which load or force."""
        told = f"the load is {self.grows} times the factor that is told" if self.grows else ""
        if self.drive is Drive.SUPPORTS:
            told = "the force is that of the blocks on the supports that move, along their motion"
        end = Sentence(self.end.value.upper(), self._role or Role.UNSURE)
        return [end, Sentence(self.message), *([Sentence(told)] if told else [])]

    @cached_property
    def asked(self) -> Question:
        """What was asked, with the load that grows."""
        asked = super().asked
        more = f", and {self.grows} times a factor" if self.grows else ""
        return replace(asked, load=asked.load + more)

    @property
    def code(self) -> int:
        """0 where it stands to the end, or a displacement from which it falls was found; else 1."""
        found = self.capacity is not None and len(self.displacement) > 1
        stands = self._role is Role.GOOD
        return 0 if stands or (found and self.drive is not Drive.SUPPORTS) else 1

    def tables(self) -> Sequence[Table]:
        """When joints become hinges and slide."""
        return [self.events()]

    def numbers(self) -> Mapping[str, Any]:
        """The curve, its peak and its end, and the positions of the blocks that move."""
        names = self.assembly.names
        moving = np.any([state.positions.any(axis=1) for state in self.states], axis=0)
        return {
            "drive": self.drive,
            "end": self.end,
            "message": self.message,
            "unit": self.unit,
            "peak": self.peak,
            "capacity": self.capacity,
            "curve": {"displacement": self.displacement, "load": self.load},
            "positions": {
                "displacement": [state.displacement for state in self.states],
                "blocks": {
                    names[i]: [state.positions[i] for state in self.states]
                    for i in np.flatnonzero(moving)
                },
            },
        }

    @property
    def _role(self) -> Role | None:
        """Of the last state; None where a load holds it."""
        if self.end is End.FALLS:
            return Role.BAD
        if self.drive is Drive.LOAD:
            return None
        return Role.GOOD if self.end is End.REACHED else Role.UNSURE

    @property
    def falling(self) -> Bools:
        """Which blocks (n,) fall at the end."""
        falls = ~self.assembly.fixed
        if self.fallen is None:
            return falls & False
        gone = block_speed(self.assembly, self.fallen.positions - self.states[-1].positions)
        return falls & (gone > FALLS * float(gone.max()))

    def layers(self) -> Scene:
        """The states from first to last, and the fall where there is one."""
        seen = (*self.states, *([] if self.fallen is None else [self.fallen]))
        path = np.stack([one.positions for one in seen])
        state = state_of(self.assembly)
        state[self.falling] = State.FALLING
        up, gravity = directions(self.assembly, self.model.load)
        stage = SceneStage(
            "all states", self.title, "; ".join([self.message, *self.model.notes]), state,
            self._role, motion=path[-1], motion_name=_NAMES[self.drive],
            path=path if len(path) > 1 else None, seconds=SECONDS, plays=True,
            up=up, gravity=gravity,
            layers=(
                *interface_layers(self.contacts),
                *load_layers(self.assembly, self.model.load),
                *self._marks(self.states[-1]),
            ),
        )  # fmt: skip
        return Scene(
            self.assembly, self.contacts, (stage,),
            f"drystone: {self.title[0].lower()}{self.title[1:]}", self.asked.facts(),
            charts=(self.figure(),), preset="solid",
        )  # fmt: skip

    def _marks(self, state: LargeState) -> tuple[Layer, ...]:
        """Hinges and sliding joints of a state; they are where their second blocks carry them."""
        made = []
        for key, label, colour, shape, joints in (
            ("hinges", "hinge: force at an edge", "hinge", MarkerShape.DISC, state.hinges),
            ("sliding", "friction fully used", "help", MarkerShape.DIAMOND, state.sliding),
        ):
            number = np.array(joints, dtype=np.intp)
            if len(number):
                block = state.contacts.block_b[number]
                moved, turn = np.split(state.positions[block], 2, axis=1)
                centroid = self.assembly.centroid[block]
                arm = state.resultants.position[number] - centroid - moved
                place = centroid + (rotations(-turn) @ arm[:, :, None])[:, :, 0]
                layer = Layer(
                    key, label, LayerKind.MARKERS, colour, place, block=block, shape=shape
                )
                made.append(layer)
        return tuple(made)

    def figure(self) -> Chart:
        """The load against the displacement, with new hinges and slides."""
        events, marks = self.events(), [Marks(MarkKind.LINE, self.displacement, self.load)]
        for kind, label, ink, shape in (
            ("hinge", "a joint becomes a hinge", "good", MarkKind.DISC),
            ("slides", "a joint slides", "bad", MarkKind.DIAMOND),
        ):
            here = np.flatnonzero(events["event"] == kind)
            if len(here):
                at = events["displacement"][here], events["load"][here]
                marks.append(Marks(shape, *at, ink, label))
        told = self.message
        drops = np.diff(self.load) < -0.01 * np.abs(self.load).max(initial=0.0)
        alone = np.flatnonzero(drops & (np.diff(self.displacement) <= 0.0))
        if len(alone):
            at = self.displacement[alone], self.load[alone + 1]
            marks.append(Marks(MarkKind.CROSS, *at, "unsure", "moved on by itself, at rest again"))
            told += "\nWhere the load drops at once, blocks move on by themselves until they rest"
        known = self.capacity is not None and self.end is not End.LOST
        where = units.quantity(self.capacity or 0.0, "m")
        lines = ((self.capacity, where),) if known and self.capacity else ()
        across, up = _LABELS[self.drive]
        return Chart(
            "Load against displacement", tuple(marks), across, up, ("m", self.unit), told, lines,
        )  # fmt: skip
