"""What one process holds after thousands of checks and loads: memory, threads, files.

``python -m benchmarks.lasting [--rounds 20000] [--seed 0]``

Each round checks a small model: one that was just made, one that was written to a file and read
again, or a file of any format that is read within this process, sound or damaged, which ends in an
answer or an error. What the process holds is told after a twentieth of the rounds, after half of
them and at the end. Threads, open files, child processes and temporary files must be as many as at
first, and memory in the second half at most 1 KiB a round more. A process takes memory that it
keeps in its first thousands of rounds, so nothing is said of memory after fewer than 10,000.
"""

from __future__ import annotations

import argparse
import gc
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import astuple, dataclass
from pathlib import Path

import drystone
from benchmarks.fuzz import OUTSIDE, damaged, file_of, samples
from drystone import Assembly, LoadCase, Model
from drystone.base.errors import InputError
from drystone.models import arch, h_model, shelf, tower

A_ROUND = 1024
"""[bytes] of memory that a round may leave."""

SETTLED = 5_000
"""Rounds after which a process has taken the memory that it keeps."""


@dataclass(frozen=True)
class Held:
    """What a process holds.

    Attributes
    ----------
    memory : [bytes] that are resident
    threads
    files
        Open ones.
    children
    left
        Files in the folder of temporary files.
    objects
        Containers that Python tracks.
    """

    memory: int
    threads: int
    files: int
    children: int
    left: int
    objects: int

    @classmethod
    def now(cls) -> Held:
        """What this process holds now."""
        gc.collect()
        lines = Path("/proc/self/status").read_text().splitlines()
        told = dict(line.split(":\t") for line in lines if ":\t" in line)
        children = [one.read_text().split() for one in Path("/proc/self/task").glob("*/children")]
        return cls(
            1024 * int(told["VmRSS"].split()[0]),
            int(told["Threads"]),
            sum(1 for _ in Path("/proc/self/fd").iterdir()),
            sum(map(len, children)),
            sum(1 for _ in Path(tempfile.gettempdir()).rglob("*")),
            len(gc.get_objects()),
        )


def made(rng: random.Random) -> Model:
    """A small model, with a friction and a load."""
    build = rng.choice((lambda: tower(2), lambda: arch(voussoirs=5), h_model, shelf))
    blocks: Assembly = build()
    load = LoadCase.tilt(blocks, (rng.uniform(-1.0, 1.0), 1.0, 0.0), rng.choice((0.0, 5.0, 40.0)))
    return Model.of(blocks, friction=rng.choice((0.1, 0.6, 0.9)), load=load)


def one(rng: random.Random, files: dict[str, list[bytes]], folder: Path) -> str:
    """One round, and how it ended."""
    kind = rng.random()
    try:
        if kind < 0.4:
            return drystone.check(made(rng)).verdict.value
        if kind < 0.6:
            path = folder / "written.json"
            drystone.write(made(rng), path)
            return drystone.check(path).verdict.value
        name = rng.choice(sorted(files))
        sound = rng.random() < 0.5
        data = rng.choice(files[name]) if sound else damaged(name, files[name], rng)
        return drystone.check(file_of(name, data, folder), supports="lowest").verdict.value
    except InputError:
        return "refused"


def run(rounds: int, seed: int, ends: Counter[str]) -> Iterator[tuple[int, Held]]:
    """What is held after how many rounds; counts how they ended."""
    files = {name: some for name, some in samples().items() if name not in OUTSIDE}
    before = tempfile.tempdir
    with tempfile.TemporaryDirectory() as place:
        tempfile.tempdir = place
        try:
            folder = Path(tempfile.mkdtemp())
            for number in range(rounds):
                ends[one(random.Random(f"{seed}-{number}"), files, folder)] += 1
                if number + 1 in (max(1, rounds // 20), rounds // 2, rounds):
                    for path in folder.iterdir():  # the models
                        shutil.rmtree(path) if path.is_dir() else path.unlink()
                    yield number + 1, Held.now()
        finally:
            tempfile.tempdir = before


def faults(held: list[tuple[int, Held]]) -> list[str]:
    """What grew."""
    (_, begin), (last, end) = held[0], held[-1]
    names = ("threads", "files", "children", "left")
    grew = [name for name in names if getattr(end, name) > getattr(begin, name)]
    half, middle = held[-2:][0]
    if half >= SETTLED and end.memory - middle.memory > A_ROUND * (last - half):
        grew.append("memory")
    return grew


def main() -> int:
    """Run, print what is held, and fail where something grows."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    begin = time.process_time()
    ends: Counter[str] = Counter()
    held = []
    print("rounds, MiB, threads, open files, children, temporary files, objects")
    for number, now in run(chosen.rounds, chosen.seed, ends):
        memory, *others = astuple(now)
        told = (f"{number:,}", f"{memory / 2**20:.1f}", *(f"{count:,}" for count in others))
        print(*told, sep=" | ", flush=True)
        held.append((number, now))
    print(", ".join(f"{kind} {count:,}" for kind, count in sorted(ends.items())))
    print(f"{time.process_time() - begin:.0f} CPU s, seed {chosen.seed}")
    grew = faults(held)
    print(f"grew: {', '.join(grew) or 'nothing'}")
    if chosen.rounds < 2 * SETTLED:
        print(f"whether memory grows is not known from fewer than {2 * SETTLED:,} rounds")
    return 1 if grew else 0


if __name__ == "__main__":
    sys.exit(main())
