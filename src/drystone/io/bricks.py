"""Stud-and-tube bricks on their grid, and their joints.

A stud under a brick is an interface with three contact points at a quarter of the pitch about its
axis, four in bricks that are one stud wide. Each point presses without limit, pulls with at most
0.98 N and is held sideways without limit. Bricks of one layer push each other where they touch.

Source: StableLego (Liu and others 2024, arXiv 2402.10711, and its data set, MIT), for the largest
pull, the pitch and the masses. The place of the points was found by ourselves: with it a linear
program uses as much of the largest pull as published for all eight labelled designs.

Lists of stud-and-tube bricks: plain text with one brick a line, and JSON.

A line is ``x y z  size_x size_y  [rotation_deg]  [mass_g]``, in studs and in layers from 0 on the
ground; ``#`` begins a remark. A rotation of 90 or 270 degrees exchanges the sizes. A line of
BrickGPT is ``2x4 (x,y,z)``, sizes along x and y first. The JSON of StableLego has an object of
bricks with ``x``, ``y``, ``z``, ``ori`` and a ``brick_id``.

Source: Pun and others 2025 (BrickGPT, arXiv 2505.05469) and Liu and others 2024 (StableLego, arXiv
2402.10711), the files that they publish.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import FormatError
from drystone.base.files import decode, lines_of
from drystone.contacts import Contacts
from drystone.geometry.polyhedron import BOX, box_corners
from drystone.io.draft import Draft, DraftBlock, Extras
from drystone.io.jsontext import Field
from drystone.joint_capacity import NO_LIMIT, JointCapacity

PITCH, PLATE = 7.8e-3, 3.2e-3
"""[m] Distance of studs, height of a plate."""
TALL = 3
"""Plates that are as high as a brick."""
_STUD_PULL = 0.98
"""[N] Largest pull of one contact point."""
_REACH = 0.25
"""Distance of a contact point from the axis of its stud, by the pitch."""
_THREE = np.deg2rad([180.0, 300.0, 60.0])
_FOUR = np.deg2rad([0.0, 90.0, 180.0, 270.0])
_MASS_PER_STUD = {True: 0.39e-3, False: 0.27e-3}
"""[kg] Of a brick, by whether it is one stud wide: means of the bricks of the data set."""
_GROUND_MARGIN = 2
"""Studs by which the ground reaches farther than the bricks on it."""
FARTHEST = 100_000
"""Largest coordinate of a brick, chosen."""
_MOST_CELLS = 1_000_000
"""Studs times plates of all bricks, chosen."""


@dataclass(frozen=True)
class Brick(OneLine):
    """A brick on the grid of studs.

    Attributes
    ----------
    x, y, z
        Its lowest corner: studs, and plates above the ground.
    size_x, size_y
        Studs along x and y, as it lies.
    mass : [kg]
    height
        In plates.
    """

    x: int
    y: int
    z: int
    size_x: int
    size_y: int
    mass: float
    height: int = TALL

    @property
    def narrow(self) -> bool:
        """Whether it is one stud wide."""
        return min(self.size_x, self.size_y) == 1

    @property
    def studs(self) -> list[tuple[int, int]]:
        """Studs that it covers."""
        along = range(self.x, self.x + self.size_x), range(self.y, self.y + self.size_y)
        return list(product(*along))


def usual_mass(size_x: int, size_y: int, height: int = TALL) -> float:
    """Mass [kg] of a brick or, by its height, of a plate."""
    return _MASS_PER_STUD[min(size_x, size_y) == 1] * size_x * size_y * height / TALL


def draft_of(bricks: Sequence[Brick], path: Path, pitch: float = PITCH) -> Draft:
    """The draft of bricks, with a ground plate below those at height 0."""
    if not bricks:
        raise FormatError("holds no brick", where=str(path), remedy="write x y z size_x size_y")
    if sum(brick.size_x * brick.size_y * brick.height for brick in bricks) > _MOST_CELLS:
        raise FormatError(
            f"has more than {_MOST_CELLS:,} studs",
            where=str(path),
            remedy="check part by part",
        )
    cells = _cells(bricks, path)
    on_ground = [brick for brick in bricks if brick.z == 0]
    if not on_ground:
        raise FormatError("has no brick on the ground", where=str(path), remedy="give z = 0")
    studs = np.array([stud for brick in on_ground for stud in (brick.studs[0], brick.studs[-1])])
    low = studs.min(axis=0) - _GROUND_MARGIN
    size = studs.max(axis=0) + 1 + _GROUND_MARGIN - low
    plate = Brick(int(low[0]), int(low[1]), -TALL, int(size[0]), int(size[1]), 1.0)
    shapes = [_shape(brick, f"brick-{i:03d}", pitch) for i, brick in enumerate(bricks)]
    shapes.append(_shape(plate, "ground", pitch, fixed=True))

    def finish(assembly: Assembly, _: float) -> Extras:
        return _joints(bricks, cells, assembly.index("ground"), pitch), (), ()

    return Draft(tuple(shapes), "m", finish)


def _cells(bricks: Sequence[Brick], path: Path) -> dict[tuple[int, int, int], int]:
    """The brick at each stud and plate."""
    taken: dict[tuple[int, int, int], int] = {}
    for i, brick in enumerate(bricks):
        for x, y in brick.studs:
            for z in range(brick.z, brick.z + brick.height):
                other = taken.setdefault((x, y, z), i)
                if other != i:
                    raise FormatError(
                        f"bricks {other} and {i} are both at stud {x} {y}, {z * PLATE * 1e3:g} mm"
                        " above the ground",
                        where=str(path),
                        remedy="remove or move one of them",
                    )
    return taken


def _shape(brick: Brick, name: str, pitch: float, *, fixed: bool = False) -> DraftBlock:
    unit = np.array([pitch, pitch, PLATE])
    size = unit * [brick.size_x, brick.size_y, brick.height]
    low = unit * [brick.x, brick.y, brick.z]
    corners = box_corners(low, low + size)
    return DraftBlock(name, corners, BOX, density=brick.mass / float(size.prod()), fixed=fixed)


def _joints(
    bricks: Sequence[Brick], cells: dict[tuple[int, int, int], int], ground: int, pitch: float
) -> Contacts:
    """Studs under bricks, and the sides of bricks that touch."""
    ends: list[tuple[int, int]] = []
    frames: list[Floats] = []
    corners: list[Floats] = []
    areas: list[float] = []
    pulls: list[float] = []
    upward = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    reach = _REACH * pitch
    for i, brick in enumerate(bricks):
        turn = _FOUR if brick.narrow else _THREE
        ring = reach * np.c_[np.cos(turn), np.sin(turn), 0.0 * turn]
        area = 0.5 * reach**2 * len(turn) * np.sin(2.0 * np.pi / len(turn))
        for x, y in brick.studs:
            below = ground if brick.z == 0 else cells.get((x, y, brick.z - 1))
            if below is None:
                continue
            axis = np.array([(x + 0.5) * pitch, (y + 0.5) * pitch, brick.z * PLATE])
            ends.append((below, i))
            frames.append(upward)
            corners.append(axis + ring)
            areas.append(area)
            pulls.append(_STUD_PULL * len(turn))
    for frame, face, area, pair in _sides(bricks, cells, pitch):
        ends.append(pair)
        frames.append(frame)
        corners.append(face)
        areas.append(area)
        pulls.append(0.0)
    pull = np.array(pulls)
    held = np.where(pull > 0.0, NO_LIMIT, 0.0)
    return Contacts(
        np.array([a for a, _ in ends], dtype=np.intp),
        np.array([b for _, b in ends], dtype=np.intp),
        np.array(frames).reshape(-1, 3, 3),
        np.array(areas),
        np.zeros(len(ends)),
        np.concatenate([np.zeros((0, 3)), *corners]),
        np.repeat(np.arange(len(corners)), [len(one) for one in corners]),
        JointCapacity(pull, held, brittle=False),
    )


def _sides(
    bricks: Sequence[Brick], cells: dict[tuple[int, int, int], int], pitch: float
) -> Iterator[tuple[Floats, Floats, float, tuple[int, int]]]:
    """Frame, corners, area and blocks where bricks are side by side, once for each stud."""
    for (x, y, z), i in cells.items():
        for axis, near in enumerate(((x + 1, y, z), (x, y + 1, z))):
            j = cells.get(near, i)
            if j == i or z != max(bricks[i].z, bricks[j].z):
                continue
            tall = PLATE * (min(bricks[k].z + bricks[k].height for k in (i, j)) - z)
            normal, along = np.eye(3)[axis], np.eye(3)[1 - axis]
            frame = np.array([normal, along, np.cross(normal, along)])
            low = np.array([near[0] * pitch, near[1] * pitch, z * PLATE])
            u, v = pitch * along, tall * np.array([0.0, 0.0, 1.0])
            face = np.array([low, low + u, low + u + v, low + v])
            if frame[2, 2] < 0.0:  # counter-clockwise about the normal
                face = face[::-1]
            yield frame, face, pitch * tall, (i, j)


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
