"""The live server: verdicts of wishes, two windows, a file that is watched, nothing left behind."""

import json
import multiprocessing
import os
import pickle
import re
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import Assembly, io
from drystone.base.errors import InputError
from drystone.cli import main
from drystone.detection.tolerances import EdgeContacts
from drystone.live import serving
from drystone.live.serving import Live, Watch
from drystone.live.wish import asked, python_lines
from drystone.models import arch, leaning_column, prism
from tests.unit.live.live_client import Window, ask, overhang, wish_of

KEYSTONE = "voussoir-06"


def test_a_wish_has_a_quick_answer_and_then_the_verdict(window: Window) -> None:
    number = window.wish(tilt=2)
    quick = window.until("quick", number)
    assert quick["answer"]["headline"].startswith("Stands with uniform stiffness")
    whole = window.until("whole", number)
    assert whole["answer"]["verdict"] == "stable"
    stage = json.loads(whole["picture"])["stage"]
    lean = np.deg2rad(2.0)
    assert stage["up"] == pytest.approx([-np.sin(lean), 0.0, np.cos(lean)], abs=1e-12)
    assert window.answer(tilt=12)["verdict"] == "unstable"


def test_the_verdict_is_that_of_check_and_friction_gravity_and_pushes_count(
    live: Live, window: Window
) -> None:
    assert window.answer(friction=0.05)["verdict"] == "unstable"
    assert window.answer(gravity=1.62)["verdict"] == "stable"
    push = [{"block": KEYSTONE, "force": [0.0, 0.0, -1e5]}]
    model = io.read(live.desk.file)
    load = model.load + drystone.LoadCase.point_load(model.assembly, KEYSTONE, (0, 0, -1e5))
    assert window.answer(pushes=push)["verdict"] == drystone.check(model, load=load).verdict


def test_a_support_holds_and_a_block_can_be_taken_out_and_put_back(window: Window) -> None:
    names = io.read(window.live.desk.file).assembly.names
    others = [name for name in names if name != KEYSTONE]
    assert window.answer(tilt=12)["verdict"] == "unstable"
    assert window.answer(tilt=12, supports=others)["verdict"] == "stable"
    number = window.wish(removed=[KEYSTONE])
    out = window.until("whole", number)
    assert out["answer"]["verdict"] == "unstable"
    assert KEYSTONE not in out["answer"]["falling"]
    assert window.answer()["verdict"] == "stable"


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="the process cannot be held")
def test_the_newest_wish_ends_the_older_ones(window: Window) -> None:
    process = window.live.desk.helper._process
    os.kill(process.pid, signal.SIGSTOP)  # none is answered before all are asked
    numbers = [window.wish(tilt=tilt) for tilt in (1, 2, 3, 4, 5)]
    os.kill(process.pid, signal.SIGCONT)
    window.until("whole", numbers[-1])
    told = [one["wish"] for one in window.events if one["event"] == "whole"]
    assert told == numbers[-1:]


def test_two_windows_are_both_answered(live: Live, window: Window) -> None:
    other = Window(live, "other")
    numbers = window.wish(tilt=2), other.wish(tilt=12)
    assert other.until("whole", numbers[1])["answer"]["verdict"] == "unstable"
    assert window.until("whole", numbers[0])["answer"]["verdict"] == "stable"
    other.close()


def test_to_the_edge(window: Window) -> None:
    found = window.until("limit", window.task("limit", direction=0.0, friction=0.9))
    assert 8.0 < found["stands"] < found["falls"] < 9.0
    assert window.answer(tilt=found["stands"])["verdict"] == "stable"


def test_load_cases_side_by_side(window: Window) -> None:
    cases = [{"tilt": 2}, {"tilt": 12}, {"removed": ["nobody"]}]
    number = window.task("cases", {"cases": cases})
    window.until("case", number, count=3)
    told = [one for one in window.events if one["event"] == "case"]
    assert [one["verdict"] for one in told] == ["STABLE", "UNSTABLE", ""]
    assert "nobody" in told[2]["headline"]


def test_a_plan_is_played_and_its_order_can_be_checked_again(window: Window) -> None:
    plan = window.until("plan", window.task("plan"))
    order = plan["plan"]["order"]
    assert len(order) == len(arch(0.15, 12).free)
    assert len(json.loads(plan["scene"])["stages"]) > 1
    again = window.until("plan", window.task("plan", {"order": order}))
    assert again["plan"]["order"] == order


def test_the_model_of_a_wish_can_be_saved(window: Window, tmp_path: Path) -> None:
    number = window.task("save", friction=0.4, removed=[KEYSTONE])
    path = tmp_path / "saved.json"
    path.write_text(window.until("saved", number)["text"])
    model = io.read(path)
    assert KEYSTONE not in model.assembly
    assert set(model.contacts.friction) == {0.4}


def test_a_mend_is_shown_made_saved_and_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    io.write(drystone.Model.of(overhang(), friction=0.9), "out.json")
    with Live("out.json", port=0) as live:
        window = Window(live, "mend")
        assert window.answer(tilt=1.0)["verdict"] == "unstable"
        found = window.until("mends", window.task("mends", tilt=1.0))
        assert found["mends"]
        told = [one for one in window.events if one["event"] == "mend"]  # as they were found
        assert [one["number"] for one in told] == list(range(len(told)))
        said = {one["number"]: f"{one['what']} ({one['price']})" for one in found["mends"]}
        assert said == {
            one["number"]: f"{one['mend']['what']} ({one['mend']['price']})" for one in told
        }
        assert all("(cost " in one for one in said.values())  # the cheapest have a margin
        assert any(re.search(r"\(cost .*margin", one) for one in said.values())
        assert all(len(line) == 6 for one in found["mends"] for line in one["ghost"])
        number = window.task("apply", {"mend": 0}, tilt=1.0)
        made = window.until("model", number)
        assert made["state"]["tilt"] == 1.0
        assert made["model"] != live.desk.current
        assert ask(live, f"/model/{made['model']}")[0] == 200
        window.wish(model=made["model"], **made["state"])
        assert window.until("whole", window.number)["answer"]["verdict"] == "stable"

        number = window.task("save", model=made["model"], **made["state"])
        Path("out-model.json").write_text(window.until("saved", number)["text"])
        body = {"window": "mend", "model": made["model"], "wish": made["state"],
                "extra": {"saved": "out-model.json"}}  # fmt: skip
        printed: list[drystone.Result] = []
        exec(ask(live, "/live/python", body)[1]["python"], {"print": printed.append})
        assert printed[0].verdict is drystone.Verdict.STABLE
        kept = pickle.loads(live.desk.models[made["model"]].blob)
        load = asked(kept, wish_of(**made["state"])).part.load  # tilted once, not twice
        np.testing.assert_allclose(printed[0].load.wrench, load.wrench, atol=1e-6)
        window.task("apply", {"mend": 99})
        assert "no such mend" in window.until("error", window.number)["what"]
        window.close()


def test_joints_are_changed_and_a_block_is_cut(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    io.write(drystone.Model.of(leaning_column(blocks=2), friction=0.12), "column.json")
    with Live("column.json", port=0) as live:
        window = Window(live, "joints")
        made = window.until("model", window.task("recut"))
        assert made["what"] == "every block is free: 2 joints changed, 4 changes tried"
        told = window.until("unchanged", window.task("recut", model=made["model"], **made["state"]))
        assert told["message"] == "every block is free: 0 joints changed, 0 changes tried"
        cut = window.until("model", window.task("cut", {"block": "c02-block"}))
        assert cut["what"] == "c02-block cut in two"
        kept = pickle.loads(live.desk.models[cut["model"]].blob)
        assert kept.assembly.names == ("base", "c01-block", "c02-block", "c02-block-part-1")
        lower, upper = (kept.assembly.index(name) for name in kept.assembly.names[2:])
        assert kept.assembly.volume[lower] == pytest.approx(kept.assembly.volume[upper])
        window.task("cut", {"block": "none"})
        assert "none" in window.until("error", window.number)["what"]
        window.close()


def test_a_monolith_is_cut_until_its_blocks_are_free(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    whole = prism([(0, 0), (1, 0), (1.7, 4), (0.7, 4)], (0, 1), "tower")
    io.write(Assembly((whole,), [True]), "tower.json")
    with Live("tower.json", port=0) as live:
        window = Window(live, "monolith")
        made = window.until("model", window.task("recut"))
        assert made["what"] == "every block of 4 is free after 0 recuts"
        kept = pickle.loads(live.desk.models[made["model"]].blob)
        assert kept.assembly.volume.sum() == pytest.approx(whole.volume)
        number = window.task("plan", model=made["model"], **made["state"])
        assert window.until("plan", number)["plan"]["counts"]["free"] == 3
        window.close()


def test_the_python_lines_give_the_same(
    live: Live, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    names = io.read("arch.json").assembly.names
    sent = {
        "tilt": 3.5, "direction": 30.0, "friction": 0.7, "gravity": 5.0, "removed": [names[5]],
        "supports": list(names[:2]), "pushes": [{"block": KEYSTONE, "force": [10.0, 5.0, -1.0]}],
    }  # fmt: skip
    body = {"window": "w", "model": live.desk.current, "wish": sent}
    status, told = ask(live, "/live/python", body)
    assert status == 200
    made: dict[str, object] = {"print": lambda *_: None}
    exec(told["python"], made)
    model = made["model"]
    expected = asked(io.read("arch.json"), wish_of(**sent)).part
    assert isinstance(model, drystone.Model)
    np.testing.assert_allclose(model.load.wrench, expected.load.wrench, rtol=1e-9, atol=1e-9)
    assert (model.contacts.friction == expected.contacts.friction).all()
    assert model.assembly.names == expected.assembly.names
    assert (model.assembly.fixed == expected.assembly.fixed).all()


def test_the_python_lines_read_the_file_with_the_options_of_the_command(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    how = {"edges": EdgeContacts.ALWAYS, "load": None, "friction": 0.6}
    lines = python_lines("arch.json", how, {}, {"gravity": 9.81, "moves": False})["python"]
    made: dict[str, Any] = {"print": lambda *_: None}
    exec(lines, made)
    assert set(made["model"].contacts.friction) == {0.6}


def test_the_load_case_is_one_of_our_json(folder: Path, tmp_path: Path) -> None:
    sent = {"tilt": 6.0, "direction": 90.0, "pushes": [{"block": KEYSTONE, "force": [9.0, 0, 0]}]}
    case = python_lines("arch.json", {}, sent, {"gravity": 9.81, "moves": False})["case"]
    content = json.loads((folder / "arch.json").read_text())
    content["loads"] = [case]
    (tmp_path / "with.json").write_text(json.dumps(content))
    read = io.read(tmp_path / "with.json").load
    expected = asked(io.read(folder / "arch.json"), wish_of(**sent)).part.load
    np.testing.assert_allclose(read.wrench, expected.wrench, rtol=1e-9, atol=1e-6)


def test_a_file_saved_anew_is_read_anew_and_a_broken_one_keeps_the_last_good_one(
    tmp_path: Path,
) -> None:
    path = tmp_path / "model.json"
    io.write(drystone.Model.of(arch(0.15, 12), friction=0.9), path)
    with Live(path, port=0) as live:
        window = Window(live, "watching")
        before = live.desk.current
        path.write_text('{"blocks": [\n {"name": "a",,}]}')
        told = window.until("file", count=2)
        assert "line 2" in told["broken"]["where"]
        assert told["model"] == before
        assert window.answer()["verdict"] == "stable"
        io.write(drystone.Model.of(arch(0.15, 12), friction=0.05), path)
        told = window.until("file", count=3)
        assert (told["broken"], told["model"] > before) == (None, True)
        assert window.answer()["verdict"] == "unstable"
        assert window.answer(model=before)["verdict"] == "stable"  # as undo asks for it
        window.close()


def test_a_model_that_cannot_be_read_is_refused_and_nothing_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "broken.json"
    path.write_text('{"blocks": [')
    before = {thread.name for thread in threading.enumerate()}
    with pytest.raises(InputError) as refused, Live(path, port=0):
        pass
    assert refused.value.where.startswith(str(path))
    monkeypatch.chdir(tmp_path)
    assert main(["live", "broken.json"]) == 2
    assert capsys.readouterr().err.startswith("drystone: broken.json, line 1")
    assert {thread.name for thread in threading.enumerate()} <= before
    with pytest.raises(InputError, match="no such file"):
        Live(tmp_path / "none.json")


def test_a_taken_port_is_passed_over(live: Live, folder: Path, monkeypatch) -> None:
    other = Live(folder / "arch.json", port=live.port)
    try:
        assert live.port < other.port < live.port + serving.PORTS
    finally:
        other.close()
    monkeypatch.setattr(serving, "PORTS", 1)
    with pytest.raises(InputError, match="none of the ports"):
        Live(folder / "arch.json", port=live.port)


def test_it_ends_after_its_last_window_was_closed_and_leaves_nothing(folder: Path) -> None:
    live = Live(folder / "arch.json", port=0)
    began = threading.Event()
    ended = threading.Thread(target=lambda: (live.start(), began.set(), live.wait(0.5)))
    ended.start()
    assert began.wait(300)
    window = Window(live, "only")
    assert window.answer()["verdict"] == "stable"
    time.sleep(1.0)
    assert ended.is_alive()  # a window is open
    window.close()
    ended.join(60)
    assert not ended.is_alive()
    process = live.desk.helper._process
    live.close()
    with pytest.raises(ValueError, match="closed"):
        process.is_alive()
    with pytest.raises(OSError, match="refused"):
        ask(live, "/v1")


@pytest.mark.skipif(sys.platform != "linux", reason="looks for child processes in /proc")
def test_ctrl_c_ends_the_command_and_its_processes(folder: Path) -> None:
    given = [sys.executable, "-m", "drystone", "live", str(folder / "arch.json"), "--port", "0"]
    running = subprocess.Popen(
        [*given, "--no-browser", "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": str(Path(drystone.__file__).parents[1])},
        # a shell starts what runs in the background with Ctrl-C ignored
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert running.stdout is not None
    told = json.loads(running.stdout.readline())
    assert told["link"] == f"http://127.0.0.1:{told['port']}/?token={told['token']}"
    with urllib.request.urlopen(told["link"]) as page:
        assert page.read(15) == b"<!doctype html>"
    threads = Path(f"/proc/{running.pid}/task").iterdir()  # each knows the children it started
    children = [one for thread in threads for one in (thread / "children").read_text().split()]
    assert children
    os.killpg(running.pid, signal.SIGINT)  # as a terminal does
    out, err = running.communicate(timeout=300)
    assert (running.returncode, out) == (0, b"")
    # reading may have been slow, and then it was said
    slow = ["drystone: starting ...", f"drystone: reading {folder / 'arch.json'} ..."]
    assert err.decode().splitlines() in ([], slow[:1], slow[1:], slow)
    end = time.monotonic() + 60.0
    while any(Path(f"/proc/{child}").exists() for child in children):
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_file_counts_as_saved_once_it_rests(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("one")
    saved = threading.Event()
    watch = Watch(path, saved.set)
    time.sleep(0.4)
    assert not saved.is_set()
    path.write_text("another")
    assert saved.wait(60)
    watch.close()


def test_the_command_says_what_is_wrong_and_writes_the_client(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["live"]) == 2
    assert main(["live", str(tmp_path / "none.json")]) == 2
    assert "no such file" in capsys.readouterr().err
    assert main(["live", "--client", str(tmp_path / "client.py")]) == 0
    compile((tmp_path / "client.py").read_text(), "client.py", "exec")


def test_a_taken_port_and_a_missing_browser_are_told_with_the_link(
    live: Live, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def serve(model: str, *, began: Callable[[Live], None], **how: object) -> None:
        with_another = Live(model, port=live.port)
        try:
            began(with_another)
        finally:
            with_another.close()

    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("webbrowser.open", lambda link: False)
    monkeypatch.setattr("drystone.live.serve", serve)
    assert main(["live", str(live.desk.file), "--port", str(live.port)]) == 0
    told = capsys.readouterr().out
    assert f"port {live.port} is taken: port " in told
    assert "http://127.0.0.1:" in told
    assert "no browser could be opened: open the link in one" in told


def test_a_script_without_a_main_guard_is_told_to_have_one(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    live = Live(folder / "arch.json", port=0)
    monkeypatch.setattr(multiprocessing.current_process(), "_inheriting", True, raising=False)
    with pytest.raises(InputError, match="__main__"):
        live.start()
    live.close()
