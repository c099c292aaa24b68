"""The entities of a DXF file, with its layers and units, each moved to where it is inserted.

Source: Autodesk, DXF Reference (2018): pairs of a group code and a value, a line each. A flat
entity lies in a plane; its normal is given by codes 210 to 230, and its axes follow from that by
the arbitrary axis algorithm.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise, product
from pathlib import Path
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import FARTHEST, Floats
from drystone.base.errors import FormatError
from drystone.base.files import lines_of
from drystone.io.outside import unfold

_UNITS = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m"}
"""By the value of $INSUNITS."""
_CODE = re.compile(r"-?\d{1,4}", re.ASCII)
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d{1,3})?", re.ASCII)
_UPRIGHT = 1.0 / 64.0
"""Below it both x and y of a normal count as zero, in the arbitrary axis algorithm."""


@dataclass(frozen=True, eq=False)
class Entity:
    """An entity with its tags; a polyline with its vertices; a block with its entities.

    Attributes
    ----------
    kind
    tags
        Group codes with their texts.
    inner
    line
        Of the file, where it begins.
    """

    kind: str
    tags: list[tuple[int, str]] = field(default_factory=list)
    inner: list[Entity] = field(default_factory=list)
    line: int = 0

    def text(self, code: int) -> str:
        """The first text of a code, or nothing."""
        return self._first.get(code, "")

    @cached_property
    def _first(self) -> dict[int, str]:
        """By code; a block with a large polyline is placed very often."""
        return dict(reversed(self.tags))

    def number(self, code: int, default: float = 0.0) -> float:
        """The first number of a code."""
        return float(self.text(code) or default)

    def numbers(self, code: int) -> list[float]:
        """All numbers of a code."""
        return [float(text) for key, text in self.tags if key == code]

    @property
    def place(self) -> str:
        """Its line, and its handle if it has one, for errors."""
        handle = self.text(5)
        return f"line {self.line}" + (f", handle {handle[:16]}" if handle else "")

    @property
    def flags(self) -> int:
        """Bits of code 70."""
        return int(self.number(70))

    def point(self, code: int = 10) -> Floats:
        """The point (3,) of a code and those 10 and 20 above it."""
        return np.array([self.number(code + step) for step in (0, 10, 20)])

    def frame(self) -> Floats:
        """Axes (3, 3) of its plane, in columns."""
        normal = self.point(210)
        size = float(np.linalg.norm(normal))
        normal = normal / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
        upright = np.abs(normal[:2]).max() < _UPRIGHT
        x = np.cross([0.0, 1.0, 0.0] if upright else [0.0, 0.0, 1.0], normal)
        x /= np.linalg.norm(x)
        return np.stack([x, np.cross(normal, x), normal], axis=1)


@dataclass(frozen=True, eq=False)
class Drawing:
    """What a file holds.

    Attributes
    ----------
    units
        ``None`` if it has none, or none that is known.
    visible
        By layer.
    entities
        Each with the matrix (4, 4) that moves it to its place, and its layer.
    """

    units: str | None
    visible: dict[str, bool]
    entities: list[tuple[Entity, Floats, str]]


def drawing(data: bytes, path: Path) -> Drawing:
    """The drawing in the bytes of a file.

    Raises
    ------
    FormatError
        No DXF, binary, cut off, with a number that is none, or with too many entities.
    """
    if data.startswith(b"AutoCAD Binary DXF"):
        raise FormatError(
            "is a binary DXF", where=str(path), remedy="save it as a text (ASCII) DXF"
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:  # before 2007; only names have other letters than ASCII
        text = data.decode("latin-1")
    units = None
    visible: dict[str, bool] = {}
    blocks: dict[str, Entity] = {}
    entities: list[Entity] = []
    section = ""
    target: list[Entity] = []
    for entity in _entities(text, path):
        if entity.kind == "SECTION":
            section = entity.text(2)
            target = entities if section == "ENTITIES" else []
            units = _units(entity) if section == "HEADER" else units
        elif entity.kind == "BLOCK":
            target = blocks.setdefault(entity.text(2).lower(), entity).inner
        elif entity.kind == "LAYER" and section == "TABLES":
            frozen = entity.flags & 1 or entity.number(62) < 0
            visible[entity.text(2)] = not frozen
        elif entity.kind == "VERTEX" and target and target[-1].kind == "POLYLINE":
            target[-1].inner.append(entity)
        elif entity.kind in ("ENDSEC", "ENDBLK"):
            target = []
        elif entity.kind != "SEQEND" and not entity.number(67):  # else it is of the paper
            target.append(entity)
    return Drawing(units, visible, [*_placed(entities, blocks, path)])


def _entities(text: str, path: Path) -> Iterator[Entity]:
    """Entities in the order of the file, each until the next code 0."""
    lines = [*lines_of(text)]
    while lines and not lines[-1].strip():
        lines.pop()
    entity: Entity | None = None
    for at in range(0, len(lines) - 1, 2):
        code, value = lines[at].strip(), lines[at + 1].strip()
        if not _CODE.fullmatch(code):
            raise FormatError(
                f"'{code[:40]}' is no group code of DXF",
                where=f"{path}, line {at + 1}",
                remedy="save it again as DXF",
            )
        key = int(code)
        if key == 0:
            if entity is not None:
                yield entity
            entity = Entity(value, line=at + 1)
        elif entity is not None:
            if 10 <= key < 100 or 210 <= key < 240:
                _require_number(value, f"{path}, line {at + 2}")
            entity.tags.append((key, value))
    if entity is None or entity.kind != "EOF":
        raise FormatError("ends too early", where=str(path), remedy="save it again as DXF")


def _require_number(value: str, where: str) -> None:
    if not _NUMBER.fullmatch(value) or not abs(float(value)) <= FARTHEST:
        raise FormatError(
            f"'{value[:40]}' is no number", where=where, remedy="save it again as DXF"
        )


def _units(header: Entity) -> str | None:
    tags = header.tags
    for (_, name), (_, value) in pairwise(tags):
        if name == "$INSUNITS":
            return _UNITS.get(int(float(value)) if _NUMBER.fullmatch(value) else 0)
    return None


_Placed: TypeAlias = tuple[Entity, Floats, str]


def _placed(entities: list[Entity], blocks: dict[str, Entity], path: Path) -> Iterator[_Placed]:
    """Entities with their matrices and layers, those of inserted blocks at each of their places."""

    def block_of(entity: Entity) -> Entity | None:
        return blocks.get(entity.text(2).lower()) if entity.kind == "INSERT" else None

    def inside(placed: _Placed) -> Iterator[_Placed]:
        insert, matrix, layer = placed
        block = block_of(insert)
        if block is not None and block.inner:
            for place in _places(insert, block):
                with np.errstate(all="ignore"):  # overflow is found with the points
                    at = matrix @ place
                yield from ((one, at, _layer(one, layer)) for one in block.inner)

    roots = [(one, np.eye(4), _layer(one, "0")) for one in entities]
    every = unfold(
        roots, inside, path, things="entities", name=lambda one: f"block '{one[0].text(2)[:40]}'"
    )
    yield from (one for one in every if block_of(one[0]) is None)


def _layer(entity: Entity, above: str) -> str:
    """Layer of an entity: that of the insertion around it where it is 0."""
    own = entity.text(8)
    return above if own in ("", "0") else own


def _places(insert: Entity, block: Entity) -> Iterator[Floats]:
    """Matrices (4, 4) of a block at an insertion, in columns and rows."""
    grid = int(insert.number(70, 1)), int(insert.number(71, 1))
    turn, grow = np.deg2rad(insert.number(50)), [insert.number(code, 1.0) for code in (41, 42, 43)]
    spin = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    frame, apart = insert.frame(), np.array([insert.number(44), insert.number(45), 0.0])
    turned = frame @ spin @ np.diag(grow)
    first = frame @ insert.point() - turned @ block.point()
    for i, j in product(range(grid[0]), range(grid[1])):
        place = np.eye(4)
        place[:3, :3] = turned
        place[:3, 3] = first + frame @ spin @ (apart * [i, j, 0])
        yield place
