"""What following the blocks by steps answers."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.contacts import Contacts
from drystone.model import Model
from drystone.results import Residuals
from drystone.settlement.corners import Carrier
from drystone.settlement.proof import moved_model


class Outcome(enum.Enum):
    """How a settlement ends."""

    RESTS = "comes to rest"
    """Near its first position; forces that balance the loads on the moved blocks are attached."""
    DISPLACED = "comes to rest far away"
    """At rest, but a block went farther than a structure that stands does."""
    FALLS = "falls"
    """A block went by a large share of its size and still moves."""
    ENDS_DECIDE = "the ends of the joints decide"
    """One answer with the ends of the joints carried by one block, another with the other."""
    UNKNOWN = "not followed to an end"
    """The message says why."""


@dataclass(frozen=True)
class SettlementOptions(Options):
    """Options of :func:`settle`; lengths by the size of a block, the cube root of its volume.

    Attributes
    ----------
    rest_within
        Way of a block up to which a structure that comes to rest is said to stand.
    fall
        Way of a block from which on it is said to fall while it still moves.
    carrier
        Which block carries the ends of joints where both end flush. Left out, both ways are
        followed where there are such ends.
    overlap
        Of the corners under the mean load of a block: small for rigid blocks. Between 1e-6 and 1e-7
        no limit of ten models that were measured changes by more than half a degree.
    tangential
        Tangential by normal stiffness. Discrete-element programs use 0.1 to 1.
    pace
        Length of the steps by the default.
    step_limit
        Steps after which it is given up.
    """

    rest_within: float = 0.02
    fall: float = 0.3
    carrier: Carrier | None = None
    overlap: float = 1e-6
    tangential: float = 0.2
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
                remedy="a block falls when it went farther than one that stands",
            )
        if not 1e-9 <= self.overlap <= 1e-2:
            raise InputError(
                f"overlap is {self.overlap:g}", remedy="give a number between 1e-9 and 1e-2"
            )
        self._refuse_below(1, "step_limit")


@dataclass(frozen=True, eq=False)
class SettlementPath(OneLine):
    """How the blocks moved, with one choice of what carries the ends of the joints.

    Attributes
    ----------
    carrier
    outcome
    model
        The model at the beginning.
    positions : (s, n, 6) [m, rad]
        Positions of the blocks after each step that was kept, from the first to the last:
        translation of the centroid and rotation vector from the beginning, world axes.
    way : (n,) translation and rotation by the radius of gyration, by the size of each block
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
    """

    carrier: Carrier
    outcome: Outcome
    model: Model
    positions: Floats
    way: Floats
    force: Floats
    point: Floats
    axes: Floats
    gap: Floats
    residuals: Residuals | None
    share: float
    steps: int
    iterations: int

    def _summary(self) -> str:
        return f"{self.outcome.value}, way {self.way.max(initial=0.0):.3g}, {self.steps} steps"

    @property
    def displacement(self) -> Floats:
        """(n, 6) [m, rad], the last of the positions."""
        last: Floats = self.positions[-1]
        return last

    @property
    def moving(self) -> tuple[int, ...]:
        """Positions of the blocks that went by a tenth or more of the longest way."""
        most = float(self.way.max(initial=0.0))
        return tuple(np.flatnonzero((self.way >= 0.1 * most) & (self.way > 0.0)).tolist())

    def moved_model(self) -> Model:
        """The blocks at the end, with an interface for each corner where its force acts."""
        return moved_model(self.model, self.displacement, self.axes, self.point)


@dataclass(frozen=True, eq=False)
class Settlement(OneLine):
    """Where blocks go that are left to themselves.

    Attributes
    ----------
    outcome
    message
        One sentence for a person.
    paths
        One for each choice of what carries the ends of the joints; one only where there are no such
        ends, or where one was asked for. The first is the one with moving carriers.
    stopped
        Why it ended before it was followed to an end; empty where it was.
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
        """The first one."""
        return self.paths[0]

    @property
    def rests(self) -> bool:
        """Whether it comes to rest near its first position, whatever carries the ends."""
        return self.outcome is Outcome.RESTS

    @property
    def model(self) -> Model:
        """The model at the beginning."""
        return self.path.model

    @property
    def assembly(self) -> Assembly:
        """The blocks at the beginning."""
        return self.model.assembly

    @property
    def contacts(self) -> Contacts:
        """The contacts at the beginning."""
        return self.model.contacts

    @property
    def displacement(self) -> Floats:
        """(n, 6) [m, rad], where the blocks of the first path end."""
        return self.path.displacement

    @property
    def way(self) -> float:
        """Longest way of a block in the first path, by its size."""
        return float(self.path.way.max(initial=0.0))


__all__ = ["Outcome", "Settlement", "SettlementOptions", "SettlementPath"]
