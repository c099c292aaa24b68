"""What is no honest request is refused in words, and the next honest one is answered."""

import ast
import contextlib
import io as memory
import json
import os
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from shutil import which
from typing import Any
from urllib.error import HTTPError

import pytest

import drystone
from drystone import io
from drystone.live import client, helper, web
from drystone.live.helper import ToolCalls
from drystone.live.serving import Live
from drystone.mcp.answers import TOOLS
from drystone.models import arch, tower, vault
from tests.unit.live.live_client import PATIENCE, Window, ask, overhang, raw

GIB = 2**30


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    outside = tmp_path_factory.mktemp("outside")
    made = tmp_path_factory.mktemp("served")
    io.write(drystone.Model.of(tower(3), friction=0.4), made / "tower.json")
    io.write(drystone.Model.of(overhang(), friction=0.9), made / "out.json")
    io.write(drystone.Model.of(vault(), friction=0.7), made / "vault.json")
    io.write(tower(2), outside / "secret.json")
    (made / "link.json").symlink_to(outside / "secret.json")
    return made


@pytest.fixture(scope="module")
def live(folder: Path) -> Iterator[Live]:
    with Live(folder / "tower.json", port=0, size_limit=1.0) as made:
        yield made


def words(answer: tuple[int, Any], status: int) -> str:
    """The refusal of an answer with this status."""
    assert answer[0] == status, answer
    error = answer[1]["error"]
    text = f"{error['where']}: {error['what']}; {error['remedy']}"
    assert "Traceback" not in text
    assert len(text) < 600
    return text


def honest(live: Live) -> None:
    """The next honest request is answered."""
    assert ask(live, "/v1")[1]["interface"] == "v1"


def test_the_link_opens_the_page_and_nothing_else_does(live: Live) -> None:
    path = live.link.removeprefix(f"http://127.0.0.1:{live.port}")
    status, page = ask(live, path, token=False)
    assert (status, page[:15]) == (200, "<!doctype html>")
    assert live.server.guard.token not in page
    assert "missing" in words(ask(live, "/", token=False), 401)
    assert "not that" in words(ask(live, "/?token=guess", token=False), 403)
    assert "missing" in words(ask(live, "/v1/check", {}, token=False), 401)
    assert "missing" in words(ask(live, "/events?window=a", token=False), 401)


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
        {"Host": "evil.example"},
        {"Host": "evil.example:80"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
    ids=str,
)
def test_other_sites_are_refused_even_with_the_token(live: Live, headers: dict[str, str]) -> None:
    told = words(ask(live, "/v1/check", {}, headers=headers), 403)
    assert "another" in told
    told = words(ask(live, f"/?token={live.server.guard.token}", headers=headers), 403)
    honest(live)


def test_our_own_page_is_no_other_site(live: Live) -> None:
    own = {"Origin": f"http://127.0.0.1:{live.port}", "Sec-Fetch-Site": "same-origin"}
    assert ask(live, "/v1", headers=own)[0] == 200


@pytest.mark.parametrize(
    "path",
    [
        "/../../etc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/model/../1",
        "/model/99999",
        "/model/" + 5_000 * "9",
        "/static/page.css",
        "/v2",
    ],
)
def test_there_is_nothing_at_other_addresses(live: Live, path: str) -> None:
    words(ask(live, path), 404)


def test_an_address_that_cannot_be_read_is_refused_in_words(live: Live) -> None:
    answer = raw(live, f"GET http://[ HTTP/1.1\r\nHost: 127.0.0.1:{live.port}\r\n\r\n".encode())
    assert answer.startswith(b"HTTP/1.0 400 ")
    assert b"the address cannot be read" in answer


def test_calls_that_are_not_there(live: Live) -> None:
    assert "/v1/check" in words(ask(live, "/v1/remove", {}), 404)
    words(ask(live, "/live/erase", {"window": "a"}), 404)
    status, _ = ask(live, "/v1/check", {}, method="DELETE")
    assert status == 501


def head(live: Live, *lines: str) -> bytes:
    """A request of the JSON interface with other headers."""
    made = ["POST /v1/check HTTP/1.1", f"Host: 127.0.0.1:{live.port}",
            f"Authorization: Bearer {live.server.guard.token}", *lines]  # fmt: skip
    return "\r\n".join(made).encode() + b"\r\n\r\n"


@pytest.mark.parametrize(
    ("line", "status", "told"),
    [
        (f"Content-Length: {GIB}", 413, "more than the 1 allowed"),
        (f"Content-Length: {GIB}\r\nExpect: 100-continue", 413, "more than the 1 allowed"),
        ("Content-Length: -1", 411, "no length"),
        ("Content-Length: 99999999999999999999999", 411, "no length"),
        ("Transfer-Encoding: chunked", 411, "no length"),
        ("X: y", 411, "no length"),
    ],
)
def test_a_body_without_bounds_is_not_read(live: Live, line: str, status: int, told: str) -> None:
    answer = raw(live, head(live, line))
    assert answer.startswith(f"HTTP/1.0 {status} ".encode())
    assert told in answer.decode()
    honest(live)


@pytest.mark.parametrize("data", [b"\0\1\2\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9\r\n\r\n"])
def test_what_is_not_http_is_refused(live: Live, data: bytes) -> None:
    assert b'"error"' in raw(live, data)
    honest(live)


def test_a_header_of_a_megabyte_is_refused(live: Live) -> None:
    try:
        answer = raw(live, head(live, "X: " + "y" * 2**20))
    except ConnectionError:
        answer = b"431"  # it was closed while we still sent
    assert b"431" in answer
    honest(live)


BOMBS = {
    "no JSON": b"{",
    "empty": b"",
    "deep": b"[" * 100_000,
    "deep objects": b'{"model":' * 50_000,
    "long number": b'{"model": ' + b"9" * 10_000 + b"}",
    "huge number": b'{"model": {"file": "tower.json", "friction": 1e999}}',
    "not a number": b'{"model": {"file": "tower.json", "friction": NaN}}',
    "negative friction": b'{"model": {"file": "tower.json", "friction": -0.1}}',
    "twice": b'{"model": {}, "model": {}}',
    "list": b"[]",
    "no model": b"{}",
    "unknown": b'{"model": {"file": "tower.json"}, "shell": "rm"}',
    "unknown in model": b'{"model": {"file": "tower.json", "path": "/"}}',
    "above": b'{"model": {"file": "../secret.json"}}',
    "above in a folder": b'{"model": {"file": "a/../../secret.json"}}',
    "above on Windows": rb'{"model": {"file": "..\\secret.json"}}',
    "absolute": b'{"model": {"file": "/etc/passwd"}}',
    "link": b'{"model": {"file": "link.json"}}',
    "not text": b"\xff\xfe",
    "types": b'{"model": {"file": 7}}',
    "load": b'{"model": {"file": "tower.json", "load": true}}',
    "wide": b'{"model": {"content": {"blocks": [' + b"{}," * 200_000 + b"{}]}}}",
}


@pytest.mark.parametrize("bomb", BOMBS)
def test_json_that_cannot_be_used_is_refused_in_words(live: Live, bomb: str) -> None:
    words(ask(live, "/v1/check", BOMBS[bomb]), 400)
    honest(live)


WISHES = {
    "negative friction": ({"friction": -0.1}, "give 0 or more"),
    "negative gravity": ({"gravity": -1}, "give 0 or more, up to 1000"),
    "tilt": ({"tilt": 400}, "give 0 or more, up to 180"),
    "text": ({"tilt": "8"}, "must be a number"),
    "unknown": ({"colour": 1}, "colour"),
    "move": ({"moves": [{"block": "a", "by": [1, 2]}]}, "not 3"),
    "force": ({"pushes": [{"block": "a", "force": [1, 2]}]}, "not 3"),
    "names": ({"removed": "all"}, "must be a list"),
}


@pytest.mark.parametrize("case", WISHES)
def test_wishes_that_cannot_be_are_refused_in_words(live: Live, case: str) -> None:
    wish, told = WISHES[case]
    body = {"window": "a", "model": 1, "wish": wish}
    assert told in words(ask(live, "/live/wish", body), 400)


def test_wishes_of_windows_models_and_tasks_that_are_not_there(live: Live) -> None:
    assert "stream" in words(ask(live, "/live/wish", {"window": "none", "model": 1}), 400)
    words(ask(live, "/live/wish", {"window": "a", "wish": {"removed": ["x" * 300_000]}}), 413)
    assert "no task" in words(ask(live, "/live/task", {"window": "a", "task": "rm"}), 400)
    words(ask(live, "/events?window=../a"), 400)
    window = Window(live, "strange")
    answer = ask(live, "/live/wish", {"window": "strange", "model": 77})
    assert "model 77" in words(answer, 400)
    number = window.wish(removed=["nobody"])
    assert "nobody" in window.until("error", number)["what"]
    number = window.wish(removed=["block-0", "block-1", "block-2"])
    assert "every block" in window.until("error", number)["what"]
    assert window.answer()["verdict"] == "stable"
    window.close()


def test_connections_that_never_end_give_way(live: Live) -> None:
    idle = [socket.create_connection(("127.0.0.1", live.port)) for _ in range(200)]
    for one in idle[::2]:
        one.sendall(b"POST /v1/check HTTP/1.1\r\nX: ")
    honest(live)
    idle[0].settimeout(60)
    assert b"503" in idle[0].recv(1000)
    for one in idle:
        one.close()
    honest(live)


def test_a_request_that_comes_byte_by_byte_is_ended(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(web, "PATIENCE", 0.3)
    with socket.create_connection(("127.0.0.1", live.port)) as slow:
        slow.settimeout(60)
        slow.sendall(b"GET / HT")
        assert b"408" in slow.recv(1000)
    honest(live)


def test_windows_are_bounded(live: Live) -> None:
    until_closed(live)
    windows = [Window(live, f"w{i}") for i in range(16)]
    assert "16 windows" in words(ask(live, "/events?window=more"), 400)
    for window in windows:
        window.close()
    until_closed(live)
    honest(live)


def until_closed(live: Live) -> None:
    """Wait until the server has seen that every window was closed."""
    end = time.monotonic() + 300.0
    while live.desk.windows:
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_call_that_takes_too_long_ends_and_the_next_is_answered(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = ToolCalls(live.desk.folder, 1e-9)
    body = json.dumps({"model": {"file": "out.json"}}).encode()
    try:
        with monkeypatch.context() as at_once:
            at_once.setattr(helper, "POLL_S", 1e-6)
            status, text = calls.call("mend", body)
        assert (status, "no answer within" in text) == (504, True)
        calls.seconds = 300.0
        status, text = calls.call("check", body)
        assert (status, json.loads(text)["verdict"]) == (200, "unstable")
    finally:
        calls.close()


def test_a_model_that_takes_minutes_ends_in_words_and_the_next_call_is_answered(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live.calls, "seconds", 1.0)  # its plan takes much longer
    status, told = ask(live, "/v1/plan", {"model": {"file": "vault.json"}})
    if status == 200:
        assert told["stopped"]
    else:
        assert "no answer within" in words((status, told), 504)
    monkeypatch.setattr(live.calls, "seconds", 300.0)
    assert ask(live, "/v1/check", {"model": {"file": "out.json"}})[1]["verdict"] == "unstable"


def test_a_search_that_takes_minutes_gives_way_to_a_wish(live: Live, folder: Path) -> None:
    with Live(folder / "vault.json", port=0) as slow:
        window = Window(slow, "slow")
        number = window.task("mends", tilt=20)
        window.until("progress")
        window.wish(removed=[io.read(folder / "vault.json").assembly.names[-1]])
        window.until("quick", window.number)
        assert not [one for one in window.events if one["event"] == "mends"]
        assert window.number == number + 1
        honest(slow)
        window.close()


def test_a_gigabyte_is_not_waited_for(live: Live) -> None:
    with socket.create_connection(("127.0.0.1", live.port), timeout=PATIENCE) as connection:
        connection.sendall(head(live, f"Content-Length: {GIB}"))
        with contextlib.suppress(ConnectionError):  # it is closed while we still send
            for _ in range(64):  # MiB, of which one is read
                connection.sendall(bytes(2**20))
            pytest.fail("64 MiB of a refused body were read")
    honest(live)


def test_a_calculation_that_crashes_is_replaced(live: Live) -> None:
    window = Window(live, "crash")
    assert window.answer()["verdict"] == "stable"
    live.desk.helper._process.kill()
    assert window.answer(tilt=2)["verdict"] == "stable"
    window.close()


# -- the JSON interface and its client ----------------------------------------------------------


def test_the_interface_offers_what_the_tools_are(live: Live) -> None:
    assert set(ask(live, "/v1")[1]["calls"]) == set(TOOLS)


def test_check_limit_plan_and_mend_by_the_client(live: Live) -> None:
    server = client.Server(live.link)
    tower_ = {"file": "tower.json"}
    assert server.check(tower_)["verdict"] == "stable"
    limit = server.limit(tower_, "tilt", axis="y")
    assert limit["stands"] <= 21.801 <= limit["falls"]  # atan 0.4
    assert server.plan(tower_)["order"] == ["block-1", "block-2"]
    assert server.call("files")["count"] == 3
    mends = server.mend({"file": "out.json"}, kinds=["prop"])["mends"]
    assert {one["kind"] for one in mends} == {"prop"}
    status, told = ask(live, "/v1/check", {"model": {"file": "../secret.json"}})
    assert (status, told["error"]["where"]) == (400, "../secret.json")
    assert "path relative" in told["error"]["remedy"]
    with pytest.raises(client.Refused, match="path relative") as refused:
        server.check({"file": "../secret.json"})
    assert isinstance(refused.value.__context__, HTTPError)
    assert refused.value.__context__.closed  # or Python 3.14 warns
    with socket.create_server(("127.0.0.1", 0)) as silent:  # takes the call, says nothing
        link = f"http://127.0.0.1:{silent.getsockname()[1]}/?token=x"
        with pytest.raises(client.Refused, match="no answer within"):
            client.Server(link, 0.05).check(tower_)
    with pytest.raises(client.Refused, match="token"):
        client.Server(live.link + "x").check(tower_)
    with pytest.raises(client.Refused, match="no server answers"):
        client.Server("http://127.0.0.1:9/?token=x").check(tower_)


def test_the_client_sends_blocks(live: Live) -> None:
    blocks = [
        client.block(one.name, one.vertices, one.faces, fixed=i == 0)
        for i, one in enumerate(arch(0.15, 12).blocks[:1])
    ]
    told = client.Server(live.link).check({"content": {"blocks": blocks}})
    assert told["verdict"] == "stable"


def test_the_client_has_no_syntax_that_old_pythons_lack() -> None:
    assert client.__file__
    text = Path(client.__file__).read_text("utf-8")
    tree = ast.parse(text, feature_version=(3, 4))
    new = (ast.JoinedStr, ast.AnnAssign, ast.AsyncFunctionDef, ast.NamedExpr, ast.Starred)
    assert not [node for node in ast.walk(tree) if isinstance(node, new)]
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            assert not node.args.kwonlyargs
            assert node.returns is None
            assert all(one.annotation is None for one in node.args.args)
        if isinstance(node, ast.Raise):
            assert node.cause is None
    assert text.isascii()
    assert memory.StringIO(text).readline().startswith('"""')


def old_pythons() -> list[str]:
    """Interpreters of this machine that are older than the one that drystone needs."""
    named = [found for name in ("python2.7", "python3.6", "python3.8") if (found := which(name))]
    kept = Path.home().glob(".pyenv/versions/*/bin/python")
    asked = "import sys; print('%d.%d' % sys.version_info[:2])"
    found: dict[str, str] = {}
    for program in [*named, *map(str, sorted(kept))]:
        told = subprocess.run([program, "-c", asked], capture_output=True, text=True, check=False)
        version = told.stdout.strip()
        if told.returncode == 0 and version in ("2.7", "3.6", "3.8"):
            found.setdefault(version, program)
    return list(found.values())


def test_the_client_runs_in_old_pythons(live: Live, tmp_path: Path) -> None:
    programs = old_pythons()
    if not programs:
        pytest.skip("no older Python on this machine")
    script = (
        "import sys, drystone_client\n"
        "server = drystone_client.Server(sys.argv[1], 600.0)\n"
        "cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]\n"
        "faces = [[0,1,3,2], [4,6,7,5], [0,4,5,1], [2,3,7,6], [0,2,6,4], [1,5,7,3]]\n"
        "top = [[x, y, z + 1] for x, y, z in cube]\n"
        "blocks = [drystone_client.block('base', cube, faces, True),\n"
        "          drystone_client.block('top', top, faces)]\n"
        "print(server.check({'content': {'blocks': blocks}, 'friction': 0.6})['verdict'])\n"
        "try:\n"
        "    server.check({'file': 'none.json'})\n"
        "except drystone_client.Refused as error:\n"
        "    print(error)\n"
    )
    assert client.__file__
    (tmp_path / "drystone_client.py").write_bytes(Path(client.__file__).read_bytes())
    (tmp_path / "ask.py").write_text(script)
    for program in programs:
        told = subprocess.run(
            [program, "ask.py", live.link], cwd=tmp_path, capture_output=True, text=True,
            timeout=PATIENCE, check=False, env={"PATH": os.environ["PATH"]},
        )  # fmt: skip
        assert told.returncode == 0, (program, told.stderr)
        verdict, refusal = told.stdout.splitlines()
        assert verdict == "stable", program
        assert "no such file" in refusal
