"""``drystone reproduce``."""

import json
import sys

from drystone.cli import main
from drystone.reproduce import SECTIONS, Case, Line, sections_of


def test_a_section_prints_published_beside_found(capsys):
    assert main(["reproduce", "5.1.1"]) == 0
    out = capsys.readouterr().out
    assert "figures agree  section 5.1.1" in out
    assert "not compared" not in out
    assert "stable / unstable" in out


def test_a_section_without_published_figures_is_not_said_to_agree(capsys, monkeypatch):
    alone = Case("5.1.1", "a shape of ours", (Line("blocks held", "", "4", None),), {})
    monkeypatch.setitem(SECTIONS, "5.1.1", lambda: alone)
    assert main(["reproduce", "5.1.1"]) == 0
    out = capsys.readouterr().out
    assert "no published figure can be compared" in out
    assert "figures agree" not in out
    lines = Line("sides", "3", "3", True), Line("tilt", "9", "8", None, "the shape is ours")
    monkeypatch.setitem(SECTIONS, "5.1.1", lambda: Case("5.1.1", "a shape of ours", lines, {}))
    assert main(["reproduce", "5.1.1"]) == 0
    out = capsys.readouterr().out
    assert "1 of 1 figure agrees, 1 not compared" in out
    assert "note: not compared: tilt: the shape is ours" in out


def test_figures_by_method_have_a_column_each_in_80_columns(capsys, monkeypatch):
    found = "stands to 40.8, falls from 58.1 (check), 180.0 (RBE)"
    tilt = "type-b about x, friction 0.84: tilt"
    line = Line(tilt, "58.7 (3DEC), 58.5 (CRA), 180 (RBE)", found, False, "the ends decide")
    monkeypatch.setitem(SECTIONS, "5.1.1", lambda: Case("5.1.1", "wedges", (line,), {}))
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["reproduce", "5.1.1"]) == 1
    out = capsys.readouterr().out
    row = " ".join(out.splitlines()[-2].split())
    assert row == "type-b about x, friction 0.84 58.7 58.5 180 40.8 to 58.1 180.0 no"
    assert f"note: {tilt}: the ends decide" in out


def test_the_sections_are_listed(capsys):
    assert main(["reproduce"]) == 0
    out = capsys.readouterr().out
    for section in ("5.1.1", "6.2.3", "8.5"):
        assert section in out
    assert "Figures 7.3 and 7.4" in out


def test_a_part_of_the_source_is_all_of_its_sections(capsys):
    assert sections_of("7.5") == ["7.5.1", "7.5.2", "7.5.3"]
    assert main(["reproduce", "5"]) == 0
    assert "section 5.1.1" in capsys.readouterr().out


def test_json_has_the_lines_and_the_files(capsys, tmp_path):
    folder = tmp_path / "new" / "pages"
    assert main(["reproduce", "5.1.1", "--json", "--out", str(folder)]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["sections"][0]["section"] == "5.1.1"
    assert all(line["agrees"] for line in data["sections"][0]["lines"])
    assert sorted(data["files"]) == sorted(str(path) for path in folder.iterdir())


def test_an_unknown_section_and_a_file_in_place_of_a_folder_are_bad_input(capsys, tmp_path):
    assert main(["reproduce", "9.9", "--out", str(tmp_path / "new")]) == 2
    assert "7.2.4" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()
    (tmp_path / "file").write_text("")
    assert main(["reproduce", "5.1.1", "--out", str(tmp_path / "file")]) == 2
    assert "another folder" in capsys.readouterr().err


def test_a_section_that_needs_another_package_is_left_out_of_all(capsys, monkeypatch):
    for section in set(SECTIONS) - {"4.2", "4.5"}:
        monkeypatch.delitem(SECTIONS, section)
    monkeypatch.setitem(sys.modules, "networkx", None)
    assert main(["reproduce", "all"]) == 0
    assert "section 4.5 is left out: the graph needs networkx" in capsys.readouterr().out
    assert main(["reproduce", "4.5"]) == 3
