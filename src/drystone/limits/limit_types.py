"""Options of the search for limits, and limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from drystone.base.display import Card
from drystone.base.errors import InputError, counted
from drystone.base.settings import Options
from drystone.base.table import Table
from drystone.formulations.corner_forces import FrictionCone
from drystone.limits.brackets import Bracket, Evaluation, plain
from drystone.results import Verdict
from drystone.settlement import Outcome


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
        Some forces balance the loads (associated flow).
    rest
        The verdict of :func:`drystone.check` on both sides. Where contact stiffness decides, the
        blocks were followed by finite steps. ``None`` if not requested.
    uniform
        It stands for uniform contact stiffness, like in a discrete-element program, to first order.
        ``None`` with another check.
    robust
        It stands for every tried contact stiffness. ``None`` with another check, and if not
        searched.
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
    robust: Bracket | None = None
    islands: tuple[tuple[float, float], ...] = ()
    evaluations: tuple[Evaluation, ...] = ()
    time_s: Mapping[str, float] = field(default_factory=dict)
    stopped: str = ""

    def _facts(self) -> tuple[str, Mapping[str, object]]:
        kinds = {
            "equilibrium": self.equilibrium,
            "rest": self.rest,
            "uniform": self.uniform,
            "robust": self.robust,
        }
        falling = self.best.falling
        return self._summary(), {
            **{
                kind: f"{self._told(bracket.stands)} to {self._told(bracket.falls)}"
                for kind, bracket in kinds.items()
                if bracket is not None
            },
            "falls then": "" if falling is None else ", ".join(falling.falling_names),
            "tried": counted(len(self.evaluations), "value"),
            "depends on joints": "; ".join(self.remarks),
        }

    def _summary(self) -> str:
        stands, falls = self._told(self.best.stands), self._told(self.best.falls)
        early = f", stopped: {self.stopped}" if self.stopped else ""
        return f"{self.parameter}, stands at {stands}, falls at {falls}{early}"

    def _told(self, value: float | None) -> str:
        unit = f" {self.unit}" if self.unit else ""
        return "none that was tried" if value is None else f"{value:.6g}{unit}"

    def _range(self, ends: tuple[float, float]) -> str:
        low, high = (f"{value:.6g}" for value in sorted(ends))
        last = self._told(max(ends))
        return f"at {last}" if low == high else f"between {low} and {last}"

    @property
    def best(self) -> Bracket:
        """The bracket of the full verdict, or that of equilibrium if there is no other."""
        return self.equilibrium if self.rest is None else self.rest

    @property
    def sensitive_between(self) -> tuple[float, float] | None:
        """Values between which contact stiffness decides whether it stands.

        The first is the last value at which it stands for every tried stiffness. The second is the
        value at which it falls by the verdict and for uniform stiffness. ``None`` if the verdict
        changes at one value.
        """
        if self.robust is None or self.rest is None:
            return None
        low = self.start if self.robust.stands is None else self.robust.stands
        known = (
            self.rest.stands,
            self.rest.falls,
            None if self.uniform is None else self.uniform.falls,
        )
        high = max((v for v in known if v is not None), key=lambda v: abs(v - self.start))
        falling = self.rest.falling
        # at the start, without any forces that balance the loads or without any that press
        at_once = high == self.start and falling is not None and falling.settlement is None
        changes_once = (low, high) == (self.rest.stands, self.rest.falls)
        return None if changes_once or at_once or self.robust.stands == high else (low, high)

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

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences about values at which the answer depends on the joints."""
        told = []
        if self.sensitive_between is not None:
            told.append(
                f"{self._range(self.sensitive_between)} the answer depends on the stiffness "
                "of the joints: there the blocks were followed by finite steps, and the limit is "
                "where they no longer come to rest"
            )
        if self.undecided_between is not None:
            ends = [one.settled for one in self.evaluations if one.value in self.undecided_between]
            because = ""
            if all(one is Outcome.ENDS_DECIDE for one in ends):
                because = ": it depends on which block carries the ends of the joints"
            told.append(f"{self._range(self.undecided_between)} it is undecided{because}")
        return tuple(told)

    def table(self) -> Table:
        """The tried values, in ascending order, with their verdicts."""
        tried = self.evaluations
        columns = {
            "value": [one.value for one in tried],
            "verdict": [one.verdict.value for one in tried],
            "stiffnesses_tried": [one.samples.tried for one in tried],
            "stiffnesses_standing": [one.samples.standing for one in tried],
            "settled": ["" if one.settled is None else one.settled.value for one in tried],
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
            "robust": plain(self.robust),
            "islands": [list(run) for run in self.islands],
            "falling": [] if falling is None else list(falling.falling_names),
            "message": "" if falling is None else falling.message,
            "sensitive": self.is_sensitive,
            "sensitive_between": _listed(self.sensitive_between),
            "undecided_between": _listed(self.undecided_between),
            "remarks": list(self.remarks),
            "stopped": self.stopped,
            "evaluations": [
                {
                    "value": one.value,
                    "verdict": one.verdict.value,
                    "tried": one.samples.tried,
                    "standing": one.samples.standing,
                    "settled": None if one.settled is None else one.settled.value,
                }
                for one in self.evaluations
            ],
            "time_s": dict(self.time_s),
        }


def _listed(pair: tuple[float, float] | None) -> list[float] | None:
    return None if pair is None else list(pair)
