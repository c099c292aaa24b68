"""A thickness that nearly all blocks are apart is taken for mortar."""

import pytest

from drystone import Assembly, Model, Verdict, check, find_contacts
from drystone.detection import DetectionOptions
from drystone.detection.misses import Error
from drystone.models import box

LENGTH, WIDTH, HEIGHT = 0.215, 0.1025, 0.065


def brick_wall(mortar: float, courses: int = 4, bricks: int = 4, heads: bool = True) -> Assembly:
    """Bricks in running bond on a floor, without half bricks at the ends."""
    pitch = LENGTH + (mortar if heads else 0.0)
    blocks = [box((3.0, 0.3, 0.1), (-1.0, -0.15, -0.1), name="floor")]
    for i in range(courses):
        for k in range(bricks):
            at = (
                k * pitch + (0.4 * pitch if i % 2 else 0.0),
                -0.05,
                mortar + i * (HEIGHT + mortar),
            )
            blocks.append(box((LENGTH, WIDTH, HEIGHT), at, name=f"brick {i} {k}"))
    return Assembly(tuple(blocks)).with_fixed(["floor"])


@pytest.mark.parametrize("thick", [0.001, 0.003, 0.005, 0.01, 0.015])
def test_a_wall_that_is_drawn_with_its_mortar_joints_stands_as_without(thick: float) -> None:
    model, exact = Model.of(brick_wall(thick)), Model.of(brick_wall(0.0))
    assert check(model).verdict is Verdict.STABLE
    assert model.contacts.block_a.tolist() == exact.contacts.block_a.tolist()
    assert model.contacts.block_b.tolist() == exact.contacts.block_b.tolist()


def test_the_thickness_is_told() -> None:
    model = Model.of(brick_wall(0.01))
    assert model.report is not None
    assert {pair.error for pair in model.report.inexact} == {Error.MORTAR}
    assert [pair.off for pair in model.report.inexact] == pytest.approx([0.01] * 37)
    assert "37 pairs of blocks are up to 10 mm apart, all alike: taken for mortar" in model.notes[0]
    assert not model.unjoined


def test_mortar_beds_with_dry_heads_are_found() -> None:
    assert check(brick_wall(0.01, heads=False)).verdict is Verdict.STABLE


def test_a_joint_is_as_wide_as_without_mortar() -> None:
    found = find_contacts(brick_wall(0.01, courses=2, bricks=2)).contacts
    beds = {
        (int(a), int(b)): float(area)
        for a, b, area in zip(found.block_a, found.block_b, found.area, strict=True)
    }
    assert beds[1, 3] == pytest.approx(0.6 * (LENGTH + 0.01) * WIDTH)


def test_blocks_that_are_apart_by_different_distances_are_not_joined() -> None:
    gaps = (0.11, 0.05, 0.17, 0.08, 0.14)
    z, blocks = 1.0, [box((1.0, 1.0, 1.0), name="base")]
    for gap in gaps:
        blocks.append(box((1.0, 1.0, 1.0), (0.0, 0.0, z + gap), name=f"block {z}"))
        z += 1.0 + gap
    found = find_contacts(Assembly(tuple(blocks)))
    assert found.contacts.count == 0
    assert check(Assembly(tuple(blocks)).with_fixed(["base"])).verdict is Verdict.UNDECIDED


def test_two_blocks_apart_show_no_mortar() -> None:
    blocks = (box((1.0, 1.0, 1.0)), box((1.0, 1.0, 1.0), (0.0, 0.0, 1.1), name="top"))
    assert find_contacts(Assembly(blocks)).contacts.count == 0


def test_mortar_is_left_out_of_a_search_by_the_tolerances_alone() -> None:
    options = DetectionOptions(inexact=False)
    assert find_contacts(brick_wall(0.01), options=options).contacts.count == 0
