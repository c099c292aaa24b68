"""States of a search: stages, their cost, and the options of the search."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

Cost: TypeAlias = tuple[int, int]
"""Number of props, and of blocks placed together with another one."""


@dataclass(frozen=True, eq=False)
class Node:
    """A stage in the search.

    Attributes
    ----------
    placed, props
        Sets of blocks as bits; props are a subset of the placed blocks.
    group
        Blocks removed since the last stage that stands, in the order of removal.
    cost
    parent
        The last stage that stands.
    """

    placed: int
    props: int
    group: tuple[int, ...] = ()
    cost: Cost = (0, 0)
    parent: Node | None = None

    def path(self) -> list[Node]:
        """The stages from the complete structure to this one."""
        out: list[Node] = [self]
        while out[-1].parent is not None:
            out.append(out[-1].parent)
        return out[::-1]


@dataclass(frozen=True)
class SearchOptions:
    """Effort of the search.

    Attributes
    ----------
    patience
        Checks without progress before the best state is continued with held blocks or props.
        Infinite: never; the result is proved to be optimal.
    width
        Number of blocks tried for removal from one stage, the first ones in the order.
    tries
        Number of these that a forced removal compares. Of the props that it adds, twice as many are
        tested for need.
    """

    patience: float = float("inf")
    width: int = 2**30
    tries: int = 4


@dataclass(frozen=True, eq=False)
class FoundOrder:
    """Result of a search.

    Attributes
    ----------
    path
        Stages that stand, from the complete structure to the core.
    proved
        Whether no path with a lower cost exists.
    """

    path: list[Node]
    proved: bool


__all__ = ["Cost", "FoundOrder", "Node", "SearchOptions"]
