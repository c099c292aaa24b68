"""Jams, wedges, piles, counterweights and hinges: the rows of ``closed-forms.csv``."""

from __future__ import annotations

import pytest

from benchmarks.closed_forms import (
    LEANS,
    TABLE,
    Row,
    diamond,
    expected_thrust,
    rows,
    thrust_of_cards,
    with_a_spine,
)
from benchmarks.tables import read_table
from drystone import check

ROWS = rows()


def test_every_closed_form_has_its_row() -> None:
    told = read_table(TABLE)
    assert [row["structure"] for row in told[: len(ROWS)]] == [row.structure for row in ROWS]
    expected = [*(row.expected for row in ROWS), *map(expected_thrust, LEANS)]
    assert [float(row["expected"]) for row in told] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.structure)
def test_it_stands_on_one_side_of_its_closed_form_and_falls_on_the_other(row: Row) -> None:
    below, above = (check(row.build(share * row.expected)) for share in (0.999, 1.001))
    assert below.falls is above.stable is row.stands_above
    assert below.stable is above.falls is not row.stands_above


@pytest.mark.parametrize("degrees", LEANS)
def test_the_thrust_of_three_hinges_is_half_the_weight_times_the_cotangent(degrees: float) -> None:
    assert thrust_of_cards(degrees) == pytest.approx(expected_thrust(degrees), rel=1e-3)


@pytest.mark.parametrize(("shift", "stands"), [(-0.002, True), (0.002, False)])
@pytest.mark.parametrize("edge", ["table", "spine"])
def test_bricks_with_a_spine_turn_about_either_edge(edge: str, shift: float, stands: bool) -> None:
    of_table, of_spine = (shift, -0.001) if edge == "table" else (-0.05, shift)
    assert check(with_a_spine(of_table, of_spine)).stable is stands


@pytest.mark.parametrize(
    ("out", "back", "table", "stands"),
    [
        (-0.003, -0.003, -0.003, True),
        (0.003, 0.0, -0.003, False),
        (-0.003, 0.003, -0.003, False),
        (-0.003, -0.003, 0.006, False),
    ],
)
def test_a_diamond_of_bricks_turns_about_each_of_three_edges(
    out: float, back: float, table: float, stands: bool
) -> None:
    assert check(diamond(out, back, table)).stable is stands
