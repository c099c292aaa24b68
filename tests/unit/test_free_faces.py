"""Parts of faces that no joint covers."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Assembly, Model
from drystone.free_faces import free_parts
from drystone.models import box
from drystone.shells import shell_by_name


def test_a_face_that_a_joint_divides_has_two_free_parts_that_keep_away_from_it() -> None:
    fin = box((0.4, 1.0, 2.0), (0.0, 0.0, 0.0), "fin")
    slab = box((3.4, 1.0, 0.2), (-2.0, 0.0, 2.0), "slab")  # free for 2 m on one side, 1 m here
    model = Model.of(Assembly((fin, slab)).with_fixed([0]), friction=0.6)
    below = [part for part in free_parts(model, 1, away=0.0) if part.normal[2] < -0.9]
    assert [part.area for part in below] == pytest.approx([2.0, 1.0])
    assert all(part.covered for part in below)
    np.testing.assert_allclose(below[1].middle, [0.9, 0.5, 2.0])
    near = [part for part in free_parts(model, 1, away=0.1) if part.normal[2] < -0.9]
    gap = 0.1 * model.assembly.size[1]
    assert near[1].outline[:, 0].min() == pytest.approx(0.4 + gap)


def test_the_middle_of_a_bent_part_lies_on_it() -> None:
    post = box((0.8, 0.8, 1.0), (0.0, 0.0, 0.0), "post")
    slab = box((1.0, 1.0, 0.2), (0.0, 0.0, 1.0), "slab")
    model = Model.of(Assembly((post, slab)).with_fixed([0]), friction=0.6)
    (bent,) = [part for part in free_parts(model, 1, away=0.0) if part.normal[2] < -0.9]
    assert bent.middle[:2].max() > 0.8
    area = 0.5 * np.cross(bent.outline, np.roll(bent.outline, -1, axis=0)).sum(axis=0)
    np.testing.assert_allclose(area[2], -bent.area)  # counter-clockwise from outside


@pytest.mark.parametrize(
    ("surface", "blocks", "joggle"), [("cross", None, 0.0), ("barrel", 3, 10.0)]
)
def test_joints_whose_edges_nearly_coincide_with_those_of_a_face_leave_parts_that_are_regions(
    surface: str, blocks: int | None, joggle: float
) -> None:
    shell = shell_by_name(surface, courses=6, blocks=blocks, joggle=joggle)
    model = Model.of(shell.assembly, friction=0.6)
    parts = [p for block in model.assembly.free for p in free_parts(model, int(block), away=0.0)]
    assert all(part.shape.is_valid and part.shape.geom_type == "Polygon" for part in parts)
    assert all(part.share < 1.0 + 1e-6 for part in parts)
