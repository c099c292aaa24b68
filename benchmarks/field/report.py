"""The page of a run: counts, and every state with the answers of all programs."""

from __future__ import annotations

import csv
import io
import os
import platform
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

import drystone
from drystone.base.files import write_bytes
from drystone.base.version import commit

BEGIN, END = "<!-- field -->", "<!-- end field -->"
"""What the tables stand between in a page."""


def mark(answer: dict[str, Any], stands: bool) -> str:
    """Right, wrong or none."""
    if answer["stands"] is None:
        return "none"
    return "right" if answer["stands"] is stands else "wrong"


def place() -> str:
    """Versions and machine, in a sentence."""
    busy = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    return (
        f"drystone {drystone.__version__}, commit {commit() or 'unknown'}; "
        f"Python {platform.python_version()}, {os.cpu_count()} cores, {platform.system()} "
        f"{platform.machine()}; load average {busy} at the start."
    )


def tables(rows: list[dict[str, Any]]) -> str:
    """The counts of each program."""
    names = list(dict.fromkeys(name for row in rows for name in row["answers"]))
    lines = [
        "| program | asked | right | wrong: said to stand | wrong: said to fall | no answer "
        "| median [s] | all [s] |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name in names:
        marks: Counter[str] = Counter()
        spent = []
        for row in (row for row in rows if name in row["answers"]):
            answer, stands = row["answers"][name], row["state"]["stands"]
            kind = mark(answer, stands)
            marks[kind if kind != "wrong" else f"wrong {answer['stands']}"] += 1
            spent += [answer["seconds"]] if answer["seconds"] is not None else []
        middle = f"{np.median(spent):.2g}" if spent else ""
        lines.append(
            f"| {name} | {marks.total()} | {marks['right']} | {marks['wrong True']} "
            f"| {marks['wrong False']} | {marks['none']} | {middle} | {sum(spent):.0f} |"
        )
    return "\n".join(lines)


def states(rows: list[dict[str, Any]]) -> str:
    """Every state with the answer of each program, as comma-separated values."""
    names = list(dict.fromkeys(name for row in rows for name in row["answers"]))
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["model", "state", "stands", "limit", *names])
    for row in rows:
        state = row["state"]
        cells = []
        for name in names:
            answer = row["answers"].get(name)
            if answer is None:
                cells.append("not asked")
                continue
            kind = mark(answer, state["stands"])
            told = kind if kind == "right" else f"**{kind}**"
            took = "" if answer["seconds"] is None else f" {answer['seconds']:.2g} s"
            cells.append(told + took)
        stands = "yes" if state["stands"] else "no"
        table.writerow([row["model"], state["name"], stands, state["limit"], *cells])
    return text.getvalue()


def write_between(page: Path, text: str) -> None:
    """Write tables to a page, between its marks where it has them."""
    before, _, rest = (page.read_text("utf-8") if page.exists() else BEGIN + END).partition(BEGIN)
    _, _, after = rest.partition(END)
    write_bytes(page, f"{before}{BEGIN}\n{text}\n{END}{after}".encode())


__all__ = ["mark", "place", "states", "tables", "write_between"]
