"""How fast the live page answers, and whether anything grows: ``python -m benchmarks.live``.

A wish is sent as the page sends it, by HTTP; the time runs until its quick answer has arrived. Each
model is tilted to and fro, then its highest free block is pushed, then a support is moved. Then a
wish ends a limit, a search for mends, a plan, and blocks that follow a support.
"""

from __future__ import annotations

import argparse
import http.client
import json
import os
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import drystone
from benchmarks.curved import curved_vault
from benchmarks.machine import commit, processor
from drystone import Assembly, io
from drystone.live.serving import Live
from drystone.models import arch, vault

OURS: dict[str, tuple[Callable[[], Assembly], float]] = {
    "arch": (lambda: arch(0.2, 28), 0.9), "vault": (vault, 0.7), "curved": (curved_vault, 0.9),
}  # fmt: skip
"""Models of ours and their friction."""
WISHES = 200
MANY = 1000
TRIES = 4
TILT = 2.0
"""[degrees] within which the tilt goes to and fro, as a slider that is dragged."""
PUSH = 0.1
"""Push by the weight of the block, at most."""
MOVE = 0.01
"""Way of a support by the size of a block, at most."""


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
                if event["event"] == "error":
                    raise SystemExit(event["what"])
                if event["event"] == kind and event["wish"] == self.number:
                    return event
        raise SystemExit("the stream has ended")

    def send(self, path: str, wish: dict[str, Any], **more: Any) -> None:
        """Ask for something; the answer comes as an event."""
        self.number += 1
        body = {"window": "bench", "number": self.number, "model": self.live.desk.current,
                "wish": wish, **more}  # fmt: skip
        connection = http.client.HTTPConnection("127.0.0.1", self.live.port)
        connection.request("POST", path, json.dumps(body), self.head)
        connection.getresponse().read()
        connection.close()

    def task(self, task: str, wish: dict[str, Any]) -> None:
        """Press a button."""
        self.send("/live/task", wish, task=task)

    def wish(self, wish: dict[str, Any], kind: str = "quick") -> float:
        """Seconds from a wish to its answer."""
        began = time.perf_counter()
        self.send("/live/wish", wish)
        self.until(kind)
        return time.perf_counter() - began


def to_and_fro(count: int) -> np.ndarray:
    """Numbers from 0 to 1 and back, four times, in small steps."""
    return 0.5 * (1.0 - np.cos(np.linspace(0.0, 8.0 * np.pi, count)))


def tilts(count: int) -> list[dict[str, Any]]:
    """Load cases of a slider that is dragged."""
    return [{"tilt": TILT * float(share)} for share in to_and_fro(count)]


def drags(model: drystone.Model, count: int) -> dict[str, list[dict[str, Any]]]:
    """Load cases by what is dragged."""
    assembly = model.assembly
    top = max(assembly.free, key=lambda i: assembly.centroid[i, 2])
    weight = 9.81 * float(assembly.mass[top])
    foot = int(np.flatnonzero(assembly.fixed)[-1])
    out = assembly.centroid[foot] - assembly.centroid.mean(axis=0)
    way = MOVE * float(np.median(assembly.size)) * np.sign(out[0] or 1.0)
    shares = [float(share) for share in to_and_fro(count)]

    def pushed(share: float) -> dict[str, Any]:
        return {"pushes": [{"block": assembly.names[top], "force": [PUSH * weight * share, 0, 0]}]}

    def moved(share: float) -> dict[str, Any]:
        by = [float(way) * (0.1 + 0.9 * share), 0.0, 0.0]
        return {"moves": [{"block": assembly.names[foot], "by": by}]}

    return {
        "tilt": tilts(count),
        "push": [pushed(one) for one in shares],
        "support": [moved(one) for one in shares],
    }


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


def latency(file: Path, wishes: int) -> None:
    """Print a row for each thing that is dragged."""
    model = io.read(file)
    for what, cases in drags(model, wishes).items():
        with Live(file, port=0) as live:
            asker = Asker(live)
            first = asker.wish(cases[0])
            began = spent(live)
            times = [asker.wish(one) for one in cases]
            each = (spent(live) - began) / len(cases)
            whole = asker.wish(cases[len(cases) // 8], "whole")
            print(
                f"| {file.stem} | {len(model)} | {what} | {1e3 * first:.0f} "
                f"| {1e3 * statistics.median(times):.0f} | {1e3 * max(times):.0f} "
                f"| {1e3 * each:.0f} | {whole:.2f} |",
                flush=True,
            )


def interrupted(file: Path, tries: int) -> None:
    """Print how long a wish takes that ends something longer, begun 1, 2, 3 ... s before."""
    moved = drags(io.read(file), 8)["support"][4]
    for task in ("limit", "mends", "plan", "following"):
        times = []
        for seconds in range(1, tries + 1):
            with Live(file, port=0) as live:
                asker = Asker(live)
                asker.wish({})
                if task == "following":
                    asker.wish(moved)
                else:
                    asker.task(task, {"friction": 0.1} if task == "mends" else {})
                time.sleep(seconds)
                times.append(asker.wish({"tilt": 0.5}))
        print(
            f"| {file.stem} | {task} | {1e3 * statistics.median(times):.0f} "
            f"| {1e3 * max(times):.0f} |",
            flush=True,
        )


def growth(file: Path, many: int) -> None:
    """Print what is held before and after many wishes."""
    with Live(file, port=0) as live:
        asker = Asker(live)
        for one in tilts(50):  # caches are filled
            asker.wish(one)
        before = holdings(live)
        for one in tilts(many):
            asker.wish(one)
        after = holdings(live)
    print(f"\n| {many} wishes | before | after |\n|---|---|---|")
    for name, value in before.items():
        print(f"| {name} | {value} | {after[name]} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "models", nargs="*", default=list(OURS), help="one of ours, or a file of supports"
    )
    parser.add_argument("--wishes", type=int, default=WISHES)
    parser.add_argument("--many", type=int, default=MANY, help="wishes of the look at growth")
    parser.add_argument("--tries", type=int, default=TRIES, help="of ending something longer")
    chosen = parser.parse_args()
    load = f", load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
    print(f"drystone {drystone.__version__}, commit {commit()}; {processor()}{load}")
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for name in chosen.models:
            file = Path(name)
            if name in OURS:
                file = Path(folder) / f"{name}.json"
                made, friction = OURS[name]
                io.write(drystone.Model.of(made(), friction=friction), file)
            files.append(file)
        if chosen.wishes:
            print(
                "| model | blocks | dragged | first [ms] | median [ms] | worst [ms] "
                "| CPU by wish [ms] | whole [s] |\n|---|---|---|---|---|---|---|---|"
            )
            for file in files:
                latency(file, chosen.wishes)
        if chosen.tries:
            print("\n| model | what is ended | median [ms] | worst [ms] |\n|---|---|---|---|")
            for file in files:
                interrupted(file, chosen.tries)
        if chosen.many:
            growth(files[0], chosen.many)


if __name__ == "__main__":
    main()
