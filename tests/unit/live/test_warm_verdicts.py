"""The verdict of a load case begins at the rest states of the one before."""

import json
from typing import Any

import numpy as np
import pytest

import drystone
from drystone.limits import Tilt
from drystone.live import calculator
from drystone.live.calculator import DO, Calculator
from drystone.models import arch, box, prism
from drystone.stability import check


class NoJobs:
    """Keeps what is told, and cancels nothing."""

    cancelled = False

    def __init__(self) -> None:
        self.told: list[dict[str, Any]] = []

    def send(self, event: dict[str, Any]) -> None:
        self.told.append(event)


def test_a_verdict_begins_at_the_rest_states_of_the_one_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    began_at: list[bool] = []
    steps: list[int] = []

    def recorded(model: Any, start: Any = None, **how: Any) -> Any:
        began_at.append(start is not None)
        found = check(model, start=start, **how)
        steps.append(found.iterations)
        return found

    monkeypatch.setattr(calculator, "check", recorded)
    model = drystone.Model.of(arch(0.15, 12), friction=0.9)
    jobs = NoJobs()
    one = Calculator(jobs)  # type: ignore[arg-type]
    one.models[1] = model
    common = {"model": 1, "window": "a", "name": "arch", "seconds": 60.0}
    told = {}
    for tilt in (1.0, 1.2, 30.0, 1.2):
        for do in ("quick", "whole"):
            DO[do](one, {**common, "wish": {"tilt": tilt}})
        told[tilt] = jobs.told[-1]["answer"]
    assert began_at[:2] == [True, True]  # the quick answer at first
    assert (told[1.2]["verdict"], told[1.2]["headline"]) == ("stable", "Stands")
    assert told[30.0]["verdict"] == "unstable"
    assert told[30.0]["falling"] == list(
        drystone.check(Tilt(model, np.array((0.0, 1.0, 0.0)))(30.0)).falling_names
    )
    DO["whole"](one, {**common, "window": "b", "wish": {"tilt": 1.2}})
    assert not began_at[-1]  # another window


def test_edges_that_touch_as_well_are_told_with_the_answer() -> None:
    slab = prism([(0, 0), (0.17, 0), (1.17, 1.732), (1.04, 1.807)], (-0.2, 0.2), "slab")
    wall = box((1, 4, 4), (float(slab.bounds[1, 0]), -2, 0), "wall")
    floor, apart = box((20, 8, 1), (-10, -4, -1), "floor"), box((1, 1, 1), (-5, 0, 0), "apart")
    made = drystone.Assembly((floor, wall, apart, slab)).with_fixed([0, 1])
    model = drystone.Model.of(made, friction=0.9)
    jobs = NoJobs()
    one = Calculator(jobs)  # type: ignore[arg-type]
    one.models[1] = model
    for removed in ([], ["apart"]):
        message = {"model": 1, "window": "a", "name": "slab", "seconds": 60.0}
        DO["whole"](one, {**message, "wish": {"removed": removed}})
        assert jobs.told[-1]["answer"]["verdict"] == "stable"
        told = json.loads(jobs.told[-1]["picture"])
        joints = told["contacts"]["a"]["shape"][0]
        assert told["stage"]["normal"]["shape"] == [joints]
        assert joints > model.contacts.count
