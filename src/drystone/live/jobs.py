"""The jobs that come through a pipe, read by a thread that can interrupt the one under way."""

from __future__ import annotations

import contextlib
import ctypes
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import Any


class Cancelled(BaseException):
    """Nobody waits for the answer any more.

    No ``Exception``, so that no analysis takes it for a failure of its own: it may come between any
    two lines, as Ctrl-C does.
    """


class Jobs:
    """Messages of the server, one after the other, and the way back.

    The thread that makes it is the one that works. A job that is cancelled is interrupted where it
    is, once: an analysis need not ask. Where the interruption is lost, in a callback of compiled
    code, :attr:`cancelled` still tells. Nothing is interrupted while it is sent.
    """

    def __init__(self, pipe: Connection, gone: Callable[[], None]) -> None:
        self._pipe, self._gone = pipe, gone
        self._messages: SimpleQueue[dict[str, Any]] = SimpleQueue()
        self._gate = threading.RLock()
        self._worker = ctypes.c_ulong(threading.get_ident())
        self._now = self._dropped = 0
        threading.Thread(target=self._read, daemon=True, name="drystone-jobs").start()

    @property
    def cancelled(self) -> bool:
        """Whether nobody waits for the job under way."""
        return self._now == self._dropped

    def next(self) -> dict[str, Any]:
        """The next message; waits for it."""
        return self._messages.get()

    def send(self, event: dict[str, Any]) -> None:
        """Tell the server something, as a whole; it may be gone, as where it was killed."""
        try:
            with self._gate:
                self._pipe.send(event)
        except ConnectionError:
            self._gone()

    def do(self, job: int, work: Callable[[], None]) -> None:
        """Work until it has ended or is cancelled."""
        try:
            with self._gate:
                self._now = job
            if not self.cancelled:
                work()
            self._end()
        except Cancelled:  # once in a job, so that the end is not interrupted again
            self._end()

    def _end(self) -> None:
        self._gate.acquire()
        self._now = 0
        ctypes.pythonapi.PyThreadState_SetAsyncExc(self._worker, None)
        # since Python 3.14 an interruption may come when a gate is taken and not yet to be let go
        with contextlib.suppress(RuntimeError):
            while True:
                self._gate.release()

    def _read(self) -> None:
        """Read until the server is gone."""
        try:
            while True:
                message = self._pipe.recv()
                if "cancel" in message:
                    self._cancel(message["cancel"])
                else:
                    self._messages.put(message)
        except (EOFError, OSError):
            self._gone()

    def _cancel(self, job: int) -> None:
        with self._gate:
            if job == self._now != self._dropped:
                raised = ctypes.py_object(Cancelled)
                ctypes.pythonapi.PyThreadState_SetAsyncExc(self._worker, raised)
            self._dropped = job
