"""The oracle and the model families against closed forms and published limits of equilibrium.

Nothing of the engine runs here: what disagrees with these numbers is a model or the oracle.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from drystone import Assembly, models
from tests.oracle import Oracle, bisected, down, touching_faces

Y = (0.0, 1.0, 0.0)


def test_block_on_an_incline_slides_at_the_friction_angle() -> None:
    for mu in (0.3, 0.6):
        limit = np.rad2deg(np.arctan(mu))
        for angle, stands in ((limit - 0.01, True), (limit + 0.01, False)):
            assembly = models.incline(angle)
            contacts = touching_faces(assembly, mu)
            # along u or v an inscribed pyramid with its edges there is exact
            assert Oracle(assembly, contacts, sides=4, outside=False).balances(down()) is stands


@pytest.mark.parametrize(("free", "angle"), [(2, 26.565), (4, 14.036)])
def test_towers_topple_at_the_angle_of_their_diagonal(free: int, angle: float) -> None:
    tower = models.tower(free + 1)
    oracle = Oracle(tower, touching_faces(tower, 1.0))
    assert oracle.tilt(Y, 0.0, 60.0) == pytest.approx(angle, abs=0.005)


def test_harmonic_stack_is_at_its_limit() -> None:
    for share, stands in ((0.9999, True), (1.0001, False)):
        stack = models.overhang(models.harmonic_offsets(4, share=share))
        assert Oracle(stack, touching_faces(stack, 0.6)).balances(down()) is stands


@pytest.mark.parametrize(("voussoirs", "ratio"), [(27, 0.106721), (36, 0.107424)])
def test_least_thickness_of_the_semicircular_arch(voussoirs: int, ratio: float) -> None:
    """Milankovitch 1907; Cocchetti and Rizzi 2020; discrete values by an independent program."""

    def stands(thickness: float) -> bool:
        arch = models.arch(thickness, voussoirs)
        return Oracle(arch, touching_faces(arch, 1.0), sides=4).balances(down())

    assert bisected(stands, 0.11, 0.10, 1e-5) == pytest.approx(ratio, abs=1e-5)


@pytest.mark.parametrize(("friction_angle", "tilt"), [(43.0, 8.246), (21.8, 3.006)])
def test_tilt_of_the_arch(friction_angle: float, tilt: float) -> None:
    arch = models.arch(0.15)
    oracle = Oracle(arch, touching_faces(arch, np.tan(np.deg2rad(friction_angle))), sides=4)
    assert oracle.tilt(Y, 0.0, 20.0) == pytest.approx(tilt, abs=0.005)


def test_buttressed_arch_needs_the_published_friction_and_tilts_as_far() -> None:
    arch = models.buttressed_arch()
    contacts = touching_faces(arch, 0.7)
    assert Oracle(arch, contacts).tilt(Y, 0.0, 30.0) == pytest.approx(12.12, abs=0.01)
    least = bisected(
        lambda mu: Oracle(arch, contacts.with_friction(mu), sides=4).balances(down()),
        0.5,
        0.1,
        1e-4,
    )
    assert least == pytest.approx(0.309, abs=5e-4)


@pytest.mark.parametrize(("number", "factor"), [(1, 0.64286), (2, 0.58)])
def test_associative_load_factors_of_ferris_and_tin_loi(number: int, factor: float) -> None:
    wall = models.ferris_wall(number)
    oracle = Oracle(wall, touching_faces(wall, 0.65), sides=4)
    assert oracle.load_factor(np.array([1.0, 0.0, 0.0])) == pytest.approx(factor, abs=1e-5)


def test_dome_of_the_literature_tilts_to_32_degrees() -> None:
    dome = models.dome()
    oracle = Oracle(dome, touching_faces(dome, 0.6), sides=8)
    assert oracle.balances(down(Y, 31.0))
    assert not oracle.balances(down(Y, 33.0))


@pytest.mark.parametrize(
    ("make", "too_little", "enough"),
    [
        (models.h_model, 0.0, 0.01),
        # the wall pushes along its normal, 30 degrees down: only more friction than that points up
        (models.a_model, 0.99 * np.tan(np.deg2rad(30.0)), 1.01 * np.tan(np.deg2rad(30.0))),
        (models.two_blocks_on_incline, 0.4368, 0.4370),
    ],
)
def test_forces_exist_from_a_least_friction_on(
    make: Callable[[], Assembly], too_little: float, enough: float
) -> None:
    model = make()
    contacts = touching_faces(model, 0.6)
    for mu, exists in ((too_little, False), (enough, True)):
        oracle = Oracle(model, contacts.with_friction(mu), sides=4, outside=False)
        assert oracle.balances(down()) is exists
