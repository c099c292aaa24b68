"""Supports that are moved on the live page: at once to first order, then by finite steps."""

import base64
import concurrent.futures
import json
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import io
from drystone.base import units
from drystone.base.errors import InputError
from drystone.design import MendOptions, find_mends
from drystone.io.jsontext import Field
from drystone.live import calculator
from drystone.live.moved_supports import AfterMoving, CoarseSteps, at_once, moved_model, verdict_of
from drystone.live.serving import Live
from drystone.live.tasks import TASKS, Work
from drystone.live.wish import Found, asked, python_lines, snapshot
from drystone.models import arch, box, tower
from drystone.settlement import (
    End,
    LargeDisplacement,
    large_displacement,
    move_supports,
    support_response,
)
from drystone.view import State
from tests.unit.live.live_client import Window, ask, wish_of

FOOT = "springer-right"
AWAY = (0.02, 0.0, 0.0)
MOVE = [{"block": FOOT, "by": list(AWAY)}]


def test_a_moved_support_is_answered_to_first_order_and_then_followed(
    live: Live, window: Window
) -> None:
    model = io.read(live.desk.file)
    number = window.wish(moves=MOVE)
    quick = window.until("quick", number)
    joints = len(support_response(model, {FOOT: AWAY}).open_joints())
    assert quick["answer"]["headline"].startswith(f"Supports moved by 20 mm: {joints} joints open")
    whole = window.until("whole", number)
    found = move_supports(model, {FOOT: AWAY})
    assert found.end is End.REACHED
    assert whole["answer"]["verdict"] == "stable"
    told = f"Stands with its supports moved by 20 mm: {len(found.states[-1].hinges)} hinges"
    assert whole["answer"]["headline"] == told
    for event in (quick, whole):
        picture = json.loads(event["picture"])
        stage = picture["stage"]
        assert stage["moved"]
        raw = picture["blobs"][stage["motion"]["blob"]]
        motion = np.frombuffer(base64.b64decode(raw), "<f4").reshape(-1, 6)
        np.testing.assert_allclose(motion[-1], [*AWAY, 0, 0, 0], atol=1e-7)
        assert "springer-right moved by 20 mm" in dict(stage["facts"])["Load"]
        marks = [one for one in stage["layers"] if one["kind"] == "markers"]
        assert marks
        assert all("interface" not in one for one in marks)  # they are where the blocks went


def test_an_arch_whose_support_moves_too_far_falls(live: Live, window: Window) -> None:
    whole = window.until("whole", window.wish(moves=[{"block": FOOT, "by": [0.5, 0.0, 0.0]}]))
    answer = whole["answer"]
    assert answer["verdict"] == "unstable"
    shown = json.loads(whole["picture"])
    falls = np.frombuffer(base64.b64decode(shown["blobs"][shown["stage"]["state"]["blob"]]), "u1")
    assert (falls[1:-1] == State.FALLING).sum() > 3
    assert (falls[[0, -1]] == State.SUPPORT).all()
    found = move_supports(io.read(live.desk.file), {FOOT: (0.5, 0.0, 0.0)})
    far = units.quantity(float(found.displacement[-1]), "m")
    assert answer["headline"] == f"Falls when the supports have moved by {far}"
    fallen = window.answer(moves=MOVE, tilt=12)
    assert fallen["headline"].endswith(", before the supports move")
    assert fallen["verdict"] == "unstable"


def test_blocks_that_are_taken_out_stay_out_while_the_others_follow(window: Window) -> None:
    names = io.read(window.live.desk.file).assembly.names
    wish = {"moves": MOVE, "removed": [names[6]], "supports": [*names[:6], *names[7:11], FOOT]}
    number = window.wish(**wish)
    stage = json.loads(window.until("whole", number)["picture"])["stage"]
    assert stage["motion"]["shape"] == [len(names), 6]
    assert stage["path"]["shape"][1:] == [len(names), 6]


@pytest.mark.parametrize(
    ("wish", "told"),
    [
        ({"moves": [{"block": "voussoir-05", "by": [1, 0, 0]}]}, "no support"),
        ({"moves": MOVE, "removed": [FOOT]}, "no support"),
        ({"moves": [{"block": "nobody", "by": [1, 0, 0]}]}, "nobody"),
        ({"moves": MOVE, "gravity": 0}, "nothing loads"),
    ],
)
def test_what_cannot_move_is_refused_in_words(window: Window, wish: dict, told: str) -> None:
    assert told in window.until("error", window.wish(**wish))["what"]
    assert window.answer()["verdict"] == "stable"


def test_a_translation_of_two_numbers_is_refused(live: Live) -> None:
    body = {"window": "w", "wish": {"moves": [{"block": FOOT, "by": [1, 2]}]}}
    status, answer = ask(live, "/live/wish", body)
    assert (status, "not 3" in answer["error"]["what"]) == (400, True)


def test_the_python_lines_move_the_supports(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(live.desk.file.parent)
    sent = {"moves": MOVE, "tilt": 2.0}
    body = {"window": "w", "model": live.desk.current, "wish": sent}
    printed: list[LargeDisplacement] = []
    exec(ask(live, "/live/python", body)[1]["python"], {"print": printed.append})
    made = asked(io.read("arch.json"), wish_of(**sent))
    assert printed[0].message == move_supports(made.moving).message


def test_a_saved_load_case_and_a_saved_model_have_the_motion(
    live: Live, window: Window, tmp_path: Path
) -> None:
    case = python_lines("arch.json", {}, {"moves": MOVE}, {"gravity": 9.81, "moves": False})["case"]
    content = json.loads(live.desk.file.read_text())
    content["loads"] = [case]
    (tmp_path / "with.json").write_text(json.dumps(content))
    text = window.until("saved", window.task("save", moves=MOVE))["text"]
    (tmp_path / "saved.json").write_text(text)
    for name in ("with.json", "saved.json"):
        motion = asked(io.read(tmp_path / name), wish_of()).motion
        assert motion is not None
        np.testing.assert_allclose(motion[-1, :3], AWAY)
    with Live(tmp_path / "saved.json", port=0) as again:
        other = Window(again, "again")
        assert other.answer()["headline"].startswith("Stands with its supports moved by 20 mm")
        other.close()


def test_a_changed_model_keeps_the_motion_of_its_file() -> None:
    base, top = box((1, 1, 1), name="base"), box((1, 1, 1), (0, 0, 1), name="top")
    model = drystone.Model.of(drystone.Assembly((base, top)).with_fixed([0]), friction=0.5)
    moving = asked(model, wish_of(moves=[{"block": "base", "by": list(AWAY)}])).moving
    wish, block = wish_of(), Field({"block": "top"}, "", Path("wish"))
    work = Work(
        moving, wish, asked(moving, wish), block, lambda: False, lambda *_: None, "two", print
    )
    ((event, told),) = TASKS["cut"](work)
    assert (event, len(told["made"])) == ("model", 3)
    motion = asked(told["made"], wish).motion
    assert motion is not None
    np.testing.assert_allclose(motion, [[*AWAY, 0, 0, 0], np.zeros(6), np.zeros(6)])


def test_load_cases_side_by_side_follow_their_supports(window: Window) -> None:
    number = window.task("cases", {"cases": [{}, {"moves": MOVE}]})
    told = [window.until("case", number, count=i)["headline"] for i in (1, 2)]
    assert told[0] == "Stands"
    assert told[1].startswith("Stands with its supports moved by 20 mm")


def test_the_limit_is_that_of_the_moved_supports() -> None:
    model = drystone.Model.of(arch(0.15, 3), friction=0.9)
    wish = wish_of(moves=[{"block": FOOT, "by": list(AWAY)}])
    made, nothing = asked(model, wish), Field({}, "", Path("wish"))
    work = Work(model, wish, made, nothing, lambda: False, lambda *_: None, "arch", print)
    ((event, found),) = TASKS["limit"](work)
    assert event == "limit"
    assert found["stands"] < drystone.limit_tilt(model, (0, 1, 0)).best.stands - 0.3
    for tilt, verdict in ((found["stands"], "stable"), (found["falls"], "unstable")):
        tilted = asked(model, replace(wish, tilt=tilt))
        assert verdict_of(tilted, stop=lambda: False).result.verdict == verdict


def test_a_plan_and_changed_joints_are_refused_where_supports_move(window: Window) -> None:
    for task in ("plan", "recut"):
        told = window.until("error", window.task(task, moves=MOVE))
        assert "this load case moves them" in told["what"]
        assert "back first" in told["remedy"]


def test_what_a_model_becomes_where_it_begins_to_fall_falls_and_where_it_stands_stands() -> None:
    model = drystone.Model.of(arch(0.15, 6), friction=0.9)
    for far, verdict in ((0.1, "stable"), (0.5, "unstable")):
        there = moved_model(move_supports(model, {FOOT: (far, 0.0, 0.0)}))
        assert drystone.check(there).verdict == verdict


def test_a_mend_holds_after_the_supports_have_moved(window: Window) -> None:
    left, right = box((1, 1, 1), name="left"), box((1, 1, 1), (1.4, 0, 0), name="right")
    plank = box((1.4, 0.5, 0.2), (0.6, 0.0, 1.0), name="plank")
    model = drystone.Model.of(drystone.Assembly((left, right, plank)).with_fixed([0, 1]))
    model = model.with_friction([0.9, 0.05])
    motion = np.zeros((3, 6))
    motion[1, 0] = 1.5
    margin = AfterMoving.of_supports(model, motion)
    assert drystone.check(model).stable
    assert not margin.stands(model)
    assert margin.holds(model).falling_names == ("plank",)
    found = find_mends(model, options=MendOptions(margin, ("merge",)))
    assert found.mends
    assert all(margin.stands(one.model) for one in found.mends)
    told = window.until("mends", window.task("mends", moves=MOVE))
    assert "stands with its supports moved" in told["message"]


def test_a_block_on_one_support_moves_with_it() -> None:
    base, top = box((1, 1, 1), name="base"), box((1, 1, 1), (0, 0, 1), name="top")
    model = drystone.Model.of(drystone.Assembly((base, top)).with_fixed([0]), friction=0.5)
    made = asked(model, wish_of(moves=[{"block": "base", "by": [0.0, 0.0, -0.1]}]))
    for found in (at_once(made.moving), verdict_of(made, stop=lambda: False)):
        assert found.moved
        np.testing.assert_allclose(found.stage.motion[1], [0, 0, -0.1, 0, 0, 0], atol=1e-4)


def test_a_block_that_meets_another_is_shown_with_the_interfaces_of_the_model() -> None:
    base, top = box((1, 1, 1), name="base"), box((1, 1, 1), (0, 0, 1), name="top")
    wall = box((1, 1, 2), (1.05, 0, 0.5), name="wall")
    assembly = drystone.Assembly((base, top, wall)).with_fixed([0, 2])
    made = asked(
        drystone.Model.of(assembly, friction=0.9),
        wish_of(moves=[{"block": "base", "by": [0.2, 0, 0]}]),
    )
    seen: list[Found] = []
    found = verdict_of(made, stop=lambda: False, watch=seen.append)
    for one in (*seen, found):
        assert len(one.result.force) == made.part.contacts.corner_count
        assert snapshot(made, wish_of(), one)["stage"]["moved"]
    assert found.stage.motion[1, 0] < 0.1  # the wall holds it back


def test_of_many_blocks_coarse_steps_give_the_forces_at_once() -> None:
    model = drystone.Model.of(arch(0.2, 50), friction=0.9)
    steps = CoarseSteps(model)
    motion = np.zeros((len(model), 6))
    motion[model.assembly.index(FOOT), 0] = 2e-4
    hurried = steps.moved(motion, 0.0)  # no time is left after the first increment
    assert hurried is not None
    assert hurried[0].displacement == pytest.approx(
        2e-4
    )  # the supports are there, the blocks are not
    assert not hurried[1]
    steps = CoarseSteps(model)
    normal = []
    for size in (1e-9, 2e-4, 1e-4):  # it is dragged to and fro
        made = asked(model, wish_of(moves=[{"block": FOOT, "by": [size, 0.0, 0.0]}]))
        found = at_once(made.moving, steps)
        while "not at rest yet" in found.stage.headline:
            found = at_once(made.moving, steps)
        normal.append(found.result.resultants.normal)
    assert found.stage.headline.startswith("Supports moved by 100 µm, in coarse steps")
    assert found.stage.role is None
    fine = move_supports(model, {FOOT: (1e-4, 0.0, 0.0)}).states[-1].resultants.normal
    assert np.linalg.norm(fine - normal[0]) > 0.01 * np.linalg.norm(fine)
    assert np.linalg.norm(fine - normal[-1]) < 0.002 * np.linalg.norm(fine)


def test_supports_of_many_blocks_are_shown_moved_before_their_rest_is_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    known = threading.Event()

    def late(model: drystone.Model) -> CoarseSteps:
        known.wait(60.0)
        return CoarseSteps(model)

    class Told:
        cancelled = False
        headlines: list[str] = []  # noqa: RUF012

        def send(self, event: dict) -> None:
            self.headlines.append(event["answer"]["headline"])

    monkeypatch.setattr(calculator, "CoarseSteps", late)
    asked_for = calculator.Calculator(Told())
    asked_for.models[1] = drystone.Model.of(arch(0.2, 50), friction=0.9)
    message = {"window": "a", "model": 1, "wish": {"moves": MOVE}}
    calculator.DO["quick"](asked_for, message)
    known.set()
    concurrent.futures.wait(asked_for.dragged.values())
    calculator.DO["quick"](asked_for, message)
    first, second = Told.headlines
    assert first == "Supports moved by 20 mm: the blocks are being followed"
    assert "in coarse steps" in second


def test_where_no_coarse_step_is_found_blocks_are_shown_as_they_followed_before() -> None:
    model = drystone.Model.of(tower(60), friction=0.5)
    name = model.assembly.names[0]
    made = asked(model, wish_of(moves=[{"block": name, "by": [0.0, 0.0, -0.1]}]))
    found = at_once(made.moving)
    assert found.stage.headline == "Supports moved by 100 mm: the blocks are being followed"
    assert found.stage.role is None
    np.testing.assert_allclose(found.stage.motion[0], [0, 0, -0.1, 0, 0, 0])
    assert not found.stage.motion[1:].any()
    before = np.tile([0.0, 0.0, -0.05, 0.0, 0.0, 0.0], (60, 1))  # of a tower that sinks as a whole
    after = at_once(made.moving, before=before)
    np.testing.assert_allclose(after.stage.motion, 2.0 * before)
    assert after.stage.role is None


def test_blocks_are_shown_while_they_follow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(large_displacement, "WATCHED", 0.0)
    model = drystone.Model.of(tower(4), friction=0.5)
    name = model.assembly.names[0]
    made = asked(model, wish_of(moves=[{"block": name, "by": [0.0, 0.0, -0.1]}]))
    seen: list[Found] = []
    last = verdict_of(made, stop=lambda: False, watch=seen.append)
    ways = [-float(one.stage.motion[-1, 2]) for one in seen]
    assert len(ways) > 5
    assert ways == sorted(ways)
    np.testing.assert_allclose([one.stage.motion[0, 2] for one in seen], -np.array(ways), atol=1e-5)
    assert ways[-1] == pytest.approx(-last.stage.motion[-1, 2], rel=1e-3)
    assert all(one.stage.role is None and one.moved for one in seen)
    assert seen[0].stage.headline.endswith("so far: the blocks are being followed")


def test_a_motion_of_zero_is_none() -> None:
    model = drystone.Model.of(tower(2), friction=0.5)
    name = model.assembly.names[0]
    assert asked(model, wish_of(moves=[{"block": name, "by": [0, 0, 0]}])).motion is None
    with pytest.raises(InputError, match="finite"):
        wish_of(moves=[{"block": name, "by": [float("nan"), 0, 0]}])
