"""Groups of options: one declaration, many commands."""

import inspect
from dataclasses import dataclass
from typing import Annotated

import typer
from typer.testing import CliRunner

from drystone.cli.groups import expanded


@dataclass(frozen=True)
class Stone:
    quarry: Annotated[str, typer.Argument()]
    weight: Annotated[float, typer.Option(help="Weight in kg.")] = 1.0
    wet: Annotated[bool, typer.Option("--wet")] = False


SEEN: list[tuple[Stone, str, int]] = []


@expanded
def lay(*, rows: Annotated[int, typer.Option()] = 1, stone: Stone, place: str) -> int:
    """Lay stones."""
    SEEN.append((stone, place, rows))
    return 0


def test_a_group_stands_for_its_options_in_its_place() -> None:
    parameters = inspect.signature(lay).parameters
    assert list(parameters) == ["quarry", "place", "rows", "weight", "wet"]
    assert parameters["weight"].default == 1.0
    assert lay.__doc__ == "Lay stones."


def test_the_command_gets_its_groups_back() -> None:
    app = typer.Typer()
    app.command()(lay)
    arguments = ["north", "wall", "--weight", "2.5", "--wet", "--rows", "3"]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0
    assert SEEN.pop() == (Stone("north", 2.5, True), "wall", 3)
    assert "Weight in kg." in CliRunner().invoke(app, ["--help"]).output
