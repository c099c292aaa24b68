"""Cuts through blocks, and the loop that accepts or changes them."""

import numpy as np
import pytest

from drystone.assembly import Assembly, Block
from drystone.base.errors import InputError
from drystone.design import (
    Cut,
    CutOptions,
    cut_until_free,
    split_block,
    tilted_cuts,
)
from drystone.design.cuts import proposed_cuts
from drystone.detection import find_contacts
from drystone.models import box, prism
from drystone.models.simple import stool

Y = np.array([0.0, 1.0, 0.0])
Z = np.array([0.0, 0.0, 1.0])


def leaning(lean_deg: float = 10.0, width: float = 1.0, height: float = 4.0) -> Block:
    shift = height * np.tan(np.deg2rad(lean_deg))
    return prism([(0, 0), (width, 0), (width + shift, height), (shift, height)], (0, 1), "tower")


def winding() -> Block:
    """One concave block that winds like the snake."""
    z = np.linspace(0.0, 4.0, 13)
    phase = 2.0 * np.pi * z / 4.0
    centre = np.column_stack([0.25 * np.sin(phase), 0.8 + z])
    slope = 2.0 * np.pi * 0.25 / 4.0 * np.cos(phase)
    across = np.column_stack([np.ones(13), -slope]) / np.hypot(1.0, slope)[:, None]
    foot = np.array([[0.5, 0.0], [-0.5, 0.0]])
    left, right = centre - 0.4 * across, centre + 0.4 * across
    return prism(np.concatenate([foot, left, right[::-1]]), (0.0, 0.8), "snake")


@pytest.mark.parametrize(
    "cut",
    [
        Cut((0.0, 0.0, 1.3), Z),
        Cut((0.4, 0.5, 1.3), (0.2, 0.1, 1.0)),
        Cut((0.5, 0.5, 1.3), Z, 20.0, Y),
        Cut((0.5, 0.5, 1.3), Z, -20.0, (1.0, 1.0, 0.0)),
    ],
)
@pytest.mark.parametrize("block", [leaning(), winding(), box((1.0, 1.0, 3.0))])
def test_pieces_are_closed_and_have_the_volume_of_the_whole(block, cut):
    above, below = split_block(block, cut)
    assert len(above) == len(below) == 1
    assert above[0].volume + below[0].volume == pytest.approx(block.volume, rel=1e-9)
    pair = Assembly((below[0], above[0]), np.array([True, False]))
    contacts = find_contacts(pair).contacts
    assert contacts.count == (1 if cut.wedge_deg == 0.0 else 2)


def test_a_groove_seats_what_is_above_and_a_ridge_what_is_below():
    cube = box((1.0, 1.0, 1.0))
    groove, _ = split_block(cube, Cut((0.5, 0.5, 0.5), Z, 30.0, Y))
    ridge, _ = split_block(cube, Cut((0.5, 0.5, 0.5), Z, -30.0, Y))
    lens = 0.5 * 0.5 * np.tan(np.deg2rad(30.0))
    assert groove[0].volume == pytest.approx(0.5 - lens)
    assert ridge[0].volume == pytest.approx(0.5 + lens)


def test_a_cut_through_the_legs_of_a_stool_leaves_four_feet():
    above, below = split_block(stool().blocks[1], Cut((0.0, 0.0, 0.1), Z))
    assert (len(above), len(below)) == (1, 4)


def test_a_cut_may_go_on_from_a_step():
    step = prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], (0.0, 1.0))
    above, below = split_block(step, Cut((0.0, 0.0, 1.0), Z))
    assert [piece.volume for piece in (*above, *below)] == pytest.approx([1.0, 2.0])


def test_a_cut_beside_the_block_or_on_its_end_is_refused():
    cube = box((1.0, 1.0, 1.0))
    with pytest.raises(InputError, match="misses"):
        split_block(cube, Cut((0.0, 0.0, 3.0), Z))
    with pytest.raises(InputError, match="misses"):
        split_block(cube, Cut((0.0, 0.0, 1.0), Z))


def test_a_cut_that_lets_the_tower_slide_is_changed_for_one_that_holds():
    heights = (0.5, 1.5, 2.5, 3.5)
    proposals = [
        tilted_cuts(np.array([0.5 + 0.17 * z, 0.5, z]), Z, Y, (40.0, 20.0, 0.0)) for z in heights
    ]
    found = cut_until_free(leaning(), proposals)
    assert len(found.model) == 5
    slopes = [one.value for one in found.changes]
    assert slopes == pytest.approx([20.0] * 4)  # on 40 degrees it slides
    assert found.plan.counts["free"] == 4
    assert found.model.assembly.volume.sum() == pytest.approx(leaning().volume)


def test_a_snake_is_cut_and_built_from_below():
    places = [tilted_cuts(np.array([0.0, 0.4, z]), Z, Y, (0.0, 10.0)) for z in (1.0, 2.3, 3.6)]
    built = cut_until_free(winding(), places).plan
    assert built.order == ("c01-block", "c02-block", "c03-block")
    assert built.counts["free"] == 3


def test_a_place_without_a_cut_that_works_is_named():
    steep = [tilted_cuts(np.array([0.5, 0.5, 1.0]), Z, Y, (40.0, 50.0))]
    found = cut_until_free(leaning(), steep, options=CutOptions(friction=0.3))
    assert found.plan is None
    assert "cut 0 changed: on none of its cuts the part above stands" in found.log
    with pytest.raises(InputError, match="no place to cut at"):
        cut_until_free(leaning(), [])


def flared() -> Block:
    """Its middle leans out and what is above leans back: together they stand, the middle alone not.

    On the level bed at z = 1, 0 <= x <= 0.5, the centroid of the middle lies at x = 0.66.
    """
    outline = [(0, 0), (0.5, 0), (0.5, 1), (1.7, 2), (-0.2, 3), (-1, 3), (-0.1, 2), (0, 1)]
    return prism(outline, (0.0, 0.5), "flared")


def test_a_block_that_falls_when_it_is_placed_has_the_cut_under_it_changed():
    found = cut_until_free(flared(), options=CutOptions(blocks=3))
    assert found.free
    assert found.plan.counts["free"] == 2
    first, *others, _ = found.log
    assert "cut 0 changed: c01-block is held: without help: c01-block falls" in first
    assert all(one.startswith("cut 0 changed") for one in others)
    assert found.changes[0].value > 1.0
    assert found.changes[1].value == pytest.approx(0.0)
    assert found.model.assembly.volume.sum() == pytest.approx(flared().volume)


def test_a_loop_without_a_cut_that_works_says_so():
    level = [one[:1] for one in proposed_cuts(flared(), 3)]
    found = cut_until_free(flared(), level)
    assert not found.free
    assert found.message == "no proposed cuts make every block free"
    assert cut_until_free(flared(), stop=lambda: True).plan is None


def test_a_leaning_tower_is_cut_and_planned_in_one_call():
    found = cut_until_free(leaning(), options=CutOptions(blocks=5))
    assert found.message == "every block of 5 is free after 0 recuts"
    assert found.plan.order == ("c01-block", "c02-block", "c03-block", "c04-block")


def test_cuts_lie_at_equal_heights_and_turn_about_the_edge_across_the_lean():
    places = proposed_cuts(leaning(), 4)
    assert [one[0].point[2] for one in places] == pytest.approx([1.0, 2.0, 3.0])
    assert all(abs(cut.normal[1]) < 1e-9 for one in places for cut in one)


@pytest.mark.parametrize("bad", [{"blocks": 1}, {"friction": -0.1}, {"most": 0}])
def test_cut_options_out_of_range_are_refused(bad):
    with pytest.raises(InputError):
        CutOptions(**bad)
