"""Tables: columns and rows, files, data frames; and the tables of the joints on disk."""

import csv
import json
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import InputError, Model, limits, solve_rbe
from drystone.base.table import SHOWN, Table
from drystone.models import tower
from drystone.virtual import shrink
from tests.oracle import touching_faces

TOWER = tower(3)
RESULT = solve_rbe(Model(TOWER, touching_faces(TOWER, 0.6)))
JOINTS = RESULT.joints()
WEIGHT = 2400.0 * 9.81
SMALL = Table(
    "boxes", {"box": ["a", "b<c"], "mass": [2.0, np.inf], "at": [None, 3]}, {"mass": "kg"}
)


def test_rows_are_plain_values_and_columns_arrays() -> None:
    assert list(SMALL) == [
        {"box": "a", "mass": 2.0, "at": None},
        {"box": "b<c", "mass": np.inf, "at": 3},
    ]
    assert SMALL["mass"].tolist() == [2.0, np.inf]
    assert len(SMALL) == 2
    assert next(iter(SMALL.take([1])))["box"] == "b<c"
    assert len(Table("empty", {"a": [], "b": []})) == 0


def test_a_table_cannot_be_changed_nor_change_what_it_was_made_of() -> None:
    mass = np.ones(2)
    table = Table("boxes", {"mass": mass})
    mass[0] = 5.0
    assert table["mass"][0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        table["mass"][0] = 5.0
    with pytest.raises(TypeError):
        table.columns["mass"] = mass  # type: ignore[index]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Table("boxes", {"a": [1], "b": [1, 2]}), "'boxes' differ in length"),
        (lambda: Table("boxes", {"a": [1]}, {"b": "m"}), "no column 'b'; there are a"),
        (lambda: SMALL["weight"], "no column 'weight'; there are box, mass, at"),
        (lambda: SMALL.take([0.5]), r"a row is 0\.5"),
    ],
)
def test_what_does_not_fit_is_refused(make, words):  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=words):
        make()


def test_csv_has_units_in_its_header_and_a_row_per_joint(tmp_path: Path) -> None:
    JOINTS.to_csv(tmp_path / "joints.csv")
    rows = list(csv.DictReader((tmp_path / "joints.csv").read_text("utf-8").splitlines()))
    assert [row["block_b"] for row in rows] == ["block-1", "block-2"]
    assert float(rows[0]["normal [N]"]) == pytest.approx(2.0 * WEIGHT)
    assert float(rows[1]["peak_pressure [Pa]"]) == pytest.approx(WEIGHT, rel=1e-5)


def test_a_dictionary_has_the_same_rows_and_the_units() -> None:
    content = json.loads(json.dumps(JOINTS.to_dict(), allow_nan=False))
    assert content["rows"] == list(JOINTS)
    assert content["units"]["normal"] == "N"


def test_infinite_pressure_is_none_in_a_dictionary() -> None:
    hinged = solve_rbe(Model(tower(2), shrink(touching_faces(tower(2), 0.6), 0.0))).joints()
    assert hinged["peak_pressure"].tolist() == [np.inf]
    assert hinged.to_dict()["rows"][0]["peak_pressure"] is None


def test_a_data_frame_has_the_same_columns_and_can_be_changed() -> None:
    pandas = pytest.importorskip("pandas")
    frame = JOINTS.to_pandas()
    assert list(frame.columns) == list(JOINTS.columns)
    assert frame["normal"].tolist() == JOINTS["normal"].tolist()
    assert frame.attrs["units"]["normal"] == "N"
    frame.loc[0, "normal"] = 0.0
    assert JOINTS["normal"][0] > 0.0
    assert isinstance(SMALL.to_pandas(), pandas.DataFrame)


def test_without_pandas_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(drystone.MissingDependency, match=r"\.\[pandas\]"):
        SMALL.to_pandas()


def test_the_package_imports_no_pandas() -> None:
    code = "import sys, drystone.base.table; print('pandas' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_a_notebook_shows_names_as_text_and_the_first_rows() -> None:
    shown = SMALL._repr_html_()
    assert "<th>mass [kg]</th>" in shown
    assert "<td><bdi>b&lt;c</bdi></td><td><bdi>unlimited</bdi></td><td><bdi>3</bdi></td>" in shown
    many = Table("many", {"i": range(SHOWN + 5)})._repr_html_()
    assert many.count("<tr>") == SHOWN + 1
    assert "and 5 more" in many


def test_the_force_on_the_upper_block_balances_its_weight() -> None:
    top = list(JOINTS)[1]
    force = [top[f"force_{axis}"] for axis in "xyz"]
    assert force == pytest.approx([0.0, 0.0, WEIGHT], abs=1e-3)
    assert [top[axis] for axis in "xyz"] == pytest.approx([0.5, 0.5, 2.0], abs=1e-6)


def test_limits_tell_what_was_tried_in_a_table() -> None:
    limit = limits.limit_tilt(tower(2), options=limits.LimitOptions(width=5.0, scan=1), upper=45.0)
    table = limit.table()
    assert table.units == {"value": "deg"}
    assert table["value"].tolist() == sorted(one.value for one in limit.evaluations)
    assert table["value"][-1] == limit.rest.stands
    assert set(table["verdict"]) == {"stable"}
    sweep = limits.tilt_sweep(tower(2), 2, options=limits.LimitOptions(width=5.0, scan=1))
    assert sweep.table()["azimuth"].tolist() == [0.0, 180.0]
    assert np.array_equal(sweep.table()["rest"], sweep.rest)


def test_the_contact_search_tells_its_interfaces_in_a_table() -> None:
    table = drystone.find_contacts(tower(3)).report.table()
    assert table["block_a"].tolist() == ["block-0", "block-1"]
    assert table["kind"].tolist() == ["area", "area"]
    assert table["area"] == pytest.approx([1.0, 1.0])


def test_readers_of_arrow_take_a_table_as_it_is() -> None:
    pyarrow = pytest.importorskip("pyarrow")
    found = pyarrow.table(SMALL)
    assert found.column_names == ["box", "mass [kg]", "at"]
    assert found.to_pylist()[0] == {"box": "a", "mass [kg]": 2.0, "at": None}
    assert pyarrow.table(JOINTS).num_rows == len(JOINTS)


def test_the_package_for_arrow_is_named_where_it_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(drystone.MissingDependency, match=r"\.\[arrow\]"):
        SMALL.__arrow_c_stream__()


def test_bounds_are_rounded_to_their_safe_side_for_people_and_kept_whole_for_programs() -> None:
    columns = {
        "carries": [1.44189, np.inf, np.nan],
        "needs": [0.56211, 0.1, 0.0],
        "push": [1239.0] * 3,
    }
    table = Table("limits", columns, {"needs": "1", "push": "N"},
                  {"carries": False, "needs": True, "push": False})  # fmt: skip
    shown = [
        ["1.441", "56.3%", "1.23 kN"],
        ["unlimited", "10.0%", "1.23 kN"],
        ["-", "0.0%", "1.23 kN"],
    ]
    for one in (table, table.take([0, 1, 2]), pickle.loads(pickle.dumps(table))):
        assert one.cells()[1] == shown
        assert one["carries"][0] == 1.44189
    assert Table("limits", columns).cells()[1][0] == ["1.442", "0.5621", "1239"]


def test_places_far_from_the_origin_are_told_to_the_millimetre() -> None:
    table = Table(
        "blocks", {"centroid": [(0.5, 0.55, 101.2), (1.0005, 2.0, 3.25)]}, {"centroid": "m"}
    )
    assert table.cells()[1] == [["0.5, 0.55, 101.2 m"], ["1, 2, 3.25 m"]]


def test_words_on_paper_have_more_room_than_names() -> None:
    factors = "1.35 tail + 1.35 beam + 0.9 head + 1.5 live + 0.75 snow + 0.9 wind"
    table = Table("combinations", {"block": ["stone of stone " * 7], "factors": [factors]})
    ((name, told),) = table.printed()[1]
    assert (len(name), told) == (60, factors)
