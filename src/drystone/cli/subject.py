"""The model that a command is about: read, supported, in contact and loaded."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from drystone.cli import loading, options
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

if TYPE_CHECKING:
    from drystone.detection import ContactReport, DetectionOptions
    from drystone.model import Model

PAIRS = 5
"""Blocks or pairs named in a remark."""


@dataclass(frozen=True)
class Tolerances:
    """Within what contacts are found."""

    gap: options.Gap = None
    angle: options.Angle = None
    edges: options.Edges = None

    def options(self) -> DetectionOptions:
        """The tolerances of the contact search, from those options that were given."""
        from drystone.detection import DetectionOptions

        asked: dict[str, Any] = {"gap": self.gap, "angle": self.angle, "edges": self.edges}
        return DetectionOptions(**{key: value for key, value in asked.items() if value is not None})


@dataclass(frozen=True)
class Finding(Tolerances):
    """How the contacts of a model are found."""

    find_contacts: options.FindContacts = False
    anyway: options.Anyway = False


@dataclass(frozen=True)
class Subject:
    """The model that is analysed, its supports and materials, and its loads but for earthquakes."""

    model: options.ModelArgument
    supports: options.Supports = None
    friction: options.Friction = None
    density: options.Density = None
    units: options.Units = None
    split: options.Split = False
    gravity: options.Gravity = None
    load: loading.Loads = ()
    case: loading.Cases = ()

    def prepared(
        self,
        waiting: Waiting,
        finding: Finding | None = None,
        seismic: str | None = None,
        moves: tuple[str, ...] = (),
        settling: bool = False,
    ) -> Model:
        """Read the model, fix its supports, find its contacts, load it with its weight and more.

        A load case of the file that moves supports is for ``settling`` only.

        Raises
        ------
        InputError
            Something in the file or in the options cannot be used, or nothing is fixed.
        """
        finding = Finding() if finding is None else finding
        from drystone import io  # the commands start fast: work is imported when there is some

        stages = {"read": ("read", f"reading {self.model}"), "contacts": ("detect", "contacts")}
        model = io.read(
            self.model,
            supports=self.supports,
            friction=self.friction,
            density=self.density,
            load=1.0 if self.case else self.gravity,  # the cases replace it
            detection=finding.options(),
            units=self.units,
            split=self.split,
            search=finding.find_contacts,
            anyway=finding.anyway,
            progress=lambda stage, *_: waiting.stage(*stages[stage]),
        )
        if not model.assembly.fixed.any():
            raise InputError(
                "no block is fixed",
                where=self.model,
                remedy="add --supports lowest, below:Z or the names of blocks",
            )
        notes = list(model.notes)
        notes += [] if model.report is None else warnings_of(model.report)
        load = model.load
        if self.case:
            if self.gravity is not None or self.density is not None:
                raise InputError(
                    "the cases of the file have their own weight",
                    where="--case",
                    remedy="leave out --gravity and --density",
                )
            load = loading.combined(self.case, model.cases)
        load = loading.loaded(model.assembly, load, self.load, seismic, moves, self.gravity)
        if load.motion is not None and not settling:
            raise InputError(
                f"the load case '{load.name}' moves supports",
                where="--case" if self.case else self.model,
                remedy="ask 'drystone settle', or choose --case without settlement",
            )
        return replace(model, load=load, notes=(*notes, *load.notes))


def warnings_of(report: ContactReport) -> list[str]:
    """What a user must hear of the contact search even when he did not ask for its report."""
    names = report.names
    said = []
    if report.isolated:
        shown = ", ".join(f"'{names[i]}'" for i in report.isolated[:PAIRS])
        more = len(report.isolated) - PAIRS
        said.append(f"touching nothing: {shown}" + (f" and {more} more blocks" if more > 0 else ""))
        said += report.suggestions()
    return said
