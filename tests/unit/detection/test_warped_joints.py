"""Faces that are too warped for one plane touch as fans of triangles."""

import numpy as np
import pytest

from drystone import Assembly, Block, Model, Verdict, check, find_contacts
from drystone.detection.misses import Error

FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def twisted(rise: float, first: int = 0) -> Assembly:
    """Two blocks of 3 x 2 x 1 m with one bed, two of whose corners are higher.

    The loop of the bed of the upper block begins at another corner.
    """
    bed = [[0, 0, 1], [3, 0, 1 + rise], [3, 2, 1], [0, 2, 1 + rise]]
    low = [[x, y, 0] for x, y, _ in bed]
    high = [[x, y, 2] for x, y, _ in bed]
    turned = ((*FACES[0][first:], *FACES[0][:first]), *FACES[1:])
    return Assembly(
        (
            Block(np.array(low + bed, dtype=float), FACES, "lower"),
            Block(np.array(bed + high, dtype=float), turned, "upper"),
        )
    ).with_fixed(["lower"])


@pytest.mark.parametrize("rise", [0.05, 0.1, 0.2, 0.3, 0.5])
def test_a_block_on_a_twisted_bed_stands(rise: float) -> None:
    found = check(twisted(rise))
    assert found.verdict is Verdict.STABLE
    assert found.contacts.area.sum() == pytest.approx(6.0, rel=0.05)


@pytest.mark.parametrize("first", [0, 1, 2, 3])
def test_a_strongly_twisted_bed_is_a_fan_wherever_its_loop_begins(first: int) -> None:
    model = Model.of(twisted(0.3, first))
    assert model.contacts.count == 4
    assert model.report is not None
    assert np.abs(model.report.interfaces.gap).max() < 1e-12
    assert model.report.interfaces.face_a.tolist() == [1] * 4
    assert model.report.interfaces.face_b.tolist() == [0] * 4
    (told,) = model.report.inexact
    assert (told.error, told.off) == (Error.WARP, pytest.approx(0.15))
    assert "a joint 150 mm from plane, taken as a fan of triangles" in model.notes[0]
    assert not model.report.missed
    assert not model.report.isolated


def test_a_slightly_twisted_bed_stays_one_plane() -> None:
    found = find_contacts(twisted(0.2))
    assert found.contacts.count == 1
    assert not found.report.inexact
