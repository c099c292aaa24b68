"""The scan that finds published limits again."""

from __future__ import annotations

import pytest

from benchmarks.scan import tilt_limit
from benchmarks.thesis import _same
from drystone.reproduce.tilt_cases import studies


def test_limit_is_where_standing_is_first_lost() -> None:
    found = tilt_limit(lambda angle: angle <= 23.4)
    assert found.angle == pytest.approx(23.4, abs=0.03)
    assert found.islands == ()


def test_islands_beyond_the_limit_are_told() -> None:
    found = tilt_limit(lambda angle: angle < 12.0 or 39.0 < angle < 51.0)
    assert found.angle == pytest.approx(12.0, abs=0.03)
    assert found.islands == (40.0, 45.0, 50.0)


def test_a_narrow_fall_below_the_last_one_is_found() -> None:
    # as close to the limit of a hood: it falls, stands again a little farther, and falls for good
    found = tilt_limit(lambda angle: angle < 41.48 or 41.52 < angle < 41.6)
    assert found.angle == pytest.approx(41.475, abs=0.026)


def test_never_and_always_are_answers() -> None:
    assert tilt_limit(lambda angle: True).angle == 180.0
    assert tilt_limit(lambda angle: False).angle == 0.0


def test_a_bound_ends_the_scan() -> None:
    asked: list[float] = []

    def stands(angle: float) -> bool:
        asked.append(angle)
        return angle < 3.0

    assert tilt_limit(stands, highest=3.1, step=1.0).angle == pytest.approx(3.0, abs=0.03)
    assert max(asked) <= 4.1


def test_whole_degrees_are_taken_as_cut_down() -> None:
    assert _same(25.03, 25.0)
    assert _same(13.64, 13.0)
    assert _same(71.31, 71.3)
    assert not _same(71.9, 71.3)
    assert not _same(12.7, 13.0)
    assert not _same(14.1, 13.0)


def test_every_published_tilt_test_is_there_once() -> None:
    keys = [study.key for study in studies()]
    assert len(keys) == len(set(keys)) == 24 + 4 + 5 + 6 + 2
