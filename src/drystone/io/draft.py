"""The unchecked content of a file: shapes that may be open, flat or repeated.

Layers of CAD files: which are read, which hold their blocks, and notes on the others.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly
from drystone.base.display import OneLine
from drystone.base.errors import FormatError, InputError, counted
from drystone.contacts import Contacts
from drystone.detection import DetectionOptions
from drystone.loads import LoadCase
from drystone.results import Result

UP = {
    "z": np.eye(3),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
}
"""Rotations from the vertical axis of a file to z."""
Extras: TypeAlias = tuple[Contacts | None, tuple[LoadCase, ...], tuple[Result, ...]]
"""Contacts, loads and results of one assembly."""


@dataclass(frozen=True)
class DraftBlock:
    """One block of a file, unchecked.

    Attributes
    ----------
    name
    vertices : (v, 3), any nested sequence or array, in units of the file
    faces
        Loops of vertex indices.
    where
        Position in the file, for errors: a line, or a field path.
    density : [kg/m3]
    fixed
    metadata
    repairs
        Repairs made before the file was written.
    defect
        Why it is no block, where the reader knows that already.
    """

    name: str
    vertices: Any
    faces: Sequence[Sequence[int]]
    where: str = ""
    density: float = DEFAULT_DENSITY
    fixed: bool = False
    metadata: Mapping[str, Any] = field(default_factory=dict)
    repairs: tuple[str, ...] = ()
    defect: InputError | None = None


@dataclass(frozen=True)
class Draft:
    """The unchecked content of one file.

    Attributes
    ----------
    shapes
    units
        Unit of length of the shapes, if the file has one.
    finish
        Function of the finished assembly and a scale [m per unit of the file] that makes contacts,
        loads and results; ``None`` if the file has none.
    notes
        Assumptions of the reader.
    ties
        Names of the two blocks of each tie.
    ends
        Of the model; see :class:`drystone.Model`.
    detection
        Tolerances with which the contacts were searched; ``None`` where they were given.
    up
        Axis of the shapes that points up, z or y.
    """

    shapes: tuple[DraftBlock, ...]
    units: str | None = None
    finish: Callable[[Assembly, float], Extras] | None = None
    notes: tuple[str, ...] = ()
    ties: tuple[tuple[str, str], ...] = ()
    ends: str | None = None
    detection: DetectionOptions | None = None
    up: str = "z"


@dataclass(frozen=True)
class Contents(OneLine):
    """The content of a file: an assembly, and optionally contacts, load cases and results.

    Attributes
    ----------
    assembly
    contacts
        ``None`` when they have not been found yet.
    loads
    results
        Each refers to the assembly and the contacts of this model.
    notes
        Assumptions and repairs of the reader, one sentence each.
    ties
        Names of the two blocks of each tie that is not among the contacts.
    units
        Unit of length of the file; only a writer gets an assembly in it, all others one in metres.
    ends
        Of the model; see :class:`drystone.Model`.
    detection
        Tolerances with which the contacts were searched; ``None`` where they were given.
    """

    assembly: Assembly
    contacts: Contacts | None = None
    loads: tuple[LoadCase, ...] = ()
    results: tuple[Result, ...] = ()
    notes: tuple[str, ...] = ()
    ties: tuple[tuple[str, str], ...] = ()
    units: str = "m"
    ends: str | None = None
    detection: DetectionOptions | None = None


_HELD = ("support", "supports", "fixed", "ground")


def holds(layer: str) -> bool:
    """Whether the blocks of a layer are fixed, by its name without those of the layers above it."""
    return layer.rpartition("::")[2].lower() in _HELD


def hidden_notes(unread: Mapping[str, int]) -> list[str]:
    """Notes on the number of hidden objects of each layer."""
    return [
        f"{counted(count, 'hidden object')} left out on layer '{layer}'"
        for layer, count in unread.items()
    ]


def require_blocks(
    shapes: Sequence[object],
    layers: Sequence[str],
    known: Collection[str],
    unread: Mapping[str, int],
    path: Path,
) -> None:
    """Refuse a file without blocks on the layers that are read.

    Parameters
    ----------
    shapes
    layers
        Those that were asked for; all visible ones when empty.
    known
        Those of the file.
    unread
        Number of hidden objects, by layer.
    path
    """
    if not shapes and layers:
        wanted, has = (", ".join(f"'{one}'" for one in names) for names in (layers, known))
        raise FormatError(
            f"holds no block on layer {wanted}",
            where=str(path),
            remedy=f"its layers are {has or 'none'}",
        )
    if not shapes and unread:
        total = counted(sum(unread.values()), "object")
        raise FormatError(
            f"holds no visible block; {total} hidden on layers {', '.join(map(repr, unread))}",
            where=str(path),
            remedy="read them with --layer NAME or --hidden, or show them in the drawing",
        )
