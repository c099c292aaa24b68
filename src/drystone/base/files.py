"""Files on disk: bounded reading, and writing without incomplete files."""

from __future__ import annotations

import codecs
import contextlib
import errno
import hashlib
import io
import os
import shutil
import tempfile
import time
import tomllib
import zlib
from collections.abc import Callable, Iterator, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

from drystone.base.errors import FormatError, InputError, quoted

PathLike: TypeAlias = str | os.PathLike[str]
Job: TypeAlias = tuple[PathLike, Callable[[Path], object]]
"""A file to be written, and what writes it to the path it is given."""

MIB = 2**20
LARGEST_FILE = 64 * MIB
"""[bytes], chosen: 64 MiB holds about a million faces in any of the formats; any content is read or
refused within some ten seconds."""

_HIDDEN = ".drystone-"
_LEFT_S = 3600.0
"""[s] after which a hidden folder of another machine is one that was left; chosen: no file takes
that long."""


def read_bytes(path: PathLike, largest: int | None = None, anew: str = "export it again") -> bytes:
    """The whole of a file.

    Parameters
    ----------
    path
    largest : [bytes]
        :data:`LARGEST_FILE` when left out.
    anew
        What to do where it is empty, or holds zeros only.

    Raises
    ------
    FormatError
        Missing, a folder, no plain file, empty, an archive, not readable, or too large.
    """
    largest = LARGEST_FILE if largest is None else largest
    file = Path(path)
    try:
        if file.is_dir():
            raise FormatError("is a folder", where=str(file), remedy="name a model file")
        if not file.exists():
            raise FormatError("there is no such file", where=str(file), remedy="check the path")
        if not file.is_file():
            raise FormatError("is not a plain file", where=str(file), remedy="name a model file")
        size = file.stat().st_size
        if size > largest:
            raise FormatError(
                f"holds {size / MIB:.3g} MiB, more than the {largest / MIB:.3g} MiB allowed",
                where=str(file),
                remedy="split the model, thin out its meshes, or allow more (--max-size)",
            )
        with file.open("rb") as opened:
            most = min(largest, max(size, MIB))
            data = opened.read(most + 1)
        if len(data) > most:  # it grows while it is read, or lies about its size
            raise FormatError("is larger than it says", where=str(file), remedy="try again")
    except (OSError, ValueError) as error:
        if isinstance(error, FormatError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise FormatError(
            f"cannot be read: {reason}", where=str(file), remedy="check its path and permissions"
        ) from error
    if not data.strip(b" \t\r\n\x00"):
        raise FormatError("the file is empty", where=str(file), remedy=anew)
    if data.startswith(b"PK\x03\x04") and file.suffix.lower() != ".usdz":
        raise FormatError("is a zip archive", where=str(file), remedy="unpack it")
    return data


def digest(path: PathLike) -> str:
    """The SHA-256 of a file, in hexadecimal digits."""
    with as_path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def decode(data: bytes, path: PathLike) -> str:
    """Text of a file in UTF-8, with or without a byte order mark.

    Raises
    ------
    FormatError
        Not UTF-8.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        what, remedy = f"byte {error.start} is not UTF-8 text", "save it as UTF-8 text"
        if b"\0" in data and data[:2] not in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
            what, remedy = "is binary, no text", "name it by its format, or export it again"
        raise FormatError(what, where=str(path), remedy=remedy) from error


def toml_of(data: bytes, path: PathLike, deepest: int = 100) -> dict[str, Any]:
    """The top-level table of a TOML file.

    Parameters
    ----------
    data, path
    deepest
        Dots of a line. A key of 8,000 parts takes 264 MB, one of twice as many four times that.

    Raises
    ------
    FormatError
        Not TOML (the line is named), or it takes too much to be read.
    """
    text = decode(data, path)
    try:
        if len(data) > MIB or max(line.count(".") for line in lines_of(text)) > deepest:
            raise RecursionError
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FormatError(f"is not TOML: {error}", where=str(path)) from error
    except (ValueError, RecursionError) as error:
        deep = isinstance(error, RecursionError)
        what = "it is larger than 1 MiB or nested too deeply" if deep else "a number has no end"
        raise FormatError(f"is no TOML that can be used: {what}", where=str(path)) from error


def shipped(file: str) -> str:
    """The text of a file of this package, such as ``view/static/page.html``."""
    return resources.files("drystone").joinpath(file).read_text("utf-8")


def lines_of(text: str) -> Iterator[str]:
    """Lines of a text, without their ends, one at a time: a file may be nothing but line ends."""
    for line in io.StringIO(text, newline=None):
        yield line[:-1] if line.endswith("\n") else line


def as_path(path: PathLike) -> Path:
    """The path, where it is one.

    Raises
    ------
    FormatError
        It is none.
    """
    try:
        return Path(path)
    except TypeError as error:
        told = quoted(path)
        raise FormatError(f"the path is {told}", remedy="give a string or a Path") from error


def is_there(path: PathLike) -> bool:
    """Whether a file or folder has this name; none has one that is too long."""
    try:
        return as_path(path).exists()
    except OSError:
        return False


def plain_target(path: PathLike) -> Path:
    """The path of a file to write: the target of a symbolic link, else the path.

    Raises
    ------
    FormatError
        A folder, a device, a pipe, or a link that leads nowhere.
    """
    named = as_path(path)
    try:
        named.lstat()
    except (FileNotFoundError, NotADirectoryError):
        return named
    except OSError as error:
        raise unwritable(named, error) from error
    except ValueError as error:  # a null byte, or half of a surrogate pair
        what = "is no name of a file"
        raise FormatError(what, where=str(path), remedy="choose another name") from error
    target = Path(os.path.realpath(named)) if named.is_symlink() else named
    if target.is_symlink() or (target.exists() and not target.is_file()):
        taken = "is a folder" if target.is_dir() else "is not a plain file"
        raise FormatError(taken, where=str(path), remedy="choose another name")
    return target


def same_place(path: PathLike) -> str:
    """The common path of two names of one file; a loop of links stays a separate path."""
    return os.path.realpath(as_path(path))


def write_whole(path: PathLike, fill: Callable[[BinaryIO], None]) -> None:
    """Let ``fill`` write a temporary file in the same folder, then rename it.

    Whatever interrupts ``fill``, an existing file stays as it was and no other file remains.

    Raises
    ------
    FormatError
        The folder does not exist or cannot be written.
    """
    target = plain_target(path)
    try:
        with _hidden_in(target.parent) as folder:
            temporary = folder / target.name
            with temporary.open("xb") as file:
                fill(file)
            temporary.chmod(_mode(target))
            temporary.replace(target)
    except (OSError, ValueError) as error:
        if isinstance(error, FormatError):
            raise
        raise unwritable(target, error) from error


def write_together(jobs: Sequence[Job], *, into: PathLike | None = None) -> list[str]:
    """Let every job write its file under a temporary name, then rename all of them.

    What goes wrong while they are written leaves the files of that name as they were, all of them.

    Parameters
    ----------
    jobs
        Each a path, and what writes one file to the path it is given: beside the other and with
        the same suffix.
    into
        A folder that is made for them where there is none. It goes again where they cannot be
        written.

    Returns
    -------
    list of str
        The names.

    Raises
    ------
    FormatError
        A folder does not exist or cannot be written, or two jobs have one file.
    """
    if into is not None and not as_path(into).exists():
        folder = _made_folder(into)
        try:
            return write_together(jobs)
        except BaseException:
            with contextlib.suppress(OSError):
                folder.rmdir()
            raise
    done: list[tuple[Path, Path]] = []
    hidden: dict[Path, Path] = {}
    with contextlib.ExitStack() as folders:
        for path, write in jobs:
            target = plain_target(path)
            if target in [other for other, _ in done]:
                raise FormatError("is named twice", where=str(path), remedy="choose another name")
            with _told_at(target):
                if target.parent not in hidden:
                    hidden[target.parent] = folders.enter_context(_hidden_in(target.parent))
                temporary = hidden[target.parent] / target.name
                write(temporary)
                temporary.chmod(_mode(target))
            done.append((target, temporary))
        for target, temporary in done:
            with _told_at(target):
                temporary.replace(target)
    return [str(path) for path, _ in jobs]


@contextlib.contextmanager
def _told_at(target: Path) -> Iterator[None]:
    """Name the file where it cannot be written."""
    try:
        yield
    except FormatError as error:
        raise error.located(str(target)) from error
    except InputError:  # of what is written, not of the place
        raise
    except (OSError, ValueError) as error:
        raise unwritable(target, error) from error


def _made_folder(path: PathLike) -> Path:
    """A folder to write into, made with those above it where there is none.

    Raises
    ------
    FormatError
        It cannot be made.
    """
    folder = as_path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise unwritable(folder, error) from error
    return folder


def write_bytes(path: PathLike, data: bytes) -> None:
    """Write a whole file, or nothing; see :func:`write_whole`."""

    def fill(file: BinaryIO) -> None:
        file.write(data)

    write_whole(path, fill)


def write_text(path: PathLike, text: str) -> None:
    """Write a whole text as UTF-8, or nothing; see :func:`write_whole` and :func:`utf8`."""
    write_bytes(path, utf8(text))


def utf8(text: str) -> bytes:
    """A text as UTF-8. Half of a surrogate pair, which is no letter, becomes its escape in JSON."""
    return text.encode("utf-8", "backslashreplace")


@contextlib.contextmanager
def _hidden_in(folder: Path) -> Iterator[Path]:
    """A hidden folder in another one. Those that killed processes left there are removed."""
    for other in folder.glob(f"{_HIDDEN}*"):
        with contextlib.suppress(OSError):
            if _was_left(other):
                shutil.rmtree(other, ignore_errors=True)
    prefix = f"{_HIDDEN}{_machine()}-{os.getpid()}-"
    with tempfile.TemporaryDirectory(prefix=prefix, dir=folder) as made:
        yield Path(made)


def _machine() -> str:
    """The name of this machine in eight letters; none on Windows, which has no harmless signal."""
    return f"{zlib.crc32(os.uname().nodename.encode()):08x}" if hasattr(os, "uname") else ""


def _was_left(folder: Path) -> bool:
    """Whether the process that made a hidden folder has ended, as far as can be known."""
    machine, _, rest = folder.name.removeprefix(_HIDDEN).partition("-")
    process = rest.partition("-")[0]
    if machine and machine == _machine() and process.isdecimal():
        try:
            os.kill(int(process), 0)
        except (ProcessLookupError, OverflowError):  # no process has a number that large
            return True
        except PermissionError:  # it is of somebody else
            return False
    return time.time() - folder.stat().st_mtime > _LEFT_S


def _mode(target: Path) -> int:
    """Permissions of the replaced file, else those of a new file."""
    if target.exists():
        return target.stat().st_mode & 0o777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def unwritable(target: Path, error: Exception) -> FormatError:
    """What to raise where writing failed; a full disk is told as one."""
    reason = getattr(error, "strerror", None) or str(error)
    remedies = {
        errno.ENOSPC: "free some space, or choose another disk",
        errno.ENAMETOOLONG: "choose a shorter name",
        errno.EFBIG: "write to another disk, or raise the limit of sizes (ulimit -f)",
    }
    other = "choose a folder that exists and that you may write to"
    remedy = remedies.get(getattr(error, "errno", None) or 0, other)
    return FormatError(f"cannot be written: {reason}", where=str(target), remedy=remedy)
