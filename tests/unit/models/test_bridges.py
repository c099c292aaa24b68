"""Bridges: profiles of the intrados, feet, piers, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from drystone import InputError, check
from drystone.models import segmental_bridge
from drystone.models.bridges import Measured, joints_of
from tests.unit.io.test_dxf import light, text


def test_a_segmental_ring_has_its_span_its_rise_and_radial_joints() -> None:
    joints = joints_of("segmental", 6.0, 1.5, 4)
    foot, ray = joints[:, 0], joints[:, 1]
    assert foot[[0, -1]].tolist() == [[0.0, 0.0], pytest.approx([6.0, 0.0])]
    assert foot[2] == pytest.approx([3.0, 1.5])
    centre = np.array([3.0, 1.5 - 3.75])  # radius (3^2 + 1.5^2) / 3
    assert foot - 3.75 * ray == pytest.approx(np.tile(centre, (5, 1)))


@pytest.mark.parametrize(
    ("profile", "rise", "crown"),
    [("pointed", 4.0, 25.0 / 24.0), ("elliptic", 1.5, 1.0), ("three-centred", 1.5, 1.0)],
)
def test_other_profiles_spring_upright_and_reach_their_rise(
    profile: str, rise: float, crown: float
) -> None:
    """An apex is mitred: normals of (0.28, 0.96) and (-0.28, 0.96) meet there."""
    joints = joints_of(profile, 6.0, rise, 8)  # type: ignore[arg-type]
    assert joints[0, 1] == pytest.approx([-1.0, 0.0], abs=1e-9)
    assert joints[4] == pytest.approx(np.array([[3.0, rise], [0.0, crown]]), abs=1e-6)
    mirrored = joints[::-1] * [-1.0, 1.0] + np.array([[6.0, 0.0], [0.0, 0.0]])
    assert joints == pytest.approx(mirrored, abs=1e-6)


def test_points_of_a_circle_give_its_ring() -> None:
    angle = np.linspace(np.pi, 0.0, 400)
    points = np.stack([3.0 + 3.0 * np.cos(angle), 3.0 * np.sin(angle)], axis=1)
    measured = joints_of(Measured(points), 0.0, 0.0, 10)
    circle = joints_of("segmental", 6.0, 3.0, 10)
    assert measured[:, 0] == pytest.approx(circle[:, 0], abs=1e-3)
    assert measured[1:-1, 1] == pytest.approx(circle[1:-1, 1], abs=1e-3)


def test_the_polyline_of_a_drawing_is_an_intrados(tmp_path: Path) -> None:
    drawn = tmp_path / "ring.dxf"
    bulge = -float(np.tan(np.pi / 4))  # half a circle, from the left over the top
    drawn.write_text(text([light([(0, 0, bulge), (6000, 0)], closed=0)], units=4), "ascii")
    measured = Measured.named(str(drawn))
    radius = np.linalg.norm(measured.point - [3.0, 0.0], axis=1)
    assert radius == pytest.approx(np.full(len(radius), 3.0))
    table = tmp_path / "ring.csv"
    rows = [f"{x},{z}" for x, z in measured.point]
    for header in ([], ["x,z"], ["x[mm],z[mm]"]):
        table.write_text("\n".join([*header, *rows]), "utf-8")
        scale = 1e-3 if "mm" in str(header) else 1.0
        assert Measured.named(str(table)).point == pytest.approx(scale * measured.point)
    table.write_text("x [mm], z [m]\n0,0\n3000,1.5\n6000,0", "utf-8")
    assert Measured.named(str(table)).point.tolist() == [[0.0, 0.0], [3.0, 1.5], [6.0, 0.0]]
    table.write_text("0,0\n3,1.5\n6,0", "utf-8-sig")
    assert Measured.named(str(table)).point.tolist() == [[0.0, 0.0], [3.0, 1.5], [6.0, 0.0]]
    table.write_text("x,z\n0,0\n3000,1500\n6000,0", "utf-8")
    with pytest.raises(InputError, match=r"it spans 6000 m; give metres, or the unit: x \[mm\]"):
        Measured.named(str(table))
    table.write_text("0,0\n3;one\n6,0", "utf-8")
    with pytest.raises(InputError, match="'3,one' is not X,Z"):
        Measured.named(str(table))
    with pytest.raises(InputError, match="does not grow: 3 in row 2, 2 in the next"):
        Measured.named("0,0 3,1.5 2,2 6,0")


def test_piers_and_abutments_stand_free_on_a_fixed_course() -> None:
    bridge = segmental_bridge(voussoirs=6, spans=2, pier=1.5, height=2.0, courses=2)
    fixed = [name for name, held in zip(bridge.names, bridge.fixed, strict=True) if held]
    assert fixed == ["springer-left-ground", "pier-1-ground", "springer-right-ground"]
    assert check(bridge, friction=0.7).stable


def test_a_ring_of_two_rolls_is_one_ring_cut_along() -> None:
    one, two = (segmental_bridge(ring=ring, rings=rolls) for ring, rolls in ((0.6, 1), (0.3, 2)))
    assert one.mass.sum() == pytest.approx(two.mass.sum())


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"rise": 4.0}, "more than a semicircle"),
        ({"profile": "pointed"}, "its arcs would begin inclined"),
        ({"profile": "three-centred", "rise": 0.5}, "no such arcs"),
        ({"spans": 2, "pier": 0.1}, "the rings meet over a pier"),
        ({"height": 2.0, "abutment": 0.1}, "an abutment is too narrow"),
        ({"profile": Measured(np.array([[0.0, 0.0], [1.0, -1.0], [2.0, 0.0]]))}, "joints cross"),
        ({"profile": Measured.named("0,0 1,1 2,0"), "span": 6.0}, "span and rise are those of"),
    ],
)
def test_what_cannot_be_built_is_told(given: dict[str, object], told: str) -> None:
    with pytest.raises(InputError, match=told):
        segmental_bridge(ring=0.8, voussoirs=30, **given)  # type: ignore[arg-type]
