"""The program: its commands, and what becomes of errors.

Exit codes: 0 answered and stable, 1 answered and not stable, 2 bad input, 3 something missing,
70 a fault of drystone itself, 130 interrupted: with the answer so far, or with none.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from typing import Any

import typer
from typer.core import TyperGroup

from drystone.cli import output
from drystone.cli.check import check
from drystone.cli.convert import convert
from drystone.cli.demo import demo
from drystone.cli.inspect import inspect
from drystone.cli.limit import limit
from drystone.cli.mend import mend
from drystone.cli.plan import plan
from drystone.cli.reproduce import reproduce
from drystone.cli.settle import settle
from drystone.cli.shell import shell
from drystone.cli.waiting import INTERRUPTED, NOTHING, UNDER_WAY
from drystone.errors import DrystoneError, MissingDependency

USAGE_ERROR: Any = typer.BadParameter.__bases__[0]
"""The base of typer's errors about the command line; its home moved between releases."""
BAD_INPUT, MISSING, FAULT = 2, 3, 70


class Interrupted(Exception):
    """Ctrl-C ended a command before it had an answer; says what is left of it."""


class Program(TyperGroup):
    """The commands. Typer would make an exit code of Ctrl-C, and forget what is said about it."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that is asked for."""
        UNDER_WAY.set(None)
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as error:
            work = UNDER_WAY.get()
            raise Interrupted(NOTHING if work is None else work.left()) from error


app = typer.Typer(
    name="drystone",
    cls=Program,
    help="Does a structure of loose blocks stand by contact and friction alone?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(asked: bool) -> None:
    if asked:
        from drystone import __version__

        output.say(f"drystone {__version__}")
        raise typer.Exit


@app.callback()
def _program(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Show the version and exit."
    ),
) -> None:
    """Does a structure of loose blocks stand by contact and friction alone?"""


for _command in (check, mend, inspect, convert, demo, settle, shell, plan, reproduce):
    app.command()(_command)
app.add_typer(limit, name="limit")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code.

    Parameters
    ----------
    arguments
        Without the name of the program; those of the process when left out.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    as_json = "--json" in given
    try:
        code = app(args=given, prog_name="drystone", standalone_mode=False)
    except MissingDependency as error:
        return output.fail(error, MISSING, as_json)
    except DrystoneError as error:
        return output.fail(error, BAD_INPUT, as_json)
    except USAGE_ERROR as error:
        return _usage(error, as_json)
    except Interrupted as error:
        return output.fail(KeyboardInterrupt(f"interrupted; {error}"), INTERRUPTED, as_json)
    except (KeyboardInterrupt, typer.Abort):
        return output.fail(KeyboardInterrupt(f"interrupted; {NOTHING}"), INTERRUPTED, as_json)
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115  # for exit
        return 1
    except OSError as error:
        return output.fail(error, BAD_INPUT, as_json)
    except Exception as error:  # the edge of the program: a fault of ours, told in one line
        if os.environ.get("DRYSTONE_TRACEBACK"):
            traceback.print_exc()
        return output.fail(error, FAULT, as_json)
    return int(code or 0)


def _usage(error: Any, as_json: bool) -> int:
    """A wrong option or argument; without any argument, the help."""
    if type(error).__name__ == "NoArgsIsHelpError":
        output.say(error.format_message())
        return BAD_INPUT
    hint = f"see '{error.ctx.command_path} --help'" if error.ctx is not None else ""
    wording = error.format_message().rstrip(".")
    return output.fail(output.UsageFault(wording, remedy=hint), BAD_INPUT, as_json)
