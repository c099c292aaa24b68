"""Who waits for what: windows, their wishes, and which of them is computed next.

The newest wish of a window replaces its older ones. Quick verdicts come first, then what a person
requested with a button, then complete verdicts. Work that is interrupted starts again later.
"""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

from drystone.base.errors import InputError
from drystone.live.helper import Helper
from drystone.mcp.folder import Folder

_URGENCY = {"read": 0, "quick": 0, "task": 1, "whole": 2, "cases": 3}
_OF_A_WISH = ("quick", "whole", "task")
"""What a newer wish of the same window ends."""
_WINDOWS = 16
"""Windows that may be open at one time, chosen."""
_EVENTS = 256
"""Events that wait for a window that does not read them, chosen; then the window is closed."""
MODELS = 20
"""Models that are kept: that of the file, the one before, and mended ones. Chosen: one of 400
blocks takes 4 MB."""


@dataclass(eq=False)
class _Window:
    """A page that is open: its events on their way."""

    name: str
    events: queue.Queue[dict[str, Any] | None] = field(
        default_factory=lambda: queue.Queue(maxsize=_EVENTS)
    )


@dataclass(eq=False)
class _Kept:
    """A model that windows may ask about: pickled for the process, and encoded for the page."""

    blob: bytes
    scene: str
    facts: Mapping[str, Any]


@dataclass(eq=False)
class _Job:
    """One thing to compute, for a window; for all of them where the name is empty."""

    window: str
    do: str
    wish: int = 0
    message: Mapping[str, Any] = field(default_factory=dict)
    seconds: float = 60.0

    @property
    def urgency(self) -> int:
        """Lower comes first."""
        return _URGENCY[self.do]


class Desk:
    """Jobs of all windows, done by one process, one after the other.

    Attributes
    ----------
    given, file
        The file of the model, as it was named and as an absolute path.
    current
        Number of the model of the file as it was read last; 0 before.
    broken
        Why the file cannot be read now; ``None`` where it can.
    """

    def __init__(self, given: Path, how: Mapping[str, Any], largest_mib: float, seconds: float):
        file = given.resolve()
        self.folder = Folder.of(file.parent, largest_mib)
        self.given, self.file, self.how, self.seconds = given, file, dict(how), seconds
        self.helper = Helper()
        self.windows: dict[str, _Window] = {}
        self.models: dict[int, _Kept] = {}
        self.current = 0
        self.broken: dict[str, str] | None = None
        self.ever_open = False
        self._numbers = count(1)
        self._pending: list[_Job] = []
        self._running: _Job | None = None
        self._changed = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._work, daemon=True, name="drystone-desk")

    def start(self) -> None:
        """Start the process and read the file.

        Raises
        ------
        InputError
            The file cannot be read.
        """
        self._thread.start()
        self.read()
        with self._changed:
            self._changed.wait_for(lambda: self.current or self.broken or self._closed)
        if self.broken is not None:
            why = self.broken
            raise InputError(why["what"], where=why["where"], remedy=why["remedy"])

    def close(self) -> None:
        """End the process, and the streams of all windows."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self.helper.close()
        for window in list(self.windows.values()):
            self.leave(window)
        self._thread.join()

    # -- windows --------------------------------------------------------------------------------
    def enter(self, name: str) -> _Window:
        """A window opens its stream of events; an older stream of the same name ends.

        Raises
        ------
        InputError
            Too many are open.
        """
        with self._changed:
            old = self.windows.pop(name, None)
            if len(self.windows) >= _WINDOWS:
                raise InputError(f"{_WINDOWS} windows are open", remedy="close one of them")
            window = self.windows[name] = _Window(name)
            self.ever_open = True
        if old is not None:
            _put(old, None)
        _put(window, self._state())
        return window

    def leave(self, window: _Window) -> None:
        """A window was closed: nothing is computed for it any more."""
        with self._changed:
            if self.windows.get(window.name) is window:
                del self.windows[window.name]
                self._drop(window.name, tuple(_URGENCY))
        _put(window, None)

    def _state(self) -> dict[str, Any]:
        return {"event": "file", "model": self.current, "name": self.file.name,
                "broken": self.broken}  # fmt: skip

    # -- jobs -----------------------------------------------------------------------------------
    def read(self) -> None:
        """Read the file anew."""
        message = {"folder": self.folder, "name": self.file.name, "how": self.how}
        self._add(_Job("", "read", 0, {**message, "number": next(self._numbers)}, self.seconds))

    def wish(self, window: str, number: int, model: int, wish: Any) -> None:
        """A load case: its quick verdict, then the whole one. Older wishes of the window end.

        Raises
        ------
        InputError
            The window has no stream of events, or there is no such model.
        """
        self._require(window, model)
        message = {"model": model, "wish": wish, "seconds": self.seconds, "name": self.file.name}
        with self._changed:
            self._drop(window, _OF_A_WISH)
        for do in ("quick", "whole"):
            self._add(_Job(window, do, number, message, 1.5 * self.seconds))

    def task(self, window: str, number: int, model: int, task: str, wish: Any, extra: Any) -> None:
        """Something that a person pressed a button for; an older task of the window ends.

        Raises
        ------
        InputError
            As :meth:`wish`.
        """
        self._require(window, model)
        do = "cases" if task == "cases" else "task"
        with self._changed:
            self._drop(window, (do,))
        message = {
            "model": model, "wish": wish, "seconds": self.seconds, "task": task, "extra": extra,
            "name": self.file.name, "number": next(self._numbers),
        }  # fmt: skip
        self._add(_Job(window, do, number, message, 1.5 * self.seconds))

    def end(self, window: str) -> None:
        """Nothing more is wanted for a window for now."""
        with self._changed:
            self._drop(window, tuple(_URGENCY))

    def _require(self, window: str, model: int) -> None:
        if window not in self.windows:
            raise InputError(
                "the window has no stream of events", where="window", remedy="open /events first"
            )
        if model not in self.models:
            remedy = "load the page again"
            raise InputError(f"there is no model {model} any more", where="model", remedy=remedy)

    def _drop(self, window: str, kinds: tuple[str, ...]) -> None:
        """Forget the jobs of some kinds of a window; the caller holds the lock."""
        self._pending = [
            job for job in self._pending if job.window != window or job.do not in kinds
        ]
        running = self._running
        if running is not None and running.window == window and running.do in kinds:
            self._running = None
            self.helper.cancel()

    def _add(self, job: _Job) -> None:
        with self._changed:
            self._pending.append(job)
            running = self._running
            if running is not None and running.urgency > job.urgency:
                self._pending.append(running)
                self._running = None
                self.helper.cancel()
            self._changed.notify_all()

    def _work(self) -> None:
        self.helper.start()
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or self._pending)
                if self._closed:
                    return
                job = min(self._pending, key=lambda one: one.urgency)
                self._pending.remove(job)
                self._running = job
                message = self._message(job)
            self._let_run(job, message)
            with self._changed:
                self._running = None

    def _let_run(self, job: _Job, message: dict[str, Any]) -> None:
        self.helper.run(
            message,
            lambda event: self._hear(job, event),
            job.seconds,
            lambda: self._running is job,
        )

    def _message(self, job: _Job) -> dict[str, Any]:
        """What the process is told, with the model where it does not know it yet."""
        message = {**job.message, "do": job.do, "window": job.window}
        number = int(message.get("model", 0))
        kept = self.models.get(number)
        self.helper.start()
        if kept is not None and number not in self.helper.knows:
            message["blob"] = kept.blob
            self.helper.knows.add(number)
        message["forget"] = sorted(self.helper.knows - set(self.models))
        self.helper.knows &= set(self.models)
        return message

    def _hear(self, job: _Job, event: dict[str, Any]) -> None:
        """Pass an event on to the window that waits for it, or a new file to all of them."""
        with self._changed:
            if self._running is not job:
                return
            if event["event"] == "model":
                number = job.message["number"]
                self.models[number] = _Kept(event.pop("blob"), event.pop("scene"), event["facts"])
                self.helper.knows.add(number)
                event["model"] = number
                if job.do == "read":
                    self.current, self.broken = number, None
                while len(self.models) > MODELS:
                    del self.models[min(one for one in self.models if one != self.current)]
            if job.do == "read" and event["event"] == "error":
                self.broken = {
                    key: event[key].replace(str(self.file), str(self.given))
                    for key in ("what", "where", "remedy")
                }
            self._changed.notify_all()
            windows = [w for w in self.windows.values() if job.window in ("", w.name)]
        if job.do == "read":
            if event["event"] == "progress":
                return
            event = self._state()
        for window in windows:
            if not _put(window, {**event, "wish": job.wish}):
                self.leave(window)


def _put(window: _Window, event: dict[str, Any] | None) -> bool:
    """Whether there was room for an event; the end of a stream takes the place of others."""
    try:
        window.events.put_nowait(event)
    except queue.Full:
        if event is None:
            with contextlib.suppress(queue.Empty):
                window.events.get_nowait()
            with contextlib.suppress(queue.Full):
                window.events.put_nowait(None)
        return False
    return True
