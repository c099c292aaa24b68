"""Options with checked fields, functions with checked calls, and the keywords of long work.

Every analysis, limit, plan and settlement takes ``executor, progress, stop, time_limit_s`` as
:class:`LongWork`, and makes a :class:`Clock` of them. They never change the result of a
calculation that is not ended early.
"""

from __future__ import annotations

import enum
import functools
import inspect
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import (
    Any,
    ParamSpec,
    Self,
    TypeAlias,
    TypedDict,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np

from drystone.base.arrays import number, of_type, refuse_many
from drystone.base.display import OneLine
from drystone.base.errors import ODD, DrystoneError, InputError, counted, refuse_unknown
from drystone.base.hints import (
    beyond,
    blame,
    documented,
    hint_of,
    hints_of,
    kinds_of,
    left_out,
    refuse_wrong,
)
from drystone.base.workers import ExecutorFactory, Found, Item, WorkerPool

Progress: TypeAlias = Callable[[str, int, int], None]
"""Called as ``progress(stage, done, total)`` with 0 <= done <= total; it must not raise.
It cannot stop the work: use ``stop``."""

Stop: TypeAlias = Callable[[], bool]
"""Whether to stop. Once True, it must stay True."""

Workers: TypeAlias = Executor | ExecutorFactory
"""Where parts of a calculation run side by side."""


class LongWork(TypedDict, total=False):
    """The four keywords."""

    executor: Workers | None
    progress: Progress | None
    stop: Stop | None
    time_limit_s: float


KEYWORDS = {
    "executor": """\
Computes independent parts side by side: a ``concurrent.futures.Executor``, or a function
that starts one, such as ``drystone.sequence.LocalWorkers(4)``. The result does not depend on it.
Where every step needs the one before, there is nothing to share, and it is not used.""",
    "progress": """\
Called as ``progress(stage, done, total)``, with 0 <= done <= total.""",
    "stop": """\
Called often; True ends the calculation with the results so far.""",
    "time_limit_s": """\
Time [s] after which the calculation ends with the results so far.""",
}
"""Their documentation."""


class Stopped(Exception):
    """A search ends early: ``stop`` asked for it, or its time is over. What it found is kept."""


@dataclass(frozen=True, eq=False, kw_only=True)
class MayStop:
    """What is found by work that a time limit or its caller may end early.

    Attributes
    ----------
    stopped
        Why it ended before all was done: ``the time was up`` or ``it was interrupted``; else empty.
    time_s
        Seconds by what took them.
    """

    stopped: str = ""
    time_s: Mapping[str, float] = field(default_factory=dict)


class Clock:
    """Time since the start, the limit, and the caller's request to stop; once late, always late.

    ``progress`` is what :meth:`tell` calls, ``workers`` the executor or what starts one. Where the
    request is that of another clock, its reason is taken over.
    """

    def __init__(
        self,
        limit_s: float,
        stop: Stop | None = None,
        progress: Progress | None = None,
        workers: Workers | None = None,
    ) -> None:
        self.began = time.perf_counter()
        self.limit_s = limit_s
        self.wish = stop
        self.progress = progress
        self.workers = workers
        self.reason = ""

    @classmethod
    def of(cls, work: LongWork) -> Clock:
        """From the keywords of a function, which are taken out of them."""
        limit_s, stop = work.pop("time_limit_s", math.inf), work.pop("stop", None)
        return cls(limit_s, stop, work.pop("progress", None), work.pop("executor", None))

    @property
    def rest(self) -> LongWork:
        """The keywords of a calculation that is a part of this one."""
        return {
            "executor": self.workers,
            "progress": self.progress,
            "stop": self.wish,
            "time_limit_s": self.left_s,
        }

    def __getstate__(self) -> dict[str, Any]:
        """What travels to another process: the time that is left, not the request to stop."""
        return {"limit_s": self.left_s, "reason": self.reason}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["limit_s"])  # type: ignore[misc]
        self.reason = state["reason"]

    def tell(self, stage: str, done: int, total: int) -> None:
        """Report how far a stage is, where the caller wants to know."""
        if self.progress is not None:
            self.progress(stage, done, total)

    def shares(self, stage: str) -> Callable[[float], None]:
        """Reports a stage by the share that is done, as whole per cents that never fall."""
        most = 0

        def tell(share: float) -> None:
            nonlocal most
            most = max(most, min(int(100.0 * share), 99))
            self.tell(stage, most, 100)

        return tell

    def answers(
        self, task: Callable[[Item], Found], items: Sequence[Item], stage: str, *, least: int = 0
    ) -> Iterator[Found]:
        """The answers of a task in the order of its items, each told; so many come in any case."""
        done = 0

        def late() -> bool:
            return done >= least and self.late()

        with WorkerPool(self.workers) as pool:
            for answer in pool.answers(task, items, late):
                done += 1
                yield answer
                self.tell(stage, done, len(items))

    @property
    def elapsed_s(self) -> float:
        """[s]."""
        return time.perf_counter() - self.began

    @property
    def left_s(self) -> float:
        """[s], until the limit."""
        return max(self.limit_s - self.elapsed_s, 0.0)

    def late(self) -> bool:
        """Whether to stop now with the results so far; ``reason`` then says why."""
        if not self.reason:
            if self.wish is not None and self.wish():
                whole = getattr(self.wish, "__self__", None)
                self.reason = whole.reason if isinstance(whole, Clock) else "it was interrupted"
            elif self.elapsed_s > self.limit_s:
                self.reason = "the time was up"
        return bool(self.reason)


def with_keywords(documentation: str | None) -> str | None:
    """The documentation of a function with that of the four keywords."""
    if documentation is None:
        return None
    lines = inspect.cleandoc(documentation).splitlines()
    if "Parameters" not in lines:
        at = _section(lines, 0)
        lines[at:at] = ["Parameters", "----------", ""]
    begin = lines.index("Parameters") + 2
    at = _section(lines, begin)
    while not lines[at - 1].strip():
        at -= 1
    for name, words in reversed(KEYWORDS.items()):
        lines[at:at] = [name, *(f"    {line}" for line in words.splitlines())]
    return "\n".join(lines)


def with_parameters(signature: inspect.Signature, keywords: Any) -> inspect.Signature:
    """The signature of a function with its dictionary of keywords by their names.

    Of ``**how``, the arguments of :func:`drystone.read`, those of long work only.
    """
    *own, last = signature.parameters.values()
    named = LongWork if last.name == "how" else keywords
    more = [
        inspect.Parameter(
            name,
            last.KEYWORD_ONLY,
            default=left_out(hint),
            annotation=named.__annotations__[name].__forward_arg__,
        )
        for name, hint in get_type_hints(named).items()
    ]
    return signature.replace(parameters=[*own, *more, *([last] if last.name == "how" else [])])


def _section(lines: list[str], begin: int) -> int:
    """Where the next section of a documentation begins; its end where there is none."""
    for at in range(begin, len(lines) - 1):
        if lines[at].strip() and set(lines[at + 1]) == {"-"}:
            return at
    lines.append("")
    return len(lines)


P = ParamSpec("P")
R = TypeVar("R")
E = TypeVar("E", bound=enum.Enum)


class Options(OneLine):
    """Base of all options: a frozen dataclass that checks the types of its fields.

    Each value must be one that the annotation allows, within the range that its documentation
    says, such as ``>= 0``; a value of an enumeration becomes its member.

    Raises
    ------
    InputError
        A field is of another type or out of range, or there is none of that name; it is named.
    """

    def __post_init__(self) -> None:
        own: Any = type(self)
        hints = hints_of(own)
        for name, default in own.__dataclass_fields__.items():
            if (value := getattr(self, name, None)) is default.default or name not in hints:
                continue
            refuse_wrong([(name, value)], hints)
            if (made := _of_kind(value, hints[name])) is not value:
                object.__setattr__(self, name, made)
            _refuse_beyond(own, name, made)

    @classmethod
    def of(cls, given: Self | None) -> Self:
        """The given options; the defaults if None.

        Raises
        ------
        InputError
            It is something else.
        """
        return cls() if given is None else of_type(given, cls, "options")


def _of_kind(value: Any, hint: Any) -> Any:
    """A number, tuple or member of an enumeration as the annotation has it; others as they are."""
    kinds = kinds_of(hint) or [hint]
    kind: Any = get_origin(kinds[0]) or kinds[0]
    made = isinstance(kind, type) and issubclass(kind, int | float | tuple | enum.Enum)
    return kind(value) if made and len(kinds) == 1 and value is not None else value


def member_of(kind: type[E], value: Any, name: str) -> E:
    """The member of an enumeration, or of that value; else InputError."""
    refuse_wrong([(name, value)], {name: kind})
    return kind(value)


def checked_call(function: Callable[P, R]) -> Callable[P, R]:
    """A public function that refuses wrong arguments with a message.

    These are more arguments by position than it has, an unknown keyword, a field of its
    ``options`` that is given by itself, a value that an annotation does not allow, and a
    ``time_limit_s`` below zero. Where it ends in an error of Python, the argument that is wrong is
    named. The keywords of long calculations are added to its documentation.
    """
    known = inspect.signature(function).parameters
    most = sum(one.kind is one.POSITIONAL_OR_KEYWORD for one in known.values())
    own = {name for name, one in known.items() if one.kind is not one.VAR_KEYWORD}

    @functools.wraps(function)
    def asked(*given: P.args, **named: P.kwargs) -> R:
        if len(given) > most:
            raise InputError(
                f"{function.__name__} takes {counted(most, 'argument')} by position, "
                f"got {len(given)}",
                remedy="name all others; blocks, contacts and load together are a "
                "Model(assembly, contacts, load)",
            )
        if not named.keys() <= own:
            _refuse_unknown(function, named)
        _refuse(function, {**dict(zip(known, given, strict=False)), **named})
        limit = number(named.get("time_limit_s", 0.0), "the time limit", finite=False)
        if not limit >= 0.0:
            raise InputError(f"the time limit is {limit} s", remedy="give 0 or more")
        try:
            return function(*given, **named)
        except ODD as error:
            blame(function, given, named, error)
            raise

    many = _many(function, [*known.values()][-1])
    long = LongWork.__optional_keys__ <= getattr(many, "__optional_keys__", frozenset())
    if long or "reading" in known:
        asked.__doc__ = with_keywords(function.__doc__) if long else function.__doc__
        shown = with_parameters(inspect.signature(function), many)
        asked.__signature__ = shown  # type: ignore[attr-defined]
    return asked


def _many(function: Any, last: inspect.Parameter) -> Any:
    """The dictionary that a function takes by its last name; None where there is none."""
    if last.kind is not last.VAR_KEYWORD:
        return None
    return (get_args(hint_of(function, last)) or (None,))[0]


def hold(room: dict[str, Any]) -> list[str]:
    """Let each function that a package offers refuse values of another type, and too large ones.

    A number is finite, a count up to a million. It offers the names of ``__all__``; without that
    all that it imports by name, which is given back.
    """
    named = (
        name
        for name, one in room.items()
        if not (name.startswith("_") or inspect.ismodule(one) or one is hold)
    )
    offered = room.get("__all__") or sorted(named)
    for name in offered:
        if inspect.isfunction(room.get(name)) and not hasattr(room[name], "__wrapped__"):
            room[name] = _held(room[name])
            room[name].__module__ = room["__name__"]  # where it is found when it was sent on
    return offered


def _refuse(of: Any, asked: Mapping[str, Any]) -> None:
    """Refuse values that annotations or ranges do not allow, and counts above a million."""
    hints = hints_of(of)
    refuse_wrong(asked.items(), hints)
    for name, value in asked.items():
        if isinstance(value, int) and int in kinds_of(hints.get(name)):
            refuse_many(value, name, 1_000_000)
        _refuse_beyond(of, name, value)


def _refuse_beyond(of: Any, name: str, value: Any) -> None:
    """Refuse a number, or one of several, that is out of the range that a documentation says."""
    said = documented(of).get(name, {"ends": {}})
    for one in value if isinstance(value, tuple | list) else (value,):
        if isinstance(one, int | float | np.number) and (remedy := beyond(one, said["ends"])):
            unit = f" [{said['unit']}]" if said["unit"] not in ("", "coefficient") else ""
            raise InputError(f"{name} is {one:g}", remedy=remedy + unit)


def _held(make: Callable[..., R]) -> Callable[..., R]:
    known = inspect.signature(make).parameters
    open_ended = any(one.kind is one.VAR_KEYWORD for one in known.values())

    @functools.wraps(make)
    def held(*given: Any, **named: Any) -> R:
        hints = hints_of(make)
        if not open_ended:
            refuse_unknown(named, known, f"{make.__name__} has")
        asked = {**dict(zip(known, given, strict=False)), **named}
        _refuse(make, asked)
        for name, value in asked.items():
            if hints.get(name) is float:
                asked[name] = number(value, name)
        with np.errstate(all="ignore"):  # what overflows is refused where blocks are made
            try:
                return make(*given[len(known) :], **asked)
            except ODD as error:
                blame(make, given, named, error)
                if isinstance(error, DrystoneError) or any(map(callable, asked.values())):
                    raise
                said = f"{make.__name__} cannot take these values"
                raise InputError(said, remedy=str(error)) from error

    return held


def _place_in(options: type, name: str) -> str:
    """How options, or options among them, are given a field, or made by a name; empty where not."""
    own = options.__name__
    known = hints_of(options) if hasattr(options, "__dataclass_fields__") else {}
    if name in known:
        return f"{own}({name}=...)"
    if isinstance(vars(options).get(name), classmethod):
        return f"{own}.{name}()"
    inner = ((x, _place_in(kind, name)) for x, hint in known.items() for kind in kinds_of(hint)
             if isinstance(kind, type))  # fmt: skip
    return next((f"{own}({x}={given})" for x, given in inner if given), "")


def _refuse_unknown(function: Callable[..., Any], named: Mapping[str, Any]) -> None:
    """Refuse keywords that a function does not have, also those that belong into its options."""
    hints = hints_of(function)
    options = kinds_of(hints.get("options", object))[0]
    for name in named.keys() - hints.keys():
        given = _place_in(options, name)
        if given:
            said = f"'{name}' is no argument of {function.__name__}, but of its options"
            raise InputError(said, remedy=f"give options={given}")
    refuse_unknown(named, (*hints,), f"{function.__qualname__.removesuffix('.__init__')} has")
