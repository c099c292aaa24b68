"""Both sides of a limit, and the values that were tried."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from drystone.base.display import OneLine
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
