"""What a limit says of itself: in words, tables and pictures."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from drystone.answer import Answer, Question, Role, Scene, SceneStage, Sentence
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.answer.scene import side_by_side
from drystone.base.display import digits_apart, named, rounded_down, rounded_up
from drystone.base.errors import InputError
from drystone.base.table import Table
from drystone.checks import crushed_most, crushing_share
from drystone.limits.limit_types import Bracket, Evaluation, LimitValues, plain
from drystone.model import Model
from drystone.results import Result, Sensitivity, Verdict
from drystone.results.stage import first_motion_words
from drystone.settlement import Outcome

_LISTED = 12
"""Blocks that give way which are named."""
_KINDS = {
    "equilibrium": "equilibrium",
    "rest": "check",
    "uniform": "uniform stiffness",
    "robust": "every stiffness tried",
}

AT_LEAST = " at least, where the search ends"
"""Follows the last value of a search at which it stands."""

_DECIDES = {
    Outcome.ENDS_DECIDE: "which block carries the ends of the joints (--ends)",
    Outcome.SHEAR_DECIDES: "the shear stiffness of the joints",
}
_LOOKS = {Verdict.STABLE: (MarkKind.DISC, "good"), Verdict.UNSTABLE: (MarkKind.CROSS, "bad")}
"""Of a value that was tried, by its verdict."""


@dataclass(frozen=True, eq=False)
class Limit(LimitValues, Answer):
    """A limit of equilibrium and of rest.

    Attributes
    ----------
    quantity
        What was varied.
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
        asked for.
    islands
        Ranges beyond the first fall in which it stands again, as far as they were tried.
    evaluations
        Tried values, in ascending order.
    time_s
    stopped
        Why the search stopped before the brackets had the required width; else empty.
    options
    """

    def _summary(self) -> str:
        stands, falls = self._told(self.best.stands), self._told(self.best.falls)
        early = f", stopped: {self.stopped}" if self.stopped else ""
        return f"{self.quantity.name}, stands at {stands}, falls at {falls}{early}"

    def _told(self, value: float | None) -> str:
        unit = f" {self.quantity.unit}" if self.quantity.unit else ""
        told = "" if value is None else f"{self._rounded(value, 6, self.best):.6g}{unit}"
        return told or "none that was tried"

    def _range(self, ends: tuple[float, float]) -> str:
        low, high = (f"{value:.6g}" for value in sorted(ends))
        last = self._told(max(ends))
        return f"at {last}" if low == high else f"between {low} and {last}"

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences about values at which the answer depends on the joints."""
        told = self._stiffness_decides()
        if between := self._between_sides():
            told.append(between)
        elif self.undecided_between is not None:
            told.append(f"{self._range(self.undecided_between)} it is undecided{self._because()}")
        return tuple(told)

    def _between_sides(self) -> str:
        """Why what lies between both sides of equilibrium is undecided, if that is the limit."""
        known, low, high = self.equilibrium, self.best.stands, self.best.falls
        if (
            known is None
            or low is None
            or high is None
            or (known.stands, known.falls) != (low, high)
        ):
            return ""
        sides = f"between {self._short(low)} and {self._short(high)}"
        return f"{sides} it is undecided: {known.undecided}" if known.undecided else ""

    def _because(self) -> str:
        """What the undecided values depend on, where that is known of all."""
        low, high = sorted(self.undecided_between or (0.0, 0.0))
        unsure = [one for one in self.evaluations if one.verdict is Verdict.UNDECIDED]
        ends = {one.settled for one in unsure if low <= one.value <= high}
        said = " or ".join(words for outcome, words in _DECIDES.items() if outcome in ends)
        return f": it depends on {said}" if ends <= _DECIDES.keys() else ""

    def _stiffness_decides(self) -> list[str]:
        """Where stiffness or pressure within joints decides, or which joint needs its corners."""
        if self.sensitive_between is not None:
            between = f"{self._range(self.sensitive_between)} the answer depends on the"
            falling = None if self.robust is None else self.robust.falling
            if falling is not None and falling.sensitive_to == (Sensitivity.PRESSURE,):
                return [f"{between} pressure within joints: it stands on their corners only"]
            every = (one for one in (self.uniform, self.rest, self.robust) if one is not None)
            safe = min(every, key=lambda one: self._from_start(one.stands))
            use = "" if safe.stands is None else self._short(safe.stands, safe)
            return [
                f"{between} stiffness of the joints: there the blocks were followed by finite "
                f"steps, and the limit is where they no longer come to rest"
                f"{use and '; for design use '}{use}"
            ]
        standing = None if self.robust is not None else self.best.standing
        if standing is None or not standing.corners_needed:
            return []
        more = "--robust asks up to where it stands without"
        return [f"at the limit {standing.corners_needed}; {more}"]

    @property
    def states(self) -> list[tuple[Result, float, bool]]:
        """The known states on either side: result, value, and whether it falls.

        Where the verdict at the start is undecided, that state alone.
        """
        best = self.best
        if self._open and best.falling is not None:
            return [(best.falling, self.start, False)]
        sides = ((best.standing, best.stands, False), (best.falling, best.falls, True))
        return [(s, v, falls) for s, v, falls in sides if s is not None and v is not None]

    @property
    def model(self) -> Model:
        """The model at the limit.

        Raises
        ------
        InputError
            No state is known on either side.
        """
        if not self.states:
            raise InputError("there is no picture: no state is known on either side of the limit")
        return self.states[-1][0].model

    @cached_property
    def asked(self) -> Question:
        """What was asked, without what the limit varies."""
        if not self.states:
            return Question.of_nothing(self.options, self.when)
        asked = super().asked.without(*self.quantity.replaces)
        return replace(asked, load=self.quantity.load or asked.load)

    @property
    def _open(self) -> bool:
        """Whether the verdict at the start is undecided."""
        return self.best.falling is not None and self.best.falls is None

    @property
    def _known(self) -> bool:
        """Whether any value was tried."""
        return bool(self.evaluations) or self.best.falls is not None

    @property
    def title(self) -> str:
        """Up to which value it stands; where values beyond are undecided, from which it falls."""
        stands, start, falls = self.best.stands, self._quantity(self.start), self.best.falls
        if stands is not None:
            least = AT_LEAST if self.capped else ""
            least = " at least" if self.stopped and falls is None else least
            least = ", the least above 0 that was tried" if falls == self.end == 0.0 else least
            if self.undecided_between is not None:
                fall = "" if falls is None else f", falls from {self._short(falls)}"
                least += f"{fall}; {'between them' if fall else 'beyond'} undecided"
            return f"{self._head} {self._quantity(stands)}{least}"
        if self._open:
            return f"Not decided at {start}"
        if self.best.falls == self.start:
            rough = "friction" in self.quantity.replaces
            more = "more was not tried: --friction, in Python upper, starts higher"
            remedy = more if rough else "change the model to stand there"
            return f"Falls at {start}, where the search starts: {remedy}"
        tried = f"Stands at no {self.quantity.words} that was tried"
        return tried if self._known else "No verdict is known yet"

    @property
    def _below_given(self) -> bool:
        """Whether a load, that is no unit, is not carried as it was given."""
        falls, varied = self.best.falls, self.quantity
        if falls is None or varied.name != "load factor" or varied.unit:
            return False
        return varied.acting + falls <= 1.0

    @property
    def _role(self) -> Role:
        """Of the title: good is a load that is carried as it was given."""
        if self.best.stands is None:
            return Role.BAD if self._known else Role.UNSURE
        return Role.UNSURE if self._below_given else Role.GOOD

    @property
    def code(self) -> int:
        """0 where a limit is found, whatever it is."""
        return int(self.best.stands is None)

    def sentences(self) -> Sequence[Sentence]:
        """Up to which value it stands, what gives way beyond, and where the joints decide."""
        falling = self.best.falling
        if self._open and falling is not None:
            return [Sentence(f"{self.title}: {falling.message}", Role.UNSURE)]
        said = [Sentence(self.title, self._role)]
        if self.quantity.inverse and self.best.stands:
            inverse = rounded_down(1.0 / self.best.stands)
            said.append(Sentence(f"{self.quantity.inverse}: {inverse:g}"))
        if self.quantity.remark:
            said.append(Sentence(self.quantity.remark, Role.REMARK))
        said += [Sentence(f"joints decide: {one}", Role.REMARK) for one in self.remarks]
        for low, high in self.islands:
            ends = Bracket(max(low, high, key=lambda one: abs(one - self.start)))
            again = f"it stands again from {self._short(low, ends)} to {self._short(high, ends)}"
            said.append(Sentence(again, Role.REMARK))
        if falling is not None and falling.falling:
            names = named(falling.falling_names, _LISTED)
            every = len(falling.falling) == (~falling.assembly.fixed).sum() > 1
            said.append(Sentence(f"gives way: {'all free blocks' if every else names}"))
            moves = first_motion_words(falling)
            said += [Sentence(f"first motion: {moves}")] if moves else []
            said.append(Sentence(falling.message))
        if falling is not None and falling.mechanism is not None:
            share = crushing_share(falling.model, falling.mechanism)
            at = crushed_most(falling.model, falling.mechanism)
            if at is not None:
                what = "yielding" if falling.contacts.ties[at] else "crushing"
                head = f"{what} governs: it" if share > 0.5 else what
                rest = "of the work that resists this motion, lifted weights the rest"
                said.append(Sentence(f"{head} takes {100.0 * share:.3g} % {rest}"))
        sides = [one for one in (self.best.stands, self.best.falls) if one is not None]
        between = f"; {self._range((sides[0], sides[1]))} it is open" if sides[1:] else ""
        said += self._unfinished(between)
        searched = f"searched from {self.start:.6g} to {self._told(self.end)}"
        if self.capped:
            searched += f"; {'--upper' if self.quantity.replaces else '--to'} goes on"
        return [*said, Sentence(searched)]

    def tables(self) -> Sequence[Table]:
        """The limit by each definition; those that agree share a row."""
        found = self._definitions()
        columns = {
            "definition": list(found),
            "stands_at": [self._cell(one.stands, one) for one in found.values()],
            "gives_way_at": [self._cell(one.falls, one) for one in found.values()],
        }
        unit = self.quantity.unit
        units = {"stands_at": unit, "gives_way_at": unit} if unit else {}
        return [Table("limit", columns, units)]

    def numbers(self) -> Mapping[str, Any]:
        """Both sides of the limit by each definition, and the values that were tried."""
        falling, stands = self.best.falling, self.best.stands
        inverse = self.quantity.inverse.replace(" ", "_")
        return {
            "parameter": self.quantity.name,
            "unit": self.quantity.unit,
            "range": [self.start, self.end],
            "stands": stands,
            "falls": self.best.falls,
            **{key: plain(getattr(self, key)) for key in _KINDS},
            "islands": self.islands,
            "falling": () if falling is None else falling.falling_names,
            "message": "" if falling is None else falling.message,
            "sensitive": self.is_sensitive,
            "sensitive_between": self.sensitive_between,
            "undecided_between": self.undecided_between,
            "remarks": self.remarks,
            **({inverse: 1.0 / stands} if inverse and stands else {}),
            "evaluations": list(self.table()),
        }

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
        unit = self.quantity.unit
        return Table(self.quantity.name, columns, {"value": unit} if unit else {})

    def layers(self) -> Scene:
        """The last state that stands beside the first one that falls.

        If their blocks differ (a limit of thickness), the blocks of the other state are absent.
        """
        model, states = self.model, self.states
        assembly, contacts = model.assembly, model.contacts
        stages = tuple(self._stage(*one) for one in states)
        if not all(_same_shape(state, states[-1][0]) for state, _, _ in states):
            names = [" (falls)" if falls else " (stands)" for _, _, falls in states]
            models = [state.model for state, _, _ in states]
            assembly, contacts, stages = side_by_side(models, stages, names)
        title = f"drystone: {self.title[0].lower()}{self.title[1:]}"
        charts = (self.chart(),) if self.evaluations else ()
        facts = self.asked.facts()
        return Scene(assembly, contacts, stages, title, facts, charts=charts, still=-1)

    def chart(self) -> Chart:
        """The values that were tried: how many contact stiffnesses stand at each."""
        best, tried = self.best, self.evaluations
        looks = [_LOOKS.get(one.verdict, (MarkKind.RING, "good")) for one in tried]
        marks = []
        told: dict[float, float] = {}  # as its words round it
        if best.falls is not None:
            told = {best.falls: float(self._digits(best.falls))}
        falls = "".join(f"falls at {self._short(one)}" for one in told)
        for kind, ink in dict.fromkeys(looks):
            mine = [one for one, look in zip(tried, looks, strict=True) if look == (kind, ink)]
            x, y = np.array([(told.get(one.value, one.value), _share(one)) for one in mine]).T
            marks.append(Marks(kind, x, y, ink, {MarkKind.CROSS: falls}.get(kind, "")))
        for value in told.keys() - {one.value for one in tried}:
            marks.append(Marks(MarkKind.CROSS, np.array([told[value]]), np.zeros(1), "bad", falls))
        line = () if best.stands is None else ((best.stands, self._short(best.stands)),)
        return Chart(
            "Values that were tried", tuple(marks), self.quantity.words,
            "share of stiffnesses that stand", (self.quantity.unit, ""),
            "Discs stand, crosses fall; the height is the share of the contact stiffnesses tried "
            "that stand.", line, top=1.0,
        )  # fmt: skip

    def _stage(self, state: Result, value: float, falls: bool) -> SceneStage:
        """One side of the limit."""
        headline = self.title  # that of the answer, whichever of its sides is shown
        if falls and self.best.stands is not None and self.undecided_between is None:
            headline += f"; falls at {self._short(value)}"
        names = {re.escape(f"{value:{form}}") for form in ("g", ".4g")}
        whole = rf"(?<![\d.])(?:{'|'.join(names)})(?!\.?\d)"  # no part of another number
        told, asked = self._digits(value), state.asked.facts()  # rounded as in the headline
        keys = sorted({"Friction", "Load"} & asked.keys())
        facts = {one: re.sub(whole, told, asked[one]) for one in keys}
        label = f"{'falls' if falls else 'not decided' if self._open else 'stands'} at "
        label += self._short(value)
        means = "; ".join(one for one in (state.message, *self._means()) if one)
        stage = replace(state.stage(label), headline=headline, message=means, facts=facts)
        return replace(stage, role=self._role) if self._below_given else stage

    def _definitions(self) -> dict[str, Bracket]:
        """The bracket by each definition; one of those that agree, that of the check if it can."""
        known = {key: getattr(self, key) for key in _KINDS}
        if not self.is_sensitive:
            known["robust"] = None
        rows: list[list[str]] = []
        for key in [key for key, one in known.items() if one is not None]:
            alike = [row for row in rows if known[row[0]].agrees(known[key])]
            if alike:
                alike[0].append(key)
            else:
                rows.append([key])
        return {
            ", ".join(_KINDS[key] for key in row): known["rest" if "rest" in row else row[0]]
            for row in rows
        }

    def _means(self) -> list[str]:
        """How the limit was found."""
        told = [
            f"{words} to {self._short(bracket.stands, bracket)}"
            for words, bracket in self._definitions().items()
            if bracket.stands is not None
        ]
        return [*told, *(one.text for one in self.sentences() if one.role is Role.REMARK)]

    @property
    def _head(self) -> str:
        """Up to which value, or down to which, it stands; or forces could balance only."""
        stands = any((self.rest, self.uniform, self.robust))
        if self._below_given:
            less = "Does not stand under" if stands else "No forces balance"
            return f"{less} the load as given, only up to"
        stood = "Stands" if stands else "Forces balance"
        return f"{stood} {'up' if self.end >= self.start else 'down'} to"

    def _quantity(self, value: float) -> str:
        """A value in words."""
        return self.quantity.told(self._digits(value))

    def _cell(self, value: float | None, bracket: Bracket) -> str:
        return "-" if value is None else self._digits(value, bracket)

    def _digits(self, value: float, bracket: Bracket | None = None) -> str:
        """A value with the digits of a bound, or with as many more as tell both sides apart.

        It is rounded away from the limit: what is told to stand stands, what falls falls.
        """
        sides = bracket or self.best
        both = [one for one in (sides.stands, sides.falls) if one is not None]
        digits = digits_apart(*both)
        return f"{self._rounded(value, digits, sides):.{digits}g}"

    def _rounded(self, value: float, digits: int, sides: Bracket) -> float:
        """A value towards the start if it is what stands, else towards the end."""
        up = (self.end >= self.start) != (value == sides.stands)
        return (rounded_up if up else rounded_down)(value, digits)

    def _short(self, value: float, bracket: Bracket | None = None) -> str:
        unit = self.quantity.unit
        mark = "\N{DEGREE SIGN}" if unit == "deg" else f" {unit}" if unit else ""
        return f"{self._digits(value, bracket)}{mark}"


def _same_shape(first: Result, second: Result) -> bool:
    """Whether two results are of blocks in the same places, with as many corners."""
    same = np.array_equal(first.assembly.bounds, second.assembly.bounds)
    return same and first.contacts.corner_count == second.contacts.corner_count


def _share(one: Evaluation) -> float:
    if one.samples.tried:
        return one.samples.standing / one.samples.tried
    return 1.0 if one.verdict in (Verdict.STABLE, Verdict.EQUILIBRIUM_EXISTS) else 0.0
