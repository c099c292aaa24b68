"""Whether the block that carries the ends of joints matters: in any axes, and on any springs."""

import numpy as np
import pytest

from drystone import LoadCase, Model, settle
from drystone.geometry.frames import rotation_about
from drystone.models import curve_three_blocks
from drystone.settlement import Carrier, Outcome, path


def cradle(tilt: float, turn: float = 0.0) -> Model:
    """A roller in a cradle, tilted about x and then turned as a whole [degrees]."""
    rotation = rotation_about(np.array([1.0, 2.0, 3.0]), turn)
    assembly = curve_three_blocks()
    pull = LoadCase.tilt(assembly, (1.0, 0.0, 0.0), tilt).wrench[:, :3].sum(axis=0)
    turned = assembly.transformed(rotation)
    load = LoadCase.gravity(turned, direction=rotation @ pull / np.linalg.norm(pull))
    return Model.of(turned, friction=0.84, load=load)


def test_the_distance_of_the_two_places_of_an_end_does_not_depend_on_the_axes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    farthest, seen = path._farthest, []

    def told(*given):  # type: ignore[no-untyped-def]
        seen.append(farthest(*given))
        return seen[-1]

    monkeypatch.setattr(path, "_farthest", told)
    for turn in (0.0, 37.0, 77.0):
        settle(cradle(23.0, turn))
    assert seen[0] > 1e-5
    np.testing.assert_allclose(seen, seen[0], rtol=1e-3)


def test_on_stiffer_springs_both_carriers_are_followed() -> None:
    # the ends differ by 64 millionths of a block, which is 6,400 overlaps there
    found = settle(cradle(25.3))
    assert [path.carrier for path in found.paths] == [Carrier.MOVING, Carrier.RESTING]
    assert found.paths[0].overlap < 1e-6
    assert [path.outcome for path in found.paths] == [Outcome.RESTS, Outcome.FALLS]
    assert found.outcome is Outcome.ENDS_DECIDE
