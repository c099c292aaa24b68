"""Stages where contact stiffness decides: the plan follows the verdict of check."""

import numpy as np

from drystone import CheckOptions, LoadCase, Model, Verdict, check, plan
from drystone.models import tower, wedge
from drystone.sequence import check_both, check_once

X = (1.0, 0.0, 0.0)


def tilted(degrees: float) -> Model:
    assembly = wedge("c", longer=0.2)
    load = LoadCase.tilt(assembly, X, degrees)
    return Model.of(assembly, friction=0.84, load=load)


def test_a_structure_that_stands_after_settling_is_planned_and_told() -> None:
    model = tilted(40.0)
    assert check_once(model).falls
    found = plan(model)
    assert found.verdict is Verdict.STABLE
    assert found.order == ("wedge",)
    assert "it comes to rest after settling by" in found.complete.settled
    assert found.message == "every stage stands; 1 of 1 after settling: there the joints decide"
    assert found.to_dict()["steps"][0]["settled"] == found.complete.settled


def test_a_structure_that_settles_into_a_fall_is_refused() -> None:
    """Two forces that balance, far below and above, turn it on once it has turned."""
    model, load = tilted(40.0), LoadCase.point_load
    for force, z in ((4e4, -1e3), (-4e4, 1e3)):
        place = model.assembly.centroid[2] + [0.0, 0.0, z]
        model = model.with_load(model.load + load(model.assembly, "wedge", (0, 0, force), place))
    for falls in (model, tilted(46.0)):
        found = plan(falls)
        assert found.verdict is Verdict.UNSTABLE
        assert not found.steps
        assert "does not stand" in found.message


def test_a_stage_that_stands_for_one_stiffness_only_gets_the_verdict_of_check() -> None:
    # uniform stiffness holds it, others do not
    model = tilted(36.0)
    once, both = check_once(model), check_both(model)
    whole = check(model, options=CheckOptions.robust())
    assert once.stable
    assert whole.samples.standing < whole.samples.tried
    assert both.verdict is whole.verdict


def test_robust_stages_are_not_followed() -> None:
    found = plan(Model.of(tower(3)))
    assert found.message == "every stage stands"
    assert all(step.answer.settled == "" for step in found.steps)
    assert np.allclose([step.answer.used for step in found.steps], 0.0, atol=1e-6)
