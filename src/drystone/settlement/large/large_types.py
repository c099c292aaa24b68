"""What driving blocks by finite amounts answers: states, a curve, a capacity."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.base.table import Table
from drystone.contacts import Contacts
from drystone.joints import (
    HINGED,
    Resultants,
    hinged,
    joint_table,
    resultants_of,
    utilisation_of,
)
from drystone.model import Model, OfModel
from drystone.settlement.settlement_types import SettlementOptions

if TYPE_CHECKING:
    import pandas

CARRIES = 1e-3
"""Joints with less normal force than this share of the largest are neither hinges nor sliding."""


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

    SPENT = "no load is needed any more"
    """The load has fallen to zero: the blocks are in an equilibrium from which they fall."""
    FALLS = "falls"
    """Blocks move on while what drives them is held."""
    HELD = "nothing gives way"
    """Some joint carries a thousand times the load of a block."""
    REACHED = "as far as asked for"
    LOST = "no further position was found"
    STOPPED = "ended early"
    """Time was up, it was interrupted, or there were too many steps."""


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

    def joints(self, names: tuple[str, ...]) -> Table:
        """The table of :meth:`drystone.Result.joints`, of this state."""
        return joint_table(self.contacts, names, self.resultants, self.utilisation)


@dataclass(frozen=True, eq=False)
class LargeDisplacement(OfModel, OneLine):
    """Blocks that were followed while something grew.

    What ``displacement`` and ``load`` are depends on what grows:

    ========  =======================================  ==========================================
    grows     displacement [m]                         load
    ========  =======================================  ==========================================
    load      mean displacement of the forces of the   load factor
              load, along themselves, by their size
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
    stopped
        Why it ended early; empty where it did not.
    options, time_s
    """

    drive: Drive
    model: Model
    displacement: Floats
    load: Floats
    states: tuple[LargeState, ...]
    end: End
    message: str
    fallen: LargeState | None = None
    stopped: str = ""
    options: SettlementOptions = field(default_factory=SettlementOptions)
    time_s: Mapping[str, float] = field(default_factory=dict)

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
        """[m], the displacement at which no load is needed any more, or from which blocks fall.

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
        units = {"displacement": "m"} | ({"load": self.unit} if self.unit else {})
        columns = {"displacement": self.displacement, "load": self.load}
        return Table(f"load against displacement, {self.drive.value}", columns, units)

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
        joint = [row[4] for row in rows]
        a, b = self.contacts.block_a, self.contacts.block_b
        columns: dict[str, Any] = {
            "state": [row[0] for row in rows],
            "displacement": [row[1] for row in rows],
            "load": [row[2] for row in rows],
            "event": [row[3] for row in rows],
            "joint": joint,
            "block_a": [names[a[i]] for i in joint],
            "block_b": [names[b[i]] for i in joint],
        }
        units = {"displacement": "m"} | ({"load": self.unit} if self.unit else {})
        return Table("hinges and slides", columns, units)

    def to_pandas(self) -> pandas.DataFrame:
        """The curve as a data frame."""
        return self.table().to_pandas()

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "drive": self.drive.value,
            "end": self.end.value,
            "message": self.message,
            "unit": self.unit,
            "peak": self.peak,
            "capacity": self.capacity,
            "stopped": self.stopped,
            "curve": {"displacement": self.displacement.tolist(), "load": self.load.tolist()},
            "events": self.events().to_dict()["rows"],
            "positions": {
                "displacement": [state.displacement for state in self.states],
                "blocks": {
                    name: [state.positions[i].tolist() for state in self.states]
                    for i, name in enumerate(self.assembly.names)
                    if any(state.positions[i].any() for state in self.states)
                },
            },
            "time_s": dict(self.time_s),
        }
