"""Commands made of functions: groups of options, help, examples, completion."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import click
import pytest

from drystone import io
from drystone.answer import Role, Sentence, Statement
from drystone.cli import main
from drystone.cli.command import command
from drystone.cli.offered import MODEL, Argument, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.model import Model
from drystone.models import h_model
from tests.unit.cli.running import commands

Capsys = pytest.CaptureFixture[str]


@dataclass(frozen=True)
class Stone:
    quarry: Annotated[str, Argument("QUARRY", "Where it is from.")]
    weight: Annotated[float, Option("Weight in kg.", MODEL)] = 1.0
    wet: Annotated[bool, Option("Wet.", expert=True)] = False


SEEN: list[tuple[Stone, str, int, tuple[str, ...]]] = []


@command("lay north wall", "lay south wall --rows 2")
def lay(
    *,
    rows: Annotated[int, Option("Rows.")] = 1,
    stone: Stone,
    place: Annotated[str, Argument("PLACE", "Where it goes.")],
    tool: Annotated[tuple[str, ...], Option("Tools.")] = (),
    waiting: Waiting,
) -> Told:
    """Lay stones."""
    assert isinstance(waiting, Waiting)
    SEEN.append((stone, place, rows, tool))
    return Told(Statement((Sentence("laid", Role.GOOD),), values={"laid": rows}))


def test_the_command_gets_its_groups_back(capsys: Capsys) -> None:
    given = ["north", "wall", "--weight", "2.5", "--wet", "--rows", "3", "--tool", "a"]
    assert lay.main([*given, "--tool", "b", "--json"], standalone_mode=False) == 0
    assert SEEN.pop() == (Stone("north", 2.5, True), "wall", 3, ("a", "b"))
    assert '"laid": 3' in capsys.readouterr().out
    assert lay.main(["north", "wall"], standalone_mode=False) == 0
    assert SEEN.pop() == (Stone("north"), "wall", 1, ())
    assert "laid" in capsys.readouterr().out


def test_help_shows_groups_and_examples_and_hides_expert_options(capsys: Capsys) -> None:
    with pytest.raises(SystemExit):
        lay.main(["--help"], prog_name="lay")
    out = capsys.readouterr().out
    for words in ("QUARRY", "Model:\n  --weight", "Analysis:\n  --rows", "Examples:\n  lay north"):
        assert words in out
    assert "--wet" not in out
    assert "1 more option: lay --help-all" in out
    with pytest.raises(SystemExit):
        lay.main(["--help-all"], prog_name="lay")
    assert "--wet" in capsys.readouterr().out


@pytest.mark.parametrize("name", commands())
def test_the_help_of_every_command_has_two_examples_and_few_options(
    name: str, capsys: Capsys
) -> None:
    assert main([*name.split(), "--help"]) == 0
    out = capsys.readouterr().out
    examples = out.partition("Examples:\n")[2].splitlines()
    assert len(examples) == 2
    assert all(
        line.startswith(f"  drystone {name}") for line in examples if line != "  drystone demo"
    )
    assert len(re.findall(r"^  --[a-z]", out, re.MULTILINE)) <= 16
    assert max(map(len, out.splitlines())) <= 100


@pytest.mark.parametrize("name", ["", "limit", *commands()])
def test_every_command_shows_all_of_its_options(name: str, capsys: Capsys) -> None:
    assert main([*name.split(), "--help-all"]) == 0
    assert "more option" not in capsys.readouterr().out


def test_mends_that_fail_are_folded_and_listed_on_request(tmp_path: Path, capsys: Capsys) -> None:
    path = tmp_path / "h.json"
    io.write(Model.of(h_model(), friction=0.5), path)
    command = ["mend", str(path), "--kind", "friction"]
    assert main(command) == main([*command, "--all"]) == 1
    short, _, every = capsys.readouterr().out.partition("block: friction: it falls")
    assert short.count("1 combination was tried without success: friction") == 2
    assert short.count("--all lists every mend, and all that was tried") == 1
    assert every
    assert "--all" not in every


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_get_their_completion(shell: str, capsys: Capsys) -> None:
    assert main(["--completion", shell]) == 0
    assert "_DRYSTONE_COMPLETE" in capsys.readouterr().out


def test_commands_options_and_choices_are_completed(
    capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    def completed(*words: str) -> list[str]:
        monkeypatch.setenv("_DRYSTONE_COMPLETE", "bash_complete")
        monkeypatch.setenv("COMP_WORDS", " ".join(("drystone", *words)))
        monkeypatch.setenv("COMP_CWORD", str(len(words)))
        with pytest.raises(SystemExit):
            main([])
        return [line.partition(",")[2] for line in capsys.readouterr().out.splitlines()]

    assert completed("ins") == ["inspect"]
    assert completed("check", "model.obj", "--fr") == ["--friction"]
    assert completed("check", "model.obj", "--edges", "is") == ["isolated"]
    assert completed("check", "--units", "m") == ["mm", "m"]


def test_an_option_without_its_value_and_a_flag_with_one_are_told(capsys: Capsys) -> None:
    for given, told in (
        (["check", "x.json", "--friction"], "--friction: needs a value"),
        (["check", "x.json", "--strict=3"], "--strict: takes no value"),
        (["check"], "MODEL: is missing"),
        (["limit", "thrust", "one.json"], "MODEL or BLOCK: is missing"),
        (["mcp", ".", "more"], "'more' is one argument too many"),
        (["check", "x.json", "--seismic=1,0", "--seismic=0,1"], "--seismic is given twice; give"),
        (["check", "x.json", "--frction", "1"], "there is no option '--frction'; did you mean"),
        (["limit", "tlit"], "there is no command 'tlit'; did you mean 'tilt'"),
    ):
        assert main(given) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.startswith(f"drystone: {told}")
        assert err.count("\n") == 1


@pytest.mark.parametrize(("path", "one"), commands().items())
def test_the_help_of_a_command_shows_about_a_dozen_options(path: str, one: click.Command) -> None:
    text = one.get_help(click.Context(one, info_name=path))
    shown = [line.split()[0] for line in text.splitlines() if line.startswith("  --")]
    assert len([name for name in shown if not name.startswith("--help")]) <= 13
    assert text.count(f"\n  drystone {path}") >= 2, "two examples"


def test_the_list_of_limits_tells_each_in_full(capsys: Capsys) -> None:
    assert main(["limit", "--help"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "..." not in out.partition("Commands:")[2]
    assert "that the others exert on a block along a direction tilt The largest" in out
