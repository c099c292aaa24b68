"""A document as plain data: title block, sections of texts, tables, pictures, plans of joints."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import NAME, OneLine, name_text, shortened
from drystone.base.files import PathLike, as_path, read_bytes
from drystone.base.settings import Options
from drystone.base.table import Table
from drystone.geometry.kern import kern
from drystone.io.jsontext import parse_toml
from drystone.results import Result
from drystone.virtual import local_corners

_SIDE = 150
"""[px] of a plan."""


@dataclass(frozen=True, eq=False)
class JointPlan(OneLine):
    """The plan of a joint, seen against its normal.

    Attributes
    ----------
    joint
        Its number.
    blocks
        Names of both blocks.
    corners, kern : (c, 2), (d, 2) [m], along u and v
    pressed : (2,) [m]
        Centre of pressure.
    axes
        Where u and v point, in words.
    """

    joint: int
    blocks: tuple[str, str]
    corners: Floats
    kern: Floats
    pressed: Floats
    axes: str

    @property
    def width(self) -> float:
        """[m], the larger of both extents."""
        return float(np.ptp(self.corners, axis=0).max())

    def on(self, points: Floats, side: float, margin: float) -> Floats:
        """Points (p, 2) [m] on a square of a side, with a margin, from its lower left corner."""
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        scale = (side - 2.0 * margin) / self.width if self.width > 0.0 else 1.0
        return 0.5 * side + scale * (points - 0.5 * (low + high))


def joint_plan(result: Result, table: Table, i: int) -> JointPlan:
    """The plan of a row of the joint table of a result."""
    contacts = result.contacts.joints
    origin, flat = local_corners(contacts)
    corners = flat[contacts.start[i] : contacts.start[i + 1]]
    position = np.array([table[axis][i] for axis in "xyz"])
    at = contacts.frame[i, 1:] @ (position - origin[i])
    names = (str(table["block_a"][i]), str(table["block_b"][i]))
    right, up = map(_direction, contacts.frame[i, 1:])
    return JointPlan(i, names, corners, kern(corners), at, f"right: {right}, up: {up}")


def _direction(unit: Floats) -> str:
    """A direction (3,) as an axis of the model with its sign, or its parts."""
    axis = int(np.abs(unit).argmax())
    if abs(unit[axis]) > 0.995:
        return f"{'-' if unit[axis] < 0.0 else '+'}{'xyz'[axis]}"
    return "(" + ", ".join(f"{part + 0.0:.2g}" for part in unit.round(2)) + ")"


def plan_figure(plan: JointPlan) -> str:
    """The joint, its kern and its centre of pressure as a small SVG, u to the right, v up."""

    def pixels(points: Floats) -> Floats:
        return np.array([0.0, _SIDE]) + plan.on(points, _SIDE, 12.0) * np.array([1.0, -1.0])

    def path(points: Floats) -> str:
        return " ".join(f"{x:.1f},{y:.1f}" for x, y in pixels(points))

    x, y = pixels(plan.pressed)
    between = " – ".join(shortened(name, NAME) for name in plan.blocks)
    label = html.escape(f"joint {plan.joint}: {between}")
    return (
        f'<figure><svg viewBox="0 0 {_SIDE} {_SIDE}" width="{_SIDE}" height="{_SIDE}" role="img" '
        f'aria-label="{label}"><polygon class="stone" points="{path(plan.corners)}"/>'
        f'<polygon class="kern" points="{path(plan.kern)}"/>'
        f'<circle class="force" cx="{x:.1f}" cy="{y:.1f}" r="5"/></svg>'
        f"<figcaption>joint {plan.joint}: {' – '.join(map(name_text, plan.blocks))}"
        f"<br>{plan.width:.3g} m wide, {plan.axes}</figcaption></figure>"
    )


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


Part: TypeAlias = str | Heading | Mapping[str, str] | Table | Picture | tuple[JointPlan, ...]
"""A paragraph, a heading, entries by name, a table, a picture, or plans of joints."""


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
