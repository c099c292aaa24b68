"""The benchmark of the field: its files, its tasks, and the marks of the answers."""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.field import MODELS
from benchmarks.field.cases import cases
from benchmarks.field.report import mark, tables, write_between
from benchmarks.field.run import Program, in_turn, questions, rows_of, task_of, upright
from benchmarks.field.solve_drystone import solve
from drystone import LoadCase, Model, io, models

FILES = sorted(MODELS.glob("*.json"))


def test_the_files_are_what_the_script_writes() -> None:
    made = {case.key: json.loads(case.text()) for case in cases()}
    assert set(made) == {path.stem for path in FILES}
    for path in FILES:
        told = json.loads(path.read_text("utf-8"))
        fresh = made[path.stem]
        assert told["_benchmark"] == fresh["_benchmark"]
        for block, again in zip(told["blocks"], fresh["blocks"], strict=True):
            assert block["faces"] == again["faces"]
            np.testing.assert_allclose(block["vertices"], again["vertices"], atol=1e-9)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_is_a_model_with_a_load_case_for_every_state(path: Any) -> None:
    told = json.loads(path.read_text("utf-8"))["_benchmark"]
    contents = io.read_file(path)
    assert contents.assembly.fixed.any()
    assert [load.name for load in contents.loads] == [state["name"] for state in told["states"]]
    assert told["title"]
    assert told["citation"]
    for state in told["states"]:
        assert state["friction"] > 0.0 or contents.contacts is not None
        assert isinstance(state["stands"], bool)


def test_there_are_as_many_as_the_page_says() -> None:
    states = sum(len(json.loads(path.read_text("utf-8"))["_benchmark"]["states"]) for path in FILES)
    page = (MODELS.parents[2] / "docs" / "trust" / "benchmark.md").read_text("utf-8")
    assert f"data: {len(FILES)} files" in page
    assert f"with {states} states" in page


@pytest.mark.parametrize("only", ["slide", "topple", "slanted-joint", "overhang", "external"])
def test_drystone_knows_the_closed_forms(only: str) -> None:
    for question in questions(only):
        stands, _, _ = solve(question.task)
        assert stands is question.state["stands"], question.state["name"]


@pytest.mark.parametrize("direction", [(0, 0, -1), (0.6, 0, -0.8), (0, -1, 0), (0, 0.6, 0.8)])
def test_a_task_is_turned_so_that_gravity_points_down(direction: Any) -> None:
    turn = upright(np.array(direction, dtype=float))
    np.testing.assert_allclose(turn @ direction, [0.0, 0.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_the_interfaces_of_a_task_lie_on_its_blocks() -> None:
    assembly = models.tower(2)
    load = LoadCase.tilt(assembly, (0.0, 1.0, 0.0), 20.0)
    task = task_of(Model.of(assembly, friction=0.6, load=load), 0.6)
    (face,) = task["interfaces"]
    normal = np.array(face["frame"][0])
    heights = np.array(face["points"]) @ normal
    for number, block in enumerate(task["blocks"]):
        beyond = np.array(block["vertices"]) @ normal - heights[0]
        assert (beyond.max() if number == face["a"] else beyond.min()) == pytest.approx(0, abs=1e-9)
    assert task["g"] == pytest.approx(9.81)


def test_marks_and_their_counts() -> None:
    answers = [True, False, None]
    assert [mark({"stands": one}, True) for one in answers] == ["right", "wrong", "none"]
    state = {"name": "weight", "stands": True, "limit": "none"}
    rows = [
        {
            "model": "x",
            "state": state,
            "answers": {"s 1": {"stands": one, "said": "", "seconds": 0.5}},
        }
        for one in answers
    ]
    assert "| s 1 | 3 | 1 | 0 | 1 | 1 | 0.5 | 2 |" in tables(rows)


SOLVER = """
import json, sys
print(json.dumps({"name": "told"}), flush=True)
for line in sys.stdin:
    if json.loads(line)["friction"] > 1.0:
        sys.exit(1)
    print(json.dumps({"stands": True, "said": "", "seconds": 0.0}), flush=True)
"""


def test_a_solver_that_ends_has_no_answer_and_is_started_again() -> None:
    program = Program([sys.executable, "-c", SOLVER], 60.0)
    try:
        assert program.name == "told"
        assert program.ask({"friction": 0.5})["stands"] is True
        assert program.ask({"friction": 2.0})["said"] == "it ended without an answer"
        assert program.ask({"friction": 0.5})["stands"] is True
    finally:
        program.close()


def test_small_models_are_asked_first() -> None:
    every = sorted([*questions("slide"), *questions("lemos"), *questions("overhang")], key=in_turn)
    assert every[0].model == "slide"
    assert every[-1].model == "lemos"


def test_rows_that_are_known_are_not_asked_again() -> None:
    class Counted:
        name = "counted"
        limit = 1.0
        asked = 0

        def ask(self, task: Any) -> dict[str, Any]:
            self.asked += 1
            return {"stands": True, "said": "", "seconds": 0.0}

    program: Any = Counted()
    every = list(questions("slide"))
    first = [row for row, _ in rows_of(every, [program])]
    assert program.asked == len(every) == 2
    again = list(rows_of(every, [program], json.loads(json.dumps(first[:1]))))
    assert program.asked == 3
    assert again == [(first[0], False), (first[1], True)]
    assert list(rows_of(every, [program], end=0.0)) == []
    program.limit = 2.0
    assert [new for _, new in rows_of(every, [program], first)] == [True, True]
    program.limit, program.name = 1.0, "a newer one"
    ((row, _), *_) = rows_of(every, [program], first)
    assert list(row["answers"]) == ["a newer one"]


def test_tables_are_written_between_the_marks_of_a_page(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("before <!-- field -->old<!-- end field --> after\n", "utf-8")
    write_between(page, "new")
    assert page.read_text("utf-8") == "before <!-- field -->\nnew\n<!-- end field --> after\n"


PULLS = """
import sys
sys.path.insert(0, FOLDER)
import tasks
def solve(task):
    while task["friction"] == 0.123: pass
    return True, "", 0.0
tasks.answer_all("dry", solve)
"""


def test_a_solver_of_dry_joints_has_no_answer_for_joints_that_pull() -> None:
    script = PULLS.replace("FOLDER", repr(str(MODELS.parent)))
    (pulls,) = questions("external-weight-good")
    (dry, *_) = questions("slide")
    program = Program([sys.executable, "-c", script], 60.0)
    try:
        assert program.ask(dry.task)["stands"] is True
        assert program.ask(pulls.task)["stands"] is None
    finally:
        program.close()


def test_the_solver_of_the_page_is_asked(tmp_path: Path) -> None:
    page = (MODELS.parents[2] / "docs" / "trust" / "benchmark.md").read_text("utf-8")
    script = tmp_path / "my_solver.py"
    script.write_text(page.partition("```python\n")[2].partition("```")[0], "utf-8")
    program: Any = Program([sys.executable, str(script)], 60.0)
    try:
        rows = [row for row, _ in rows_of(questions("slide"), [program])]
    finally:
        program.close()
    assert "| my solver 1.0 | 2 | 1 | 0 | 1 | 0 | 0 | 0 |" in tables(rows)


@pytest.mark.skipif(sys.platform == "win32", reason="no limit of CPU time")
def test_a_state_that_takes_too_much_cpu_has_no_answer() -> None:
    script = PULLS.replace("FOLDER", repr(str(MODELS.parent)))
    task = next(questions("slide")).task
    program = Program([sys.executable, "-c", script], 1.0)
    try:
        assert program.ask(task | {"friction": 0.123})["said"] == "more than 1 s"
        assert program.ask(task)["stands"] is True
    finally:
        program.close()
