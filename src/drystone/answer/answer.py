"""The base of all answers: title, sentences, tables, layers, numbers, and what was asked."""

from __future__ import annotations

import dataclasses
import datetime as dt
import enum
import html
import math
import time
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NoReturn, Self

import numpy as np

from drystone.answer.chart import Chart
from drystone.answer.question import Question
from drystone.answer.scene import Scene
from drystone.answer.sentences import Role, Sentence
from drystone.base.display import OneLine, picture_of
from drystone.base.errors import InputError
from drystone.base.settings import MayStop
from drystone.base.table import Table
from drystone.model import OfModel

if TYPE_CHECKING:
    import pandas


class Answer(MayStop, OfModel, OneLine, ABC):
    """What an analysis answers. It says five things of itself, and keeps what was asked.

    A new kind of answer implements :attr:`title`, :meth:`sentences`, :meth:`tables`,
    :meth:`layers` and :meth:`numbers`. The command line, the JSON, pages, figures, CAD files, the
    live page, notebooks and the tools for programs show these and know no analysis.

    Attributes
    ----------
    made : [s]
        Time at which it was made, since 1970.
    options
        With which it was computed; ``None`` where there are none.
    """

    made: float
    options: Any = None

    def __new__(cls, *given: Any, **named: Any) -> Self:
        """A new answer, which knows when it was made; a copy keeps that."""
        answer = super().__new__(cls, *given, **named)
        object.__setattr__(answer, "made", time.time())
        return answer

    @property
    @abstractmethod
    def title(self) -> str:
        """The answer in a few words."""

    @abstractmethod
    def sentences(self) -> Sequence[Sentence]:
        """The answer in sentences; the first one is the verdict."""

    def tables(self) -> Sequence[Table]:
        """Blocks, joints, steps or values; each table has its own title."""
        return ()

    def table(self) -> Table:
        """What a file with one table has: the first one, unless another says more.

        Raises
        ------
        InputError
            There is none.
        """
        for one in self.tables():
            return one
        raise InputError("this answer has no table", remedy="ask for --json")

    def to_pandas(self) -> pandas.DataFrame:
        """That table as a data frame."""
        return self.table().to_pandas()

    @abstractmethod
    def layers(self) -> Scene:
        """What is drawn.

        Raises
        ------
        InputError
            There is no picture.
        """

    @abstractmethod
    def numbers(self) -> Mapping[str, Any]:
        """The answer as plain values in SI units, but for what the tables hold."""

    @property
    def news(self) -> Role:
        """Its news, by which reports list it: that of the first sentence, unless it holds worse."""
        return self.sentences()[0].role

    @property
    def code(self) -> int:
        """The exit code of a command: 0 where the first sentence is good news, else 1."""
        return 0 if self.sentences()[0].role is Role.GOOD else 1

    def _summary(self) -> str:
        return f"'{self.title}'"

    @cached_property
    def asked(self) -> Question:
        """What was asked: the model, where it came from, its loads, options, version and date."""
        return Question.of(self.model, self.options, self.when)

    @property
    def when(self) -> str:
        """Date and time at which it was made."""
        return dt.datetime.fromtimestamp(self.made).astimezone().strftime("%Y-%m-%d %H:%M")

    def _unfinished(self, more: str = "") -> list[Sentence]:
        """That work ended before all was done, if it did; ``more`` follows the reason."""
        said = Sentence(f"not finished: {self.stopped}{more}", Role.REMARK)
        return [said] if self.stopped else []

    def figure(self) -> Scene | Chart:
        """What is drawn on paper: the same, unless something else says more."""
        return self.layers()

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON: title, numbers, rows of each table, what was asked, the time."""
        tables = self.tables()
        return {
            "title": self.title,
            "sentences": [one.text for one in self.sentences()],
            **plain(self.numbers()),
            "stopped": self.stopped,
            "time_s": dict(self.time_s),
            **{one.key: plain(list(one)) for one in tables},
            "units": {one.key: dict(one.units) for one in tables if one.units},
            "asked": self.asked.to_dict(),
        }

    def _repr_html_(self) -> str:
        told = "".join(f"<div>{html.escape(one.text)}</div>" for one in self.sentences())
        tables = "".join(one._repr_html_() for one in self.tables())
        return (
            '<div style="display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start">'
            '<div style="max-width:min(32em,100%);overflow:auto;overflow-wrap:anywhere">'
            f"<b>{html.escape(self.title)}</b>{told}{tables}"
            f'<div style="opacity:.7">{html.escape(self.asked.line())}</div></div>'
            f"{picture_of(self)}</div>"
        )


class WithoutModel(Answer):
    """An answer that is about no model, or about several."""

    @property
    def model(self) -> NoReturn:
        """Refuse: it has none."""
        raise InputError("has no model", where=self.title, remedy="ask what it is about")

    def layers(self) -> NoReturn:
        """Refuse: it has no picture."""
        raise InputError("has no picture", where=self.title, remedy="draw what it is about")

    @cached_property
    def asked(self) -> Question:
        """The version and the date."""
        return Question.of_nothing(self.options, self.when)


@dataclass(frozen=True, eq=False)
class Statement(WithoutModel):
    """Sentences, tables and values, without a model and without a picture.

    Attributes
    ----------
    told
        The first one is the verdict.
    listed
    values
    """

    told: tuple[Sentence, ...]
    listed: tuple[Table, ...] = ()
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """The first sentence."""
        return self.told[0].text

    def sentences(self) -> Sequence[Sentence]:
        """Those that it was made of."""
        return self.told

    def tables(self) -> Sequence[Table]:
        """Those that it was made of."""
        return self.listed

    def numbers(self) -> Mapping[str, Any]:
        """The values that it was made of."""
        return self.values


def worst_first(answers: Iterable[Answer]) -> list[Answer]:
    """Answers with bad news before what is not decided, and good news last.

    Parameters
    ----------
    answers
        In any order; equally good ones keep theirs.
    """
    order = (Role.BAD, Role.UNSURE)
    return sorted(answers, key=lambda one: (*order, one.news).index(one.news))


def plain(value: Any) -> Any:
    """The same with values that JSON knows; numbers that are not finite become ``None``.

    Parameters
    ----------
    value
        A number, text, array, enumeration or dataclass, or lists and dictionaries of these;
        anything else becomes its text.

    Examples
    --------
    >>> from drystone.answer import Verdict
    >>> plain({"a": np.ones(2), "b": Verdict.STABLE, "c": float("nan")})
    {'a': [1.0, 1.0], 'b': 'stable', 'c': None}
    """
    if isinstance(value, enum.Enum):
        return value.value
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {one.name: plain(getattr(value, one.name)) for one in dataclasses.fields(value)}
    return value if isinstance(value, bool | int | str) or value is None else str(value)
