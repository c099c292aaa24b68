"""How a limit is searched, and what is found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from drystone.base.display import Card
from drystone.base.errors import InputError, counted
from drystone.base.settings import Options
from drystone.base.table import Table
from drystone.formulations.equilibrium import FrictionCone
from drystone.limits.search import Bracket, Evaluation, plain


@dataclass(frozen=True)
class LimitOptions(Options):
    """How a limit is searched.

    Attributes
    ----------
    width
        Of the brackets, in the unit of the parameter; left out, a default of each limit.
    scan
        Steps between the start and the limit of equilibrium that are tried before it is bisected:
        an island narrower than a step can be missed.
    cone
        Of the equilibrium limit.
    full
        Whether to search the full verdict too.
    """

    width: float | None = None
    scan: int = 6
    cone: FrictionCone = field(default_factory=FrictionCone.exact)
    full: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.width is not None and not 0.0 < self.width < float("inf"):
            raise InputError(f"width is {self.width}", remedy="give a number above zero")
        if self.scan < 1:
            raise InputError(f"scan is {self.scan}", remedy="give one step or more")


@dataclass(frozen=True, eq=False)
class Limit(Card):
    """A limit by both definitions.

    Attributes
    ----------
    parameter, unit
    start, end
        Range that was searched, from where it should stand.
    equilibrium
        Some forces balance the loads (associative friction).
    rest
        The full verdict: stands for some contact stiffness. ``None`` where it was not asked for.
    uniform
        Stands for uniform contact stiffness, as a discrete-element program would see it; never
        beyond ``rest``. ``None`` with a check of one's own.
    islands
        Values beyond the first fall at which it stands again, as far as they were tried.
    evaluations
        Values that were tried, in ascending order.
    time_s
    stopped
        Why the search ended before the brackets were as narrow as asked for; else empty.
    """

    parameter: str
    unit: str
    start: float
    end: float
    equilibrium: Bracket
    rest: Bracket | None = None
    uniform: Bracket | None = None
    islands: tuple[tuple[float, float], ...] = ()
    evaluations: tuple[Evaluation, ...] = ()
    time_s: Mapping[str, float] = field(default_factory=dict)
    stopped: str = ""

    def _facts(self) -> tuple[str, Mapping[str, object]]:
        kinds = {"equilibrium": self.equilibrium, "rest": self.rest, "uniform": self.uniform}
        falling = self.best.falling
        return self._summary(), {
            **{
                kind: f"{_told(bracket.stands)} to {_told(bracket.falls)} {self.unit}"
                for kind, bracket in kinds.items()
                if bracket is not None
            },
            "falls then": "" if falling is None else ", ".join(falling.falling_names),
            "tried": counted(len(self.evaluations), "value"),
        }

    def _summary(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        stands, falls = (_told(x) for x in (self.best.stands, self.best.falls))
        early = f", stopped: {self.stopped}" if self.stopped else ""
        return f"{self.parameter}, stands at {stands}{unit}, falls at {falls}{unit}{early}"

    @property
    def best(self) -> Bracket:
        """The bracket of the full verdict, or that of equilibrium where there is no other."""
        return self.equilibrium if self.rest is None else self.rest

    @property
    def is_sensitive(self) -> bool:
        """Whether it stands farther for some contact stiffnesses than for a uniform one."""
        if self.rest is None or self.uniform is None:
            return False
        return self.rest.stands != self.uniform.stands

    def table(self) -> Table:
        """The values that were tried, in ascending order, and what stands there."""
        tried = self.evaluations
        columns = {
            "value": [one.value for one in tried],
            "verdict": [one.verdict.value for one in tried],
            "stiffnesses_tried": [one.samples.tried for one in tried],
            "stiffnesses_standing": [one.samples.standing for one in tried],
        }
        return Table(self.parameter, columns, {"value": self.unit} if self.unit else {})

    def to_dict(self) -> dict[str, Any]:
        """Plain values; blocks that fall by name."""
        falling = self.best.falling
        return {
            "parameter": self.parameter,
            "unit": self.unit,
            "range": [self.start, self.end],
            "equilibrium": plain(self.equilibrium),
            "rest": plain(self.rest),
            "uniform": plain(self.uniform),
            "islands": [list(run) for run in self.islands],
            "falling": [] if falling is None else list(falling.falling_names),
            "message": "" if falling is None else falling.message,
            "sensitive": self.is_sensitive,
            "stopped": self.stopped,
            "evaluations": [
                {
                    "value": one.value,
                    "verdict": one.verdict.value,
                    "tried": one.samples.tried,
                    "standing": one.samples.standing,
                }
                for one in self.evaluations
            ],
            "time_s": dict(self.time_s),
        }


def _told(value: float | None) -> str:
    return "none that was tried" if value is None else f"{value:.6g}"


__all__ = ["Limit", "LimitOptions"]
