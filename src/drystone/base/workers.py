"""Work side by side, on executors: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
)
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice
from multiprocessing.process import BaseProcess
from typing import Any, TypeAlias, TypeVar

from drystone.base.errors import DrystoneError, InputError, quoted, require

Item = TypeVar("Item")
Found = TypeVar("Found")

_log = logging.getLogger(__name__)

_AHEAD = 64
"""Items that are given to the workers before their answers are asked for: enough for some tens of
workers, and few enough to be kept in memory."""
LOST_WORKER = (BrokenExecutor, CancelledError, OSError)
"""What an answer raises when its worker has died, or the scheduler or the network to it."""
POLL_S = 0.1
"""Time between two looks at the clock while an answer is waited for."""

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
        executor = ProcessPoolExecutor(self.count, mp_context=context, initializer=_end_with_parent)
        with _interrupts_ignored():
            for _ in range(self.count):
                executor.submit(int)  # starts a process
        return executor


def _end_with_parent() -> None:
    """End this worker process when the process that started it is killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)


class WorkerPool:
    """The workers of one calculation, or this process where there are none.

    Parameters
    ----------
    given
        An executor; or a function that starts one. That one is started again when a worker dies,
        and is shut down at the end.
    needed
        Whether it is an error when a worker died and none can be started again. Otherwise the work
        goes on in this process.
    """

    def __init__(self, given: Executor | ExecutorFactory | None, *, needed: bool = True) -> None:
        self.needed = needed
        executor = isinstance(given, Executor) or hasattr(given, "submit")
        self._executor: Any = given if executor else None
        self._factory: Any = None if executor else given
        self._futures: deque[Future[Any]] = deque()

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    @property
    def executor(self) -> Executor | None:
        """The executor, which is started now if it was not yet."""
        if self._executor is None and self._factory is not None:
            made = self._factory()
            if not hasattr(made, "submit"):
                said = f"what the executor's function starts is {quoted(made)}"
                raise InputError(said, remedy="give LocalWorkers(2), or an executor")
            self._executor = made
        return self._executor

    @property
    def count(self) -> int:
        """Number of workers, 0 without; 2 where an executor does not tell."""
        executor = self.executor
        return 0 if executor is None else int(getattr(executor, "_max_workers", None) or 2)

    def answers(
        self,
        task: Callable[[Item], Found],
        items: Iterable[Item],
        late: Callable[[], bool] = bool,
        *,
        ahead: int | None = None,
        failed: Callable[[Item], Found] | None = None,
    ) -> Iterator[Found]:
        """The answers of a task in the order of its items.

        Parameters
        ----------
        task
            For worker processes it must be a function that another process can import.
        items
        late
            Called before every answer, and often while one is waited for; True ends the work.
        ahead
            Number of items per worker that are taken before their answers are known; 64 items in
            all when left out.
        failed
            The answer of an item that ended its worker twice; an error when left out.

        Raises
        ------
        InputError
            A worker died that cannot be started again, or twice at the same item.
        """
        if self.executor is None:
            yield from _here(task, items, late)
            return
        window = _AHEAD
        if ahead is not None:
            window = ahead * self.count
        left = iter(items)
        taken: deque[Item] = deque()
        futures: deque[Future[Found]] = deque()
        self._futures = futures
        deaths = _Deaths()
        try:
            while not late():
                try:
                    for item in islice(left, (1 if deaths.alone else window) - len(taken)):
                        taken.append(item)
                        futures.append(self._submit(task, item))
                    if not taken or not _done(futures[0], late):
                        return
                    answer = futures[0].result()
                except LOST_WORKER as error:
                    again = list(taken)
                    taken.clear()
                    futures.clear()
                    if not self._revived(error):
                        yield from _here(task, chain(again, left), late)
                        return
                    if deaths.caused_by(again):
                        if failed is None:
                            raise InputError(
                                "a worker process ended twice at the same part of the work",
                                remedy="give fewer workers, or none",
                            ) from error
                        yield failed(again.pop(0))
                    left = chain(again, left)
                else:
                    taken.popleft()
                    futures.popleft()
                    deaths.alone = max(deaths.alone - 1, 0)
                    yield answer
        finally:
            for future in futures:
                future.cancel()

    def _submit(self, task: Callable[[Item], Found], item: Item) -> Future[Found]:
        executor = self.executor
        assert executor is not None
        return executor.submit(task, item)

    def _revived(self, error: BaseException) -> bool:
        """Whether workers were started again after the death of one."""
        _log.warning("a worker died (%s); its work is done again", " ".join(str(error).split()))
        if self._factory is None and self.needed:
            raise InputError(
                f"a worker died: {' '.join(str(error).split())}",
                remedy="give LocalWorkers(2), which is started again, and call again to go on",
            ) from error
        self.end()
        if self._factory is None or self.needed:
            self._executor = None
            return self._factory is not None
        try:
            self._executor = self._factory()
        except DrystoneError:
            self._factory = None  # it is gone for good
        return self._factory is not None

    def end(self) -> None:
        """Shut down what was started here; what still runs is of no use, and is ended."""
        if self._factory is None or self._executor is None:
            return
        busy = any(not (future.cancel() or future.done()) for future in self._futures)
        # of this machine; without ending them Python waits for them before it exits
        processes = list((getattr(self._executor, "_processes", None) or {}).values())
        ended = processes if busy else []
        for process in ended:
            process.terminate()
        # the thread that looks after them closes a pipe, to which Python writes when it exits
        self._executor.shutdown(wait=bool(ended), cancel_futures=True)
        self._executor = None


def _here(
    task: Callable[[Item], Found], items: Iterable[Item], late: Callable[[], bool]
) -> Iterator[Found]:
    """The answers of a task in this process."""
    for item in items:
        if late():
            return
        yield task(item)


@dataclass
class _Deaths:
    """The search for the item that ends its worker: after a death items are asked one by one."""

    alone: int = 0
    suspect: object = None

    def caused_by(self, items: Sequence[object]) -> bool:
        """Whether the first of the items, with which a worker died, did it: twice, and alone.

        Another program may have ended the worker once.
        """
        if not self.alone:
            self.alone = len(items)
        elif self.suspect is not items[0]:
            self.suspect = items[0]
        else:
            self.alone -= 1
            return True
        return False


def _done(future: Future[Any], late: Callable[[], bool]) -> bool:
    """Wait for an answer; False when it is late before."""
    while not future.done() and not late():
        with suppress(TimeoutError):
            future.result(timeout=POLL_S)
    return future.done()


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
        require("distributed", "cluster", "Dask")
        from distributed import Client  # optional: a cluster

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
        self._function: tuple[Callable[..., Any], Any] | None = None
        self._max_workers = max(1, len(client.scheduler_info()["workers"]))

    def submit(  # type: ignore[override]
        self, function: Callable[..., Any], /, *arguments: Any
    ) -> Future[Any]:
        """Submit one task; a function, with what is bound to it, is sent once."""
        if self._function is None or self._function[0] is not function:
            self._function = (function, self._client.scatter(function, broadcast=True, hash=False))
        found = self._client.submit(_called, self._function[1], *arguments, pure=False, retries=3)
        # a wait for a future of Dask that is given up cancels what comes meanwhile
        future: Future[Any] = Future()
        future.add_done_callback(lambda one: found.cancel() if one.cancelled() else None)
        found.add_done_callback(partial(_pass_on, future))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: ARG002
        """Disconnect; the scheduler keeps running."""
        of_client = logging.getLogger("distributed.client")
        before, of_client.disabled = of_client.disabled, True  # of a dead one it shows a traceback
        try:
            self._client.close()
        finally:
            of_client.disabled = before


def _pass_on(future: Future[Any], found: Any) -> None:
    """Give the answer, or the error, of a future of Dask to one of Python."""
    if not future.set_running_or_notify_cancel():
        return
    try:
        future.set_result(found.result())
    except Exception as error:  # whatever the task, the worker or the network raises
        future.set_exception(error)


def _called(function: Callable[..., Any], *arguments: Any) -> Any:
    return function(*arguments)
