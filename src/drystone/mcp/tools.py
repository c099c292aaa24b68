"""The tools in the form of the protocol: names, arguments, descriptions."""

from __future__ import annotations

import asyncio
import json
import signal
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from functools import partial
from inspect import Parameter, Signature
from itertools import chain
from typing import Annotated, Any

import anyio
from anyio import to_process
from mcp.server import MCPServer
from mcp.server.mcpserver.exceptions import ToolError
from mcp.server.stdio import stdio_server
from mcp.shared.message import SessionMessage
from mcp.types import (
    PARSE_ERROR,
    ErrorData,
    JSONRPCError,
    ToolAnnotations,
    jsonrpc_message_adapter,
)
from pydantic import WithJsonSchema

import drystone
from drystone.base.errors import InputError, meant, refuse_unknown
from drystone.mcp.answers import TOOLS, Tool, answer
from drystone.mcp.folder import MODEL, Folder

INSTRUCTIONS = """\
drystone tells whether a structure of loose rigid blocks stands by contact and friction alone.
Lengths are in metres, forces in newtons, angles in degrees, masses in kilograms; z points up.
A model is {"file": NAME} in the folder of this server or {"content": {"blocks": [{"name",
"vertices", "faces", "fixed"}]}}, faces as lists of vertex numbers, counter-clockwise from outside.
Begin with 'inspect' where the contacts are not known to be right. 'undecided' is an answer: it is
no hint in either direction."""


@asynccontextmanager
async def _listening() -> AsyncIterator[tuple[Any, Any]]:
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
        self._read, self._room = asyncio.Queue[bytes](), threading.Semaphore()
        loop = asyncio.get_running_loop()
        threading.Thread(target=self._listen, args=(loop,), daemon=True).start()

    def _listen(self, loop: asyncio.AbstractEventLoop) -> None:
        with suppress(RuntimeError), open(0, "rb", closefd=False) as file:  # the loop is closed
            for line in chain(file, [b""]):
                self._room.acquire()  # one line at a time
                loop.call_soon_threadsafe(self._read.put_nowait, line)

    def __aiter__(self) -> _Lines:
        return self

    async def __anext__(self) -> str:
        while line := await self._next():
            for text in (line.decode(errors="replace"), _without_halves(line)):
                with suppress(ValueError):
                    said = jsonrpc_message_adapter.validate_json(text)
                    if hasattr(said, "id") or "id" not in json.loads(text):
                        return text  # another id than a text or a whole number gets no answer
            wrong = ErrorData(code=PARSE_ERROR, message="the line is no message of JSON-RPC")
            await self.told.send(SessionMessage(JSONRPCError(jsonrpc="2.0", id=None, error=wrong)))
        raise StopAsyncIteration

    async def _next(self) -> bytes:
        line = await self._read.get()
        self._room.release()
        return line


def _without_halves(line: bytes) -> str:
    """The same JSON with a mark in place of every half of a pair of UTF-16."""
    with suppress(ValueError, RecursionError):
        return json.dumps(json.loads(line), ensure_ascii=False).encode(errors="replace").decode()
    return ""


class _Server(MCPServer[Any]):
    """A server that refuses arguments that a tool does not have, and answers every line."""

    async def run_stdio_async(self) -> None:
        """Serve over standard input and output."""
        options = self._lowlevel_server.create_initialization_options()
        try:
            async with _listening() as (heard, told):
                await self._lowlevel_server.run(heard, told, options)
        except* anyio.BrokenResourceError:
            pass  # a line came together with the request to end

    async def call_tool(
        self, name: str, arguments: dict[str, Any], *more: Any, **named: Any
    ) -> Any:
        """Call a tool."""
        if name not in TOOLS:
            raise ToolError(f"there is no tool '{name}'; {meant(name, tuple(TOOLS))}")
        try:
            refuse_unknown(arguments, TOOLS[name].names)
        except InputError as error:
            raise ToolError(str(error)) from None
        return await super().call_tool(name, arguments, *more, **named)


def build(folder: Folder, seconds: float) -> MCPServer[Any]:
    """A server whose tools work on the models of a folder.

    Calls are answered one after the other, each in a process of its own with a time limit.

    Parameters
    ----------
    folder
    seconds
        For one call.
    """
    one = anyio.Lock()

    async def ask(tool: str, given: dict[str, Any]) -> dict[str, Any]:
        async with one:
            try:
                with anyio.fail_after(seconds):
                    told = await to_process.run_sync(
                        answer, tool, given, folder, seconds, cancellable=True
                    )
            except TimeoutError:
                raise ToolError(
                    f"no answer within {seconds:g} s; give a smaller model, or start the server "
                    "with a larger --time-limit"
                ) from None
            except anyio.BrokenWorkerProcess:
                raise ToolError(
                    "the calculation ended without an answer, perhaps because memory ran out; "
                    "give a smaller model"
                ) from None
        if "error" in told:
            raise ToolError(told["error"])
        return told

    server = _Server(
        "drystone",
        instructions=INSTRUCTIONS,
        version=drystone.__version__,
        log_level="WARNING",
    )
    reads = ToolAnnotations(read_only_hint=True, open_world_hint=False)
    for name, tool in TOOLS.items():
        call = _callable(tool, partial(ask, name))
        server.add_tool(call, name=name, description=tool.text, annotations=reads)
    return server


def _callable(tool: Tool, ask: Callable[..., Any]) -> Callable[..., Any]:
    """A function with the arguments of a tool, from which the protocol makes its schema."""

    async def call(**given: Any) -> dict[str, Any]:
        return await ask({key: value for key, value in given.items() if value is not None})

    call.__signature__ = Signature(  # type: ignore[attr-defined]
        [
            Parameter(
                key,
                Parameter.KEYWORD_ONLY,
                annotation=Annotated[Any, WithJsonSchema(schema)],
                **({} if key in ("model", "of") else {"default": None}),
            )
            for key, schema in _arguments(tool).items()
        ],
        return_annotation=dict[str, Any],
    )
    return call


def _arguments(tool: Tool) -> dict[str, dict[str, Any]]:
    """The JSON schema of each argument."""
    model = {
        "description": "The model to analyse.",
        "type": "object",
        "properties": {name: one.schema for name, one in MODEL.items()},
        "additionalProperties": False,
    }
    own = {name: one.schema for name, one in tool.arguments.items()}
    return {"model": model, **own} if tool.of_model else own
