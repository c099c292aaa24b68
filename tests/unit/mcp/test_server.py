"""The server, asked by the protocol's own client over standard input and output."""

import asyncio
import gc
import json
import os
import signal
import subprocess
import sys
from collections.abc import Coroutine, Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import drystone
from drystone import io
from drystone.assembly import Block
from drystone.cli import main
from drystone.mcp.answers import answer
from drystone.mcp.folder import Folder
from drystone.models import arch, box, shelf, tower, vault

if find_spec("mcp") is None:  # it takes a second to import: one process that tests is enough
    pytest.skip("no mcp", allow_module_level=True)

TIME_LIMIT = 120.0
"""[s] of a call, for a busy machine."""


class Session:
    """A connection that is open for the whole module."""

    def __init__(self, folder: Path) -> None:
        from mcp import Client, StdioServerParameters

        self.loop = asyncio.new_event_loop()
        arguments = ["-m", "drystone", "mcp", str(folder), "--size-limit", "0.2"]
        arguments += ["--time-limit", str(TIME_LIMIT)]
        path = {"PYTHONPATH": str(Path(drystone.__file__).parents[1])}
        self.client = Client(
            StdioServerParameters(command=sys.executable, args=arguments, env=path)
        )
        self.asked: asyncio.Queue[Any] = asyncio.Queue()
        self.task = self.loop.create_task(self._serve())

    async def _serve(self) -> None:
        """All that the client does is done by one task, as its package asks for."""
        async with self.client:
            while (work := await self.asked.get()) is not None:
                coroutine, done = work
                done.set_result(await coroutine)

    def run(self, coroutine: Coroutine[Any, Any, Any]) -> Any:
        done = self.loop.create_future()
        self.asked.put_nowait((coroutine, done))
        first = asyncio.wait({done, self.task}, return_when=asyncio.FIRST_COMPLETED)
        self.loop.run_until_complete(first)
        return done.result() if done.done() else self.task.result()

    def call(self, tool: str, **arguments: Any) -> Any:
        return self.run(self.client.call_tool(tool, arguments))

    def answer(self, tool: str, **arguments: Any) -> dict[str, Any]:
        result = self.call(tool, **arguments)
        assert not result.is_error, result.content
        told: dict[str, Any] = result.structured_content
        assert json.loads(result.content[0].text) == told
        return told

    def refusal(self, tool: str, **arguments: Any) -> str:
        result = self.call(tool, **arguments)
        assert result.is_error
        text: str = result.content[0].text
        return text

    def close(self) -> None:
        self.asked.put_nowait(None)
        self.loop.run_until_complete(self.task)
        self.loop.close()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    outside = tmp_path_factory.mktemp("outside")
    made = tmp_path_factory.mktemp("models")
    io.write(shelf(), made / "shelf.json")
    io.write(arch(0.15, 12), made / "arch.obj")
    io.write(drystone.Model.of(vault(), friction=0.6), made / "vault.json")
    (made / "nested").mkdir()
    io.write(tower(3), made / "nested" / "tower.json")
    (made / "notes.txt").write_text("not a model")
    (made / "broken.json").write_text('{"blocks": [')
    (made / "large.obj").write_bytes(b"# " + b"x" * 300_000)
    io.write(tower(2), outside / "secret.json")
    if os.name == "posix":
        (made / "link.json").symlink_to(outside / "secret.json")
        (made / "door").symlink_to(outside)
    return made


@pytest.fixture(scope="module")
def session(folder: Path) -> Iterator[Session]:
    made = Session(folder)
    yield made
    made.close()


def content(count: int) -> dict[str, Any]:
    """A tower as the object that a program writes."""
    return content_of(tower(count).blocks)


def content_of(blocks: Iterable[Block]) -> dict[str, Any]:
    """Blocks as the object that a program writes."""
    return {
        "blocks": [
            {
                "name": block.name,
                "vertices": block.vertices.tolist(),
                "faces": [list(face) for face in block.faces],
            }
            for block in blocks
        ]
    }


def test_the_tools_say_what_they_are_for(session: Session) -> None:
    tools = {tool.name: tool for tool in session.run(session.client.list_tools()).tools}
    assert set(tools) >= {"files", "inspect", "check", "diagnose", "limit", "mend", "plan"}
    assert all(tool.description and tool.annotations.read_only_hint for tool in tools.values())
    assert session.client.server_info.version == drystone.__version__
    assert "newtons" in (session.client.instructions or "")


def test_model_files_are_listed_and_links_are_not(session: Session) -> None:
    names = {row["file"] for row in session.answer("files")["files"]}
    assert {"shelf.json", "arch.obj", "nested/tower.json"} <= names
    assert not {"link.json", "door/secret.json", "notes.txt"} & names


def test_a_shelf_that_balances_and_falls(session: Session) -> None:
    told = session.answer("check", model={"file": "shelf.json", "friction": 0.9})
    assert told["verdict"] == "unstable"
    assert told["falling"] == ["block-9", "block-10"]
    assert {row["block"] for row in told["gives_way"]} == {"block-9", "block-10"}
    assert "most_loaded" not in told


def test_why_a_shelf_falls_and_what_force_is_missing(session: Session) -> None:
    model = {"file": "shelf.json", "friction": 0.9}
    told = session.answer("diagnose", model=model, kinds=[])
    fallen = {name for region in told["regions"] for name in region["blocks"]}
    assert fallen == {"block-9", "block-10"}
    force = sum(region["needs"]["prop"]["force"][2] for region in told["regions"])
    assert force > 0.0
    assert len(told["sentences"]) >= len(told["regions"])
    assert session.answer("diagnose", model={"file": "nested/tower.json"})["regions"] == []


def test_a_block_that_touches_nothing_is_propped_and_not_held_by_friction(session: Session) -> None:
    blocks = [box((1, 1, 1), name="post"), box((3, 1, 0.5), (1.1, 0, 0.75), name="beam")]
    model = {"content": content_of(blocks), "supports": "post", "friction": 0.9}
    told = session.answer("mend", model=model, kinds=["prop"])
    (mend,) = told["mends"]
    assert (mend["kind"], mend["verdict"], mend["blocks"]) == ("prop", "stable", ["beam"])
    told = session.answer("mend", model=model, kinds=["friction"])
    assert told["mends"] == []
    assert [one["what"] for one in told["tried"]] == ["it touches no other block"]


def test_an_inline_tower_carries_its_weight(session: Session) -> None:
    model = {"content": content(3), "supports": "lowest", "density": 1000.0, "gravity": 10.0}
    told = session.answer("check", model=model)
    assert (told["verdict"], told["asked"]["blocks"]) == ("stable", 3)
    assert told["most_loaded"][0]["normal"] == pytest.approx(20_000.0, rel=1e-4)
    push = {"kind": "seismic", "kx": 0.7}
    told = session.answer("check", model={**model, "load": [push]})
    assert told["verdict"] == "unstable"


def test_limits_are_brackets_around_closed_forms(session: Session) -> None:
    model = {"file": "nested/tower.json", "friction": 0.4}
    tilt = session.answer("limit", model=model, of="tilt", axis="y")
    assert tilt["stands"] <= 21.801 <= tilt["falls"]  # atan 0.4
    assert tilt["unit"] == "deg"
    push = [{"kind": "seismic", "kx": 1.0}]
    load = session.answer("limit", model=model, of="load", live=push)
    assert load["stands"] <= 0.4 <= load["falls"] * (1.0 + 1e-6)


def test_a_plan_in_counts(session: Session) -> None:
    told = session.answer("plan", model={"file": "nested/tower.json"})
    assert told["counts"]["free"] == 2
    assert told["order"] == ["block-1", "block-2"]
    assert (told["props"], told["verdict"]) == ([], "stable")


def test_blocks_that_are_propped_are_not_called_impossible(session: Session) -> None:
    told = session.answer("plan", model={"file": "arch.obj", "supports": "springer-*"})
    assert told["counts"]["propped"] > 0
    assert told["counts"]["impossible"] == 0


def test_what_is_in_a_file(session: Session) -> None:
    told = session.answer("inspect", model={"file": "arch.obj", "supports": "springer-*"})
    assert (len(told["blocks"]), len(told["asked"]["supports"])) == (14, 2)
    assert told["contacts"]["pairs"] == 13
    assert told["defects"] == []
    assert told["asked"]["size"][2] > 0.0


LARGE = {"blocks": [], "_remark": "x" * 300_000}
REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "above": ({"file": "../secret.json"}, "path relative"),
    "above, inside": ({"file": "nested/../../secret.json"}, "path relative"),
    "absolute": ({"file": os.path.abspath(os.sep + "etc")}, "path relative"),  # noqa: PTH100
    "missing": ({"file": "none.json"}, "no such file"),
    "folder": ({"file": "nested"}, "no such file"),
    "no model": ({"file": "notes.txt"}, "no model file"),
    "broken": ({"file": "broken.json"}, "broken.json, line 1"),
    "no support": ({"file": "arch.obj"}, "no block is fixed"),
    "large": ({"file": "large.obj"}, "MiB allowed"),
    "large object": ({"content": LARGE}, "MiB allowed"),
    "nothing": ({}, "either file or content"),
    "both": ({"file": "shelf.json", "content": {}}, "either file or content"),
    "empty object": ({"content": {}}, "has no 'blocks'"),
    "negative friction": ({"file": "shelf.json", "friction": -1.0}, "friction"),
    "a wrong key": ({"file": "shelf.json", "frictoin": 0.6}, "frictoin"),
    "load on nothing": (
        {"file": "shelf.json", "load": [{"kind": "mass", "block": "x", "mass": 1.0}]},
        "'x'",
    ),
}
if os.name == "posix":
    REFUSED |= {
        "link": ({"file": "link.json"}, "symbolic link"),
        "link to a folder": ({"file": "door/secret.json"}, "symbolic link"),
    }


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_used_is_refused_in_words(case: str, session: Session) -> None:
    model, words = REFUSED[case]
    text = session.refusal("check", model=model)
    assert words in text
    assert "Traceback" not in text
    assert len(text) < 1000


def test_a_limit_of_load_needs_a_load(session: Session) -> None:
    model = {"file": "nested/tower.json"}
    assert "live: is missing" in session.refusal("limit", model=model, of="load")
    push = [{"kind": "mass", "block": "block-2", "mass": 1.0}]
    assert "live: is not used" in session.refusal("limit", model=model, of="tilt", live=push)
    assert "of" in session.refusal("limit", model=model, of="thickness")
    assert "axis: is not used" in session.refusal("limit", model=model, of="shrink", axis="x")
    assert "load: is 1e+30; give words" in session.refusal(
        "limit", model=model, of="load", live=1e30
    )
    assert len(session.refusal("limit", model=model, of="tilt", **{"x" * 2000: 1})) < 500


def test_nothing_was_written_beside_the_models(session: Session, folder: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    session.answer("inspect", model={"file": "shelf.json"})
    session.answer("check", model={"content": content(2), "supports": "lowest"})
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before


@pytest.mark.filterwarnings(
    "ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)
def test_a_call_ends_with_its_time(folder: Path) -> None:
    from mcp import Client

    from drystone.mcp.tools import build

    server = build(Folder.of(folder, 1.0), 0.05)

    async def ask() -> Any:
        async with Client(server) as client:
            return await client.call_tool("check", {"model": {"file": "vault.json"}})

    result = asyncio.run(ask())
    gc.collect()  # anyio leaves the pipes of a worker that it ended
    assert result.is_error
    assert "no answer within 0.05 s" in result.content[0].text


def test_an_analysis_that_runs_out_of_time_tells_what_it_knows(folder: Path) -> None:
    given = {"model": {"file": "vault.json"}}
    told = answer("check", given, Folder.of(folder, 1.0), 1e-6)
    assert (told["verdict"], told["stopped"]) == ("undecided", "the time was up")
    told = answer("limit", {**given, "of": "tilt"}, Folder.of(folder, 1.0), 1e-6)
    assert (told["stands"], told["stopped"]) == (None, "the time was up")


def test_the_command_refuses_a_folder_that_is_not_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["mcp", str(tmp_path / "none")]) == 2
    assert "there is no such folder" in capsys.readouterr().err
    assert main(["mcp", str(tmp_path), "--time-limit", "0"]) == 2
    assert "--time-limit: is 0" in capsys.readouterr().err


posix = pytest.mark.skipif(os.name == "nt", reason="signals to other processes")


def heeding() -> None:
    """Heed the requests to end that the tests were started without, as by nohup."""
    for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(one, signal.SIG_DFL)


STARTING = "drystone: starting ...\n"
"""What a program says that needs seconds to start, on a busy machine."""


class Raw:
    """A server that is written to line by line."""

    def __init__(self, folder: Path) -> None:
        command = [sys.executable, "-m", "drystone", "mcp", str(folder)]
        pipe = subprocess.PIPE
        self.run = subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=pipe, text=True,
            preexec_fn=heeding if os.name == "posix" else None,
        )  # fmt: skip
        about = {"protocolVersion": "2025-06-18", "capabilities": {}}
        about["clientInfo"] = {"name": "raw", "version": "1"}
        self.ask({"id": 0, "method": "initialize", "params": about})
        self.say(json.dumps({"jsonrpc": "2.0", "method": "notifications/initialized"}))

    def say(self, line: str) -> None:
        assert self.run.stdin is not None
        self.run.stdin.write(line + "\n")
        self.run.stdin.flush()

    def ask(self, message: str | dict[str, Any]) -> dict[str, Any]:
        plain = isinstance(message, str)
        self.say(str(message) if plain else json.dumps({"jsonrpc": "2.0", **message}))
        assert self.run.stdout is not None
        answered: dict[str, Any] = json.loads(self.run.stdout.readline())
        return answered

    def call(self, name: str, file: str) -> str:
        given = {"name": name, "arguments": {"model": {"file": file}}}
        answered = self.ask({"id": 1, "method": "tools/call", "params": given})
        text: str = answered["result"]["content"][0]["text"]
        return text

    def ends_with(self, number: int) -> None:
        self.run.send_signal(number)
        assert self.run.wait(30.0) == 0
        assert self.run.stderr is not None
        assert self.run.stderr.read() in ("", STARTING)


@pytest.fixture
def raw(folder: Path) -> Iterator[Raw]:
    made = Raw(folder)
    yield made
    made.run.kill()
    made.run.communicate()


@posix
def test_every_line_is_answered_and_a_request_to_end_ends_it_while_none_comes(raw: Raw) -> None:
    assert "a?.json: there is no such file" in raw.call("check", "a\ud800.json")
    assert "there is no such file" in raw.call("check", "x" * 5000)
    assert "there is no tool 'chekc'; did you mean check" in raw.call("chekc", "shelf.json")
    listed = '{"jsonrpc": "2.0", "method": "tools/list", "id": %s}'
    odd = [listed % one for one in ("null", "1.5", "1e400", "{}")]
    for line in ("no JSON", '{"id": 5}', "[" * 5000, '{"id": %s}' % ("1" * 5000), *odd):
        answered = raw.ask(line)
        assert (answered["id"], answered["error"]["code"]) == (None, -32700)
    assert '"verdict": "unstable"' in raw.call("check", "shelf.json")
    raw.ends_with(signal.SIGTERM)


@posix
def test_ctrl_c_ends_it_while_lines_come(raw: Raw) -> None:
    for _ in range(500):
        raw.say(json.dumps({"jsonrpc": "2.0", "method": "notifications/initialized"}))
    raw.ends_with(signal.SIGINT)
