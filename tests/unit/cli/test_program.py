"""The program as a whole: help, version, exit codes of what goes wrong inside, quick start."""

import io as text_io
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import drystone
from drystone.base.errors import MissingDependency
from drystone.base.version import commit
from drystone.cli import application, main, output
from drystone.cli.waiting import Waiting

HEAVY = ("matplotlib", "PIL", "starlette", "fastapi", "uvicorn", "rhino3dm", "trimesh", "compas")
"""Plotting, app and CAD packages."""


def imported(statement: str) -> set[str]:
    """Top-level modules in a fresh interpreter after a statement."""
    code = f"import sys\n{statement}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(run.stdout.split())


def test_importing_drystone_imports_no_plotting_app_or_cad_package() -> None:
    names = imported("import drystone")
    assert not names & {*HEAVY, "click", "rich"}


def test_importing_drystone_takes_less_than_half_a_second() -> None:
    statement = "import time; t = time.perf_counter(); import drystone; t = time.perf_counter() - t"
    best = float("inf")
    for _ in range(5):  # the best of several: other work on the machine only makes it slower
        code = f"{statement}; print(t)"
        run = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        )
        best = min(best, float(run.stdout))
        if best < 0.5:
            break
    assert best < 0.5


def test_help_imports_no_numerical_package() -> None:
    names = imported("from drystone.cli import main; main(['--help'])")
    assert not names & {*HEAVY, "scipy", "shapely", "clarabel", "highspy"}


def test_drystone_runs_as_a_module() -> None:
    run = subprocess.run(
        [sys.executable, "-m", "drystone", "--version"], capture_output=True, text=True, check=True
    )
    assert run.stdout.split()[:2] == ["drystone", drystone.__version__]


def test_without_arguments_the_help_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert "check" in capsys.readouterr().out


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A program whose only command raises what it is given."""

    def make(error: BaseException) -> None:
        def command(**_: Any) -> int:
            raise error

        monkeypatch.setattr(application.app, "main", command)

    return make


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (MissingDependency("rhino3dm", extra="cad", purpose="reading 3dm"), 3, ".[cad]"),
        (KeyboardInterrupt(), 130, "interrupted; nothing was written"),
        (PermissionError(13, "Permission denied", "x.html"), 2, "Permission denied"),
        (
            MemoryError("Unable to allocate 40. GiB"),
            2,
            "the memory was used up: Unable to allocate",
        ),
        (MemoryError(), 2, "the memory was used up; take fewer blocks"),
        (ImportError("x.so: failed to map segment"), 2, "the memory was used up: x.so"),
        (ZeroDivisionError("division\nby zero"), 70, "please report it: ZeroDivisionError"),
    ],
)
def test_each_kind_of_error_has_its_exit_code_and_one_line(
    failing: Any, error: BaseException, code: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    failing(error)
    assert main(["check", "--json"]) == code
    out, err = capsys.readouterr()
    assert words in err
    assert err.count("\n") == 1
    assert json.loads(out)["exit_code"] == code


@pytest.mark.parametrize("error", [BrokenPipeError(), SystemExit(1)], ids=["ours", "of rich"])
def test_a_reader_that_goes_away_is_not_told_that_it_falls(
    failing: Any, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    monkeypatch.setattr(sys, "stdout", sys.stdout)  # to be set back
    failing(error)
    assert main(["check"]) == 141
    sys.stdout.close()  # it goes nowhere now


def test_bad_input_has_its_exit_code_where_stderr_is_full(monkeypatch: pytest.MonkeyPatch) -> None:
    class Full(text_io.StringIO):
        def write(self, _: str) -> int:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(sys, "stderr", Full())
    assert main(["check", "nowhere.json"]) == 2
    sys.stderr.close()  # it goes nowhere now


def test_numbers_that_json_does_not_know_become_null(capsys: pytest.CaptureFixture[str]) -> None:
    output.emit({"a": [float("inf"), float("nan"), 1.0], "b": {"c": (1, None)}})
    assert json.loads(capsys.readouterr().out) == {"a": [None, None, 1.0], "b": {"c": [1, None]}}


def test_nothing_is_drawn_where_stderr_is_no_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("drystone.cli.waiting.PATIENCE", 0.0)
    with Waiting() as waiting:
        waiting.stage("solve", "solving")
        waiting("solving", 1, 2)
    assert capsys.readouterr() == ("", "")
    assert set(waiting.time_s) == {"solve"}


def test_a_bar_is_drawn_on_a_terminal_once_patience_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Terminal(text_io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr("drystone.cli.waiting.PATIENCE", 0.0)
    with Waiting() as waiting:
        waiting.stage("solve", "solving the vault")
        assert waiting.shown.wait(10.0)
        waiting("solving the vault", 1, 2)
    assert "solving the vault" in terminal.getvalue()


def test_the_time_of_a_stage_that_fails_is_kept() -> None:
    waiting = Waiting()

    def work() -> None:
        with waiting:
            waiting.stage("solve", "solving")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        work()
    assert set(waiting.time_s) == {"solve"}


def test_the_version_is_told_with_the_commit(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    record = tmp_path / "_commit.txt"
    record.write_text("0123456789\n", encoding="ascii")
    monkeypatch.setattr("drystone.base.version.RECORD", record)
    commit.cache_clear()
    try:
        assert main(["--version"]) == 0
    finally:
        commit.cache_clear()
    assert capsys.readouterr().out == f"drystone {drystone.__version__} (0123456789)\n"


def test_the_version_is_told_without_numpy() -> None:
    code = (
        "import sys; from drystone.cli import main\n"
        "try: main(['--version'])\n"
        "finally: sys.exit('numpy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_slow_command_says_in_a_pipe_what_it_does(monkeypatch: pytest.MonkeyPatch) -> None:
    for patience, told in ((0.0, "drystone: mending ...\n"), (60.0, "")):
        said = text_io.StringIO()
        monkeypatch.setattr("drystone.cli.waiting.PATIENCE", patience)
        monkeypatch.setattr(sys, "stderr", said)
        monkeypatch.setattr(sys, "__stderr__", said)
        with Waiting() as waiting:
            waiting.stage("mend", "mending")
            wait_for(said, told)
        assert said.getvalue().endswith(told)
        assert bool(said.getvalue()) == bool(told)


def wait_for(said: text_io.StringIO, words: str) -> None:
    end = time.monotonic() + 10.0
    while words not in said.getvalue() and time.monotonic() < end:
        time.sleep(0.005)


def test_a_program_that_starts_slowly_says_so_and_goes_on_with_what_it_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    said = text_io.StringIO()
    for name in ("stderr", "__stderr__"):
        monkeypatch.setattr(sys, name, said)
    monkeypatch.setattr("drystone.cli.waiting.PATIENCE", 0.0)

    begin = application.app.main

    def slow(*given: Any, **named: Any) -> Any:
        wait_for(said, "starting")  # imports that take long
        return begin(*given, **named)

    monkeypatch.setattr(application.app, "main", slow)
    assert main(["check", "a.json"]) == 2
    assert said.getvalue().startswith("drystone: starting ...\ndrystone: reading a.json ...\n")


def test_a_later_stage_that_takes_long_is_told_too(monkeypatch: pytest.MonkeyPatch) -> None:
    said = text_io.StringIO()
    for name in ("stderr", "__stderr__"):
        monkeypatch.setattr(sys, name, said)
    monkeypatch.setattr("drystone.cli.waiting.PATIENCE", 0.01)
    with Waiting() as waiting:
        waiting.stage("read", "reading")
        wait_for(said, "reading ...")
        waiting.stage("solve", "solving")
        wait_for(said, "solving ...")
        waiting.stage("write", "writing")
    assert said.getvalue().splitlines()[-2:] == ["drystone: reading ...", "drystone: solving ..."]


def test_a_stage_that_goes_on_is_told_again_with_how_far_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    said = text_io.StringIO()
    for name in ("stderr", "__stderr__"):
        monkeypatch.setattr(sys, name, said)
    monkeypatch.setattr("drystone.cli.waiting.PATIENCE", 0.01)
    with Waiting() as waiting:
        waiting.stage("mend", "mending")
        wait_for(said, "mending")
        waiting("mends of region 1", 3, 12)
        wait_for(said, "3 of 12")
    assert said.getvalue().splitlines()[-1] == "drystone: mends of region 1, 3 of 12 ..."


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux keeps to such a limit")
@pytest.mark.parametrize(
    ("code", "words"),
    [
        (
            "limit(270000 << 10); from drystone.cli import main; main(['check', 'a.json'])",
            "drystone: 384 MiB of memory are needed to begin",
        ),
        (
            "import numpy as np; from drystone.solvers.threads import one_blas_thread\n"
            "with one_blas_thread():\n"
            "    a = np.ones((99, 99)); b = a.copy()\n"
            "    limit(1 << 20); np.matmul(a, a, out=b); print(b[0, 0], file=sys.stderr)",
            "99.0",
        ),
    ],
    ids=["before it begins", "after an analysis began"],
)
def test_the_library_of_matrices_never_ends_the_process_for_want_of_memory(
    code: str, words: str
) -> None:
    head = "import sys; from resource import *; limit = lambda n: setrlimit(RLIMIT_AS, (n, n))\n"
    run = subprocess.run(
        [sys.executable, "-c", head + code], capture_output=True, text=True, timeout=20
    )
    assert run.stderr.startswith(words)
