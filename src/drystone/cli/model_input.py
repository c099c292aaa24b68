"""The model of a command: what it is read from, how, and what is doubtful about it."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.display import named
from drystone.base.errors import InputError, counted
from drystone.cli import kinds
from drystone.cli.offered import CONTACTS, LOADS, MODEL, Analysis, Argument, Of
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.assembly import Assembly
    from drystone.detection import ContactReport
    from drystone.io.several import Paths
    from drystone.loads import LoadCase
    from drystone.model import Model

_FLAGS = {"search": "--find-contacts", "layers": "--layer"}
SHOWN = ("units", "supports", "friction", "density", "gravity", "load")
"""Ways of reading that every help shows."""
HOW = partial(
    Of,
    "drystone.io.read",
    without=("detection", "progress"),
    shown=SHOWN,
    flags=_FLAGS,
    metavars={
        "supports": "NAMES|lowest|ground",
        "gravity": "SIZE|X,Y,Z",
        "load": "BLOCK:WHAT[@X,Y,Z]",
        "case": "[FACTOR*]NAME",
        "seismic": "KX,KY",
        "joint_capacity": "WHAT|FILE.csv",
        "strength": "PRESSURE",
        "tie": "BLOCK[@X,Y,Z]:BLOCK[@X,Y,Z][:FORCE]|fill",
        "gap": "LENGTH|SHARE",
        "only": "NAMES",
        "without": "NAMES",
        "isolate": "NAMES",
        "crack": "BLOCKS:BLOCKS",
        "layers": "NAME",
        "thickness": "LENGTH",
    },
    group=MODEL,
    groups={
        LOADS: ("gravity", "load", "case", "seismic", "shaken"),
        CONTACTS: (
            "joint_capacity",
            "strength",
            "tie",
            "gap",
            "angle",
            "edges",
            "ends",
            "anyway",
            "search",
            "crack",
        ),
    },
)
"""How a model is read: the options of :func:`drystone.read`."""
FILES = Argument(
    "MODEL",
    "Model file; its suffix determines the format. Or a folder, a pattern in quotes, or several "
    "files.",
    kinds.FILE,
    several=True,
)


@dataclass(frozen=True)
class Subject:
    """The model, and how it is read."""

    files: Annotated[str | tuple[str, ...], FILES]
    reading: Annotated[Analysis, HOW()]

    @property
    def name(self) -> str:
        """What it is called: its file, or the number of files."""
        return self.place if isinstance(self.place, str) else f"{len(self.place)} files"

    @property
    def place(self) -> str | list[str]:
        """What it is read from."""
        return self.each[0] if len(self.each) == 1 else self.each

    @property
    def each(self) -> list[str]:
        """Its files, folders and patterns."""
        return [self.files] if isinstance(self.files, str) else list(self.files)

    @property
    def how(self) -> dict[str, Any]:
        """Arguments of :func:`drystone.read`."""
        return dict(self.reading.given)

    def command(self, name: str, *more: str) -> str:
        """Another command on the same model, as it is typed, with more behind it."""
        words = ["drystone", *name.split(), *self.each]
        for key, given in self.how.items():
            flag = _FLAGS.get(key, f"--{key.replace('_', '-')}")
            for one in given if isinstance(given, tuple) else (given,):
                words += (
                    [flag]
                    if one is True
                    else [flag, f"{one:.6g}" if isinstance(one, float) else str(one)]
                )
        return shlex.join([*words, *more])

    def uncut(self, assembly: Assembly) -> list[str]:
        """How a surface is cut into blocks, where the file has one body and no joint."""
        from drystone.supports import own_blocks  # the program starts fast

        if own_blocks(assembly).sum() != 1 or not isinstance(self.place, str):
            return []
        how = [f"--{key} {self.how[key]}" for key in ("units", "up") if key in self.how]
        words = " ".join((shlex.quote(self.place), *how))
        return [f"only one block, so no joint is tested; an open surface is cut into blocks by: "
                f"drystone shell {words} --courses 11 --blocks 6 --thickness 0.2"]  # fmt: skip

    @property
    def anyway(self) -> bool:
        """Whether what is doubtful is accepted."""
        return bool(self.how.get("anyway"))

    def prepared(
        self, waiting: Waiting, moves: tuple[str, ...] = (), settling: bool = False
    ) -> Model:
        """Read the model with its supports, contacts and loads.

        What is doubtful about it is asked in a terminal, and told elsewhere. A load case that moves
        supports is accepted only with ``settling``.

        Raises
        ------
        InputError
            Something in the file or in the options cannot be used, or nothing is fixed.
        """
        how = self.how
        model = self._read(how, waiting)
        waiting.end_stage()  # the import is no part of the stage before
        from drystone.stability.doubts import doubts

        waiting.stage("read", "looking at the model")
        told = []
        changed: dict[str, Any] = {}
        for doubt in doubts(model, self.place, how):
            if waiting.ask(f"{doubt.text} Use {doubt.option}?"):
                changed |= doubt.how
                continue
            text = f"{doubt.text} ({doubt.option})"
            noted = doubt.text in model.notes  # with its option
            waiting.warn(doubt.text if noted else text)
            told += [] if noted else [text]
        if changed:
            how |= changed
            model = self._read(how, waiting)
        uncut = self.uncut(model.assembly)
        _refuse_supports(model, how, self, uncut)
        notes = [*uncut, *model.notes, *told]
        notes += [] if model.report is None else warnings_of(model.report)
        load = model.load
        for text in moves:
            from drystone.loads.load_words import move_of_words

            load = load + move_of_words(text, model.assembly)
        if load.motion is not None and not settling:
            raise InputError(
                f"the load case '{load.name}' moves supports",
                where="case" if "case" in how else self.name,
                remedy="ask 'drystone settle', or choose --case without settlement",
            )
        return replace(model, load=load, notes=tuple(notes))

    def case_of(self, text: str, model: Model) -> LoadCase:
        """A load case of the file by its name, ``seismic:KX,KY``, or ``BLOCK:WHAT[@X,Y,Z]``."""
        from drystone.io.load_options import grown

        return grown(text, model, self.how.get("gravity"), self.how.get("shaken", False))

    def _read(self, how: dict[str, Any], waiting: Waiting) -> Model:
        from drystone import io  # the commands start fast: work is imported when there is some

        stages = {"read": ("read", f"reading {self.name}"), "contacts": ("detect", "contacts")}
        return io.read(self.place, **how, progress=lambda stage, *_: waiting.stage(*stages[stage]))


_READ = ("units", "split", "repair", "layers", "hidden", "thickness", "max_size", "up")
"""How the blocks of files are read."""


@dataclass(frozen=True)
class Source(Subject):
    """The blocks of files, without supports, materials and loads."""

    reading: Annotated[Analysis, HOW(_READ, shown=("units", "up"))]


@dataclass(frozen=True)
class Inspected(Subject):
    """Blocks that are looked at, ties, and the tolerances of the contact search."""

    reading: Annotated[
        Analysis, HOW((*_READ, "supports", "gap", "angle", "edges", "tie"), shown=(*SHOWN, "up"))
    ]


@dataclass(frozen=True)
class Converted(Subject):
    """Blocks that are written again."""

    reading: Annotated[
        Analysis,
        HOW((*_READ, "skip_defects", "supports", "friction", "density"), shown=(*SHOWN, "up")),
    ]


@dataclass(frozen=True)
class OneFile(Subject):
    """As :class:`Subject`, where another argument that can be left out follows."""

    files: Annotated[str | tuple[str, ...], replace(FILES, several=False)]


def _refuse_supports(
    model: Model, how: dict[str, Any], source: Subject, uncut: Sequence[str] = ()
) -> None:
    """Raise InputError where no block is fixed, or every block is."""
    from drystone.model import up_of_load  # as above
    from drystone.supports import require_supports

    chosen = how.get("supports") is not None
    fixed, remedy = model.assembly.fixed, "name fewer blocks with --supports"
    if uncut:
        remedy = uncut[0]
    elif not chosen:
        remedy = "the file says so: choose those that stand still with --supports"
        layers = sorted({str(block.metadata.get("layer", "")) for block in model.assembly.blocks})
        if any(layers):
            remedy += f"; or draw what moves on another layer than {named(layers, 4)}"
    if chosen and (said := on_its_side(model, source.place, how)):
        remedy += f"; or {said}"
    require_supports(
        model.assembly,
        model.joints,
        up=up_of_load(how.get("gravity")),
        where="supports" if fixed.all() and chosen else source.name,
        option="--supports",
        remedy=remedy,
    )


def on_its_side(model: Model, path: Paths, how: dict[str, Any]) -> str:
    """The question whether another axis is up, where all blocks are fixed and that frees some."""
    if not model.assembly.fixed.all():
        return ""
    from drystone.stability.doubts import other_up, toward  # as above
    from drystone.supports import select

    if not (up := other_up(path, how)):
        return ""
    lying = select(model.assembly, "lowest", up=toward(up), joints=model.joints).fixed
    some = counted(int(lying.sum()), "block")
    said = f"does the model lie on its side? With --up {up} 'lowest' fixes {some}"
    return "" if lying.all() else said


def warnings_of(report: ContactReport) -> Iterable[str]:
    """Warnings of the contact search that every command prints."""
    names = report.names
    said = []
    if report.isolated:
        alone = named([f"'{names[i]}'" for i in report.isolated])
        said.append(f"touching nothing: {alone}")
        said += report.suggestions()
    return said
