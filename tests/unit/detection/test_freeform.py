"""Curved joints: meshed differently on both sides, resampled, given by the user."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from benchmarks.curved import curved_vault
from drystone import (
    Assembly,
    Contacts,
    LoadCase,
    Model,
    Verdict,
    check,
    find_contacts,
    limit_tilt,
    read,
    write,
)
from drystone.detection import Detection, DetectionOptions
from drystone.models import concave, cube_curve, curve_three_blocks, tower

AREA = 2.460
VAULT = curved_vault(9, 3, wave=0.08)
ALL = DetectionOptions(curve=0.0)


@cache
def pieces_of_vault() -> Detection:
    """The joints of a vault of small facets as plane pieces."""
    return find_contacts(VAULT)


@cache
def facets_of_vault() -> Contacts:
    """All facets of its joints."""
    return find_contacts(VAULT, options=ALL).contacts


def mixed(base: int, cradle: int, roller: int) -> Assembly:
    """Curve-3-blocks with another number of strips on every block."""
    strips = (base, cradle, roller)
    blocks = tuple(curve_three_blocks(s).blocks[i] for i, s in enumerate(strips))
    return Assembly(blocks, np.array([True, False, False]))


@pytest.mark.parametrize("strips", [(20, 13, 17), (5, 7, 9), (40, 39, 41), (10, 40, 20)])
def test_differently_meshed_sides_keep_their_area(strips: tuple[int, int, int]) -> None:
    report = find_contacts(mixed(*strips)).report
    for joint, area in ((1, 1.2130), (2, 1.2469)):
        assert report.interfaces.area[report.interfaces.block_b == joint].sum() == pytest.approx(
            area, rel=0.02
        )
    assert report.interfaces.area.sum() == pytest.approx(AREA, rel=0.02)
    assert report.overlaps == ()


def test_differently_meshed_rims_keep_their_area() -> None:
    blocks = (cube_curve(strips=18).blocks[0], cube_curve(strips=14).blocks[1])
    assert find_contacts(Assembly(blocks)).contacts.area.sum() == pytest.approx(0.4708, rel=0.02)


def test_slivers_go_into_their_neighbours() -> None:
    found = find_contacts(mixed(20, 21, 20))
    contacts, merged = found.contacts, found.report.interfaces.merged
    assert merged.max() > 1
    assert contacts.area.sum() == pytest.approx(AREA, rel=2e-3)
    assert contacts.area.min() > 0.1 * np.median(contacts.area)


def test_joints_of_exact_models_keep_their_faces() -> None:
    for model in (concave(), cube_curve(), tower(3)):
        found = find_contacts(model)
        assert found.report.resampled == ()
        assert found.report.interfaces.merged.tolist() == [1] * found.contacts.count


def test_vault_of_small_facets_has_as_many_pieces_as_its_curvature_needs() -> None:
    every, found = facets_of_vault(), pieces_of_vault()
    pieces, report = found.contacts, found.report
    assert every.count > 10 * pieces.count
    assert pieces.area.sum() == pytest.approx(every.area.sum(), rel=2e-3)
    assert max(pair.turn for pair in report.resampled) <= 3.0
    assert sum(pair.pieces for pair in report.resampled) == pieces.count
    assert sum(pair.points for pair in report.resampled) == pieces.corner_count
    (said,) = (line for line in report.summary() if "plane pieces" in line)
    assert said in Model.of(VAULT).notes
    assert report.to_dict()["resampled"][0]["pieces"] == report.resampled[0].pieces


def test_limits_of_pieces_differ_by_less_than_they_turn() -> None:
    model = curve_three_blocks(150)
    every = limit_tilt(Model(model, find_contacts(model, options=ALL).contacts), axis="y").best
    found = find_contacts(model)
    pieces = limit_tilt(Model(model, found.contacts), axis="y").best
    turn = max(pair.turn for pair in found.report.resampled)
    assert 1.0 < turn <= 3.0
    assert pieces.stands - every.falls < turn
    assert every.stands - pieces.falls < turn


def test_vault_of_pieces_falls_within_what_they_turn_of_all_facets() -> None:
    found, every = pieces_of_vault(), facets_of_vault()
    turn = max(pair.turn for pair in found.report.resampled)

    def verdict(contacts: Contacts, degrees: float) -> Verdict:
        return check(Model(VAULT, contacts, LoadCase.tilt(VAULT, (1.0, 0.0, 0.0), degrees))).verdict

    stands, falls = 32.0, 34.0
    assert falls - stands < turn
    assert verdict(found.contacts, stands) is Verdict.STABLE
    assert verdict(found.contacts, falls) is Verdict.UNSTABLE
    assert verdict(every, falls - turn) is Verdict.STABLE
    assert verdict(every, stands + turn) is Verdict.UNSTABLE


def test_contacts_of_a_file_are_all_kept_and_their_number_is_told(tmp_path: Path) -> None:
    file = tmp_path / "vault.json"
    write(Model(VAULT, facets_of_vault()), file)
    kept, searched = read(file), read(file, search=True)
    assert kept.contacts.count > 10 * searched.contacts.count
    (said,) = (note for note in kept.notes if "of the file are used" in note)
    assert f"all facets of {searched.contacts.joints.count} joints; --find-contacts" in said


def test_more_angle_means_fewer_pieces() -> None:
    model = curve_three_blocks(150)
    counts = [
        find_contacts(model, options=DetectionOptions(curve=angle)).contacts.count
        for angle in (0.0, 1.0, 4.0)
    ]
    assert counts == sorted(counts, reverse=True)
    assert len(set(counts)) == len(counts)
