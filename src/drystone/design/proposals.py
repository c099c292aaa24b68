"""Changes that are proposed for a region, tried one after the other on its bench."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from drystone.design.bench import Bench, Held, Tried
from drystone.design.changes import Change
from drystone.design.needs import Needs


class Take(enum.Enum):
    """Which of some changes that hold a region are told."""

    EACH = enum.auto()
    FIRST = enum.auto()
    SMALLEST = enum.auto()


@dataclass(frozen=True, eq=False)
class Tries:
    """Changes of one kind that are tried, and what is said if none of them holds the region.

    Attributes
    ----------
    changes
    why
        Empty where nothing is said.
    take
    known
        The least values that the diagnosis found without a margin, ``None`` where it found none;
        where left out it did not look for them. Searches that begin there save a tenth of the time
        of all mends.
    last
        Whether they are tried only where none before them holds it.
    told
        Makes the change that is said from the one that holds it.
    """

    changes: Sequence[Change]
    why: str
    take: Take = Take.EACH
    known: Sequence[float | None] | None = None
    last: bool = False
    told: Callable[[Change], Held] | None = None


@dataclass(frozen=True, eq=False)
class KnownNeeds:
    """What the changes of a region are proposed from.

    Attributes
    ----------
    bench
    needs
        What the diagnosis found that would hold it, without a margin.
    known
        Whether that is of the same local model: not where supports have moved.
    """

    bench: Bench
    needs: Needs
    known: bool


Proposals: TypeAlias = Iterator[Tries | Tried | str]
"""Changes to try, and why others are not tried."""


def held_by(kind: str, proposals: Proposals, asked: KnownNeeds) -> Iterator[Held]:
    """The changes of a kind that hold a region, with their least values; else it is noted why."""
    bench, holds = asked.bench, False
    for tries in proposals:
        if isinstance(tries, Tried):
            bench.tried.append(tries)
        elif isinstance(tries, str):
            bench.fail(kind, tries)
        elif not (tries.last and holds):
            found = _held(bench, tries, asked.known)
            holds = holds or bool(found)
            yield from found
            if not found and tries.why:
                bench.fail(kind, tries.why, *(one.make(one.steps[-1]) for one in tries.changes))


def _held(bench: Bench, tries: Tries, known: bool) -> list[Held]:
    """Those of some changes that hold a region."""
    changes = list(tries.changes)
    if known and tries.known is not None:
        pairs = zip(changes, tries.known, strict=True)
        changes = [change.above(value) for change, value in pairs if value is not None]
    if tries.take is Take.SMALLEST:
        best = bench.smallest(changes)
        return [] if best is None else [best]
    found: list[Held] = []
    for change in changes:
        value = bench.least(change)
        if value is not None:
            found.append((change, value) if tries.told is None else tries.told(change))
            if tries.take is Take.FIRST:
                break
    return found
