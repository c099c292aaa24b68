"""``drystone live``: a page on which a model can be changed; ``drystone mcp``: for programs."""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import click

from drystone.base.files import shipped, write_text
from drystone.cli import kinds, output
from drystone.cli.command import command
from drystone.cli.model_input import HOW
from drystone.cli.offered import OUTPUT, Analysis, Argument, Of, Option, writes
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.live.serving import Live


@command("drystone live arch.json", "drystone live vault.obj --supports lowest --no-browser")
def live(
    *,
    model: Annotated[
        str | None, Argument("MODEL", "Model file; its suffix determines the format.", kinds.FILE)
    ] = None,
    reading: Annotated[Analysis, HOW()],
    served: Annotated[
        Analysis,
        Of("drystone.live.serving.Live", ("port", "time_limit", "size_limit"), shown=("port",)),
    ],
    no_browser: Annotated[bool, Option("Print the link and open no browser.", OUTPUT)] = False,
    client: Annotated[
        Path | None,
        writes("Write the client of the JSON interface (one Python file), and exit.", ".py"),
    ] = None,
    waiting: Waiting,
) -> None:
    """Open a page on which a model can be tilted, pushed and mended, and its supports moved.

    The verdict follows at once. The model file is watched: when it is saved, it is read again.
    Programs can ask the same server by JSON (docs/reference/json-interface.md). It serves this
    machine only. It ends with Ctrl-C, or ten seconds after the last window is closed.
    """
    if client is not None:
        write_text(client, shipped("live/client.py"))
        output.say(f"wrote {client}")
        return
    if model is None:
        raise output.UsageFault("is missing", where="MODEL", remedy="name a model file")
    from drystone.live import serve  # the program starts fast: work is imported when there is some

    ctx = click.get_current_context()
    waiting.stage("read", f"reading {model}")

    def began(server: Live) -> None:
        waiting.close()
        said(server, as_json=bool(ctx.params.get("as_json")))
        if not no_browser and not opened(server.link):
            output.say("no browser could be opened: open the link in one")
            sys.stdout.flush()

    serve(model, began=began, how=reading.given, **served.given)


def said(server: Live, as_json: bool) -> None:
    """Print the address of the page."""
    if as_json:
        output.emit({"link": server.link, "port": server.port, "token": server.server.guard.token})
    else:
        if server.port != server.asked_port and server.asked_port:
            output.say(f"port {server.asked_port} is taken: port {server.port} is used")
        output.say(f"{server.link}\nCtrl-C ends it")
    sys.stdout.flush()


def opened(link: str) -> bool:
    """Whether a browser with windows could be opened."""
    screens = ("DISPLAY", "WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not any(os.environ.get(name) for name in screens):
        return False
    try:
        return webbrowser.open(link)
    except (webbrowser.Error, OSError):
        return False


@command("drystone mcp .", "drystone mcp ./models --time-limit 300")
def mcp(
    *,
    folder: Annotated[str, Argument("FOLDER", "The only folder that files are read from.")],
    served: Annotated[Analysis, Of("drystone.mcp.serve", shown=("time_limit", "size_limit"))],
    waiting: Waiting,
) -> None:
    """Serve check, diagnose, mend, limit, plan and inspect to programs: Model Context Protocol.

    It uses standard input and output, and ends when the client disconnects.
    """
    from drystone.mcp import serve  # the program starts fast: work is imported when there is some

    waiting.close()  # the client waits
    serve(folder, **served.given)
