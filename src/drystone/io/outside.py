"""Files that a library of another language reads: in a separate program, with bounded time.

What a small file unfolds to: parts that refer to other parts, and are placed very often.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from drystone.base.errors import FormatError

_RUNNER = Path(__file__).with_name("extract.py")
_CPU_SHARE = 0.75
"""Of the elapsed time, processor time that may be used."""
_WALL_S_PER_MIB = 60.0
"""[s] A large file has more time, also for busy machines. Chosen."""


def content_of(
    data: bytes, path: Path, program: Path, options: Mapping[str, Any], wall_s: float = 20.0
) -> bytes:
    """What the function ``content`` of a program makes of a file.

    Parameters
    ----------
    data, path
    program
        A Python file that needs nothing of drystone.
    options
        For the function, as JSON.
    wall_s
        [s] for a file of less than 1 MiB.

    Raises
    ------
    FormatError
        It crashed, or took too long.
    """
    patience = wall_s + _WALL_S_PER_MIB * (len(data) // 2**20)
    cpu_s = str(max(1, int(_CPU_SHARE * patience)))
    try:
        done = subprocess.run(
            [sys.executable, "-P", str(_RUNNER), str(program), cpu_s, json.dumps(options)],
            input=data,
            capture_output=True,
            timeout=patience,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise FormatError(
            f"was not read within {patience:g} s: it is damaged, or the machine is very busy",
            where=str(path),
            remedy="try again; if that does not help, save it again",
        ) from error
    if done.returncode != 0:
        raise FormatError(
            "is damaged: what reads it broke off", where=str(path), remedy="save it again"
        )
    return done.stdout


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
