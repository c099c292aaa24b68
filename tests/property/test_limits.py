"""Limits, kerns and joint tables do not depend on units, density, place or orientation."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drystone import Model, limit_shrink, limit_tilt, solve_rbe
from drystone.geometry.frames import rotation_about
from drystone.geometry.kern import convex_hull, edge_ratio, kern, kern_ratio, sections
from drystone.limits import LimitOptions, thrust_bounds
from drystone.models import arch
from drystone.virtual import shrink, to_kern
from tests.oracle import touching_faces

ARCH = arch(0.2, 9)
JOINTS = touching_faces(ARCH, 0.7)
BOUND = LimitOptions(equilibrium_only=True, width=0.01)
TILT = limit_tilt(Model(ARCH, JOINTS), "y", options=BOUND).equilibrium.value
THRUST = thrust_bounds(Model(ARCH, JOINTS), "springer-right", (1.0, 0.0, 0.0))
TABLE = THRUST.least_state.joints() if THRUST.least_state is not None else None


@settings(max_examples=4, deadline=None, derandomize=True)
@given(
    st.sampled_from([1e-3, 0.1, 10.0, 1e3]),
    st.sampled_from([1e-6, 1.0, 2400.0]),
    st.sampled_from([0.0, 30.0, 137.0]),
)
def test_limits_and_shares_do_not_depend_on_size_density_or_direction(
    scale: float, density: float, turn: float
) -> None:
    rotation = rotation_about(np.array([0.0, 0.0, 1.0]), turn)
    moved = ARCH.transformed(scale * rotation, (scale * 40.0, 0.0, 0.0)).with_density(density)
    joints = touching_faces(moved, 0.7)
    axis = rotation @ np.array([0.0, 1.0, 0.0])
    limit = limit_tilt(Model(moved, joints), axis, options=BOUND)
    assert limit.equilibrium.value == pytest.approx(TILT, abs=1e-4)
    bounds = thrust_bounds(Model(moved, joints), "springer-right", rotation[:, 0])
    unit = scale**3 * density / 2400.0
    assert bounds.least == pytest.approx(THRUST.least * unit, rel=1e-6)
    assert bounds.most == pytest.approx(THRUST.most * unit, rel=1e-6)
    assert TABLE is not None
    assert bounds.least_state is not None
    table = bounds.least_state.joints()
    for name in ("friction_use", "kern_ratio", "edge_ratio"):
        found, expected = np.sort(table[name]), np.sort(TABLE[name])
        np.testing.assert_allclose(found, expected, atol=1e-4)
    np.testing.assert_allclose(
        np.sort(table["mean_pressure"]),
        np.sort(TABLE["mean_pressure"]) * unit / scale**2,
        rtol=1e-4,
    )


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 100_000), st.floats(-3.0, 3.0), st.floats(0.2, 5.0))
def test_kern_and_ratios_follow_any_affine_map(seed: int, shear: float, stretch: float) -> None:
    rng = np.random.default_rng(seed)
    hull = convex_hull(rng.uniform(-1.0, 1.0, (6, 2)))
    start = np.array([0, len(hull)])
    if sections(hull, start).area[0] < 0.1:
        return
    affine = np.array([[stretch, shear], [0.0, 1.0]])
    place = np.array([3.0, -7.0])
    mapped = hull @ affine.T + place
    expected = kern(hull) @ affine.T + place
    for corner in kern(mapped):
        assert np.linalg.norm(expected - corner, axis=1).min() < 1e-9
    at = rng.uniform(-0.3, 0.3, (1, 2))
    for ratio in (kern_ratio, edge_ratio):
        one = ratio(sections(hull, start), hull, start, at)
        other = ratio(sections(mapped, start), mapped, start, at @ affine.T + place)
        assert other[0] == pytest.approx(one[0], abs=1e-9)


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.floats(0.1, 1.0), st.floats(0.1, 1.0))
def test_smaller_joints_never_stand_where_larger_ones_do_not(one: float, other: float) -> None:
    small, large = min(one, other), max(one, other)
    stands = [
        solve_rbe(Model(ARCH, shrink(JOINTS, factor))).verdict == "equilibrium exists"
        for factor in (small, large)
    ]
    assert stands[0] <= stands[1]


def test_what_stands_within_its_kerns_stands_with_a_third_of_its_joints_left_over() -> None:
    thick = arch(0.5, 9)
    joints = touching_faces(thick, 0.9)
    assert solve_rbe(Model(thick, to_kern(joints))).verdict == "equilibrium exists"
    limit = limit_shrink(Model(thick, joints), options=LimitOptions(equilibrium_only=True))
    assert limit.equilibrium.value is not None
    assert limit.equilibrium.value < 1.0 / 3.0
