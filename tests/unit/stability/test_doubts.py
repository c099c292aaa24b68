"""What may not be meant is said before anything is solved, with the option that would settle it."""

from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import io
from drystone.assembly import Assembly
from drystone.cli import main
from drystone.models import box, tower, vault
from drystone.stability.doubts import doubts

Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def options(path: Path, **how: object) -> list[str]:
    model = drystone.read(path, **how)
    return [one.option for one in doubts(model, path, how)]


def written(assembly: Assembly, path: Path) -> Path:
    io.write(assembly, path)
    return path


def test_nothing_is_doubtful_about_a_tower(tmp_path: Path) -> None:
    path = written(tower(3), tmp_path / "tower.obj")
    assert options(path, supports="lowest", friction=0.7) == []


def test_a_load_that_the_case_of_a_file_has_is_asked_for_when_it_is_given_anew(
    tmp_path: Path,
) -> None:
    path = tmp_path / "mended.json"
    io.write(drystone.read(written(tower(3), path), load="block-1:80N", seismic="0.1,0"), path)
    assert options(path) == []
    assert options(path, load="block-2:80N") == []
    assert options(path, load="block-1:0N") == []
    assert options(path, load="block-1:80N") == ["--case weight"]
    assert options(path, load=["block-1:80N", "block-2:80N"]) == ["--case weight"]
    assert options(path, seismic="0.2,0") == ["--case weight"]
    assert options(path, seismic="0.2,0", case="weight") == []


def test_a_friction_above_that_of_stone_may_be_an_angle(tmp_path: Path) -> None:
    path = written(tower(3), tmp_path / "tower.json")
    assert options(path, friction=30.0) == ["--friction 30deg"]
    assert options(path, friction=4) == ["--friction 4deg"]
    for sure in ("30deg", 3.0):  # with 3 hardly anything slides
        assert options(path, friction=sure) == []


@pytest.mark.parametrize(
    ("edge", "option"), [(500.0, ["--units mm"]), (1.0, []), (50.0, ["--units cm"])]
)
def test_blocks_of_an_improbable_size_may_be_in_another_unit(
    tmp_path: Path, edge: float, option: list[str]
) -> None:
    path = written(tower(3, edge=edge), tmp_path / "tower.obj")
    assert options(path, supports="lowest") == option


def test_blocks_that_nearly_touch_are_joined_by_a_wider_gap(tmp_path: Path) -> None:
    blocks = (box((1.0, 1.0, 1.0), name="low"), box((1.0, 1.0, 1.0), (0.0, 0.0, 1.012), name="up"))
    path = written(Assembly(blocks), tmp_path / "apart.obj")
    (option,) = options(path, supports="low")
    assert option.startswith("--gap ")
    gap = option.removeprefix("--gap ")
    joined = drystone.read(path, supports="low", gap=gap)
    assert joined.contacts.count == 1
    assert options(path, supports="low", gap="13mm") == []


def test_a_model_that_stands_on_its_other_side_may_lie(tmp_path: Path) -> None:
    path = written(vault().transformed(Y_UP), tmp_path / "lying.obj")
    assert options(path, supports="lowest") == ["--up y"]
    assert options(path, supports="lowest", up="y") == []
    raw = written(vault().transformed(Y_UP.T), tmp_path / "raw.glb")  # z is up in the file
    assert options(raw, supports="lowest") == ["--up z"]
    assert options(raw, supports="lowest", up="z") == []


def test_what_falls_with_y_up_too_may_lie_if_nothing_presses_on_what_falls(tmp_path: Path) -> None:
    """A table whose top overhangs too far: lying, its legs hang beside the top."""
    blocks = [box((0.4, 1.0, 2.0), (x, 0.0, 0.0), f"leg-{x:g}") for x in (0.0, 1.0)]
    blocks += [box((0.4, 1.0, 0.2), (x, 0.0, 2.0), f"head-{x:g}") for x in (0.0, 1.0)]
    blocks += [box((4.0, 1.4, 0.2), (0.7, -0.2, 2.2), "top")]
    path = written(Assembly(tuple(blocks)).transformed(Y_UP), tmp_path / "lying.obj")
    assert drystone.check(drystone.read(path, supports="lowest", up="y", friction=0.6)).falls
    model = drystone.read(path, supports="lowest")
    (doubt,) = doubts(model, path, {"supports": "lowest"})
    assert doubt.option == "--up y"
    assert "nothing presses on the blocks that fall" in doubt.text


def test_what_is_doubtful_is_asked_in_a_terminal_and_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tower(3), tmp_path / "tower.json")
    asked: list[str] = []

    def answer(_: object, question: str) -> bool:
        asked.append(question)
        return True

    monkeypatch.setattr("drystone.cli.waiting.Waiting.ask", answer)
    assert main(["check", str(path), "--friction", "30"]) == 0
    (question,) = asked
    assert question.endswith("are degrees meant? Use --friction 30deg?")
    out = capsys.readouterr().out
    assert "friction 0.5774" in out
    assert "degrees meant" not in out
    assert main(["check", str(path), "--density", "2.4"]) == 0
    assert asked[1].endswith("is the unit right (--density 2400)? Use --density 2400?")
    assert "density 2400 kg/m" in capsys.readouterr().out


def test_what_nobody_can_be_asked_is_said_with_its_option(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tower(3), tmp_path / "tower.json")
    assert main(["check", str(path), "--friction", "30", "--density", "2.4"]) == 0
    said = capsys.readouterr().err
    assert "are degrees meant? (--friction 30deg)" in said
    assert "is the unit right (--density 2400)?" in said
