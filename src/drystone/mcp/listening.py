"""The lines of a client: each is answered, and Ctrl-C is heard while none comes."""

from __future__ import annotations

import asyncio
import json
import signal
import threading
from collections.abc import AsyncIterator
from concurrent.futures import CancelledError
from contextlib import asynccontextmanager, suppress
from itertools import chain
from typing import Any

from mcp.server.stdio import stdio_server
from mcp.shared.message import SessionMessage
from mcp.types import PARSE_ERROR, ErrorData, JSONRPCError, jsonrpc_message_adapter


@asynccontextmanager
async def listening() -> AsyncIterator[tuple[Any, Any]]:
    """The streams of a server over standard input and output.

    The protocol's own streams wait for the next line before they end, and do not answer a line that
    they cannot read.
    """
    for one in signal.valid_signals():  # a request to end is as Ctrl-C, which the loop hears
        if signal.getsignal(one) is signal.default_int_handler:
            signal.signal(one, signal.getsignal(signal.SIGINT))
    lines = _Lines()
    async with stdio_server(stdin=lines) as (heard, told):  # type: ignore[arg-type]
        lines.told = told
        yield heard, told


class _Lines:
    """Lines of standard input, from a thread for which nothing waits.

    Attributes
    ----------
    told
        Stream of the answers.
    """

    told: Any = None

    def __init__(self) -> None:
        self._read: asyncio.Queue[bytes] = asyncio.Queue(1)
        loop = asyncio.get_running_loop()
        threading.Thread(target=self._listen, args=(loop,), daemon=True).start()

    def _listen(self, loop: asyncio.AbstractEventLoop) -> None:
        with suppress(RuntimeError, CancelledError), open(0, "rb", closefd=False) as file:
            for line in chain(file, [b""]):
                asyncio.run_coroutine_threadsafe(self._read.put(line), loop).result()

    def __aiter__(self) -> _Lines:
        return self

    async def __anext__(self) -> str:
        while line := await self._read.get():
            for text in (line.decode(errors="replace"), _without_halves(line)):
                with suppress(ValueError):
                    jsonrpc_message_adapter.validate_json(text)
                    return text
            wrong = ErrorData(code=PARSE_ERROR, message="the line is no message of JSON-RPC")
            await self.told.send(SessionMessage(JSONRPCError(jsonrpc="2.0", id=None, error=wrong)))
        raise StopAsyncIteration


def _without_halves(line: bytes) -> str:
    """The same JSON with a mark in place of every half of a pair of UTF-16."""
    with suppress(ValueError, RecursionError):
        return json.dumps(json.loads(line), ensure_ascii=False).encode(errors="replace").decode()
    return ""
