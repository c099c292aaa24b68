"""States of a search: stages, their cost, and the options of the search."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

Cost: TypeAlias = tuple[int, int, int]
"""Number of propped blocks, of held blocks, and of simultaneous placements (of the blocks of a
step, all except the last). Fewer of the first count more than fewer of the next."""

NO_HELP: Cost = (0, 0, 0)


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
    cost: Cost = NO_HELP
    parent: Node | None = None

    @property
    def propped_first(self) -> bool:
        """Whether the first removed block was propped; it does not count as held then."""
        return self.parent is not None and any(self.parent.props >> b & 1 for b in self.group[:1])

    def joined(self, block: int) -> Node:
        """The node with one more block removed together with the others."""
        props, held, together = self.cost
        first = len(self.group) == 1 and not self.propped_first
        cost = props, held + 1 + first, together + 1
        return replace(
            self, placed=self.placed & ~(1 << block), group=(*self.group, block), cost=cost
        )

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
