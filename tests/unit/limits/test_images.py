"""Structures that are their own image, and the axes about which they tilt alike."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from drystone import Assembly, LoadCase, Model, limit_tilt
from drystone.limits.images import unlike_axes
from drystone.models import arch, dome, leaning_column, random_pack, tower, wall

ALL = ["x", "-x", "y", "-y"]


@pytest.mark.parametrize(
    ("build", "axes"),
    [
        (lambda: tower(3), ["x"]),
        (lambda: dome(slices=8, rings=2), ["x"]),
        (lambda: dome(slices=9, rings=2, bonded=True), ["x", "y", "-y"]),
        (lambda: wall(3, 2), ["x", "y"]),
        (lambda: arch(0.15, 7), ["x", "y"]),
        (lambda: leaning_column(lean_deg=5.0), ["x", "y", "-y"]),
        (lambda: random_pack(6, 2), ALL),
    ],
)
def test_a_structure_tilts_alike_about_an_axis_and_its_image(
    build: Callable[[], Assembly], axes: list[str]
) -> None:
    model = Model.of(build(), friction=0.6)
    assert list(unlike_axes(model)) == axes


def test_what_differs_on_one_side_is_no_image() -> None:
    """A wall of one leaf has the same front and back, whatever differs along it."""
    model = Model.of(wall(3, 2), friction=0.6)
    rough = np.full(model.contacts.count, 0.6)
    rough[1] = 0.5
    heavy = model.assembly.with_density([*[2000.0] * (len(model) - 1), 2500.0])
    fewer = model.contacts.select(np.delete(np.arange(model.contacts.count), 1))
    for other in (
        model.with_friction(rough),
        Model.of(heavy, friction=0.6),
        model.with_contacts(fewer),
    ):
        assert list(unlike_axes(other)) == ["x", "y", "-y"]
    push = LoadCase.seismic(model.assembly, 0.1)
    assert list(unlike_axes(model.with_load(model.load + push))) == ALL


def test_the_state_before_the_limit_of_equilibrium_balances_the_loads() -> None:
    """It is mixed of the forces upright and at the limit: no program is solved for it."""
    found = limit_tilt(arch(0.15, 7), friction=0.6).equilibrium
    assert found.standing is not None
    residuals = found.standing.residuals
    assert residuals is not None
    assert max(residuals.equilibrium, residuals.cone) < 1e-6
    assert (found.computed or 0.0) - (found.stands or 0.0) == pytest.approx(0.025)
