"""Where a measurement was made, and how a process is kept to one thread and a share of time."""

from __future__ import annotations

import json
import os
import platform
import resource
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import drystone

ROOT = Path(__file__).parents[1]

LIBRARIES = ("OPENBLAS", "OMP", "MKL", "RAYON")
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in LIBRARIES}
"""Read by the libraries when they are loaded: set before the measured process starts."""


def processor() -> str:
    """Name of the CPU."""
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def commit() -> str:
    """Commit of the working tree, and whether it was changed since."""
    try:
        name = _git("rev-parse", "--short", "HEAD")
        return name + (" with changes" if _git("status", "--porcelain", "src") else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def _git(*arguments: str) -> str:
    command = ["git", "-C", str(ROOT), *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def description() -> str:
    """Versions, CPU, commit and how busy the machine was, in one sentence each."""
    packages = ", ".join(
        f"{name} {version(name)}" for name in ("numpy", "scipy", "shapely", "clarabel")
    )
    busy = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    return (
        f"drystone {drystone.__version__}, commit {commit()}; Python {platform.python_version()}, "
        f"{packages}; {processor()}, {os.cpu_count()} cores, {platform.system()}; load average "
        f"{busy} at the start."
    )


@contextmanager
def checkout_of(reference: str) -> Iterator[Path]:
    """Another commit, checked out beside this one."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "before"
        _git("worktree", "add", "--detach", str(place), reference)
        try:
            yield place
        finally:
            _git("worktree", "remove", "--force", str(place))


def ask(command: Sequence[str | Path], limit_s: float, checkout: Path = ROOT) -> dict[str, Any]:
    """The JSON that a process of one thread prints last; ``failed`` says why there is none.

    Parameters
    ----------
    command
    limit_s : [s]
        CPU time after which the process is ended.
    checkout
        Where the process imports drystone and the benchmarks from: a commit is asked by its own
        benchmark, so that the interface of the package may differ between two commits.
    """
    limited: Callable[[], None] = partial(
        resource.setrlimit, resource.RLIMIT_CPU, (int(limit_s), int(limit_s) + 5)
    )
    done = subprocess.run(
        [str(part) for part in command],
        env=os.environ | ONE_THREAD | {"PYTHONPATH": str(checkout / "src")},
        cwd=checkout,
        capture_output=True,
        text=True,
        preexec_fn=limited,
        check=False,
    )
    if done.returncode < 0:
        return {"failed": f"none after {limit_s:.0f} s", "stopped": True}
    if done.returncode > 0:
        words = done.stderr.strip().splitlines()
        return {"failed": words[-1] if words else f"exit {done.returncode}"}
    answer: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return answer
