"""Ten thousand verdicts of random piles of 50 blocks, on two cores, into a file.

``python -m benchmarks.many --out FILE [--models 10000] [--blocks 50] [--workers 2] [--kill 100]``

The same command goes on where the file ends. ``--kill N`` kills one worker after every N answers:
the count of the answers and the answers themselves must not change.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import signal
import sys
import time
from collections import Counter
from pathlib import Path

from benchmarks.workloads import random_pile
from drystone.sequence import LocalWorkers
from drystone.stability import check_many


def main() -> int:
    """Run, and print the verdicts and the time of each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--models", type=int, default=10_000)
    parser.add_argument("--blocks", type=int, default=50)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--kill", type=int, default=0, help="kill a worker after so many answers")
    parser.add_argument("--limit", type=float, default=float("inf"), help="seconds in all")
    parser.add_argument("--out", type=Path, required=True)
    chosen = parser.parse_args()
    begin = time.perf_counter()
    seen = killed = 0

    def progress(stage: str, done: int, total: int) -> None:  # noqa: ARG001
        nonlocal seen, killed
        seen += 1
        if chosen.kill and seen % chosen.kill == 0:
            worker = next(iter(multiprocessing.active_children()), None)
            if worker is not None and worker.pid is not None:
                os.kill(worker.pid, signal.SIGKILL)
                killed += 1
        if seen % 100 == 0:
            rate = seen / (time.perf_counter() - begin)
            print(f"{done:,} of {chosen.models:,}, {rate:.1f} a second", flush=True)

    found = check_many(
        (
            random_pile(number, chosen.blocks, chosen.blocks // 3, 5.0)
            for number in range(chosen.models)
        ),
        out=chosen.out,
        executor=LocalWorkers(chosen.workers) if chosen.workers > 1 else None,
        progress=progress,
        time_limit_s=chosen.limit,
    )
    spent = time.perf_counter() - begin
    kinds = Counter(found["verdict"].tolist())
    print(", ".join(f"{kind} {count:,}" for kind, count in kinds.most_common()))
    each = 1e3 * spent / max(seen, 1)
    print(f"{seen:,} answers in {spent:.0f} s, {each:.0f} ms each; {killed} workers killed")
    print(f"the slowest took {found['time_s'].max(initial=0.0):.1f} s")
    return 1 if kinds["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
