"""What a command offers: arguments, options in groups, and those declared beside analyses.

Options that several commands share.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, is_dataclass, replace
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, get_args, get_origin

import click

from drystone.cli import kinds
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.base.declared import Declared

GROUPS = ("Model", "Loads", "Contacts", "Analysis", "Output")
"""Groups of options, in the order of the help."""
MODEL, LOADS, CONTACTS, ANALYSIS, OUTPUT = GROUPS
_KINDS = {float: kinds.NUMBER, int: kinds.WHOLE, str: kinds.TEXT}


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


def writes(help: str, *suffixes: str, flags: tuple[str, ...] = (), expert: bool = False) -> Option:
    """The option of a file that is written, with one of these suffixes."""
    return Option(help, OUTPUT, flags, kinds.target(*suffixes), expert=expert)


@dataclass(frozen=True)
class Analysis:
    """An analysis, and the options that were given for it.

    Attributes
    ----------
    analysis
    given
        Its keywords.
    time_limit : [s]
    workers
    """

    analysis: Callable[..., Any]
    given: Mapping[str, Any]
    time_limit: float | None
    workers: int | str

    def instead(self, analysis: Callable[..., Any], **more: Any) -> Analysis:
        """The same of another analysis, with more keywords."""
        return replace(self, analysis=analysis, given={**self.given, **more})

    def of(self, waiting: Waiting, *subject: Any, doing: str = "searching", **more: Any) -> Any:
        """What it answers about a model, or about other things that it takes by position."""
        waiting.stage("solve", doing)
        takes = inspect.signature(self.analysis).parameters
        with waiting.keywords(self.time_limit, self.workers) as common:
            late = {name: value for name, value in common.items() if name in takes}
            return self.analysis(*subject, **self.given, **more, **late)


WORKERS = "Processes that work side by side (1), or the address of a Dask scheduler, tcp://..."
"""The help of --workers."""
_METAVARS = {
    "axis": "AXIS|X,Y,Z",
    "direction": "AXIS|X,Y,Z",
    "keep": "BLOCKS",
    "margin": "WHAT",
    "virtual": "WHAT[@BLOCKS]",
}
"""Placeholders of values, by the name of the option."""
_LATE = {"time_limit_s": "--time-limit", "executor": "--workers"}
"""Keywords of everything that takes long, by name, which are options too."""


@dataclass(frozen=True)
class Of:
    """Options that are declared beside an analysis.

    Attributes
    ----------
    place
        A class of options, whose instance the command gets; or an analysis, with which it gets an
        :class:`Analysis`. The keywords of an analysis and the fields of its ``options`` are
        options. Or its module and name, and it is imported when the command is asked for.
    names
        Those that are offered, such as ``plan.rules.hands``; all when left out.
    without
        Those that are not.
    shown
        Those that ``--help`` shows; the others are shown by ``--help-all``.
    flags
        Names on the command line, where they are not the last part of the name.
    metavars
        Placeholders of values in the help, where they are others than usual.
    group, groups
        Of the options in the help, and names in other groups.
    """

    place: str | Callable[..., Any]
    names: Sequence[str] | None = None
    without: tuple[str, ...] = ()
    shown: tuple[str, ...] = ()
    flags: Mapping[str, str] = field(default_factory=dict)
    metavars: Mapping[str, str] = field(default_factory=dict)
    group: str = ANALYSIS
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @cached_property
    def target(self) -> Callable[..., Any]:
        """The class or the analysis."""
        if not isinstance(self.place, str):
            return self.place
        module, _, name = self.place.rpartition(".")
        return getattr(import_module(module), name)

    def _declared(self) -> dict[str, Declared]:
        """The options by name."""
        from drystone.base.declared import declared_at, options_of  # it starts without numpy

        left_out = {*self.without}
        names = options_of(self.target) if self.names is None else self.names
        names = [one for one in names if not left_out & {one, one.partition(".")[0]}]
        return {name: declared_at(self.target, name) for name in names}

    def _flag(self, name: str) -> str:
        return self.flags.get(name) or _LATE.get(name) or f"--{_last(name).replace('_', '-')}"

    def params(self, before: str) -> list[click.Parameter]:
        """The options of the command line; their names begin with that of the parameter."""
        found: list[click.Parameter] = []
        for name, one in self._declared().items():
            more: dict[str, Any] = {"default": None}
            text, flag = one.told(), self._flag(name)
            if bool in one.kinds:
                more |= {"is_flag": True}
                if one.default is True:
                    flag, text = (
                        f"--no-{flag.removeprefix('--')}",
                        f"Without: {text[0].lower()}{text[1:]}",
                    )
            elif name == "executor":
                more["type"], text = kinds.WORKERS, WORKERS
            elif name == "time_limit_s":
                more["type"] = kinds.POSITIVE
            else:
                more |= {"type": kinds.of(one), "multiple": one.several}
                more["metavar"] = self.metavars.get(name) or _METAVARS.get(_last(name))
            found.append(
                GroupedOption(
                    [*flag.split(), _key(before, name)],
                    group=next(
                        (one for one in self.groups if name in self.groups[one]), self.group
                    ),
                    expert=name not in self.shown,
                    help=text,
                    about=_last(name),
                    **more,
                )
            )
        return found

    def made(self, given: Mapping[str, Any], before: str) -> Any:
        """The options, or the analysis with them, from the values of the command line."""
        from drystone.base.declared import made_of, nested  # as above

        values: dict[str, Any] = {}
        for name, one in self._declared().items():
            value = given[_key(before, name)]
            if not (value is None or value is False or value == ()):  # 0 is a value
                values[name] = one.default is not True if value is True else value
                if one.several:  # one word alone is not the same as a list of one
                    alone = len(value) == 1 and str in one.kinds
                    values[name] = one.value(value[0] if alone else value)
        if is_dataclass(self.target):
            return made_of(self.target, values)
        limit, workers = values.pop("time_limit_s", None), values.pop("executor", 1)
        return Analysis(self.target, nested(self.target, values), limit, workers)


def _key(before: str, name: str) -> str:
    return f"{before}_{name.replace('.', '_')}"


def _last(name: str) -> str:
    return name.rpartition(".")[2]


@dataclass(frozen=True)
class Part:
    """A parameter of the function of a command, and what it is made of on the command line."""

    name: str
    params: list[click.Parameter]
    made: Callable[[dict[str, Any]], Any]


@dataclass(frozen=True)
class Argument:
    """The help of an argument."""

    metavar: str
    help: str
    kind: kinds.OptionKind = kinds.TEXT
    several: bool = False


class GroupedOption(click.Option):
    """An option that knows its group, whether it is for experts, and what it was declared as."""

    def __init__(
        self, *names: Any, group: str = OUTPUT, expert: bool = False, about: str = "", **more: Any
    ) -> None:
        super().__init__(*names, **more)
        self.about = about
        self.group = group
        self.expert = expert


class HelpedArgument(click.Argument):
    """An argument with help."""

    def __init__(self, names: list[str], told: str, **more: Any) -> None:
        super().__init__(names, **more)
        self.told = told

    def get_usage_pieces(self, ctx: click.Context) -> list[str]:
        """Its name, in brackets where it can be left out."""
        return super().get_usage_pieces(ctx) if self.required else [f"[{self.metavar}]"]


def param_of(name: str, hint: Any, default: Any) -> click.Parameter:
    """The argument or option of a parameter."""
    plain, told = get_args(hint)[:2]
    left_out = {"required": True} if default is MISSING else {"required": False, "default": default}
    if isinstance(told, Argument):
        count = {"nargs": -1, "required": True} if told.several else left_out
        return HelpedArgument([name], told.help, metavar=told.metavar, type=told.kind, **count)
    several = get_origin(plain) is tuple
    base = next(part for part in (*get_args(plain), plain) if part is not type(None))
    flags = told.flags or (f"--{name.replace('_', '-')}",)
    names = [*flags, name]
    more = {"type": told.kind or _KINDS.get(base, kinds.TEXT), "metavar": told.metavar,
            "multiple": several, **({} if several else left_out)}  # fmt: skip
    if base is bool:
        more = {"is_flag": True, "default": False}
    return GroupedOption(names, group=told.group, expert=told.expert, help=told.help, **more)


Friction: TypeAlias = Annotated[
    float | None,
    Option(
        "Friction coefficient, or angle such as 31deg, of all joints (the file's, else 0.6).",
        MODEL,
        kind=kinds.COEFFICIENT,
    ),
]

Html: TypeAlias = Annotated[
    Path | None,
    writes("Write a page that shows the answer in a browser.", ".html", ".htm"),
]

Png: TypeAlias = Annotated[
    Path | None,
    writes("Write a figure, .png, .svg or .pdf.", ".png", ".svg", ".pdf"),
]

Section: TypeAlias = Annotated[
    str | None,
    Option(
        "Cut the pictures across an axis: x through the middle, x=1.2 at a coordinate in metres. "
        "What lies before the cut is not drawn.",
        OUTPUT,
        kind=kinds.SECTION,
        expert=True,
    ),
]

_CAD = writes("Write the answer for CAD programs, .3dm or .glb.", ".3dm", ".glb")
Cad: TypeAlias = Annotated[Path | None, _CAD]
RareCad: TypeAlias = Annotated[Path | None, replace(_CAD, expert=True)]

Csv: TypeAlias = Annotated[
    Path | None,
    writes("Write the table of the answer, .csv.", ".csv", expert=True),
]

_REPORT = writes("Write a calculation report on the answer, .pdf or .html.", ".pdf", ".html")
Report: TypeAlias = Annotated[Path | None, _REPORT]
RareReport: TypeAlias = Annotated[Path | None, replace(_REPORT, expert=True)]

_TITLES = Option("TOML file with the entries of the title block.", OUTPUT, kind=kinds.FILE)
TitleBlock: TypeAlias = Annotated[Path | None, _TITLES]
RareTitleBlock: TypeAlias = Annotated[Path | None, replace(_TITLES, expert=True)]

TimeLimit: TypeAlias = Annotated[
    float | None,
    Option(
        "Seconds after which the search stops with what is known so far.",
        kind=kinds.POSITIVE,
        expert=True,
    ),
]

Workers: TypeAlias = Annotated[int | str, Option(WORKERS, kind=kinds.WORKERS, expert=True)]
