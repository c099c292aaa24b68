"""Charts beside a picture: curves and marks as plain data."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine


class MarkKind(enum.Enum):
    """How the points of marks are drawn."""

    LINE = "line"
    DASHED = "dashed"
    AREA = "area"
    """Filled, from the values down to ``low``, or inside a ring."""
    DISC = "disc"
    RING = "ring"
    CROSS = "cross"
    DIAMOND = "diamond"


@dataclass(frozen=True, eq=False)
class Marks(OneLine):
    """Points, or a line through them.

    Attributes
    ----------
    kind
    x, y : (p,)
    ink
        ``accent``, ``good``, ``bad``, ``unsure`` or ``ink``.
    label
        For the legend; none where it is empty.
    low : (p,)
        The lower edge of an area.
    """

    kind: MarkKind
    x: Floats
    y: Floats
    ink: str = "accent"
    label: str = ""
    low: Floats | None = None


@dataclass(frozen=True, eq=False)
class Chart(OneLine):
    """A chart with one pair of axes.

    Attributes
    ----------
    title
    marks
    across, up
        What the axes are.
    units
        Of both; empty where there is none.
    caption
    lines
        Values across that are marked, with their texts.
    polar
        x are directions [degrees] from the axis to the right, y the distances from the middle.
    top
        End of the axis up; that of the marks when left out.
    """

    title: str
    marks: tuple[Marks, ...] = ()
    across: str = ""
    up: str = ""
    units: tuple[str, str] = ("", "")
    caption: str = ""
    lines: tuple[tuple[float, str], ...] = ()
    polar: bool = False
    top: float | None = None


@dataclass(frozen=True, eq=False)
class HeatMap(OneLine):
    """Values by two parameters, as cells.

    Attributes
    ----------
    title
    across, up
        What the axes are.
    columns, rows
        Values of the parameters, in words, from left to right and from below.
    values : (r, c)
        NaN where there is none.
    quantity
        What the values are, with its unit.
    """

    title: str
    across: str
    up: str
    columns: tuple[str, ...]
    rows: tuple[str, ...]
    values: Floats
    quantity: str


def ring(azimuth: Floats, values: Floats, closed: bool = True) -> tuple[Floats, Floats]:
    """The points of a polar line, back to the first one where it is closed."""
    order = np.arange(len(azimuth) + closed) % max(len(azimuth), 1)
    return azimuth[order], values[order]
