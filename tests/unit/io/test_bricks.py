"""Bricks: LDraw models, lists of BrickGPT and StableLego. Stud joints are held in validation."""

import json
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import FormatError, Verdict, check, io

UPRIGHT = "1 0 0 0 1 0 0 0 1"
CROSSWISE = "0 0 1 0 1 0 -1 0 0"


def read(folder: Path, text: str, name: str = "model.ldr") -> drystone.Model:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return drystone.read(path)


def pairs(model: drystone.Model) -> list[tuple[int, int]]:
    contacts = model.contacts
    return list(zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True))


def test_two_bricks_of_ldraw_stand_on_their_studs(tmp_path: Path) -> None:
    text = f"0 two\n1 4 0 0 0 {UPRIGHT} 3001.dat\n1 4 40 -24 0 {UPRIGHT} 3001.dat\n"
    model = read(tmp_path, text)
    assert model.assembly.names == ("brick-000", "brick-001", "ground")
    low, high = model.assembly.bounds[1]
    assert high - low == pytest.approx([0.032, 0.016, 0.0096])
    assert low == pytest.approx([0.016, 0.0, 0.0096])
    assert pairs(model).count((0, 1)) == 4
    assert check(model).verdict is Verdict.STABLE


def test_plates_are_a_third_as_high_and_turned_parts_lie_crosswise(tmp_path: Path) -> None:
    lines = [
        f"1 4 0 0 0 {UPRIGHT} 3020.dat",
        f"1 4 0 -8 0 {CROSSWISE} 3020.dat",
        f"1 4 0 -32 0 {UPRIGHT} 3003P01.DAT",
        f"1 4 40 -24 0 {UPRIGHT} 3003.dat",  # beside the plate crosswise and the brick on it
    ]
    model = read(tmp_path, "\n".join(lines))
    size = model.assembly.bounds[:3, 1] - model.assembly.bounds[:3, 0]
    assert size == pytest.approx(
        np.array([[0.032, 0.016, 0.0032], [0.016, 0.032, 0.0032], [0.016, 0.016, 0.0096]])
    )
    assert pairs(model).count((1, 2)) == 4
    sides = model.contacts.capacity.tension == 0.0
    area = dict.fromkeys([(1, 3), (2, 3)], 0.0)
    for pair, one, side in zip(pairs(model), model.contacts.area, sides, strict=True):
        if side:
            area[pair] += one
    assert area == pytest.approx({(1, 3): 0.016 * 0.0032, (2, 3): 0.016 * 0.0064})


def test_models_of_a_file_use_each_other(tmp_path: Path) -> None:
    column = "0 FILE Column.ldr\n" + "".join(
        f"1 4 0 {-24 * i} 0 {UPRIGHT} 3003.dat\n0 STEP\n" for i in range(3)
    )
    main = "0 FILE main.ldr\n" + "".join(
        f"1 16 {x} 0 0 {CROSSWISE} column.ldr\n" for x in (0, 40, 200)
    )
    model = read(
        tmp_path, main + column + "0 NOFILE\nother things\n".replace("other", "0"), "m.mpd"
    )
    assert len(model.assembly) == 10
    assert model.assembly.bounds[:9, 0, 0] == pytest.approx(np.repeat([0.0, 0.016, 0.08], 3))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"1 4 0 0 0 {UPRIGHT} 3062b.dat", "line 1: part '3062b.dat' is not known; plain bricks"),
        (f"1 4 0 0 0 {UPRIGHT} wheel.dat", "part 'wheel.dat' is not known"),
        ("1 4 0 0 0 1 0 0 0 -1 0 0 0 -1 3001.dat", "is not upright"),
        ("1 4 0 0 0 .7 0 .7 0 1 0 -.7 0 .7 3001.dat", "turned by less than a right angle"),
        ("1 4 0 0 0 -1 0 0 0 1 0 0 0 1 3001.dat", "is not upright"),
        (f"1 4 0 0 0 {UPRIGHT} 3001.dat\n1 4 30 -24 0 {UPRIGHT} 3003.dat", "part 2 does not lie"),
        (f"1 4 0 0 0 {UPRIGHT} 3001.dat\n1 4 1e30 -24 0 {UPRIGHT} 3003.dat", "too far away"),
        (f"1 4 0 0 0 {UPRIGHT} 3001.dat\n1 4 20 0 0 {UPRIGHT} 3003.dat", "bricks 0 and 1 are both"),
        ("1 4 0 0 3001.dat", "is no part"),
        ("solid cube", "'solid cube' is not LDraw"),
        ("0 nothing", "holds no brick"),
        (f"0 FILE a\n1 4 0 0 0 {UPRIGHT} a", "model 'a' is in itself"),
    ],
)
def test_what_is_no_brick_is_refused_by_name(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        read(tmp_path, text)


def test_a_plate_of_very_many_studs_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="more than 1,000,000 studs"):
        read(tmp_path, "0 0 0 99999 99999", "model.bricks")


def test_lists_of_public_generators_are_read_as_they_come(tmp_path: Path) -> None:
    text = read(tmp_path, "2x4 (0,0,0)\n4x2 (1,1,1)\n1x8 (0,4,0)\n", "model.txt")
    other = {
        "1": {"brick_id": 2, "x": 0, "y": 0, "z": 0, "ori": 0},
        "2": {"brick_id": 2, "x": 1, "y": 1, "z": 1, "ori": 1},
        "3": {"brick_id": 4, "x": 0, "y": 4, "z": 0, "ori": 0},
    }
    listed = read(tmp_path, json.dumps(other), "model.json")
    own = read(tmp_path, "0 0 0 2 4\n1 1 1 4 2\n0 4 0 1 8\n", "model.bricks")
    for one in (text, listed):
        assert np.array_equal(one.assembly.bounds, own.assembly.bounds)
        assert pairs(one) == pairs(own)
    other["2"]["brick_id"] = 99
    with pytest.raises(FormatError, match=r"2\.brick_id: 99 is no brick"):
        read(tmp_path, json.dumps(other), "model.json")


def test_a_text_beside_the_models_of_a_folder_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "readme.txt").write_text("what these are", encoding="utf-8")
    (tmp_path / "a.bricks").write_text("0 0 0 2 4", encoding="utf-8")
    assert io.read_file(tmp_path).assembly.names == ("brick-000", "ground")
