"""A published claim beside what is found here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from drystone.base.display import OneLine
from drystone.base.table import Table

if TYPE_CHECKING:
    from drystone.results import Result
    from drystone.sequence import Plan


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

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Case(OneLine):
    """A section of the source.

    Attributes
    ----------
    section
        Number in Kao 2023 (doctoral dissertation, ETH Zurich).
    title
    lines
    pictures
        By name, results and plans of which a page and a figure can be drawn.
    """

    section: str
    title: str
    lines: tuple[Line, ...]
    pictures: Mapping[str, Result | Plan]

    @property
    def agrees(self) -> bool:
        """Whether no line disagrees with what is published."""
        return all(line.agrees is not False for line in self.lines)

    def table(self) -> Table:
        """The lines as a table."""
        agrees = {True: "yes", False: "no", None: ""}
        columns = {
            "claim": [line.what for line in self.lines],
            "published": [line.published for line in self.lines],
            "found": [line.found for line in self.lines],
            "agrees": [agrees[line.agrees] for line in self.lines],
            "note": [line.note for line in self.lines],
        }
        return Table(f"section {self.section}: {self.title}", columns)
