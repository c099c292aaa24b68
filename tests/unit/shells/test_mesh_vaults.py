"""Vaults through an open mesh on several supports."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drystone import InputError
from drystone.base.arrays import Floats
from drystone.cli import main
from drystone.cli.shell_request import SurfaceRequest, surface_of
from drystone.shells import (
    Ground,
    Layout,
    Shape,
    ShellBody,
    build_shell,
    find_form,
    several_supports,
    three_legged_plan,
    vaults_from_mesh,
)
from tests.legged import mesh_of, plans, write_obj

NODES = 9


def legs() -> tuple[Floats, list[list[int]]]:
    """A mesh of a shell on three legs, leg after leg; its seams are not merged."""
    shape = find_form(three_legged_plan(), height=2.5, rows=NODES, columns=NODES).shape
    at = np.linspace(0.0, 1.0, NODES)
    points = [patch.point(at[:, None], at[None, :]).reshape(-1, 3) for patch in shape.patches]
    n = np.arange(NODES**2).reshape(NODES, NODES)
    quads = np.stack([n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]], axis=-1).reshape(-1, 4)
    faces = [quads + k * NODES**2 for k in range(len(points))]
    return np.concatenate(points), np.concatenate(faces).tolist()


def test_the_courses_of_each_vault_are_arches_from_support_to_support() -> None:
    points, faces = legs()
    assert several_supports(points, faces)
    shape, _ = vaults_from_mesh(points, faces)
    assert len(shape.patches) == 3
    feet = {
        round(float(z), 6) for edge in shape.supports for z in shape.points_along(edge, 5)[:, 2]
    }
    assert feet == {0.0}
    shell = build_shell(
        shape, Layout(courses=2, width=2.5), ShellBody(0.2, ground=Ground.SPRINGERS)
    )
    role = {block.name: block.metadata["role"] for block in shell.assembly.blocks}
    for patch in range(3):
        for course in range(2):
            own = sorted(name for name in role if name.startswith(f"p{patch}-c{course:02d}"))
            springers = [name for name in own if role[name] == "springer"]
            assert springers == [own[0], own[-1]]


def test_the_surface_goes_through_the_mesh() -> None:
    points, faces = legs()
    shape, _ = vaults_from_mesh(points, faces)
    at = np.linspace(0.0, 1.0, 81)
    on = np.concatenate([p.point(at[:, None], at[None, :]).reshape(-1, 3) for p in shape.patches])
    apart = [float(np.linalg.norm(on - point, axis=1).min()) for point in points]
    assert max(apart) < 0.1  # the samples are that far apart


def test_open_sides_may_turn_inwards_between_legs() -> None:
    at = range(16)  # three by three squares of five faces, without those at the corners
    inside = [(i, j) for i in at for j in at if i // 5 == 1 or j // 5 == 1]
    inside = [(i, j) for i, j in inside if i < 15 and j < 15]
    x, y = np.meshgrid(np.linspace(-3.0, 3.0, 16), np.linspace(-3.0, 3.0, 16), indexing="ij")
    points = np.stack([x, y, 2.0 - 0.12 * (x**2 + y**2)], axis=-1).reshape(-1, 3)
    loop = (0, 16, 17, 1)
    faces = [[16 * i + j + step for step in loop] for i, j in inside]
    shape, _ = vaults_from_mesh(points, faces)
    feet = np.concatenate([shape.points_along(edge, 5) for edge in shape.supports])
    assert len(shape.patches) == 4
    assert np.abs(feet[:, :2]).max(axis=1) == pytest.approx(3.0, abs=0.01)


def test_corners_that_are_no_ends_of_supports_are_refused() -> None:
    points, faces = legs()
    with pytest.raises(InputError, match=r"3 ends of supports.*two supports or more"):
        vaults_from_mesh(points, faces, corners=[0, NODES - 1, NODES**2])


VAULTS = {"T": 3, "Y": 3, "uneven": 3, "cross": 4, "H": 4, "L": 2}


def grids(shape: Shape) -> Floats:
    """(k, 41, 41, 3) points on each vault."""
    at = np.linspace(0.0, 1.0, 41)
    return np.stack([patch.point(at[:, None], at[None, :]) for patch in shape.patches])


@pytest.mark.parametrize(("name", "triangles"), list(zip(VAULTS, [False, True] * 3, strict=True)))
def test_legs_that_meet_in_a_plan_are_vaults_that_cover_it(name: str, triangles: bool) -> None:
    points, faces, ends = mesh_of(name, triangles=triangles)
    shape, farthest = vaults_from_mesh(points, faces)
    assert len(shape.patches) == VAULTS[name]
    assert farthest < 0.004
    found = np.concatenate([shape.points_along(edge, 2) for edge in shape.supports])
    apart = np.linalg.norm(points[ends][:, None] - found, axis=2).min(axis=1)
    assert apart.max() < 1e-6
    each = grids(shape)[..., :2]
    across, other = each[:, 1:, 1:] - each[:, :-1, :-1], each[:, 1:, :-1] - each[:, :-1, 1:]
    cell = 0.5 * (across[..., 0] * other[..., 1] - across[..., 1] * other[..., 0])
    assert (cell > 0.0).all() or (cell < 0.0).all()  # no fold
    quads = np.array(plans()[name][0])
    first, second = quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]
    legs_area = 0.5 * float((first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum())
    assert np.abs(cell).sum() == pytest.approx(legs_area, rel=0.01)
    named, _ = vaults_from_mesh(points, faces, corners=ends)
    assert_same(grids(named), grids(shape), 1e-9)
    backwards, _ = vaults_from_mesh(points, faces, corners=ends[::-1])
    assert_same(grids(backwards), grids(shape), 1e-9)


def assert_same(one: Floats, other: Floats, within: float) -> None:
    """The same vaults, in any order."""
    gap = np.abs(one[:, None] - other[None]).max(axis=(2, 3, 4))
    assert gap.min(axis=1).max() < within


@pytest.mark.parametrize("name", ["uneven", "H", "L"])
def test_vaults_move_with_their_mesh_and_do_not_know_its_numbers(name: str) -> None:
    points, faces, _ = mesh_of(name, noise=1e-3, triangles=True, rise=5.0)
    made = grids(vaults_from_mesh(points, faces)[0])
    turn = Rotation.from_euler("zx", [40.0, 30.0], degrees=True).as_matrix()
    moved = 0.01 * turn
    grid = grids(vaults_from_mesh(points @ moved.T + [7.0, -3.0, 2.0], faces)[0])
    assert_same(grid, made @ moved.T + [7.0, -3.0, 2.0], 1e-6)
    order = np.random.default_rng(1).permutation(len(points))
    new = np.argsort(order)
    again = [[int(new[i]) for i in face] for face in faces[::-1]]
    assert_same(grids(vaults_from_mesh(points[order], again)[0]), made, 1e-4)


@pytest.mark.parametrize("name", ["Y", "H", "L"])
def test_the_command_builds_a_mesh_of_legs_and_checks_it(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_obj(path := tmp_path / f"{name}.obj", *mesh_of(name, noise=1e-3)[:2])
    stands = name != "L"  # two legs fall outwards where they bend
    assert main(["shell", str(path), "--json"]) == (0 if stands else 1)
    assert ('"verdict": "stable"' in capsys.readouterr().out) is stands


def test_a_mesh_that_overhangs_is_refused() -> None:
    points, faces, _ = mesh_of("T")
    inwards = 3.0 * np.clip(1.0 - points[:, 2], 0.0, 1.0) ** 2
    horseshoe = points - np.sign(points) * [1.0, 0.0, 0.0] * inwards[:, None]
    with pytest.raises(InputError, match=r"overhangs in \d+ faces, .*; cut it"):
        vaults_from_mesh(horseshoe, faces)


def test_four_corners_named_on_a_round_border_are_those_of_one_patch() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    plan = np.concatenate([[[0.0, 0.0]], 0.5 * ring, ring])
    points = np.column_stack([plan, 0.3 * (1.0 - (plan**2).sum(axis=1))])
    inner = [[0, 1 + k, 1 + (k + 1) % 24] for k in range(24)]
    outer = [[1 + k, 25 + k, 25 + (k + 1) % 24, 1 + (k + 1) % 24] for k in range(24)]
    assert not several_supports(points, [*inner, *outer], corners=[25, 31, 37, 43])


def test_the_command_divides_a_mesh_on_several_supports(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    points, faces = legs()
    lines = [f"v {x} {y} {z}" for x, y, z in points.tolist()]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    path = tmp_path / "legs.obj"
    path.write_text("\n".join(lines) + "\n")
    feet = tuple(i for k in range(3) for i in (k * NODES**2, k * NODES**2 + NODES - 1))
    for corners in (None, feet):
        made = surface_of(SurfaceRequest(str(path), corners=corners))
        assert len(made.shape.patches) == 3
        assert made.courses == 4
        assert made.notes == (
            "3 vaults from support to support, one at each open side",
            "the vertices of the mesh are up to 1.1 mm from them",
        )
    named = ",".join(map(str, feet))
    assert main(["shell", str(path), "--corners", named, "--supports", "left"]) == 2
    assert "--supports" in capsys.readouterr().err
    assert main(["shell", str(path), "--corners", "one"]) == 2
    assert main(["shell", "dome", "--corners", "1,2,3,4"]) == 2
