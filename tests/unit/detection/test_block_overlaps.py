"""Blocks that stand in each other."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Assembly, find_contacts
from drystone.detection import find_overlaps
from drystone.geometry.frames import rotation_about
from drystone.models import arch, box, concave, cube_curve, dome, prism, random_pack, wall

CUBE = box((1.0, 1.0, 1.0), name="a")


def depths(*blocks: object) -> list[float]:
    assembly = Assembly(blocks)  # type: ignore[arg-type]
    turned = assembly.transformed(rotation_about([1.0, 2.0, 3.0], 40.0), (100.0, 0.0, 0.0))
    found = [[p.depth for p in find_contacts(each).report.overlaps] for each in (assembly, turned)]
    assert found[0] == pytest.approx(found[1])
    return found[0]


@pytest.mark.parametrize("depth", [0.02, 0.3])
def test_depth_of_boxes_is_the_shortest_way_out(depth: float) -> None:
    assert depths(CUBE, box((1.0, 1.0, 1.0), (0.4, 0.3, 1.0 - depth), "b")) == pytest.approx(
        [depth]
    )


def test_depth_of_crossing_edges_is_along_their_cross_product() -> None:
    ridge = box((4.0, 1.0, 1.0), (-2.0, -0.5, -0.5), "a").transformed(
        rotation_about([1.0, 0.0, 0.0], 45.0)
    )
    over = ridge.transformed(
        rotation_about([0.0, 0.0, 1.0], 90.0), (0.0, 0.0, np.sqrt(2.0) - 0.1)
    ).renamed("b")
    assert depths(ridge, over) == pytest.approx([0.1])


def test_block_inside_another_is_found() -> None:
    assert depths(CUBE, box((0.2, 0.2, 0.2), (0.1, 0.4, 0.4), "b")) == pytest.approx([0.3])


def test_concave_blocks_are_measured_too() -> None:
    corner = prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], (0.0, 1.0), "corner")
    deep = box((1.0, 1.0, 1.0), (0.9, 0.0, 1.0), "deep")
    assert depths(corner, deep) == pytest.approx([0.1])
    beside = box((1.0, 1.0, 1.0), (1.0, 0.0, 1.0), "beside")
    assert depths(corner, beside) == []


def test_bar_through_a_concave_block_is_found() -> None:
    corner = prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], (0.0, 1.0), "corner")
    bar = box((0.2, 3.0, 0.2), (0.4, -1.0, 0.4), "bar")
    assert len(depths(corner, bar)) == 1


@pytest.mark.parametrize(
    "model",
    [wall(4, 4), dome(), arch(), concave(), cube_curve(), random_pack(60)],
    ids=["wall", "dome", "arch", "concave", "cube-curve", "pack"],
)
def test_blocks_that_touch_do_not_penetrate(model: Assembly) -> None:
    for each in (model, model.transformed(rotation_about([3.0, 1.0, 2.0], 71.0), (1e4, 0.0, 0.0))):
        assert find_contacts(each).report.overlaps == ()


def test_supports_may_overlap() -> None:
    one, two = box((1.0, 1.0, 1.0), name="one"), box((1.0, 1.0, 1.0), (0.5, 0.0, 0.0), "two")
    assert find_overlaps(Assembly((one, two))) != ()
    assert find_overlaps(Assembly((one, two), np.array([True, False]))) != ()
    assert find_overlaps(Assembly((one, two), np.array([True, True]))) == ()
