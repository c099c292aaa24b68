"""Arrays in an npz file beside a JSON file, with checks of both.

In the JSON an array is ``{"npz": "force"}``, a part of an array ``{"npz": "vertices", "rows": [0,
8]}``, and a list of lists of different lengths ``{"npz": "corners", "rows": [0, 24], "lengths": [4,
4, 4, 4, 4, 4]}``. Top level: ``"arrays": {"file": "model.npz", "sha256": "..."}``.
"""

from __future__ import annotations

import hashlib
import io
import math
import re
import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drystone.base.errors import FormatError
from drystone.base.files import read_bytes
from drystone.io.jsontext import Field

_HEADER = re.compile(
    rb"\x93NUMPY\x01\x00(..)\{'descr': '([<|](?:f[48]|[iu][1248]))', 'fortran_order': False, "
    rb"'shape': \(([0-9, ]{0,60})\), \} *\n",
    re.DOTALL,
)
"""Start of the header that numpy writes for numeric arrays in C order. Source: numpy.lib.format,
1.0."""
UNPACKED, RATIO = 2**26, 100
"""[bytes] Largest unpacked size of an archive: the first number plus the second times its packed
size. Chosen."""
_UNREADABLE = (
    *(zipfile.BadZipFile, zlib.error, struct.error, ValueError, KeyError, NotImplementedError),
    *(RuntimeError, EOFError, OSError, OverflowError),
)
"""Errors of the standard library for a damaged archive."""


class Packer:
    """Collects arrays while a model is converted to plain values.

    Attributes
    ----------
    arrays
        The whole arrays, by key.
    """

    def __init__(self) -> None:
        self.arrays: dict[str, NDArray[Any]] = {}
        self._pieces: dict[str, list[NDArray[Any]]] = {}
        self._rows: dict[str, int] = {}

    def put(self, key: str, array: NDArray[Any]) -> dict[str, Any]:
        """Store a whole array; returns its reference for the JSON."""
        self.arrays[key] = array
        return {"npz": key}

    def append(self, key: str, array: NDArray[Any]) -> dict[str, Any]:
        """Store an array as further rows of another; returns its reference."""
        first = self._rows.get(key, 0)
        self._rows[key] = first + len(array)
        self._pieces.setdefault(key, []).append(array)
        return {"npz": key, "rows": [first, first + len(array)]}

    def data(self) -> bytes:
        """The npz file."""
        joined = {key: np.concatenate(pieces) for key, pieces in self._pieces.items()}
        buffer = io.BytesIO()
        # the type checker cannot exclude an array named allow_pickle
        np.savez_compressed(buffer, **(self.arrays | joined))  # type: ignore[arg-type]
        return buffer.getvalue()


def digest(data: bytes) -> str:
    """The checksum that connects the two files."""
    return hashlib.sha256(data).hexdigest()


def resolve(top: Field) -> Field:
    """The JSON with every reference replaced by its numbers.

    Raises
    ------
    FormatError
        The npz file is missing, belongs to another file, or does not fit a reference.
    """
    if not top.has("arrays"):
        return top
    named = top["arrays"]
    named.only(("file", "sha256"))
    name = named["file"].text()
    if Path(name).name != name or not name.endswith(".npz"):
        raise named["file"].error(
            "is not the name of an npz file in the same folder", "keep both in one folder"
        )
    path = top.file.parent / name
    data = read_bytes(path)
    if digest(data) != named["sha256"].text():
        raise FormatError(
            f"does not belong to {top.file.name}", where=str(path), remedy="write both again"
        )
    arrays = _load(data, path)
    rest = {key: value for key, value in top.value.items() if key != "arrays"}
    budget = [2 * sum(array.size for array in arrays.values()) + 1000]
    return Field(_expand(Field(rest, "", top.file), arrays, budget), "", top.file)


def _load(data: bytes, path: Path) -> dict[str, NDArray[Any]]:
    """Numeric arrays of an npz file; sizes are checked against the data."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if sum(member.file_size for member in members) > UNPACKED + RATIO * len(data):
                raise FormatError(
                    "becomes far larger than itself when it is unpacked",
                    where=str(path),
                    remedy="write it again",
                )
            return {
                member.filename.removesuffix(".npy"): _array(archive, member, path)
                for member in members
            }
    except FormatError:
        raise
    except _UNREADABLE as error:
        raise FormatError(f"is no npz file: {error}", where=str(path)) from error


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo, path: Path) -> NDArray[Any]:
    where = f"{path}, array '{member.filename[:40]}'"
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise FormatError(
            "is compressed with an unusual method", where=where, remedy="write it again"
        )
    with archive.open(member) as file:
        content = file.read(member.file_size + 1)
    match = _HEADER.match(content)
    if match is None or match.end() != 10 + int.from_bytes(match[1], "little"):
        raise FormatError("is not an array of numbers", where=where, remedy="write it again")
    dtype = np.dtype(match[2].decode())
    shape = tuple(int(size) for size in match[3].decode().replace(",", " ").split())
    body = content[match.end() :]
    if math.prod(shape) * dtype.itemsize != len(body):
        raise FormatError(
            "does not have the contents that its header says", where=where, remedy="write it again"
        )
    return np.frombuffer(body, dtype=dtype).reshape(shape)


def _expand(field: Field, arrays: dict[str, NDArray[Any]], budget: list[int]) -> Any:
    """Values with references replaced; ``budget`` [numbers] limits the expanded size."""
    if isinstance(field.value, list):
        return [_expand(element, arrays, budget) for element in field.elements()]
    if not isinstance(field.value, dict):
        return field.value
    if "npz" not in field.value:
        return {key: _expand(value, arrays, budget) for key, value in field.items()}
    field.only(("npz", "rows", "lengths"))
    key = field["npz"].text()
    if key not in arrays or arrays[key].ndim == 0:
        raise field.error(f"there is no array '{key[:40]}' in the npz file")
    array = arrays[key]
    if field.has("rows"):
        first, last = field["rows"].integers(2).tolist()
        if not 0 <= first <= last <= len(array):
            raise field["rows"].error(f"are not in the array, which has {len(array)} rows")
        array = array[first:last]
    budget[0] -= array.size
    if budget[0] < 0:
        raise field.error("repeats the same numbers too often", "write the file again")
    if not field.has("lengths"):
        return array.tolist()
    lengths = field["lengths"].integers(None)
    if (lengths < 0).any() or lengths.sum() != len(array):
        raise field["lengths"].error(f"do not add up to {len(array)} rows")
    return [part.tolist() for part in np.split(array, np.cumsum(lengths)[:-1])]
