"""What a small file unfolds to: parts that refer to other parts, and are placed very often."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import TypeVar

from drystone.base.errors import FormatError

Node = TypeVar("Node")

_MOST, _DEEPEST = 100_000, 64
"""Parts in all, and in each other. Chosen."""
_MOST_FACES = 1_000_000
"""Of all that a file places, with three vertices each: triangles that share none. Chosen."""


def unfold(
    roots: Iterable[Node],
    inside: Callable[[Node], Iterable[Node]],
    path: Path,
    *,
    things: str,
    name: Callable[[Node], str],
) -> Iterator[Node]:
    """Some parts and all that is in them, each before what is in it.

    Parameters
    ----------
    roots
    inside
        The parts in a part, such as those of the group that it refers to, each in its place.
    path
        The file, for errors.
    things
        What the parts are called.
    name
        Of a part, for errors.

    Raises
    ------
    FormatError
        A part is in itself, or there are too many.
    """
    waiting = [(one, 1) for one in roots][::-1]
    for _ in range(_MOST):
        if not waiting:
            return
        node, depth = waiting.pop()
        yield node
        inner = [(one, depth + 1) for one in islice(inside(node), _MOST)]
        if inner and depth == _DEEPEST:
            raise FormatError(f"{name(node)} is in itself", where=str(path))
        if len(waiting) + len(inner) >= _MOST:
            break
        waiting += inner[::-1]
    raise FormatError(
        f"has more than {_MOST:,} {things}", where=str(path), remedy="save less of it"
    )


class Unfolded:
    """Counts what a file places: a small file may place one large part very often.

    Parameters
    ----------
    path
        The file, for errors.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._vertices = self._faces = 0

    def take(self, vertices: int, faces: int) -> None:
        """Count one more part, before it is placed.

        Raises
        ------
        FormatError
            There are too many vertices or faces together.
        """
        self._vertices += vertices
        self._faces += faces
        if self._vertices > 3 * _MOST_FACES or self._faces > _MOST_FACES:
            raise FormatError(
                f"places more than {_MOST_FACES:,} faces, or as many vertices as they can have",
                where=str(self._path),
                remedy="save less of it, or thin out its meshes",
            )
