"""``drystone interlock`` and ``drystone gravity``."""

import json
from pathlib import Path

import pytest

import drystone
from drystone import Model
from drystone.cli import main
from drystone.models import burr


@pytest.fixture
def puzzle(tmp_path: Path) -> str:
    path = tmp_path / "burr.json"
    drystone.write(Model.of(burr(), friction=0.3), path)
    return str(path)


def test_a_burr_interlocks_with_its_key_and_not_without(
    puzzle: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["interlock", puzzle, "--supports", "x-low,key"]) == 0
    assert capsys.readouterr().out.startswith("Interlocks")
    assert main(["interlock", puzzle, "--supports", "x-low", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["can_move_alone"] == ["key"]


def test_directions_of_gravity_are_answered_with_the_verdict_where_it_is_asked(
    puzzle: str, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["gravity", puzzle, "--supports", "x-low", "--directions", "4", "--json"]
    main(given)
    assert set(json.loads(capsys.readouterr().out)["shares"]) == {"frictionless", "balanced"}
    main([*given, "--stands"])
    assert "stands" in json.loads(capsys.readouterr().out)["shares"]
