"""Drawings that are a little off are answered as their exact ones: the part that is quick."""

import pytest

from benchmarks.perturbed import Case, cases, clearly, drawings
from drystone import Verdict, check

CASES = {case.name: case for case in cases()}


@pytest.mark.parametrize("name", ["table", "tower", "wall", "arch", "stool 0.1"])
def test_what_stands_with_a_margin_stands_where_it_is_drawn_a_little_off(name: str) -> None:
    case: Case = CASES[name]
    assert clearly(case) is Verdict.STABLE
    for kind, assembly in drawings(case, 1, simulate=False):
        assert check(case.model(assembly)).verdict is Verdict.STABLE, kind


@pytest.mark.parametrize("name", ["tower 0.5", "thin arch", "too far over", "table 0.9"])
def test_what_clearly_falls_falls_where_it_is_drawn_a_little_off(name: str) -> None:
    case: Case = CASES[name]
    assert clearly(case) is Verdict.UNSTABLE
    for kind, assembly in drawings(case, 1, simulate=False):
        assert check(case.model(assembly)).verdict is not Verdict.STABLE, kind
