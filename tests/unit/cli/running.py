"""Commands run in this process, and what they print."""

import json
from typing import Any

import pytest

from drystone.cli import main

Capsys = pytest.CaptureFixture[str]


def answer(capsys: Capsys, *arguments: str) -> tuple[int, Any]:
    """Exit code and the object of a command with --json; nothing else may be printed."""
    code = main([*arguments, "--json"])
    out, err = capsys.readouterr()
    assert err == ""
    assert out.count("\n") == 1
    return code, json.loads(out)


def refused(capsys: Capsys, *arguments: str) -> str:
    """The one line that a command prints when its input is bad."""
    assert main(list(arguments)) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err
