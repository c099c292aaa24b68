"""Wavefront OBJ: one object or group per block, polygons and names kept.

Source: Wavefront Technologies, Advanced Visualizer Manual, Appendix B1 (object files).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from drystone.base.errors import FormatError
from drystone.base.files import decode, lines_of, write_text
from drystone.geometry.polyhedron import used_vertices
from drystone.io.draft import Contents, Draft, DraftBlock

_IGNORED = frozenset(
    (
        *("vt", "vn", "vp", "p", "l", "s", "mg", "usemtl", "mtllib", "usemap", "maplib", "bevel"),
        *("lod", "c_interp", "d_interp", "shadow_obj", "trace_obj", "cstype", "deg", "bmat"),
        *("step", "parm", "end", "con"),
    )
)
"""Statements without meaning for a polygon mesh."""
_FREE_FORM = frozenset(
    ("curv", "curv2", "surf", "trim", "hole", "scrv", "sp", "bsp", "bzp", "cdc", "cdp", "res")
)
"""Statements of curves and surfaces."""
_INDEX = re.compile(r"-?[0-9]{1,11}")
NUMBER = re.compile(
    r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf|infinity)", re.IGNORECASE | re.ASCII
)


@dataclass
class _Part:
    """Faces between two object or group statements."""

    number: int  # of its object statement
    object: str | None
    group: str | None
    line: int
    faces: list[list[int]] = field(default_factory=list)


def read(data: bytes, path: Path) -> Draft:
    """Blocks of an OBJ file.

    Blocks are the objects (``o``) where two or more have faces, else the groups (``g``), else the
    whole file is one block. A block gets its own copy of the vertices that its faces use.
    """
    vertices, parts, cut_off = _parse(decode(data, path), path)
    shapes, notes = _shapes(vertices, _blocks(parts), path)
    return Draft(tuple(shapes), notes=(*notes, *cut_off))


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines with their numbers; continued lines are joined, comments and blank lines skipped.

    Names are unchanged: they may contain ``#`` and end in a backslash.
    """
    held: list[str] = []
    start = 0
    for number, line in enumerate(lines_of(text), start=1):
        if not held and line[:2] in ("o ", "g "):
            yield number, line.strip()
            continue
        start = start if held else number
        if line.endswith("\\"):
            held.append(line[:-1])
            continue
        stripped = " ".join((*held, line)).split("#", 1)[0].strip()
        held = []
        if stripped:
            yield start, stripped
    last = " ".join(held).strip()
    if last:
        yield start, last


def _parse(text: str, path: Path) -> tuple[list[list[float]], list[_Part], list[str]]:
    """Vertices, parts with faces, and a note where the file ends before the faces of an object."""
    vertices: list[list[float]] = []
    parts = [_Part(0, None, None, 1)]
    begun = 0  # vertices before the last object
    for number, line in _lines(text):
        keyword, *rest = line.split(None, 1)
        argument = rest[0] if rest else ""
        if keyword == "v":
            vertices.append(_vertex(argument, f"{path}, line {number}"))
        elif keyword == "f":
            parts[-1].faces.append(_face(argument, len(vertices), f"{path}, line {number}"))
        elif keyword == "o":
            parts.append(_Part(parts[-1].number + 1, argument or None, None, number))
            begun = len(vertices)
        elif keyword == "g":
            name = argument if argument and argument != "default" else None
            parts.append(_Part(parts[-1].number, parts[-1].object, name, number))
        elif keyword in _FREE_FORM:
            raise FormatError(
                f"'{keyword}' is a free-form surface",
                where=f"{path}, line {number}",
                remedy="export meshes instead of surfaces",
            )
        elif keyword not in _IGNORED:
            raise FormatError(
                f"'{line[:40]}' is not OBJ", where=f"{path}, line {number}", remedy="export it anew"
            )
    last = [part for part in parts if part.number == parts[-1].number]
    cut_off = []
    if len(vertices) > begun and not any(part.faces for part in last):
        told = f"'{last[0].object}' at line {last[0].line}" if last[0].object else "the last object"
        cut_off = [f"{told} has vertices and no faces: was the file cut off there?"]
    return vertices, [part for part in parts if part.faces], cut_off


def _vertex(argument: str, where: str) -> list[float]:
    words = argument.split()
    if not 3 <= len(words) <= 7 or not all(NUMBER.fullmatch(word) for word in words):
        cut_off = ": it may have been cut off there" if len(words) < 3 else ""
        raise FormatError(
            f"vertex '{argument[:60]}' is not three numbers",
            where=where,
            remedy=f"export the file again{cut_off}",
        )
    point = [float(word) for word in words[:3]]
    if not all(abs(x) < float("inf") for x in point):
        raise FormatError(
            f"vertex '{argument[:60]}' is not finite", where=where, remedy="give finite numbers"
        )
    return point


def _face(argument: str, count: int, where: str) -> list[int]:
    """Zero-based vertex indices of ``v``, ``v/vt``, ``v//vn`` or ``v/vt/vn`` corners."""
    loop = []
    for word in argument.split():
        digits = word.split("/", 1)[0]
        try:
            index = int(digits) if _INDEX.fullmatch(digits) else 0
        except ValueError:
            index = 0
        if index == 0 or index > count or -index > count:
            raise FormatError(
                f"face corner '{word[:40]}' is no vertex",
                where=where,
                remedy=f"{count} vertices are known here, the first is 1",
            )
        loop.append(index - 1 if index > 0 else count + index)
    if len(loop) < 3:
        raise FormatError("a face needs three corners", where=where)
    return loop


def _blocks(parts: list[_Part]) -> list[_Part]:
    """Parts combined into blocks, by object or by group."""
    by_object = len({part.number for part in parts}) > 1 or all(p.group is None for p in parts)
    blocks: list[_Part] = []
    open_blocks: dict[int | str | None, tuple[_Part, set[int]]] = {}
    for part in parts:
        key = part.number if by_object else part.group
        corners = {i for face in part.faces for i in face}
        block, used = open_blocks.get(key, (None, set()))
        # a repeated group continues its block, unless it shares no vertex with it
        if block is None or not (by_object or corners & used):
            name = part.object if by_object else part.group
            block, used = _Part(part.number, name, None, part.line), set()
            blocks.append(block)
            open_blocks[key] = (block, used)
        block.faces.extend(part.faces)
        used |= corners
    return blocks


def _shapes(
    vertices: list[list[float]], blocks: list[_Part], path: Path
) -> tuple[list[DraftBlock], list[str]]:
    shapes, notes = [], []
    for number, block in enumerate(blocks):
        used, loops = used_vertices(block.faces)
        name = block.object
        if name is None:
            name = path.stem if len(blocks) == 1 else f"block-{number}"
            if len(blocks) > 1:
                notes.append(f"the block at line {block.line} has no name: '{name}'")
        points = [vertices[i] for i in used]
        shapes.append(DraftBlock(name, points, loops, where=f"line {block.line}"))
    return shapes, notes


def write(model: Contents, path: Path) -> None:
    """One ``o`` per block, coordinates in shortest exact decimals; supports are not kept."""
    lines = [f"# drystone, {model.units}"]
    offset = 1
    for block in model.assembly.blocks:
        name = " ".join(lines_of(block.name))
        lines.append(f"o {name}")
        lines += ["v " + " ".join(map(repr, point)) for point in block.vertices.tolist()]
        lines += ["f " + " ".join(str(i + offset) for i in face) for face in block.faces]
        offset += len(block.vertices)
    write_text(path, "\n".join(lines) + "\n")
