"""A document as plain data: title block, sections of texts, tables, pictures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import TypeAlias

from drystone.base.display import OneLine
from drystone.base.files import PathLike, as_path, read_bytes
from drystone.base.settings import Options
from drystone.base.table import Table
from drystone.io.jsontext import parse_toml


@dataclass(frozen=True)
class Heading(OneLine):
    """A heading inside a section."""

    text: str


@dataclass(frozen=True, eq=False)
class Picture(OneLine):
    """A picture as the bytes of a PNG, with its caption; ``size`` is width and height [pixels]."""

    png: bytes
    size: tuple[int, int]
    caption: str


Part: TypeAlias = str | Heading | Mapping[str, str] | Table | Picture
"""A paragraph, a heading, entries by name, a table, or a picture."""


@dataclass(frozen=True, eq=False)
class Section(OneLine):
    """A section of a document; its title has its number."""

    title: str
    parts: tuple[Part, ...]


@dataclass(frozen=True, eq=False)
class Document(OneLine):
    """A title, the entries of its title block, what stands at the foot of pages, and sections."""

    title: str
    entries: Mapping[str, str]
    foot: str
    sections: tuple[Section, ...]


@dataclass(frozen=True)
class TitleBlock(Options):
    """What stands in the title block of a report; empty entries are left out.

    Attributes
    ----------
    project
        What is assessed.
    part
        The part of it that the report is about.
    client
        For whom.
    author
        Who calculated.
    checker
        Who checks it.
    number
        Of the report.
    date
        Of the report (today).
    """

    project: str = ""
    part: str = ""
    client: str = ""
    author: str = ""
    checker: str = ""
    number: str = ""
    date: str = ""

    @classmethod
    def read(cls, path: PathLike) -> TitleBlock:
        """From the keys of a TOML file.

        Raises
        ------
        FormatError
            It is no TOML, has a key that no title block has, or a value that is no text.
        """
        top = parse_toml(read_bytes(path), as_path(path))
        top.only(tuple(one.name for one in fields(cls)))
        return cls(**{name: one.text() for name, one in top.items()})

    def over(self, other: TitleBlock) -> TitleBlock:
        """Its entries, and those of another where it has none."""
        return replace(other, **self._filled())

    def entries(self, made: str) -> Mapping[str, str]:
        """Entries by their words; ``made`` is the date where none is given."""
        told = {**self._filled(), "date": self.date or made}
        return {name.capitalize(): text for name, text in told.items()}

    def _filled(self) -> dict[str, str]:
        each = {one.name: getattr(self, one.name) for one in fields(self)}
        return {name: text for name, text in each.items() if text}
