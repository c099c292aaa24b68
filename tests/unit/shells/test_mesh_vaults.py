"""Vaults through an open mesh on several supports."""

from pathlib import Path

import numpy as np
import pytest

from drystone import InputError
from drystone.base.arrays import Floats
from drystone.cli import main
from drystone.cli.surfaces import SurfaceRequest, surface_of
from drystone.shells import (
    Ground,
    Layout,
    ShellBody,
    build_shell,
    find_form,
    several_supports,
    three_legged_plan,
    vaults_from_mesh,
)

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
    shape = vaults_from_mesh(points, faces)
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
    shape = vaults_from_mesh(points, faces)
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
    shape = vaults_from_mesh(points, faces)
    feet = np.concatenate([shape.points_along(edge, 5) for edge in shape.supports])
    assert len(shape.patches) == 4
    assert np.abs(feet[:, :2]).max(axis=1) == pytest.approx(3.0, abs=0.01)


def test_corners_that_are_no_ends_of_supports_are_refused() -> None:
    points, faces = legs()
    with pytest.raises(InputError, match=r"4 corners.*three supports or more"):
        vaults_from_mesh(points, faces, corners=[0, NODES - 1, NODES**2, NODES**2 + NODES - 1])


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
        assert made.notes == ("3 vaults from support to support, one at each open side",)
    named = ",".join(map(str, feet))
    assert main(["shell", str(path), "--corners", named, "--supports", "left"]) == 2
    assert "--supports" in capsys.readouterr().err
    assert main(["shell", str(path), "--corners", "one"]) == 2
    assert main(["shell", "dome", "--corners", "1,2,3,4"]) == 2
