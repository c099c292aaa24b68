"""What stands still may be an open surface, or a plane of ground."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import InputError, Model, Verdict, check
from drystone.assembly import Assembly
from drystone.models import box, tower
from drystone.supports import GroundPlane

STONES = (box((1.0, 1.0, 0.5), name="b1"), box((1.0, 1.0, 0.5), (0.2, 0.0, 0.5), "b2"))
FLOOR = [[-0.5, -0.5, 0.0], [2.0, -0.5, 0.0], [2.0, 1.5, 0.0], [-0.5, 1.5, 0.0]]


def written(path: Path, name: str, vertices: list, faces: list, *, fixed: bool = True) -> Path:
    """A file with an open surface and two stones on it."""
    stones = [{"name": b.name, "vertices": b.vertices.tolist(), "faces": b.faces} for b in STONES]
    surface = {"name": name, "vertices": vertices, "faces": faces, "fixed": fixed}
    path.write_text(json.dumps({"blocks": [surface, *stones]}))
    return path


def terrain() -> tuple[list, list]:
    """A field of heights of 8 by 8 squares, cut into triangles, level under the stones."""
    step = np.linspace(-2.0, 2.0, 9)
    bump = [
        [x, y, 0.0 if max(abs(x - 0.5), abs(y - 0.5)) < 1.6 else 0.3 * np.sin(3 * x + y)]
        for x in step
        for y in step
    ]
    faces = []
    for i in range(8):
        for j in range(8):
            a = 9 * i + j
            faces += [[a, a + 9, a + 10], [a, a + 10, a + 1]]
    return bump, faces


@pytest.mark.parametrize("turned", [False, True])
def test_one_face_holds_a_stack(tmp_path: Path, turned: bool) -> None:
    face = [0, 1, 2, 3][:: -1 if turned else 1]
    model = drystone.read(written(tmp_path / "one.json", "ground", FLOOR, [face]))
    assert check(model).verdict is Verdict.STABLE
    assert model.contacts.count == 2
    assert any("'ground': an open surface backed by" in note for note in model.notes)


def test_a_terrain_holds_a_stack(tmp_path: Path) -> None:
    model = drystone.read(written(tmp_path / "terrain.json", "terrain", *terrain()))
    assert check(model).verdict is Verdict.STABLE
    assert model.report is not None
    assert model.report.overlaps == ()


@pytest.mark.parametrize("supports", ["lowest", "ter*", "b2, terrain", "below:0.1"])
def test_supports_say_that_a_surface_stands_still(tmp_path: Path, supports: str) -> None:
    file = written(tmp_path / "terrain.json", "terrain", *terrain(), fixed=False)
    model = drystone.read(file, supports=supports)
    assert model.assembly.fixed[0]
    assert check(model).verdict is Verdict.STABLE


def test_a_mesh_with_a_hole_holds_a_stack(tmp_path: Path) -> None:
    base = box((2.0, 2.0, 1.0), (-0.5, -0.5, -1.0))
    faces = [f for f in base.faces if base.vertices[list(f)][:, 2].mean() > -1.0]
    file = written(tmp_path / "hole.json", "base", base.vertices.tolist(), faces)
    model = drystone.read(file)
    assert check(model).verdict is Verdict.STABLE
    assert model.assembly.blocks[0].volume == pytest.approx(4.0)


def test_what_moves_has_to_be_closed(tmp_path: Path) -> None:
    file = written(tmp_path / "one.json", "lid", FLOOR, [[0, 1, 2, 3]], fixed=False)
    with pytest.raises(InputError, match="only a support may be open"):
        drystone.read(file)
    with pytest.raises(InputError, match="only a support may be open"):
        drystone.read(file, supports="b1")


@pytest.mark.parametrize("supports", ["ground", "ground:0", "ground: 0mm", GroundPlane()])
def test_a_plane_of_ground_holds_a_tower(supports: str | GroundPlane) -> None:
    model = Model.of(tower(3).with_fixed(()), supports=supports)
    assert model.assembly.names[-1] == "ground"
    assert model.assembly.fixed.tolist() == [False, False, False, True]
    assert check(model).verdict is Verdict.STABLE


def test_a_plane_below_the_tower_holds_nothing() -> None:
    model = Model.of(tower(3).with_fixed(()), supports="ground:-1")
    assert check(model).verdict is Verdict.UNSTABLE


def test_ground_is_where_gravity_points() -> None:
    lying = tower(3).with_fixed(()).transformed(np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]))
    model = Model.of(lying, supports="ground", load=(0.0, 9.81, 0.0))
    assert check(model).verdict is Verdict.STABLE


def test_a_block_called_ground_is_meant_by_its_name() -> None:
    named = Assembly((box((2.0, 2.0, 1.0), name="ground"), box((1.0, 1.0, 1.0), (0, 0, 1.0), "a")))
    assert Model.of(named, supports="ground").assembly.fixed.tolist() == [True, False]
    laid = Model.of(named, supports="ground:0")
    assert laid.assembly.names == ("ground", "a", "ground-plane")
    assert laid.assembly.fixed.tolist() == [False, False, True]


def test_ground_and_names_are_fixed_together() -> None:
    model = Model.of(tower(3), supports="block-2, ground")
    assert model.assembly.fixed.tolist() == [False, False, True, True]
    with pytest.raises(InputError, match="asked for twice"):
        Model.of(tower(3), supports="ground, ground:1")
    with pytest.raises(InputError, match="height '' is not a number"):
        Model.of(tower(3), supports="ground:")


def test_contacts_of_a_file_do_not_know_the_ground(tmp_path: Path) -> None:
    drystone.write(Model.of(tower(3)), tmp_path / "tower.json")
    with pytest.raises(InputError, match="--find-contacts"):
        drystone.read(tmp_path / "tower.json", supports="ground")
    model = drystone.read(tmp_path / "tower.json", supports="ground", search=True)
    assert model.contacts.count == 3


def test_a_support_without_area_is_told_as_such(tmp_path: Path) -> None:
    line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]
    floor = {"name": "floor", "vertices": line, "faces": [[0, 1, 2]], "fixed": True}
    path = tmp_path / "model.json"
    path.write_text(json.dumps({"blocks": [floor]}), encoding="utf-8")
    with pytest.raises(InputError, match="block 'floor': face 0 of its open surface has no area"):
        drystone.read(path)
