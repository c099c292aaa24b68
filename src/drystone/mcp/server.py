"""The server: it starts, listens, and ends when its client closes the connection."""

from __future__ import annotations

from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

from drystone.base.errors import InputError, MissingDependency
from drystone.mcp.folder import Folder

_TIME_LIMIT = 50.0
"""[s] for one call. Chosen: clients of the protocol often wait for 60 s."""
_SIZE_LIMIT = 16.0
"""[MiB] of one model. Chosen: about 50,000 blocks of six faces in our JSON."""


def serve(
    folder: str | Path, *, time_limit: float = _TIME_LIMIT, size_limit: float = _SIZE_LIMIT
) -> None:
    """Answer the calls of one client over standard input and output.

    It ends when the client disconnects, or with Ctrl-C.

    Parameters
    ----------
    folder
        The only folder that files are read from.
    time_limit : [s]
        Time for one call.
    size_limit : [MiB]
        Size of one model.

    Raises
    ------
    InputError
        There is no such folder, or a limit is not above zero.
    MissingDependency
        The package ``mcp`` is not installed.
    """
    for name, value in (("time_limit", time_limit), ("size_limit", size_limit)):
        if not 0.0 < value < float("inf"):
            raise InputError(f"is {value}", where=name, remedy="give a number above zero")
    models = Folder.of(folder, size_limit)
    if find_spec("mcp") is None:
        raise MissingDependency("mcp", extra="mcp", purpose="the server")
    from drystone.mcp.tools import build  # needs the package

    with suppress(KeyboardInterrupt):
        build(models, time_limit).run()
