"""Strict reading of JSON and TOML: every value has a required type, every error names its path."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import FormatError, InputError
from drystone.base.files import decode, shipped, toml_of

_LARGEST_WHOLE = 2**53
"""Floats represent all whole numbers up to this one."""


def parse(data: bytes, path: Path, whole: str = "export it again") -> Field:
    """The top-level object or list of a JSON file.

    Parameters
    ----------
    data, path
    whole
        What to do where its end is missing.

    Raises
    ------
    FormatError
        Not JSON (the line is named), a bare value, or a key given twice.
    """
    text = decode(data, path)
    try:
        value = json.loads(text, object_pairs_hook=_object)
    except json.JSONDecodeError as error:
        end = error.pos >= len(text.rstrip()) or error.msg.startswith("Unterminated string")
        what = "the JSON ends too early" if end else f"is not JSON: {error.msg.lower()}"
        raise FormatError(
            what,
            where=f"{path}, line {error.lineno}, column {error.colno}",
            remedy=whole if end else "correct it there",
        ) from error
    except (ValueError, RecursionError) as error:
        what = str(error)
        if isinstance(error, RecursionError):
            what = "its objects are nested too deeply"
        elif not isinstance(error, _TwiceError):  # the only other one: too long for an integer
            what = "a whole number has thousands of digits"
        raise FormatError(f"is no JSON that can be used: {what}", where=str(path)) from error
    top = Field(value, "", path)
    return top if isinstance(value, list) else top.object()


def parse_toml(data: bytes, path: Path) -> Field:
    """The top-level table of a TOML file.

    Raises
    ------
    FormatError
        Not TOML (the line is named), or it takes too much to be read.
    """
    return Field(toml_of(data, path), "", path)


def standard(file: str) -> Field:
    """The top-level table of a TOML file of this package, such as ``seismic/standards/ec8``."""
    name = Path(f"{file}.toml")
    return parse_toml(shipped(f"{file}.toml").encode("utf-8"), Path(name.name))


class _TwiceError(ValueError):
    """A key is given twice in one object."""


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    out = dict(pairs)
    if len(out) != len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise _TwiceError(f"the key '{key}' is given twice in one object")
            seen.add(key)
    return out


@dataclass(frozen=True)
class Field:
    """A value in a JSON file, with its path.

    Attributes
    ----------
    value
    path
        Such as ``blocks[3].vertices[2]``; empty for the top level.
    file
    """

    value: Any
    path: str
    file: Path

    def error(self, what: str, remedy: str = "", at: str = "") -> FormatError:
        """An error about this field, to be raised."""
        where = f"{self.file}: {self.path}{at}".rstrip(": ")
        return FormatError(what, where=where, remedy=remedy)

    @contextmanager
    def blamed(self, remedy: str | None = None) -> Iterator[None]:
        """Errors inside are about this field, perhaps with another remedy."""
        try:
            yield
        except InputError as error:
            raise self.error(error.what, error.remedy if remedy is None else remedy) from error

    def _expect(self, kind: type | tuple[type, ...], name: str) -> None:
        if not isinstance(self.value, kind) or (isinstance(self.value, bool) and kind is not bool):
            raise self.error(f"must be {name}, is {_kind(self.value)}")

    def object(self) -> Field:
        """The field itself, checked to be an object."""
        self._expect(dict, "an object")
        return self

    def has(self, key: str) -> bool:
        """Whether the object has a value other than null for ``key``."""
        return self.object().value.get(key) is not None

    def __getitem__(self, key: str) -> Field:
        if key not in self.object().value:
            has = f"it has {_keys(self.value)}" if self.value else "add it"
            raise self.error(f"'{key}' is missing", has)
        return Field(self.value[key], f"{self.path}.{key}".lstrip("."), self.file)

    def get(self, key: str, default: Any) -> Field:
        """The field of ``key``; a field with ``default`` if it is missing or null."""
        path = f"{self.path}.{key}".lstrip(".")
        return self[key] if self.has(key) else Field(default, path, self.file)

    def only(self, keys: Mapping[str, Any] | tuple[str, ...]) -> None:
        """Refuse keys other than the given ones; those that start with ``_`` are comments."""
        for key in self.object().value:
            if key not in keys and not key.startswith("_"):
                raise self.error(
                    f"has an unknown field '{key[:40]}'", f"known are {', '.join(keys)}"
                )

    def items(self) -> Iterator[tuple[str, Field]]:
        """Keys and fields of an object."""
        for key in self.object().value:
            yield key, self[key]

    def elements(self) -> Iterator[Field]:
        """Fields of a list."""
        self._expect(list, "a list")
        for i, value in enumerate(self.value):
            yield Field(value, f"{self.path}[{i}]", self.file)

    def text(self) -> str:
        """A string."""
        self._expect(str, "a string")
        return str(self.value)

    def boolean(self) -> bool:
        """True or false."""
        self._expect(bool, "true or false")
        return bool(self.value)

    def integer(self) -> int:
        """A whole number that a float can hold."""
        self._expect(int, "a whole number")
        if abs(self.value) >= _LARGEST_WHOLE:
            raise self.error("is too large a whole number")
        return int(self.value)

    def number(self) -> float:
        """A finite number."""
        self._expect((int, float), "a number")
        try:
            number = float(self.value)
        except OverflowError as error:
            raise self.error("is too large a number") from error
        if not np.isfinite(number):
            raise self.error(f"is {number}", "give a finite number")
        return number

    def floats(self, *shape: int | None) -> Floats:
        """Nested lists of finite numbers of the given shape; ``None`` stands for any length.

        The usual case is converted in one step. Only if this fails, the wrong value is searched.
        """
        try:
            array = np.array(self.value if self.value != [] else np.zeros([n or 0 for n in shape]))
            numbers = _holds_numbers(self.value, len(shape))
        except (ValueError, OverflowError, TypeError):
            array, numbers = np.array(None), False
        good = (
            numbers
            and array.dtype.kind in "fiu"
            and array.ndim == len(shape)
            and all(want in (None, have) for want, have in zip(shape, array.shape, strict=True))
        )
        if good and np.isfinite(array).all():
            return array.astype(np.float64)
        self._find_bad(shape)
        raise self.error(f"must be numbers of shape {_shape_text(shape)}")

    def _find_bad(self, shape: tuple[int | None, ...]) -> None:
        if not shape:
            self.number()
            return
        self._expect(list, f"a list of {'' if shape[0] is None else shape[0]} ".rstrip() + " items")
        if shape[0] is not None and len(self.value) != shape[0]:
            raise self.error(f"has {len(self.value)} items, not {shape[0]}")
        for element in self.elements():
            element._find_bad(shape[1:])

    def integers(self, *shape: int | None) -> Ints:
        """Nested lists of whole numbers; see :meth:`floats`."""
        array = self.floats(*shape)
        whole = np.abs(array) < _LARGEST_WHOLE
        whole &= array == np.floor(array)
        if not whole.all():
            place = "".join(f"[{i}]" for i in np.argwhere(~whole)[0])
            raise self.error("must be a whole number", at=place)
        return array.astype(np.intp)


def _holds_numbers(value: Any, depth: int) -> bool:
    """Whether nested lists hold numbers only; numpy would convert true to 1."""
    for _ in range(depth - 1):
        value = chain.from_iterable(value)
    return {type(one) for one in value} <= {int, float}


@lru_cache
def _shape_text(shape: tuple[int | None, ...]) -> str:
    return "(" + ", ".join("any" if size is None else str(size) for size in shape) + ")"


def _kind(value: Any) -> str:
    if value is None:
        return "null"
    names = {bool: "true or false", dict: "an object", list: "a list", str: "a string"}
    return names.get(type(value), f"the number {str(value)[:20]}")


def _keys(value: dict[str, Any]) -> str:
    shown = ", ".join(list(value)[:8])[:120]
    return shown or "no fields"
