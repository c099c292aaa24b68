"""What limits consist of: values that were tried, both sides, options, and what follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.formulations.corner_forces import FrictionCone
from drystone.limits.limit_families import Quantity
from drystone.results import Result, Samples, Verdict
from drystone.settlement import Outcome


@dataclass(frozen=True)
class Evaluation:
    """One value that was tried.

    Attributes
    ----------
    value
    verdict
    samples
    settled
        How it ended where the blocks were followed by finite steps, because contact stiffness
        decides; else ``None``.
    """

    value: float
    verdict: Verdict
    samples: Samples = field(default_factory=Samples)
    settled: Outcome | None = None


@dataclass(frozen=True, eq=False)
class Bracket(OneLine):
    """Both sides of a limit.

    Attributes
    ----------
    stands
        The last value at which it stands; ``None`` if none was found.
    falls
        The first value beyond at which it falls; ``None`` if it stands at all tried values.
    standing, falling
        The states there; the falling one has the mechanism.
    computed
        The limit from a convex program, if there is one.
    """

    stands: float | None = None
    falls: float | None = None
    standing: Result | None = None
    falling: Result | None = None
    computed: float | None = None

    def agrees(self, other: Bracket) -> bool:
        """Whether both may be of one limit: they overlap, or their sides are the same."""
        sides = [(one.stands, one.falls) for one in (self, other)]
        known = [[value for value in one if value is not None] for one in sides]
        if min(map(len, known)) < 2:
            return sides[0] == sides[1]
        return max(map(min, known)) <= min(map(max, known))

    def _summary(self) -> str:
        return f"stands={self.stands}, falls={self.falls}, computed={self.computed}"

    @property
    def value(self) -> float | None:
        """The limit: computed, or the middle of the bracket; ``None`` where a side is missing."""
        if self.stands is None or self.falls is None:
            return None
        if self.computed is not None:
            return self.computed
        return 0.5 * (self.stands + self.falls)

    def closes(self, stands: float, distance: float) -> bool:
        """Whether it falls within a distance of a value that stands."""
        return self.falls is not None and abs(self.falls - stands) <= distance


@dataclass(frozen=True, eq=False)
class FoundBracket:
    """Result of a search.

    Attributes
    ----------
    bracket
        Around the first change of the verdict, seen from the start.
    islands
        Values beyond it between which the structure stands again, as far as they were tried.
    evaluations
        In ascending order of the value.
    """

    bracket: Bracket
    islands: tuple[tuple[float, float], ...]
    evaluations: tuple[Evaluation, ...]


def plain(bracket: Bracket | None) -> dict[str, Any] | None:
    """A bracket as plain values."""
    if bracket is None:
        return None
    return {"stands": bracket.stands, "falls": bracket.falls, "value": bracket.value}


@dataclass(frozen=True)
class LimitOptions(Options):
    """Options of the search for a limit.

    Attributes
    ----------
    width : > 0
        Width of the brackets, in the unit of the parameter; when left out, a default of each limit.
    scan : >= 1
        Number of steps between the start and the limit of equilibrium before bisection. An island
        narrower than a step can be missed.
    cone
        Friction cone of the equilibrium limit: ``exact``, or the ``octagon`` of published figures.
    equilibrium_only
        Whether to search the limit of equilibrium only, without the verdict.
    robust
        Whether to search the limit of standing for every contact stiffness too.
    """

    width: float | None = None
    scan: int = 6
    cone: FrictionCone = field(default_factory=FrictionCone.exact)
    equilibrium_only: bool = False
    robust: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.width is not None and not 0.0 < self.width < float("inf"):
            raise InputError(f"width is {self.width}", remedy="give a number above zero")
        if self.scan < 1:
            raise InputError(f"scan is {self.scan}", remedy="give one step or more")


@dataclass(frozen=True, eq=False)
class LimitValues:
    """The numbers of a limit, and what follows from them; see :class:`Limit`."""

    quantity: Quantity
    start: float
    end: float
    equilibrium: Bracket
    rest: Bracket | None = None
    uniform: Bracket | None = None
    robust: Bracket | None = None
    islands: tuple[tuple[float, float], ...] = ()
    evaluations: tuple[Evaluation, ...] = ()
    time_s: Mapping[str, float] = field(default_factory=dict)
    stopped: str = ""
    options: LimitOptions | None = None

    @property
    def stands(self) -> float | None:
        """The last value at which it stands, by the verdict where that was asked for."""
        return self.best.stands

    @property
    def falls(self) -> float | None:
        """The first value beyond it at which it falls; ``None`` where it stands at all."""
        return self.best.falls

    @property
    def best(self) -> Bracket:
        """The bracket of the full verdict, or that of equilibrium if there is no other."""
        return self.equilibrium if self.rest is None else self.rest

    @property
    def sensitive_between(self) -> tuple[float, float] | None:
        """Values between which contact stiffness decides whether it stands.

        Between them either uniform stiffness holds it or the blocks come to rest, not both; or,
        where the limit for every stiffness was asked for, some stiffness does not hold it. ``None``
        if the verdict changes at one value.
        """
        if self.uniform is None or self.rest is None:
            return None
        falling = self.rest.falling
        # at the start, without any forces that balance the loads or without any that press
        at_once = self.rest.falls == self.start and (falling is None or falling.settlement is None)
        inner = (self.uniform, self.rest, *([] if self.robust is None else [self.robust]))
        low = min(self._from_start(one.stands) for one in inner)
        outer = (self.rest.stands, self.rest.falls, self.uniform.falls)
        high = max(self._from_start(value) for value in outer)
        here = tuple(self._from_start(value) for value in (self.rest.stands, self.rest.falls))
        if at_once or (low, high) == here or low == self._from_start(self.end):
            return None
        way = 1.0 if self.end > self.start else -1.0
        return self.start + way * low, self.start + way * high

    def _from_start(self, value: float | None) -> float:
        """Distance from the start; none where no value was found."""
        return 0.0 if value is None else abs(value - self.start)

    @property
    def is_sensitive(self) -> bool:
        """Whether contact stiffness decides at some value near the limit."""
        return self.sensitive_between is not None

    @property
    def undecided_between(self) -> tuple[float, float] | None:
        """The first and last value between the two sides of the limit that are undecided."""
        inside, outside = self.best.stands, self.best.falls
        if inside is None:
            return None
        low = abs(inside - self.start)
        high = float("inf") if outside is None else abs(outside - self.start)
        within = [
            one.value
            for one in self.evaluations
            if low < abs(one.value - self.start) < high and one.verdict is Verdict.UNDECIDED
        ]
        within.sort(key=lambda value: abs(value - self.start))
        return (within[0], within[-1]) if within else None
