"""Searches for a change of verdict, on a family whose answers are known."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import pytest

from drystone import LoadCase, Result, Verdict
from drystone.limits.limit_search import VerdictSearch, Width
from drystone.limits.limit_types import Bracket
from drystone.model import Model
from drystone.models import tower
from tests.oracle import touching_faces

TOWER = tower(2)
CONTACTS = touching_faces(TOWER, 0.6)
W = Width
S, U, D = Verdict.STABLE, Verdict.UNSTABLE, Verdict.UNDECIDED


@dataclass(frozen=True)
class Given:
    """The parameter travels in the load."""

    parameter: str = "given"
    unit: str = ""

    def __call__(self, value: float) -> Model:
        load = LoadCase.point_load(TOWER, 1, (value, 0.0, 0.0))
        return Model(TOWER, CONTACTS, load)


@dataclass(frozen=True)
class Steps:
    """Verdicts between successive limits."""

    limits: tuple[float, ...]
    verdicts: tuple[Verdict, ...]

    def __call__(self, model: Model) -> Result:
        value = float(model.load.wrench[1, 0])
        verdict = self.verdicts[sum(value > limit for limit in self.limits)]
        return Result("given", verdict, model)


def test_a_single_change_is_bracketed_to_the_width() -> None:
    found = VerdictSearch(Given(), Steps((0.37,), (S, U))).run(0.0, 1.0, width=W(1e-3), scan=4)
    bracket = found.bracket
    assert bracket.stands is not None
    assert bracket.falls is not None
    assert bracket.stands <= 0.37 < bracket.falls
    assert bracket.falls - bracket.stands <= 1e-3
    assert bracket.standing is not None
    assert bracket.standing.verdict is S
    assert bracket.falling is not None
    assert bracket.falling.verdict is U
    assert found.islands == ()


def test_a_search_can_go_downwards() -> None:
    bracket = (
        VerdictSearch(Given(), Steps((0.37,), (U, S))).run(1.0, 0.0, width=W(1e-3), scan=4).bracket
    )
    assert bracket.stands is not None
    assert bracket.falls is not None
    assert bracket.falls <= 0.37 < bracket.stands
    assert bracket.value == pytest.approx(0.37, abs=1e-3)


def test_islands_beyond_the_first_fall_are_reported() -> None:
    steps = Steps((0.2, 0.45, 0.8), (S, U, S, U))
    found = VerdictSearch(Given(), steps).run(0.0, 1.0, width=W(1e-2), scan=10)
    assert found.bracket.value == pytest.approx(0.2, abs=1e-2)
    assert found.islands == ((pytest.approx(0.5), pytest.approx(0.8)),)


def test_an_undecided_zone_is_closed_in_from_both_sides() -> None:
    found = VerdictSearch(Given(), Steps((0.3, 0.6), (S, D, U))).run(
        0.0, 1.0, width=W(1e-2), scan=2
    )
    assert found.bracket.stands == pytest.approx(0.3, abs=1e-2)
    assert found.bracket.falls == pytest.approx(0.6, abs=1e-2)
    assert D in {one.verdict for one in found.evaluations}


def test_an_undecided_zone_of_many_blocks_is_closed_in_from_where_it_stands_only() -> None:
    """Each value in it takes as long as following them does."""
    search = VerdictSearch(Given(), Steps((0.3, 0.6), (S, D, U)))
    found = search.around(0.2, 0.35, (0.0, 1.0), width=W(1e-2), closing=2.0)
    assert found.bracket.stands == pytest.approx(0.3, abs=1e-2)
    assert found.bracket.falls == 1.0


def test_standing_beyond_an_undecided_value_counts() -> None:
    steps = Steps((0.49, 0.51, 0.7), (S, D, S, U))
    found = VerdictSearch(Given(), steps).run(0.0, 1.0, width=W(1e-2), scan=2)
    assert found.bracket.value == pytest.approx(0.7, abs=1e-2)


def test_a_proof_beyond_the_end_closes_the_bracket() -> None:
    proof = Bracket(stands=1.0, falls=1.01)
    bracket = (
        VerdictSearch(Given(), Steps((), (S,)))
        .run(0.0, 1.0, width=W(0.1), scan=2, beyond=proof)
        .bracket
    )
    assert (bracket.stands, bracket.falls) == (1.0, 1.01)
    undecided = Steps((0.5,), (S, D))
    found = (
        VerdictSearch(Given(), undecided).run(0.0, 1.0, width=W(0.01), scan=2, beyond=proof).bracket
    )
    assert found.stands == pytest.approx(0.5, abs=0.01)
    assert found.falls == 1.01


def test_what_never_falls_or_never_stands_has_one_side_only() -> None:
    always = VerdictSearch(Given(), Steps((), (S,))).run(0.0, 1.0, width=W(0.1), scan=3).bracket
    assert (always.stands, always.falls, always.value) == (1.0, None, None)
    never = VerdictSearch(Given(), Steps((0.8,), (U, S))).run(0.0, 1.0, width=W(0.1), scan=2)
    assert (never.bracket.stands, never.bracket.falls) == (None, 0.0)
    assert [one.value for one in never.evaluations] == [0.0]
    unknown = VerdictSearch(Given(), Steps((), (D,))).run(0.0, 1.0, width=W(0.1), scan=2).bracket
    assert (unknown.stands, unknown.falls) == (None, None)


def test_a_width_below_rounding_ends() -> None:
    bracket = (
        VerdictSearch(Given(), Steps((0.37,), (S, U))).run(0.0, 1.0, width=W(0.0), scan=1).bracket
    )
    assert bracket.value == pytest.approx(0.37, abs=1e-15)


def test_every_value_is_tried_once_and_listed_in_order() -> None:
    tried: list[float] = []
    steps = Steps((0.37,), (S, U))

    def counted(model: Model) -> Result:
        tried.append(float(model.load.wrench[1, 0]))
        return steps(model)

    found = VerdictSearch(Given(), counted).run(0.0, 1.0, width=W(1e-2), scan=4)
    assert len(tried) == len(set(tried))
    assert [one.value for one in found.evaluations] == sorted(tried)


def test_a_scan_begins_each_value_in_line_with_the_two_before_it() -> None:
    begun: dict[float, float | None] = {}

    def straight(model: Model, start: np.ndarray | None = None) -> Result:
        value = float(model.load.wrench[1, 0])
        begun[value] = None if start is None else float(start[1, 0])
        return Result("given", S, model, displacement=np.full((2, 6), 1.0 - 3.0 * value))

    VerdictSearch(Given(), straight, starts={}).run(0.0, 1.0, width=W(0.1), scan=4)
    assert begun == pytest.approx({0.0: None, 0.25: 1.0, 0.5: -0.5, 0.75: -1.25, 1.0: -2.0})


def test_next_to_a_proof_of_falling_nothing_is_tried_after_an_undecided_value() -> None:
    search = VerdictSearch(Given(), Steps((0.3,), (S, D)))
    proof = Bracket(falls=1.005)
    found = search.around(0.3, 0.31, (0.0, 1.0), width=W(0.01), beyond=proof, closing=2.0)
    assert (found.bracket.stands, found.bracket.falls) == (0.3, 1.005)
    assert max(search.results) < 0.6


def test_a_stopped_search_tells_what_was_tried_by_then() -> None:
    proof = Bracket(falls=1.01)
    widths = []
    for count in (0, 4, 6, 8, 12, 20):
        calls = iter(range(count + 1))  # once before the first value, and after each
        search = VerdictSearch(
            Given(),
            Steps((0.37,), (S, U)),
            stop=lambda calls=calls: next(calls, None) is None,
        )
        found = search.run(0.0, 1.0, width=W(1e-4), scan=4, beyond=proof)
        bracket = found.bracket
        assert len(found.evaluations) <= count + 1
        if count == 0:
            assert (bracket.stands, bracket.falls) == (0.0, 1.01)
            continue
        assert bracket.stands is not None
        assert bracket.falls is not None
        assert bracket.stands <= 0.37 < bracket.falls
        assert bracket.standing is search.results[bracket.stands]
        widths.append(bracket.falls - bracket.stands)
    assert widths == sorted(widths, reverse=True)
    assert widths[-1] < 0.01


def test_an_undecided_answer_that_may_have_been_broken_off_is_not_kept() -> None:
    calls = iter([False, False])
    search = VerdictSearch(Given(), Steps((0.1,), (S, D)), stop=lambda: next(calls, True))
    found = search.run(0.0, 1.0, width=W(1e-4), scan=4)
    assert [one.value for one in found.evaluations] == [0.0]


def test_an_executor_changes_nothing() -> None:
    steps = Steps((0.37, 0.5, 0.9), (S, D, U, S))
    alone = VerdictSearch(Given(), steps).run(0.0, 1.0, width=W(1e-3), scan=8)
    with ThreadPoolExecutor(2) as executor:
        together = VerdictSearch(Given(), steps, executor).run(0.0, 1.0, width=W(1e-3), scan=8)
    assert alone.evaluations == together.evaluations
    assert alone.islands == together.islands
    assert (alone.bracket.stands, alone.bracket.falls) == (
        together.bracket.stands,
        together.bracket.falls,
    )
