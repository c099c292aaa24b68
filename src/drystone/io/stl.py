"""STL: triangles, in text as named solids, in binary as one soup.

Source: 3D Systems, StereoLithography Interface Specification, 1989.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from drystone.base.arrays import ROUNDING, SAME, Floats, unit
from drystone.base.errors import FormatError
from drystone.base.files import decode, lines_of, write_text
from drystone.base.ragged import Ragged
from drystone.geometry.triangulate import fan_warped, triangulate
from drystone.io.draft import Contents, Draft, FaceSoup, in_double, shapes_of

HEADER, RECORD = 84, 50
"""[bytes] Length of the header and of each triangle in the binary form."""
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("spare", "<u2")])
_FACET = ("facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet")


def read(data: bytes, path: Path) -> Draft:
    """Blocks of an STL file: its named solids, or the closed solids among its triangles."""
    if _is_binary(data):
        return _binary(data, path)
    return _text(decode(data, path), path)


def _is_binary(data: bytes) -> bool:
    """Whether the length agrees with the header; binary files may start with ``solid`` too."""
    if len(data) >= HEADER:
        count = int.from_bytes(data[80:84], "little")
        if len(data) == HEADER + RECORD * count:
            return True
    return data.lstrip()[:5].lower() != b"solid"


def _binary(data: bytes, path: Path) -> Draft:
    count = int.from_bytes(data[80:84], "little") if len(data) >= HEADER else -1
    if len(data) < HEADER + RECORD * max(count, 0) or count < 0:
        raise FormatError(
            f"says that it has {max(count, 0)} triangles, but the file ends before"
            if count >= 0
            else "is neither text STL nor binary STL",
            where=str(path),
            remedy="export it again",
        )
    corners = in_double(np.frombuffer(data, _TRIANGLE, count, HEADER)["corner"])
    shapes, notes = shapes_of([_soup(corners.reshape(-1, 3), path.stem, "")], SAME, path)
    return Draft(tuple(shapes), notes=tuple(notes))


def _soup(points: Floats, name: str, where: str) -> FaceSoup:
    return FaceSoup(points, np.arange(len(points)).reshape(-1, 3).tolist(), name, where)


def _text(text: str, path: Path) -> Draft:
    solids: list[tuple[str, int, list[list[float]]]] = []
    expected: tuple[str, ...] = ()
    for number, line in enumerate(lines_of(text), start=1):
        words = line.split()
        if not words:
            continue
        keyword = words[0].lower()
        if expected:
            if keyword != expected[0]:
                raise _bad(path, number, line, expected[0])
            expected = expected[1:]
            if keyword == "vertex":
                solids[-1][2].append(_vertex(words, path, number, line))
        elif keyword == "solid":
            solids.append((line.strip()[5:].strip(), number, []))
        elif keyword == "facet" and solids:
            expected = _FACET[1:]
        elif keyword != "endsolid" or not solids:
            raise _bad(path, number, line, "facet or endsolid")
    if expected:
        raise FormatError(
            f"ends where '{expected[0]}' is expected", where=str(path), remedy="export it again"
        )
    return _named(solids, path)


def _named(solids: list[tuple[str, int, list[list[float]]]], path: Path) -> Draft:
    """Blocks with the names of their solids; else the name of the file, or a number."""
    soups = []
    for i, (name, line, points) in enumerate(solids):
        known = name or (path.stem if len(solids) == 1 else f"solid-{i}")
        corners = np.array(points, dtype=np.float64).reshape(-1, 3)
        soups.append(_soup(corners, known, f"line {line}"))
    shapes, notes = shapes_of(soups, ROUNDING, path, shared=False)
    return Draft(tuple(shapes), notes=tuple(notes))


def _vertex(words: list[str], path: Path, number: int, line: str) -> list[float]:
    try:
        point = [float(word) for word in words[1:]]
    except ValueError as error:
        raise _bad(path, number, line, "vertex x y z") from error
    if len(point) != 3 or not np.isfinite(point).all() or "_" in line:
        raise _bad(path, number, line, "vertex x y z, finite numbers")
    return point


def _bad(path: Path, number: int, line: str, due: str) -> FormatError:
    return FormatError(
        f"'{line.strip()[:40]}' where '{due}' is expected",
        where=f"{path}, line {number}",
        remedy="export it again",
    )


def write(model: Contents, path: Path) -> None:
    """Text, one solid per block with its name, coordinates in shortest exact decimals.

    Polygons are cut into triangles, warped ones about the mean of their corners, as in the volume
    calculation. Supports and densities are not written.
    """
    faces = fan_warped(model.assembly.faces, ROUNDING)
    triangle, polygon = triangulate(faces.point[faces.loop], faces.start)
    corner = faces.point[faces.loop[triangle]]
    normal = unit(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))[0]
    of_block = Ragged.from_owners(faces.owner[polygon], len(model.assembly))
    lines: list[str] = []
    for block, mine in zip(model.assembly.blocks, of_block, strict=True):
        name = " ".join(block.name.split())
        lines.append(f"solid {name}")
        for n, points in zip(normal[mine].tolist(), corner[mine].tolist(), strict=True):
            lines.append(" facet normal " + " ".join(f"{x:.9g}" for x in n))
            lines.append("  outer loop")
            lines += ["   vertex " + " ".join(map(repr, point)) for point in points]
            lines += ["  endloop", " endfacet"]
        lines.append(f"endsolid {name}")
    write_text(path, "\n".join(lines) + "\n")
