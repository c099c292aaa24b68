"""Workers that check stages: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from typing import Any, TypeAlias

from drystone.base.errors import InputError, MissingDependency

ExecutorFactory: TypeAlias = Callable[[], Executor]
"""Starts workers; called again when the failure of a worker broke the executor."""


@dataclass(frozen=True)
class LocalWorkers:
    """Starts worker processes on this machine: an :data:`ExecutorFactory`.

    Attributes
    ----------
    count
    """

    count: int

    def __call__(self) -> Executor:
        """Start the workers."""
        # spawned, not forked: a fork does not copy the threads of numerical libraries
        context = multiprocessing.get_context("spawn")
        executor = ProcessPoolExecutor(self.count, mp_context=context, initializer=end_with_parent)
        with _interrupts_ignored():
            for _ in range(self.count):
                executor.submit(int)  # starts a process
        return executor


def end_with_parent() -> None:
    """End this worker process when the process that started it is killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Processes started meanwhile ignore Ctrl-C, which reaches every process of a terminal.

    Only the main process handles it, so there is one message.
    """
    before = signal.getsignal(signal.SIGINT)
    if before is None or threading.current_thread() is not threading.main_thread():
        yield  # it cannot be set or restored
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@dataclass(frozen=True)
class DaskWorkers:
    """Uses a running Dask scheduler: an :data:`ExecutorFactory`.

    Attributes
    ----------
    address
        Such as ``tcp://127.0.0.1:8786``.
    timeout_s
        Longest time to wait for an answer.
    """

    address: str
    timeout_s: float = 5.0

    def __call__(self) -> Executor:
        """Connect.

        Raises
        ------
        MissingDependency
            Dask is not installed.
        InputError
            There is no scheduler at the address.
        """
        try:
            from distributed import Client  # optional: a cluster
        except ImportError as error:
            raise MissingDependency("distributed", extra="cluster", purpose="Dask") from error
        connect: Any = Client
        try:
            client = connect(self.address, timeout=self.timeout_s, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError(
                f"no Dask scheduler answers at '{self.address}'",
                where="dask",
                remedy="start one with 'dask scheduler'",
            ) from error
        if not client.scheduler_info()["workers"]:
            client.close()
            raise InputError(
                f"the Dask scheduler at '{self.address}' has no workers",
                where="dask",
                remedy=f"start some with 'dask worker {self.address}'",
            )
        return _DaskExecutor(client)


class _DaskExecutor(Executor):
    """A Dask client as an executor; Dask moves the work of a failed worker to another one."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._payload: tuple[bytes, Any] | None = None
        self._max_workers = max(1, len(client.scheduler_info()["workers"]))

    def submit(  # type: ignore[override]
        self, function: Callable[..., Any], payload: bytes, /, *arguments: Any
    ) -> Future[Any]:
        """Submit one task; a payload is sent once."""
        if self._payload is None or self._payload[0] is not payload:
            self._payload = (payload, self._client.scatter(payload, broadcast=True, hash=True))
        future: Future[Any] = self._client.submit(
            function, self._payload[1], *arguments, pure=False, retries=3
        )
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: ARG002
        """Disconnect; the scheduler keeps running."""
        self._client.close()


__all__ = ["DaskWorkers", "ExecutorFactory", "LocalWorkers", "end_with_parent"]
