"""The live server as a whole: it starts, waits, watches the file, and ends cleanly."""

from __future__ import annotations

import errno
import json
import multiprocessing
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from drystone.base.errors import InputError
from drystone.base.files import MIB, shipped
from drystone.live.desk import Desk
from drystone.live.helper import ToolCalls
from drystone.live.web import WebServer
from drystone.view.page import Addition, page_of_data

PORTS = 20
"""Ports that are tried."""

_PERIOD = 0.25
"""[s] between two looks at a file. A file counts as saved once two looks see the same."""

_SCRIPTS = (
    "live-stream.js", "live-state.js", "live-picture.js", "live-push.js", "live-lists.js",
    "live-controls.js",
)  # fmt: skip
"""In the order in which they are put into the page, after those of every page."""


class Live:
    """The server of one model file.

    Parameters
    ----------
    model
        A model file. Files beside it are readable by calls of the JSON interface, and no others.
    port
        First port that is tried; 0 for any. A taken one is passed over.
    how
        Arguments of :func:`drystone.read`.
    time_limit : [s]
        Time for a verdict, a task or a call.
    size_limit : [MiB]
        Size of a model.

    Raises
    ------
    InputError
        There is no such file, no port is free, or a limit is not above zero.
    """

    def __init__(
        self,
        model: str | Path,
        *,
        port: int = 8377,
        how: Mapping[str, Any] | None = None,
        time_limit: float = 60.0,
        size_limit: float = 16.0,
    ) -> None:
        for name, value in (("time_limit", time_limit), ("size_limit", size_limit)):
            if not 0.0 < value < float("inf"):
                raise InputError(f"is {value}", where=name, remedy="give a number above zero")
        if not 0 <= port < 2**16:
            raise InputError(f"is {port}", where="port", remedy="give 0 to 65535")
        file = Path(model)
        if not file.is_file():
            raise InputError("there is no such file", where=str(model), remedy="check the path")
        self.desk = Desk(file, how or {}, size_limit, time_limit)
        self.desk.folder.model(self.desk.file.name)
        self.calls = ToolCalls(self.desk.folder, time_limit)
        self.asked_port = port
        self.server = self._bound(port, int(size_limit * MIB))
        self._watch: Watch | None = None
        self._thread = threading.Thread(
            target=self.server.serve_forever, kwargs={"poll_interval": 0.1}, daemon=True
        )

    def _bound(self, port: int, largest: int) -> WebServer:
        for number in [0] if port == 0 else range(port, port + PORTS):
            try:
                return WebServer(number, self.desk, self.calls, largest, _page_of)
            except OSError as error:
                if error.errno not in (errno.EADDRINUSE, errno.EACCES):
                    raise
        last = port + PORTS - 1
        remedy = "give another one with --port, or 0 for any"
        raise InputError(f"none of the ports {port} to {last} is free", where="port", remedy=remedy)

    @property
    def port(self) -> int:
        """Where it listens."""
        return self.server.guard.port

    @property
    def link(self) -> str:
        """The address of the page, with its token."""
        return self.server.guard.link

    def start(self) -> None:
        """Read the model, then serve, in other threads.

        Raises
        ------
        InputError
            The model cannot be read.
        """
        if getattr(multiprocessing.current_process(), "_inheriting", False):
            raise InputError(
                "the live server is started while Python imports the main module for its process",
                remedy="put the lines that start it below: if __name__ == '__main__':",
            )
        self._watch = Watch(self.desk.file, self.desk.read)
        self._thread.start()
        try:
            self.desk.start()
        except BaseException:
            self.close()
            raise

    def wait(self, alone: float = 10.0) -> None:
        """Wait until the last window was closed for some time [s]; for ever if none is opened.

        A page that is loaded again is back within ten seconds, also on a slow machine.
        """
        since = time.monotonic()
        while time.monotonic() - since < alone:
            time.sleep(0.2)
            if self.desk.windows or not self.desk.ever_open:
                since = time.monotonic()
            since = max(since, self.server.called)

    def close(self) -> None:
        """End threads, connections and processes."""
        if self._watch is not None:
            self._watch.close()
            self.server.shutdown()
            self._thread.join()
        self.server.server_close()
        self.server.watch.join()
        self.calls.close()
        if self._watch is not None:
            self.desk.close()

    def __enter__(self) -> Live:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def serve(model: str | Path, *, began: Callable[[Live], None], **how: Any) -> None:
    """Serve a model until the last window is closed or Ctrl-C ends it.

    Parameters
    ----------
    model
        File, as for :class:`Live`.
    began
        Called once it listens.
    how
        As for :class:`Live`.
    """
    try:
        with Live(model, **how) as live:
            began(live)
            live.wait()
    except KeyboardInterrupt:
        pass


class Watch:
    """Calls a function after a file was saved, in a thread of its own."""

    def __init__(self, path: Path, saved: Callable[[], None]) -> None:
        self.path, self._saved = path, saved
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True, name="drystone-watch")
        self._thread.start()

    def close(self) -> None:
        """Stop watching the file."""
        self._end.set()
        self._thread.join()

    def _look(self) -> None:
        told = last = self._state()
        while not self._end.wait(_PERIOD):
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


def _page_of(desk: Desk) -> str:
    """The page of the model of the file as it was read last."""

    def read(name: str) -> str:
        return shipped(f"live/static/{name}")

    number = desk.current
    kept = desk.models[number]
    begins = json.dumps({"model": number, "name": desk.file.name, "facts": kept.facts})
    for sign in "<>&":
        begins = begins.replace(sign, f"\\u{ord(sign):04x}")
    begins = begins.replace("{{", "{\\u007b")  # a name, and no mark of the page
    controls = read("strip.html").replace("{{BEGINS}}", begins)
    script = "\n".join(read(name) for name in _SCRIPTS)
    added = Addition(controls, read("live.css"), script)
    return page_of_data(kept.scene, f"drystone live: {desk.file.name}", added=added)
