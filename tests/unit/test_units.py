"""Numbers with units, as people type and read them."""

import math

import pytest

from drystone import InputError
from drystone.base import units
from drystone.base.table import Table


def test_friction_is_a_coefficient_or_an_angle() -> None:
    assert units.coefficient("0.6") == 0.6
    for text in ("40deg", "40 deg", "40°"):
        assert units.coefficient(text) == pytest.approx(math.tan(math.radians(40.0)))
    for text in ("-1", "90deg", "-5deg", "inf", "nan", "steep", "40rad", ""):
        with pytest.raises(InputError):
            units.coefficient(text)


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (0.0, "0 N"), (-0.0, "0 N"), (-2.6e-13, "0 N"), (0.5, "500 mN"), (-12.345, "-12.3 N"),
        (999.6, "1 kN"), (1000.0, "1 kN"), (23544.0, "23.5 kN"), (1.234e6, "1.23 MN"),
        (6.07e-7, "607 nN"),
    ],
)  # fmt: skip
def test_forces_are_told_by_their_size(value: float, told: str) -> None:
    assert units.quantity(value, "N", 1e-9) == told


def test_components_share_a_prefix_and_rounding_is_zero() -> None:
    assert units.components([-1e-9, 0.0, 23544.0], "N") == "0, 0, 23.5 kN"
    assert units.components([0.0, 0.0, 0.0], "N") == "0, 0, 0 N"
    assert units.components([0.0, -1.17e-7, 0.0], "N m", 1e-5) == "0, 0, 0 N m"
    assert units.components([-4.0, 700.0, -999.9], "N") == "-0.004, 0.7, -1 kN"
    assert units.components([-0.4, 700.0, -999.9], "N") == "0, 0.7, -1 kN"
    assert units.components([-40.0, 700.0, 150.0], "N") == "-40, 700, 150 N"


def test_masses_are_told_in_kilograms_and_tonnes() -> None:
    told = [units.mass(value) for value in (0.25, 80.0, 999.0, 1000.0, 4800.0, 8.31e9)]
    assert told == ["0.25 kg", "80 kg", "999 kg", "1 t", "4.8 t", "8,310,000 t"]


def test_a_number_has_one_of_its_units() -> None:
    assert units.measured("-1.5kN", units.FORCES) == -1500.0
    assert units.measured("2 t", units.MASSES) == 2000.0
    assert units.measured("3", units.FORCES, 1.0) == 3.0
    for text in ("3", "kN", "1e999N", "nanN", "1 stone", "1kN2", ""):
        with pytest.raises(InputError):
            units.measured(text, units.FORCES)


def test_a_number_of_thousands_of_digits_is_no_example_of_what_to_write() -> None:
    for text, example in (("9" * 5000 + "mm", "1e.15mm"), ("0." + "3" * 5000, "0.333333333333N")):
        with pytest.raises(InputError, match=f" {example}") as caught:
            units.measured(text, units.FORCES if "." in text else units.UNITS)
        assert len(str(caught.value)) < 600


def test_a_column_of_forces_has_no_smaller_unit_than_its_largest_value() -> None:
    told = Table("props", {"force": [275.0, 0.0305, 0.0, 12300.0]}, {"force": "N"}).cells()[1]
    assert [row[0] for row in told] == ["275 N", "0.0305 N", "0 N", "12.3 kN"]
