"""Load cases stated in parts in a model file."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drystone import FormatError, LoadCase, check, io
from drystone.models import tower

TOWER = tower(2)


def read(tmp_path: Path, *loads: dict[str, Any]) -> tuple[LoadCase, ...]:
    blocks = [
        {
            "name": block.name,
            "vertices": block.vertices.tolist(),
            "faces": [list(face) for face in block.faces],
            "fixed": bool(fixed),
        }
        for block, fixed in zip(TOWER.blocks, TOWER.fixed, strict=True)
    ]
    path = tmp_path / "model.json"
    path.write_text(json.dumps({"blocks": blocks, "loads": list(loads)}))
    return io.read_file(path).loads


def test_parts_add_up_with_their_factors(tmp_path: Path) -> None:
    top = [0.5, 0.5, 2.0]
    load = read(
        tmp_path,
        {
            "name": "design",
            "parts": [
                {"kind": "gravity", "factor": 1.35},
                {"kind": "seismic", "kx": 0.1},
                {"kind": "point", "block": "block-1", "force": [10, 0, 0], "at": top},
                {"kind": "line", "block": 1, "force_per_length": [0, 0, -2], "start": [0, 0.5, 2],
                 "end": [1, 0.5, 2]},
                {"kind": "surface", "block": 1, "pressure": 5.0, "facing": [0, 0, 1]},
                {"kind": "surface", "block": 1, "traction": [0, 3, 0], "faces": [1]},
                {"kind": "moment", "block": 1, "moment": [0, 0, 7], "factor": 2},
                {"kind": "mass", "block": 1, "mass": 100, "at": top},
            ],
        },
    )[0]  # fmt: skip
    expected = LoadCase.combine(
        [
            (1.35, LoadCase.gravity(TOWER)),
            (1.0, LoadCase.seismic(TOWER, 0.1)),
            (1.0, LoadCase.point_load(TOWER, 1, (10, 0, 0), top)),
            (1.0, LoadCase.point_load(TOWER, 1, (0, 3, -7), top)),
            (2.0, LoadCase.moment(TOWER, 1, (0, 0, 7))),
            (1.0, LoadCase.extra_mass(TOWER, 1, 100.0, top)),
        ]
    )
    assert load.name == "design"
    np.testing.assert_allclose(load.wrench, expected.wrench, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ({"kind": "wind"}, r"loads\[0\]\.parts\[0\]\.kind: 'wind' is no load"),
        (
            {"kind": "point", "block": "block-0", "force": [1, 0, 0]},
            r"parts\[0\].*'block-0' is fix",
        ),
        ({"kind": "point", "block": "block-7", "force": [1, 0, 0]}, "no block is called"),
        ({"kind": "point", "block": 1, "force": [10**400, 0, 0]}, "force must be numbers"),
        ({"kind": "surface", "block": 1, "pressure": 1, "faces": [10**400]}, "do not exist"),
        ({"kind": "point", "block": 1, "force": [1, 0]}, r"parts\[0\].*force"),
        ({"kind": "point", "block": 1}, "'force' is missing"),
        ({"kind": "gravity", "mass": 3}, "unknown field 'mass'"),
        ({"kind": "settlement", "block": 0, "motion": [0, 1]}, r"parts\[0\].*3 or 6 numbers"),
        ({"kind": "settlement", "block": 0}, "'motion' is missing"),
        ({"kind": "surface", "block": 1, "faces": [0]}, "either a traction or a pressure"),
        ({"kind": "surface", "block": 1, "pressure": 1, "faces": [9]}, "numbered 0 to 5"),
    ],
)
def test_parts_that_cannot_be_used_are_refused_with_their_place(
    tmp_path: Path, part: dict[str, Any], words: str
) -> None:
    with pytest.raises(FormatError, match=words):
        read(tmp_path, {"parts": [part]})


def test_fill_and_earth_are_parts_in_words(tmp_path: Path) -> None:
    earth = {"kind": "earth", "words": "side=-x,weight=18kN/m3,k=0.5", "factor": 2.0}
    fill = {"kind": "fill", "words": "cover=0.5m,weight=20kN/m3"}
    (load,) = read(tmp_path, {"name": "ground", "parts": [earth, fill]})
    assert load.wrench[1, :3] == pytest.approx([2.0 * 0.5 * 18e3 * 0.5, 0.0, -20e3 * 0.5])
    with pytest.raises(FormatError, match="fill has no weight"):
        read(tmp_path, {"name": "x", "parts": [{"kind": "fill", "words": "cover=1m"}]})


def test_settlements_are_parts_too_and_are_written_and_read_back(tmp_path: Path) -> None:
    part = {"kind": "settlement", "block": "block-0", "motion": [0, 0, -0.01], "factor": 2}
    load = read(tmp_path, {"name": "pier", "parts": [{"kind": "gravity"}, part]})[0]
    assert load.motion is not None
    assert load.motion[0].tolist() == [0.0, 0.0, -0.02, 0.0, 0.0, 0.0]
    path = tmp_path / "loads.json"
    io.write(io.Contents(TOWER, None, (load, LoadCase.gravity(TOWER)), ()), path)
    again = io.read_file(path).loads
    assert np.array_equal(again[0].motion, load.motion)
    assert again[1].motion is None
    with pytest.raises(FormatError, match="both a motion and parts"):
        read(tmp_path, {"motion": load.motion.tolist(), "parts": [part]})


def test_a_load_case_is_stated_in_one_way(tmp_path: Path) -> None:
    wrench = np.zeros((2, 6)).tolist()
    with pytest.raises(FormatError, match="both a wrench and parts"):
        read(tmp_path, {"wrench": wrench, "parts": [{"kind": "gravity"}]})
    with pytest.raises(FormatError, match="has no parts"):
        read(tmp_path, {"parts": []})


def test_a_part_of_our_json_is_a_load_in_words() -> None:
    part = {"kind": "line", "block": 1, "force_per_length": [0, 0, -5], "start": [0, 0, 2],
            "end": [1, 0, 2]}  # fmt: skip
    asked = check(TOWER, load=json.dumps(part)).model.load
    line = LoadCase.line_load(TOWER, 1, (0, 0, -5), (0, 0, 2), (1, 0, 2))
    assert np.array_equal(asked.wrench, (LoadCase.gravity(TOWER) + line).wrench)
    with pytest.raises(FormatError, match="'lines' is no load"):
        check(TOWER, load=json.dumps(part | {"kind": "lines"}))
