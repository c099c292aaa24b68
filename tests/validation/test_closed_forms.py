"""The verdict against closed forms, just inside and just outside of each."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import (
    Assembly,
    LoadCase,
    Model,
    Result,
    Verdict,
    check,
    find_contacts,
    models,
    solve_rbe,
)
from tests.oracle import Oracle, down, touching_faces

STABLE, UNSTABLE = Verdict.STABLE, Verdict.UNSTABLE
Y = (0.0, 1.0, 0.0)


def verdict(
    assembly: Assembly, friction: float, axis: tuple[float, float, float] = Y, tilt: float = 0.0
) -> Result:
    contacts = find_contacts(assembly, friction=friction).contacts
    result = check(Model(assembly, contacts, LoadCase.tilt(assembly, axis, tilt)))
    if result.verdict is STABLE:
        assert result.residuals is not None
        assert result.residuals.largest <= 1e-8
    if result.verdict is UNSTABLE:
        assert result.falling
        assert result.mechanism is not None
    return result


@pytest.mark.parametrize("friction", [0.1, 0.6, 1.2])
def test_block_on_an_incline_stands_if_and_only_if_friction_exceeds_the_slope(
    friction: float,
) -> None:
    limit = float(np.rad2deg(np.arctan(friction)))
    size = (1.0, 0.8, 0.5)
    assert verdict(models.incline(limit - 0.05, size), friction).verdict is STABLE
    assert verdict(models.incline(limit + 0.05, size), friction).verdict is UNSTABLE


def test_a_steep_block_on_an_incline_topples_before_it_slides() -> None:
    limit = float(np.rad2deg(np.arctan(0.5 / 1.0)))
    assert verdict(models.incline(limit - 0.05, (0.5, 0.8, 1.0)), 0.9).verdict is STABLE
    assert verdict(models.incline(limit + 0.05, (0.5, 0.8, 1.0)), 0.9).verdict is UNSTABLE


@pytest.mark.parametrize(("cubes", "angle"), [(2, 26.565), (4, 14.036)])
def test_towers_topple_at_the_angle_of_their_diagonal(cubes: int, angle: float) -> None:
    tower = models.tower(cubes + 1)
    assert verdict(tower, 0.8, Y, angle - 0.05).verdict is STABLE
    assert verdict(tower, 0.8, Y, angle + 0.05).verdict is UNSTABLE


@pytest.mark.parametrize("count", [1, 2, 3, 4, 8])
def test_bricks_overhang_by_the_harmonic_sum_and_no_further(count: int) -> None:
    """Hall 2005."""
    for share, expected in ((0.999, STABLE), (1.001, UNSTABLE)):
        stack = models.overhang(models.harmonic_offsets(count, share=share))
        assert verdict(stack, 0.6).verdict is expected


def test_two_blocks_on_a_slanted_joint_need_the_tangent_of_its_angle() -> None:
    stack = models.two_blocks_on_incline(23.6)
    assert verdict(stack, 0.4365).verdict is UNSTABLE
    assert verdict(stack, 0.4373).verdict is STABLE


@pytest.mark.parametrize("friction", [0.05, 0.2, 0.6, 0.9, 2.0, 10.0])
@pytest.mark.parametrize("make", [models.h_model, models.a_model])
def test_h_and_a_fall_at_every_friction(make: type, friction: float) -> None:
    result = verdict(make(), friction)
    assert result.verdict is UNSTABLE
    assert result.falling_names == ("block",)


@pytest.mark.parametrize(("make", "friction"), [(models.h_model, 0.2), (models.a_model, 0.7)])
def test_h_and_a_are_in_equilibrium_for_rbe(make: type, friction: float) -> None:
    model = make()
    contacts = find_contacts(model, friction=friction).contacts
    assert solve_rbe(Model(model, contacts)).verdict is Verdict.EQUILIBRIUM_EXISTS


def test_exactly_two_pieces_of_the_shelf_fall() -> None:
    shelf = models.shelf()
    contacts = find_contacts(shelf, friction=0.9).contacts
    assert solve_rbe(Model(shelf, contacts)).verdict is Verdict.EQUILIBRIUM_EXISTS
    result = check(Model(shelf, contacts))
    assert result.verdict is UNSTABLE
    assert set(result.falling) == {9, 10}


def test_the_shelf_stands_without_the_two_pieces() -> None:
    assert verdict(models.shelf().without(["block-9", "block-10"]), 0.9).verdict is STABLE


@pytest.mark.parametrize(("friction_angle", "tilt"), [(43.0, 8.246), (21.8, 3.006)])
def test_arch_tilts_to_the_published_angle(friction_angle: float, tilt: float) -> None:
    """Kao et al. 2022: 8.2 and 3.0 degrees, RBE, CRA and 3DEC alike."""
    arch = models.arch(0.15)
    friction = float(np.tan(np.deg2rad(friction_angle)))
    assert verdict(arch, friction, Y, tilt - 0.05).verdict is STABLE
    assert verdict(arch, friction, Y, tilt + 0.05).verdict is UNSTABLE


@pytest.mark.parametrize(("ratio", "expected"), [(0.109, STABLE), (0.106, UNSTABLE)])
def test_arch_stands_from_the_thickness_of_milankovitch_on(ratio: float, expected: Verdict) -> None:
    assert verdict(models.arch(ratio), 0.9).verdict is expected


def test_a_block_without_a_contact_falls() -> None:
    apart = Assembly(
        (models.box((1, 1, 1), name="base"), models.box((1, 1, 1), (0, 0, 1.5), "loose")),
        np.array([True, False]),
    )
    result = verdict(apart, 0.6)
    assert result.verdict is UNSTABLE
    assert result.falling_names == ("loose",)


@pytest.mark.parametrize("name", ["vault", "dome", "wall", "buttressed arch", "corbelled wall"])
def test_built_in_structures_stand(name: str) -> None:
    model = {
        "vault": models.vault,
        "dome": lambda: models.dome(slices=8, rings=5, bonded=True),
        "wall": models.wall,
        "buttressed arch": models.buttressed_arch,
        "corbelled wall": models.corbelled_wall,
    }[name]()
    assert verdict(model, 0.6).verdict is STABLE


def test_a_corbelled_wall_falls_when_its_centre_leaves_the_base() -> None:
    for corbel, expected in ((0.049, STABLE), (0.051, UNSTABLE)):  # (5 + 1) corbel = 0.3
        assert verdict(models.corbelled_wall(corbel=corbel), 0.8).verdict is expected


@pytest.mark.parametrize("seed", range(6))
def test_rbe_agrees_with_linear_programs_on_random_stacks(seed: int) -> None:
    """Equilibrium by the engine's exact cone lies between an inner and an outer pyramid."""
    random = np.random.default_rng(seed)
    offsets = random.uniform(-0.55, 0.55, 3)
    stack = models.overhang(offsets.tolist(), (1.0, 1.0, 0.6))
    friction = float(random.uniform(0.1, 0.7))
    axis, angle = (0.3, 1.0, 0.0), float(random.uniform(0.0, 25.0))
    gravity = down(axis, angle)
    brute = touching_faces(stack, friction)
    inner = Oracle(stack, brute, sides=32, outside=False).balances(gravity)
    outer = Oracle(stack, brute, sides=32).balances(gravity)
    assert inner is outer  # the seeds keep clear of the limit
    contacts = find_contacts(stack, friction=friction).contacts
    result = solve_rbe(Model(stack, contacts, LoadCase.tilt(stack, axis, angle)))
    assert result.verdict is (Verdict.EQUILIBRIUM_EXISTS if inner else UNSTABLE)
