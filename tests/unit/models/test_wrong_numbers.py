"""Families of models and shells refuse numbers that they cannot be made of, in one line."""

import inspect
import pickle
import random
from collections.abc import Callable
from contextlib import suppress
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from drystone import InputError, models, shells
from drystone.cli import main

COUNTS = (-3, -1, 0, 1, 2, 2**70, 10**5000, True, np.int64(3), "3", None, 1.5)
NUMBERS = (
    -1.0, 0.0, 5e-324, 1e-12, 0.5, 90.0, 1e30, 1e308, 10**400, float("nan"), float("inf"),
    Decimal("0.5"), Decimal("NaN"), Fraction(1, 2), "1", 1j, np.complex64(2), np.float32(0.5), None,
)  # fmt: skip
LISTS = (
    (), (1, 2), (1, 1, 1), (0, 0, 0), (1, 2, 3, 4), (1e30, 1e-30, 1), [None] * 3, "abc",
    np.ones(3, dtype=complex), np.ones((3, 2)), 5, [float("nan")] * 3,
)  # fmt: skip
FAMILIES: list[Callable[..., Any]] = [
    *(getattr(models, name) for name in models.__all__),
    *(shells.barrel_vault, shells.cross_vault, shells.dome, shells.pavilion_vault),
    *(shells.rectangular_plan, shells.tri_dome, shells.patch_from_grid),
]


def some(annotation: str, rng: random.Random) -> Any:
    """Any value in place of one of an annotation."""
    kind = {"int": COUNTS, "float": NUMBERS}.get(annotation, LISTS)
    return rng.choice(kind)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda one: one.__qualname__)
def test_any_numbers_make_a_family_or_are_refused(family: Callable[..., Any]) -> None:
    rng = random.Random(family.__name__)
    for _ in range(8):
        given = {
            name: some(str(one.annotation), rng)
            for name, one in inspect.signature(family).parameters.items()
            if one.default is one.empty or rng.random() < 0.3
        }
        with suppress(InputError):
            family(**given)


def test_a_family_is_sent_on_by_its_name() -> None:
    assert pickle.loads(pickle.dumps(models.arch)) is models.arch
    assert pickle.loads(pickle.dumps(shells.dome)) is shells.dome
    with pytest.raises(InputError, match=r"no argument 'voussoir'; did you mean voussoirs"):
        models.arch(voussoir=8)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    "words",
    [
        "models arch --set voussoirs=99999999999999999999999",
        "models barrel-vault --set courses=-3",
        "models segmental-bridge --set span=1e300",
        "shell barrel --blocks 99999999999999999999999",
        "limit thickness arch --scan 99999999999999999999999",
    ],
)
def test_a_number_that_is_too_large_is_no_fault(
    words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words.split()) == 2
    assert "fault" not in capsys.readouterr().err
