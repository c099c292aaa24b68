"""How much volume polyhedra share and how deep they are in each other, concave ones too."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Assembly, Block
from drystone.geometry.frames import rotation_about
from drystone.geometry.selfcontact import convex_bodies
from drystone.geometry.shared_volume import shared_volumes
from drystone.models import box, prism

ELL = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]


def shared(*blocks: Block) -> tuple[list[float], list[float]]:
    """Depth and volume of all pairs, zero for those that are apart."""
    a, b = np.triu_indices(len(blocks), 1)
    convex = convex_bodies([one.vertices for one in blocks], [one.faces for one in blocks])
    found = shared_volumes(Assembly(blocks).faces, a, b, np.full(len(a), 1e-6), convex)
    depth, volume = np.zeros(len(a)), np.zeros(len(a))
    depth[found.row], volume[found.row] = found.depth, found.volume
    return depth.tolist(), volume.tolist()


def depth(*blocks: Block) -> list[float]:
    return shared(*blocks)[0]


def ells(seed: int, count: int) -> list[Block]:
    random = np.random.default_rng(seed)
    return [
        prism(ELL, (0.0, 1.0), f"ell {k}").transformed(
            rotation_about(random.normal(size=3), random.uniform(0.0, 360.0)),
            random.uniform(0.0, 1.5, 3),
        )
        for k in range(count)
    ]


def test_blocks_that_fill_the_notch_of_another_touch_it_only() -> None:
    ell = prism(ELL, (0.0, 1.0), "ell")
    assert depth(ell, box((1.0, 1.0, 1.0), (1.0, 0.0, 1.0), "fits")) == [0.0]
    deeper = box((1.0, 1.0, 1.0), (0.9, 0.0, 0.9), "deeper")
    assert depth(ell, deeper) == pytest.approx([np.hypot(0.1, 0.1)])


def test_a_block_wholly_inside_is_found() -> None:
    inner = box((0.2, 0.2, 0.2), (0.4, 0.4, 0.4), "inner")
    found = shared(box((1.0, 1.0, 1.0), name="outer"), inner)
    assert found == (pytest.approx([0.6]), pytest.approx([0.008]))


@pytest.mark.parametrize(
    ("size", "corner", "deep", "volume"),
    [
        ((1.0, 1.0, 1.0), (0.0, 0.0, 0.0), 1.0, 1.0),
        ((1.0, 1.0, 1.0), (0.6, 0.0, 0.0), 0.4, 0.4),
        ((1.0, 1.0, 2.0), (0.0, 0.0, 0.5), 0.5, 0.5),
    ],
)
def test_boxes_whose_edges_lie_on_each_other_can_share_a_space(
    size: tuple[float, float, float],
    corner: tuple[float, float, float],
    deep: float,
    volume: float,
) -> None:
    found = shared(box((1.0, 1.0, 1.0), name="one"), box(size, corner, "other"))
    assert found == (pytest.approx([deep]), pytest.approx([volume]))


def test_two_ells_that_share_a_cube_in_the_grid() -> None:
    """No edge of the one passes through the other, and all corners of the cube are on both."""
    ell = prism(ELL, (0.0, 1.0), "ell")
    other = ell.transformed(np.diag([-1.0, 1.0, -1.0]), (1.0, 0.0, 1.0)).renamed("other")
    deep, volume = shared(ell, other)
    assert volume == pytest.approx([1.0])
    assert deep == pytest.approx([0.5])


def test_a_concave_block_and_its_copy() -> None:
    ell = prism(ELL, (0.0, 1.0), "ell")
    deep, volume = shared(ell, ell.renamed("copy"))
    assert volume == pytest.approx([3.0])
    assert deep == pytest.approx([6.0 * 3.0 / 14.0])


def test_a_tongue_that_fills_a_groove_shares_no_space() -> None:
    """The mean of the corners that touch is inside the tongue, not inside the groove."""
    groove = [
        (0.0, 0.0),
        (3.0, 0.0),
        (3.0, 2.0),
        (2.0, 2.0),
        (2.0, 1.0),
        (1.0, 1.0),
        (1.0, 2.0),
        (0.0, 2.0),
    ]
    tongue = [(1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0)]
    assert depth(prism(groove, (0.0, 1.0), "groove"), prism(tongue, (0.0, 1.0), "tongue")) == [0.0]


def test_pairs_measured_together_are_as_deep_as_alone() -> None:
    blocks = ells(1, 5)
    together = depth(*blocks)
    a, b = np.triu_indices(len(blocks), 1)
    alone = [depth(blocks[i], blocks[j])[0] for i, j in zip(a, b, strict=True)]
    assert together == pytest.approx(alone)


def within(points: np.ndarray) -> np.ndarray:
    """Points in an L of two bars, in its own coordinates."""
    inside = ((points > 0.0) & (points < [2.0, 1.0, 2.0])).all(axis=1)
    return inside & ~((points[:, 0] > 1.0) & (points[:, 2] > 1.0))


def test_blocks_have_a_depth_when_points_lie_in_both() -> None:
    """Decided by points sampled in the two, without any surface."""
    random = np.random.default_rng(2)
    ell = prism(ELL, (0.0, 1.0), "ell")
    seen = []
    for _ in range(24):
        rotation = rotation_about(random.normal(size=3), random.uniform(0.0, 360.0))
        shift = random.uniform(-1.5, 2.5, 3)
        points = random.uniform(0.0, 2.0, (4000, 3))
        points = points[within(points)]
        both = within((points - shift) @ rotation)
        deep = depth(ell, ell.transformed(rotation, shift).renamed("other"))[0]
        assert deep > 0.0 or not both.any()
        assert both.any() or deep < 0.2
        seen.append(deep > 0.0)
    assert 5 < sum(seen) < 20
