"""Several files as one model: a folder, a pattern or a list, each file with one block or more."""

from __future__ import annotations

import hashlib
import os
import re
from collections import Counter
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
from drystone.io.draft import UP, Draft, DraftBlock

Paths: TypeAlias = PathLike | list[PathLike] | tuple[PathLike, ...] | list[str] | list[Path]
"""One file, a folder, a pattern such as ``parts/*.obj``, or several of these."""

_MOST = 10_000
"""Files of one model. Chosen: above any set of stones that was scanned."""
_ODD = 30.0
"""A file whose blocks are larger or smaller by this factor than the median file is told: nearer to
the ratio of units than of stones. Chosen."""
_BESIDE = (".mtl", ".jpg", ".jpeg", ".png", ".bmp", ".tga", ".tif", ".tiff", ".gif", ".webp")
"""Suffixes of materials and pictures, which a shell puts into a list of files: ``parts/*``."""


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


def files_of(path: Paths, suffixes: Sequence[str]) -> tuple[list[Path], list[Path]]:
    """The files of a model, and those beside them that are none.

    Parameters
    ----------
    path
        One that is no folder and no pattern is taken as it is. Of several files materials and
        pictures are left out.
    suffixes
        Files of a folder, and of a pattern that has no suffix of its own, are taken if they have
        one of these, in the order of their names; numbers count by their value. Hidden files and
        folders are not.

    Raises
    ------
    FormatError
        A folder or a pattern without such a file, or too many files.
    """
    if not isinstance(path, list | tuple):
        return _files_of_one(path, suffixes)
    if not path:
        raise InputError("no file is given")
    each = [_files_of_one(one, suffixes) for one in path]
    every, left = ([file for own in each for file in own[i]] for i in (0, 1))
    taken = [file for file in every if file.suffix.lower() not in _BESIDE]
    if not taken:
        return every, left
    return taken, [*left, *(file for file in every if file not in taken)]


def _files_of_one(path: PathLike, suffixes: Sequence[str]) -> tuple[list[Path], list[Path]]:
    place = as_path(path)
    every = _listed(place)
    if every is None:
        return [place], []
    named = not place.is_dir() and place.suffix and not has_magic(place.suffix)
    taken = every if named else [one for one in every if one.suffix.lower() in suffixes]
    if not taken:
        folder = place.is_dir()
        missing = "the folder holds no model file" if folder else "no file fits the pattern"
        read = ", ".join(sorted(set(suffixes)))
        raise FormatError(missing, where=str(place), remedy=f"these are read: {read}")
    if len(taken) > _MOST:
        raise FormatError(
            f"{len(taken)} files are more than the {_MOST} of one model", where=str(place)
        )
    chosen = set(taken)
    return taken, [one for one in every if one not in chosen]


def _listed(place: Path) -> list[Path] | None:
    """The files in a folder or of a pattern, in order; ``None`` if it is neither."""
    try:
        folder, known = place.is_dir(), place.exists()
    except (OSError, ValueError):  # no name of a file: it is refused when it is read
        return None
    if folder:
        found = [one for one in place.iterdir() if not one.name.startswith(".")]
    elif has_magic(str(place)) and not known:
        root = Path(place.anchor)
        found = [*root.glob(str(place.relative_to(root)))]
    else:
        return None
    return sorted((one for one in found if one.is_file()), key=_in_order)


def _in_order(file: Path) -> list[tuple[int, str]]:
    """Key that sorts stone-2 before stone-10."""
    parts = re.split(r"(\d+)", str(file))
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


def left_notes(left: Sequence[Path]) -> list[str]:
    """A remark on files that are no models."""
    if not left:
        return []
    names = named([file.name for file in left])
    return [f"{counted(len(left), 'file')} that can hold no model left out: {names}"]


def together(drafts: Sequence[tuple[Path, Draft]], units: str | None) -> Draft:
    """One draft of the shapes of several files, with remarks on their units.

    Its lengths are in ``units`` where these are given, else in metres; z is up.

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
    shapes: list[DraftBlock] = []
    size: list[float] = []
    notes: list[str] = []
    for (file, draft), name in zip(drafts, _names([file for file, _ in drafts]), strict=True):
        if draft.finish is not None:
            raise FormatError(
                "it has contacts, loads or results, which refer to its own blocks",
                where=str(file),
                remedy="read it alone, or convert it to a mesh",
            )
        scale = 1.0 if units else scale_of(draft.units or "m")
        turn = scale * UP[draft.up].T
        own = [_placed(shape, file, name, len(draft.shapes), turn) for shape in draft.shapes]
        shapes += own
        size.append(_extent(own))
        notes += [f"{file.name}: {note}" for note in draft.notes]
        notes += [f"{file.name}: {counted(len(draft.ties), 'tie')} left out"] if draft.ties else []
    if units is None:
        notes += _units_told(drafts)
    told = units or ("m" if any(draft.units for _, draft in drafts) else None)
    return Draft(tuple(shapes), told, notes=(*notes, *_odd_sizes([f for f, _ in drafts], size)))


def _names(files: Sequence[Path]) -> list[str]:
    """A name for each file: as short as tells it from the others."""
    stems, names = Counter(file.stem for file in files), Counter(file.name for file in files)
    named = []
    for file in files:
        if files.count(file) > 1:
            raise FormatError("is given twice", where=str(file), remedy="name each file once")
        alone = names[file.name] == 1
        short = file.stem if stems[file.stem] == 1 else file.name
        named.append(short if alone else f"{file.parent.name}/{file.stem}")
    return named


def _placed(shape: DraftBlock, file: Path, name: str, of: int, turn: Floats) -> DraftBlock:
    where = f"{file.name} {shape.where}".strip()
    vertices = frozen_floats(shape.vertices, (None, 3), "vertices") @ turn
    own = name if of == 1 else f"{name}.{shape.name}"
    return replace(shape, name=own, vertices=vertices, where=where)


def _extent(shapes: Sequence[DraftBlock]) -> float:
    """The size of the median shape, its longest side along an axis [m]."""
    points = [np.asarray(shape.vertices) for shape in shapes]
    sizes = [np.ptp(one, axis=0).max(initial=0.0) if len(one) else 0.0 for one in points]
    return float(np.median(sizes))


def _units_told(drafts: Sequence[tuple[Path, Draft]]) -> list[str]:
    """A remark where some files say another unit than others, or none."""
    files: dict[str, list[str]] = {}
    for file, draft in drafts:
        files.setdefault(draft.units or "no unit, metres assumed", []).append(file.name)
    if len(files) < 2:
        return []
    told = [f"{named(names)}: {unit}" for unit, names in files.items()]
    return [f"the units of the files differ ({'; '.join(told)}): --units reads all in one"]


def _odd_sizes(files: Sequence[Path], size: Sequence[float]) -> list[str]:
    """A remark on files whose blocks are far larger or smaller than those of the others."""
    sized = [(file.name, one) for file, one in zip(files, size, strict=True) if one > 0.0]
    if len(sized) < 2:
        return []
    every = [one for _, one in sized]
    usual = float(np.median(every)) if len(sized) > 2 else min(every)
    way = {True: "larger", False: "smaller"}
    told = [
        f"{name} is {max(one / usual, usual / one):,.0f} times {way[one > usual]}"
        for name, one in sized
        if not usual <= _ODD * one <= _ODD**2 * usual
    ]
    if not told:
        return []
    than = "the median" if len(sized) > 2 else "the other file"
    return [f"{named(told)} than {than}: are the units of all files the same (--units)?"]


def digest_of(files: Sequence[Path]) -> str:
    """The SHA-256 of one file, or of those of several, in hexadecimal digits."""
    if len(files) == 1:
        return digest(files[0])
    return hashlib.sha256("".join(digest(file) for file in files).encode()).hexdigest()
