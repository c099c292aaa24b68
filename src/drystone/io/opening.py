"""A model, ready to be checked, from a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeAlias, TypedDict, Unpack

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import of_type
from drystone.base.display import differing, shortened
from drystone.base.errors import InputError, counted, meant
from drystone.base.progress import Progress
from drystone.base.settings import checked_call
from drystone.detection import DetectionOptions, find_overlaps
from drystone.detection.block_overlaps import overlap_lines, require_apart
from drystone.io.registry import files_at, read_file
from drystone.io.several import Paths, digest_of, is_paths, place_of
from drystone.loads import LoadCase
from drystone.model import Model, Origin, up_of_load
from drystone.supports import GroundPlane, ground_of, require_supports

UP = {
    "z": np.eye(3),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
}
"""Rotations from the vertical axis of a file to z."""

Given: TypeAlias = Model | Assembly | Paths
"""The input of an analysis: a model, an assembly, or files."""


class How(TypedDict, total=False):
    """How a model is made of an assembly or a file; see :func:`drystone.read`."""

    supports: str | Sequence[int | str] | GroundPlane | None
    friction: float | None
    density: float | None
    load: Any
    detection: DetectionOptions | None
    units: str | None
    up: str
    split: bool
    repair: bool
    search: bool
    anyway: bool
    skip_defects: bool
    layers: Sequence[str]
    hidden: bool
    thickness: float | str | None
    max_size: float | None


_FILE_ONLY = (
    "units", "up", "split", "repair", "search", "skip_defects", "layers", "hidden",
    "thickness", "max_size",
)  # fmt: skip
"""Arguments of :func:`drystone.read` that only a file has."""


@checked_call
def read(
    path: Paths,
    *,
    supports: str | Sequence[int | str] | GroundPlane | None = None,
    friction: float | None = None,
    density: float | None = None,
    load: Any = None,
    detection: DetectionOptions | None = None,
    units: str | None = None,
    up: str = "z",
    split: bool = False,
    repair: bool = False,
    search: bool = False,
    anyway: bool = False,
    skip_defects: bool = False,
    layers: Sequence[str] = (),
    hidden: bool = False,
    thickness: float | str | None = None,
    max_size: float | None = None,
    progress: Progress | None = None,
) -> Model:
    """Read a model that is ready to be checked.

    Parameters
    ----------
    path
        Its suffix determines the format. A folder, a pattern such as ``parts/*.obj`` or a list of
        files is one model, each file with one block or more that are named by it.
    supports
        Which blocks are fixed: ``lowest``, ``below:Z``, names and patterns, or a plane of
        ``ground``; see ``drystone.supports.select``. Their surfaces may be open. Heights are
        along z; if ``load`` is an acceleration, along the axis nearest to its opposite. When left
        out: the blocks that the file marks as fixed.
    friction
        Coefficient of every interface. When left out: that of the file, else 0.6.
    density : [kg/m3]
        Of every block. When left out: that of the file, else 2400.
    load
        A load case, a multiple of gravity, or an acceleration (3,) [m/s2]. When left out: the first
        load case of the file, else self-weight.
    detection
        Tolerances of the contact search.
    units
        Unit of length of the file: mm, cm, m, in or ft. When left out: the unit in the file, else
        metres.
    up
        The vertical axis of the file, ``z`` or ``y``.
    split
        Separate parts of a block become separate blocks.
    repair
        Mend broken meshes, with notes; see :func:`drystone.repair.mended_blocks`.
    search
        Search contacts even if the file has some.
    anyway
        Accept blocks that overlap by more than a tenth of the smaller one.
    skip_defects
        Leave out blocks that cannot be used, with a note.
    layers
        Names of the layers to read, including hidden ones; 3dm and DXF only. When left out: all
        visible layers.
    hidden
        Read hidden layers and objects too; 3dm and DXF only.
    thickness
        Of the blocks of a section in a DXF file: metres, or a length such as ``450mm`` (1 m).
    max_size : [MiB]
        Refuse larger files, before they are read; 64 when left out.
    progress

    Raises
    ------
    FormatError
        The file cannot be read, or something in it is wrong: file, place and remedy are named.
    InputError
        A unit, an axis or a support is not known; or two blocks overlap by more than a tenth of
        the smaller one.
    MissingDependency
        The format needs an extra.

    Examples
    --------
    >>> import tempfile
    >>> import drystone
    >>> from drystone.models import tower
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     drystone.write(tower(3), f"{folder}/tower.obj")
    ...     model = read(f"{folder}/tower.obj", supports="lowest", friction=0.7)
    >>> model.assembly.names
    ('block-0', 'block-1', 'block-2')
    """
    if not isinstance(up, str) or up not in UP:
        raise InputError(f"the axis '{up}' cannot point up", where="up", remedy="give y or z")
    of_type(anyway, bool, "anyway")
    if progress is not None:
        progress("read", 0, 2)
    contents = read_file(
        path,
        units=units,
        split=split,
        repair=repair,
        skip_defects=skip_defects,
        layers=layers,
        hidden=hidden,
        thickness=thickness,
        max_size=max_size,
        supports=supports if isinstance(supports, str) else None,
    )
    assembly, contacts, notes = contents.assembly, contents.contacts, list(contents.notes)
    if up != "z" and (contacts is not None or contents.loads):
        raise InputError(
            "the file has contacts or loads, whose axes are known",
            where=str(path),
            remedy="leave up out",
        )
    if up != "z":
        assembly = assembly.transformed(UP[up])
    cases = contents.loads
    asked = supports
    laid, supports = ground_of(assembly, supports, up_of_load(load))
    if laid is not assembly:
        if contacts is not None and not search:
            raise InputError(
                "the contacts of the file have none with the ground",
                where="supports",
                remedy="search contacts too: --find-contacts (search=True in Python)",
            )
        assembly, cases = laid, tuple(_with_one_more(case) for case in cases)
    case = load is None and density is None and bool(cases)
    load = cases[0] if case else load
    if contacts is None or search:
        if progress is not None:
            progress("contacts", 1, 2)
        model = Model.of(
            assembly,
            supports=supports,
            friction=friction,
            density=density,
            load=load,
            detection=detection,
            anyway=anyway,
        )
    else:
        assembly = assembly if density is None else assembly.with_density(density)
        contacts = contacts if friction is None else contacts.with_friction(friction)
        verb = "is" if contacts.count == 1 else "are"
        notes.append(f"the {counted(contacts.count, 'interface')} of the file {verb} used")
        overlaps = find_overlaps(assembly, detection)
        if not anyway:
            require_apart(assembly.names, overlaps)
        notes += overlap_lines(assembly.names, overlaps)
        model = Model(assembly, contacts, load)
        if supports is not None:
            model = model.with_supports(supports, up_of_load(load))
    notes += model.notes
    if case:
        notes.append(f"the load case '{cases[0].name}' of the file is used")
    given = {
        "units": units, "up": None if up == "z" else up, "supports": asked,
        "friction": friction, "density": density, "split": split, "repair": repair,
        "search": search, "anyway": anyway, "skip_defects": skip_defects, "layers": layers,
        "hidden": hidden, "thickness": thickness,
        **({} if detection is None else differing(detection)),
    }  # fmt: skip
    chosen = {name: one for name, one in given.items() if one is not None and one is not False}
    reading = {name: _told(one) for name, one in chosen.items() if one != ()}
    origin = Origin(str(place_of(path)), digest_of(files_at(path)), reading)
    return replace(model, notes=tuple(notes), cases=cases, origin=origin)


def _told(value: Any) -> str:
    return "yes" if value is True else shortened(str(value), 60)


def _with_one_more(case: LoadCase) -> LoadCase:
    """The load case of an assembly with one more block, on which nothing acts."""
    none = np.zeros((1, 6))
    motion = None if case.motion is None else np.concatenate([case.motion, none])
    return replace(case, wrench=np.concatenate([case.wrench, none]), motion=motion)


def as_model(given: Given, **how: Unpack[How]) -> Model:
    """The model for an analysis, made from an assembly or a file if necessary.

    Parameters
    ----------
    given
        A model, an assembly, meshes of other packages, or the path of a file.
    how
        Arguments of :func:`drystone.read` for a file; of :meth:`drystone.Model.of` for an assembly.
        Of a model ``load``, ``friction`` and ``supports`` can be changed.

    Raises
    ------
    InputError
        It is of another type, or ``how`` does not apply to it.
    """
    for name in how:
        if name not in How.__annotations__:
            remedy = meant(name, How.__annotations__)
            raise InputError(f"there is no argument '{name}'", remedy=remedy)
    if is_paths(given):
        return read(given, **how)
    if not isinstance(given, Model):
        _refuse(how, _FILE_ONLY, "an assembly")
        return Model.of(given, **how)  # type: ignore[misc]
    _refuse(how, (*_FILE_ONLY, "anyway", "detection", "density"), "a model")
    model = given
    if how.get("supports") is not None:
        model = model.with_supports(how["supports"])  # type: ignore[arg-type]
    if how.get("friction") is not None:
        model = model.with_friction(how["friction"])  # type: ignore[arg-type]
    return model if how.get("load") is None else model.with_load(how["load"])


def supported_model(given: Given, **how: Unpack[How]) -> Model:
    """The model for an analysis that needs supports; see :func:`as_model`.

    Raises
    ------
    InputError
        No block of a file or of an assembly is fixed, or ``supports`` fixes every block.
    """
    model = as_model(given, **how)
    where = str(place_of(given)) if is_paths(given) else ""
    chosen = how.get("supports") is not None
    if chosen or not isinstance(given, Model):
        up = up_of_load(how.get("load"))
        require_supports(model.assembly, model.joints, up=up, where=where, chosen=chosen)
    return model


def _refuse(how: How, names: Sequence[str], what: str) -> None:
    for name in names:
        if name in how:
            raise InputError(f"{what} takes no '{name}'", remedy="it is an argument of read")
