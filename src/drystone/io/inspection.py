"""What an inspection of blocks says of itself: sizes, defects, contacts and near misses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from drystone.answer import (
    Answer,
    Layer,
    LayerKind,
    Question,
    Role,
    Scene,
    SceneStage,
    Sentence,
)
from drystone.answer.chart import Chart
from drystone.answer.drawing import interface_layers, state_of
from drystone.assembly import Assembly, Block
from drystone.base import units
from drystone.base.arrays import Floats
from drystone.base.errors import InputError, counted
from drystone.base.files import digest
from drystone.base.ragged import Ragged
from drystone.base.table import Table
from drystone.contacts import Contacts
from drystone.detection import ContactReport, Detection
from drystone.geometry.surface import worth_drawing
from drystone.io.build import Built
from drystone.model import Model
from drystone.supports import ground_of, own_blocks, select


@dataclass(frozen=True, eq=False)
class Inspection(Answer):
    """Blocks, the defects of their meshes, and the contacts between them.

    Attributes
    ----------
    usable
        The blocks without defects; ``None`` where there are none.
    found
        Their contacts, and what the search missed.
    built
        All blocks of the file, and the defects; ``None`` of an assembly.
    file
        Its name; empty of an assembly.
    """

    usable: Assembly | None
    found: Detection | None
    built: Built | None = None
    file: str = ""

    @property
    def assembly(self) -> Assembly:
        """The blocks that can be used.

        Raises
        ------
        InputError
            There are none.
        """
        if self.usable is None:
            raise InputError("no block can be used", where=self.file, remedy="mend the defects")
        return self.usable

    @property
    def contacts(self) -> Contacts:
        """The contacts between them."""
        return Contacts.empty() if self.found is None else self.found.contacts

    @property
    def model(self) -> Model:
        """The blocks with their contacts, under their weight."""
        return Model(self.assembly, self.contacts)

    @cached_property
    def asked(self) -> Question:
        """The file, and the blocks that can be used; contacts found anew have no friction yet."""
        known = self.usable is not None
        asked = (
            Question.of(self.model, made=self.when)
            if known
            else Question.of_nothing(made=self.when)
        )
        sha256 = digest(self.file) if Path(self.file).is_file() else ""
        asked = asked.without("load", "acceleration", "friction")
        return replace(asked, file=self.file, sha256=sha256)

    @property
    def _blocks(self) -> list[Block]:
        """Those of the file, without the ground that supports lay."""
        if self.built is None or not self.built.defects:
            return [self.assembly.blocks[i] for i in np.flatnonzero(own_blocks(self.assembly))]
        return [block for block in self.built.blocks if block is not None]

    @property
    def _defects(self) -> tuple[InputError, ...]:
        return () if self.built is None else self.built.defects

    @cached_property
    def _fixed(self) -> list[bool]:
        if self.built is None or not self.built.defects:
            return [bool(one) for one in self.assembly.fixed[own_blocks(self.assembly)]]
        names = () if self.usable is None else self.usable.names
        chosen = {} if self.usable is None else dict(zip(names, self.usable.fixed, strict=True))
        each = zip(self.built.blocks, self.built.fixed, strict=True)
        return [bool(chosen.get(one.name, was)) for one, was in each if one is not None]

    @property
    def title(self) -> str:
        """How many blocks touch, and how many nearly."""
        told = counted(len(self._blocks), "block")
        if self.found is None:
            return told
        missed = sum(not miss.joined for miss in self.found.report.missed)
        near = f", {counted(missed, 'near miss', 'near misses')}" if missed else ""
        return f"{told}, {counted(self.contacts.count, 'interface')}{near}"

    @property
    def code(self) -> int:
        """0 where every block can be used, else 2: it is bad input."""
        return 2 if self._defects else 0

    def sentences(self) -> Sequence[Sentence]:
        """Sizes, defects by kind, what the contact search found and missed."""
        blocks, fixed = self._blocks, sum(self._fixed)
        told = [f"{counted(len(blocks), 'block')}, {fixed} of them fixed"]
        if blocks:
            bounds = np.array([block.bounds for block in blocks])
            extent = bounds[:, 1].max(axis=0) - bounds[:, 0].min(axis=0)
            volume = sum(float(block.volume) for block in blocks)
            weight = sum(float(block.mass) for block in blocks)
            told += [units.extent(extent), f"{volume:,.4g} m3", units.mass(weight)]
        said = [Sentence(", ".join(told), Role.BAD if self._defects else Role.GOOD)]
        said += self._told_defects()
        lines = [] if self.found is None else list(self.found.report.summary())
        return [*said, *map(Sentence, lines)]

    def _told_defects(self) -> list[Sentence]:
        """A sentence for each kind of defect."""
        kinds: dict[str, list[InputError]] = {}
        for error in self._defects:
            kinds.setdefault(error.kind or error.what, []).append(error)
        said = []
        for kind, (first, *others) in kinds.items():
            more = f" ({len(others)} more: {kind}; --json lists all)" if others else ""
            said.append(Sentence(f"defect: {first}{more}", Role.REMARK))
        return said

    def tables(self) -> Sequence[Table]:
        """The blocks."""
        blocks = self._blocks
        columns = {
            "block": [one.name for one in blocks],
            "fixed": self._fixed,
            "volume": [float(one.volume) for one in blocks],
            "mass": [float(one.mass) for one in blocks],
            "size": np.array([one.bounds[1] - one.bounds[0] for one in blocks]).reshape(-1, 3),
            "faces": [len(one.faces) for one in blocks],
        }
        return [Table("blocks", columns, {"volume": "m3", "mass": "kg", "size": "m"})]

    def numbers(self) -> Mapping[str, Any]:
        """Where the blocks are, the defects, and the contact report."""
        blocks = self._blocks
        return {
            "volume": sum(float(one.volume) for one in blocks),
            "places": [
                {
                    "block": one.name,
                    "centroid": one.centroid,
                    "bounds": one.bounds,
                    "vertices": len(one.vertices),
                    "repairs": one.repairs,
                }
                for one in blocks
            ],
            "defects": [
                {"what": one.what, "where": one.where, "remedy": one.remedy, "kind": one.kind}
                for one in self._defects
            ],
            "contacts": None if self.found is None else self.found.report.to_dict(),
        }

    def layers(self) -> Scene:
        """The interfaces, and near misses between blocks that do not touch in orange.

        Examples
        --------
        >>> from drystone.detection import find_contacts
        >>> from drystone.models import tower
        >>> Inspection(tower(3), find_contacts(tower(3))).layers().title
        'drystone: 3 blocks, 2 interfaces'
        """
        assembly, contacts = self.assembly, self.contacts
        lines = contacts.start[:-1][np.diff(contacts.start) == 2]
        ends = contacts.point[lines[:, None] + [0, 1]]
        parts = [
            *interface_layers(contacts),
            *_line_layer("lines", "line contacts", "interface", ends),
        ]
        message, charts = "", []
        if self.found is not None:
            report = self.found.report
            parts += missed_layers(report)
            said = worth_drawing(report.summary())
            first, *rest = said
            advice = [f"suggestion: {text}" for text in report.suggestions()]
            told = [first, *advice, *(line for line in rest if line not in advice)]
            message = "; ".join(told)
            charts.append(Chart("Contact search", caption="\n".join(said)))
        bare = () if self.built is None else self.built.bare
        parts += _polygon_layer("defects", "faces at holes", "help", bare)
        stage = SceneStage("contacts", self.title, message, state_of(assembly), layers=tuple(parts))
        own = int(own_blocks(assembly).sum())
        count = f"{counted(own, 'block')}, {contacts.count} interfaces"
        return Scene(
            assembly, contacts, (stage,), f"drystone: {count}", self.asked.facts(),
            charts=tuple(charts),
        )  # fmt: skip


def usable(built: Built, supports: str | None = None) -> tuple[Assembly | None, list[str]]:
    """The blocks of a file that can be used, with their supports, and notes."""
    assembly, notes = built.assembly, list(built.notes)
    if assembly is not None:
        assembly, chosen = ground_of(assembly, supports)
        return assembly if supports is None else select(assembly, str(chosen)), notes
    assembly = built.usable
    if assembly is None:
        notes.append("contacts are found, and drawn, once the defects are mended")
        return None, notes
    rest = len(built.blocks) - len(assembly)
    left_out = f"{counted(rest, 'block')} left out" if rest else "as they are"
    some = counted(len(assembly), "block")
    notes.append(
        f"contacts are found among the {some} that can be used, {left_out}: mend the defects first"
    )
    if supports is not None:
        try:
            assembly = select(assembly, supports)
        except InputError as error:
            notes.append(f"--supports waits for the defects: {error}")
    return assembly, notes


def missed_layers(report: ContactReport) -> tuple[Layer, ...]:
    """Near misses of pairs of blocks that do not touch elsewhere."""
    missed = [miss.polygon for miss in report.missed if not miss.joined]
    areas = [polygon for polygon in missed if len(polygon) > 2]
    points = np.array([polygon for polygon in missed if len(polygon) == 2]).reshape(-1, 2, 3)
    return (
        *_polygon_layer("missed", "near misses", "missed", areas),
        *_line_layer("missed-points", "near misses of corners", "missed", points),
    )


def _polygon_layer(
    key: str, label: str, colour: str, polygons: Sequence[Floats]
) -> tuple[Layer, ...]:
    """Polygons (c, 3) in one colour; no layer where there are none."""
    if not polygons:
        return ()
    start = Ragged.of(polygons).start
    corner = np.concatenate(polygons)
    return (Layer(key, label, LayerKind.POLYGONS, colour, corner, start=start.astype(np.intp)),)


def _line_layer(key: str, label: str, colour: str, ends: Floats) -> tuple[Layer, ...]:
    """Lines with the ends (p, 2, 3) in one colour; no layer where there are none."""
    start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    line = Layer(key, label, LayerKind.LINES, colour, start, along, width=2.0)
    return (line,) if len(ends) else ()
