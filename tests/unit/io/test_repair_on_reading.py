"""Broken meshes of files, mended on request, and errors that offer it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import FormatError, Verdict, check
from drystone.io import inspect
from drystone.models import box

Mesh = tuple[np.ndarray, list[tuple[int, ...]]]
CUBE = box((1.0, 1.0, 1.0))


def welded(*places: Sequence[float]) -> Mesh:
    """Unit cubes as one mesh with common corners; each keeps all of its faces."""
    points = np.concatenate([CUBE.vertices + np.array(place) for place in places])
    kept, number = np.unique(points.round(9), axis=0, return_inverse=True)
    faces = [
        tuple(int(number.ravel()[8 * k + i]) for i in face)
        for k in range(len(places))
        for face in CUBE.faces
    ]
    return kept, faces


def voxels(*places: Sequence[float]) -> Mesh:
    """The same without the faces between two cubes."""
    points, faces = welded(*places)
    uses = [frozenset(face) for face in faces]
    return points, [face for face in faces if uses.count(frozenset(face)) == 1]


def written(folder: Path, suffix: str, mesh: Mesh) -> Path:
    """A file of one object on a base."""
    points, faces = mesh
    base = box((9.0, 9.0, 1.0), (-4.0, -4.0, -1.0))
    path = folder / f"model{suffix}"
    if suffix == ".json":
        shapes = [("base", base.vertices, base.faces), ("part", points, faces)]
        blocks = [
            {"name": name, "vertices": v.tolist(), "faces": [list(f) for f in loops]}
            for name, v, loops in shapes
        ]
        path.write_text(json.dumps({"blocks": blocks}))
        return path
    lines, first = [], 1
    for name, v, loops in (("base", base.vertices, base.faces), ("part", points, faces)):
        lines += [f"o {name}", *(f"v {x} {y} {z}" for x, y, z in v.tolist())]
        lines += ["f " + " ".join(str(i + first) for i in face) for face in loops]
        first += len(v)
    path.write_text("\n".join(lines) + "\n")
    return path


STACK = ([0, 0, 0], [0, 0, 1], [0, 0, 2])
KNOT = ([0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1])
CORNER = ([0, 0, 0], [1, 0, 0], [1, 0, 1], [1, 1, 1], [0, 1, 1])
"""The last cube and the first meet along an edge, and in the last case so do others."""


def with_a_wall() -> Mesh:
    points, faces = welded([0, 0, 0], [0, 0, 1])
    uses = [frozenset(face) for face in faces]
    twin = next(i for i, use in enumerate(uses) if uses.count(use) == 2)
    return points, [face for i, face in enumerate(faces) if i != twin]


def with_a_joint_on_an_edge() -> Mesh:
    points = np.concatenate([CUBE.vertices, [[0.5, 0.0, 1.0]]])
    faces = list(CUBE.faces)
    for f, face in enumerate(faces):
        at = CUBE.vertices[list(face)]
        if (at[:, 2] == 1.0).all():
            ends = [i for i in range(4) if at[i, 1] == 0.0 and at[(i + 1) % 4, 1] == 0.0]
            faces[f] = (*face[: ends[0] + 1], 8, *face[ends[0] + 1 :])
    return points, faces


MENDED = {
    "welded boxes": (welded(*STACK), 3, 3.0, "split into its 3 parts"),
    "voxels along an edge": (voxels(*KNOT), 1, 5.0, "touched itself parted"),
    "voxels in a ring": (voxels(*CORNER), 1, 5.0, ""),
    "voxels at a corner": (voxels([0, 0, 0], [1, 1, 1]), 2, 2.0, "split into its 2 parts"),
    "a face inside": (with_a_wall(), 1, 2.0, "1 face inside removed"),
    "a plane hole": ((CUBE.vertices, list(CUBE.faces[:1] + CUBE.faces[2:])), 1, 1.0, "hole closed"),
    "a joint on an edge": (with_a_joint_on_an_edge(), 1, 1.0, "1 vertex joined with the edges"),
}


@pytest.mark.parametrize("suffix", [".json", ".obj"])
@pytest.mark.parametrize("kind", MENDED)
def test_broken_meshes_are_mended_on_request_and_said_so(
    tmp_path: Path, kind: str, suffix: str
) -> None:
    mesh, count, volume, told = MENDED[kind]
    file = written(tmp_path, suffix, mesh)
    model = drystone.read(file, repair=True, supports="base")
    assert len(model) == 1 + count
    assert model.assembly.volume[1:].sum() == pytest.approx(volume, rel=1e-5)
    (note,) = [note for note in model.notes if note.startswith("block 'part'")] or [told]
    assert told in note
    assert not told or f"volume {volume:g} m3" in note
    assert model.report is not None
    assert model.report.overlaps == ()
    if len(told):
        with pytest.raises(FormatError, match="--repair would mend it"):
            drystone.read(file)


def test_mended_boxes_stand_on_each_other(tmp_path: Path) -> None:
    file = written(tmp_path, ".obj", welded(*STACK))
    for how in ({"repair": True}, {"split": True}):
        model = drystone.read(file, supports="base", **how)
        assert model.assembly.names == ("base", "part-0", "part-1", "part-2")
        assert check(model).verdict is Verdict.STABLE
        assert model.contacts.count == 3
    with pytest.raises(FormatError, match="--split or --repair would mend it"):
        drystone.read(file)


def test_mended_voxels_stand(tmp_path: Path) -> None:
    file = written(tmp_path, ".json", voxels(*KNOT))
    assert check(drystone.read(file, supports="base", repair=True)).verdict is Verdict.STABLE


def test_a_bent_hole_is_not_closed(tmp_path: Path) -> None:
    bent = (CUBE.vertices, [f for i, f in enumerate(CUBE.faces) if i not in (1, 2)])
    file = written(tmp_path, ".json", bent)
    for repair in (False, True):
        with pytest.raises(FormatError, match="close the holes"):
            drystone.read(file, repair=repair)


def test_inspect_offers_a_repair(tmp_path: Path) -> None:
    file = written(tmp_path, ".obj", voxels(*KNOT))
    (defect,) = inspect(file).defects
    assert "--repair would mend it" in defect.remedy
    assert "touched itself" in defect.remedy
    assert inspect(file, repair=True).defects == ()


def test_sound_meshes_are_left_alone(tmp_path: Path) -> None:
    file = written(tmp_path, ".json", (CUBE.vertices, list(CUBE.faces)))
    model = drystone.read(file, repair=True)
    assert model.notes == drystone.read(file).notes
    assert model.assembly.blocks[1].repairs == ()


def side_by_side(*places: Sequence[float]) -> Mesh:
    """Unit cubes as one mesh, each with corners of its own."""
    points = np.concatenate([CUBE.vertices + np.array(place) for place in places])
    return points, [
        tuple(8 * k + i for i in face) for k in range(len(places)) for face in CUBE.faces
    ]


@pytest.mark.parametrize("suffix", [".json", ".obj"])
@pytest.mark.parametrize(
    ("mesh", "volumes", "split"),
    [
        (side_by_side((0, 0, 0), (1, 1, 0)), [1.0, 1.0], True),  # along an edge
        (side_by_side((0, 0, 0), (1, 1, 1)), [1.0, 1.0], True),  # at a corner
        (side_by_side((0, 0, 0), (0, 0, 1)), [1.0, 1.0], True),  # a face each, inside
        (side_by_side((0, 0, 0), (0.3, 0.2, 1)), [1.0, 1.0], True),  # corners on faces
        (side_by_side((0, 0, 0), (0, 0, 0)), [1.0], False),  # the same twice
    ],
)
def test_parts_that_only_touch_are_mended_on_request(
    tmp_path: Path, suffix: str, mesh: Mesh, volumes: list[float], split: bool
) -> None:
    path = written(tmp_path, suffix, mesh)
    with pytest.raises(FormatError, match=r"(touches itself|is there twice).*--repair would mend"):
        drystone.io.read_file(path)
    mended = drystone.io.read_file(path, repair=True)
    assert [block.volume for block in mended.assembly.blocks[1:]] == pytest.approx(volumes)
    assert any(note.startswith("block 'part': ") for note in mended.notes)
    assert not any("move as one" in note for note in mended.notes)
    if split:
        with pytest.raises(FormatError, match="--split or --repair would mend it"):
            drystone.io.read_file(path)
        apart = drystone.io.read_file(path, split=True)
        assert [block.volume for block in apart.assembly.blocks[1:]] == pytest.approx(volumes)


def test_parts_in_each_other_are_not_offered_a_repair(tmp_path: Path) -> None:
    path = written(tmp_path, ".obj", side_by_side((0, 0, 0), (0.3, 0.2, 0.5)))
    with pytest.raises(FormatError, match="crosses itself") as caught:
        drystone.io.read_file(path)
    assert "--repair" not in str(caught.value)
    assert "--split makes blocks of its 2 parts" in str(caught.value)
    assert len(drystone.io.read_file(path, split=True).assembly) > 1
