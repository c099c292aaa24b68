"""What the report says, and what it suggests."""

from __future__ import annotations

import json

import numpy as np
import pytest

from drystone import Assembly, Block, find_contacts
from drystone.assembly import replace_block
from drystone.detection import DetectionOptions, Reason
from drystone.geometry.frames import rotation_about
from drystone.io.inspection import missed_layers
from drystone.models import box, concave, random_pack, tower

SLAB = box((4.0, 4.0, 0.5), (-2.0, -2.0, -0.5), "slab")


def above(gap: float) -> Assembly:
    return Assembly((SLAB, box((1.0, 1.0, 1.0), (0.0, 0.0, gap), "cube")))


def test_suggested_gap_joins_what_it_promises() -> None:
    report = find_contacts(above(0.0087)).report
    assert [miss.reason for miss in report.missed] == [Reason.GAP]
    assert report.missed[0].needed == pytest.approx(0.0087)
    assert report.suggestions() == ("raise gap from 0.005 to 0.0088 to join 1 more pair",)
    joined = find_contacts(above(0.0087), options=DetectionOptions(gap=0.0088)).report
    assert joined.pair_count == 1
    assert joined.suggestions() == ()


def test_missed_polygons_lie_between_the_faces() -> None:
    miss = find_contacts(above(0.02)).report.missed[0]
    np.testing.assert_allclose(miss.polygon[:, 2], 0.01, atol=1e-12)
    assert miss.area == pytest.approx(1.0)
    assert not miss.joined


def test_faces_that_touch_already_are_not_missed() -> None:
    assert find_contacts(random_pack(60, seed=2)).report.missed == ()
    assert find_contacts(tower(4)).report.missed == ()


def test_far_block_is_isolated_and_said_to_be_far() -> None:
    report = find_contacts(above(0.5)).report
    assert report.isolated == (0, 1)
    assert "nothing is near slab, cube" in report.suggestions()[0]


def test_repairs_are_passed_on() -> None:
    cube = box((1.0, 1.0, 1.0))
    turned = Block(cube.vertices, tuple(face[::-1] for face in cube.faces), "inside-out")
    report = find_contacts(Assembly((SLAB, turned))).report
    assert report.repairs == ((1, "all faces pointed inwards, and are turned"),)
    assert any("pointed inwards" in line for line in report.summary())


def test_summary_of_many_faults_stays_short() -> None:
    cubes = [
        Block(c.vertices, tuple(face[::-1] for face in c.faces), f"cube-{i}")
        for i, c in enumerate(box((1.0, 1.0, 1.0), (3.0 * i, 0.0, 0.0)) for i in range(30))
    ]
    lines = find_contacts(Assembly(tuple(cubes))).report.summary()
    assert len(lines) < 15
    assert any("'cube-2' and 27 more: all faces" in line for line in lines)


def test_block_that_is_there_twice_is_named() -> None:
    cube = box((1.0, 1.0, 1.0))
    report = find_contacts(Assembly((SLAB, cube, cube.renamed("again")))).report
    (overlap,) = report.overlaps
    assert (overlap.block_a, overlap.block_b, overlap.share) == (1, 2, pytest.approx(1.0))


def test_report_is_json_and_complete() -> None:
    report = find_contacts(
        Assembly((*above(0.0087).blocks, box((1, 1, 1), (-2, 0, -0.1), "deep")))
    ).report
    data = json.loads(json.dumps(report.to_dict()))
    assert data["isolated"] == ["slab", "cube", "deep"]
    assert data["missed"][0]["blocks"] == ["slab", "cube"]
    assert data["missed"][0]["reason"] == "too far apart"
    (overlap,) = data["overlaps"]
    assert overlap["blocks"] == ["slab", "deep"]
    assert overlap["depth"] == pytest.approx(0.1)
    assert data["options"]["gap"] == 0.005
    whole = json.loads(json.dumps(find_contacts(concave()).report.to_dict()))
    assert len(whole["interfaces"]) == 7
    assert {entry["kind"] for entry in whole["interfaces"]} == {"area"}


def test_summary_counts_interfaces_and_pairs() -> None:
    assert find_contacts(concave()).report.summary()[0] == "7 interfaces in 1 pair"
    assert find_contacts(tower(2)).report.summary()[0] == "1 interface in 1 pair"


def on_edge(lift: float) -> Assembly:
    """A unit cube on an edge above a slab."""
    cube = box((1.0, 1.0, 1.0), (-0.5, -0.5, -0.5)).transformed(
        rotation_about([1.0, 0.0, 0.0], 45.0), (0.0, 0.0, np.sqrt(0.5) + lift)
    )
    return Assembly((SLAB, replace_block(cube, name="cube")))


def test_edge_that_nearly_touches_is_told_with_its_distance() -> None:
    report = find_contacts(on_edge(0.008)).report
    (miss,) = report.missed
    assert (miss.reason, miss.gap) == (Reason.GAP, pytest.approx(0.008))
    assert sorted(miss.polygon[:, 2].round(6).tolist()) == [0.0, 0.0, 0.008, 0.008]
    assert any("too far apart: slab-cube (8 mm)" in line for line in report.summary())
    assert report.suggestions() == ("raise gap from 0.005 to 0.0081 to join 1 more pair",)
    joined = find_contacts(on_edge(0.008), options=DetectionOptions(gap=0.0081)).report
    assert joined.pair_count == 1
    assert joined.missed == ()


def test_corner_that_nearly_touches_is_told_and_drawn() -> None:
    turn = rotation_about([1.0, -1.0, 0.0], np.rad2deg(np.arctan(np.sqrt(2.0))))
    cube = replace_block(box((1.0, 1.0, 1.0), (-0.5, -0.5, -0.5)).transformed(turn), name="cube")
    model = Assembly((SLAB, cube.transformed(translation=(0.0, 0.0, 0.01 - cube.bounds[0, 2]))))
    found = find_contacts(model)
    (miss,) = found.report.missed
    assert miss.polygon.shape == (2, 3)
    assert json.loads(json.dumps(found.report.to_dict()))["missed"][0]["faces"][1] is None
    assert [layer.key for layer in missed_layers(found.report)] == ["missed-points"]


def test_blocks_near_each_other_with_parallel_edges_are_not_called_far() -> None:
    one = box((1.0, 1.0, 1.0), name="one")
    other = box((1.0, 1.0, 1.0), (1.01, 0.0, 1.01), "other")
    report = find_contacts(Assembly((one, other))).report
    assert report.undirected == ((0, 1),)
    assert not any("nothing is near" in text for text in report.suggestions())


def test_first_step_is_suggested_as_well_as_the_last() -> None:
    cubes = [
        box((1.0, 1.0, 1.0), (1.1 * i - 2.0, 0.0, gap), f"cube-{i}")
        for i, gap in enumerate((0.0085, 0.037))
    ]
    assert find_contacts(Assembly((SLAB, *cubes))).report.suggestions() == (
        "raise gap from 0.005 to 0.0086 to join 1 more pair, or to 0.038 to join 2 more pairs",
    )


def test_one_block_twice_is_to_be_removed_or_moved() -> None:
    twin = replace_block(SLAB, name="twin")
    assert find_contacts(Assembly((SLAB, twin))).report.suggestions() == (
        "1 pair of blocks overlaps: move them apart in the model, or remove what is there twice",
    )


def test_overlap_that_a_larger_angle_joins_is_not_to_be_moved_apart() -> None:
    cube = box((1.0, 1.0, 1.0), (-0.5, -0.5, 0.0), "cube")
    tilted = replace_block(cube.transformed(rotation_about([1.0, 0.0, 0.0], 4.0)), name="cube")
    model = Assembly((SLAB, tilted))
    options = DetectionOptions(edges="never")
    report = find_contacts(model, options=options).report
    assert report.overlaps != ()
    (text,) = report.suggestions()
    assert text.startswith("raise angle from 2 to 4")


def test_one_isolated_block_touches_nothing() -> None:
    cubes = (box((1.0, 1.0, 1.0), name="on"), box((1.0, 1.0, 1.0), (9.0, 0.0, 9.0), "off"))
    assert (
        "1 block touches nothing: off" in find_contacts(Assembly((SLAB, *cubes))).report.summary()
    )


def test_tilted_block_above_another_is_told_the_gap_that_joins_it() -> None:
    cube = box((1.0, 1.0, 1.0), (-0.5, -0.5, 0.0)).transformed(rotation_about([1.0, 0.0, 0.0], 8.0))
    lifted = cube.transformed(translation=(0.0, 0.0, 0.02 - cube.bounds[0, 2]))
    model = Assembly((SLAB, replace_block(lifted, name="cube")))
    report = find_contacts(model).report
    (text,) = report.suggestions()
    assert text == "raise gap from 0.005 to 0.021 to join 1 more pair"
    assert find_contacts(model, options=DetectionOptions(gap=0.021)).report.pair_count == 1


def test_single_block_is_not_asked_for_company() -> None:
    assert find_contacts(Assembly((SLAB,))).report.suggestions() == ()
