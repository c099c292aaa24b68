"""Reading and writing: the format of a file by its suffix."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypedDict, Unpack

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import cross, lengths, number, texts
from drystone.base.display import OneLine
from drystone.base.errors import FormatError, InputError, one_line_errors, require
from drystone.base.files import PathLike, as_path, is_there, read_bytes
from drystone.base.settings import checked_call
from drystone.base.units import length, scale_of
from drystone.io.build import Built, build, try_blocks
from drystone.io.draft import Contents, Draft
from drystone.io.several import Paths, files_of, left_notes, place_of, together
from drystone.model import Model
from drystone.results import Result
from drystone.ties import strengths, ties_told


@dataclass(frozen=True)
class Format(OneLine):
    """A file format. Its modules are imported when a file is read or written.

    Attributes
    ----------
    name
        Identifier.
    title
        Name for display.
    suffixes
        Lower case, with the dot.
    reader
        Module of ``drystone.io`` whose ``read(data, path)`` makes a draft from the bytes of a file;
        the path serves errors and files in the same folder. Empty if the format is only written.
    writer
        Module whose ``write(contents, path)`` writes a file, or another function of it after a
        dot. Empty if the format is only read.
    loses
        The parts of a model that the format cannot hold, as text; empty if it holds everything.
    any_unit
        Whether lengths may be written in another unit than metres.
    options
        What ``read`` takes further: ``layers`` and ``hidden``, or ``thickness`` and ``units``.
    up
        The axis taken to point up in its files, where these do not say it or many have another;
        empty where readers turn what files say.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    reader: str = ""
    writer: str = ""
    loses: str = ""
    any_unit: bool = False
    options: tuple[str, ...] = ()
    up: str = ""

    @property
    def read(self) -> Callable[..., Draft]:
        """The function that reads a file."""
        return _function(self.reader, "read")

    @property
    def write(self) -> Callable[[Contents, Path], None]:
        """The function that writes a file."""
        return _function(self.writer, "write")


def _function(place: str, usual: str) -> Callable[..., Any]:
    module, _, function = place.partition(".")
    return getattr(import_module(f"drystone.io.{module}"), function or usual)


_LAYERED = ("layers", "hidden")
_LOADS = "loads and results"
_CONTACTS = f"contacts, ties, joint capacities, {_LOADS}"
_MATERIAL = f"supports, densities, metadata, {_CONTACTS}"
_SIMULATED = "ties, joint capacities, results, loads but for gravity"
_SINGLE = "digits beyond single precision, polygons that are not plane"
_COMPAS = f"friction, joint capacities, metadata, {_LOADS} but for forces"
FORMATS: tuple[Format, ...] = (
    Format("drystone", "drystone JSON", (".json",), "json_files", "json_files"),
    Format(
        "compas-assembly",
        "COMPAS JSON, compas_assembly",
        (".json",),
        "json_files",
        "json_files.write_assembly",
        _COMPAS,
    ),
    Format(
        "compas-dem",
        "COMPAS JSON, compas_dem",
        (".json",),
        "json_files",
        "json_files.write_block_model",
        _COMPAS,
    ),
    Format("obj", "Wavefront OBJ", (".obj",), "obj", "obj", _MATERIAL, True, up="z"),
    Format("stl", "STL", (".stl",), "stl", "stl", f"polygons, {_MATERIAL}", True, up="z"),
    Format("ply", "PLY", (".ply",), "ply", "ply", _CONTACTS, True, up="z"),
    Format(
        "3dm",
        "Rhino 3dm",
        (".3dm",),
        "rhino",
        "rhino",
        f"joint capacities, contacts, limits of ties and places away from centroids, {_LOADS}",
        any_unit=True,
        options=_LAYERED,
    ),
    Format("dxf", "DXF", (".dxf",), "dxf", options=(*_LAYERED, "thickness", "units")),
    Format("dae", "COLLADA", (".dae",), "dae"),
    Format("step", "STEP", (".step", ".stp"), "step"),
    Format("ifc", "IFC", (".ifc",), "ifc"),
    Format("usd", "USD", (".usd", ".usda", ".usdc", ".usdz"), "usd"),
    Format("bricks", "stud-and-tube bricks", (".bricks", ".txt"), "bricks"),
    Format("ldraw", "LDraw", (".ldr", ".mpd"), "ldraw"),
    Format(
        "mjcf",
        "MJCF, for MuJoCo",
        (".xml", ".mjcf"),
        "mjcf",
        "mjcf",
        loses=f"friction of single joints, {_SIMULATED}",
    ),
    Format(
        "urdf",
        "URDF, with meshes",
        (".urdf",),
        "urdf",
        "urdf",
        loses="friction, ties, joint capacities, loads, results",
    ),
    Format(
        "glb",
        "glTF 2.0, binary",
        (".glb",),
        "glb",
        "glb",
        f"{_SINGLE}, {_CONTACTS}",
        up="y",
    ),
)
"""In order of preference where several formats share a suffix."""


def format_of(path: PathLike, name: str | None = None, *, writing: bool = False) -> Format:
    """The format with this name, else the first with the suffix of ``path``.

    Where there is none, the error names the suffixes that can be read, or written.

    Parameters
    ----------
    path
        Its suffix counts, in capitals or not.
    name
        Of a format; left out, the suffix decides.
    writing
        Whether the error names the suffixes that can be written.

    Raises
    ------
    FormatError
        There is none.
    """
    suffix = as_path(path).suffix.lower()
    for known in FORMATS:
        if suffix in known.suffixes if name is None else known.name == name:
            return known
    if name is not None:
        names = ", ".join(f.name for f in FORMATS)
        raise FormatError(f"format '{name}' is not known", remedy=f"use one of {names}")
    raise _unknown(path, suffix, writing)


def _unknown(path: PathLike, suffix: str, writing: bool) -> FormatError:
    """Why no format has the suffix of a file."""
    if not writing and not suffix and not is_there(path):
        what = "there is no such file or folder"
        return FormatError(what, where=str(path), remedy="check the path")
    suffixes = ", ".join(_suffixes("writer" if writing else "reader"))
    has = f"suffix '{suffix}' is not known" if suffix else "the name has no suffix"
    one_file = "save it as .glb, which is glTF in one file; " if suffix == ".gltf" else ""
    return FormatError(has, where=str(path), remedy=f"{one_file}these are: {suffixes}")


Unit: TypeAlias = Literal["mm", "cm", "m", "in", "ft"]


class FileOptions(TypedDict, total=False):
    """What of a file is read, and how; see :func:`drystone.read`.

    Attributes
    ----------
    units, layers, hidden, thickness, split, repair, up
        As in :func:`drystone.read`.
    max_size : [MiB]
        Refuse larger files, before they are read; 64 when left out.
    """

    units: Unit | None
    layers: Sequence[str]
    hidden: bool
    thickness: float | str | None
    max_size: float | None
    split: bool
    repair: bool
    up: Literal["z", "y"] | None


def files_at(path: Paths) -> tuple[Path, ...]:
    """The files that a path stands for: itself, those of a folder, or those of a pattern.

    Parameters
    ----------
    path
        A file, a folder, a pattern such as ``parts/*.obj``, or a list of files.
    """
    return tuple(_files_at(path)[0])


def _files_at(path: Paths) -> tuple[list[Path], list[Path]]:
    known = [one for one in _suffixes("reader") if one != ".txt"]  # notes beside the models
    return files_of(path, known)


def _suffixes(able: str) -> list[str]:
    """Suffixes of the formats that have a reader, or a writer."""
    return sorted({suffix for one in FORMATS if getattr(one, able) for suffix in one.suffixes})


@checked_call
def read_file(
    path: Paths,
    *,
    supports: str | None = None,
    skip_defects: bool = False,
    **how: Unpack[FileOptions],
) -> Contents:
    """Read the content of a file, with its contacts if it has some.

    Parameters
    ----------
    path
        Its suffix determines the format. A folder, a pattern such as ``parts/*.obj`` or a list of
        files is one model, each file with one block or more that are named by it.
    supports
        Which blocks will be fixed, as text: only these may be open surfaces. When left out, those
        that the file marks as fixed.
    skip_defects
        Leave out blocks that cannot be used.
    how
        See :class:`FileOptions`.

    Raises
    ------
    FormatError
        The file cannot be read, or something in it is wrong: file, place and remedy are named.
    InputError
        The unit is not known.
    MissingDependency
        The format needs an extra.

    Examples
    --------
    >>> import tempfile
    >>> from drystone.models import tower
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write(tower(3), f"{folder}/tower.json")
    ...     contents = read_file(f"{folder}/tower.json")
    >>> contents.assembly.names
    ('block-0', 'block-1', 'block-2')
    """
    with one_line_errors():
        draft, units, rest = _draft(path, **how)
        place = place_of(path)
        return build(draft, place, units, supports=supports, skip_defects=skip_defects, **rest)


@checked_call
def inspect(path: Paths, *, supports: str | None = None, **how: Unpack[FileOptions]) -> Built:
    """Read the usable blocks, and every defect of the others; see :func:`read_file`.

    Parameters
    ----------
    path
        As in :func:`read_file`.
    supports
        Which blocks will be fixed, as text; left out, those that the file marks as fixed.
    """
    with one_line_errors():
        draft, units, rest = _draft(path, **how)
        built = try_blocks(draft, place_of(path), units, supports=supports, **rest)
        return replace(built, notes=(*built.notes, *_tie_notes(draft, built, units)))


def _tie_notes(draft: Draft, built: Built, units: str | None) -> list[str]:
    """The ties of a file; those of its contacts where all its blocks can be used."""
    ties = {":".join(pair): float("inf") for pair in draft.ties}
    if draft.finish is not None and built.assembly is not None:
        with suppress(InputError):  # 'check' tells what is wrong with them
            contacts, *_ = draft.finish(built.assembly, scale_of(units or draft.units or "m"))
            ties |= {} if contacts is None else strengths(built.assembly, contacts)
    return [f"ties of the file: {ties_told(ties)}"] if ties else []


def _draft(
    path: Paths,
    *,
    units: str | None = None,
    layers: Sequence[str] = (),
    hidden: bool = False,
    thickness: float | str | None = None,
    max_size: float | None = None,
    up: str | None = None,
    **rest: Any,
) -> tuple[Draft, str | None, dict[str, Any]]:
    """The draft of a file, or of several together; its unit if it is not that; other options."""
    if units is not None:
        scale_of(units)
    asked: dict[str, Any] = {"layers": texts(layers), "hidden": hidden}
    if thickness is not None:
        told = length(thickness, "thickness") if isinstance(thickness, str) else thickness
        asked["thickness"] = number(told, "thickness")
        if not asked["thickness"] > 0.0:
            raise InputError(f"a thickness of {thickness} m", remedy="give metres above zero")
    asked = {name: one for name, one in asked.items() if one}
    files, left = _files_at(path)
    drafts = [(file, _draft_of(file, units, max_size, up, asked)) for file in files]
    draft = drafts[0][1] if len(drafts) == 1 else together(drafts, units)
    draft = replace(draft, notes=(*draft.notes, *left_notes(left)))
    return draft, units, rest


def _draft_of(
    path: Path,
    units: str | None,
    max_size: float | None,
    up: str | None,
    asked: Mapping[str, Any],
) -> Draft:
    chosen = format_of(path)
    if not chosen.reader:
        raise FormatError(f"{chosen.title} can be written but not read", where=str(path))
    for name in asked:
        if name not in chosen.options:
            what = "no thickness to choose" if name == "thickness" else "no layers"
            raise FormatError(f"{chosen.title} has {what}", where=str(path), remedy="leave it out")
    options = {**asked, **({"units": units} if "units" in chosen.options else {})}
    largest = (
        None if max_size is None else int(2**20 * np.clip(number(max_size, "max_size"), 0.0, 1e12))
    )
    data = read_bytes(path, largest)
    try:
        draft = replace(chosen.read(data, Path(path), **options), up=up or chosen.up or "z")
    except (RecursionError, MemoryError) as error:
        raise FormatError(
            "reading the file would take more memory than any model needs", where=str(path)
        ) from error
    if not draft.shapes:
        raise FormatError("holds no block", where=str(path), remedy="export the blocks as meshes")
    return draft


@checked_call
def write(
    model: Model | Assembly | Result | Contents,
    path: PathLike,
    *,
    format: str | None = None,
    units: Unit | str = "m",
) -> None:
    """Write a model, an assembly alone, or a result with its model.

    Parameters
    ----------
    model
    path
        Its suffix determines the format, unless ``format`` is given. An existing file is replaced
        when the new one is complete.
    format
        Name of the format, for suffixes of several formats.
    units
        Unit of lengths in obj, stl, ply and 3dm; other formats have metres.

    Raises
    ------
    FormatError
        No format has the suffix, it cannot hold the model, or the folder cannot be written.
    InputError
        The unit is not known.
    """
    chosen = writable(path, format)
    contents, scale = contents_of(model), scale_of(units)
    contents = replace(contents, ties=kept_ties(contents), units="m")
    if chosen.any_unit and units != "m":
        scaled = contents.assembly.transformed(np.eye(3) / scale)
        contents = Contents(scaled, ties=contents.ties, units=units)
    chosen.write(contents, Path(path))


def writable(path: PathLike, format: str | None = None) -> Format:
    """The format that :func:`write` takes.

    Raises
    ------
    FormatError
        There is none, or it is only read.
    MissingDependency
        It needs an extra.
    """
    chosen = format_of(path, format, writing=True)
    if not chosen.writer:
        raise FormatError(f"{chosen.title} can be read but not written", where=str(path))
    if chosen.name == "3dm":
        require("rhino3dm", "cad", "writing 3dm")
    return chosen


def kept_ties(contents: Contents) -> tuple[tuple[str, str], ...]:
    """The names of the blocks of ties that these alone describe, the one that is pulled first.

    They bear any pull, between the centroids.
    """
    contacts, names, middle = contents.contacts, contents.assembly.names, contents.assembly.centroid
    if contacts is None:
        return contents.ties
    bars = contacts.select(contacts.ties & np.isinf(contacts.tie_strength))
    far = middle[bars.block_a] - middle[bars.block_b]
    off = lengths(bars.centroid - middle[bars.block_b]) + lengths(cross(far, bars.frame[:, 0]))
    some = np.flatnonzero(off <= 1e-6 * lengths(far)).tolist()
    own = tuple((names[bars.block_b[k]], names[bars.block_a[k]]) for k in some)
    return (*contents.ties, *own)


def contents_of(model: Model | Assembly | Result | Contents) -> Contents:
    """The content to write for a model, an assembly or a result."""
    if isinstance(model, Contents):
        return model
    if isinstance(model, Model):
        loads = (model.load, *(case for case in model.cases if case is not model.load))
        return Contents(
            model.assembly, model.contacts, loads, notes=model.notes, ends=model.ends,
            detection=model.detection,
        )  # fmt: skip
    if isinstance(model, Result):
        return Contents(
            model.assembly, model.contacts, (model.load,), (model,), ends=model.model.ends,
            detection=model.model.detection,
        )  # fmt: skip
    if isinstance(model, Assembly):
        return Contents(model)
    raise InputError(
        f"a value of type {type(model).__name__} cannot be written",
        remedy="give a Model, Assembly or Result",
    )
