"""A model, ready to be checked, from a file."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, TypeAlias, Unpack, cast

import numpy as np

from drystone.assembly import Assembly
from drystone.assembly.block import require_sound
from drystone.base.arrays import Bools, Ints, texts
from drystone.base.display import differing, named, shortened
from drystone.base.errors import DrystoneError, InputError, counted, located
from drystone.base.settings import LongWork, Progress, checked_call
from drystone.base.units import coefficient
from drystone.contacts import Contacts
from drystone.detection import DetectionOptions, EdgeContacts, find_contacts, find_overlaps
from drystone.detection.face_overlaps import overlap_lines, require_apart
from drystone.detection.resample import FEW
from drystone.io.build import doubtful_density
from drystone.io.capacity_words import with_joint_capacity, with_strength
from drystone.io.draft import Contents
from drystone.io.load_options import Loads, weighed_anew
from drystone.io.registry import FileOptions, files_at, read_file
from drystone.io.several import Paths, digest_of, is_paths, place_of
from drystone.joint_capacity import DRY
from drystone.loads import LoadCase
from drystone.mesh_objects import assembly_of
from drystone.model import FlushEnds, Model, Origin, up_of_load
from drystone.supports import GroundPlane, ground_of, require_supports, select
from drystone.ties import with_tie_words, with_ties

Whole: TypeAlias = LoadCase | float | Sequence[float]
"""The whole load of a model: a load case, a multiple of gravity, or an acceleration (3,) [m/s2]."""

Load: TypeAlias = Whole | str | Mapping[str, Any] | Sequence[str | Mapping[str, Any]]
"""The whole load; or loads in words or as in our JSON, which are added to the others."""

Given: TypeAlias = Model | Assembly | Paths
"""The input of an analysis: a model, an assembly, or files."""


class How(FileOptions, total=False):
    """How a model is made of an assembly or a file; see :func:`drystone.read`."""

    supports: str | Sequence[int | str] | GroundPlane | None
    friction: float | str | None
    density: float | None
    gravity: float | str | Sequence[float] | None
    load: Load | None
    case: str | Sequence[str]
    seismic: str | float | Sequence[float] | None
    shaken: bool
    joint_capacity: str | None
    strength: str | float | None
    tie: str | Sequence[str]
    gap: float | str | None
    angle: float | None
    edges: EdgeContacts | str | None
    detection: DetectionOptions | None
    ends: FlushEnds | str | None
    anyway: bool
    only: str | Sequence[str]
    without: str | Sequence[str]
    isolate: str | Sequence[str]
    crack: str | Sequence[str]
    search: bool
    skip_defects: bool


class LongHow(How, LongWork, total=False):
    """The keywords of an analysis: how its model is made, and the work that it is."""


_OF_FILES = (*FileOptions.__annotations__, "search", "skip_defects")
"""Arguments of :func:`drystone.read` that only a file has."""
_OF_THE_SEARCH = ("anyway", "detection", "gap", "angle", "edges", "density")
"""Those that a model, whose contacts are known, does not take."""


@checked_call
def read(path: Paths, *, progress: Progress | None = None, **reading: Unpack[How]) -> Model:
    """Read a model that is ready to be checked.

    The command line, the JSON interface and the tools for programs have the same options, and so
    has every analysis that is given a file.

    Parameters
    ----------
    path
        Its suffix determines the format. A folder, a pattern such as ``parts/*.obj`` or a list of
        files is one model, each file with one block or more that are named by it.
    supports
        Fixed blocks: ``lowest``, ``below:Z``, or names and patterns, separated by commas;
        ``ground`` or ``ground:Z`` lays a plane below (those marked in the file). See
        ``drystone.supports.select``. Their surfaces may be open. Heights are along z; under another
        gravity, along the axis nearest to its opposite.
    friction : coefficient >= 0
        Friction coefficient, or angle such as ``31deg``, of all joints (the file's, else 0.6).
    density : [kg/m3] > 0, <= 1e6
        Density of all blocks (the file's, else 2400).
    gravity : [m/s2]
        Gravity: its size along -z, or a vector (9.81). Refused where the file has other loads than
        weight, unless ``case`` is ``weight``.
    load
        A load at the centroid of a block or at a point in m, added to the others: a force such as
        ``BLOCK:0,0,-500`` in N, ``BLOCK:2kN`` along gravity, a mass ``BLOCK:80kg``, a moment
        ``BLOCK:m=0,0,25`` in N m, each with ``@X,Y,Z`` or without; fill of a bridge such as
        ``fill:cover=0.3m,weight=20kN/m3``, earth behind a wall such as
        ``earth:side=-x,weight=18kN/m3,k=0.33``; or a part in JSON. Several are added up. In Python
        also the whole load: a load case, a multiple of gravity, or an acceleration (3,) [m/s2].
    case
        A load case of the file in place of the weight, such as ``1.35*dead``, or ``weight``: that
        of the blocks alone. Several are added up (the first one).
    seismic
        Horizontal forces as shares of the weight, along x and y: of blocks, fill and masses in kg.
    shaken
        Other loads that press down are weights of masses too, as of a roof: earthquakes shake them.
    joint_capacity
        What joints carry beyond friction, ``tension=0.1MPa,cohesion=0.2MPa`` or ``shear`` in Pa or
        N, ``moment`` in Nm; ``compression=5MPa`` for joints that crush; with ``ductile`` at the end
        for joints that do not break; or a table block_a,block_b,tension,cohesion,shear,compression
        in N.
    strength
        Pressure under which all joints crush: ``5MPa``, or a number in Pa in Python; left out, they
        bear any.
    tie
        A rod between the middles of two blocks, or points of them, that only pulls, with the force
        at which it yields: ``BLOCK:BLOCK:20kN``, ``BLOCK@X,Y,Z:BLOCK@X,Y,Z:20kN`` in m; without
        one it bears any. ``fill``: rods for the passive pressure of the fill of the load. Several
        are possible.
    gap
        Largest gap of a joint: a length such as ``2mm``, or a share of the size of the smaller
        block, such as ``5%`` (0.5%).
    angle : [degrees] >= 0
        Largest angle between faces that make a joint (2).
    edges
        Contacts along edges and in corners: for isolated blocks, which touch nothing else, always
        or never (isolated).
    detection
        All tolerances of the contact search.
    ends
        Ends of joints where the faces of both blocks end, while blocks are followed: the face of
        the block nearer to the supports goes on (longer), or both end as drawn (exact). Left out,
        undecided where they decide.
    anyway
        Go on where it is refused as doubtful: blocks that overlap by more than a tenth of the
        smaller one, and for a plan or scaffolding a structure that does not stand.
    only
        Blocks that are kept, by names and patterns separated by commas; the others are left out.
    without
        Blocks that are left out, by names and patterns separated by commas.
    isolate
        Blocks that are looked at alone, by names and patterns separated by commas: all others are
        fixed.
    crack
        Joints that are cut out, as open cracks that carry nothing: ``BLOCKS:BLOCKS`` of those
        between blocks by names and patterns, such as ``r00-*:r00-*`` for the head joints of a ring.
    units
        Unit of length of the file (the file's, else m).
    up
        Axis that points up in the file, z or y (y in GLB, else z).
    split
        Make a block of each separate part of a block.
    repair
        Mend broken meshes, and say what was done; see :func:`drystone.repair.mended_blocks`.
    search
        Search contacts even if the file has some.
    skip_defects
        Leave out blocks that cannot be used.
    layers
        Layers of a 3dm or DXF file to read, hidden or not (all that are visible).
    hidden
        Read hidden layers and objects of a 3dm or DXF file too.
    thickness
        Thickness of the blocks of a section in a DXF file, such as ``450mm`` (1 m).
    max_size : [MiB] > 0
        Largest file that is read (64).
    progress
        Called as ``progress(stage, done, total)``, with 0 <= done <= total.

    Raises
    ------
    FormatError
        The file cannot be read, or something in it is wrong: file, place and remedy are named.
    InputError
        An option cannot be used; it is named. Or two blocks overlap by more than a tenth of the
        smaller one.
    MissingDependency
        The format needs an extra.

    Examples
    --------
    >>> import tempfile
    >>> import drystone
    >>> from drystone.models import tower
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     drystone.write(tower(3), f"{folder}/tower.obj")
    ...     model = read(f"{folder}/tower.obj", supports="lowest", friction="35deg")
    >>> model.assembly.names
    ('block-0', 'block-1', 'block-2')
    """
    if progress is not None:
        progress("read", 0, 2)
    given: dict[str, Any] = {key: reading[key] for key in How.__annotations__ if key in reading}  # type: ignore[literal-required]
    supports, detection = reading.get("supports"), reading.get("detection")
    layer, skip = (
        supports if isinstance(supports, str) else None,
        reading.get("skip_defects", False),
    )
    of_file = {key: given[key] for key in FileOptions.__annotations__ if key in given}
    contents = read_file(path, supports=layer, skip_defects=skip, **cast(FileOptions, of_file))
    model = _model_of(contents, Loads.of(reading), _searched(reading), reading, progress)
    given |= {} if detection is None else differing(detection)
    silent = ("load", "detection", "max_size")
    told = {key: _told(one) for key, one in given.items() if key not in silent and _says(one)}
    origin = Origin(str(place_of(path)), digest_of(files_at(path)), told, contents.units)
    return replace(model, origin=origin)


def _says(value: Any) -> bool:
    """Whether an argument differs from what it is when it is left out."""
    return not (value is None or value is False or (isinstance(value, list | tuple) and not value))


def _told(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.10g}"
    return "yes" if value is True else shortened(str(value), 60)


def _model_of(
    contents: Contents,
    loads: Loads,
    detection: DetectionOptions | None,
    how: How,
    progress: Progress | None = None,
) -> Model:
    """The model of what was read, or of an assembly; see :func:`read`."""
    anyway, density = how.get("anyway", False), how.get("density")
    coefficient = _coefficient(how.get("friction"))
    contents, notes = _part_of(contents, how)
    up = up_of_load(loads.acceleration)
    stored = contents.contacts is not None and not how.get("search")
    contents, supports = _on_ground(contents, how.get("supports"), up, stored)
    assembly = contents.assembly
    if contents.contacts is not None and stored:
        dense = assembly if density is None else assembly.with_density(density)
        model = Model(dense, contents.contacts, loads.acceleration)
        model = model if coefficient is None else model.with_friction(coefficient)
        model = _as_stored(model, contents.detection, detection, anyway)
        if supports is not None:
            model = model.with_supports(supports, up)
    else:
        if progress is not None:
            progress("contacts", 1, 2)
        model = Model.of(
            assembly,
            supports=supports,
            friction=coefficient,
            density=density,
            load=loads.acceleration,
            detection=detection,
            anyway=anyway,
        )
        model = with_ties(model, contents.ties)
    model = _cracked(_isolated(model, how), how)
    notes += model.notes + doubtful_density(model.assembly)
    cases = tuple(weighed_anew(one, assembly, model.assembly) for one in contents.loads)
    total, said = loads.on(model.assembly, cases)
    return _with_joints(
        replace(model, load=total, notes=(*notes, *said), cases=cases),
        {**how, "ends": how.get("ends") or contents.ends},
    )


def _on_ground(
    contents: Contents,
    supports: str | Sequence[int | str] | GroundPlane | None,
    up: Sequence[float],
    stored: bool,
) -> tuple[Contents, str | Sequence[int | str] | None]:
    """What was read with a plane below, where the supports lay one, and the other supports."""
    laid, rest = ground_of(contents.assembly, supports, up)
    if laid is contents.assembly:
        return contents, rest
    if stored:
        raise InputError(
            "the contacts of the file have none with the ground",
            where="supports",
            remedy="search contacts too: --find-contacts (search=True in Python)",
        )
    every = np.arange(len(contents.assembly))
    loads = tuple(case.of_blocks(every, len(laid)) for case in contents.loads)
    return replace(contents, assembly=laid, loads=loads), rest


def _as_stored(
    model: Model,
    searched: DetectionOptions | None,
    detection: DetectionOptions | None,
    anyway: bool,
) -> Model:
    """The model with notes on the contacts of a file, after a look at overlaps.

    Where these were ``searched``, what the search left out is found again.
    """
    names, contacts = model.assembly.names, model.contacts
    verb = "is" if contacts.count == 1 else "are"
    used = f"the {counted(contacts.count, 'interface')} of the file {verb} used"
    model = replace(model, notes=(*model.notes, used + _facets_kept(contacts)))
    if searched is None:
        overlaps = find_overlaps(model.assembly, detection)
        model = replace(model, notes=(*model.notes, *overlap_lines(names, overlaps)))
    else:
        model = model.with_report(find_contacts(model.assembly, options=searched).report)
        overlaps = model.report.overlaps  # type: ignore[union-attr]
    if not anyway:
        require_apart(names, overlaps)
    return model


def _facets_kept(contacts: Contacts) -> str:
    """That the contact search would have taken fewer pieces, where it would."""
    if contacts.corner_count <= FEW or contacts.joints is contacts:
        return ""
    joints = counted(contacts.joints.count, "joint")
    return f", all facets of {joints}; --find-contacts (search=True) takes fewer where they curve"


def tolerances(
    detection: DetectionOptions | None = None,
    gap: float | str | None = None,
    angle: float | None = None,
    edges: EdgeContacts | str | None = None,
) -> DetectionOptions | None:
    """The tolerances of the contact search; ``None`` where none are given."""
    given = {"angle": angle, "edges": edges}
    chosen: dict[str, Any] = {name: one for name, one in given.items() if one is not None}
    if gap is None and not chosen:
        return detection
    options = replace(DetectionOptions.of(detection), **chosen)
    return options if gap is None else options.with_gap(gap)


def _searched(how: How) -> DetectionOptions | None:
    return tolerances(how.get("detection"), how.get("gap"), how.get("angle"), how.get("edges"))


def _coefficient(friction: float | str | None) -> float | None:
    if not isinstance(friction, str):
        return friction
    with located("friction"):
        return coefficient(friction)


def _with_joints(model: Model, how: How) -> Model:
    """The model with the capacities and ends of joints that are asked for."""
    words, strength, ends = how.get("joint_capacity"), how.get("strength"), how.get("ends")
    model = model if ends is None else replace(model, ends=ends)  # type: ignore[arg-type]
    model = model if words is None else with_joint_capacity(model, words)
    if strength is not None and words is not None and model.contacts.crushes.any():
        raise InputError(
            "the joints have a strength already", where="strength", remedy="leave one of both out"
        )
    model = model if strength is None else with_strength(model, strength)
    return with_tie_words(model, texts(how.get("tie", ())))


def _part_of(contents: Contents, how: How) -> tuple[Contents, list[str]]:
    """What was read, less the blocks that are left out, and its notes."""
    assembly, notes = contents.assembly, list(contents.notes)
    kept = kept_of(assembly, how.get("only", ()), how.get("without", ()))
    if len(kept) == len(assembly):
        return contents, notes
    notes.append(f"{counted(len(assembly) - len(kept), 'block')} of {len(assembly)} left out")
    contacts = contents.contacts
    return replace(
        contents,
        assembly=assembly.subset(kept.tolist()),
        contacts=None if contacts is None else contacts.of_blocks(kept, len(assembly)),
        loads=tuple(one.of_blocks(kept) for one in contents.loads),
        results=(),
    ), notes


def kept_of(
    assembly: Assembly, only: str | Sequence[str] = (), without: str | Sequence[str] = ()
) -> Ints:
    """Positions of the blocks that are not left out.

    Raises
    ------
    InputError
        A name or pattern fits no block, or no block is left.
    """
    kept = np.ones(len(assembly), dtype=bool)
    if only := texts(only):
        kept &= _named(assembly, only, "only")
    if without := texts(without):
        kept &= ~_named(assembly, without, "without")
    if not kept.any():
        raise InputError("no block is left", where="without", remedy="leave fewer blocks out")
    return np.flatnonzero(kept)


def _named(assembly: Assembly, given: Sequence[str], option: str) -> Bools:
    """The blocks (n,) that names and patterns mean."""
    with located(option):
        chosen = [select(assembly, text).fixed for text in given]
    return np.any(chosen, axis=0)


def _isolated(model: Model, how: How) -> Model:
    """The model with all blocks fixed but these.

    Source: Kao 2023, section 6.3.2, an unstable block with its neighbours as supports.
    """
    if not (blocks := texts(how.get("isolate", ()))):
        return model
    fixed = model.assembly.fixed | ~_named(model.assembly, blocks, "isolate")
    if fixed.all():
        raise InputError("it is a support", where="isolate", remedy="name a block that is free")
    free = [name for name, still in zip(model.assembly.names, fixed, strict=True) if not still]
    note = f"all blocks are fixed but {shortened(', '.join(free), 60)}"
    assembly = model.assembly.with_fixed(np.flatnonzero(fixed).tolist())
    return replace(model, assembly=assembly, notes=(*model.notes, note))


def _cracked(model: Model, how: How) -> Model:
    """The model without the joints that are cracks; no others are looked for instead."""
    if not (given := texts(how.get("crack", ()))):
        return model
    contacts, cut = model.contacts, np.zeros(model.contacts.count, dtype=bool)
    for text in given:
        first, colon, second = text.partition(":")
        if not colon:
            raise InputError(
                f"'{text}' is not BLOCKS:BLOCKS", where="crack", remedy="write a-*:b-*"
            )
        a, b = (_named(model.assembly, [one], "crack") for one in (first, second))
        of_a, of_b = contacts.block_a, contacts.block_b
        here = (a[of_a] & b[of_b]) | (a[of_b] & b[of_a])
        if not here.any():
            raise InputError(f"no joint is between '{first}' and '{second}'", where="crack")
        cut |= here
    names, each = model.assembly.names, np.flatnonzero(cut).tolist()
    pairs = {f"{names[contacts.block_a[i]]}-{names[contacts.block_b[i]]}": i for i in each}
    note = f"{counted(len(each), 'joint')} cut out as cracks, which carry nothing: "
    note += named([*pairs])
    left = model.with_contacts(contacts.select(~cut))
    return replace(left, report=None, unjoined=(), notes=(*model.notes, note))


@checked_call
def as_model(given: Given, **how: Unpack[LongHow]) -> Model:
    """The model for an analysis, made from an assembly or a file if necessary.

    Parameters
    ----------
    given
        A model, an assembly, meshes of other packages, or the path of a file.
    how
        Arguments of :func:`drystone.read`. An assembly takes all but those of files, a model those
        that need no search of contacts.

    Raises
    ------
    InputError
        It is of another type, or ``how`` does not apply to it.
    """
    if is_paths(given):
        return read(given, **how)  # type: ignore[misc]  # a clock took what read has not
    loads = Loads.of(how)
    if not isinstance(given, Model):
        _refuse(how, _OF_FILES, "an assembly")
        return _model_of(Contents(assembly_of(given)), loads, _searched(how), how)
    _refuse(how, (*_OF_FILES, *_OF_THE_SEARCH), "a model")
    require_sound(given.assembly.blocks)
    return _changed(given, loads, how) if how else given


def _changed(model: Model, loads: Loads, how: How) -> Model:
    """A model with other supports, friction or loads."""
    only, without, supports = how.get("only", ()), how.get("without", ()), how.get("supports")
    coefficient = _coefficient(how.get("friction"))
    if only or without:
        model = model.subset(kept_of(model.assembly, only, without))
    if supports is not None:
        model = model.with_supports(supports, up_of_load(loads.acceleration))  # type: ignore[arg-type]
    model = _cracked(_isolated(model, how), how)
    if coefficient is not None:
        model = model.with_friction(coefficient)
    if loads.given:
        total, notes = loads.on(model.assembly, model.cases, base=model.load)
        model = replace(model, load=total, notes=(*model.notes, *notes))
    return _with_joints(model, how)


def content_of(given: object) -> str:
    """A hash of files, or of blocks, contacts and loads; empty for others and for missing files."""
    if is_paths(given):
        return _content_at(given)
    if not isinstance(given, Model | Assembly):
        return ""
    assembly = given.assembly if isinstance(given, Model) else given
    content = hashlib.sha256(repr((assembly.names, [one.faces for one in assembly])).encode())
    arrays = [assembly.fixed, assembly.mass, *(block.vertices for block in assembly.blocks)]
    for array in arrays + (_joints_and_load(given) if isinstance(given, Model) else []):
        content.update(np.ascontiguousarray(array).tobytes())
    return content.hexdigest()


def _content_at(path: Paths) -> str:
    """A hash of files, and of what is in the meshes that scenes name; empty where it cannot be."""
    try:
        told = digest_of(files := files_at(path))
        if {one.suffix.lower() for one in files} & {".urdf", ".xml", ".mjcf"}:
            told += content_of(read_file(path).assembly)
    except (OSError, DrystoneError):  # it is refused where it is read
        return ""
    return told


def _joints_and_load(model: Model) -> list[Any]:
    """What a model has beside its blocks, as arrays."""
    known, capacity = model.contacts, model.contacts.capacity
    arrays: list[Any] = [
        *(one.wrench for one in (model.load, *model.cases)),
        np.array([one.name for one in model.cases]), np.array(model.ends or []),
        *(getattr(known, one.name) for one in fields(known) if one.name != "capacity"),
    ]  # fmt: skip
    if capacity is not None:
        arrays += [*(getattr(capacity, name) for name in DRY), np.array(capacity.brittle)]
    return arrays


def supported_model(given: Given, **how: Unpack[LongHow]) -> Model:
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
        load = Loads(how.get("gravity"), how.get("load"), how.get("case", ())).acceleration
        up = up_of_load(load)
        require_supports(model.assembly, model.joints, up=up, where=where, chosen=chosen)
    return model


def _refuse(how: How, names: Sequence[str], what: str) -> None:
    for name in names:
        if name in how:
            raise InputError(f"{what} takes no '{name}'", remedy="it is an argument of read")
