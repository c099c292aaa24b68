"""Progress and early end of long calculations, and workers that are lost."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, CancelledError
from typing import TypeAlias

Progress: TypeAlias = Callable[[str, int, int], None]
"""Called as ``progress(stage, done, total)`` with 0 <= done <= total; it must not raise.
It cannot stop the work: use ``stop``."""

LOST_WORKER = (BrokenExecutor, CancelledError, OSError)
"""What an answer raises when its worker has died, or the scheduler or the network to it."""


class Clock:
    """Time since the start, the limit, and the caller's request to stop; once late, always late."""

    def __init__(self, limit_s: float, stop: Callable[[], bool] | None = None) -> None:
        self.began = time.perf_counter()
        self.limit_s = limit_s
        self.wish = stop
        self.reason = ""

    @property
    def elapsed_s(self) -> float:
        """[s]."""
        return time.perf_counter() - self.began

    @property
    def left_s(self) -> float:
        """[s], until the limit."""
        return max(self.limit_s - self.elapsed_s, 0.0)

    def late(self) -> bool:
        """Whether to stop now with the results so far; ``reason`` then says why."""
        if not self.reason:
            if self.wish is not None and self.wish():
                self.reason = "it was interrupted"
            elif self.elapsed_s > self.limit_s:
                self.reason = "the time was up"
        return bool(self.reason)
