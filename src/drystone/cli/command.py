"""Commands with options in groups. Each option is declared once, with its help."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import click

from drystone.base.errors import counted
from drystone.cli import kinds
from drystone.cli.output import UsageFault
from drystone.cli.told import Printed, Told, finish
from drystone.cli.waiting import Waiting

_GROUPS = ("Model", "Loads", "Contacts", "Analysis", "Output")
"""Groups of options, in the order of the help."""
MODEL, LOADS, CONTACTS, ANALYSIS, OUTPUT = _GROUPS
_WIDTH = 100
"""Largest width of the help [characters]."""
SETTINGS: dict[str, Any] = {"help_option_names": ["-h", "--help"], "max_content_width": _WIDTH}
"""Of every command."""
_KINDS = {float: kinds.number(), int: kinds.whole(), str: kinds.TEXT}


@dataclass(frozen=True)
class Option:
    """The help of an option; the parameter has its type and default.

    Attributes
    ----------
    help
    group
    flags
        Its names; when left out, that of the parameter.
    kind
        Kind of its value, where the type does not say it.
    metavar
        Placeholder of the value in the help.
    expert
        Shown by ``--help-all`` only.
    """

    help: str
    group: str = ANALYSIS
    flags: tuple[str, ...] = ()
    kind: kinds.OptionKind | None = None
    metavar: str | None = None
    expert: bool = False


@dataclass(frozen=True)
class Experts:
    """Marks a dataclass of options whose options are shown by ``--help-all`` only, but for some."""

    but: tuple[str, ...] = ()


@dataclass(frozen=True)
class Argument:
    """The help of an argument."""

    metavar: str
    help: str
    kind: kinds.OptionKind = kinds.TEXT


class _GroupedOption(click.Option):
    """An option that knows its group, and whether it is for experts."""

    def __init__(self, *names: Any, group: str = OUTPUT, expert: bool = False, **more: Any) -> None:
        super().__init__(*names, **more)
        self.group = group
        self.expert = expert


class Command(click.Command):
    """A command whose help shows options in groups, and examples."""

    examples: tuple[str, ...] = ()

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse options and arguments; refuse unknown ones."""
        try:
            rest = super().parse_args(ctx, args)
        except click.UsageError as error:  # some errors do not name the command
            error.ctx = error.ctx or ctx
            raise
        if ctx.args and not ctx.resilient_parsing:
            what = f"'{ctx.args[0]}' is one argument too many"
            several = "for several files give their folder, or a pattern in quotes; "
            remedy = f"{several if Path(ctx.args[0]).is_file() else ''}{kinds.see(ctx)}"
            raise UsageFault(what, remedy=remedy)
        return rest

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Arguments, then each group of options."""
        arguments = [
            (kinds.named(one), one.told) for one in self.params if isinstance(one, _Argument)
        ]
        if arguments:
            with formatter.section("Arguments"):
                formatter.write_dl(arguments)
        everything = ctx.meta.get("drystone.everything", False)
        hidden = 0
        for group in _GROUPS:
            rows = []
            for one in self.get_params(ctx):
                if getattr(one, "group", OUTPUT) != group or isinstance(one, click.Argument):
                    continue
                if isinstance(one, _GroupedOption) and one.expert and not everything:
                    hidden += 1
                    continue
                rows += [row for row in [one.get_help_record(ctx)] if row is not None]
            if rows:
                with formatter.section(group):
                    formatter.write_dl(rows)
        if hidden:
            formatter.write_paragraph()
            formatter.write(f"{counted(hidden, 'more option')}: {ctx.command_path} --help-all\n")

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """The examples, a line each."""
        write_examples(self.examples, formatter)


class _Argument(click.Argument):
    """An argument with help."""

    def __init__(self, names: list[str], told: str, **more: Any) -> None:
        super().__init__(names, **more)
        self.told = told

    def get_usage_pieces(self, ctx: click.Context) -> list[str]:
        """Its name, in brackets where it can be left out."""
        return super().get_usage_pieces(ctx) if self.required else [f"[{self.metavar}]"]


def write_examples(examples: tuple[str, ...], formatter: click.HelpFormatter) -> None:
    """A section with a line for each example."""
    with formatter.section("Examples"):
        for example in examples:
            formatter.write(f"{' ' * formatter.current_indent}{example}\n")


def command(*examples: str, name: str = "") -> Callable[[Callable[..., Printed | Told]], Command]:
    """Make a command of a function that returns an answer.

    Each parameter is an argument or an option; its annotation has an :class:`Argument` or an
    :class:`Option`. A parameter whose type is a dataclass gives an option per field. A parameter
    ``waiting`` gets the :class:`Waiting` of the command. ``--json`` and, where there are expert
    options, ``--help-all`` are added.
    """

    def make(function: Callable[..., Printed | Told]) -> Command:
        params: list[click.Parameter] = []
        groups: dict[str, type[Any]] = {}
        hints = get_type_hints(function, include_extras=True)
        for one in inspect.signature(function).parameters.values():
            hint = hints[one.name]
            if hint is Waiting:
                continue
            kind, *marks = get_args(hint) if get_origin(hint) is Annotated else (hint,)
            if is_dataclass(kind) and isinstance(kind, type):
                groups[one.name] = kind
                inner = get_type_hints(kind, include_extras=True)
                made_of = [
                    _param(each.name, inner[each.name], each.default) for each in fields(kind)
                ]
                for param in made_of:
                    hides = any(isinstance(mark, Experts) and param.name not in mark.but
                                for mark in marks)  # fmt: skip
                    if hides and isinstance(param, _GroupedOption):
                        param.expert = True
                params += made_of
            else:
                default = MISSING if one.default is one.empty else one.default
                params.append(_param(one.name, hint, default))
        made = Command(
            name or function.__name__,
            callback=_runner(function, groups),
            params=[*params, *_common(params)],
            help=inspect.getdoc(function),
            short_help=(inspect.getdoc(function) or "").partition("\n")[0].rstrip("."),
            context_settings={**SETTINGS, "allow_extra_args": True},
        )
        made.examples = examples
        return made

    return make


def _runner(
    function: Callable[..., Printed | Told], groups: dict[str, type[Any]]
) -> Callable[..., int]:
    def run(as_json: bool, **given: Any) -> int:
        made = {
            name: kind(**{each.name: given.pop(each.name) for each in fields(kind)})
            for name, kind in groups.items()
        }
        with Waiting() as waiting:
            answer = function(**made, **given, waiting=waiting)
            told = finish(answer, waiting, as_json)
        return told()

    return run


def _common(params: list[click.Parameter]) -> list[click.Parameter]:
    more: list[click.Parameter] = [
        _GroupedOption(
            ["--json", "as_json"], is_flag=True, help="Print one JSON object and nothing else."
        )
    ]
    if any(isinstance(one, _GroupedOption) and one.expert for one in params):
        more.append(
            _GroupedOption(
                ["--help-all"],
                is_flag=True,
                is_eager=True,
                expose_value=False,
                callback=_help_all,
                help="Show all options and exit.",
            )
        )
    return more


def _help_all(ctx: click.Context, _: click.Parameter, asked: bool) -> None:
    if asked:
        ctx.meta["drystone.everything"] = True
        click.echo(ctx.get_help())
        ctx.exit()


def _param(name: str, hint: Any, default: Any) -> click.Parameter:
    """The argument or option of a parameter."""
    plain, told = get_args(hint)[:2]
    left_out = {"required": True} if default is MISSING else {"required": False, "default": default}
    if isinstance(told, Argument):
        return _Argument([name], told.help, metavar=told.metavar, type=told.kind, **left_out)
    several = get_origin(plain) is tuple
    base = next(part for part in (*get_args(plain), plain) if part is not type(None))
    flags = told.flags or (f"--{name.replace('_', '-')}",)
    names = [*flags, name]
    if base is bool:
        return _GroupedOption(
            names, group=told.group, expert=told.expert, help=told.help, is_flag=True, default=False
        )
    return _GroupedOption(
        names,
        group=told.group,
        expert=told.expert,
        help=told.help,
        type=told.kind or _KINDS.get(base, kinds.TEXT),
        metavar=told.metavar,
        multiple=several,
        **({} if several else left_out),
    )
