"""A published claim beside what is found here."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

from drystone.answer import Answer, Question, Role, Scene, Sentence
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.table import Table
from drystone.model import Model

if TYPE_CHECKING:
    from drystone.programs import Forces
    from drystone.results import Result
    from drystone.sequence import Plan

    Picture: TypeAlias = Result | Plan | Forces


_ALONE = "there is no figure to hold it against"
ASSUMED = "its dimensions are not published: the shape is ours"


@dataclass(frozen=True)
class Line(OneLine):
    """One claim.

    Attributes
    ----------
    what
        The model and what is asked of it.
    published
        As in the source; empty where the source gives no figure.
    found
    agrees
        Whether they agree to the accuracy of the published figure; None where nothing is published
        that could be compared.
    note
        Why they differ, or what was assumed.
    """

    what: str
    published: str
    found: str
    agrees: bool | None
    note: str = ""

    @classmethod
    def same(cls, what: str, published: str, found: str, note: str = "") -> Line:
        """A claim that agrees where both say the same."""
        return cls(what, published, found, published == found, note)

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Case(Answer):
    """A section of the source.

    Attributes
    ----------
    section
        Number in Kao 2023 (doctoral dissertation, ETH Zurich).
    name
        What it is about.
    lines
    pictures
        By name, results, plans and forces of which a page and a figure can be drawn.
    """

    section: str
    name: str
    lines: tuple[Line, ...]
    pictures: Mapping[str, Picture]

    @property
    def agrees(self) -> bool:
        """Whether no line disagrees with what is published."""
        return all(line.agrees is not False for line in self.lines)

    @property
    def _first(self) -> Picture:
        if not self.pictures:
            raise InputError(f"there is no picture of section {self.section}")
        return next(iter(self.pictures.values()))

    @property
    def model(self) -> Model:
        """That of the first picture.

        Raises
        ------
        InputError
            There is none.
        """
        first = self._first
        return first.model if isinstance(first.model, Model) else first.model.model

    @cached_property
    def asked(self) -> Question:
        """The section."""
        return Question.of_nothing(made=self.when)

    @property
    def title(self) -> str:
        """Number and name of the section."""
        return f"section {self.section}: {self.name}"

    def sentences(self) -> Sequence[Sentence]:
        """How many of its figures agree, why others are not compared, and what is to be said."""
        notes: dict[str, list[str]] = {}
        for line in self.lines:
            if line.agrees is None or line.note:
                head = "not compared: " if line.agrees is None else ""
                notes.setdefault(line.note or _ALONE, []).append(head + line.what)
        said = [Sentence(f"{'; '.join(of)}: {note}", Role.REMARK) for note, of in notes.items()]
        return [Sentence(agreement([self]), Role.GOOD if self.agrees else Role.BAD), *said]

    def tables(self) -> Sequence[Table]:
        """The lines as a table, and one of those that have a figure by each method."""
        split = {line: by for line in self.lines if (by := _by_method(line))}
        plain = {
            line: {"published": line.published, "found": line.found}
            for line in self.lines
            if line not in split
        }
        tilts = f"{self.title}, tilts [degrees] as published, and here"
        made = _table(self.title, plain), _table(tilts, split)
        return [one for one in made if len(one)]

    def layers(self) -> Scene:
        """The first picture."""
        return self._first.layers()

    def numbers(self) -> Mapping[str, Any]:
        """The lines."""
        return {
            "section": self.section,
            "name": self.name,
            "agrees": self.agrees,
            "lines": [line.to_dict() for line in self.lines],
        }


_METHOD = re.compile(r"(.+?) \((\w+)\)(?:, |$)")


def _by_method(line: Line) -> dict[str, str]:
    """What was published and found by each method; empty where a text has another form."""
    published, found = line.published, line.found
    if not published or _METHOD.sub("", published + found):
        return {}
    here = found.removeprefix("stands to ").replace(", falls from ", " to ")
    both = {name: value for value, name in _METHOD.findall(published)}
    return both | {f"{name}_here": value for value, name in _METHOD.findall(here)}


def _table(title: str, each: Mapping[Line, Mapping[str, str]]) -> Table:
    names = dict.fromkeys(name for by in each.values() for name in by)
    agrees = {True: "yes", False: "no", None: "not compared"}
    columns = {name: [by.get(name, "") for by in each.values()] for name in names}
    claim = [line.what.removesuffix(": tilt") for line in each]
    return Table(title, {"claim": claim, **columns, "agrees": [agrees[x.agrees] for x in each]})


def agreement(cases: Sequence[Case]) -> str:
    """How many figures of some sections agree, which sections differ, and how many have no other.

    Examples
    --------
    >>> lines = Line("mass", "2 kg", "2 kg", True), Line("height", "", "1 m", None)
    >>> agreement([Case("1", "a block", lines, {})])
    '1 of 1 figure agrees, 1 not compared'
    """
    every = [line.agrees for case in cases for line in case.lines]
    alone = every.count(None)
    compared, same = len(every) - alone, every.count(True)
    if not compared:
        return "no published figure can be compared"
    told = f"{same} of {counted(compared, 'figure')} {'agree' if compared > 1 else 'agrees'}"
    wrong = [case.section for case in cases if not case.agrees]
    told += f"; {', '.join(wrong)} differs" if wrong else ""
    return f"{told}, {alone} not compared" if alone else told
