"""A document as plain data: sections of texts, entries, tables, pictures and plans of joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from drystone.base.display import OneLine
from drystone.base.table import Table
from drystone.view.joint_page import JointPlan


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

    def _summary(self) -> str:
        return f"'{self.caption}', {self.size[0]} x {self.size[1]}"


Part: TypeAlias = str | Heading | Mapping[str, str] | Table | Picture | tuple[JointPlan, ...]
"""A paragraph, a heading, entries by name, a table, a picture, or plans of joints."""


@dataclass(frozen=True, eq=False)
class Section(OneLine):
    """A section of a document; its title has its number."""

    title: str
    parts: tuple[Part, ...]

    def _summary(self) -> str:
        return f"'{self.title}', {len(self.parts)} parts"


@dataclass(frozen=True, eq=False)
class Document(OneLine):
    """A title, the entries of its title block, what stands at the foot of pages, and sections."""

    title: str
    entries: Mapping[str, str]
    foot: str
    sections: tuple[Section, ...]

    def _summary(self) -> str:
        return f"'{self.title}', {len(self.sections)} sections"
