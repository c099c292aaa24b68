"""Progress of running work on stderr, and Ctrl-C."""

from __future__ import annotations

import signal
import sys
import threading
import time
from _thread import interrupt_main
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drystone.base.errors import clean
from drystone.cli.output import INTERRUPTED

if TYPE_CHECKING:
    from rich.progress import Progress

    from drystone.base.workers import DaskWorkers, LocalWorkers

PATIENCE = 1.0
"""Time [s], about, before progress is shown."""
NOTHING = "nothing was written"
_REQUESTS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
_STOPPING = "stopping (Ctrl-C again ends at once)"


class Waiting:
    """Shows stages and their progress inside its context.

    Where stderr is no terminal it has a line, once the work takes long, and one for each later
    stage that does; one that goes on is told again, with how far it is and its seconds. So it has
    everywhere before the context: imports take seconds on a busy machine.

    An instance is the progress callback of the library: ``(stage, done, total)``.

    Attributes
    ----------
    time_s
        Seconds spent in each stage that was announced with :meth:`stage`.
    shown
        Set once the bar is on the terminal.
    interrupted
        Whether Ctrl-C asked to stop with what is known so far.
    wrote
        Names of the files that are written.
    checkpoint
        File with answers for the next run.
    asks
        Whether questions may be asked in a terminal.
    """

    def __init__(self, asks: bool = True) -> None:
        self.asks = asks
        self.time_s: dict[str, float] = {}
        self.shown = threading.Event()
        self.interrupted = False
        self.wrote: list[str] = []
        self.checkpoint: Path | None = None
        self._begun: tuple[str, float] | None = None
        self._state = ("", 0, 0)
        self._doing = ""
        self._due = self._told = False
        self._bar: Progress | None = None
        self._timer: threading.Timer | None = None
        self._lock = threading.RLock()  # Ctrl-C may leave it taken since Python 3.14
        UNDER_WAY.set(self)
        if sys.stderr is sys.__stderr__:  # not where a program keeps what is said
            self._begin(1.5 * PATIENCE, self._tell)

    def __enter__(self) -> Waiting:
        from rich.console import Console  # slow to import

        self._console = Console(stderr=True)
        if self._console.is_terminal:
            self.close()
            self._told = False
            self._begin(0.5 * PATIENCE, self._show)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.end_stage()
        self.close()
        if kind is KeyboardInterrupt:
            from multiprocessing import active_children  # the commands start fast

            for child in active_children():  # their answers are not needed any more
                child.terminate()

    def _begin(self, after: float, action: Callable[[], None]) -> None:
        """Show what is done after so many seconds."""
        self._timer = threading.Timer(after, action)
        self._timer.daemon = True
        self._timer.start()

    def close(self) -> None:
        """Show nothing from here on."""
        if self._timer is not None:
            self._timer.cancel()
        with self._lock:
            self._timer, bar, self._bar, self._due = None, self._bar, None, False
            if bar is not None:
                bar.stop()

    @contextmanager
    def stoppable(self) -> Iterator[Callable[[], bool]]:
        """In this context the first Ctrl-C asks the work to stop, and the second ends the program.

        So do a request to end and a closed terminal (SIGTERM, SIGHUP), which keep what is known so
        far too. Yields the function ``stop`` of the library.
        """
        requests = _handled_by(signal.default_int_handler)

        def ask(*_: object) -> None:
            for one in requests:
                signal.signal(one, signal.default_int_handler)
            self.interrupted = True
            self(_STOPPING, 0, 0)

        for one in requests:
            signal.signal(one, ask)
        try:
            yield lambda: self.interrupted
        finally:
            for one in requests:
                signal.signal(one, signal.default_int_handler)

    @contextmanager
    def keywords(
        self, time_limit: float | None = None, workers: int | str = 1
    ) -> Iterator[dict[str, Any]]:
        """The keywords of everything that takes long, where the first Ctrl-C asks it to stop."""
        limit, executor = float("inf") if time_limit is None else time_limit, executor_of(workers)
        with self.stoppable() as stop:
            yield {"executor": executor, "progress": self, "stop": stop, "time_limit_s": limit}

    def exit_code(self, code: int) -> int:
        """The exit code of an answer; 130 after Ctrl-C."""
        return INTERRUPTED if self.interrupted else code

    def stage(self, key: str, wording: str) -> None:
        """Begin a stage: its time is added under ``key``; ``wording`` is shown."""
        self.end_stage()
        self._begun = (key, time.perf_counter())
        self._doing = clean(wording)
        self(wording, 0, 0)
        if self._due:
            self._tell()
        elif self._told and self._timer is not None:
            self._timer.cancel()
            self._begin(1.5 * PATIENCE, self._tell)

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Progress of the running work; a total of zero means that it is not known."""
        if self.interrupted:
            stage, done, total = _STOPPING, 0, 0
        stage = clean(stage)  # file names may have control characters
        self._state = (stage, done, total)
        if self._bar is not None:
            self._bar.update(
                self._bar.task_ids[0], description=stage, completed=done, total=total or None
            )

    def left(self) -> str:
        """What remains of work that was interrupted."""
        if self.wrote:
            return f"wrote {', '.join(self.wrote)}"
        if self.checkpoint is not None and self.checkpoint.exists():
            return (
                f"'{self.checkpoint}' keeps what was found, the same command goes on from there; "
                "nothing else was written"
            )
        return NOTHING

    def ask(self, question: str) -> bool:
        """The answer of whoever sits at the terminal; no where nobody does."""
        if not (self.asks and self._at_terminal):
            return False
        with self._lock:  # the bar would be drawn over the question
            if self._bar is not None:
                self._bar.stop()
        answer = self._console.input(f"{clean(question)} [y/N] ", markup=False)
        with self._lock:
            if self._bar is not None:
                self._bar.start()
        return answer.strip().lower() in ("y", "yes")

    @property
    def _at_terminal(self) -> bool:
        return bool(sys.stdin and sys.stdin.isatty() and self._console.is_terminal)

    def warn(self, text: str) -> None:
        """Say on stderr, before the work, what nobody can be asked."""
        with self._lock, suppress(OSError, ValueError):  # closed or full: nobody reads it
            if self.asks and not self._at_terminal and sys.stderr is not None:
                print(f"drystone: {clean(text)}", file=sys.stderr, flush=True)

    def end_stage(self) -> None:
        """Add the time of the running stage."""
        if self._begun is not None:
            key, since = self._begun
            self.time_s[key] = self.time_s.get(key, 0.0) + time.perf_counter() - since
            self._begun = None

    def _tell(self) -> None:
        with self._lock:
            if self._timer is None or sys.stderr is None:
                return
            self._told = True
            self._due = self._begun is None  # the stage is told once it begins
            stage, done, total = self._state
            told = f"{stage}, {done} of {total}" if done < total else self._doing or "starting"
            if self._begun is not None:
                since = time.perf_counter() - self._begun[1]
                told += f", after {since:.0f} s" if since > 2.0 else ""
                self._begin(max(10.0 * PATIENCE, since), self._tell)  # twice as long each time
            with suppress(OSError, ValueError):  # closed or full: nobody reads it
                print(f"drystone: {told} ...", file=sys.stderr, flush=True)

    def _show(self) -> None:
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        with self._lock:
            if self._timer is None:
                return
            told = TextColumn("{task.description}", markup=False)
            shown = (told, BarColumn(), TimeElapsedColumn())
            bar = Progress(*shown, console=self._console, transient=True)
            stage, done, total = self._state
            bar.add_task(stage, completed=done, total=total or None)
            bar.start()
            self._bar = bar
        self.shown.set()


def executor_of(workers: int | str) -> LocalWorkers | DaskWorkers | None:
    """So many processes of this machine, or the workers of the Dask scheduler at an address."""
    if workers == 1:
        return None
    from drystone.base.workers import DaskWorkers, LocalWorkers  # the program starts fast

    return DaskWorkers(workers) if isinstance(workers, str) else LocalWorkers(workers)


UNDER_WAY: ContextVar[Waiting | None] = ContextVar("UNDER_WAY", default=None)
"""The running work of the command, if it has begun."""


@contextmanager
def ends_as_ctrl_c() -> Iterator[None]:
    """In this context a request to end and a closed terminal (SIGTERM, SIGHUP) are as Ctrl-C.

    One that is ignored, as ``nohup`` has it, stays ignored.
    """
    requests, told = _handled_by(signal.SIG_DFL), sys.unraisablehook
    for one in requests:
        signal.signal(one, signal.default_int_handler)
    sys.unraisablehook = partial(_not_lost, told)
    try:
        yield
    finally:
        sys.unraisablehook = told
        for one in requests:
            signal.signal(one, signal.SIG_DFL)


def _not_lost(told: Callable[[Any], object], lost: Any) -> None:
    """Send a request to end again that came where Python drops errors, as where a value is freed.

    It is sent from another thread, so that it does not come in here. Other errors are told.
    """
    if lost.exc_type is not KeyboardInterrupt:
        told(lost)
    elif heard := [one for one in _REQUESTS if callable(signal.getsignal(one))]:
        threading.Timer(0.01, interrupt_main, heard[:1]).start()


def _handled_by(handler: object) -> list[signal.Signals]:
    """The requests to end that a handler answers; none in other threads, which cannot set one."""
    if threading.current_thread() is not threading.main_thread():
        return []
    return [one for one in _REQUESTS if signal.getsignal(one) is handler]
