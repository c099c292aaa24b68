"""A full disk is told with the file, in one line, by every command that writes; nothing is left."""

import os
import shutil
from collections import Counter
from collections.abc import Iterator
from io import BytesIO
from itertools import groupby
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from benchmarks import interrupted
from benchmarks.interrupted import Case
from drystone import FormatError
from drystone.cli import main
from drystone.models import tower
from drystone.report.document import Picture
from drystone.view import save_figure


def chosen() -> list[Case]:
    """Each command with a file that fewest have been asked of before, and each option of one."""
    asked: Counter[str] = Counter()
    some: list[Case] = []
    more: list[Case] = []
    for _, group in groupby(interrupted.cases(every_suffix=False), lambda case: case.command):
        one, *others = sorted(group, key=lambda case: (not case.is_journal, asked[case.option]))
        asked[one.option] += 1
        some.append(one)
        more += others
    return [*some, *(case for case in more if not asked[case.option])]


CASES = chosen()
"""All are run by ``python -m benchmarks.interrupted disks``."""
NEEDS = {"fall": "mujoco"}
"""Packages without which a command refuses its work."""


def name_of(case: Case) -> str:
    """A command and what it writes."""
    return f"{case.command} {case.option}"


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with the models that the commands are asked about."""
    folder = tmp_path_factory.mktemp("work")
    interrupted.models_in(folder)
    before = Path.cwd()
    os.chdir(folder)
    yield folder
    os.chdir(before)


@pytest.fixture(scope="module")
def dot() -> Picture:
    """A small picture in place of those of reports."""
    made = BytesIO()
    Figure(figsize=(1, 1)).savefig(made, format="png", dpi=8)
    return Picture(made.getvalue(), (8, 8), "a dot")


def test_every_command_that_writes_is_among_them() -> None:
    writing = {
        name for name, one in interrupted.commands().items() if interrupted.files_of(name, one)
    }
    assert {case.command for case in CASES} == writing
    assert len(interrupted.cases()) > 90


def test_the_help_calls_no_other_option_a_file() -> None:
    for name, one in interrupted.commands().items():
        known = {param.name for param, _ in interrupted.files_of(name, one)}
        for param in one.params:
            told = str(getattr(param, "help", "") or "")
            writes = told.startswith(("Write ", "Draw ")) and not getattr(param, "is_flag", False)
            assert not writes or param.name in known, f"{name} {param.name}: use kinds.target"


def test_a_disk_that_is_full_in_the_middle_of_a_pdf_is_told_as_one(tmp_path: Path) -> None:
    figure = tmp_path / "tower.pdf"
    with (
        interrupted.small_files(tmp_path, interrupted.PAGE),
        pytest.raises(FormatError, match=r"tower\.pdf: cannot be written: File too large"),
    ):
        save_figure(tower(2), figure, size=(3, 2))
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize("case", CASES, ids=name_of)
def test_a_full_disk_is_told_with_the_file_and_nothing_is_left(
    case: Case,
    work: Path,
    dot: Picture,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    blank = Figure(figsize=(1, 1))  # what is drawn does not matter, and takes long
    for room in ("view.figure", "report.sketches"):
        monkeypatch.setattr(f"drystone.{room}.draw", lambda *_, **__: blank)
    monkeypatch.setattr("drystone.report.sketches._picture", lambda *_: dot)
    if case.command in NEEDS:
        pytest.importorskip(NEEDS[case.command])
    disk = work / "disk"
    shutil.rmtree(disk, ignore_errors=True)
    disk.mkdir()
    if "." in case.name and not case.is_journal:
        (disk / case.name).write_bytes(interrupted.OLD)
    before = interrupted.tree(disk)
    with interrupted.small_files(disk, 0):
        code = main(case.words)
    told = capsys.readouterr().err
    assert interrupted.left_by(case, code, told, before, disk) == ""
    assert code == 2
