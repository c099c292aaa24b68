"""From the arguments of a command to an assembly with contacts and a load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from drystone.cli.loading import combined, loaded
from drystone.cli.options import gravity_vector, positive
from drystone.cli.waiting import Waiting
from drystone.errors import InputError, counted

if TYPE_CHECKING:
    from drystone.assembly import Assembly
    from drystone.contacts import Contacts
    from drystone.detection import ContactReport
    from drystone.loads import LoadCase


LISTED = 5
"""Blocks or pairs named in a warning."""


@dataclass(frozen=True)
class Prepared:
    """Everything that an analysis needs.

    Attributes
    ----------
    assembly
    contacts
    load
    report
        Of the contact search; ``None`` where the file brought its contacts.
    notes
        Remarks of the reader and of what was assumed here.
    cases
        The load cases of the file.
    """

    assembly: Assembly
    contacts: Contacts
    load: LoadCase
    report: ContactReport | None
    notes: tuple[str, ...]
    cases: tuple[LoadCase, ...] = ()


def prepare(
    path: str,
    waiting: Waiting,
    *,
    supports: str | None,
    friction: float | None,
    density: float | None,
    units: str | None,
    gravity: str | None,
    gap: float | None = None,
    angle: float | None = None,
    edges: str | None = None,
    find_contacts: bool = False,
    split: bool = False,
    loads: Sequence[str] | None = None,
    seismic: str | None = None,
    cases: Sequence[str] | None = None,
    moves: Sequence[str] | None = None,
    settling: bool = False,
) -> Prepared:
    """Read a model, fix its supports, find its contacts and load it with its weight and more.

    A load case of the file that moves supports is for ``settling`` only.

    Raises
    ------
    InputError
        Something in the file or in the arguments cannot be used, or nothing is fixed.
    """
    positive(density, "--density")
    direction = gravity_vector(gravity)
    if friction is not None and not 0.0 <= friction < float("inf"):
        raise InputError(
            f"is {friction}", where="--friction", remedy="give a coefficient of zero or more"
        )
    from drystone import io  # the commands start fast: work is imported when there is some

    waiting.stage("read", f"reading {path}")
    model = io.read(path, units=units, split=split)
    assembly = supported(model.assembly, supports, path)
    if density is not None:
        assembly = with_density(assembly, density)
    contacts, report = None if find_contacts else model.contacts, None
    notes = list(model.notes)
    if contacts is None:
        contacts, report = found(assembly, friction, waiting, gap, angle, edges)
        notes += warnings_of(report)
        if friction is None:
            contacts, said = with_own_friction(assembly, contacts)
            notes += said
    else:
        verb = "is" if contacts.count == 1 else "are"
        notes.append(f"the {counted(contacts.count, 'interface')} of the file {verb} used")
        contacts = contacts if friction is None else contacts.with_friction(friction)
    load = weight(assembly, direction)
    if cases:
        if direction is not None or density is not None:
            raise InputError(
                "the cases of the file have their own weight",
                where="--case",
                remedy="leave out --gravity and --density",
            )
        load = combined(cases, model.loads)
    elif model.loads and direction is None and density is None:
        load = model.loads[0]
        notes.append(f"the load case '{load.name}' of the file is used")
    load = loaded(assembly, load, loads, seismic, moves)
    if load.motion is not None and not settling:
        raise InputError(
            f"the load case '{load.name}' moves supports",
            where="--case" if cases else path,
            remedy="ask 'drystone settle', or choose --case without settlement",
        )
    notes += load.notes
    return Prepared(assembly, contacts, load, report, tuple(notes), model.loads)


def supported(assembly: Assembly, spec: str | None, path: str) -> Assembly:
    """The assembly with its supports; refused when nothing is fixed."""
    from drystone.io import supports

    if spec is not None:
        assembly = supports.select(assembly, spec)
    if not assembly.fixed.any():
        raise InputError(
            "no block is fixed",
            where=path,
            remedy="add --supports lowest, below:Z or the names of blocks",
        )
    return assembly


def with_density(assembly: Assembly, density: float) -> Assembly:
    """The same blocks, all of one density [kg/m3]."""
    from drystone.assembly import Assembly, replace_block

    blocks = tuple(replace_block(block, density=density) for block in assembly.blocks)
    return Assembly(blocks, assembly.fixed)


def found(
    assembly: Assembly,
    friction: float | None,
    waiting: Waiting,
    gap: float | None = None,
    angle: float | None = None,
    edges: str | None = None,
) -> tuple[Contacts, ContactReport]:
    """The contacts of an assembly and the report of the search.

    Raises
    ------
    InputError
        The gap is not a number between zero and one half, the angle not one between zero and 45
        degrees, or edges not one of its words.
    """
    from drystone.contacts import DEFAULT_FRICTION
    from drystone.detection import DetectionOptions, find_contacts

    waiting.stage("detect", "finding contacts")
    asked: dict[str, Any] = {"gap": gap, "angle": angle, "edges": edges}
    options = DetectionOptions(**{key: value for key, value in asked.items() if value is not None})
    detection = find_contacts(
        assembly, friction=DEFAULT_FRICTION if friction is None else friction, options=options
    )
    return detection.contacts, detection.report


def with_own_friction(assembly: Assembly, contacts: Contacts) -> tuple[Contacts, list[str]]:
    """Contacts with the friction that blocks bring from their file, of two blocks the smaller."""
    import numpy as np

    given = [block.metadata.get("friction") for block in assembly.blocks]
    own = np.array([x if isinstance(x, int | float) else np.nan for x in given], dtype=float)
    if np.isnan(own).all():
        return contacts, []
    smaller = np.fmin(own[contacts.block_a], own[contacts.block_b])
    friction = np.where(np.isnan(smaller), contacts.friction, smaller)
    return contacts.with_friction(friction), ["joints have the friction that their blocks bring"]


def warnings_of(report: ContactReport) -> list[str]:
    """What a user must hear of the contact search even when he did not ask for its report."""
    from drystone.detection.advice import millimetres  # the commands start fast

    names = report.names
    said = []
    if report.isolated:
        shown = ", ".join(f"'{names[i]}'" for i in report.isolated[:LISTED])
        more = len(report.isolated) - LISTED
        said.append(f"touching nothing: {shown}" + (f" and {more} more blocks" if more > 0 else ""))
        said += report.suggestions()
    deepest = sorted(report.penetrations, key=lambda pair: -pair.depth)
    said += [
        f"blocks '{names[pair.block_a]}' and '{names[pair.block_b]}' stand"
        f" {millimetres(pair.depth)} mm in each other"
        for pair in deepest[:LISTED]
    ]
    if len(deepest) > LISTED:
        said.append(f"and {len(deepest) - LISTED} more pairs of blocks stand in each other")
    return said


def weight(assembly: Assembly, direction: tuple[float, float, float] | None) -> LoadCase:
    """Self-weight, along ``direction`` [m/s2] with its size, else 9.81 along -z."""
    from drystone.loads import LoadCase

    if direction is None:
        return LoadCase.gravity(assembly)
    size = sum(x * x for x in direction) ** 0.5
    return LoadCase.gravity(assembly, size, direction)
