"""A progress bar on stderr, for people, once work takes longer than a second."""

from __future__ import annotations

import threading
import time
from types import TracebackType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress

PATIENCE = 1.0
"""[s] before anything is shown."""


class Waiting:
    """Shows stages and their progress while it is entered; silent when stderr is no terminal.

    An instance is itself the progress callback of the library: ``(stage, done, total)``.

    Attributes
    ----------
    time_s
        Seconds spent in each stage that was announced with :meth:`stage`.
    shown
        Set once the bar is on the terminal.
    """

    def __init__(self) -> None:
        self.time_s: dict[str, float] = {}
        self.shown = threading.Event()
        self._begun: tuple[str, float] | None = None
        self._state = ("", 0, 0)
        self._bar: Progress | None = None
        self._timer: threading.Timer | None = None
        self._lock = threading.Lock()

    def __enter__(self) -> Waiting:
        from rich.console import Console  # slow to import

        self._console = Console(stderr=True)
        if self._console.is_terminal:
            self._timer = threading.Timer(PATIENCE, self._show)
            self._timer.daemon = True
            self._timer.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end_stage()
        if self._timer is not None:
            self._timer.cancel()
        with self._lock:
            self._timer = None
            if self._bar is not None:
                self._bar.stop()

    def stage(self, key: str, wording: str) -> None:
        """Begin a stage: its time is added up under ``key``, ``wording`` is shown."""
        self._end_stage()
        self._begun = (key, time.perf_counter())
        self(wording, 0, 0)

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Progress of the work that is under way; a total of zero means that it is not known."""
        self._state = (stage, done, total)
        if self._bar is not None:
            self._bar.update(
                self._bar.task_ids[0], description=stage, completed=done, total=total or None
            )

    def _end_stage(self) -> None:
        if self._begun is not None:
            key, since = self._begun
            self.time_s[key] = self.time_s.get(key, 0.0) + time.perf_counter() - since
            self._begun = None

    def _show(self) -> None:
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        with self._lock:
            if self._timer is None:
                return
            columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
            bar = Progress(*columns, console=self._console, transient=True)
            stage, done, total = self._state
            bar.add_task(stage, completed=done, total=total or None)
            bar.start()
            self._bar = bar
        self.shown.set()
