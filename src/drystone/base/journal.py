"""Records in a file that survive what cuts it: a full disk, a killed process, a damaged byte."""

from __future__ import annotations

import dataclasses
import json
import logging
import os
import re
import zlib
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from drystone.base.display import shortened
from drystone.base.errors import FormatError
from drystone.base.files import PathLike, digest, plain_target, read_bytes, unwritable
from drystone.base.settings import Workers
from drystone.base.workers import WorkerPool

_LOG = logging.getLogger(__name__)
_LARGEST = 2**30
"""[bytes], chosen: some million records. One more would make a file that cannot be continued."""
_NO_RECORD = (ValueError, TypeError, LookupError, AttributeError, OverflowError, RecursionError)
"""What JSON that is no record, or the record that it is not, ends in."""

_ANEW = "name another file, or remove this one to start anew"


class _Damaged(ValueError):
    """A line is not what was written."""


class Journal:
    """Records that are added one by one, each on the disk before the next.

    Every line is a checksum and a JSON value. The first says what the records are about. A last
    line that is no record, such as half a line of a process that was killed or of a full disk, is
    dropped and told to the log.

    Parameters
    ----------
    path
        Made by the first record; continued where it exists.
    about
        What the records are about, such as the fingerprint of a model and the version.
    made
        What a record stands for, from its JSON; fails with an error of Python where it is none.

    Raises
    ------
    FormatError
        The file is no journal, is about something else, is damaged before its end, or cannot be
        read.
    """

    def __init__(
        self,
        path: PathLike,
        about: Mapping[str, Any],
        made: Callable[[Any], Any] = lambda record: record,
    ) -> None:
        self.path, self._made = plain_target(path), made
        self.records: list[Any] = []
        self._about = json.loads(json.dumps(about))
        self._whole = self._size = 0
        if self.path.exists() and self.path.stat().st_size:
            self._read()

    @staticmethod
    def about(path: PathLike) -> dict[str, Any]:
        """What the records of a file are about.

        Raises
        ------
        FormatError
            The file is no journal, or cannot be read.
        """
        first = BytesIO(read_bytes(path, _LARGEST, anew=_ANEW)).readline()
        try:
            return dict(_value(first))
        except _NO_RECORD as error:
            raise _no_journal(path) from error

    def add(self, records: Iterable[Any]) -> None:
        """Write records to the end.

        Raises
        ------
        FormatError
            The file cannot be written, as on a full disk; what was whole stays. Or another process
        wrote to it.
        """
        lines = b"".join(map(_line, chain([] if self._whole else [self._about], records)))
        try:
            with self.path.open("ab", buffering=0) as file:
                if file.tell() != self._size:
                    raise FormatError(
                        "was changed by another process",
                        where=str(self.path),
                        remedy="let each process have a file of its own",
                    )
                file.truncate(self._whole)
                rest = lines
                while rest:
                    rest = rest[file.write(rest) :]
        except OSError as error:
            with suppress(OSError):  # else the next run drops the part that was written
                os.truncate(self.path, self._whole)
                self._size = self._whole
            raise unwritable(self.path, error) from error
        self._whole = self._size = self._whole + len(lines)

    def _read(self) -> None:
        data = read_bytes(self.path, _LARGEST, anew=_ANEW)
        self._size = len(data)
        lines = BytesIO(data).readlines()
        values = []
        for number, line in enumerate(lines, start=1):
            try:
                value = _value(line)
                values.append(value if number == 1 else self._made(value))
            except _NO_RECORD as error:
                if number == 1:
                    raise _no_journal(self.path) from error
                if number < len(lines):
                    raise FormatError(
                        f"line {number} of {len(lines)} is damaged: {_why(error)}",
                        where=str(self.path),
                        remedy=f"remove it and all after it to go on with the {number - 2} records "
                        "before it, or remove the file to start anew",
                    ) from error
                _LOG.warning("%s: the last record is cut off or damaged, and left out", self.path)
            else:
                self._whole += len(line)
            if number == 1:  # before records, which other work has of another kind
                self._require_same(values[0])
        self.records = values[1:]

    def _require_same(self, about: Any) -> None:
        """Refuse a file that is about something else."""
        if about != self._about:
            was = about if isinstance(about, dict) else {}
            differ = [k for k in self._about | was if was.get(k) != self._about.get(k)]
            raise FormatError(
                f"is of other work: {shortened(', '.join(differ), 60)} differ",
                where=str(self.path),
                remedy=_ANEW,
            )


def add_answers(
    done: list[Any],
    journal: Journal | None,
    executor: Workers | None,
    task: Callable[[Any], Any],
    items: Iterable[Any],
    *,
    failed: Callable[[Any], Any],
    late: Callable[[], bool],
    tell: Callable[[int], None],
) -> None:
    """Add the answers of a task to a list, each kept in a journal as soon as it is known.

    Parameters
    ----------
    done
        Answers that are known; the others are added in the order of the items.
    journal, executor
    task, items, failed, late
        As of ``WorkerPool.answers``.
    tell
        Called with the number of answers.
    """
    with WorkerPool(executor) as pool:
        for found in pool.answers(task, items, late, failed=failed):
            if found is None:  # it was stopped before it was known
                return
            done.append(found)
            if journal is not None:
                journal.add([found])
            tell(len(done))


def exactly(value: Any) -> str:
    """A value in words that are the same in every process, and others where an answer may be.

    All digits of all numbers are told, and the content of files that a text names; of a function
    its name only.
    """
    if isinstance(value, str | os.PathLike):
        text = os.fspath(value)
        named = {text, text.rpartition(",")[0], *re.split(r"[\s=]", text)}  # FILE,ductile too
        files = [digest(one) for one in sorted(named) if _is_file(one)]
        return repr((text, files)) if files else repr(text)
    if isinstance(value, list | tuple | set | frozenset):
        told = [exactly(one) for one in value]
        return f"({', '.join(told if isinstance(value, list | tuple) else sorted(told))})"
    parts = _parts(value)
    return repr(value) if parts is None else exactly(parts)


def _parts(value: Any) -> Any:
    """What a value is made of; None where its ``repr`` tells all of it."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return sorted(value.items())
    if isinstance(value, partial):
        return value.func, value.args, value.keywords
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = [getattr(value, one.name) for one in dataclasses.fields(value)]
        return type(value).__qualname__, *fields
    if callable(value):
        return getattr(value, "__qualname__", type(value).__qualname__)
    return None


def _is_file(name: str) -> bool:
    try:
        return Path(name).is_file()
    except (OSError, ValueError):  # a long text is no name
        return False


def _no_journal(path: PathLike) -> FormatError:
    return FormatError("is no journal, or its first line is damaged", where=str(path), remedy=_ANEW)


def _why(error: Exception) -> str:
    return str(error) if isinstance(error, _Damaged) else "it is no such record"


def _line(value: Any) -> bytes:
    text = json.dumps(value, separators=(",", ":")).encode("ascii")
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _value(line: bytes) -> Any:
    """The value of a line.

    Raises
    ------
    _Damaged
        It has no end, or its checksum differs.
    """
    if not line.endswith(b"\n"):
        raise _Damaged("it has no end")
    checksum, _, text = line[:-1].partition(b" ")
    if checksum != b"%08x" % zlib.crc32(text):
        raise _Damaged("its checksum differs")
    return json.loads(text)
