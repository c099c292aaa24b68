"""The keywords of long work: the same on all analyses, and no difference with an executor."""

import inspect
import pickle
import re
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import partial
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import design, detection, fall, limits, models, sequence, settlement, stability
from drystone.base.settings import KEYWORDS, Clock
from drystone.base.workers import WorkerPool

NOT_LONG = {"read"}
"""Half a model is of no use: reading has progress only."""


def analyses() -> dict[str, Callable[..., Any]]:
    """The public functions that take any of the keywords."""
    out = {}
    for room in (drystone, design, detection, fall, limits, sequence, settlement, stability):
        for name in room.__all__:
            one = getattr(room, name)
            if inspect.isfunction(one) and set(inspect.signature(one).parameters) & set(KEYWORDS):
                out[name] = one
    return out


def test_every_analysis_takes_all_keywords_in_one_order_with_one_meaning() -> None:
    found = {name: one for name, one in analyses().items() if name not in NOT_LONG}
    assert len(found) >= 30
    for name, one in found.items():
        parameters = inspect.signature(one).parameters
        assert [key for key in parameters if key in KEYWORDS] == list(KEYWORDS), name
        for key in KEYWORDS:
            assert parameters[key].kind is inspect.Parameter.KEYWORD_ONLY, name
            default = parameters[key].default
            assert default is None or (key == "time_limit_s" and default == float("inf")), name
        documented = inspect.getdoc(one) or ""
        for key, words in KEYWORDS.items():
            assert len(re.findall(rf"^{key}$", documented, re.MULTILINE)) == 1, name
            assert words.splitlines()[0] in documented, name
        for section in ("Returns", "Raises", "Examples"):
            if f"\n{section}\n---" in documented:
                assert documented.index("time_limit_s") < documented.index(f"\n{section}\n"), name


@pytest.mark.parametrize("keyword", KEYWORDS)
def test_every_analysis_refuses_a_keyword_of_another_type(keyword: str) -> None:
    for one in analyses().values():
        if keyword in inspect.signature(one).parameters:
            with pytest.raises(drystone.InputError, match=keyword):
                one(**{keyword: "soon"})


WEDGE = models.wedge("b")
SENSITIVE = drystone.Model.of(
    WEDGE, friction=0.84, load=drystone.LoadCase.tilt(WEDGE, (1.0, 0.0, 0.0), 50.0)
)
ARCH = drystone.Model.of(models.arch(0.15, 6), friction=0.7)
FALLS = drystone.Model.of(models.h_model(), friction=0.6)
BOX = models.box
OVER = [BOX((1, 1, 0.2), (at, 0, 1), f"plate{at:g}") for at in (0.7, -0.7)]
TWO = drystone.Model.of(drystone.Assembly((BOX((1, 1, 1), name="base"), *OVER)).with_fixed([0]))
KINK = limits.Imperfections(friction_range=(0.3, 0.7), offset=0.05)


def planned(**how: Any) -> sequence.Plan:
    return sequence.plan(ARCH, options=sequence.PlanOptions(sequence.Rules(hands=1)), **how)


PLAN = planned()

SHARED: dict[str, Callable[..., Any]] = {
    "check": lambda **how: drystone.check(ARCH, options=drystone.CheckOptions.robust(), **how),
    "solve_cra": lambda **how: drystone.solve_cra(SENSITIVE, **how),
    "solve_cra_penalty": lambda **how: drystone.solve_cra_penalty(SENSITIVE, **how),
    "settle": lambda **how: drystone.settle(SENSITIVE, **how),
    "check_many": lambda **how: drystone.check_many([ARCH, FALLS], **how),
    "limit_tilt": lambda **how: limits.limit_tilt(ARCH, "y", **how),
    "tilt_sweep": lambda **how: limits.tilt_sweep(ARCH, 2, **how),
    "imperfections": lambda **how: limits.imperfections(ARCH, KINK, draws=4, **how),
    "diagnose": lambda **how: drystone.diagnose(TWO, **how),
    "find_mends": lambda **how: design.find_mends(
        TWO, options=design.MendOptions(kinds=("prop", "glue")), regions=1, **how
    ),
    "plan": planned,
    "scaffolding": lambda **how: sequence.scaffolding(PLAN, "clamp", **how),
    "handling": lambda **how: sequence.handling(PLAN, **how),
    "take_turns": lambda **how: sequence.take_turns(ARCH, **how),
    "gravity_region": lambda **how: sequence.gravity_region(ARCH, directions=6, **how),
}


def plain(value: Any) -> Any:
    """A value as plain data, without times."""
    if hasattr(value, "to_dict"):
        value = value.to_dict()
    if isinstance(value, dict):
        return {
            key: plain(one) for key, one in value.items() if not re.search("time|_s$|^made$", key)
        }
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    return repr(np.asarray(value).tolist()) if isinstance(value, np.ndarray) else repr(value)


class Counted(ThreadPoolExecutor):
    """An executor that counts the parts that it is given."""

    given = 0

    def submit(self, *arguments: Any, **named: Any) -> Any:
        self.given += 1
        pickle.dumps(arguments)  # so that worker processes could take it
        return super().submit(*arguments, **named)


@pytest.mark.parametrize("name", SHARED)
def test_the_result_is_the_same_with_an_executor(name: str) -> None:
    alone = plain(SHARED[name]())
    with Counted(2) as executor:
        assert plain(SHARED[name](executor=executor)) == alone
        assert executor.given > 1


def test_a_function_that_starts_an_executor_is_called_once_and_its_executor_is_ended() -> None:
    started: list[Executor] = []

    def start() -> Executor:
        started.append(ThreadPoolExecutor(2))
        return started[-1]

    assert drystone.check(ARCH, executor=start).stable
    assert len(started) == 1
    with pytest.raises(RuntimeError):
        started[0].submit(int)


def ended(found: list[int]) -> bool:
    return len(found) >= 3


def test_late_work_ends_and_unused_parts_are_not_asked_for() -> None:
    asked: list[int] = []

    def items() -> Iterator[int]:
        for number in range(1000):
            asked.append(number)
            yield number

    for executor in (None, ThreadPoolExecutor(2)):
        asked.clear()
        found: list[int] = []
        with WorkerPool(executor) as pool:
            for value in pool.answers(abs, items(), partial(ended, found), ahead=2):
                found.append(value)
        assert found == [0, 1, 2]
        assert len(asked) < 10


def test_a_clock_takes_the_time_that_is_left_to_another_process() -> None:
    clock = Clock(50.0, lambda: True)
    there = pickle.loads(pickle.dumps(clock))
    assert 0.0 < there.left_s <= 50.0
    assert not there.late()
    assert clock.late()
    assert pickle.loads(pickle.dumps(clock)).late()
