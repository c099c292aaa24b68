"""The header and the tables of a PLY file; sizes are checked against the length of the file."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drystone.base.errors import FormatError
from drystone.base.files import MIB

_END = re.compile(rb"[\r\n][ \t]*end_header")
"""It must be a whole line, since a block may have this name."""
_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}
"""Of the module struct."""
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}

Table = dict[str, Any]
"""Columns by name: arrays of numbers, and for list properties a list of lists."""


@dataclass(frozen=True)
class _Property:
    """A column of an element; a list has a type for its length."""

    name: str
    type: str
    length: str | None = None


@dataclass(frozen=True)
class Element:
    """A table of the file."""

    name: str
    count: int
    properties: tuple[_Property, ...]


@dataclass(frozen=True)
class _Header:
    """Description of the tables of a file."""

    order: str
    elements: tuple[Element, ...]
    comments: tuple[str, ...]
    size: int


def header_of(data: bytes, path: Path) -> _Header:
    """The header of a file.

    Raises
    ------
    FormatError
        It has no header, or one that cannot be read.
    """
    ending = _END.search(data, 0, MIB)
    end = -1 if ending is None else ending.end() - len(b"end_header")
    stop = data.find(b"\n", end)
    if not data.startswith(b"ply") or end < 0:
        raise FormatError("is not a PLY file", where=str(path), remedy="export it again")
    size = stop + 1 if stop >= 0 else len(data)
    try:
        lines = data[:end].decode("utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise FormatError("has a header that is no text", where=str(path)) from error
    order: str | None = None
    elements: list[tuple[str, int, list[_Property]]] = []
    comments: list[str] = []
    for number, line in enumerate(lines[1:], start=2):
        words = line.split()
        try:
            match words:
                case [] | ["obj_info", *_]:
                    pass
                case ["comment", *_]:
                    comments.append(line.split(None, 1)[1] if len(words) > 1 else "")
                case ["format", kind, _]:
                    order = _ORDERS[kind]
                case ["element", name, count]:
                    elements.append((name, _count(count), []))
                case ["property", "list", length, kind, name]:
                    elements[-1][2].append(_Property(name, _TYPES[kind], _TYPES[length]))
                case ["property", kind, name]:
                    elements[-1][2].append(_Property(name, _TYPES[kind]))
                case _:
                    raise KeyError(line)
        except (KeyError, IndexError, ValueError) as error:
            raise FormatError(
                f"'{line.strip()[:40]}' is no PLY header", where=f"{path}, line {number}"
            ) from error
    if order is None:
        raise FormatError("does not say its format", where=str(path), remedy="export it again")
    tables = tuple(Element(name, count, tuple(columns)) for name, count, columns in elements)
    return _Header(order, tables, tuple(comments), size)


def _count(text: str) -> int:
    if not text.isdecimal() or len(text) > 12:
        raise ValueError(text)
    return int(text)


def read(body: bytes, header: _Header, path: Path) -> dict[str, Table]:
    """All tables, by name.

    Raises
    ------
    FormatError
        The file ends too early, or has values that are not numbers.
    """
    early = FormatError("ends before its data do", where=str(path), remedy="export it again")
    try:
        if not header.order:
            return _ascii(body, header)
        return _binary(body, header)
    except (IndexError, struct.error) as error:
        raise early from error
    except (ValueError, OverflowError) as error:
        raise FormatError(f"has values that are not numbers: {error}", where=str(path)) from error


def _ascii(body: bytes, header: _Header) -> dict[str, Table]:
    words = body.split()
    at = 0

    def taken(kind: str, count: int) -> list[Any]:
        """The next values."""
        nonlocal at
        if not 0 <= count <= len(words) - at:
            raise IndexError
        at += count
        return list(map(float if kind[0] == "f" else int, words[at - count : at]))

    tables: dict[str, Table] = {}
    for element in header.elements:
        if element.properties and element.count > len(words) - at:
            raise IndexError
        tables[element.name] = _rows(element, taken)
    return tables


def _rows(element: Element, taken: Callable[[str, int], Sequence[Any]]) -> Table:
    """The columns of rows that follow each other, from a function that takes the next values."""
    columns: Table = {column.name: [] for column in element.properties}
    for _ in range(element.count if element.properties else 0):
        for column in element.properties:
            if column.length is None:
                columns[column.name].append(taken(column.type, 1)[0])
            else:
                (length,) = taken(column.length, 1)
                columns[column.name].append(list(map(int, taken(column.type, int(length)))))
    for column in element.properties:
        if column.length is None:
            kind = np.float64 if column.type[0] == "f" else np.int64
            columns[column.name] = np.array(columns[column.name], dtype=kind)
    return columns


def _binary(body: bytes, header: _Header) -> dict[str, Table]:
    at = 0

    def taken(kind: str, count: int) -> Sequence[Any]:
        """The next values; lists in rows have different lengths."""
        nonlocal at
        size = int(kind[1]) * count
        if not 0 <= size <= len(body) - at:
            raise IndexError
        at += size
        return struct.unpack_from(f"{header.order}{count}{_CODES[kind]}", body, at - size)

    tables: dict[str, Table] = {}
    for element in header.elements:
        if element.properties and not any(column.length for column in element.properties):
            dtype = np.dtype([(c.name, header.order + c.type) for c in element.properties])
            size = dtype.itemsize * element.count
            if size > len(body) - at:
                raise IndexError
            rows = np.frombuffer(body, dtype, element.count, at)
            tables[element.name] = {column.name: rows[column.name] for column in element.properties}
            at += size
            continue
        tables[element.name] = _rows(element, taken)
    return tables
