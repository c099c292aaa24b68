"""From the arguments of a command to an assembly with contacts and a load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from drystone.cli.loading import combined, loaded
from drystone.cli.options import gravity_vector, positive
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

if TYPE_CHECKING:
    from drystone.assembly import Assembly
    from drystone.detection import ContactReport, DetectionOptions
    from drystone.model import Model


LISTED = 5
"""Blocks or pairs named in a warning."""


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
    anyway: bool = False,
    loads: Sequence[str] | None = None,
    seismic: str | None = None,
    cases: Sequence[str] | None = None,
    moves: Sequence[str] | None = None,
    settling: bool = False,
) -> Model:
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

    stages = {"read": ("read", f"reading {path}"), "contacts": ("detect", "finding contacts")}
    model = io.read(
        path,
        supports=supports,
        friction=friction,
        density=density,
        load=direction,
        detection=detection_options(gap, angle, edges),
        units=units,
        split=split,
        search=find_contacts,
        anyway=anyway,
        progress=lambda stage, *_: waiting.stage(*stages[stage]),
    )
    assembly = model.assembly
    require_support(assembly, path)
    notes = list(model.notes)
    notes += [] if model.report is None else warnings_of(model.report)
    load = model.load
    if cases:
        if direction is not None or density is not None:
            raise InputError(
                "the cases of the file have their own weight",
                where="--case",
                remedy="leave out --gravity and --density",
            )
        load = combined(cases, model.cases)
        notes = [note for note in notes if not note.startswith("the load case")]
    load = loaded(assembly, load, loads, seismic, moves)
    if load.motion is not None and not settling:
        raise InputError(
            f"the load case '{load.name}' moves supports",
            where="--case" if cases else path,
            remedy="ask 'drystone settle', or choose --case without settlement",
        )
    notes += load.notes
    return replace(model, load=load, notes=tuple(notes))


def require_support(assembly: Assembly, path: str) -> None:
    """Raise InputError where nothing is fixed."""
    if not assembly.fixed.any():
        raise InputError(
            "no block is fixed",
            where=path,
            remedy="add --supports lowest, below:Z or the names of blocks",
        )


def warnings_of(report: ContactReport) -> list[str]:
    """What a user must hear of the contact search even when he did not ask for its report."""
    names = report.names
    said = []
    if report.isolated:
        shown = ", ".join(f"'{names[i]}'" for i in report.isolated[:LISTED])
        more = len(report.isolated) - LISTED
        said.append(f"touching nothing: {shown}" + (f" and {more} more blocks" if more > 0 else ""))
        said += report.suggestions()
    return said


def detection_options(
    gap: float | None = None, angle: float | None = None, edges: str | None = None
) -> DetectionOptions:
    """The tolerances of the contact search, from those options that were given.

    Raises
    ------
    InputError
        The gap is not a number between zero and one half, the angle not one between zero and 45
        degrees, or edges not one of its words.
    """
    from drystone.detection import DetectionOptions

    asked: dict[str, Any] = {"gap": gap, "angle": angle, "edges": edges}
    return DetectionOptions(**{key: value for key, value in asked.items() if value is not None})
