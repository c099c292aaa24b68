"""What a search goes through: stages on the way down, their cost, and how hard to look."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

Cost: TypeAlias = tuple[int, int]
"""Props, and blocks placed together with another one."""


@dataclass(frozen=True, eq=False)
class Node:
    """A stage on the way.

    Attributes
    ----------
    placed, props
        Bits; props are always among the placed blocks.
    group
        Blocks that left since the last stage that stood, in the order in which they leave.
    cost
    parent
        That stage.
    """

    placed: int
    props: int
    group: tuple[int, ...] = ()
    cost: Cost = (0, 0)
    parent: Node | None = None

    def path(self) -> list[Node]:
        """From the complete structure to here."""
        out: list[Node] = [self]
        while out[-1].parent is not None:
            out.append(out[-1].parent)
        return out[::-1]


@dataclass(frozen=True)
class SearchOptions:
    """How hard to search.

    Attributes
    ----------
    patience
        Checks without getting further down before the best state so far is forced on with held
        blocks or props. Infinite: never, the answer is proved to be the best.
    width
        Blocks that are tried for removal from one stage, the first ones in the order.
    tries
        Of these, how many a forced move compares; and twice as many props that it adds are tried
        to be done without.
    """

    patience: float = float("inf")
    width: int = 2**30
    tries: int = 4


@dataclass(frozen=True, eq=False)
class Found:
    """What a search ended with.

    Attributes
    ----------
    path
        Stages that stand, from the complete one to the core.
    proved
        Whether no cheaper one exists.
    """

    path: list[Node]
    proved: bool


__all__ = ["Cost", "Found", "Node", "SearchOptions"]
