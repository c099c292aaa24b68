"""Frozen answers beside those of the code now: ``python -m benchmarks.same_answers``.

A line for every difference: the question, what differs, frozen, now. Then a summary with the CPU
seconds of each part. Exit code 1 where something differs. ``--sample 100`` asks some quick
questions of each kind, ``--freeze FILE`` keeps the answers of this code.
"""

from __future__ import annotations

import argparse
import fnmatch
import json
import platform
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from benchmarks.same_answers.asking import Answer
from benchmarks.same_answers.catalogue import PARTS, Question, answered, questions
from benchmarks.same_answers.comparing import differences, plain

FROZEN = Path(__file__).parent / "frozen.jsonl"
QUICK_S = 0.6
"""CPU seconds that a question of the sample took at most."""

SLOWER = 1.5
"""Times the frozen CPU seconds, and a quick question's more: from there on it is told. It is no
difference: the frozen ones are of one machine."""


def main() -> int:
    """Ask, compare or freeze."""
    given = _parser().parse_args()
    asked = _chosen(questions(given.folder), given)
    if given.freeze is not None:
        return _freeze(given, asked)
    header, *rows = (json.loads(line) for line in given.frozen.read_text("utf-8").splitlines())
    frozen = {row["key"]: row for row in rows}
    asked = [one for one in asked if one.key in frozen]
    if given.sample:
        asked = _sample(asked, frozen, given.sample)
    print(f"{len(asked)} questions, frozen from {header['commit']}", flush=True)
    spent: dict[str, float] = defaultdict(float)
    before_s: dict[str, float] = defaultdict(float)
    count: Counter[str] = Counter()
    different = set()
    for question, now, seconds in _answers(asked, given):
        row = frozen[question.key]
        count[question.part] += 1
        spent[question.part] += seconds
        before_s[question.part] += row["s"]
        if seconds > SLOWER * row["s"] + QUICK_S:
            print(f"{question.key}: slower: frozen {row['s']:.2f} CPU s, now {seconds:.2f}")
        for what, before, after in differences(row["answer"], now):
            different.add(question.key)
            print(f"{question.key}: {what}: frozen {_told(before)}, now {_told(after)}", flush=True)
    for part in PARTS:
        if count[part]:
            print(f"{part}: {count[part]}, {spent[part]:.1f} CPU s (frozen {before_s[part]:.1f})")
    print(f"{len(different)} of {len(asked)} differ" if different else "all the same")
    return 1 if different else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--part", choices=PARTS, action="append", help="only this part; repeat")
    parser.add_argument("--only", default="*", help="pattern of questions, or a part of one")
    parser.add_argument("--sample", type=int, help="so many quick questions of all kinds")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--folder", type=Path, help="folder of models: *.obj and *.json")
    parser.add_argument("--frozen", type=Path, default=FROZEN, help="the frozen answers")
    parser.add_argument("--freeze", type=Path, help="write the answers of this code there")
    return parser


def _chosen(known: dict[str, Question], given: argparse.Namespace) -> list[Question]:
    pattern = given.only if "*" in given.only else f"*{given.only}*"
    return [
        one
        for one in known.values()
        if (not given.part or one.part in given.part) and fnmatch.fnmatchcase(one.key, pattern)
    ]


def _sample(asked: Sequence[Question], frozen: dict[str, Answer], size: int) -> list[Question]:
    """Some of each group, evenly spaced; all groups have about as many."""
    groups: dict[tuple[str, str], list[Question]] = defaultdict(list)
    for one in asked:
        if frozen[one.key]["s"] <= QUICK_S:
            groups[one.part, "" if one.part == "limits" else one.group].append(one)
    most = 1
    while most < len(asked) and sum(min(most, len(g)) for g in groups.values()) < size:
        most += 1
    picked = []
    for group in groups.values():
        step = max(1.0, len(group) / most)
        picked += [group[int(i * step)] for i in range(min(most, len(group)))]
    return picked


def _answers(
    asked: Sequence[Question], given: argparse.Namespace
) -> Iterator[tuple[Question, Answer, float]]:
    """Each answer, and the CPU seconds that it took."""
    if given.workers == 1:
        for question in asked:
            yield question, *answered(given.folder, question.key, question)
        return
    with ProcessPoolExecutor(given.workers, mp_context=get_context("spawn")) as pool:
        work = partial(answered, given.folder)
        found = pool.map(work, [one.key for one in asked], chunksize=4)
        for question, (answer, seconds) in zip(asked, found, strict=True):
            yield question, answer, seconds


def _freeze(given: argparse.Namespace, asked: Sequence[Question]) -> int:
    """Write all answers; a line for each."""
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False
    ).stdout.strip()
    header = {"commit": commit, "python": platform.python_version(), "machine": platform.machine()}
    errors = 0
    with given.freeze.open("w", encoding="utf-8") as file:
        file.write(json.dumps(header) + "\n")
        for question, answer, seconds in _answers(asked, given):
            errors += "error" in answer
            if "error" in answer:
                print(f"{question.key}: {answer['error']}", file=sys.stderr, flush=True)
            row = {"key": question.key, "s": round(seconds, 3), "answer": plain(answer)}
            file.write(json.dumps(row, separators=(",", ":")) + "\n")
            file.flush()
    print(f"{len(asked)} answers, {errors} errors, wrote {given.freeze}")
    return 0


def _told(value: object) -> str:
    text = json.dumps(value, default=str)
    return text if len(text) <= 120 else text[:117] + "..."


if __name__ == "__main__":
    raise SystemExit(main())
