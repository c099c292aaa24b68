"""Who may ask: a program of this machine that knows the token, by requests of bounded size.

What a window of the page sends.

Calls of the JSON interface and their answers are those of :mod:`drystone.mcp.answers`.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from drystone.base.files import MIB
from drystone.io.jsontext import Field, parse
from drystone.live.wish import Wish

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


@dataclass(frozen=True)
class Sent:
    """A wish of a window, as plain values that were looked at.

    Attributes
    ----------
    window
    number
        The window counts its wishes.
    model
        Number of the model that it shows.
    wish
    task
        Empty where a verdict is asked for.
    extra
        What the task is told.
    """

    window: str
    number: int
    model: int
    wish: dict[str, Any]
    task: str
    extra: dict[str, Any]


def sent(body: bytes) -> Sent:
    """What the body of a request says.

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
    return Sent(
        top["window"].text(),
        top.get("number", 0).integer(),
        top.get("model", 0).integer(),
        wish.value,
        task,
        top.get("extra", {}).object().value,
    )
