"""The server: HTTP on the loopback address, bounded in connections, sizes and time.

A program of this machine that knows the token may ask.
"""

from __future__ import annotations

import contextlib
import hmac
import json
import os
import queue
import re
import secrets
import select
import socket
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import SplitResult, parse_qs, urlsplit

import drystone
from drystone.base.errors import DrystoneError
from drystone.base.files import MIB, utf8
from drystone.io.jsontext import Field, parse
from drystone.live.desk import Desk
from drystone.live.helper import ToolCalls
from drystone.live.wish import Wish, python_lines

WISH = 2**18
"""[bytes] of a wish at most, chosen: 1,000 cases of pushes on a dozen blocks."""
LOOPBACK = "127.0.0.1"


@dataclass(frozen=True)
class Refusal(Exception):
    """A request that is not answered, in words.

    Attributes
    ----------
    status
        Of the protocol.
    what, remedy
    """

    status: int
    what: str
    remedy: str = ""


@dataclass(frozen=True)
class Guard:
    """What every request is checked for.

    Attributes
    ----------
    port
    largest : [bytes]
        Of the body of a call.
    token
        Part of the link; 256 bits at random.
    """

    port: int
    largest: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32))

    @property
    def hosts(self) -> tuple[str, ...]:
        """What a browser or client may call this server."""
        return f"{LOOPBACK}:{self.port}", f"localhost:{self.port}"

    @property
    def link(self) -> str:
        """The address of the page."""
        return f"http://{LOOPBACK}:{self.port}/?token={self.token}"

    def admit(self, headers: Mapping[str, str], token: str = "") -> None:
        """Raise Refusal for a request of another site, or without the token.

        Parameters
        ----------
        headers
        token
            From the address; else it is the bearer token of the header ``Authorization``.
        """
        host = headers.get("Host", "")
        if host not in self.hosts:
            raise Refusal(
                403, "the request names another host", f"ask http://{self.hosts[0]}/ itself"
            )
        origin, site = headers.get("Origin"), headers.get("Sec-Fetch-Site", "none")
        if origin not in (None, f"http://{host}") or site not in ("none", "same-origin"):
            raise Refusal(403, "the request comes from another site", "open the link of the server")
        given = token or headers.get("Authorization", "").removeprefix("Bearer ").strip()
        if not given:
            raise Refusal(401, "the token is missing", "use the link that the server printed")
        if not hmac.compare_digest(given.encode(), self.token.encode()):
            raise Refusal(
                403, "the token is not that of this server", "use the link that it printed"
            )

    def length(self, headers: Mapping[str, str], most: int) -> int:
        """The length [bytes] of a body; Refusal where it is not said or too large."""
        if headers.get("Transfer-Encoding"):
            raise Refusal(411, "the body has no length", "send it whole, with Content-Length")
        text = headers.get("Content-Length") or ""
        if not (text.isascii() and text.isdigit() and len(text) < 20):
            raise Refusal(411, "the body has no length", "send it whole, with Content-Length")
        if int(text) > most:
            what = f"the body has {int(text) / MIB:.3g} MiB, more than the {most / MIB:.3g} allowed"
            raise Refusal(413, what, "give a smaller model, or start the server with --size-limit")
        return int(text)


VERSION = "v1"

TASKS = ("limit", "mends", "apply", "plan", "cut", "recut", "cases", "save")


def sent(body: bytes) -> dict[str, Any]:
    """A wish of a window, as plain values that were looked at: arguments of :meth:`Desk.task`.

    ``number`` counts the wishes of the window, ``model`` is that of what it shows, ``task`` is
    empty where a verdict is asked for, and ``extra`` is what the task is told.

    Raises
    ------
    InputError
        It is no JSON, or a value cannot be: friction below zero.
    """
    top = parse(body, Path("request"))
    top.only(("window", "number", "model", "wish", "task", "extra"))
    wish = top.get("wish", {})
    Wish.read(Field(wish.value, "", Path("wish")))
    task = top.get("task", "").text()
    if task and task not in TASKS:
        raise top["task"].error(f"there is no task '{task[:40]}'", f"there are {', '.join(TASKS)}")
    return {
        "window": top["window"].text(),
        "number": top.get("number", 0).integer(),
        "model": top.get("model", 0).integer(),
        "wish": wish.value,
        "task": task,
        "extra": top.get("extra", {}).object().value,
    }


_CONNECTIONS = 64
"""At one time, chosen: each window has one for its events and a few more."""
PATIENCE = 10.0
"""[s] for a request to arrive as a whole, and for a part of an answer to leave."""
_LOOK = 1.0
"""[s] between two looks at whether a window was closed."""
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; connect-src 'self'; frame-ancestors 'none'; "
    "base-uri 'none'; form-action 'none'"
)
_DIGITS = 10
"""More than the number of any model has."""
NAME = re.compile(r"[A-Za-z0-9-]{1,40}")


class WebServer(ThreadingHTTPServer):
    """Connections in threads of their own; where too many are open the oldest idle one gives way.

    Attributes
    ----------
    desk, calls, guard
    page
        The page that shows a model, given what it shows.
    """

    daemon_threads = True
    request_queue_size = 128
    allow_reuse_address = os.name == "posix"  # elsewhere it would let others take the port

    def __init__(
        self, port: int, desk: Desk, calls: ToolCalls, largest: int, page: Callable[[Desk], str]
    ) -> None:
        self._open: dict[socket.socket, float] = {}
        self._lock = threading.Lock()
        self._closed = threading.Event()
        super().__init__((LOOPBACK, port), _Handler)
        self.desk, self.calls, self.page = desk, calls, page
        self.guard = Guard(self.server_address[1], largest)
        self.called = time.monotonic()
        self.watch = threading.Thread(target=self._end_idle, daemon=True, name="drystone-idle")
        self.watch.start()

    def server_close(self) -> None:
        """Close every connection."""
        self._closed.set()
        super().server_close()
        with self._lock:
            for connection in self._open:
                _shut(connection)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a connection, and end the oldest one that has not asked yet where many are open."""
        with self._lock:
            self._open[request] = time.monotonic() + PATIENCE
            if len(self._open) > _CONNECTIONS:
                idle = [one for one, end in self._open.items() if end < float("inf")]
                _refuse(idle[0], 503, "too many connections are open", "try again")  # or itself
                del self._open[idle[0]]
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Forget a connection that has ended."""
        with self._lock:
            self._open.pop(request, None)
        super().shutdown_request(request)

    def asked(self, request: Any) -> None:
        """A request has arrived as a whole: its connection may stay open while it is answered."""
        with self._lock:
            if request not in self._open:
                raise ConnectionAbortedError("a newer connection took its place")
            self._open[request] = float("inf")

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A client that went away is no fault, and nothing is printed."""

    def _end_idle(self) -> None:
        """End connections on which no whole request arrives."""
        while not self._closed.wait(0.5):
            now = time.monotonic()
            with self._lock:
                for one in [one for one, end in self._open.items() if end < now]:
                    _refuse(one, 408, "no whole request came in time", "try again")
                    del self._open[one]


class _Handler(BaseHTTPRequestHandler):
    """One request."""

    server: WebServer
    timeout = PATIENCE
    server_version = "drystone"
    sys_version = ""

    def do_GET(self) -> None:  # the name that http.server asks for
        """The page, a model, the stream of events, or what the JSON interface offers."""
        self._answered(self._get)

    def do_POST(self) -> None:
        """A wish of a window, or a call of the JSON interface."""
        self._answered(self._post)

    def handle_expect_100(self) -> bool:
        """Nothing is promised before the request was looked at."""
        return True

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing is printed."""

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """What the protocol itself refuses, in the form of every other refusal."""
        self.close_connection = True
        self._send_json(code, {"error": {"what": explain or message or "bad request", "where": "",
                                         "remedy": "send a request of HTTP/1.1"}})  # fmt: skip

    def _answered(self, work: Callable[[], None]) -> None:
        self.close_connection = True
        try:
            work()
        except Refusal as refusal:
            self._throw_away_body()
            error = {"what": refusal.what, "where": "", "remedy": refusal.remedy}
            self._send_json(refusal.status, {"error": error})
        except DrystoneError as error:
            told = {name: getattr(error, name, "") for name in ("what", "where", "remedy")}
            self._send_json(400, {"error": told if told["what"] else {"what": str(error)}})
        except OSError:
            return  # the client is gone
        except Exception as error:  # the edge of the program: a fault of ours, told in one line
            what = f"a fault in drystone, please report it: {type(error).__name__}: {error}"
            self._send_json(500, {"error": {"what": what, "where": "", "remedy": ""}})

    # -- what is asked --------------------------------------------------------------------------
    def _get(self) -> None:
        parts = self._address()
        token = parse_qs(parts.query).get("token", [""])[0] if parts.path == "/" else ""
        self.server.guard.admit(self.headers, token)  # type: ignore[arg-type]
        self.server.asked(self.connection)
        if parts.path == "/":
            self._send(200, self.server.page(self.server.desk), "text/html; charset=utf-8")
        elif parts.path == "/events":
            self._events(parse_qs(parts.query).get("window", [""])[0])
        elif parts.path == f"/{VERSION}":
            calls = calls_of()
            self._send_json(200, {"drystone": drystone.__version__, "interface": VERSION,
                                  "calls": {**calls, "files": []}})  # fmt: skip
        elif parts.path.startswith("/model/"):
            number = parts.path.removeprefix("/model/")
            kept = self._kept(int(number) if number.isdecimal() and len(number) < _DIGITS else -1)
            text = json.dumps({"facts": kept.facts, "scene": kept.scene}, allow_nan=False)
            self._send(200, text, "application/json")
        else:
            raise _nothing()

    def _post(self) -> None:
        self.server.guard.admit(self.headers)  # type: ignore[arg-type]
        path = self._address().path
        desk = self.server.desk
        if path.startswith(f"/{VERSION}/"):
            tool = path.removeprefix(f"/{VERSION}/")
            if tool not in calls_of():
                known = ", ".join(f"/{VERSION}/{name}" for name in calls_of())
                raise Refusal(404, "there is no such call", f"there are {known}")
            body = self._body(self.server.guard.largest)
            self.server.called = time.monotonic()
            status, text = self.server.calls.call(tool, body)
            self.server.called = time.monotonic()
            self._send(status, text, "application/json")
            return
        if not path.startswith("/live/"):
            raise _nothing()
        asked = sent(self._body(WISH))
        if path == "/live/wish":
            desk.wish(*(asked[key] for key in ("window", "number", "model", "wish")))
        elif path == "/live/task":
            desk.task(**asked)
        elif path == "/live/end":
            desk.end(asked["window"])
        elif path == "/live/python":
            self._send_json(200, self._lines(asked))
            return
        else:
            raise _nothing()
        self._send_json(202, {"number": asked["number"]})

    def _kept(self, number: int) -> Any:
        """A model that the page knows by its number."""
        kept = self.server.desk.models.get(number)
        if kept is None:
            raise Refusal(404, "there is no such model any more", "load the page again")
        return kept

    def _lines(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        desk, kept, wish = self.server.desk, self._kept(asked["model"]), asked["wish"]
        lines = python_lines(desk.file.name, desk.how, wish, kept.facts)
        if saved := asked["extra"].get("saved"):  # a model with everything that the page shows
            facts = {**kept.facts, "moves": bool(wish.get("moves"))}
            whole = python_lines(str(saved), {}, {}, facts)
            lines["python"] = whole["python"]
        return lines

    def _events(self, name: str) -> None:
        """A stream of server-sent events, until the window is closed."""
        if not NAME.fullmatch(name):
            raise Refusal(
                400, "the window has no name of letters and digits", "load the page again"
            )
        window = self.server.desk.enter(name)
        try:
            self._head(200, "text/event-stream")
            while not self._gone():
                try:
                    event = window.events.get(timeout=_LOOK)
                except queue.Empty:
                    self.wfile.write(b":\n\n")  # tells lost windows
                    continue
                if event is None:
                    return
                self.wfile.write(f"data: {json.dumps(event, allow_nan=False)}\n\n".encode())
        finally:
            self.server.desk.leave(window)

    def _gone(self) -> bool:
        """Whether the client has closed the connection: after its request it sends nothing."""
        ready, _, _ = select.select([self.connection], [], [], 0.0)
        return bool(ready)

    def _address(self) -> SplitResult:
        try:
            return urlsplit(self.path)
        except ValueError as error:
            what = f"the address cannot be read: {error}"
            raise Refusal(400, what, "see docs/reference/json-interface.md") from error

    # -- bytes ----------------------------------------------------------------------------------
    def _body(self, most: int) -> bytes:
        length = self.server.guard.length(self.headers, most)  # type: ignore[arg-type]
        if self.headers.get("Expect", "").lower() == "100-continue":
            self.wfile.write(b"HTTP/1.1 100 Continue\r\n\r\n")
        data = self.rfile.read(length)
        self._left = 0
        if len(data) < length:
            raise Refusal(400, "the body ends too early", "send it whole")
        self.server.asked(self.connection)
        return data

    _left = MIB  # of a refused body that is read and thrown away, so that the refusal is heard

    def _throw_away_body(self) -> None:
        if self.command == "POST" and self._left and not self.headers.get("Expect"):
            with contextlib.suppress(OSError):
                self.connection.settimeout(0.2)
                while self._left > 0 and (part := self.rfile.read1(min(self._left, 2**16))):
                    self._left -= len(part)
                self.connection.settimeout(PATIENCE)

    def _head(self, status: int, kind: str, length: int | None = None) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        if length is not None:
            self.send_header("Content-Length", str(length))
        for name, value in (
            ("Cache-Control", "no-store"),
            ("Connection", "close"),
            ("Content-Security-Policy", _POLICY),
            ("Cross-Origin-Resource-Policy", "same-origin"),
            ("Referrer-Policy", "no-referrer"),
            ("X-Content-Type-Options", "nosniff"),
        ):
            self.send_header(name, value)
        self.end_headers()

    def _send(self, status: int, text: str, kind: str) -> None:
        data = utf8(text)
        self._head(status, kind, len(data))
        self.wfile.write(data)

    def _send_json(self, status: int, value: Any) -> None:
        self._send(status, json.dumps(value, allow_nan=False), "application/json")


def _nothing() -> Refusal:
    where = "see docs/reference/json-interface.md"
    return Refusal(404, "there is nothing at this address", where)


def _refuse(connection: socket.socket, status: int, what: str, remedy: str) -> None:
    """Say so on a connection that has not asked anything, and end it."""
    error = {"what": what, "where": "", "remedy": remedy}
    data = json.dumps({"error": error}).encode()
    head = f"HTTP/1.0 {status} Refused\r\nContent-Type: application/json\r\n"
    head += f"Content-Length: {len(data)}\r\nConnection: close\r\n\r\n"
    with contextlib.suppress(OSError):
        connection.send(head.encode() + data, getattr(socket, "MSG_DONTWAIT", 0))
    _shut(connection)


def _shut(connection: socket.socket) -> None:
    with contextlib.suppress(OSError):
        connection.shutdown(socket.SHUT_RDWR)


def calls_of() -> dict[str, list[str]]:
    """The calls of the JSON interface, and their arguments."""
    from drystone.mcp.answers import TOOLS  # the page is served before the analyses are imported

    return {name: list(one.names) for name, one in TOOLS.items()}
