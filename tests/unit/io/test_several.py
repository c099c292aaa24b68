"""Folders, patterns and lists of files as one model."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import FormatError, InputError, Verdict, check
from drystone.assembly import Assembly
from drystone.base.units import UNITS
from drystone.models import box, tower


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three stones on each other, one file each."""
    place = tmp_path / "parts"
    place.mkdir()
    for i in range(3):
        stone = box((1.0, 1.0, 0.5), (0.1 * i, 0.0, 0.5 * i), "whatever")
        drystone.write(Assembly((stone,)), place / f"stone-{9 + i}.obj")
    return place


def test_a_folder_is_one_model_whose_blocks_are_named_by_its_files(folder: Path) -> None:
    (folder / "notes.txt").write_text("not a model")
    (folder / ".hidden.obj").write_text("not a model")
    model = drystone.read(folder, supports="lowest")
    assert model.assembly.names == ("stone-9", "stone-10", "stone-11")
    assert model.assembly.fixed.tolist() == [True, False, False]
    assert check(model).verdict is Verdict.STABLE
    assert model.origin.file == str(folder)
    assert model.origin.sha256


def test_patterns_and_lists_choose_files(folder: Path) -> None:
    assert drystone.read(f"{folder}/stone-1?.obj").assembly.names == ("stone-10", "stone-11")
    some = [folder / "stone-11.obj", str(folder / "stone-9.obj")]
    assert drystone.read(some).assembly.names == ("stone-11", "stone-9")
    both = [f"{folder}/stone-1*.obj", folder / "stone-9.obj"]
    assert check(both, supports="stone-9").verdict is Verdict.STABLE


def test_files_of_several_formats_go_together(folder: Path) -> None:
    shutil.move(folder / "stone-10.obj", folder / "aside")
    drystone.write(Assembly((box((1.0, 1.0, 0.5), (0.1, 0.0, 0.5)),)), folder / "middle.stl")
    assert check(drystone.read(folder, supports="lowest")).verdict is Verdict.STABLE


def test_a_file_of_several_blocks_names_them_after_itself(folder: Path) -> None:
    drystone.write(tower(2).transformed(translation=(5.0, 0.0, 0.0)), folder / "tower.obj")
    names = drystone.read(folder).assembly.names
    assert names[-2:] == ("tower.block-0", "tower.block-1")


def test_files_of_one_name_in_two_folders_are_told_apart(folder: Path) -> None:
    other = folder.parent / "others"
    other.mkdir()
    shutil.copy(folder / "stone-10.obj", other / "stone-9.obj")
    files = [folder / "stone-9.obj", other / "stone-9.obj"]
    assert drystone.read(files).assembly.names == ("parts/stone-9", "others/stone-9")
    with pytest.raises(FormatError, match="is given twice"):
        drystone.read([files[0], files[0]])


def test_a_folder_that_is_not_there_is_told_as_such(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="there is no such file or folder"):
        drystone.read(tmp_path / "nowhere")
    with pytest.raises(FormatError, match="there is no such file"):
        drystone.find_poses(tmp_path / "nothing.obj")


def test_files_of_one_name_keep_their_suffix(folder: Path) -> None:
    drystone.write(Assembly((box((1.0, 1.0, 1.0), (3.0, 0.0, 0.0)),)), folder / "stone-9.stl")
    names = drystone.read(folder).assembly.names
    assert {"stone-9.obj", "stone-9.stl", "stone-10"} <= set(names)


def test_one_unit_is_that_of_all_files(folder: Path) -> None:
    model = drystone.read(folder, units="cm")
    assert model.assembly.volume == pytest.approx(0.5 * UNITS["cm"] ** 3)
    # a thousandth of a metre across: whether the unit is right is asked by its name
    assert any("read in mm: is the unit" in one for one in drystone.read(folder, units="mm").notes)


def test_units_that_differ_are_told(folder: Path) -> None:
    drystone.write(Assembly((box((1.0, 1.0, 0.5), (0.0, 0.0, 1.5)),)), folder / "top.json")
    told = [note for note in drystone.read(folder).notes if "units of the files differ" in note]
    assert len(told) == 1
    assert "top.json" in told[0]
    assert "--units" in told[0]
    assert not any("differ" in note for note in drystone.read(folder, units="m").notes)


def test_a_file_of_another_scale_is_told(folder: Path) -> None:
    large = box((1.0, 1.0, 0.5), (0.0, 0.0, 2.0))
    moved = large.transformed(1000.0 * np.eye(3))
    drystone.write(Assembly((moved,)), folder / "large.obj")
    (told,) = [note for note in drystone.read(folder).notes if "units of all files" in note]
    assert "large.obj is 1,000 times larger than the median" in told


def test_two_files_of_different_scale_are_told_with_the_factor(folder: Path) -> None:
    large = box((50.0, 50.0, 50.0), (2.0, 0.0, 0.0))
    drystone.write(Assembly((large,)), folder / "large.obj")
    model = drystone.read([folder / "large.obj", folder / "stone-9.obj"])
    (told,) = [note for note in model.notes if "units of all files" in note]
    assert "large.obj is 50 times larger than the other file" in told
    alike = drystone.read([folder / "stone-10.obj", folder / "stone-9.obj"])
    assert not any("units of all files" in note for note in alike.notes)


@pytest.mark.parametrize("by_shell", [True, False])
def test_materials_and_pictures_are_left_out_and_named(folder: Path, by_shell: bool) -> None:
    for name in ("stone-9.mtl", "granite.jpg"):
        (folder / name).write_text("no model")
    path = [*folder.iterdir()] if by_shell else f"{folder}/*"
    model = drystone.read(path, supports="stone-9")
    assert sorted(model.assembly.names) == ["stone-10", "stone-11", "stone-9"]
    (told,) = [note for note in model.notes if "left out" in note]
    assert told.startswith("2 files that can hold no model left out")
    assert "stone-9.mtl" in told


def test_errors_name_the_file(folder: Path) -> None:
    (folder / "open.obj").write_text("o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(FormatError, match=r"open\.obj line 1 block 'open': has 1 face"):
        drystone.read(folder)


def test_what_holds_no_model_is_refused(tmp_path: Path, folder: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(FormatError, match="holds no model file"):
        drystone.read(tmp_path / "empty")
    with pytest.raises(FormatError, match="no file fits the pattern"):
        drystone.read(f"{folder}/*.stl")
    with pytest.raises(InputError, match="no file is given"):
        drystone.read([])
    with pytest.raises(FormatError, match="there is no such file"):
        drystone.read([folder / "stone-9.obj", folder / "gone.obj"])


def test_a_file_with_contacts_is_read_alone(folder: Path) -> None:
    drystone.write(drystone.Model.of(tower(2)), folder / "tower.json")
    with pytest.raises(FormatError, match="read it alone"):
        drystone.read(folder)
