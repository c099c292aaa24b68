"""The model of a command: read, supported, with contacts and loads."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError, counted
from drystone.cli import kinds, loading, options
from drystone.cli.joint_capacity_option import JointCapacities, with_joint_capacity
from drystone.cli.offered import CONTACTS, LOADS, MODEL, Argument, Option
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.detection import ContactReport, DetectionOptions
    from drystone.model import Model

_PAIRS = 5
"""Blocks or pairs named in a remark."""


@dataclass(frozen=True)
class Source:
    """A model file, and how it is read."""

    model: Annotated[
        str,
        Argument(
            "MODEL",
            "Model file; its suffix determines the format. Or a folder, or a pattern in quotes.",
            kinds.FILE,
        ),
    ]
    units: options.Units = None
    split: Annotated[
        bool, Option("Make a block of each separate part of a block.", MODEL, expert=True)
    ] = False
    repair: Annotated[
        bool, Option("Mend broken meshes, and say what was done.", MODEL, expert=True)
    ] = False
    layer: Annotated[
        tuple[str, ...],
        Option(
            "Layer of a 3dm or DXF file to read, hidden or not. Can be given several times.",
            MODEL,
            metavar="NAME",
            expert=True,
        ),
    ] = ()
    hidden: Annotated[
        bool, Option("Read hidden layers and objects of a 3dm or DXF file too.", MODEL, expert=True)
    ] = False
    thickness: Annotated[
        str | None,
        Option(
            "Thickness of the blocks of a section in a DXF file, such as 450mm (1 m).",
            MODEL,
            metavar="LENGTH",
            expert=True,
        ),
    ] = None
    max_size: Annotated[
        float | None,
        Option("Largest file that is read, in MiB (64).", MODEL, kind=kinds.POSITIVE, expert=True),
    ] = None

    def how(self) -> dict[str, Any]:
        """Arguments of the functions that read a file."""
        return {
            "units": self.units,
            "split": self.split,
            "repair": self.repair,
            "layers": self.layer,
            "hidden": self.hidden,
            "thickness": self.thickness,
            "max_size": self.max_size,
        }


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of the contact search."""

    gap: Annotated[
        float | None,
        Option(
            "Largest gap of a joint, by the size of the smaller block (0.005).",
            CONTACTS,
            expert=True,
        ),
    ] = None
    angle: Annotated[
        float | None,
        Option(
            "Largest angle in degrees between faces that make a joint (2).", CONTACTS, expert=True
        ),
    ] = None
    edges: Annotated[
        str | None,
        Option(
            "Contacts along edges and in corners: for isolated blocks, which touch nothing else, "
            "always or never (isolated).",
            CONTACTS,
            kind=kinds.one_of(("isolated", "always", "never")),
            expert=True,
        ),
    ] = None

    def options(self) -> DetectionOptions:
        """The tolerances of the contact search, from those options that were given."""
        from drystone.detection import DetectionOptions

        asked: dict[str, Any] = {"gap": self.gap, "angle": self.angle, "edges": self.edges}
        return DetectionOptions(**{key: value for key, value in asked.items() if value is not None})


@dataclass(frozen=True)
class Finding(Tolerances):
    """Options of the contact search."""

    find_contacts: Annotated[
        bool, Option("Search contacts even if the file has some.", CONTACTS, expert=True)
    ] = False
    anyway: Annotated[
        bool,
        Option(
            "Accept blocks that overlap by more than a tenth of the smaller one; plan also if the "
            "complete model does not stand.",
            CONTACTS,
            expert=True,
        ),
    ] = False


@dataclass(frozen=True)
class Subject(Source):
    """The model, its supports and materials, and its loads without earthquakes."""

    up: options.Up = "z"
    skip_defects: options.SkipDefects = False
    supports: options.Supports = None
    friction: options.Friction = None
    density: options.Density = None
    joint_capacity: JointCapacities = None
    gravity: Annotated[
        tuple[float, float, float] | None,
        Option(
            "Gravity in m/s2: its size, or a vector (9.81 along -z).",
            LOADS,
            kind=kinds.OptionKind("SIZE|X,Y,Z", options.gravity_vector),
        ),
    ] = None
    load: loading.Loads = ()
    case: Annotated[
        tuple[str, ...],
        Option(
            "A load case of the file instead of the weight, such as 1.35*dead. Can be given "
            "several times: they add up.",
            LOADS,
            metavar="[FACTOR*]NAME",
            expert=True,
        ),
    ] = ()

    def prepared(
        self,
        waiting: Waiting,
        finding: Finding | None = None,
        seismic: str | None = None,
        moves: tuple[str, ...] = (),
        settling: bool = False,
    ) -> Model:
        """Read the model with its supports, contacts and loads.

        A load case that moves supports is accepted only with ``settling``.

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
            up=self.up,
            skip_defects=self.skip_defects,
            search=finding.find_contacts,
            anyway=finding.anyway,
            **self.how(),
            progress=lambda stage, *_: waiting.stage(*stages[stage]),
        )
        if self.joint_capacity is not None:
            model = with_joint_capacity(model, self.joint_capacity)
        _refuse_supports(model, self)
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

    def upright(self, model: Model, waiting: Waiting) -> tuple[str, ...]:
        """A remark where a model that falls would stand with the y axis of its file up."""
        from drystone.io import files_at, format_of
        from drystone.supports import select

        if self.up != "z" or self.gravity is not None or not self.supports:
            return ()
        if not all(format_of(file).axes_unknown for file in files_at(self.model)):
            return ()
        waiting.stage("upright", "trying another axis")
        up = (0.0, 1.0, 0.0)
        try:
            turned = select(model.assembly, self.supports, up=up, joints=model.joints)
        except InputError:
            return ()
        if turned.fixed.all():
            return ()
        from drystone.limits.limit_checks import one_stiffness
        from drystone.loads import LoadCase

        down = LoadCase.gravity(turned, direction=(0.0, -1.0, 0.0))
        stands = one_stiffness(replace(model, assembly=turned, load=down)).stable
        return ("it would stand with --up y: does y point up in the file?",) if stands else ()


def _refuse_supports(model: Model, subject: Subject) -> None:
    """Raise InputError where no block is fixed, or every block is."""
    from drystone.model import up_of_load  # as above
    from drystone.supports import require_supports, select

    fixed, remedy = model.assembly.fixed, "name fewer blocks with --supports"
    if fixed.all() and subject.up == "z" and subject.supports is not None:
        lying = select(model.assembly, "lowest", up=(0.0, 1.0, 0.0), joints=model.joints)
        if not lying.fixed.all():
            some = counted(int(lying.fixed.sum()), "block")
            remedy += f"; or does the model lie on its side? With --up y 'lowest' fixes {some}"
    require_supports(
        model.assembly,
        model.joints,
        up=up_of_load(subject.gravity),
        where="--supports" if fixed.all() and subject.supports is not None else subject.model,
        option="--supports",
        remedy=remedy,
    )


def warnings_of(report: ContactReport) -> list[str]:
    """Warnings of the contact search that every command prints."""
    names = report.names
    said = []
    if report.isolated:
        shown = ", ".join(f"'{names[i]}'" for i in report.isolated[:_PAIRS])
        more = len(report.isolated) - _PAIRS
        said.append(f"touching nothing: {shown}" + (f" and {more} more blocks" if more > 0 else ""))
        said += report.suggestions()
    return said
