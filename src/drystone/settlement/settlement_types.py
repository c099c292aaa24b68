"""Results of following blocks by steps."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.base.table import Table
from drystone.model import Model, OfModel
from drystone.results import Residuals
from drystone.settlement.faces.corners import Carrier
from drystone.settlement.loading_order import Loading
from drystone.settlement.proof import moved_model


class Outcome(enum.Enum):
    """How a settlement ends."""

    RESTS = "comes to rest"
    """Near its first position; with forces that balance the loads on the moved blocks."""
    DISPLACED = "comes to rest far away"
    """At rest, but a block moved by more than in a structure that stands."""
    FALLS = "falls"
    """A block moved by a large share of its size and still moves."""
    ENDS_DECIDE = "the ends of the joints decide"
    """The result depends on the block that carries the ends of the joints."""
    UNKNOWN = "not followed to an end"
    """The message has the reason."""


@dataclass(frozen=True)
class SettlementOptions(Options):
    """Options of :func:`settle`.

    Lengths are relative to the size of a block, the cube root of its volume.

    Attributes
    ----------
    rest_within
        Largest displacement of a block with which a structure at rest stands.
    fall
        Displacement from which on a moving block falls.
    carrier
        The block that carries the ends of joints where both end flush. When left out, both cases
        are followed if there are such ends.
    overlap
        Of the corners under the mean load of a block: small for rigid blocks. Between 1e-6 and 1e-7
        no limit of ten measured models changes by more than half a degree.
    tangential
        Tangential by normal stiffness. Discrete-element programs use 0.1 to 1. The default has the
        smallest largest miss of 41 published limits; two of them depend on it.
    loading
        In which order the load is put on: at once, as a ramp, or turned from upright.
    pace
        Factor on the default length of the steps.
    step_limit
        Largest number of steps. Four times as many Newton steps end a run as well.
    """

    rest_within: float = 0.02
    fall: float = 0.3
    carrier: Carrier | None = None
    overlap: float = 1e-6
    tangential: float = 0.17
    loading: Loading = Loading.AT_ONCE
    pace: float = 1.0
    step_limit: int = 5000

    def __post_init__(self) -> None:
        super().__post_init__()
        names = ("rest_within", "fall", "overlap", "tangential", "pace")
        self._refuse_unless_positive(*names)
        for name in names:
            if not getattr(self, name) < np.inf:
                raise InputError(f"{name} is {getattr(self, name)}", remedy="give a finite number")
        if self.rest_within > self.fall:
            raise InputError(
                f"rest_within is {self.rest_within:g}, above fall, {self.fall:g}",
                remedy="give a smaller rest_within, or a larger fall",
            )
        if not 1e-9 <= self.overlap <= 1e-2:
            raise InputError(
                f"overlap is {self.overlap:g}", remedy="give a number between 1e-9 and 1e-2"
            )
        self._refuse_below(1, "step_limit")


@dataclass(frozen=True, eq=False)
class SettlementPath(OneLine):
    """The motion of the blocks, for one carrier of the ends of the joints.

    Attributes
    ----------
    carrier
    outcome
    model
        The model at the beginning, with the interfaces of faces that were met on the way.
    positions : (s, n, 6) [m, rad]
        Positions of the blocks after each step that was kept, from the first to the last:
        translation of the centroid and rotation vector from the beginning, world axes.
    travel : (n,)
        Displacement of each block, divided by its size. A rotation counts with the radius of
        gyration.
    force : (k, 3) [N], local n, u, v of ``axes``, on block b, at the end
    point : (k, 3) [m], where the forces act at the end
    axes : (k, 3, 3) rows n, u, v at the end
    gap : (k,) [m], between the faces at the end; negative where they press
    residuals
        Of the forces on the moved blocks; None where they do not rest.
    share
        Of the load that the contacts do not carry at the end.
    steps, iterations
        Increments, and Newton steps.
    met
        Interfaces of faces that were apart at the beginning and have pressed since, the last ones.
    overlap
        That of the options, or smaller where springs were too soft.
    """

    carrier: Carrier
    outcome: Outcome
    model: Model
    positions: Floats
    travel: Floats
    force: Floats
    point: Floats
    axes: Floats
    gap: Floats
    residuals: Residuals | None
    share: float
    steps: int
    iterations: int
    met: tuple[int, ...] = ()
    overlap: float = 1e-6

    def _summary(self) -> str:
        return (
            f"{self.outcome.value}, travel {self.travel.max(initial=0.0):.3g}, {self.steps} steps"
        )

    @property
    def displacement(self) -> Floats:
        """(n, 6) [m, rad], the last of the positions."""
        last: Floats = self.positions[-1]
        return last

    @property
    def moving(self) -> tuple[int, ...]:
        """Positions of the blocks that travelled a tenth or more of the longest travel."""
        most = float(self.travel.max(initial=0.0))
        return tuple(np.flatnonzero((self.travel >= 0.1 * most) & (self.travel > 0.0)).tolist())

    def moved_model(self) -> Model:
        """The blocks at the end, with an interface for each corner where its force acts."""
        return moved_model(self.model, self.displacement, self.axes, self.point)


@dataclass(frozen=True, eq=False)
class Settlement(OfModel, OneLine):
    """The motion of the blocks until they rest or fall.

    Attributes
    ----------
    outcome
    message
        One sentence for the user.
    paths
        One for each carrier of the ends of the joints; only one if there are no such ends, or if
        one was requested. The first has moving carriers.
    stopped
        Why it stopped before the blocks rest or fall; else empty.
    options
    time_s
    """

    outcome: Outcome
    message: str
    paths: tuple[SettlementPath, ...]
    stopped: str = ""
    options: SettlementOptions = field(default_factory=SettlementOptions)
    time_s: Mapping[str, float] = field(default_factory=dict)

    def _summary(self) -> str:
        return f"{self.outcome.value}, '{self.message}'"

    def __bool__(self) -> bool:
        raise TypeError("a settlement is neither true nor false; ask for .outcome or .rests")

    @property
    def path(self) -> SettlementPath:
        """The first path."""
        return self.paths[0]

    @property
    def rests(self) -> bool:
        """Whether it rests near its first position, for every carrier of the ends."""
        return self.outcome is Outcome.RESTS

    @property
    def model(self) -> Model:
        """The model at the beginning."""
        return self.path.model

    @property
    def displacement(self) -> Floats:
        """(n, 6) [m, rad], where the blocks of the first path end."""
        return self.path.displacement

    @property
    def travel(self) -> float:
        """Largest displacement of a block in the first path, relative to its size."""
        return float(self.path.travel.max(initial=0.0))

    def table(self) -> Table:
        """Motion of every block, path by path: translation [m], rotation vector [rad], travel."""
        names = self.model.assembly.names
        motion = np.concatenate([path.displacement for path in self.paths])
        columns: dict[str, Any] = {
            "carrier": [path.carrier.value for path in self.paths for _ in names],
            "block": list(names) * len(self.paths),
            **{f"move_{axis}": motion[:, i] for i, axis in enumerate("xyz")},
            **{f"turn_{axis}": motion[:, 3 + i] for i, axis in enumerate("xyz")},
            "travel": np.concatenate([path.travel for path in self.paths]),
        }
        return Table("settlement", columns)

    def to_dict(self) -> dict[str, Any]:
        """Plain values: the outcome; for each path how it ends and the motion of every block."""
        rows, count = self.table().to_dict()["rows"], len(self.model.assembly)
        return {
            "outcome": self.outcome.value,
            "message": self.message,
            "stopped": self.stopped,
            "paths": [
                {
                    "carrier": path.carrier.value,
                    "outcome": path.outcome.value,
                    "travel": float(path.travel.max(initial=0.0)),
                    "steps": path.steps,
                    "residuals": None if path.residuals is None else asdict(path.residuals),
                    "blocks": rows[i * count : (i + 1) * count],
                }
                for i, path in enumerate(self.paths)
            ],
        }
