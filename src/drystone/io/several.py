"""Several files as one model: a folder, a pattern or a list, each file with one block or more."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Sequence
from dataclasses import replace
from glob import has_magic
from pathlib import Path
from typing import TypeAlias, TypeGuard

import numpy as np

from drystone.base.arrays import Floats, frozen_floats
from drystone.base.display import named
from drystone.base.errors import FormatError, InputError, counted
from drystone.base.files import PathLike, as_path, digest
from drystone.base.units import scale_of
from drystone.io.draft import Draft, DraftBlock

Paths: TypeAlias = PathLike | list[PathLike] | tuple[PathLike, ...] | list[str] | list[Path]
"""One file, a folder, a pattern such as ``parts/*.obj``, or several of these."""

_MOST = 10_000
"""Files of one model. Chosen: above any set of stones that was scanned."""
_ODD = 30.0
"""A file whose blocks are larger or smaller by this factor than the median file is told: nearer to
the ratio of units than of stones. Chosen."""
_NAMED = 4


def is_paths(given: object) -> TypeGuard[Paths]:
    """Whether a value names a file, or is a list of such values."""
    if isinstance(given, list | tuple):
        return bool(given) and all(isinstance(one, str | os.PathLike) for one in given)
    return isinstance(given, str | os.PathLike)


def place_of(path: Paths) -> Path:
    """What to call the model in errors: the file, the folder or the pattern."""
    if not isinstance(path, list | tuple):
        return as_path(path)
    every = [os.fspath(one) for one in path]
    return Path(every[0]) if len(every) == 1 else Path(f"{len(every)} files")


def files_of(path: Paths, suffixes: Sequence[str]) -> tuple[Path, ...]:
    """The files of a model; one that is no folder and no pattern is returned as it is.

    Parameters
    ----------
    path
    suffixes
        Files of a folder that have one of these are taken, in the order of their names; numbers
        count by their value. Hidden files and folders in it are not.

    Raises
    ------
    FormatError
        A folder or a pattern without such a file, or too many files.
    """
    if isinstance(path, list | tuple):
        if not path:
            raise InputError("no file is given")
        return tuple(file for one in path for file in files_of(one, suffixes))
    place = as_path(path)
    try:
        folder, known = place.is_dir(), place.exists()
    except (OSError, ValueError):  # no name of a file: it is refused when it is read
        return (place,)
    if folder:
        inside = [one for one in place.iterdir() if not one.name.startswith(".")]
        found = [one for one in inside if one.suffix.lower() in suffixes and one.is_file()]
        missing = "the folder holds no model file"
    elif has_magic(str(place)) and not known:
        root = Path(place.anchor)
        found = [one for one in root.glob(str(place.relative_to(root))) if one.is_file()]
        missing = "no file fits the pattern"
    else:
        return (place,)
    if not found:
        read = ", ".join(sorted(set(suffixes)))
        raise FormatError(missing, where=str(place), remedy=f"these are read: {read}")
    if len(found) > _MOST:
        raise FormatError(
            f"{len(found)} files are more than the {_MOST} of one model", where=str(place)
        )
    return tuple(sorted(found, key=_in_order))


def _in_order(file: Path) -> list[tuple[int, str]]:
    """Key that sorts stone-2 before stone-10."""
    parts = re.split(r"(\d+)", str(file))
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


def together(drafts: Sequence[tuple[Path, Draft]], units: str | None) -> Draft:
    """One draft of the shapes of several files, in metres, with remarks on their units.

    A block has the name of its file; where a file has several, a dot and its own name follow.

    Parameters
    ----------
    drafts
        Each file and its draft.
    units
        Of all files; each file's own, else metres, when left out.

    Raises
    ------
    FormatError
        A file has contacts, loads or results.
    """
    stems = [file.stem for file, _ in drafts]
    names = [file.name for file, _ in drafts]
    for file, _ in drafts:
        if sum(file == other for other, _ in drafts) > 1:
            raise FormatError("is given twice", where=str(file), remedy="name each file once")
    shapes: list[DraftBlock] = []
    size: list[float] = []
    notes: list[str] = []
    for (file, draft), stem in zip(drafts, stems, strict=True):
        if draft.finish is not None:
            raise FormatError(
                "it has contacts, loads or results, which refer to its own blocks",
                where=str(file),
                remedy="read it alone, or convert it to a mesh",
            )
        name = stem if stems.count(stem) == 1 else file.name
        name = name if names.count(file.name) == 1 else f"{file.parent.name}/{stem}"
        scale = scale_of(units or draft.units or "m")
        own = [_placed(shape, file, name, len(draft.shapes), scale) for shape in draft.shapes]
        shapes += own
        size.append(float(np.median([_extent(shape) for shape in own])))
        notes += [f"{file.name}: {note}" for note in draft.notes]
    if units is None:
        notes += _units_told(drafts)
    return Draft(tuple(shapes), "m", notes=(*notes, *_odd_sizes([f for f, _ in drafts], size)))


def _placed(shape: DraftBlock, file: Path, name: str, of: int, scale: float) -> DraftBlock:
    where = f"{file.name} {shape.where}".strip()
    vertices = scale * frozen_floats(shape.vertices, (None, 3), "vertices")
    own = name if of == 1 else f"{name}.{shape.name}"
    return replace(shape, name=own, vertices=vertices, where=where)


def _extent(shape: DraftBlock) -> float:
    points: Floats = np.asarray(shape.vertices)
    return float(np.ptp(points, axis=0).max(initial=0.0)) if len(points) else 0.0


def _units_told(drafts: Sequence[tuple[Path, Draft]]) -> list[str]:
    """A remark where some files say another unit than others, or none."""
    files: dict[str, list[str]] = {}
    for file, draft in drafts:
        files.setdefault(draft.units or "no unit, metres assumed", []).append(file.name)
    if len(files) < 2:
        return []
    told = [f"{named(names, _NAMED)}: {unit}" for unit, names in files.items()]
    return [f"the units of the files differ ({'; '.join(told)}): --units reads all in one"]


def _odd_sizes(files: Sequence[Path], size: Sequence[float]) -> list[str]:
    """A remark on files whose blocks are far larger or smaller than those of the others."""
    usual = float(np.median(size))
    odd = [
        file.name
        for file, one in zip(files, size, strict=True)
        if one > _ODD * usual or one * _ODD < usual
    ]
    if not odd or len(files) < 3:
        return []
    verb = "is" if len(odd) == 1 else "are"
    what = counted(len(odd), "file")
    return [
        f"{what} ({named(odd, _NAMED)}) {verb} {_ODD:g} times larger or smaller than the median:"
        " are the units of all files the same?"
    ]


def digest_of(files: Sequence[Path]) -> str:
    """The SHA-256 of one file, or of those of several, in hexadecimal digits."""
    if len(files) == 1:
        return digest(files[0])
    return hashlib.sha256("".join(digest(file) for file in files).encode()).hexdigest()
