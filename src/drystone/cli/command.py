"""Commands with options in groups. Each option is declared once, with its help.

Commands that are made of analyses: the model, what else must be given, options and files.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cached_property, partial
from importlib import import_module
from operator import itemgetter
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin, get_type_hints

import click

from drystone.base.errors import InputError, counted
from drystone.cli import kinds
from drystone.cli.model_input import OneFile, Subject
from drystone.cli.offered import (
    GROUPS,
    OUTPUT,
    Analysis,
    Argument,
    GroupedOption,
    HelpedArgument,
    Of,
    Part,
    param_of,
)
from drystone.cli.output import UsageFault
from drystone.cli.told import Pictures, Told, WithLoaded, WithModel, Written, finish
from drystone.cli.waiting import UNDER_WAY, Waiting

if TYPE_CHECKING:
    from drystone.base.declared import Declared, Offered


_WIDTH = 100
"""Largest width of the help [characters]."""
SETTINGS: dict[str, Any] = {"help_option_names": ["-h", "--help"], "max_content_width": _WIDTH}
"""Of every command."""


class Command(click.Command):
    """A command whose help shows options in groups, and examples.

    Its options are made when they are first needed: some are declared beside analyses, which are
    not imported before.
    """

    function: Callable[..., Told | None]
    examples: tuple[str, ...] = ()

    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        del self.params

    @cached_property
    def parts(self) -> list[Part]:
        """What the parameters of its function are made of."""
        return parts_of(_known(self.function))

    @cached_property
    def params(self) -> list[click.Parameter]:  # type: ignore[override]  # a list that is set
        """Its arguments and options."""
        params = [param for part in self.parts for param in part.params]
        return [*params, *_common(params)]

    def invoke(self, ctx: click.Context) -> int:
        """Call its function, print the answer; the exit code."""
        return _run(self.function, self.parts, dict(ctx.params))

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse options and arguments; refuse unknown ones, and one value in place of another."""
        try:
            self._refuse_twice(ctx, args)
            rest = super().parse_args(ctx, args)
        except click.UsageError as error:  # some errors do not name the command
            error.ctx = error.ctx or ctx
            raise
        if ctx.args and not ctx.resilient_parsing:
            what = f"'{ctx.args[0]}' is one argument too many"
            raise UsageFault(what, remedy=kinds.see(ctx))
        return rest

    def _refuse_twice(self, ctx: click.Context, args: list[str]) -> None:
        order = self.make_parser(ctx).parse_args(args=list(args))[2]
        values = [one for one in order if isinstance(one, click.Option) and not one.is_flag]
        for one in values:
            if not one.multiple and not ctx.resilient_parsing and values.count(one) > 1:
                raise UsageFault(f"{one.opts[-1]} is given twice", remedy="give it once")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Arguments, then each group of options."""
        arguments = [
            (kinds.named(one), one.told) for one in self.params if isinstance(one, HelpedArgument)
        ]
        if arguments:
            with formatter.section("Arguments"):
                formatter.write_dl(arguments)
        everything = ctx.meta.get("drystone.everything", False)
        hidden = 0
        for group in GROUPS:
            rows = []
            for one in self.get_params(ctx):
                if getattr(one, "group", OUTPUT) != group or isinstance(one, click.Argument):
                    continue
                if isinstance(one, GroupedOption) and one.expert and not everything:
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


def write_examples(examples: tuple[str, ...], formatter: click.HelpFormatter) -> None:
    """A section with a line for each example."""
    with formatter.section("Examples"):
        for example in examples:
            formatter.write(f"{' ' * formatter.current_indent}{example}\n")


def command(*examples: str, name: str = "") -> Callable[[Callable[..., Told | None]], Command]:
    """Make a command of a function that returns an answer.

    Each parameter is an argument or an option; its annotation has an :class:`Argument` or an
    :class:`Option`. A parameter whose type is a dataclass gives an option per field, one with
    :class:`Of` the options that are declared beside an analysis. A parameter ``waiting`` gets the
    :class:`Waiting` of the command. ``--json`` and ``--help-all`` are added.
    """

    def make(function: Callable[..., Told | None]) -> Command:
        made = Command(
            name or function.__name__,
            help=inspect.getdoc(function),
            short_help=(inspect.getdoc(function) or "").partition("\n")[0].rstrip("."),
            context_settings={**SETTINGS, "allow_extra_args": True},
        )
        made.function, made.examples = function, examples
        return made

    return make


def _hints(of: Any, module: str) -> dict[str, Any]:
    """Types of parameters or fields; what a module imports for its types only may be anything."""
    names = dict(vars(sys.modules[module]))
    while True:
        try:
            return get_type_hints(of, localns=names, include_extras=True)
        except NameError as error:
            names[str(error.name)] = Any


def _known(function: Callable[..., Any]) -> dict[str, tuple[Any, Any]]:
    """Type and default of each parameter of a function, or each field of a class."""
    hints = _hints(function, function.__module__)
    if is_dataclass(function):
        return {one.name: (hints[one.name], one.default) for one in fields(function)}
    every = inspect.signature(function).parameters.values()
    return {
        one.name: (hints[one.name], MISSING if one.default is one.empty else one.default)
        for one in every
    }


def parts_of(known: Mapping[str, tuple[Any, Any]]) -> list[Part]:
    """What parameters of these types and defaults are made of."""
    parts = []
    for name, (hint, default) in known.items():
        if hint is Waiting:
            continue
        kind, *marks = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        of = next((one for one in marks if isinstance(one, Of)), None)
        if of is not None:
            parts.append(Part(name, of.params(name), partial(of.made, before=name)))
        elif is_dataclass(kind) and isinstance(kind, type):
            inner = parts_of(_known(kind))
            params = [param for part in inner for param in part.params]
            parts.append(Part(name, params, partial(_instance, kind, inner)))
        else:
            param = param_of(name, hint, default)
            parts.append(Part(name, [param], itemgetter(name)))
    return parts


def _instance(kind: type[Any], inner: list[Part], given: dict[str, Any]) -> Any:
    return kind(**{part.name: part.made(given) for part in inner})


def _run(function: Callable[..., Told | None], parts: list[Part], given: dict[str, Any]) -> int:
    as_json = given.pop("as_json")
    try:
        made = {part.name: part.made(given) for part in parts}
        with UNDER_WAY.get() or Waiting() as waiting:
            waiting.asks = not as_json
            if "waiting" in inspect.signature(function).parameters:
                made["waiting"] = waiting
            answer = function(**made)
            if answer is None:  # a server that has ended
                return 0
            told = finish(answer, waiting, as_json)
    except InputError as error:
        raise error.located(_flag_of(error, parts) or error.where) from error
    return told()


def _flag_of(error: InputError, parts: list[Part]) -> str:
    """The option that an error of the library is about: it names a keyword, or a field."""
    name = error.where or error.what.partition(" ")[0]
    for part in parts:
        for one in part.params:
            if name and name in (one.name, getattr(one, "about", "")):
                return kinds.named(one)
    return ""


def _common(params: list[click.Parameter]) -> list[click.Parameter]:
    more: list[click.Parameter] = [
        GroupedOption(
            ["--json", "as_json"], is_flag=True, help="Print one JSON object and nothing else."
        )
    ]
    experts = any(isinstance(one, GroupedOption) and one.expert for one in params)
    return [*more, help_all(hidden=not experts)]


def help_all(*, hidden: bool = True) -> GroupedOption:
    """The option ``--help-all``; where it shows no more than ``--help`` it is taken, and hidden."""
    return GroupedOption(
        ["--help-all"], is_flag=True, is_eager=True, expose_value=False, callback=_help_all,
        help="Show all options and exit.", hidden=hidden,
    )  # fmt: skip


def _help_all(ctx: click.Context, _: click.Parameter, asked: bool) -> None:
    if asked:
        ctx.meta["drystone.everything"] = True
        click.echo(ctx.get_help())
        ctx.exit()


_FILES: Mapping[str, type[Pictures]] = {"joints": Written, "model": WithModel, "train": WithLoaded}
"""The files of answers, by what they can write beside pictures."""


class AnalysisCommand(Command):
    """The command of an analysis of a model.

    Parameters
    ----------
    name
        With the words before it, such as ``limit tilt``.
    offered
        Or the module that has it as ``OFFERED``, and what it answers, for a list of commands.
    """

    def __init__(self, name: str, offered: Offered | tuple[str, str]) -> None:
        short = offered[1] if isinstance(offered, tuple) else offered.text.partition("\n")[0]
        super().__init__(
            name.rpartition(" ")[2], short_help=short.rstrip("."),
            context_settings={**SETTINGS, "allow_extra_args": True},
        )  # fmt: skip
        del self.help
        self.words, self.place = name, offered
        self.function = self._answer

    @cached_property
    def offered(self) -> Offered:
        """The analysis; it is imported when the command is asked for."""
        if not isinstance(self.place, tuple):
            return self.place
        return import_module(self.place[0]).OFFERED

    @cached_property
    def help(self) -> str:  # type: ignore[override]  # a text that is set
        """What it answers."""
        codes = "Exit code 0: it stands, or what was looked for is found. 1: not. 2: bad input."
        return f"{self.offered.text}\n\n{codes}"

    @cached_property
    def examples(self) -> tuple[str, str]:  # type: ignore[override]  # as above
        """Two of its uses."""
        example = f"drystone {self.words} {self.offered.example}"
        return example, f"{example} --html {self.name}.html"

    @cached_property
    def parts(self) -> list[Part]:
        """What the parameters of its function are made of."""
        offered, arguments = self.offered, self.arguments
        free = all(name in offered.arguments for name in arguments)
        of = Of(offered.analysis, offered.options, without=tuple(arguments), shown=offered.shown)
        known: dict[str, tuple[Any, Any]] = {"subject": (Subject if free else OneFile, MISSING)}
        for name, one in arguments.items():
            default = MISSING if name in offered.arguments else None
            known[name] = Annotated[str | None, _argument(one)], default
        known["asked"] = Annotated[Analysis, of], MISSING
        known["wanted"] = _FILES.get(offered.writes, Pictures), MISSING
        return parts_of(known)

    @cached_property
    def arguments(self) -> dict[str, Declared]:
        """What is given by position: what must be given, and loads."""
        from drystone.base.declared import declared  # the program starts without numpy

        known = declared(self.offered.analysis)
        loads = {name: one for name, one in known.items() if _is_load(one)}
        return {**loads, **self.offered.arguments}

    def _answer(
        self, subject: Subject, asked: Analysis, wanted: Pictures, waiting: Waiting, **more: Any
    ) -> Told:
        model = subject.prepared(waiting)
        wanted.require_through(model.assembly)
        notes = list(model.notes)
        more = {name: text for name, text in more.items() if text is not None}
        under: list[str] = []
        for name, text in more.items():
            if _is_load(self.arguments[name]):
                under += _option_of(text)
                more[name] = subject.case_of(text, model)
                notes += more[name].notes
        found = asked.of(waiting, model, **more)
        notes += [one for one in found.asked.notes if one not in notes]
        short = under and found.news.value != "good"  # the load is not carried as it was given
        then = subject.command("mend", *under) if short else ""
        return Told(found, notes=notes, files=partial(wanted.of, found), then=then)


def _option_of(text: str) -> list[str]:
    """The option that puts a load in words on the model; nothing for a case of its file."""
    kind, colon, rest = text.partition(":")
    return ["--seismic", rest] if kind == "seismic" else ["--load", text] if colon else []


def _is_load(one: Declared) -> bool:
    from drystone.loads import LoadCase  # as above

    return LoadCase in one.kinds


def _argument(one: Declared) -> Argument:
    return Argument("CASE" if _is_load(one) else one.name.upper(), one.told())
