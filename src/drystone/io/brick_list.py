"""Stud-and-tube bricks as a plain text list, one brick a line, and their joints.

A line is ``x y z  size_x size_y  [rotation_deg]  [mass_g]``, in studs and in layers from 0 on the
ground; ``#`` begins a remark. A rotation of 90 or 270 degrees exchanges the sizes.

A stud under a brick is an interface with three contact points at a quarter of the pitch about its
axis, four in bricks that are one stud wide. Each point presses without limit, pulls with at most
0.98 N and is held sideways without limit. Bricks of one layer push each other where they touch.

Source: StableLego (Liu and others 2024, arXiv 2402.10711, and its data set, MIT), for the largest
pull, the pitch and the masses. The place of the points was found by ourselves: with it a linear
program uses as much of the largest pull as published for all eight labelled designs.
"""

from __future__ import annotations

import re
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
from drystone.io.draft import Draft, DraftBlock, Extras
from drystone.joint_capacity import NO_LIMIT, JointCapacity

PITCH, LAYER = 7.8e-3, 9.6e-3
"""[m] Distance of studs, height of a brick."""
_STUD_PULL = 0.98
"""[N] Largest pull of one contact point."""
REACH = PITCH / 4.0
"""[m] Distance of a contact point from the axis of its stud."""
_THREE = np.deg2rad([180.0, 300.0, 60.0])
_FOUR = np.deg2rad([0.0, 90.0, 180.0, 270.0])
_MASS_PER_STUD = {True: 0.39e-3, False: 0.27e-3}
"""[kg] By whether the brick is one stud wide: means of the bricks of the data set."""
_GROUND_MARGIN = 2
"""Studs by which the ground reaches farther than the bricks on it."""
_MOST = 100_000
"""Largest coordinate of a brick, chosen."""
_BOX = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_LINE = re.compile(r"(-?\d{1,9}\s+){4}-?\d{1,9}(\s+-?\d{1,9}(\s+\d{0,9}\.?\d{1,9})?)?", re.ASCII)


@dataclass(frozen=True)
class _Brick(OneLine):
    """A brick on the grid of studs.

    Attributes
    ----------
    x, y, z
        Its lowest corner: studs, and layers above the ground.
    size_x, size_y
        Studs along x and y, as it lies.
    mass : [kg]
    """

    x: int
    y: int
    z: int
    size_x: int
    size_y: int
    mass: float

    @property
    def narrow(self) -> bool:
        """Whether it is one stud wide."""
        return min(self.size_x, self.size_y) == 1

    @property
    def studs(self) -> list[tuple[int, int]]:
        """Studs that it covers."""
        along = range(self.x, self.x + self.size_x), range(self.y, self.y + self.size_y)
        return list(product(*along))


def read(data: bytes, path: Path) -> Draft:
    """The draft of a list of bricks, with a ground plate."""
    bricks = []
    for number, line in enumerate(lines_of(decode(data, path)), start=1):
        said = line.split("#")[0].strip()
        if said:
            bricks.append(_brick(said, f"{path}, line {number}"))
    if not bricks:
        raise FormatError("holds no brick", where=str(path), remedy="write x y z size_x size_y")
    _refuse_doubles(bricks, path)
    shapes = [_shape(brick, f"brick-{i:03d}") for i, brick in enumerate(bricks)]
    on_ground = [brick for brick in bricks if brick.z == 0]
    if not on_ground:
        raise FormatError("has no brick on the ground", where=str(path), remedy="give z = 0")
    low = [min(getattr(brick, axis) for brick in on_ground) - _GROUND_MARGIN for axis in "xy"]
    high = [
        max(getattr(b, axis) + getattr(b, f"size_{axis}") for b in on_ground) + _GROUND_MARGIN
        for axis in "xy"
    ]
    plate = _Brick(low[0], low[1], -1, high[0] - low[0], high[1] - low[1], 1.0)
    shapes.append(_shape(plate, "ground", fixed=True))

    def finish(assembly: Assembly, _: float) -> Extras:
        return _joints(bricks, assembly), (), ()

    return Draft(tuple(shapes), "m", finish)


def _brick(line: str, where: str) -> _Brick:
    if not _LINE.fullmatch(line):
        raise FormatError(
            f"'{line[:40]}' is no brick",
            where=where,
            remedy="write x y z size_x size_y, then rotation in degrees and mass in g if wanted",
        )
    words = line.split()
    x, y, z, size_x, size_y = (int(word) for word in words[:5])
    turn = int(words[5]) if len(words) > 5 else 0
    if turn % 90:
        raise FormatError(f"the rotation is {turn} degrees", where=where, remedy="give 0 or 90")
    if turn % 180:
        size_x, size_y = size_y, size_x
    if min(size_x, size_y) < 1 or z < 0 or max(map(abs, (x, y, z, size_x, size_y))) > _MOST:
        remedy = "give sizes of one stud or more, and layers from 0"
        raise FormatError(f"'{line[:40]}' is no brick", where=where, remedy=remedy)
    usual = _MASS_PER_STUD[min(size_x, size_y) == 1] * size_x * size_y
    mass = 1e-3 * float(words[6]) if len(words) > 6 else usual
    if not mass > 0.0:
        raise FormatError("its mass is zero", where=where, remedy="give grams above zero")
    return _Brick(x, y, z, size_x, size_y, mass)


def _refuse_doubles(bricks: list[_Brick], path: Path) -> None:
    taken: dict[tuple[int, int, int], int] = {}
    for i, brick in enumerate(bricks):
        for x, y in brick.studs:
            other = taken.setdefault((x, y, brick.z), i)
            if other != i:
                raise FormatError(
                    f"bricks {other} and {i} are both at {x} {y} {brick.z}", where=str(path)
                )


def _shape(brick: _Brick, name: str, *, fixed: bool = False) -> DraftBlock:
    low = np.array([brick.x * PITCH, brick.y * PITCH, brick.z * LAYER])
    size = np.array([brick.size_x * PITCH, brick.size_y * PITCH, LAYER])
    flat = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float64)
    vertices = np.concatenate([np.c_[flat, np.full(4, height)] for height in (0.0, 1.0)])
    return DraftBlock(
        name, low + vertices * size, _BOX, density=brick.mass / float(size.prod()), fixed=fixed
    )


def _joints(bricks: list[_Brick], assembly: Assembly) -> Contacts:
    """Studs under bricks, and the sides of bricks that touch."""
    at = {(x, y, b.z): i for i, b in enumerate(bricks) for x, y in b.studs}
    ground = assembly.index("ground")
    ends: list[tuple[int, int]] = []
    frames: list[Floats] = []
    corners: list[Floats] = []
    areas: list[float] = []
    pulls: list[float] = []
    upward = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    for i, brick in enumerate(bricks):
        turn = _FOUR if brick.narrow else _THREE
        ring = REACH * np.c_[np.cos(turn), np.sin(turn), 0.0 * turn]
        area = 0.5 * REACH**2 * len(turn) * np.sin(2.0 * np.pi / len(turn))
        for x, y in brick.studs:
            below = ground if brick.z == 0 else at.get((x, y, brick.z - 1))
            if below is None:
                continue
            axis = np.array([(x + 0.5) * PITCH, (y + 0.5) * PITCH, brick.z * LAYER])
            ends.append((below, i))
            frames.append(upward)
            corners.append(axis + ring)
            areas.append(area)
            pulls.append(_STUD_PULL * len(turn))
    for frame, face, pair in _sides(at):
        ends.append(pair)
        frames.append(frame)
        corners.append(face)
        areas.append(PITCH * LAYER)
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
        JointCapacity(pull, held),
    )


def _sides(
    at: dict[tuple[int, int, int], int],
) -> list[tuple[Floats, Floats, tuple[int, int]]]:
    """Frame, corners and blocks of each pair of cells of two bricks side by side."""
    found = []
    for (x, y, z), i in at.items():
        for axis, near in enumerate(((x + 1, y, z), (x, y + 1, z))):
            j = at.get(near, i)
            if j == i:
                continue
            normal, along = np.eye(3)[axis], np.eye(3)[1 - axis]
            frame = np.array([normal, along, np.cross(normal, along)])
            low = np.array([near[0] * PITCH, near[1] * PITCH, z * LAYER])
            u, v = PITCH * along, LAYER * np.array([0.0, 0.0, 1.0])
            face = np.array([low, low + u, low + u + v, low + v])
            if frame[2, 2] < 0.0:  # counter-clockwise about the normal
                face = face[::-1]
            found.append((frame, face, (i, j)))
    return found
