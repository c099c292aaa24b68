"""Models from the arguments of a client; of files, nothing outside its folder is read."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import Any

from drystone.base.declared import Declared, declared
from drystone.base.errors import InputError, refuse_unknown
from drystone.base.files import MIB, write_text
from drystone.io import FORMATS, read
from drystone.io.capacity_words import law_of
from drystone.model import Model
from drystone.supports import require_supports

_SUFFIXES = frozenset(
    suffix for known in FORMATS if known.reader for suffix in known.suffixes if suffix != ".txt"
)


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
        """The model file of that name.

        Raises
        ------
        InputError
            The name leads out of the folder or over a symbolic link, or there is no such file.
        """
        file = self._file(name)
        if file.suffix.lower() not in _SUFFIXES:
            known = ", ".join(sorted(_SUFFIXES))
            raise InputError("is no model file", where=name, remedy=f"its suffix is one of {known}")
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
        try:
            for part in parts:
                at = at / part
                if at.is_symlink():
                    what = "is a symbolic link, which is not followed"
                    raise InputError(what, where=name, remedy="copy the file")
            if not at.resolve().is_relative_to(self.path):  # such as by a junction
                raise InputError("is outside the folder", where=name, remedy="copy the file")
            there = at.is_file()
        except (OSError, UnicodeError):  # a name that no file can have
            there = False
        if not there:
            raise InputError("there is no such file", where=name, remedy="name one that is there")
        self.accept(at.stat().st_size, name)
        return at

    def require(self, name: str) -> None:
        """Refuse what is no file in the folder; see :meth:`model`."""
        self._file(name)

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
                if file.suffix.lower() in _SUFFIXES and not file.is_symlink():
                    yield file.relative_to(self.path).as_posix(), file.stat().st_size


@contextlib.contextmanager
def opened(subject: Mapping[str, Any], folder: Folder) -> Iterator[Path]:
    """The file of a model; errors have the name that the client gave.

    A model that is given as an object is written to a temporary file.

    Raises
    ------
    InputError
        Neither or both are given, the model is too large, or see :meth:`Folder.model`.
    """
    name, content = subject.get("file"), subject.get("content")
    if (name is None) == (content is None):
        raise InputError("names no model", where="model", remedy="give either file or content")
    if name is not None:
        folder.model(name)
        with contextlib.chdir(folder.path):
            yield Path(name)
        return
    text = json.dumps(content)
    folder.accept(len(text), "content")
    with tempfile.TemporaryDirectory() as place, contextlib.chdir(place):
        write_text("content.json", text)
        yield Path("content.json")


MODEL: Mapping[str, Declared] = {
    "file": Declared("file", str | None, None, "Name of a model file in the folder."),
    "content": Declared(
        "content",
        Mapping[str, Any] | None,
        None,
        "The model itself, as drystone JSON or COMPAS JSON, instead of a file.",
    ),
    **{
        name: one
        for name, one in declared(read).items()
        if name not in ("path", "detection", "progress", "max_size")
    },
}
"""What a client may say of a model: the arguments of :func:`drystone.read`."""


def how_of(subject: Mapping[str, Any], folder: Folder) -> dict[str, Any]:
    """The arguments of :func:`drystone.read`.

    Raises
    ------
    InputError
        One is not known, or has a value that it cannot have.
    """
    how = {}
    try:
        refuse_unknown(subject, tuple(MODEL))
        for name, given in subject.items():
            value = MODEL[name].value(given)
            if value is not None and name not in ("file", "content"):
                how[name] = value
    except InputError as error:
        raise error.located(f"model.{error.where}" if error.where else "model") from error
    capacity = law_of(str(how.get("joint_capacity", "")))[0]
    if capacity.lower().endswith(".csv"):
        folder.require(capacity)
    return how


def model_of(subject: Mapping[str, Any], folder: Folder) -> Model:
    """The model with its supports, materials and loads.

    Raises
    ------
    InputError
        Something in it cannot be used, or no block is fixed, or ``supports`` fixes all.
    """
    how = how_of(subject, folder)
    with opened(subject, folder) as path:
        model = read(path, **how)
    require_supports(model.assembly, model.joints, chosen="supports" in how)
    return model
