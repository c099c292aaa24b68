"""The unchecked content of a file: shapes that may be open, flat or repeated.

Layers of CAD files: which are read, which hold their blocks, and notes on the others. Formats
without blocks: a soup of faces becomes one shape per solid.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly
from drystone.base.arrays import FARTHEST, Floats, Ints
from drystone.base.display import OneLine, first_of
from drystone.base.errors import FormatError, InputError, counted
from drystone.contacts import Contacts
from drystone.detection import DetectionOptions
from drystone.geometry import coincidence
from drystone.geometry.halfedge import merge_coplanar
from drystone.geometry.polyhedron import Loop, used_vertices
from drystone.geometry.soup import split_solids, without_slivers
from drystone.geometry.surface import edge_defects
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


@dataclass(frozen=True, kw_only=True)
class Beside(OneLine):
    """What a file has beside its blocks.

    Attributes
    ----------
    notes
        Assumptions and repairs of the reader, one sentence each.
    ties
        Names of the two blocks of each tie that is not among the contacts.
    ends
        Of the model; see :class:`drystone.Model`.
    detection
        Tolerances with which the contacts were searched; ``None`` where they were given.
    """

    notes: tuple[str, ...] = ()
    ties: tuple[tuple[str, str], ...] = ()
    ends: str | None = None
    detection: DetectionOptions | None = None


@dataclass(frozen=True)
class Draft(Beside):
    """The unchecked content of one file.

    Attributes
    ----------
    shapes
    units
        Unit of length of the shapes, if the file has one.
    finish
        Function of the finished assembly and a scale [m per unit of the file] that makes contacts,
        loads and results; ``None`` if the file has none.
    up
        Axis of the shapes that points up, z or y.
    """

    shapes: tuple[DraftBlock, ...]
    units: str | None = None
    finish: Callable[[Assembly, float], Extras] | None = None
    up: str = "z"


@dataclass(frozen=True)
class Contents(Beside):
    """The content of a file: an assembly, and optionally contacts, load cases and results.

    Attributes
    ----------
    assembly
    contacts
        ``None`` when they have not been found yet.
    loads
    results
        Each refers to the assembly and the contacts of this model.
    units
        Unit of length of the file; only a writer gets an assembly in it, all others one in metres.
    """

    assembly: Assembly
    contacts: Contacts | None = None
    loads: tuple[LoadCase, ...] = ()
    results: tuple[Result, ...] = ()
    units: str = "m"


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


@dataclass(frozen=True)
class FaceSoup:
    """Faces that belong to one or more solids.

    Attributes
    ----------
    vertices : (v, 3)
    faces
    name
        Name of its solid; a number is added if there are several.
    where
        Position in the file, for errors; empty if it is the only one.
    split
        Whether to separate solids; otherwise all faces are one shape.
    """

    vertices: Floats
    faces: Sequence[Sequence[int]]
    name: str
    where: str
    split: bool = True


def shapes_of(
    soups: Sequence[FaceSoup], tolerance: float, path: Path, *, shared: bool = True
) -> tuple[list[DraftBlock], list[str]]:
    """A shape for each solid in soups of faces, and notes about repairs.

    Coincident vertices are merged, faces without area removed, solids separated, and coplanar
    neighbours merged into polygons.

    Parameters
    ----------
    soups
    tolerance
        Distance of coincident points, relative to the extent of a soup.
    path
        The file, for errors.
    shared
        Whether faces of the format share vertices. If not, there is no note about merged vertices.

    Raises
    ------
    FormatError
        A soup has no face with an area, or a vertex that is not finite.
    """
    if not soups:
        return [], []
    reach = np.array([tolerance * _extent(soup, path) for soup in soups])
    count = np.array([len(soup.vertices) for soup in soups])
    owner = np.repeat(np.arange(len(soups)), count)
    vertices = np.concatenate([soup.vertices for soup in soups])
    first = coincidence.first_coincident(vertices, reach[owner], owner).tolist()
    offset = (np.cumsum(count) - count).tolist()
    loops: list[Loop] = []
    of_loop: list[int] = []
    for number, soup in enumerate(soups):
        for face in soup.faces:
            loop = tuple(dict.fromkeys(first[i + offset[number]] for i in face))
            if len(loop) >= 3:
                loops.append(loop)
                of_loop.append(number)
    loops, kept = without_slivers(vertices, loops, reach[owner])
    home = np.array(of_loop, dtype=np.intp)[kept]
    missing = np.flatnonzero(np.bincount(home, minlength=len(soups)) == 0)
    if len(missing):
        where = _place(soups[missing[0]], path)
        raise FormatError("has no face with an area", where=where, remedy="export it again")
    solids = _per_soup(split_solids(vertices, loops, home), home, soups)
    gone = sum(len(soup.faces) for soup in soups) - len(loops)
    merged = len(vertices) - len(set(first)) if shared else 0
    return _shapes(vertices, loops, solids, soups, tolerance), _notes(merged, gone, solids)


def _place(soup: FaceSoup, path: Path) -> str:
    return f"{path}, {soup.where}" if soup.where else str(path)


def _extent(soup: FaceSoup, path: Path) -> float:
    """Diagonal of the bounding box of a soup; refuses unusable numbers."""
    usable = (np.abs(soup.vertices) <= FARTHEST).all(axis=1)
    if not usable.all():
        bad = int(np.flatnonzero(~usable)[0])
        what = "far too large" if np.isfinite(soup.vertices[bad]).all() else "not finite"
        raise FormatError(
            f"vertex {bad} is {what}", where=_place(soup, path), remedy="give finite numbers"
        )
    if len(soup.faces) == 0 or len(soup.vertices) == 0:
        raise FormatError(
            "holds no faces", where=_place(soup, path), remedy="export the blocks as meshes"
        )
    return float(np.linalg.norm(soup.vertices.max(axis=0) - soup.vertices.min(axis=0)))


def _per_soup(
    solids: list[list[int]], home: Ints, soups: Sequence[FaceSoup]
) -> list[list[list[int]]]:
    """Solids (lists of faces) of each soup."""
    grouped: list[list[list[int]]] = [[] for _ in soups]
    for solid in solids:
        grouped[int(home[solid[0]])].append(solid)
    return [
        found if soup.split else [sorted(face for solid in found for face in solid)]
        for found, soup in zip(grouped, soups, strict=True)
    ]


def _shapes(
    vertices: Floats,
    loops: Sequence[Loop],
    solids: Sequence[Sequence[Sequence[int]]],
    soups: Sequence[FaceSoup],
    tolerance: float,
) -> list[DraftBlock]:
    made: list[DraftBlock] = []
    own: list[list[Loop]] = []
    for found, soup in zip(solids, soups, strict=True):
        for number, solid in enumerate(found):
            name = soup.name if len(found) == 1 else f"{soup.name}-{number}"
            used, faces = used_vertices(loops[i] for i in solid)
            made.append(DraftBlock(name, vertices[used], faces, soup.where))
            own.append(faces)
    closed = [i for i, faces in enumerate(own) if edge_defects(faces) == ([], [], True)]
    polygons = merge_coplanar(
        [made[i].vertices for i in closed], [own[i] for i in closed], tolerance
    )
    for i, merged in zip(closed, polygons, strict=True):
        made[i] = replace(made[i], faces=merged)
    return made


def _notes(merged: int, gone: int, solids: Sequence[Sequence[Any]]) -> list[str]:
    notes = []
    if merged:
        notes.append(f"{counted(merged, 'coincident vertex', 'coincident vertices')} merged")
    if gone:
        notes.append(f"{counted(gone, 'face')} without area left out")
    several = [i for i, found in enumerate(solids) if len(found) > 1]
    if several:
        parts = sum(len(solids[i]) for i in several)
        what = "one soup of faces" if len(several) == 1 else f"{len(several)} soups of faces"
        notes.append(f"{what} split into {parts} solids")
    return notes


def in_double(values: np.ndarray[Any, Any]) -> Floats:
    """Numbers of a file as float64; NaN is found later."""
    with np.errstate(invalid="ignore"):  # a signalling NaN
        return values.astype(np.float64)


def moved(vertices: Floats, faces: Sequence[Any], matrix: Floats) -> tuple[Floats, Sequence[Any]]:
    """Vertices (v, 3) moved by a matrix (4, 4), and faces, turned round where it mirrors them.

    Overflow gives infinity or NaN; the caller refuses it with the name of the block.
    """
    with np.errstate(all="ignore"):
        placed = vertices @ matrix[:3, :3].T + matrix[:3, 3]
        mirrors = np.linalg.det(matrix[:3, :3]) < 0.0
    return placed, [face[::-1] for face in faces] if mirrors else faces


def shape_of(vertices: Floats, loops: Sequence[Loop], name: str, where: str) -> DraftBlock:
    """A shape with only the vertices that its faces use, in their order."""
    used, own = used_vertices(loops)
    return DraftBlock(name, vertices[used], own, where)


def named_apart(shapes: Sequence[DraftBlock]) -> tuple[list[DraftBlock], list[str]]:
    """Shapes with a number added to repeated names, for formats where these are usual."""
    count = Counter(shape.name for shape in shapes)
    taken = set(count)
    number: Counter[str] = Counter()
    named = []
    for shape in shapes:
        name = shape.name
        if count[name] > 1:
            while f"{name}-{number[name]}" in taken:
                number[name] += 1
            taken.add(f"{name}-{number[name]}")
            named.append(replace(shape, name=f"{name}-{number[name]}"))
        else:
            named.append(shape)
    often = [name for name, times in count.items() if times > 1]
    notes = [f"{count[name]} blocks are called '{name}': numbered" for name in often]
    return named, first_of(notes, "more names that several blocks have")
