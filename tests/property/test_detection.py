"""Contacts do not depend on units, place, rotation or numbering."""

from __future__ import annotations

from functools import cache

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from drystone import Assembly, find_contacts
from drystone.detection import Detection, DetectionOptions
from drystone.geometry.frames import rotation_about
from drystone.models import (
    barrel_vault,
    box,
    concave,
    cube_curve,
    curve_three_blocks,
    dome,
    random_pack,
    shelf,
    wall,
)

SLAB = box((4.0, 4.0, 0.5), (-2.0, -2.0, -0.5), "slab")
ON_EDGE = box((1.0, 1.0, 1.0), name="cube").transformed(rotation_about([1.0, 0.0, 0.0], 33.0))
MODELS = {
    "wall": lambda: wall(3, 3),
    "dome": dome,
    "vault": barrel_vault,
    "concave": concave,
    "rim": lambda: cube_curve(strips=8),
    "curve": lambda: Assembly(
        tuple(curve_three_blocks(s).blocks[i] for i, s in enumerate((6, 9, 7))),
        np.array([True, False, False]),
    ),
    "pack": lambda: random_pack(25, seed=4),
    "shelf": shelf,
    "edge": lambda: Assembly((SLAB, ON_EDGE)),
}


@cache
def found_in(name: str) -> tuple[Assembly, Detection]:
    """A model, and what is found where nothing is changed."""
    model = MODELS[name]()
    return model, find_contacts(model)


def table(detection: Detection, order: np.ndarray, scale: float) -> np.ndarray:
    """Per interface its blocks as first numbered, corners, area and gap; sorted."""
    contacts, report = detection.contacts, detection.report
    blocks = np.sort(np.stack([order[contacts.block_a], order[contacts.block_b]], axis=1), axis=1)
    rows = np.column_stack(
        [
            blocks,
            np.diff(contacts.start),
            np.round(contacts.area / scale**2, 6),
            np.round(report.interfaces.gap / scale, 6) + 0.0,
        ]
    )
    return rows[np.lexsort(rows.T[::-1])]


@settings(max_examples=6, derandomize=True, deadline=None)
@given(
    axis=st.tuples(*3 * [st.floats(-1.0, 1.0)]).filter(lambda a: np.linalg.norm(a) > 0.1),
    turn=st.floats(0.0, 360.0),
    scale=st.sampled_from([1e-3, 0.1, 1.0, 1e3]),
    move=st.sampled_from([0.0, 1.0, 1e4]),
    seed=st.integers(0, 1_000),
)
@pytest.mark.parametrize("name", MODELS)
def test_contacts_are_those_of_the_model(
    name: str, axis: tuple[float, float, float], turn: float, scale: float, move: float, seed: int
) -> None:
    model, expected = found_in(name)
    order = np.random.default_rng(seed).permutation(len(model))
    place = move * scale * np.array([1.0, -0.7, 0.4])
    changed = model.subset(order).transformed(scale * rotation_about(np.array(axis), turn), place)
    found = find_contacts(changed)
    np.testing.assert_allclose(
        table(found, order, scale),
        table(expected, np.arange(len(model)), 1.0),
        atol=3e-6 if move < 1e3 else 1e-5,
    )
    assert found.report.isolated == ()
    assert found.report.overlaps == ()


@settings(max_examples=8, derandomize=True, deadline=None)
@given(count=st.integers(2, 40), seed=st.integers(0, 10_000), gap=st.floats(2e-3, 0.05))
def test_narrow_gaps_cost_no_contact(count: int, seed: int, gap: float) -> None:
    pack = random_pack(count, seed=seed)
    shrunk = tuple(
        block.transformed(0.9999 * np.eye(3), 0.0001 * block.bounds.mean(axis=0))
        for block in pack.blocks
    )
    found = find_contacts(Assembly(shrunk), options=DetectionOptions(gap=gap)).contacts
    whole = find_contacts(pack).contacts
    assert found.area.sum() == pytest.approx(whole.area.sum(), rel=2e-3)
