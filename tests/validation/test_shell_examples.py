"""The shell examples run, stand, and write what they say."""

import csv
import runpy
from pathlib import Path

import pytest

from drystone import Verdict

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize(("name", "voussoirs"), [("vault", 49), ("dome", 56), ("freeform", 54)])
def test_a_shell_example_stands_and_writes_its_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, voussoirs: int
) -> None:
    result = runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"](tmp_path)
    assert result.verdict is Verdict.STABLE
    assert capsys.readouterr().out.startswith(f"{voussoirs} voussoirs")
    assert (tmp_path / f"{name}.html").stat().st_size > 10_000
    with (tmp_path / f"{name}.csv").open() as file:
        assert len(list(csv.DictReader(file))) == voussoirs


@pytest.mark.parametrize("name", ["vault", "dome", "freeform"])
def test_a_shell_example_is_short(name: str) -> None:
    assert len((EXAMPLES / f"{name}.py").read_text().splitlines()) < 40
