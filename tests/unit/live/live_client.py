"""What the tests of the live server share: requests, and a window that hears its events."""

from __future__ import annotations

import http.client
import json
import socket
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import drystone
from drystone import io
from drystone.assembly import Assembly
from drystone.io.jsontext import Field
from drystone.live.serving import Live
from drystone.live.wish import Wish
from drystone.models import arch, box

PATIENCE = 300.0
"""[s] for an answer on a busy machine."""


@contextmanager
def served_arch(folder: Path) -> Iterator[Live]:
    """A server of the arch that is written there."""
    with Live(write_arch(folder), port=0) as made:
        yield made


def write_arch(folder: Path) -> Path:
    """The file of an arch of twelve voussoirs, friction 0.9."""
    path = folder / "arch.json"
    io.write(drystone.Model.of(arch(0.15, 12), friction=0.9), path)
    return path


def ask(
    live: Live,
    path: str,
    body: Any = None,
    *,
    headers: Mapping[str, str] | None = None,
    method: str = "",
    token: bool = True,
) -> tuple[int, Any]:
    """The status and the answer to a request; headers of None are left out."""
    data = body if isinstance(body, bytes) or body is None else json.dumps(body).encode()
    given = {"Authorization": f"Bearer {live.server.guard.token}"} if token else {}
    connection = http.client.HTTPConnection("127.0.0.1", live.port, timeout=PATIENCE)
    try:
        connection.request(method or ("GET" if data is None else "POST"), path, data,
                           {**given, **(headers or {})})  # fmt: skip
        answer = connection.getresponse()
        text = answer.read().decode()
    finally:
        connection.close()
    is_json = (answer.getheader("Content-Type") or "").startswith("application/json")
    return answer.status, json.loads(text) if is_json else text


def raw(live: Live, data: bytes) -> bytes:
    """What is answered to some bytes."""
    with socket.create_connection(("127.0.0.1", live.port), timeout=PATIENCE) as connection:
        connection.sendall(data)
        found = b""
        while part := connection.recv(2**16):
            found += part
    return found


def wish_of(**values: object) -> Wish:
    """A wish as the page sends it."""
    return Wish.read(Field(values, "", Path("wish")))


def overhang() -> Assembly:
    """A slab that hangs over its support by more than half, and falls."""
    base, out = box((1.0, 1.0, 1.0)), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    return Assembly((base, out)).with_fixed([0])


class Window:
    """A window of the page: it asks, and keeps the events that it hears."""

    def __init__(self, live: Live, name: str) -> None:
        self.live, self.name, self.number = live, name, 0
        self.events: list[dict[str, Any]] = []
        self._heard = threading.Condition()
        self._connection = http.client.HTTPConnection("127.0.0.1", live.port, timeout=PATIENCE)
        self._connection.connect()
        self._socket = self._connection.sock  # the connection forgets it with the answer
        self._connection.request("GET", f"/events?window={name}", headers={
            "Authorization": f"Bearer {live.server.guard.token}"})  # fmt: skip
        self._answer = self._connection.getresponse()
        assert self._answer.status == 200
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()
        self.until("file")

    def _listen(self) -> None:
        try:
            for line in self._answer:
                if line.startswith(b"data: "):
                    with self._heard:
                        self.events.append(json.loads(line[6:]))
                        self._heard.notify_all()
        except (OSError, ValueError, AttributeError):
            return

    def close(self) -> None:
        """Go away as a browser does."""
        self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._connection.close()

    def wish(self, model: int | None = None, **wish: Any) -> int:
        """Ask for the verdict of a load case."""
        self.number += 1
        body = {"window": self.name, "number": self.number, "wish": wish,
                "model": self.live.desk.current if model is None else model}  # fmt: skip
        assert ask(self.live, "/live/wish", body) == (202, {"number": self.number})
        return self.number

    def task(self, name: str, extra: Any = None, model: int | None = None, **wish: Any) -> int:
        """Press a button."""
        self.number += 1
        body = {"window": self.name, "number": self.number, "wish": wish, "task": name,
                "model": self.live.desk.current if model is None else model,
                "extra": extra or {}}  # fmt: skip
        assert ask(self.live, "/live/task", body) == (202, {"number": self.number})
        return self.number

    def until(self, event: str, number: int = 0, count: int = 1) -> dict[str, Any]:
        """The last of so many events of a kind; ``number`` is that of the wish."""
        end = time.monotonic() + PATIENCE
        with self._heard:
            while True:
                found = [one for one in self.events
                         if one["event"] == event and one.get("wish", 0) >= number]  # fmt: skip
                if len(found) >= count:
                    return found[count - 1]
                assert time.monotonic() < end, [one["event"] for one in self.events]
                self._heard.wait(1.0)

    def answer(self, **wish: Any) -> dict[str, Any]:
        """The whole verdict of a load case."""
        found: dict[str, Any] = self.until("whole", self.wish(**wish))["answer"]
        return found
