"""LDraw models, ``.ldr`` and ``.mpd``: standard bricks and plates, by the numbers of their parts.

Source: LDraw.org, File Format 1.0.2 and MPD Language Extension. The unit is 0.4 mm and y points
down. The origin of a part is in the middle of its top, its longer side lies along x. A brick is 20
units wide for each stud and 24 high, a plate is 8 high. Models of one file may use each other.
Colours, steps and drawn lines have no meaning here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import FormatError
from drystone.base.files import decode, lines_of
from drystone.io.bricks import FARTHEST, TALL, Brick, draft_of, usual_mass
from drystone.io.draft import Draft
from drystone.io.outside import unfold

_GRID = np.array([20.0, 20.0, 8.0])
"""Distance of studs twice, and height of a plate, in units of LDraw."""
_PITCH = 8e-3
"""[m] Distance of studs."""
_UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Rotation from y down to z up."""
_BRICKS = {
    3005: (1, 1), 3004: (2, 1), 3622: (3, 1), 3010: (4, 1), 3009: (6, 1), 3008: (8, 1),
    6111: (10, 1), 6112: (12, 1), 2465: (16, 1), 3003: (2, 2), 3002: (3, 2), 3001: (4, 2),
    2456: (6, 2), 3007: (8, 2), 3006: (10, 2), 2356: (6, 4), 6212: (10, 4), 4202: (12, 4),
    30400: (18, 4), 4201: (8, 8), 4204: (16, 8), 733: (10, 10),
}  # fmt: skip
_PLATES = {
    3024: (1, 1), 3023: (2, 1), 3623: (3, 1), 3710: (4, 1), 3666: (6, 1), 3460: (8, 1),
    4477: (10, 1), 60479: (12, 1), 3022: (2, 2), 3021: (3, 2), 3020: (4, 2), 3795: (6, 2),
    3034: (8, 2), 3832: (10, 2), 2445: (12, 2), 91988: (14, 2), 4282: (16, 2), 3031: (4, 4),
    3032: (6, 4), 3035: (8, 4), 3030: (10, 4), 3029: (12, 4), 3958: (6, 6), 3036: (8, 6),
    3033: (10, 6), 3028: (12, 6), 3456: (14, 6), 3027: (16, 6), 3026: (24, 6), 41539: (8, 8),
    728: (11, 8), 92438: (16, 8),
}  # fmt: skip
"""Studs along and across the parts that the LDraw library calls "Brick" or "Plate" and two sizes.
Source: its titles, as the parts list of LeoCAD repeats them."""
_PART = re.compile(r"(\d{1,7})[a-z]?(p[0-9a-z]*)?\.dat", re.ASCII)
"""Number, letter of a mould and number of a printed pattern."""
_NUMBER = re.compile(r"[-+]?(\d{1,9}(\.\d{0,17})?|\.\d{1,17})(e[-+]?\d{1,2})?", re.ASCII | re.I)
_OFF = 0.02
"""Studs or plates that a part may lie off the grid. Chosen: files round to thousandths."""
_FARTHEST = 1e7
"""Largest number of a matrix, chosen: 4 km."""
_Placed: TypeAlias = tuple[str, Floats, str]
"""Name of a part or a model, its matrix (4, 4), and its line."""


def read(data: bytes, path: Path) -> Draft:
    """The draft of the bricks of a file, with a ground plate below the lowest."""
    models = _models(decode(data, path), path)
    first = next((name for name, parts in models.items() if name or parts), "")
    placed = [*_placed(models, first, path)]  # too many are refused before any is looked at
    parts = [_part(*part) for part in placed]
    if not parts:
        raise FormatError("holds no brick", where=str(path), remedy="save parts, not only lines")
    corner = np.array([low for low, _ in parts])
    grid = corner - corner.min(axis=0)
    off = np.abs(grid - np.rint(grid)).max(axis=1)
    if off.max() > _OFF or grid.max() > FARTHEST:
        raise FormatError(
            f"part {int(np.argmax(off)) + 1} does not lie on the grid of studs of the others",
            where=str(path),
            remedy="place it on studs: half studs, hinges and the like are not read",
        )
    bricks = [
        Brick(round(x), round(y), round(z), along, across, usual_mass(along, across, tall), tall)
        for (x, y, z), (_, (along, across, tall)) in zip(grid.tolist(), parts, strict=True)
    ]
    return draft_of(bricks, path, _PITCH)


def _models(text: str, path: Path) -> dict[str, list[_Placed]]:
    """The parts in each model of a file: the name of each, its matrix (4, 4), and its line."""
    models: dict[str, list[_Placed]] = {}
    parts = models.setdefault("", [])
    for number, line in enumerate(lines_of(text), start=1):
        words = line.split()
        where = f"{path}, line {number}"
        if words[:2] == ["0", "FILE"]:
            parts = models.setdefault(" ".join(words[2:]).lower(), [])
        elif words[:2] == ["0", "NOFILE"]:
            parts = []
        elif words[:1] == ["1"]:
            if len(words) < 15 or not all(map(_NUMBER.fullmatch, words[2:14])):
                raise FormatError(
                    f"'{line[:40]}' is no part",
                    where=where,
                    remedy="write 1, a colour, 12 numbers and a name",
                )
            numbers = np.array([float(word) for word in words[2:14]])
            matrix = np.eye(4)
            matrix[:3, 3], matrix[:3, :3] = numbers[:3], numbers[3:].reshape(3, 3)
            parts.append((" ".join(words[14:]).lower().replace("/", "\\"), matrix, where))
        elif words[:1] not in ([], ["0"], ["2"], ["3"], ["4"], ["5"]):
            raise FormatError(f"'{line[:40]}' is not LDraw", where=where, remedy="save it anew")
    return models


def _placed(models: dict[str, list[_Placed]], first: str, path: Path) -> Iterator[_Placed]:
    """The parts of a model and of the models in it."""

    def inside(part: _Placed) -> Iterator[_Placed]:
        name, matrix, _ = part
        for one, at, line in models.get(name, []):
            with np.errstate(all="ignore"):  # overflow is found with the parts
                yield one, matrix @ at, line

    every = unfold(
        models[first], inside, path, things="parts", name=lambda one: f"model '{one[0][:40]}'"
    )
    yield from (one for one in every if one[0] not in models)


def _part(name: str, matrix: Floats, where: str) -> tuple[Floats, tuple[int, int, int]]:
    """Lowest corner (3,) in studs and plates, and size in studs, studs and plates."""
    said = _PART.fullmatch(name)
    number = int(said[1]) if said else -1
    if number not in _BRICKS and number not in _PLATES:
        raise FormatError(
            f"part '{name[:40]}' is not known",
            where=where,
            remedy=f"plain bricks and plates are read: {len(_BRICKS)} and {len(_PLATES)} numbers",
        )
    along, across, tall = (*_BRICKS[number], TALL) if number in _BRICKS else (*_PLATES[number], 1)
    if not np.abs(matrix).max() < _FARTHEST:
        raise FormatError(f"part '{name[:40]}' is too far away", where=where)
    turn = _UPRIGHT @ matrix[:3, :3] @ _UPRIGHT.T
    whole = np.rint(turn)
    if whole[2, 2] != 1.0 or np.linalg.det(turn) < 0.9 or np.abs(turn - whole).max() > 1e-3:
        raise FormatError(
            f"part '{name[:40]}' is not upright, or turned by less than a right angle",
            where=where,
            remedy="turn it by 90 degrees, studs up",
        )
    size = (along, across, tall) if whole[0, 0] else (across, along, tall)
    top = _UPRIGHT @ matrix[:3, 3] / _GRID
    return top - np.array([0.5 * size[0], 0.5 * size[1], tall]), size
