"""A server for programs that use tools: the Model Context Protocol over standard input and output.

``drystone mcp FOLDER`` starts it. The extra ``mcp`` installs the package of the protocol.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from drystone.base.errors import require
from drystone.base.settings import checked_call
from drystone.mcp.folder import Folder


@checked_call
def serve(folder: str | Path, *, time_limit: float = 50.0, size_limit: float = 16.0) -> None:
    """Answer the calls of one client over standard input and output.

    It ends when the client disconnects, or with Ctrl-C.

    Parameters
    ----------
    folder
        The only folder that files are read from.
    time_limit : [s] > 0, < inf
        Time for one call; clients of the protocol often wait for 60 s.
    size_limit : [MiB] > 0, < inf
        Size of one model: by default about 50,000 blocks of six faces in our JSON.

    Raises
    ------
    InputError
        There is no such folder, or a limit is not above zero.
    MissingDependency
        The package ``mcp`` is not installed.
    """
    models = Folder.of(folder, size_limit)
    require("mcp", "mcp", "the server")
    from drystone.mcp.tools import build  # needs the package

    with suppress(KeyboardInterrupt):
        build(models, time_limit).run()


__all__ = ["serve"]
