"""Limits as scenes."""

import re

import numpy as np
import pytest

import drystone
from drystone import Assembly, Verdict
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.base.errors import InputError
from drystone.limits import Bracket, Evaluation, Limit, Quantity, limit_thickness, tilt_sweep
from drystone.models import arch, box, tower
from drystone.seismic import local_mechanism
from drystone.view import State, scene_of
from drystone.view.page import panel


@pytest.fixture(scope="module")
def tilt() -> Limit:
    return drystone.limit_tilt(tower(2), "y", friction=0.3)


def test_a_tilt_limit_says_its_number_and_direction_on_both_sides(tilt: Limit) -> None:
    stands, falls = scene_of(tilt).stages
    assert stands.headline.startswith("Stands up to 16.")
    assert stands.headline.endswith(" degrees about y")
    assert falls.headline.startswith(f"{stands.headline}; falls at 16.")
    assert (falls.state == State.FALLING).sum() == 1
    assert falls.motion is not None


def test_the_picture_of_a_tilt_is_tilted_as_the_model_is(tilt: Limit) -> None:
    _, falls = scene_of(tilt).stages
    angle = np.deg2rad(tilt.best.falls)
    # turned counter-clockwise about y, what was up leans towards x
    np.testing.assert_allclose(falls.up, [-np.sin(angle), 0.0, np.cos(angle)], atol=1e-9)
    np.testing.assert_allclose(falls.gravity, -falls.up, atol=1e-12)


def test_a_friction_limit_is_searched_downwards() -> None:
    scene = scene_of(drystone.limit_friction(arch(0.3, 6)))
    assert scene.stages[0].headline.startswith("Stands down to friction 0.")
    assert scene.title.startswith("drystone: stands down to friction 0.")


def test_states_of_different_blocks_are_not_mixed() -> None:
    def build(thickness: float) -> drystone.Assembly:
        return arch(thickness, 9)

    limit = limit_thickness(build, 0.3, 0.02, friction=0.9, parameter="thickness_ratio")
    scene = scene_of(limit)
    stands, falls = scene.stages
    assert stands.headline.startswith("Stands down to thickness ratio 0.")
    assert falls.headline.startswith(f"{stands.headline}; falls at 0.")
    assert stands.headline.split()[-1] != falls.headline.split()[-1]
    own = np.array([name.endswith(" (stands)") for name in scene.assembly.names])
    assert ((stands.state == State.ABSENT) == ~own).all()
    assert ((falls.state == State.ABSENT) == own).all()
    assert stands.normal[: len(limit.best.standing.contacts)].min() > 0.0
    assert not stands.normal[len(limit.best.standing.contacts) :].any()
    np.testing.assert_array_equal(falls.motion[own], 0.0)


def test_what_acts_is_rounded_as_the_headline_is(tilt: Limit) -> None:
    least = drystone.limit_friction(arch(0.3, 11))
    assert least.best.stands == pytest.approx(0.307333, abs=1e-6)
    assert least.title == "Stands down to friction 0.3074"
    low = scene_of(least).stages[0]
    for stage in (scene_of(tilt).stages[0], low):
        told = re.findall(r"\d+\.\d+", stage.headline)[0]
        assert told in " ".join(stage.facts.values()), stage.facts


def test_what_acts_keeps_its_other_numbers_where_the_limit_is_a_short_one() -> None:
    at_limit = drystone.limit_load(tower(2), "block-1:2452.5,0,0", friction=0.5)  # 0.5 g: 4.8
    for stage, told in zip(scene_of(at_limit).stages, ("4.7997", "4.8003"), strict=True):
        assert stage.facts["Load"] == f"gravity + {told} * 2452, 0, 0 N on 'block-1'"


def test_both_sides_of_a_limit_are_in_the_panel(tilt: Limit) -> None:
    text = panel(tilt.chart())
    assert tilt.best.falls not in [one.value for one in tilt.evaluations]
    told = scene_of(tilt).stages[-1].headline.split("; ")[1]
    assert "var(--good)" in text
    assert "var(--bad)" in text
    assert f"{told}</text>" in text  # rounded as in the headline


def test_the_value_at_which_it_falls_is_written_as_it_is_told() -> None:
    low, high = Evaluation(1.88123, Verdict.STABLE), Evaluation(1.93149, Verdict.UNSTABLE)
    bracket = Bracket(low.value, high.value)
    limit = Limit(Quantity("tilt", "deg"), 0.0, 90.0, bracket, evaluations=(low, high))
    drawn = panel(limit.chart())
    assert "falls at 1.932\N{DEGREE SIGN}</text>" in drawn


def test_a_sweep_shows_its_weakest_direction() -> None:
    sweep = tilt_sweep(tower(2), 4, friction=0.3)
    scene = scene_of(sweep)
    assert "the weakest of 4 directions" in scene.stages[0].message
    assert scene.stages[0].headline.endswith(" degrees about y: the weakest of 4 directions")
    assert len(scene.charts) == 2
    assert "towards 0 deg" in panel(sweep.figure())


def test_without_states_there_is_no_picture() -> None:
    empty = Limit(Quantity("tilt", "deg"), 0.0, 90.0, Bracket())
    with pytest.raises(InputError, match="no state is known"):
        scene_of(empty)


def test_a_chart_has_a_key_and_writes_a_marked_value_once() -> None:
    marks = (
        Marks(MarkKind.LINE, np.array([0.0, 0.0149]), np.array([0.1, 0.0]), label="load"),
        Marks(MarkKind.DIAMOND, np.array([0.01]), np.array([0.05]), "bad", "slides"),
    )
    drawn = panel(Chart("Push", marks, "u", "k", ("m", ""), lines=((0.0149, "14.9 mm"),)))
    for text in ("load", "slides", "14.9 mm"):
        assert drawn.count(f">{text}</text>") == 1


def test_a_capacity_without_an_end_draws_no_line_to_it() -> None:
    base, slab = box((1.0, 1.0, 1.0), name="base"), box((0.2, 1.0, 0.02), (0.4, 0.0, 1.0), "slab")
    found = local_mechanism(Assembly((base, slab)).with_fixed([0]), friction=0.6)  # it slides
    assert np.isnan(found.oscillator.displacement)
    assert "nan" not in panel(found.chart())
