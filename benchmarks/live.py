"""How fast the live page answers, and whether anything grows: ``python -m benchmarks.live``.

A wish is sent as the page sends it, by HTTP; the time runs until its quick answer has arrived.
"""

from __future__ import annotations

import argparse
import http.client
import json
import os
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import drystone
from benchmarks.machine import commit, processor
from drystone import io
from drystone.live.serving import Live
from drystone.models import arch, vault

WISHES = 200
MANY = 1000
TILT = 2.0
"""[degrees] within which the tilt goes to and fro, as a slider that is dragged."""


class Asker:
    """One window."""

    def __init__(self, live: Live) -> None:
        self.live, self.number = live, 0
        self.head = {"Authorization": f"Bearer {live.server.guard.token}"}
        self.connection = http.client.HTTPConnection("127.0.0.1", live.port)
        self.connection.request("GET", "/events?window=bench", headers=self.head)
        self.lines: Iterator[bytes] = iter(self.connection.getresponse())

    def until(self, kind: str) -> dict[str, Any]:
        """The next event of a kind for the newest wish."""
        for line in self.lines:
            if line.startswith(b"data: "):
                event: dict[str, Any] = json.loads(line[6:])
                if event["event"] == kind and event["wish"] == self.number:
                    return event
        raise SystemExit("the stream has ended")

    def wish(self, tilt: float, kind: str = "quick") -> float:
        """Seconds from a wish to its answer."""
        self.number += 1
        body = {"window": "bench", "number": self.number, "model": self.live.desk.current,
                "wish": {"tilt": tilt}}  # fmt: skip
        began = time.perf_counter()
        connection = http.client.HTTPConnection("127.0.0.1", self.live.port)
        connection.request("POST", "/live/wish", json.dumps(body), self.head)
        connection.getresponse().read()
        connection.close()
        self.until(kind)
        return time.perf_counter() - began


def tilts(count: int) -> np.ndarray:
    """To and fro in small steps."""
    return TILT * 0.5 * (1.0 - np.cos(np.linspace(0.0, 8.0 * np.pi, count)))


def spent(live: Live) -> float:
    """CPU seconds of server and worker so far."""
    ticks = Path(f"/proc/{live.desk.helper._process.pid}/stat").read_text().rpartition(")")[2]
    worker = sum(int(one) for one in ticks.split()[11:13]) / os.sysconf("SC_CLK_TCK")
    return time.process_time() + worker


def holdings(live: Live) -> dict[str, int]:
    """Memory [kB], threads, open files and files in the temporary folder."""
    told: dict[str, int] = {"temporary files": len(os.listdir(tempfile.gettempdir()))}  # noqa: PTH208
    for name, pid in (("server", os.getpid()), ("worker", live.desk.helper._process.pid)):
        status = Path(f"/proc/{pid}/status").read_text()
        fields = dict(line.split(":", 1) for line in status.splitlines())
        told[f"{name} memory [kB]"] = int(fields["VmRSS"].split()[0])
        told[f"{name} threads"] = int(fields["Threads"])
        told[f"{name} files"] = len(list(Path(f"/proc/{pid}/fd").iterdir()))
    threads = Path(f"/proc/{os.getpid()}/task").iterdir()
    told["processes"] = sum(len((one / "children").read_text().split()) for one in threads)
    return told


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--wishes", type=int, default=WISHES)
    parser.add_argument("--many", type=int, default=MANY, help="wishes of the look at growth")
    parser.add_argument("--armadillo", type=Path, help="a model file of 399 blocks")
    chosen = parser.parse_args()
    print(f"drystone {drystone.__version__}, commit {commit()}; {processor()}")
    print(
        "| model | blocks | first [ms] | median [ms] | worst [ms] | CPU by wish [ms] | whole [s] |"
    )
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / "arch.json", Path(folder) / "vault.json"]
        io.write(drystone.Model.of(arch(0.2, 28), friction=0.9), files[0])
        io.write(drystone.Model.of(vault(), friction=0.7), files[1])
        if chosen.armadillo:
            files.append(chosen.armadillo)
        for file in files:
            with Live(file, port=0) as live:
                asker = Asker(live)
                first = asker.wish(0.0)
                began = spent(live)
                times = [asker.wish(float(tilt)) for tilt in tilts(chosen.wishes)]
                each = (spent(live) - began) / chosen.wishes
                whole = asker.wish(1.0, "whole")
                blocks = len(io.read(file))
                print(
                    f"| {file.stem} | {blocks} | {1e3 * first:.0f} "
                    f"| {1e3 * statistics.median(times):.0f} | {1e3 * max(times):.0f} "
                    f"| {1e3 * each:.0f} | {whole:.2f} |",
                    flush=True,
                )
        if not chosen.many:
            return
        with Live(files[0], port=0) as live:
            asker = Asker(live)
            for tilt in tilts(50):  # caches are filled
                asker.wish(float(tilt))
            before = holdings(live)
            for tilt in tilts(chosen.many):
                asker.wish(float(tilt))
            after = holdings(live)
    print(f"\n| {chosen.many} wishes | before | after |\n|---|---|---|")
    for name, value in before.items():
        print(f"| {name} | {value} | {after[name]} |")


if __name__ == "__main__":
    main()
