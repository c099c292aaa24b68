"""Every text of every command reaches every stdout; what it cannot encode is written escaped."""

import io as text_io
import sys
from pathlib import Path

import pytest

import drystone
from drystone import Assembly
from drystone.cli import main
from drystone.models import tower
from tests.unit.cli.test_command import commands

NAMES = ("\u77f3", "\U0001f9f1", "e\u0301")
MODEL = "\u5854.json"
BLOCK = NAMES[1]
GIVEN: dict[str, list[str]] = {
    "check": [MODEL, "--html", "\u9875.html"],
    "combine": [MODEL, "\u8868.toml"],
    "convert": [MODEL, "\u77f3.obj"],
    "cut": [MODEL, "--block", BLOCK, "--blocks", "2", "--out", "\u5207.json"],
    "dataset": [MODEL, "--rows", "2", "--out", "\u96c6"],
    "fall": [MODEL, "--seismic", "0.4"],
    "inspect": [MODEL],
    "gravity": [MODEL, "--directions", "2"],
    "interlock": [MODEL],
    "kinematic": [MODEL, "--part", BLOCK],
    "limit decay": [MODEL],
    "limit friction": [MODEL],
    "limit imperfections": [MODEL, "--offset", "0.01", "--draws", "2"],
    "limit load": [MODEL, f"{BLOCK}:1kN@0,0,1"],
    "limit shrink": [MODEL],
    "limit strength": [MODEL, "--strength", "9MPa"],
    "forces": [MODEL],
    "limit sweep": [MODEL, "--directions", "1"],
    "limit thrust": [MODEL, NAMES[0]],
    "limit tilt": [MODEL],
    "limit train": [MODEL, "--steps", "2"],
    "live": [MODEL, "--client", "\u5ba2.py"],
    "mcp": ["\u7121"],
    "mend": [MODEL, "--seismic", "0.7", "--kind", "friction"],
    "plan": [MODEL, "--checkpoint", "\u8bb0"],
    "poses": [MODEL, "--block", BLOCK],
    "push": [MODEL, "--to", "0.001"],
    "recut": [MODEL, "--most", "1"],
    "scaffold": [MODEL, "--time-limit", "1"],
    "settle": [MODEL, "--move", f"{NAMES[0]}:0,0,-1", "--to", "0.01"],
    "shape": [MODEL, "--seismic", "0.9", "--time-limit", "1"],
    "report": [MODEL, "--limit", "none", "--out", "\u8868.html"],
    "sharpen": [MODEL, "--seismic", "0.7", "--most", "20"],
    "shell": ["\u7121.obj"],
    "tune": [
        "tower",
        "--set",
        "count=2",
        "--vary",
        "edge=0.5:1",
        "--trials",
        "1",
        "--store",
        "\u8bb0\u5f55",
    ],
}
WITHOUT_NAMES = {"demo", "limit thickness", "models", "reproduce", "study"}
SAYS_NO_NAME = {"tune"}


class Written(text_io.BytesIO):
    """Bytes that can be read after the stream over them is closed."""

    data = b""

    def close(self) -> None:
        self.data = self.getvalue()
        super().close()


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A model whose name and blocks no page of 256 letters has."""
    monkeypatch.chdir(tmp_path)
    blocks = tuple(one.renamed(name) for one, name in zip(tower(3).blocks, NAMES, strict=True))
    drystone.write(drystone.Model.of(Assembly(blocks, tower(3).fixed)), MODEL)


def told(name: str, encoding: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """What a command writes to a standard output of an encoding."""
    written = Written()
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", text_io.TextIOWrapper(written, encoding=encoding))
        patch.setattr(sys, "stderr", text_io.TextIOWrapper(Written(), encoding, "backslashreplace"))
        assert main([*name.split(), *GIVEN[name]]) in (0, 1, 2, 3), name
        sys.stdout.close()
    return written.data.decode(encoding)


def test_every_command_is_here() -> None:
    assert {*GIVEN} | WITHOUT_NAMES == {*commands()}


@pytest.mark.parametrize("name", sorted(GIVEN.keys() - SAYS_NO_NAME))
@pytest.mark.usefixtures("model")
def test_names_that_stdout_cannot_encode_are_written_escaped(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = told(name, "cp1252", monkeypatch)
    assert max(said, default=" ") < "\u2fff"
    assert not said or "\\u" in said.lower()


@pytest.mark.parametrize("name", sorted(SAYS_NO_NAME))
@pytest.mark.usefixtures("model")
def test_what_says_no_name_ends_as_well(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert told(name, "cp1252", monkeypatch)


@pytest.mark.parametrize("encoding", ["ascii", "cp437", "cp1252", "utf-16", "utf-8"])
@pytest.mark.usefixtures("model")
def test_an_encoding_that_has_a_name_writes_it(
    encoding: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = told("inspect", encoding, monkeypatch)
    assert (NAMES[0] in said) == encoding.startswith("utf")
    assert ("\\u" in said) != encoding.startswith("utf")
