"""``drystone mcp``: a server for programs that use tools."""

from __future__ import annotations

from typing import Annotated

import click

from drystone.cli.base.answer import Answer
from drystone.cli.base.command import Argument, Option, command
from drystone.cli.base.kinds import POSITIVE
from drystone.cli.base.waiting import Waiting


@command("drystone mcp .", "drystone mcp ./models --time-limit 300")
def mcp(
    *,
    folder: Annotated[str, Argument("FOLDER", "The only folder that files are read from.")],
    time_limit: Annotated[float, Option("Seconds for one call.", kind=POSITIVE)] = 50.0,
    size_limit: Annotated[float, Option("MiB of one model.", kind=POSITIVE)] = 16.0,
    waiting: Waiting,  # noqa: ARG001  # the client waits
) -> Answer:
    """Serve check, diagnose, mend, limit, plan and inspect to programs: Model Context Protocol.

    It uses standard input and output, and ends when the client disconnects.
    """
    from drystone.mcp import serve  # the program starts fast: work is imported when there is some

    serve(folder, time_limit=time_limit, size_limit=size_limit)
    click.get_current_context().exit()
