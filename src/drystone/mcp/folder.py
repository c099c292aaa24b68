"""The folder of the models of a client: nothing outside it is read."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePath

from drystone.base.errors import InputError
from drystone.io import FORMATS, jsontext

SUFFIXES = frozenset(suffix for known in FORMATS if known.read for suffix in known.suffixes)
MIB = 2**20


@dataclass(frozen=True)
class Folder:
    """A folder of models.

    Attributes
    ----------
    path
        Absolute, without symbolic links.
    largest : [bytes]
        Of a file, or of a model that is given as text.
    """

    path: Path
    largest: int

    @classmethod
    def of(cls, path: str | Path, largest_mib: float) -> Folder:
        """The folder at a path.

        Raises
        ------
        InputError
            There is no such folder.
        """
        folder = Path(path)
        if not folder.is_dir():
            raise InputError("there is no such folder", where=str(path), remedy="make it first")
        return cls(folder.resolve(), int(largest_mib * MIB))

    def model(self, name: str) -> Path:
        """The model file of that name; files that it refers to are in the folder too.

        Raises
        ------
        InputError
            The name leads out of the folder or over a symbolic link, or there is no such file.
        """
        file = self._file(name)
        if file.suffix.lower() not in SUFFIXES:
            known = ", ".join(sorted(SUFFIXES))
            raise InputError("is no model file", where=name, remedy=f"its suffix is one of {known}")
        if file.suffix.lower() == ".json" and b'"arrays"' in (data := file.read_bytes()):
            top = jsontext.parse(data, Path(name))
            if top.has("arrays"):
                self._file(str(PurePath(name).parent / top["arrays"]["file"].text()))
        return file

    def _file(self, name: str) -> Path:
        parts = PurePath(name).parts
        if PurePath(name).anchor or ".." in parts or "\0" in name or not parts:
            raise InputError(
                "is no name of a file in the folder",
                where=name,
                remedy="give a path relative to it, without '..'",
            )
        at = self.path
        for part in parts:
            at = at / part
            if at.is_symlink():
                raise InputError(
                    "is a symbolic link, which is not followed", where=name, remedy="copy the file"
                )
        if not at.resolve().is_relative_to(self.path):  # such as by a junction
            raise InputError("is outside the folder", where=name, remedy="copy the file")
        if not at.is_file():
            raise InputError("there is no such file", where=name, remedy="name one that is there")
        self.accept(at.stat().st_size, name)
        return at

    def accept(self, size: int, where: str) -> None:
        """Raise InputError where a model [bytes] is too large."""
        if size > self.largest:
            raise InputError(
                f"holds {size / MIB:.2g} MiB, more than the {self.largest / MIB:.2g} MiB allowed",
                where=where,
                remedy="give a smaller model, or start the server with a larger --size-limit",
            )

    def files(self) -> Iterator[tuple[str, int]]:
        """Names, with ``/`` between folders, and sizes [bytes] of all model files."""
        for place, folders, names in os.walk(self.path):
            folders[:] = sorted(name for name in folders if not name.startswith("."))
            for name in sorted(names):
                file = Path(place) / name
                if file.suffix.lower() in SUFFIXES and not file.is_symlink():
                    yield file.relative_to(self.path).as_posix(), file.stat().st_size
