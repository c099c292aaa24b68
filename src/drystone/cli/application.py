"""The program: its commands and its errors.

Exit codes: 0 stable, 1 not stable, 2 bad input, 3 a package is missing, 70 an error inside
drystone, 130 interrupted, with or without an answer, 141 the reader of the output went away.
"""

from __future__ import annotations

import difflib
import io
import mmap
import os
import sys
import traceback
from collections.abc import Mapping, Sequence
from functools import cached_property
from importlib import import_module
from types import MappingProxyType
from typing import Any

import click

from drystone.base.errors import DrystoneError, InputError
from drystone.cli import kinds, output
from drystone.cli.command import SETTINGS, help_all, write_examples
from drystone.cli.waiting import NOTHING, UNDER_WAY, ends_as_ctrl_c

_SHELLS = ("bash", "zsh", "fish")
"""Shells for which click writes completion."""


class _Interrupted(Exception):
    """Ctrl-C ended a command before its answer; the message names what was written."""


class _Program(click.Group):
    """Commands by name; without one, the help. A command is imported when it is asked for.

    Attributes
    ----------
    examples
    places
        Module of :mod:`drystone.cli` that has the command of each name; or an analysis, or its
        module and what it answers.
    """

    examples: tuple[str, ...] = ()
    places: Mapping[str, Any] = MappingProxyType({})

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        """Names of the commands, in order."""
        return sorted({**self.commands, **self.places})

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        """The command of a name."""
        place = None if cmd_name in self.commands else self.places.get(cmd_name)
        if isinstance(place, str):
            found = getattr(import_module(f"drystone.cli.{place}"), cmd_name)
            self.add_command(found, cmd_name)
        elif place is not None:
            from drystone.cli.command import AnalysisCommand  # when it is asked for

            words = cmd_name if self is app else f"{self.name} {cmd_name}"
            self.add_command(AnalysisCommand(words, place))
        return self.commands.get(cmd_name)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command that is asked for. Click would forget what is said about Ctrl-C."""
        try:
            return super().invoke(ctx)
        except _Interrupted:  # of a group in this one
            raise
        except (KeyboardInterrupt, Exception) as error:
            if not _is_of_ctrl_c(error):
                raise
            work = UNDER_WAY.get()
            raise _Interrupted(NOTHING if work is None else work.left()) from error

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """The command that is asked for; without one, the help and the exit code of bad input."""
        if not args and not ctx.resilient_parsing:
            output.say(ctx.get_help())
            ctx.exit(output.BAD_INPUT)
        return super().parse_args(ctx, args)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command of that name."""
        known = self.list_commands(ctx)
        if args[0] not in known and not args[0].startswith("-"):
            raise output.UsageFault(
                f"there is no command '{args[0]}'", remedy=_meant(args[0], known, ctx)
            )
        return super().resolve_command(ctx, args)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """The examples, a line each."""
        write_examples(self.examples, formatter)


class _Limits(_Program):
    """Commands that are made of the limits in their table."""

    @cached_property
    def places(self) -> Mapping[str, Any]:  # type: ignore[override]  # a mapping that is set
        """The limits, and the command for families of models."""
        from drystone.limits import LIMITS  # the program starts without numpy

        return {**LIMITS, "thickness": "shell_command"}


limit = _Limits(
    "limit",
    help="Limits: largest tilt, least friction and others.",
    params=[help_all()],
    context_settings=SETTINGS,
)
limit.examples = ("drystone limit tilt arch.json", "drystone limit thickness arch")
app = _Program(
    "drystone",
    help="Does a structure of loose blocks stand by contact and friction alone?",
    params=[help_all()],
    context_settings=SETTINGS,
)
app.examples = ("drystone demo", "drystone check arch.json --html arch.html")
_WRITTEN = {
    "application": "limit",
    "check_command": "check fall settle",
    "file_commands": "convert inspect poses",
    "mend_command": "cut mend shape",
    "models_command": "demo models reproduce",
    "plan_command": "dataset plan scaffold",
    "server_commands": "live mcp",
    "shell_command": "shell tune",
    "study_command": "report study",
}
"""The commands that are written, by module; the others are made of their analyses."""

app.places = {name: module for module, names in _WRITTEN.items() for name in names.split()} | {
    "combine": (
        "drystone.studies.combinations",
        "Check every combination of actions with partial factors",
    ),
    "forces": (
        "drystone.programs.force_states",
        "Forces in the joints, with tension where compression is not enough",
    ),
    "gravity": (
        "drystone.sequence.gravity_regions",
        "The directions of gravity in which a model holds, without and with friction",
    ),
    "interlock": (
        "drystone.sequence.freedom",
        "Whether a model with its supports fixed holds under every load without friction",
    ),
    "kinematic": (
        "drystone.seismic.local_mechanism",
        "Local collapse mechanism of masonry in an earthquake, by the kinematic method",
    ),
    "push": (
        "drystone.settlement.large_displacement",
        "Load against displacement, until the load is zero again",
    ),
    "recut": (
        "drystone.design.cuts",
        "Change joints until every block is placed alone and stands at once",
    ),
    "sharpen": (
        "drystone.design.sharpening",
        "Make wedges of plane joints with tension, until a model stands",
    ),
}


def _version(ctx: click.Context, _: click.Parameter, asked: bool) -> None:
    if asked:
        from drystone import __version__
        from drystone.base.version import commit

        output.say(f"drystone {__version__}" + (f" ({commit()})" if commit() else ""))
        ctx.exit()


def _completion(ctx: click.Context, _: click.Parameter, shell: str | None) -> None:
    if shell is not None:
        from click.shell_completion import get_completion_class

        kind = get_completion_class(shell)
        if kind is not None:
            output.say(kind(app, {}, "drystone", "_DRYSTONE_COMPLETE").source())
        ctx.exit()


app.params += [
    click.Option(
        ["--version"],
        is_flag=True, is_eager=True, expose_value=False, callback=_version,
        help="Show the version and the commit, and exit.",
    ),
    click.Option(
        ["--completion"],
        type=kinds.one_of(_SHELLS), is_eager=True, expose_value=False, callback=_completion,
        help="Print what makes a shell complete commands and options, and exit.",
    ),
]  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code.

    Parameters
    ----------
    arguments
        Without the name of the program; those of the process when left out.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    as_json = "--json" in given
    if isinstance(sys.stdout, io.TextIOWrapper):  # a name that it cannot encode is written escaped
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        _refuse_little_memory()
        with ends_as_ctrl_c():
            code = int(app.main(args=given, prog_name="drystone", standalone_mode=False) or 0)
            if sys.stdout is not None:
                sys.stdout.flush()
            return code
    except DrystoneError as error:
        return output.fail(error, output.code_of(error), as_json)
    except click.UsageError as error:
        return output.fail(_in_our_words(error), output.BAD_INPUT, as_json)
    except (_Interrupted, KeyboardInterrupt, click.Abort) as error:
        left = error if isinstance(error, _Interrupted) else NOTHING
        return output.fail(KeyboardInterrupt(f"interrupted; {left}"), output.INTERRUPTED, as_json)
    except (BrokenPipeError, SystemExit) as error:
        # click and rich exit with 1 where nobody reads, click with 0 when it has completed a word
        if isinstance(error, SystemExit) and error.code != 1:
            raise
        sys.stdout = output.nowhere()
        return output.CLOSED
    except OSError as error:
        return output.fail(error, output.BAD_INPUT, as_json)
    except Exception as error:  # the edge of the program: an error inside drystone, in one line
        if isinstance(error, MemoryError) or "failed to map segment" in str(error):
            told = InputError(
                f"the memory was used up: {error}".removesuffix(": "),
                remedy="take fewer blocks or triangles, or a machine with more memory",
            )
            return output.fail(told, output.BAD_INPUT, as_json)
        if os.environ.get("DRYSTONE_TRACEBACK"):
            traceback.print_exc()
        return output.fail(error, output.FAULT, as_json)


def _refuse_little_memory() -> None:
    """Raise InputError where less may be taken than any check takes.

    OpenBLAS would try for ever, deaf to a request to end, or end the process without a reason.
    """
    try:  # measured: a process of 415 MiB, 26 of them taken before, checks 14 blocks; 400 may not
        mmap.mmap(-1, 384 << 20).close()
    except OSError as error:
        raise InputError(
            "384 MiB of memory are needed to begin, and this process may not take them",
            remedy="raise its limit, as with ulimit -v, or take a machine with more memory",
        ) from error


def _is_of_ctrl_c(error: BaseException | None) -> bool:
    """Whether an error is Ctrl-C, or what a library made of it, such as one that was imported."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False


def _in_our_words(error: click.UsageError) -> output.UsageFault:
    """A wrong option or argument as an InputError, from the error of the parser."""
    ctx = error.ctx
    params = [] if ctx is None else ctx.command.params
    if isinstance(error, click.NoSuchOption):
        what = f"there is no option '{error.option_name}'"
        known = [name for one in params for name in one.opts]
        return output.UsageFault(what, remedy=_meant(error.option_name, known, ctx))
    if isinstance(error, click.MissingParameter):
        return output.UsageFault(
            "is missing", where=_missing(error.param, params), remedy=kinds.see(ctx)
        )
    if isinstance(error, click.BadOptionUsage):
        flags = [name for one in params if getattr(one, "is_flag", False) for name in one.opts]
        what = "takes no value" if error.option_name in flags else "needs a value"
        return output.UsageFault(what, where=error.option_name, remedy=kinds.see(ctx))
    return output.UsageFault(error.message, remedy=kinds.see(ctx))


def _missing(param: click.Parameter | None, params: list[click.Parameter]) -> str:
    """What is missing: of several models and a last argument, either of them."""
    needed = [one for one in params if isinstance(one, click.Argument) and one.required]
    return " or ".join(map(kinds.named, needed if param in needed else [param]))


def _meant(given: str, known: Any, ctx: click.Context | None) -> str:
    if ctx is not None and ctx.command.name == "study" and given in ("--friction", "--density"):
        return f"write it as a parameter, --set {given.removeprefix('--')}=VALUE"
    close = difflib.get_close_matches(given, list(known), n=1)
    return f"did you mean '{close[0]}'? {kinds.see(ctx)}" if close else kinds.see(ctx)
