"""What ``drystone models`` lists, builds and writes."""

import json
from pathlib import Path
from typing import Any

import pytest

from drystone import io, models
from drystone.cli import main
from drystone.cli.families import family, names, setting

Capsys = pytest.CaptureFixture[str]


def answer(capsys: Capsys, *arguments: str) -> Any:
    assert main(["models", *arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_every_family_is_listed_with_its_parameters(capsys: Capsys) -> None:
    told = {row["family"]: row["parameters"] for row in answer(capsys)["families"]}
    assert {"arch", "vault", "dome", "tower", "ferris-wall"} <= set(told)
    assert not {"box", "prism", "harmonic-offsets"} & set(told)
    assert told["arch"]["voussoirs"] == 36
    assert told["tower"]["count"] == 5


@pytest.mark.parametrize("suffix", ["json", "obj"])
def test_a_family_is_built_with_its_settings_and_written(
    suffix: str, tmp_path: Path, capsys: Capsys
) -> None:
    path = tmp_path / f"arch.{suffix}"
    told = answer(capsys, "arch", "--set", "voussoirs=12", "--out", str(path))
    assert (told["blocks"], told["files"]) == (14, [str(path)])
    written = io.read_file(path).assembly
    built = models.arch(voussoirs=12)
    assert written.names == built.names
    assert written.volume == pytest.approx(built.volume)
    assert ("supports" in told["loses"]) == (suffix == "obj")


def test_values_have_the_types_of_the_parameters() -> None:
    for name, text, value in (
        ("arch", "thickness-ratio=0.2", 0.2),
        ("wall", "size=0.4,0.2,0.1", (0.4, 0.2, 0.1)),
        ("wall", "ground=true", True),
        ("wall", "bond=stack", "stack"),
        ("shelf", "fix=2", 2),
        ("dome", "thickness=0.3", 0.3),
        ("dome", "thickness=0.5,0.3", (0.5, 0.3)),
        ("concave", "length=long", "long"),
    ):
        build, known = family(name)
        key, found = setting(text, known)
        assert found == value
        assert type(found) is type(value)
        build(**{key: found})


def test_every_family_is_built_without_being_told_more(capsys: Capsys) -> None:
    for name in names():
        assert len(family(name)[0]()) > 0
    assert main(["models", "tower"]) == 0
    assert "5 blocks, 1 of them fixed" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["archh"], "there is no family 'archh'; did you mean arch"),
        (["box"], "there is no family 'box'"),
        (
            ["wall", "--set", "bond=english"],
            "--set bond: is 'english'; use one of running, toothed, stack",
        ),
        (["wall", "--set", "ground=yes"], "--set ground: "),
        (["wall", "--set", "size=a,b"], "--set size: length 'a' is not a number"),
        (["segmental-bridge", "--set", "profile=none.csv"], "--set profile: none.csv: there is no"),
        (["arch", "--set", "voussoirs=1.5"], "not a whole number"),
        (["arch", "--set", "colour=1"], "no parameter 'colour'"),
        (["arch", "--out", "arch.doc"], "--out: 'arch.doc' does not end in"),
        (["--set", "voussoirs=3"], "no family is named"),
    ],
)
def test_what_cannot_be_built_is_refused(arguments: list[str], words: str, capsys: Capsys) -> None:
    assert main(["models", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert err.count("\n") == 1
