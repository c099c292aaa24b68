"""BLAS has one thread while an analysis runs, and as many as before afterwards."""

from collections.abc import Callable, Iterator

import pytest
from threadpoolctl import ThreadpoolController

import drystone
from drystone import models
from drystone.base.errors import InputError
from drystone.model import Model
from drystone.stability import try_rest

MODEL = Model.of(models.arch(0.15), friction=0.9)
POOLS = ThreadpoolController().select(user_api="blas")


def threads() -> list[int]:
    return [pool.num_threads for pool in POOLS.lib_controllers]


@pytest.fixture(autouse=True)
def two_threads() -> Iterator[None]:
    with POOLS.limit(limits=2, user_api="blas"):
        yield


@pytest.mark.parametrize(
    "analysis",
    [
        drystone.check,
        drystone.settle,
        drystone.solve_rbe,
        drystone.solve_cra,
        drystone.solve_cra_penalty,
        try_rest,
    ],
)
def test_blas_has_one_thread_inside_an_analysis_and_two_again_afterwards(
    analysis: Callable[..., object],
) -> None:
    seen: list[int] = []

    def look() -> bool:
        seen.extend(threads())
        return False

    before = threads()
    analysis(MODEL, stop=look)
    assert set(seen) == {1}
    assert threads() == before


def test_threads_are_set_back_after_an_error() -> None:
    before = threads()

    def fail() -> bool:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        drystone.check(MODEL, stop=fail)
    assert threads() == before
    with pytest.raises(InputError):
        drystone.check(models.arch(0.15), friction=-1.0)
    assert threads() == before
