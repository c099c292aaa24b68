"""``drystone reproduce``."""

import json
from types import SimpleNamespace

from drystone.cli import main
from drystone.cli.reproduce_command import _show
from drystone.reproduce.published_case import Line


def test_a_section_prints_published_beside_found(capsys):
    assert main(["reproduce", "6.2"]) == 0
    out = capsys.readouterr().out
    assert "published stable / unstable; found stable / unstable  agrees" in out


def test_a_claim_without_a_published_figure_says_so():
    told = []
    screen = SimpleNamespace(line=lambda text, *_, **__: told.append(text))
    case = SimpleNamespace(title="t", section="1", lines=[Line("a wall", "", "4.2", None)])
    _show([case], screen)
    assert told[1] == "  a wall: no published figure; found 4.2  -"


def test_json_has_the_lines_and_the_files(capsys, tmp_path):
    folder = tmp_path / "new" / "pages"
    assert main(["reproduce", "6.2", "--json", "--out", str(folder)]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["sections"][0]["section"] == "6.2"
    assert all(line["agrees"] for line in data["sections"][0]["lines"])
    assert sorted(data["files"]) == sorted(str(path) for path in folder.iterdir())


def test_an_unknown_section_and_a_file_in_place_of_a_folder_are_bad_input(capsys, tmp_path):
    assert main(["reproduce", "9.9", "--out", str(tmp_path / "new")]) == 2
    assert "7.2.4" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()
    (tmp_path / "file").write_text("")
    assert main(["reproduce", "6.2", "--out", str(tmp_path / "file")]) == 2
    assert "another folder" in capsys.readouterr().err
