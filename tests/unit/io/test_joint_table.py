"""Joint tables on disk."""

import csv
import json
from pathlib import Path

import pytest

from drystone import FormatError, solve_rbe
from drystone.io.joint_table import write_joints
from drystone.joints import joint_table
from drystone.models import tower
from drystone.virtual import to_point
from tests.oracle import touching_faces

TOWER = tower(3)
JOINTS = touching_faces(TOWER, 0.6)
TABLE = joint_table(solve_rbe(TOWER, JOINTS), strength=30e3)
WEIGHT = 2400.0 * 9.81


def test_csv_has_units_in_its_header_and_a_row_per_joint(tmp_path: Path) -> None:
    path = tmp_path / "joints.csv"
    write_joints(TABLE, path)
    rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))
    assert [row["block_b"] for row in rows] == ["block-1", "block-2"]
    assert float(rows[0]["normal [N]"]) == pytest.approx(2.0 * WEIGHT)
    assert float(rows[1]["peak_pressure [Pa]"]) == pytest.approx(WEIGHT, rel=1e-5)
    assert [row["over_strength"] for row in rows] == ["True", "False"]


def test_json_has_the_same_rows(tmp_path: Path) -> None:
    path = tmp_path / "joints.json"
    write_joints(TABLE, path)
    content = json.loads(path.read_text(encoding="utf-8"))
    assert content["strength"] == 30e3
    assert content["joints"] == TABLE.rows()
    assert content["units"]["normal"] == "N"


def test_infinite_pressure_is_null_in_json(tmp_path: Path) -> None:
    table = joint_table(solve_rbe(tower(2), to_point(touching_faces(tower(2), 0.6))))
    path = tmp_path / "joints.json"
    write_joints(table, path)
    assert json.loads(path.read_text(encoding="utf-8"))["joints"][0]["peak_pressure"] is None


def test_another_suffix_is_refused_and_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"cannot be written as '\.xls'"):
        write_joints(TABLE, tmp_path / "joints.xls")
    assert list(tmp_path.iterdir()) == []
