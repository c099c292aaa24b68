"""A file that is read anew when it was saved anew."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

PERIOD = 0.25
"""[s] between two looks at a file. A file counts as saved once two looks see the same."""


class Watch:
    """Calls a function after a file was saved, in a thread of its own."""

    def __init__(self, path: Path, saved: Callable[[], None]) -> None:
        self.path, self._saved = path, saved
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True, name="drystone-watch")
        self._thread.start()

    def close(self) -> None:
        """Look no more."""
        self._end.set()
        self._thread.join()

    def _look(self) -> None:
        told = last = self._state()
        while not self._end.wait(PERIOD):
            now = self._state()
            if now == last and now != told:
                told = now
                self._saved()
            last = now

    def _state(self) -> tuple[int, int, int] | None:
        """What changes when a file is saved; none where there is no file."""
        try:
            found = self.path.stat()
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size, found.st_ino


__all__ = ["Watch"]
