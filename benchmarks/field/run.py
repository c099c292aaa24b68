"""Ask programs about models with known answers: ``drystone-benchmarks``.

    drystone-benchmarks --cra CRA/bin/python --lmgc90 LMGC/bin/python --page run.md

In a checkout it is ``python -m benchmarks.field.run``. Each program runs in a process of its own,
one after the other for each state. It is ended where a state takes more CPU time than ``--limit``,
and started anew for the next. Ctrl-C ends the run with the states that are done; with the same
``--rows`` it goes on from there. An answer is kept only for the same program, drystone at the same
commit, the same task and limit on the same machine: what was done in parts is what one run gives.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import platform
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from drystone import Assembly, Model, io
from drystone.base.arrays import Floats
from drystone.base.files import write_bytes
from drystone.io import Contents
from drystone.io.simulator_bodies import gravity_of

from . import MODELS
from .report import mark, place, states, tables, write_between

HERE = Path(__file__).parent
Row: TypeAlias = dict[str, Any]
ENDED = "{}\n"
"""Stands for a line where there are no more."""
START = 300.0
"""[s] for a program to start."""
PATIENCE = 20.0
"""Time on the clock by CPU time, after which a program on a busy machine is ended all the same."""
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
        assembly, contacts = self.contents.assembly, self.contents.contacts
        friction = self.state["friction"]
        if contacts is None:
            return task_of(Model.of(assembly, friction=friction, load=load), friction)
        return task_of(Model(assembly, contacts, load), friction)


def questions(only: str = "") -> Iterator[Question]:
    """All states of all models whose name has ``only`` in it."""
    for path in sorted(path for path in MODELS.glob("*.json") if only in path.stem):
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
    capacity: list[dict[str, float]] = [{}] * contacts.count
    if contacts.capacity is not None:
        names = ("tension", "cohesion", "shear")
        values = zip(*(getattr(contacts.capacity, name).tolist() for name in names), strict=True)
        capacity = [dict(zip(names, each, strict=True)) for each in values]
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
                **capacity[i],
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
        told = json.dumps(task | {"limit": self.limit})
        try:
            self.process.stdin.write(told + "\n")  # type: ignore[union-attr]
            self.process.stdin.flush()  # type: ignore[union-attr]
            line = self.lines.get(timeout=PATIENCE * self.limit)
        except BrokenPipeError:
            line = ENDED
        except queue.Empty:
            line = ""
        if line and line != ENDED:
            answer: dict[str, Any] = json.loads(line)
            return answer
        self.close()
        late = line != ENDED or -self.process.returncode == getattr(signal, "SIGXCPU", None)
        said = f"more than {self.limit:g} s" if late else "it ended without an answer"
        self._start()
        return {"stands": None, "said": said, "seconds": None}

    def close(self) -> None:
        """End it."""
        self.process.kill()
        self.reader.join()
        with contextlib.suppress(BrokenPipeError), self.process:
            pass


def rows_of(
    asked: Iterable[Question],
    programs: list[Program],
    told: Iterable[Row] = (),
    end: float = float("inf"),
) -> Iterator[tuple[Row, bool]]:
    """Every state with the answers of the programs, and whether one of them was asked now.

    After ``end`` (monotonic) [s] no state is begun; what is known of the others is given. Answers
    that were ``told`` are kept if the program, the task, its limit and the machine are the same.
    """
    known: dict[tuple[str, str], dict[str, Any]] = {}
    for row in told:
        known |= {(row["asked"], name): answer for name, answer in row["answers"].items()}
    for question in asked:
        answers, new, late = {}, False, time.monotonic() > end
        digest = _asked(question.task, programs[0].limit)
        for program in programs:
            key = (digest, program.name)
            if key not in known and not late:
                known[key], new = program.ask(question.task), True
            if key in known:
                answers[program.name] = known[key]
        row = {"model": question.model, "state": question.state, "asked": digest}
        if answers:
            yield row | {"answers": answers}, new


def _asked(task: dict[str, Any], limit: float) -> str:
    """What an answer depends on besides the program: task, limit of CPU time, machine."""
    machine = [platform.node(), platform.platform(), platform.processor(), os.cpu_count()]
    told = json.dumps([task, limit, machine], sort_keys=True)
    return hashlib.sha256(told.encode()).hexdigest()[:16]


def started(asked: argparse.Namespace) -> list[Program]:
    """The programs, side by side: some take seconds to start."""
    here = __package__ or "benchmarks.field"
    commands = [[sys.executable, "-m", f"{here}.solve_{name}"] for name in asked.ask]
    if asked.cra:
        commands.append([asked.cra, str(HERE / "solve_cra.py")])
    if asked.lmgc90:
        commands.append([asked.lmgc90, str(HERE / "solve_lmgc90.py")])
    commands += asked.solver
    with ThreadPoolExecutor(max(1, len(commands))) as threads:
        return list(threads.map(lambda one: Program(one, asked.limit), commands))


def main() -> None:
    parser = argparse.ArgumentParser(description="Ask programs about models with known answers.")
    parser.add_argument("--ask", nargs="*", default=["drystone", "mujoco"], help="of these two")
    parser.add_argument("--cra", help="python of an environment with compas_cra")
    parser.add_argument("--lmgc90", help="python of an environment with compas_lmgc90")
    parser.add_argument("--solver", nargs="+", action="append", default=[], help="another command")
    parser.add_argument("--only", default="", help="models with this in their name")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds of CPU for one state")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="for the whole run")
    parser.add_argument("--rows", type=Path, help="a line of JSON for each state; goes on from it")
    parser.add_argument("--page", type=Path, help="Markdown; left out, the tables are printed")
    asked = parser.parse_args()
    end = time.monotonic() + 60.0 * asked.minutes
    every, machine = sorted(questions(asked.only), key=in_turn), place()
    if not (asked.ask or asked.cra or asked.lmgc90 or asked.solver):
        raise SystemExit("no program to ask")
    told = []
    if asked.rows and asked.rows.exists():
        told = [json.loads(line) for line in asked.rows.read_text("utf-8").splitlines()]
    rows: list[Row] = []
    programs = started(asked)
    try:
        for row, new in rows_of(every, programs, told, end):
            rows.append(row)
            marks = [f"{n}: {mark(a, row['state']['stands'])}" for n, a in row["answers"].items()]
            print(f"{len(rows)}/{len(every)}", row["model"], row["state"]["name"], *marks, sep=", ",
                  file=sys.stderr, flush=True)  # fmt: skip
            if asked.rows and new:
                with asked.rows.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
    finally:
        for program in programs:
            program.close()
    if not rows:
        raise SystemExit("no state was asked")
    text = f"{len(rows)} of {len(every)} states.\n\n{tables(rows)}\n\n"
    text += f"At most {asked.limit:g} s of CPU for one state. Measured with {machine}"
    if asked.page:
        write_between(asked.page, text)
        write_bytes(asked.page.with_suffix(".csv"), states(rows).encode())
    else:
        print(text, states(rows), sep="\n\n")


if __name__ == "__main__":
    main()
