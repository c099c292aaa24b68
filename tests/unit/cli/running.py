"""Every command by its name; commands run in this process, and what they print."""

import json
from typing import Any

import click
import pytest

from drystone.cli import main
from drystone.cli.application import app
from drystone.cli.command import Command

Capsys = pytest.CaptureFixture[str]


def commands(group: click.Group = app, before: tuple[str, ...] = ()) -> dict[str, Command]:
    """Every command by its words."""
    found: dict[str, Any] = {}
    for name in group.list_commands(click.Context(group)):
        one = group.get_command(click.Context(group), name)
        assert one is not None
        if isinstance(one, click.Group):
            found |= commands(one, (*before, name))
        else:
            found[" ".join((*before, name))] = one
    return found


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
