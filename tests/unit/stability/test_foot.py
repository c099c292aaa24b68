"""What stands on one joint says where it presses on it."""

from __future__ import annotations

import pytest

import drystone
from drystone import Assembly, Model
from drystone.models import box, tower

WIDTH, HEIGHT = 1.0, 3.0


def pier() -> Assembly:
    ground = box((2.0, 1.0, 0.5), (0.0, 0.0, -0.5), "ground")
    body = box((WIDTH, 1.0, HEIGHT), (0.5, 0.0, 0.0), "pier")
    return Assembly((ground, body)).with_fixed([0])


def feet(model: Model) -> list[str]:
    said = [one.text for one in drystone.check(model).sentences()]
    return [one for one in said if one.startswith("foot:")]


@pytest.mark.parametrize("push", [0.06, 0.16])
def test_a_push_moves_the_resultant_by_half_the_height_and_the_kern_is_a_sixth(push: float) -> None:
    (said,) = feet(Model.of(pier(), friction=0.6).with_load((9.81 * push, 0.0, -9.81)))
    far = push * 0.5 * HEIGHT
    share = far / (WIDTH / 6.0)
    inside = f"inside its kern ({100.0 * share:.3g} % of the way to the edge of the kern)"
    outside = f"outside its kern, at {share:.3g} times the way to the edge of the kern, not of the"
    assert said.startswith(f"foot: the resultant is {1e3 * far:.0f} mm from its middle, ")
    assert (inside if share < 1.0 else outside) in said


def test_nothing_is_said_of_a_resultant_in_the_middle_and_of_two_feet() -> None:
    assert feet(Model.of(tower(3), friction=0.6)) == []
    legs = [box((0.2, 1.0, 0.5), (x, 0.0, -0.5), f"leg at {x}") for x in (0.5, 1.3)]
    body = pier().blocks[1]
    two = Assembly((*legs, body)).with_fixed([0, 1])
    assert feet(Model.of(two, friction=0.6).with_load((0.5, 0.0, -9.81))) == []
