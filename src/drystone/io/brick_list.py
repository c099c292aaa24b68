"""Lists of stud-and-tube bricks: plain text with one brick a line, and JSON.

A line is ``x y z  size_x size_y  [rotation_deg]  [mass_g]``, in studs and in layers from 0 on the
ground; ``#`` begins a remark. A rotation of 90 or 270 degrees exchanges the sizes. A line of
BrickGPT is ``2x4 (x,y,z)``, sizes along x and y first. The JSON of StableLego has an object of
bricks with ``x``, ``y``, ``z``, ``ori`` and a ``brick_id``.

Source: Pun and others 2025 (BrickGPT, arXiv 2505.05469) and Liu and others 2024 (StableLego, arXiv
2402.10711), the files that they publish.
"""

from __future__ import annotations

import re
from pathlib import Path

from drystone.base.errors import FormatError
from drystone.base.files import decode, lines_of
from drystone.io.bricks import FARTHEST, TALL, Brick, draft_of, usual_mass
from drystone.io.draft import Draft
from drystone.io.jsontext import Field

_LINE = re.compile(r"(-?\d{1,9}\s+){4}-?\d{1,9}(\s+-?\d{1,9}(\s+\d{0,9}\.?\d{1,9})?)?", re.ASCII)
_SIZED = re.compile(r"(\d{1,9})x(\d{1,9}) *\((\d{1,9}), *(\d{1,9}), *(\d{1,9})\)", re.ASCII)
_BY_ID = {1: (2, 2), 2: (2, 4), 3: (2, 6), 4: (1, 8), 5: (1, 4), 6: (1, 6), 7: (1, 3),
          9: (1, 2), 10: (1, 1), 12: (2, 2), 13: (2, 8)}  # fmt: skip
"""Studs of the bricks of StableLego along x and y where ``ori`` is 0."""
_WEIGHT = 1
"""The ``brick_id`` of a weight of 200 g."""


def read(data: bytes, path: Path) -> Draft:
    """The draft of a list of bricks, with a ground plate."""
    bricks = []
    for number, line in enumerate(lines_of(decode(data, path)), start=1):
        said = line.split("#")[0].strip()
        if said:
            bricks.append(_brick(said, f"{path}, line {number}"))
    return draft_of(bricks, path)


def is_list(top: Field) -> bool:
    """Whether JSON is an object of bricks."""
    first = next(iter(top.value.values()), None) if isinstance(top.value, dict) else None
    return isinstance(first, dict) and "brick_id" in first


def from_json(top: Field) -> Draft:
    """The draft of an object of bricks, with a ground plate."""
    bricks = []
    for _, brick in top.items():
        kind = brick["brick_id"].integer()
        if kind not in _BY_ID:
            known = ", ".join(map(str, _BY_ID))
            raise brick["brick_id"].error(f"{kind} is no brick", f"known are {known}")
        size = _BY_ID[kind][:: -1 if brick["ori"].integer() else 1]
        place = [brick[axis].integer() for axis in "xyz"]
        mass = 0.2 if kind == _WEIGHT else None
        where = f"{top.file}: {brick.path}"
        bricks.append(_placed(place, size, mass, f"{place}", where))
    return draft_of(bricks, top.file)


def _brick(line: str, where: str) -> Brick:
    sized = _SIZED.fullmatch(line)
    if sized:
        size_x, size_y, *place = (int(word) for word in sized.groups())
        return _placed(place, (size_x, size_y), None, line, where)
    if not _LINE.fullmatch(line):
        raise FormatError(
            f"'{line[:40]}' is no brick",
            where=where,
            remedy="write x y z size_x size_y, then rotation in degrees and mass in g if wanted",
        )
    words = line.split()
    *place, size_x, size_y = (int(word) for word in words[:5])
    turn = int(words[5]) if len(words) > 5 else 0
    if turn % 90:
        raise FormatError(f"the rotation is {turn} degrees", where=where, remedy="give 0 or 90")
    size = (size_y, size_x) if turn % 180 else (size_x, size_y)
    mass = 1e-3 * float(words[6]) if len(words) > 6 else None
    return _placed(place, size, mass, line, where)


def _placed(
    place: list[int], size: tuple[int, ...], mass: float | None, said: str, where: str
) -> Brick:
    """A brick at studs and a layer, if it is one."""
    (x, y, z), (size_x, size_y) = place, size
    if min(size) < 1 or z < 0 or max(map(abs, (*place, *size))) > FARTHEST:
        remedy = "give sizes of one stud or more, and layers from 0"
        raise FormatError(f"'{said[:40]}' is no brick", where=where, remedy=remedy)
    mass = usual_mass(size_x, size_y) if mass is None else mass
    if not mass > 0.0:
        raise FormatError("its mass is zero", where=where, remedy="give grams above zero")
    return Brick(x, y, TALL * z, size_x, size_y, mass)
