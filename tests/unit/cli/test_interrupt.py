"""Ctrl-C: what is known is told, and what is said about files is true."""

import contextlib
import importlib
import json
import multiprocessing
import os
import signal
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import drystone
from drystone import check, io
from drystone.base.journal import Journal
from drystone.cli import check_command, main
from drystone.cli.waiting import Waiting
from drystone.model import Model
from drystone.models import tower, wall
from drystone.sequence import LocalWorkers
from tests.unit.cli import child

posix = pytest.mark.skipif(os.name == "nt", reason="signals to other processes")


PARTS = ("cli.check_command", "cli.waiting", "limits.inside", "sequence.solving")
"""Modules that every child would load."""


class Child:
    """The program, forked from a process that has loaded it.

    ``code`` replaces a part of it: ``tell`` says where it is, ``wait`` stays there.
    """

    def __init__(self, code: str, *arguments: str) -> None:
        context = multiprocessing.get_context("forkserver")
        parts = (child.__name__, *(f"drystone.{one}" for one in PARTS))
        context.set_forkserver_preload([*parts])
        self.out = Path(tempfile.mkdtemp()) / "stdout"
        told, telling = context.Pipe(duplex=False)
        self.err = os.fdopen(os.dup(told.fileno()), encoding="utf-8")
        given = (code, arguments, str(self.out), telling)
        self.process = context.Process(target=child.program, args=given)
        self.process.start()
        telling.close()

    def ended(self, *when: str, number: int = signal.SIGINT) -> tuple[int | None, str, str]:
        """A signal at each of the words; exit code, stdout, stderr after the last."""
        for words in when:
            for line in self.err:
                if words in line:
                    break
            os.kill(self.process.pid or 0, number)
        with self.err:
            err = self.err.read()
        self.process.join(60.0)
        return self.process.exitcode, self.out.read_text(encoding="utf-8"), err


@posix
@pytest.mark.parametrize("request_to_end", ["SIGINT", "SIGHUP"])
def test_a_wall_that_stands_does_so_before_all_stiffnesses_are_tried(
    tmp_path: Path, request_to_end: str
) -> None:
    model, page = tmp_path / "wall.json", tmp_path / "page.html"
    io.write(wall(4, 6), model)
    code = (
        "from drystone.cli.waiting import Waiting\n"
        "report = Waiting.__call__\n"
        "def held(self, stage, done, total):\n"
        "    report(self, stage, done, total)\n"
        "    if (stage, done) == ('stiffness samples', 3):\n"
        "        tell('third'); wait(lambda: self.interrupted)\n"
        "Waiting.__call__ = held"
    )
    run = Child(code, "check", str(model), "--strict", "--json", "--html", str(page))
    number, out, _ = run.ended("third", number=getattr(signal, request_to_end))
    told = json.loads(out)
    assert number == 130
    assert (told["verdict"], told["stopped"]) == ("stable", "it was interrupted")
    assert 1 <= told["samples"]["standing"] == told["samples"]["tried"] < 5
    assert "it was interrupted before" in told["message"]
    assert told["residuals"]["equilibrium"] < 1e-8
    assert told["files"] == [str(page)]
    assert page.stat().st_size > 10_000


@posix
def test_a_request_to_end_while_files_are_made_keeps_the_verdict(tmp_path: Path) -> None:
    io.write(tower(2), tmp_path / "tower.json")
    code = (
        "import drystone.results.result\n"
        "def joint_table(*given): tell('joints'); wait()\n"
        "drystone.results.result.joint_table = joint_table"
    )
    table = tmp_path / "joints.csv"
    run = Child(code, "check", str(tmp_path / "tower.json"), "--json", "--joints", str(table))
    number, out, _ = run.ended("joints", number=signal.SIGTERM)
    told = json.loads(out)
    assert (number, told["verdict"], told["files"]) == (130, "stable", [])
    assert "interrupted: nothing was written" in told["notes"]
    assert [path.name for path in tmp_path.iterdir()] == ["tower.json"]


@posix
def test_a_request_that_is_ignored_stays_ignored_and_the_others_are_heard(tmp_path: Path) -> None:
    io.write(tower(2), tmp_path / "tower.json")
    code = (
        "import drystone.stability\n"
        "once = drystone.stability.check\n"
        "def check(*model, stop, **more):\n"
        "    signal.raise_signal(signal.SIGHUP)\n"
        "    tell(f'asked {stop()}'); wait(stop); return once(*model, stop=stop, **more)\n"
        "drystone.stability.check = check\n"
        "signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
        "signal.signal(signal.SIGINT, signal.SIG_IGN)"
    )
    run = Child(code, "check", str(tmp_path / "tower.json"))
    number, out, _ = run.ended("asked False", number=signal.SIGTERM)
    assert (number, "it was interrupted" in out) == (130, True)


@posix
def test_the_second_ctrl_c_ends_at_once_with_nothing_written(tmp_path: Path) -> None:
    io.write(tower(2), tmp_path / "tower.json")
    code = (
        "import drystone.stability\n"
        "def check(*model, stop, **more):\n"
        "    tell('first'); wait(stop); tell('second'); wait()\n"
        "drystone.stability.check = check"
    )
    page = str(tmp_path / "page.html")
    run = Child(code, "check", str(tmp_path / "tower.json"), "--html", page)
    assert run.ended("first", "second") == (
        130, "", "drystone: interrupted; nothing was written\n"
    )  # fmt: skip
    assert [path.name for path in tmp_path.iterdir()] == ["tower.json"]


@posix
def test_a_limit_tells_the_bracket_so_far(tmp_path: Path) -> None:
    model = tmp_path / "tower.json"
    io.write(tower(2), model)
    code = (
        "from drystone.limits import inside\n"
        "asked, one = [], inside.one_stiffness\n"
        "def slow(*model, stop, **more):\n"
        "    asked.append(1)\n"
        "    if len(asked) == 3:\n"
        "        tell('third'); wait(stop)\n"
        "    return one(*model, stop=stop, **more)\n"
        "inside.one_stiffness = slow"
    )
    run = Child(code, "limit", "tilt", str(model), "--scan", "8", "--json")
    exit_code, out, err = run.ended("third")
    told = json.loads(out)
    assert (exit_code, err, told["stopped"]) == (130, "", "it was interrupted")
    assert len(told["evaluations"]) == 3
    balanced, rest = told["equilibrium"], told["rest"]
    assert balanced["falls"] - balanced["stands"] < 0.051
    assert rest["stands"] == pytest.approx(balanced["stands"] / 4)
    assert rest["falls"] == balanced["falls"]


@posix
def test_a_limit_of_which_nothing_is_known_yet_has_no_picture_and_says_so(tmp_path: Path) -> None:
    model, page = tmp_path / "tower.json", tmp_path / "page.html"
    io.write(tower(2), model)
    code = (
        "from drystone.limits import inside\n"
        "one = inside.one_stiffness\n"
        "def slow(*model, stop, **more):\n"
        "    tell('first'); wait(stop); return one(*model, stop=stop, **more)\n"
        "inside.one_stiffness = slow"
    )
    run = Child(code, "limit", "load", str(model), "block-1:1kN", "--json", "--html", str(page))
    exit_code, out, err = run.ended("first")
    told = json.loads(out)
    assert (exit_code, err, told["files"]) == (130, "", [])
    assert "interrupted: nothing was written: there is no picture" in told["notes"][-1]
    assert not page.exists()


@posix
def test_a_plan_names_its_checkpoint_and_goes_on_from_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, kept, page = (tmp_path / name for name in ("stack.json", "kept", "plan.html"))
    io.write(tower(5), model)
    code = (
        "from drystone.cli.waiting import UNDER_WAY\n"
        "from drystone.sequence import solving\n"
        "asked, once = [], solving.PartSolver.solve\n"
        "@functools.wraps(once)\n"
        "def slow(*model, **more):\n"
        "    asked.append(1)\n"
        "    if len(asked) == 3:\n"
        "        tell('third'); wait(lambda: UNDER_WAY.get().interrupted)\n"
        "    return once(*model, **more)\n"
        "solving.PartSolver.solve = slow"
    )
    arguments = ["plan", str(model), "--checkpoint", str(kept)]
    run = Child(code, *arguments, "--json", "--html", str(page))
    exit_code, out, _ = run.ended("third")
    told = json.loads(out)
    assert (exit_code, told["stopped"]) == (130, "it was interrupted")
    assert told["ends_with"][-1] == {"blocks": ["block-4"], "propped": []}
    assert told["notes"] == [
        f"'{kept}' keeps what was found, the same command goes on from there; nothing else was "
        "written",
        f"not written: {page}",
    ]
    assert len(kept.read_text().splitlines()) == 1 + 3
    assert not page.exists()
    assert main([*arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["counts"]["free"] == 4


@pytest.mark.parametrize(
    ("words", "kept"),
    [
        ("tune tower --set count=2 --vary edge=0.5:2 --store kept", "kept"),
        ("study tower --set count=2 --set count=3 --out kept.jsonl", "kept.jsonl"),
        ("dataset tower.json --out kept", "kept/orders"),
    ],
)
def test_work_that_is_ended_at_once_names_what_keeps_it(
    words: str,
    kept: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    once = Journal.add

    def ended(self: Journal, records: Any) -> None:
        once(self, records)
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    io.write(drystone.Model.of(tower(3)), "tower.json")
    monkeypatch.setattr(Journal, "add", ended)
    assert main(words.split()) == 130
    assert f"'{Path(kept)}' keeps what was found" in capsys.readouterr().err


@posix
def test_workers_leave_ctrl_c_to_the_one_that_started_them() -> None:
    before = signal.getsignal(signal.SIGINT)
    with LocalWorkers(1)() as executor:
        assert signal.getsignal(signal.SIGINT) is before
        assert executor.submit(signal.getsignal, signal.SIGINT).result() is signal.SIG_IGN


def test_the_first_ctrl_c_asks_and_the_second_raises() -> None:
    before = signal.getsignal(signal.SIGINT)
    with Waiting() as waiting:
        with waiting.stoppable() as stop:
            assert not stop()
            signal.raise_signal(signal.SIGINT)
            assert stop()
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) is before
        assert (waiting.exit_code(0), waiting.exit_code(1)) == (130, 130)


def test_other_threads_and_handlers_are_left_alone() -> None:
    said: list[bool] = []

    def work() -> None:
        with Waiting() as waiting, waiting.stoppable() as stop:
            said.append(stop())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with Waiting() as waiting, waiting.stoppable() as stop:
            signal.raise_signal(signal.SIGINT)
            said.append(stop())
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
    assert said == [False, False]


def test_ctrl_c_while_the_answer_is_printed_names_the_files_that_are_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def pressed(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("drystone.cli.told.Told.show", pressed)
    model, page = tmp_path / "tower.json", tmp_path / "page.html"
    io.write(tower(2), model)
    assert main(["check", str(model), "--html", str(page)]) == 130
    assert capsys.readouterr().err == f"drystone: interrupted; wrote {page}\n"
    assert page.exists()


@pytest.mark.parametrize("as_json", [True, False])
def test_ctrl_c_while_pictures_are_drawn_keeps_the_verdict(
    as_json: bool,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def pressed(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("drystone.view.save_figure", pressed)
    model, page = tmp_path / "tower.json", tmp_path / "page.html"
    io.write(tower(2), model)
    given = ["check", str(model), "--html", str(page), "--png", str(tmp_path / "figure.png")]
    assert main([*given, "--json"] if as_json else given) == 130
    out, err = capsys.readouterr()
    note = "interrupted: nothing was written"
    assert err == ""
    if as_json:
        told = json.loads(out)
        assert (told["verdict"], told["files"], told["notes"]) == ("stable", [], [note])
    else:
        assert out.startswith("STABLE")
        assert note in out
    assert [path.name for path in tmp_path.iterdir()] == ["tower.json"]


def test_an_answer_is_told_although_its_files_cannot_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("drystone.view.save_figure", full)
    model, figure = tmp_path / "tower.json", tmp_path / "figure.png"
    io.write(tower(2), model)
    assert main(["check", str(model), "--png", str(figure), "--json"]) == 2
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert (told["verdict"], told["exit_code"]) == ("stable", 2)
    assert "No space left" in told["error"]["message"]
    assert "figure.png: cannot be written: No space left" in err


@pytest.mark.parametrize("kind", [ImportError, drystone.InputError, RuntimeError])
def test_ctrl_c_that_a_library_turns_into_an_error_of_its_own_is_ctrl_c(
    kind: type[Exception],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def imported(*_: object, **__: object) -> None:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise kind("initialization failed") from error

    model = tmp_path / "tower.json"
    io.write(tower(2), model)
    for module, command in (
        ("stability.check", ["check"]),
        ("limits.inside.one_stiffness", ["limit", "tilt"]),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(f"drystone.{module}", imported)
            assert main([*command, str(model)]) == 130
        assert capsys.readouterr().err == "drystone: interrupted; nothing was written\n"


def test_strict_wants_every_stiffness_tried() -> None:
    pair = tower(2)
    result = check(Model.of(pair))
    stopped = replace(result, stopped="the time was up")
    assert [check_command.exit_code(result, strict) for strict in (False, True)] == [0, 0]
    assert [check_command.exit_code(stopped, strict) for strict in (False, True)] == [0, 1]


@posix
def test_ctrl_c_where_python_drops_errors_is_heard(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in what is called when a value that others watch is freed."""

    class Freed:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGTERM)

    def checked(*_: object, **__: object) -> None:
        Freed()
        for _ in range(3000):  # one long sleep would end before it is heard
            time.sleep(0.01)

    monkeypatch.setattr("drystone.cli.waiting.Waiting.stoppable", contextlib.nullcontext)
    monkeypatch.setattr("drystone.stability.check", checked)
    io.write(tower(2), tmp_path / "tower.json")
    assert main(["check", str(tmp_path / "tower.json")]) == 130
    assert capsys.readouterr().err == "drystone: interrupted; nothing was written\n"


@posix
@pytest.mark.parametrize(("rows", "drawn"), [(0, False), (1, True), (2, True)])
def test_a_study_that_is_cut_short_draws_the_rows_it_has(
    rows: int, drawn: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    module = importlib.import_module("drystone.studies.study")
    answered, known = module._row, iter(range(rows))

    def one(*given: object) -> list[object] | None:
        if next(known, None) is None:
            signal.raise_signal(signal.SIGTERM)
        return answered(*given)

    monkeypatch.setattr(module, "_row", one)
    files = [str(tmp_path / name) for name in ("map.svg", "chart.svg")]
    asked = ["study", "tower", "--set", "count=2:3:2", "--set", "friction=0.6:0.8:2"]
    assert main([*asked, "--map", files[0], "--png", files[1]]) == 130
    out = capsys.readouterr().out
    assert Path(files[0]).exists() == Path(files[1]).exists() == drawn
    assert ("there is no picture: there is no row" in out) != drawn
