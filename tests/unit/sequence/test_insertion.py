"""Directions in which a block can be taken out, and blocks that cannot."""

import numpy as np
import pytest

from drystone.answer import State
from drystone.assembly import Assembly
from drystone.model import Model
from drystone.models import box, prism
from drystone.sequence import PlanOptions, Rules, freedom, handling, plan

UP = np.array([0.0, 0.0, 1.0])
X, Y, Z = np.eye(3)


def rays(normals: list[np.ndarray]) -> set[tuple[float, ...]]:
    return {tuple(ray) for ray in freedom(np.array(normals), UP).generators.round(6) + 0.0}


def test_a_block_in_a_corner_leaves_along_three_edges():
    assert rays([X, Y, Z]) == {(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)}


def test_a_block_in_a_slot_slides_along_it_or_out():
    assert rays([X, -X, Z]) == {(0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)}


def test_a_block_in_a_shaft_with_a_floor_leaves_upwards_only():
    assert rays([X, -X, Y, -Y, Z]) == {(0.0, 0.0, 1.0)}


def test_a_block_in_a_closed_box_is_blocked():
    found = freedom(np.array([X, -X, Y, -Y, Z, -Z]), UP)
    assert found.blocked
    assert found.preferred is None


def test_a_dovetail_slides_along_its_groove_only():
    slope = np.array([np.sqrt(0.5), 0.0, -np.sqrt(0.5)])
    mirrored = slope * [-1.0, 1.0, 1.0]
    assert rays([slope, mirrored, Z]) == {(0.0, 1.0, 0.0), (0.0, -1.0, 0.0)}


def test_the_preferred_way_is_the_one_nearest_to_up():
    roof = np.array([np.sqrt(0.5), 0.0, -np.sqrt(0.5)])
    np.testing.assert_allclose(
        freedom(np.array([roof]), UP).preferred, [np.sqrt(0.5), 0.0, np.sqrt(0.5)], atol=1e-9
    )
    np.testing.assert_allclose(freedom(np.array([-Z, X]), UP).preferred @ UP, 0.0, atol=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_generators_are_free_and_blocked_cones_have_no_free_direction(seed):
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(rng.integers(1, 7), 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found = freedom(normals, UP)
    assert (found.generators @ normals.T >= -1e-3).all()
    trials = rng.normal(size=(4000, 3))
    free = (trials @ normals.T > 0.02).all(axis=1)
    assert not (found.blocked and free.any())


def tray() -> Assembly:
    """A dovetailed key in a groove that is closed at both ends."""
    low, high = 0.3, 0.5
    groove = [
        (-1.0, -0.2), (1.0, -0.2), (1.0, 0.4), (low, 0.4), (high, 0.0), (-high, 0.0), (-low, 0.4),
        (-1.0, 0.4),
    ]  # fmt: skip
    key = [(-high, 0.0), (high, 0.0), (low, 0.4), (-low, 0.4)]
    return Assembly(
        (
            prism(groove, (0.0, 1.0), "groove"),
            box((2.0, 0.2, 0.6), (-1.0, -0.2, -0.2), "end-0"),
            box((2.0, 0.2, 0.6), (-1.0, 1.0, -0.2), "end-1"),
            prism(key, (0.0, 1.0), "key"),
            box((0.2, 0.2, 0.2), (-0.1, 0.4, 0.4), "knob"),
        ),
        np.array([True, True, True, False, False]),
    )


def test_a_locked_key_is_impossible_and_what_lies_on_it_waits():
    assembly = tray()
    found = plan(Model.of(assembly))
    assert found.counts["impossible"] == 2
    assert "block every motion" in found.impossible[3]
    assert found.impossible[4].startswith("waiting for them")  # without the key nothing carries it
    assert found.order == ()
    assert found.title == "2 blocks cannot be placed: 1 without a way in, 1 waiting for them"
    states = [stage.state[3] for stage in found.layers().stages]
    assert set(states) == {State.ABSENT}
    assert handling(found).placements == ()


def test_a_groove_that_is_open_lets_the_key_slide_in():
    assembly = tray().without(["end-1"])
    found = plan(Model.of(assembly), options=PlanOptions(rules=Rules()))
    assert found.counts["impossible"] == 0
    np.testing.assert_allclose(found.steps[0].motion, [[0.0, -1.0, 0.0]], atol=1e-9)


def test_a_block_between_faces_that_pair_off_on_all_sides_is_impossible():
    places = np.concatenate([np.eye(3), -np.eye(3)])
    blocks = tuple(box((1.0, 1.0, 1.0), tuple(at), f"side-{i}") for i, at in enumerate(places))
    closed = Assembly((*blocks, box((1.0, 1.0, 1.0), name="core")), np.arange(7) < 6)
    found = plan(Model.of(closed))
    assert "block every motion" in found.impossible[6]
    assert found.counts["free"] == 0


def test_a_plan_lists_the_directions_in_which_each_block_can_be_put_in():
    blocks = (
        box((3.0, 1.0, 1.0), (0.0, 0.0, -1.0), "floor"),
        box((1.0, 1.0, 1.0), (0.0, 0.0, 0.0), "left"),
        box((1.0, 1.0, 1.0), (2.0, 0.0, 0.0), "right"),
        box((1.0, 1.0, 1.0), (1.0, 0.0, 0.0), "last"),
    )
    shaft = Assembly(blocks, np.array([True, True, True, False]))
    found = plan(Model.of(shaft))
    (ways,) = found.directions(0)
    down_or_along = {(0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)}
    assert {tuple(way) for way in ways.round(6) + 0.0} == down_or_along
    assert found.to_dict()["steps"][0]["directions"] == [ways.tolist()]
