"""The process that computes, seen from the server: started, asked, ended when it does not stop.

The page has one, and so have the calls of the JSON interface, which come one after the other.
"""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from drystone.base.workers import POLL_S
from drystone.live.calculator import calculate
from drystone.mcp.folder import Folder

_GRACE = 3.0
"""[s] from cancelling a job to ending the process that does not stop. Chosen: a job is interrupted
between two lines of Python, and one call of compiled code takes less than a second."""
_START = 120.0
"""[s] for the process to start. Chosen: it takes one or two, and a hundred on a crowded machine."""

_FORKS = sys.platform == "linux"
"""Whether processes are forked from one that has loaded what computes: another one starts in 0.05 s
of CPU, not 0.8. As Python 3.14 does; elsewhere libraries of the system refuse forks."""

_ENDED = (
    "the calculation ended without an answer, perhaps because memory ran out",
    "give a smaller model",
)
_NOT_STARTED = (
    "the process that computes ended before it was ready",
    "see what it wrote; in a script, start the server below: if __name__ == '__main__':",
)

_WAITING = 8
"""Calls that may wait for the one that is computed, chosen."""


class Helper:
    """One process, and the job that it works on. Only one thread may call :meth:`run`."""

    def __init__(self) -> None:
        self._context: Any = multiprocessing.get_context("forkserver" if _FORKS else "spawn")
        if _FORKS:
            self._context.set_forkserver_preload([calculate.__module__])
        self._lock = threading.Lock()
        self._process: Any = None
        self._pipe: Any = None
        self._job = 0
        self._cancelled_at: float | None = None
        self._closed = self._ready = False
        self.knows: set[int] = set()

    def start(self) -> None:
        """Start the process where there is none."""
        with self._lock:
            if self._closed or (self._process is not None and self._process.is_alive()):
                return
            self._end()
            ours, theirs = self._context.Pipe()
            process = self._context.Process(target=calculate, args=(theirs,), daemon=True)
            process.start()
            theirs.close()
            self._process, self._pipe, self.knows, self._ready = process, ours, set(), False

    def run(
        self,
        message: Mapping[str, Any],
        hear: Callable[[dict[str, Any]], None],
        seconds: float,
        wanted: Callable[[], bool] = lambda: True,
    ) -> None:
        """Let it do a job; ``hear`` is given every event. Returns when the job has ended.

        A process that crashes, or has not ended the job after some seconds, is replaced by another.
        A job that is no longer wanted is cancelled.
        """
        self.start()
        with self._lock:
            if self._pipe is None:
                return
            self._job += 1
            self._cancelled_at = None
            pipe, job = self._pipe, self._job
            try:
                pipe.send({**message, "job": job})
            except OSError:
                self._end()
        end = time.monotonic() + seconds + (0.0 if self._ready else _START)
        while not self._closed:
            if not wanted():
                self.cancel()
            try:
                if pipe.poll(POLL_S):
                    event = pipe.recv()
                    if event["event"] == "ready":
                        self._ready, end = True, time.monotonic() + seconds
                        continue
                    if event["event"] == "done":
                        return
                    if self._cancelled_at is None:
                        hear(event)
                    continue
            except (EOFError, OSError):
                why = _ENDED if self._ready else _NOT_STARTED
                self._replace()
                if self._cancelled_at is None:
                    hear(_failed(*why))
                return
            now = time.monotonic()
            if self._cancelled_at is not None and now - self._cancelled_at > _GRACE:
                self._replace()
                return
            if now > end:
                self._replace()
                hear(_failed(f"no answer within {seconds:g} s", "give a smaller model, or start "
                             "the server with a larger --time-limit"))  # fmt: skip
                return

    def cancel(self) -> None:
        """Ask the job that is under way to stop; its further events are not heard."""
        with self._lock:
            if self._pipe is None or self._cancelled_at is not None:
                return
            self._cancelled_at = time.monotonic()
            with contextlib.suppress(OSError):
                self._pipe.send({"cancel": self._job})

    def close(self) -> None:
        """End the process for good."""
        with self._lock:
            self._closed = True
            self._end()

    def _replace(self) -> None:
        with self._lock:
            self._end()
        self.start()

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process.close()
        if self._pipe is not None:
            self._pipe.close()
        self._process = self._pipe = None


def _failed(what: str, remedy: str) -> dict[str, Any]:
    return {"event": "error", "what": what, "where": "", "remedy": remedy, "late": True}


class ToolCalls:
    """Calls of the JSON interface: one after the other, in a process of their own.

    The process is started with the first call.
    """

    def __init__(self, folder: Folder, seconds: float) -> None:
        self.folder, self.seconds = folder, seconds
        self.helper = Helper()
        self._one = threading.Lock()
        self._room = threading.BoundedSemaphore(_WAITING)

    def call(self, tool: str, body: bytes) -> tuple[int, str]:
        """The status of the protocol and the answer, or an error in words."""
        if not self._room.acquire(blocking=False):
            return 503, _error(f"{_WAITING} calls are waiting", "try again")
        try:
            with self._one:
                heard: list[dict[str, Any]] = []
                message = {"do": "tool", "tool": tool, "body": body, "folder": self.folder,
                           "seconds": self.seconds}  # fmt: skip
                self.helper.run(message, heard.append, 1.2 * self.seconds)
        finally:
            self._room.release()
        for event in heard:
            if event["event"] == "answer":
                return 200, str(event["answer"])
            if event["event"] == "error":
                status = 504 if event.get("late") else 400
                return status, _error(event["what"], event["remedy"], event["where"])
        return 503, _error("the server is closing", "start it again")

    def close(self) -> None:
        """End the process."""
        self.helper.close()


def _error(what: str, remedy: str, where: str = "") -> str:
    return json.dumps({"error": {"what": what, "where": where, "remedy": remedy}})
