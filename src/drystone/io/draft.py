"""The unchecked content of a file: shapes that may be open, flat or repeated."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from drystone.assembly import DEFAULT_DENSITY, Assembly
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.contacts import Contacts
from drystone.loads import LoadCase
from drystone.results import Result

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
    """

    shapes: tuple[DraftBlock, ...]
    units: str | None = None
    finish: Callable[[Assembly, float], Extras] | None = None
    notes: tuple[str, ...] = ()
    ties: tuple[tuple[str, str], ...] = ()
    ends: str | None = None


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
    """

    assembly: Assembly
    contacts: Contacts | None = None
    loads: tuple[LoadCase, ...] = ()
    results: tuple[Result, ...] = ()
    notes: tuple[str, ...] = ()
    ties: tuple[tuple[str, str], ...] = ()
    units: str = "m"
    ends: str | None = None
