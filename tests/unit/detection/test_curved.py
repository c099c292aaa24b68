"""Curved joints meshed differently, and curved blocks on plane ones."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from drystone import Assembly, Block, Model, Verdict, check, find_contacts
from drystone.assembly import replace_block
from drystone.base.arrays import Floats
from drystone.detection import DetectionOptions
from drystone.models import box, cube_curve, curve_three_blocks, prism

Surface = Callable[[Floats, Floats], Floats]
EVERY = DetectionOptions(curve=0.0)


def dome(x: Floats, y: Floats) -> Floats:
    """Curved alike in both directions."""
    height: Floats = 0.3 * np.cos(2.0 * (x - 0.5)) * np.cos(2.0 * (y - 0.5))
    return height


def egg_crate(x: Floats, y: Floats) -> Floats:
    """One hill, one dale and a saddle beside each."""
    height: Floats = 0.08 * np.sin(2.0 * np.pi * x) * np.sin(2.0 * np.pi * y)
    return height


def bump(x: Floats, y: Floats) -> Floats:
    """A steep Gaussian hill."""
    height: Floats = 0.8 * np.exp(-20.0 * ((x - 0.5) ** 2 + (y - 0.5) ** 2))
    return height


def half(surface: Surface, cells: int, *, upper: bool) -> Block:
    """A unit square between a surface and the plane z = -1 or 2, in triangles, cut crosswise."""
    x, y = np.meshgrid(*2 * [np.linspace(0.0, 1.0, cells + 1)], indexing="ij")
    curved = np.stack([x, y, surface(x, y)], axis=-1).reshape(-1, 3)
    far = curved * (1.0, 1.0, 0.0) + (0.0, 0.0, 2.0 if upper else -1.0)
    at = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    faces: list[tuple[int, ...]] = []
    for i in range(cells):
        for j in range(cells):
            a, b, c, d = (int(k) for k in (at[i, j], at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]))
            alike = (i + j) % 2 == int(upper)
            faces += [(a, b, c), (a, c, d)] if alike else [(a, b, d), (b, c, d)]
    rim = [*at[:-1, 0], *at[-1, :-1], *at[:0:-1, -1], *at[0, :0:-1]]
    n = len(curved)
    faces += [
        (int(a), int(a) + n, int(b) + n, int(b)) for a, b in zip(rim, np.roll(rim, -1), strict=True)
    ]
    faces.append(tuple(int(a) + n for a in rim[::-1]))
    if upper:
        faces = [face[::-1] for face in faces]
    used = sorted({i for face in faces for i in face})
    place = {old: new for new, old in enumerate(used)}
    loops = [tuple(place[i] for i in face) for face in faces]
    return Block(np.concatenate([curved, far])[used], loops, "upper" if upper else "lower")


def joint(surface: Surface, lower: int, upper: int) -> Assembly:
    """Two blocks that share a curved joint."""
    return Assembly((half(surface, lower, upper=False), half(surface, upper, upper=True)))


def curved_area(block: Block) -> float:
    """Area of the triangles of a block."""
    corner = block.vertices[np.array([face for face in block.faces if len(face) == 3])]
    sides = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return float(0.5 * np.linalg.norm(sides, axis=1).sum())


def roller(sides: int, lift: float, *, on_edge: bool = False) -> Assembly:
    """A prism of a regular polygon above a plane, on a face or on an edge."""
    angle = 2.0 * np.pi * (np.arange(sides) + (0.0 if on_edge else 0.5)) / sides - 0.5 * np.pi
    section = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    section[:, 1] += lift - section[:, 1].min()
    base = box((6.0, 6.0, 1.0), (-3.0, -3.0, -1.0), "base")
    lying = prism(section, (-1.0, 1.0), "roller")
    return Assembly((base, lying), np.array([True, False]))


@pytest.mark.parametrize(
    ("surface", "lower", "upper"),
    [(dome, 5, 17), (dome, 8, 11), (egg_crate, 5, 17), (egg_crate, 8, 11), (bump, 10, 10)],
)
def test_surfaces_curved_both_ways_keep_their_area(
    surface: Surface, lower: int, upper: int
) -> None:
    model = joint(surface, lower, upper)
    least = min(curved_area(block) for block in model.blocks)
    found = find_contacts(model, options=EVERY)
    assert found.contacts.area.sum() == pytest.approx(least, rel=0.02)


def test_what_a_curved_joint_lacks_is_told_and_found_with_what_is_suggested() -> None:
    model = joint(bump, 5, 17)
    least = min(curved_area(block) for block in model.blocks)
    found = find_contacts(model, options=EVERY)
    missing = 1.0 - found.contacts.area.sum() / least
    assert missing > 0.1
    (short,) = found.report.shortfalls
    assert short.share == pytest.approx(missing, abs=0.05)
    assert any("curved joint" in line for line in found.report.summary())
    assert any("raise gap" in line and "angle" in line for line in found.report.suggestions())
    wider = DetectionOptions(curve=0.0, gap=1.05 * short.gap, angle=1.05 * short.angle)
    again = find_contacts(model, options=wider)
    assert again.contacts.area.sum() == pytest.approx(least, rel=0.05)
    assert again.report.to_dict()["shortfalls"] == []


@pytest.mark.parametrize("model", [curve_three_blocks(20), cube_curve(strips=18)])
def test_joints_that_are_whole_lack_nothing(model: Assembly) -> None:
    assert find_contacts(model).report.shortfalls == ()


@pytest.mark.parametrize("sides", [12, 24, 64])
def test_curve_beside_a_plane_is_granted_nothing(sides: int) -> None:
    assert find_contacts(roller(sides, 0.0)).contacts.count == 1
    assert find_contacts(roller(sides, 0.03)).contacts.count == 0


def test_roller_on_an_edge_touches_along_a_line() -> None:
    found = find_contacts(roller(24, 0.0, on_edge=True))
    assert found.contacts.count == 1
    assert found.contacts.area.tolist() == [0.0]
    assert len(found.contacts.polygon(0)) == 2


def test_rollers_side_by_side_are_no_curved_joint() -> None:
    one = roller(24, 0.03).blocks[1]
    other = replace_block(one.transformed(translation=(2.03, 0.0, 0.0)), name="other")
    assert find_contacts(Assembly((one, other))).contacts.count == 0


def test_rough_ball_on_a_plane_rolls_away() -> None:
    rng = np.random.default_rng(0)
    point = rng.normal(size=(60, 3))
    point /= np.linalg.norm(point, axis=1)[:, None]
    hull = ConvexHull(point)
    faces = []
    for face in hull.simplices.tolist():
        a, b, c = point[face]
        faces.append(tuple(face if np.cross(b - a, c - a) @ a > 0.0 else face[::-1]))
    ball = Block(point - (0.0, 0.0, point[:, 2].min()), faces, "ball")
    model = Assembly((box((4, 4, 1), (-2, -2, -1), "base"), ball), np.array([True, False]))
    found = find_contacts(model)
    assert found.contacts.area.sum() == 0.0
    assert check(Model(model, found.contacts)).verdict is Verdict.UNSTABLE
