"""Ask programs about models with known answers: ``python -m benchmarks.field.run`` writes the page.

    python -m benchmarks.field.run --cra CRA/bin/python --lmgc90 LMGC/bin/python --only arch

Each program runs in a process of its own, all side by side. It is ended where a state takes longer
than ``--limit``, and started anew for the next. Seconds are of CPU, told by the program. Ctrl-C
ends the run with the states that are done.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import queue
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.field.cases import FOLDER
from benchmarks.machine import description
from drystone import Assembly, Model, io
from drystone.base.arrays import Floats
from drystone.io import Contents
from drystone.io.simulators.simulator_bodies import gravity_of

HERE = Path(__file__).parent
PAGE = HERE.parents[1] / "docs" / "benchmark.md"
ENDED = "{}\n"
"""Stands for a line where there are no more."""
START = 300.0
"""[s] for a program to start."""
SMALL = 60
"""Faces of a model that is asked before the others."""


def upright(direction: Floats) -> Floats:
    """The least rotation (3, 3) that turns a unit vector to -z."""
    x, y, z = direction
    if z > 1.0 - 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0.0, 0.0, x], [0.0, 0.0, y], [-x, -y, 0.0]])
    turned: Floats = np.eye(3) + cross + cross @ cross / (1.0 - z)
    return turned


@dataclass(frozen=True)
class Question:
    """A state of a model.

    Attributes
    ----------
    model
        Name of its file.
    number
        Of the state in the file.
    state
        As in the file.
    contents
        Of the file.
    """

    model: str
    number: int
    state: dict[str, Any]
    contents: Contents

    @cached_property
    def task(self) -> dict[str, Any]:
        """What a solver is asked."""
        (load,) = [load for load in self.contents.loads if load.name == self.state["name"]]
        friction = self.state["friction"]
        return task_of(Model.of(self.contents.assembly, friction=friction, load=load), friction)


def questions(only: str = "") -> Iterator[Question]:
    """All states of all models whose name has ``only`` in it."""
    for path in sorted(path for path in FOLDER.glob("*.json") if only in path.stem):
        told = json.loads(path.read_text("utf-8"))["_benchmark"]
        contents = io.read_file(path)
        for number, state in enumerate(told["states"]):
            yield Question(path.stem, number, state, contents)


def in_turn(question: Question) -> tuple[bool, int, int, str]:
    """Small models first, and of these the first limit of each: a run can be ended early."""
    faces = sum(len(block.faces) for block in question.contents.assembly.blocks)
    return faces > SMALL, question.number // 2, faces, question.model


def task_of(model: Model, friction: float) -> dict[str, Any]:
    """What a solver is asked; see :mod:`benchmarks.field.tasks`."""
    gravity = gravity_of(model)
    size = float(np.linalg.norm(gravity))
    turn = upright(gravity / size)
    assembly: Assembly = model.assembly.transformed(turn)
    contacts = model.contacts
    starts = np.searchsorted(contacts.interface, np.arange(contacts.count + 1))
    return {
        "blocks": [
            {
                "vertices": block.vertices.tolist(),
                "faces": [list(face) for face in block.faces],
                "density": block.density,
            }
            for block in assembly.blocks
        ],
        "fixed": np.flatnonzero(assembly.fixed).tolist(),
        "friction": friction,
        "g": size,
        "interfaces": [
            {
                "a": int(contacts.block_a[i]),
                "b": int(contacts.block_b[i]),
                "points": (contacts.point[starts[i] : starts[i + 1]] @ turn.T).tolist(),
                "frame": (contacts.frame[i] @ turn.T).tolist(),
                "area": float(contacts.area[i]),
            }
            for i in range(contacts.count)
        ],
    }


class Program:
    """A solver in a process of its own."""

    def __init__(self, command: list[str], limit: float) -> None:
        self.command, self.limit = command, limit
        self.name = ""
        self._start()

    def _start(self) -> None:
        self.process = subprocess.Popen(
            self.command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            cwd=HERE.parents[1],
        )
        self.lines: queue.Queue[str] = queue.Queue()
        read = (self.process, self.lines)
        self.reader = threading.Thread(target=self._read, args=read, daemon=True)
        self.reader.start()
        self.name = json.loads(self.lines.get(timeout=START)).get("name", "")
        if not self.name:
            raise SystemExit(f"{' '.join(self.command)} does not start")

    @staticmethod
    def _read(process: Any, lines: queue.Queue[str]) -> None:
        for line in process.stdout:
            lines.put(line)
        lines.put(ENDED)

    def ask(self, task: dict[str, Any]) -> dict[str, Any]:
        """Its answer; none where it takes too long or ends."""
        try:
            self.process.stdin.write(json.dumps(task) + "\n")  # type: ignore[union-attr]
            self.process.stdin.flush()  # type: ignore[union-attr]
            line = self.lines.get(timeout=self.limit)
        except BrokenPipeError:
            line = ENDED
        except queue.Empty:
            line = ""
        if line and line != ENDED:
            answer: dict[str, Any] = json.loads(line)
            return answer
        late = line != ENDED
        self.close()
        self._start()
        said = f"more than {self.limit:g} s" if late else "it ended without an answer"
        return {"stands": None, "said": said, "seconds": None}

    def close(self) -> None:
        """End it."""
        self.process.kill()
        self.reader.join()
        with contextlib.suppress(BrokenPipeError), self.process:
            pass


def mark(answer: dict[str, Any], stands: bool) -> str:
    """Right, wrong or none."""
    if answer["stands"] is None:
        return "none"
    return "right" if answer["stands"] is stands else "wrong"


def rows_of(
    asked: list[Question], programs: list[Program], end: float = float("inf")
) -> list[dict[str, Any]]:
    """Every state with the answers of all programs; none is begun after ``end`` (monotonic) [s]."""
    rows: list[dict[str, Any]] = []
    threads = ThreadPoolExecutor(len(programs))
    with contextlib.suppress(KeyboardInterrupt):
        for question in asked:
            if time.monotonic() > end:
                break
            told = threads.map(lambda one, task=question.task: one.ask(task), programs)
            answers = dict(zip([program.name for program in programs], told, strict=True))
            rows.append({"model": question.model, "state": question.state, "answers": answers})
            marks = [f"{name}: {mark(a, question.state['stands'])}" for name, a in answers.items()]
            print(question.model, question.state["name"], *marks, sep=", ", flush=True)
    return rows


def tables(rows: list[dict[str, Any]]) -> str:
    """The counts, and every state."""
    names = list(rows[0]["answers"])
    lines = [
        "| program | right | wrong: said to stand | wrong: said to fall | no answer "
        "| median [s] | all [s] |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in names:
        marks: Counter[str] = Counter()
        spent = []
        for row in rows:
            answer, stands = row["answers"][name], row["state"]["stands"]
            kind = mark(answer, stands)
            marks[kind if kind != "wrong" else f"wrong {answer['stands']}"] += 1
            spent += [answer["seconds"]] if answer["seconds"] is not None else []
        middle = f"{np.median(spent):.2g}" if spent else ""
        lines.append(
            f"| {name} | {marks['right']} | {marks['wrong True']} | {marks['wrong False']} "
            f"| {marks['none']} | {middle} | {sum(spent):.0f} |"
        )
    lines += ["", f"| model | state | stands | limit | {' | '.join(names)} |"]
    lines.append("|---" * (4 + len(names)) + "|")
    for row in rows:
        state = row["state"]
        cells = []
        for name in names:
            answer = row["answers"][name]
            kind = mark(answer, state["stands"])
            told = kind if kind == "right" else f"**{kind}**"
            took = "" if answer["seconds"] is None else f" {answer['seconds']:.2g} s"
            cells.append(told + took)
        stands = "yes" if state["stands"] else "no"
        told = [row["model"], state["name"], stands, state["limit"], *cells]
        lines.append(f"| {' | '.join(told)} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cra", help="python of an environment with compas_cra")
    parser.add_argument("--lmgc90", help="python of an environment with compas_lmgc90")
    parser.add_argument("--solver", nargs="+", action="append", default=[], help="another command")
    parser.add_argument("--only", default="", help="models with this in their name; no page then")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds for one state")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="for the whole run")
    asked = parser.parse_args()
    end = time.monotonic() + 60.0 * asked.minutes
    commands = [
        [sys.executable, "-m", "benchmarks.field.solve_drystone"],
        [sys.executable, "-m", "benchmarks.field.solve_mujoco"],
    ]
    if asked.cra:
        commands.append([asked.cra, "-m", "benchmarks.field.solve_cra"])
    if asked.lmgc90:
        commands.append([asked.lmgc90, "-m", "benchmarks.field.solve_lmgc90"])
    commands += asked.solver
    with ThreadPoolExecutor(len(commands)) as threads:  # they take seconds to start
        programs = list(threads.map(lambda one: Program(one, asked.limit), commands))
    every, machine = sorted(questions(asked.only), key=in_turn), description()
    try:
        rows = rows_of(every, programs, end)
    finally:
        for program in programs:
            program.close()
    if not rows:
        raise SystemExit("no state was asked")
    text = f"{len(rows)} of {len(every)} states.\n\n{tables(rows)}"
    if asked.only:
        print(text)
        return
    text += f"\n\nAt most {asked.limit:g} s for one state. Measured with {machine}"
    page = PAGE.read_text("utf-8")
    before, _, rest = page.partition("<!-- field -->")
    _, _, after = rest.partition("<!-- end field -->")
    PAGE.write_text(f"{before}<!-- field -->\n{text}\n<!-- end field -->{after}", "utf-8")


if __name__ == "__main__":
    main()
