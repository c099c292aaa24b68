"""Force and torque that friction resists, against other ways to find them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from drystone.base.arrays import dot, lengths, plane_cross
from drystone.base.ragged import Ragged
from drystone.friction_use import LEVER
from drystone.geometry.kern import edge_ratio, linear_pressure, sections
from drystone.geometry.quadrature import cut_face_points
from drystone.geometry.slipping import clipped, slip_use, turned

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
ANGLE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.3], [0.3, 0.3], [0.3, 1.0], [0.0, 1.0]])
TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.2, 0.7]])
FACES = [
    (SQUARE, (0.5, 0.5)),
    (SQUARE, (0.2, 0.1)),
    (ANGLE, (0.6, 0.3)),
    (ANGLE, (1.4, 0.2)),
    (TRIANGLE, (0.3, 0.3)),
    (np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.02], [0.0, 0.02]]), (0.5, 0.004)),
]


def pressed(corners: np.ndarray, centre: tuple[float, float]) -> tuple[np.ndarray, Ragged, float]:
    """A face from its centre of pressure, with the plane of its pressure, and its area."""
    local, start = corners - centre, np.array([0, len(corners)])
    made = sections(local, start)
    return local, linear_pressure(made, local, start, np.zeros((1, 2))), float(made.area[0])


def around(draw: np.random.Generator, count: int) -> np.ndarray:
    """Corners (count, 2) of a random star-shaped face, counter-clockwise."""
    angle = 2.0 * np.pi / count * (np.arange(count) + draw.uniform(0.0, 0.5, count))
    along = np.stack([np.cos(angle), 10.0 ** draw.uniform(-1.0, 1.0) * np.sin(angle)], axis=1)
    return draw.uniform(0.3, 1.0, (count, 1)) * along


def grid(local: np.ndarray, plane: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of a grid inside a face (p, 2) and the friction of each (p,), in all 1."""
    import shapely

    low, high = local.min(axis=0), local.max(axis=0)
    at = (np.arange(count) + 0.5) / count
    x, y = np.meshgrid(*(low[i] + at * (high[i] - low[i]) for i in (0, 1)))
    inside = shapely.contains_xy(shapely.Polygon(local), x, y)
    place = np.stack([x[inside], y[inside]], axis=1)
    share = np.maximum(plane[0, 0] + place @ plane[0, 1:], 0.0)
    return place, share / share.sum()


def by_search(place: np.ndarray, share: np.ndarray, force: np.ndarray, torque: float) -> float:
    """The use that a search for the slip of least power finds."""
    wanted = np.append(force, torque)
    across = np.linalg.svd(wanted[None])[2][1:]

    def power(shares: np.ndarray) -> float:
        v, w, turn = wanted / (wanted @ wanted) + shares @ across
        return float(share @ np.hypot(v - turn * place[:, 1], w + turn * place[:, 0]))

    starts = ([0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0])
    return 1.0 / min(
        minimize(power, start, method="Nelder-Mead", options={"fatol": 1e-7}).fun
        for start in starts
    )


@pytest.mark.parametrize("case", range(len(FACES)))
def test_use_is_that_of_the_slip_of_least_power(case: int) -> None:
    local, plane, area = pressed(*FACES[case])
    place, share = grid(local, plane, 100)
    owner = np.zeros(len(local), dtype=int)
    loops, corners = clipped(
        Ragged.from_counts([len(local)]), local, plane[owner, 0] + local @ plane[0, 1:]
    )
    rng = np.random.default_rng(case)
    for force, torque in (((0.0, 0.0), 1.0), (rng.normal(size=2), 0.3), (rng.normal(size=2), -0.1)):
        force = np.array(force)
        found = slip_use(corners, loops, plane, area * force[None], np.array([area * torque]))
        assert found.use[0] == pytest.approx(by_search(place, share, force, torque), rel=8e-3)


def test_closed_forms() -> None:
    angle = 2.0 * np.pi * np.arange(720) / 720.0
    disc = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    corners = np.concatenate([SQUARE - 0.5, disc])
    loops = Ragged.from_counts([4, 720])
    even = np.tile([1.0, 0.0, 0.0], (2, 1))
    torque = np.array([(np.sqrt(2.0) + np.arcsinh(1.0)) / 6.0, np.pi * 2.0 / 3.0])
    found = slip_use(corners, loops, even, np.zeros((2, 2)), torque)
    assert found.use == pytest.approx(1.0, rel=1e-4)
    assert found.pole == pytest.approx(0.0, abs=1e-6)
    pulled = slip_use(corners, loops, even, np.array([[0.5, 0.0], [0.0, np.pi]]), 1e-6 * torque)
    assert pulled.use == pytest.approx([0.5, 1.0], rel=1e-4)


@pytest.mark.parametrize("width", [1e-2, 2e-5, 1e-9])
def test_a_strip_of_any_width_resists_as_the_line_that_it_nearly_is(width: float) -> None:
    """A line of length 2 that turns about one of its points f resists f and (1 - f^2) / 2."""
    force = np.array([0.3, 0.6, 0.9, 0.99])
    turn = np.array([[0.8, 0.6], [-0.6, 0.8]])
    strip = (np.array([[-1, -1], [1, -1], [1, 2], [-1, 2]]) * [1.0, width / 3.0]) @ turn
    slope = turn[1] / width**2
    plane = np.tile([2.0 / (3.0 * width), *-slope], (4, 1))
    across, torque = force[:, None] * turn[1], (1.0 - force**2) / 2.0
    found = slip_use(np.tile(strip, (4, 1)), Ragged.from_counts([4] * 4), plane, across, torque)
    assert found.use == pytest.approx(1.0, abs=1e-4)
    assert found.pole == pytest.approx(-force[:, None] * turn[0], abs=2e-3)


def test_faces_are_found_one_by_one() -> None:
    rng = np.random.default_rng(5)
    faces = [pressed(*case) for case in FACES]
    force, torque = rng.normal(size=(len(faces), 2)), rng.normal(size=len(faces))
    parts = [
        clipped(Ragged.from_counts([len(local)]), local, plane[0, 0] + local @ plane[0, 1:])
        for local, plane, _ in faces
    ]
    together = slip_use(
        np.concatenate([corners for _, corners in parts]),
        Ragged.from_counts([loops.rows for loops, _ in parts]),
        np.concatenate([plane for _, plane, _ in faces]),
        force,
        torque,
    )
    for i, (loops, corners) in enumerate(parts):
        alone = slip_use(corners, loops, faces[i][1], force[[i]], torque[[i]])
        assert together.use[i] == pytest.approx(alone.use[0], rel=1e-9)
        assert together.pole[i] == pytest.approx(alone.pole[0], rel=1e-6)


@pytest.mark.parametrize("pole", [(0.4, 0.2), (0.0, 0.0), (1.0, 3.0), (-20.0, 7.0)])
def test_integrals_of_a_turn_are_the_derivatives_of_each_other(pole: tuple[float, float]) -> None:
    plane = np.array([[0.3, 0.5, 0.8]])
    loops, pole = Ragged.from_counts([6]), np.array([pole])
    found = turned(ANGLE, loops, plane, pole)
    place, _ = grid(ANGLE, plane, 400)
    pressure = plane[0, 0] + place @ plane[0, 1:]
    mean = float((pressure * np.hypot(*(place - pole).T)).mean()) * 0.81
    assert found.moment[0] == pytest.approx(mean, rel=2e-3)
    step = 1e-4
    for i in (0, 1):
        ahead, behind = (
            turned(ANGLE, loops, plane, pole + side * step * np.eye(2)[[i]]) for side in (1.0, -1.0)
        )
        slope = (ahead.moment - behind.moment) / (2.0 * step)
        assert slope == pytest.approx(-found.pull[:, i], rel=1e-4, abs=1e-7)
        bend = np.eye(2) * np.trace(found.bend[0]) - found.bend[0]
        assert (ahead.pull - behind.pull)[0] / (2.0 * step) == pytest.approx(
            -bend[i], rel=2e-2, abs=2e-4
        )


def test_pressure_is_linear_and_does_not_pull() -> None:
    corners, start = np.tile(SQUARE, (2, 1)), np.array([0, 4, 8])
    centre = np.array([[0.2, 0.5], [0.5, 0.5]])
    plane = linear_pressure(sections(corners, start), corners, start, centre)
    assert plane == pytest.approx(np.array([[10.0 / 3.0, -50.0 / 9.0, 0.0], [1.0, 0.0, 0.0]]))
    points = cut_face_points(corners, start, plane, centre)
    assert points.loops.sum(points.area) == pytest.approx([1.0, 1.0])
    height = plane[points.loops.owner, 0] + (points.place * plane[points.loops.owner, 1:]).sum(1)
    share = points.area * np.maximum(height, 0.0)
    assert points.loops.sum(share) == pytest.approx([1.0, 1.0])
    assert points.loops.sum(share[:, None] * points.place) == pytest.approx(centre, rel=1e-2)
    tipped, even = points.loops.split(share)
    assert (tipped[points.place[points.loops[0], 0] > 0.6001] == 0.0).all()
    assert even == pytest.approx(points.area[points.loops[1]])


def test_pressure_on_a_part_of_a_face_lies_on_average_not_much_nearer_than_the_rim() -> None:
    draw = np.random.default_rng(5)
    corners = [around(draw, int(draw.integers(3, 12))) for _ in range(400)]
    loops, corner = Ragged.of(corners), np.concatenate(corners)
    made = sections(corner, loops)
    start = draw.normal(size=made.centroid.shape) * np.sqrt(made.area)[:, None]
    way = np.sqrt(draw.uniform(0.2, 0.999, len(loops)))
    way /= edge_ratio(made, corner, loops, made.centroid + start)
    centre = made.centroid + way[:, None] * start
    local = corner - centre[loops.owner]
    made = sections(local, loops)
    plane = linear_pressure(made, local, loops, np.zeros_like(centre))
    edge = local[loops.following] - local
    rim = loops.min(plane_cross(local, edge) / lengths(edge))
    height = plane[loops.owner, 0] + dot(local, plane[loops.owner, 1:])
    some = np.isfinite(plane[:, 0]) & (loops.min(height) < 0.0) & (rim > 0.0)
    part, row = loops.take(some)
    none, one = np.zeros((len(part), 2)), np.ones(len(part))
    pressed_part, pressed_corner = clipped(part, local[row], height[row])
    use = slip_use(pressed_corner, pressed_part, plane[some], none, one).use
    assert len(part) > 200
    assert (1.0 / (use * made.area[some]) > LEVER * rim[some]).all()
