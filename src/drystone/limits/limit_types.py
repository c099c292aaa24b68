"""Options of the search for limits, and limits."""

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
    """Options of the search for a limit.

    Attributes
    ----------
    width
        Width of the brackets, in the unit of the parameter; when left out, a default of each limit.
    scan
        Number of steps between the start and the limit of equilibrium before bisection. An island
        narrower than a step can be missed.
    cone
        Friction cone of the equilibrium limit.
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
    """A limit of equilibrium and of rest.

    Attributes
    ----------
    parameter, unit
    start, end
        Searched range, from a value at which it should stand.
    equilibrium
        Some forces balance the loads (associative friction).
    rest
        The full verdict: it stands for some contact stiffness. ``None`` if not requested.
    uniform
        It stands for uniform contact stiffness, like in a discrete-element program; never beyond
        ``rest``. ``None`` with another check.
    islands
        Ranges beyond the first fall in which it stands again, as far as they were tried.
    evaluations
        Tried values, in ascending order.
    time_s
    stopped
        Why the search stopped before the brackets had the required width; else empty.
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
        """The bracket of the full verdict, or that of equilibrium if there is no other."""
        return self.equilibrium if self.rest is None else self.rest

    @property
    def is_sensitive(self) -> bool:
        """Whether the limit for some contact stiffness is beyond that for a uniform one."""
        if self.rest is None or self.uniform is None:
            return False
        return self.rest.stands != self.uniform.stands

    def table(self) -> Table:
        """The tried values, in ascending order, with their verdicts."""
        tried = self.evaluations
        columns = {
            "value": [one.value for one in tried],
            "verdict": [one.verdict.value for one in tried],
            "stiffnesses_tried": [one.samples.tried for one in tried],
            "stiffnesses_standing": [one.samples.standing for one in tried],
        }
        return Table(self.parameter, columns, {"value": self.unit} if self.unit else {})

    def to_dict(self) -> dict[str, Any]:
        """Plain values; falling blocks by name."""
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
