"""Blocks from the data of a file: scaled, closed, repaired where that is safe, and checked."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly, Block
from drystone.base.arrays import ROUNDING, Floats
from drystone.base.errors import DefectKind, FormatError, InputError, counted, printable
from drystone.base.units import UNITS, mass, scale_of
from drystone.detection.tolerances import repair_lines
from drystone.geometry import coincidence
from drystone.io.draft import UP, Contents, Draft, DraftBlock
from drystone.io.shape_blocks import blocks_of, faces_at_holes
from drystone.loads.case import STANDARD_GRAVITY
from drystone.supports import own_blocks

_LIKELY_EXTENT = (0.01, 1000.0)
_LIKELY_BLOCK = (0.002, 4.0)
_LIKELY_MASS = 1e10
"""[m, m, kg], chosen: range of the model size, range of the median block size, largest mass (the
Great Pyramid has 6e9 kg). Outside them the model is accepted, with a remark on its unit."""
_USUAL_BLOCK = 0.5
_METRIC = ("mm", "cm", "m")
"""[m], chosen: the suggested unit is the metric unit that brings the median block nearest to this
size."""


@dataclass(frozen=True)
class Built:
    """Blocks made from a draft, and the defects of the others.

    Attributes
    ----------
    blocks
        One per shape; ``None`` where it cannot be used.
    fixed
    defects
        One error per fault, in order.
    notes
    bare
        Faces (c, 3) [m] of open meshes with a missing neighbour.
    faulty
        Positions of blocks that must not be used: they are duplicates.
    """

    blocks: tuple[Block | None, ...]
    fixed: tuple[bool, ...]
    defects: tuple[InputError, ...]
    notes: tuple[str, ...]
    bare: tuple[Floats, ...] = ()
    faulty: frozenset[int] = frozenset()

    @cached_property
    def assembly(self) -> Assembly | None:
        """The assembly of all blocks; ``None`` if there are defects."""
        if self.defects:
            return None
        blocks = tuple(block for block in self.blocks if block is not None)
        return Assembly(blocks, np.array(self.fixed, dtype=bool))

    @cached_property
    def usable(self) -> Assembly | None:
        """The assembly of the blocks without defects, the first of each name, or ``None``."""
        first: dict[str, tuple[Block, bool]] = {}
        for i, (block, held) in enumerate(zip(self.blocks, self.fixed, strict=True)):
            if block is not None and i not in self.faulty:
                first.setdefault(block.name, (block, held))
        if not first:
            return None
        blocks, fixed = zip(*first.values(), strict=True)
        return Assembly(blocks, np.array(fixed, dtype=bool))


def build(
    draft: Draft,
    path: Path,
    units: str | None = None,
    *,
    split: bool = False,
    skip_defects: bool = False,
    supports: str | None = None,
    repair: bool = False,
) -> Contents:
    """The model of a draft; with ``skip_defects`` without the blocks that cannot be used.

    The other options are those of :func:`try_blocks`.

    Raises
    ------
    InputError
        The first defect, with the number of others; or no block can be used.
    """
    built = try_blocks(draft, path, units, split=split, supports=supports, repair=repair)
    assembly, unit = built.assembly, units or draft.units or "m"
    if assembly is None and skip_defects and built.usable is not None:
        left = len(built.blocks) - len(built.usable)
        said = [
            f"{counted(left, 'block')} with defects left out ('drystone inspect' lists them)",
            *(["contacts, loads and results of the file left out"] if draft.finish else []),
        ]
        notes = (*built.notes, *said)
        return Contents(built.usable, notes=notes, ties=draft.ties, units=unit)
    if assembly is None:
        first = built.defects[0]
        more = len(built.defects) - 1
        tail = f" ({more} more; 'drystone inspect' lists all)" if more else ""
        tail += "; 'drystone check --skip-defects' leaves out such blocks" * bool(built.usable)
        raise first.located(first.where, first.remedy + tail) from first
    contacts, loads, results = (
        draft.finish(assembly, scale_of(unit)) if draft.finish else (None, (), ())
    )
    return Contents(
        assembly, contacts, loads, results, unit, notes=built.notes, ties=draft.ties,
        ends=draft.ends, detection=draft.detection,
    )  # fmt: skip


def try_blocks(
    draft: Draft,
    path: Path,
    units: str | None = None,
    *,
    split: bool = False,
    supports: str | None = None,
    repair: bool = False,
) -> Built:
    """Every block that can be made of a draft, and all defects of the others.

    With ``split``, the separate parts of a block become separate blocks. An open surface that is
    fixed, in the file or by ``supports``, gets a body behind it. With ``repair``, other broken
    meshes are mended, and else an error says where this would work; see
    :func:`drystone.repair.mended_blocks`. The axis of the draft that points up becomes z.
    """
    remarks = _overruled(draft, path, units)
    scale = scale_of(units or draft.units or "m")
    if (split or repair) and draft.finish is not None:
        raise FormatError(
            "its contacts, loads and results refer to whole blocks",
            where=str(path),
            remedy="leave --split and --repair out",
        )
    if draft.up != "z" and draft.finish is not None:
        raise FormatError(
            "the file has contacts or loads, whose axes are known",
            where=str(path),
            remedy="leave up out",
        )
    made, said = blocks_of(draft.shapes, scale, supports, split=split, repair=repair)
    blocks: list[Block | None] = []
    fixed: list[bool] = []
    defects: list[InputError] = []
    bare: list[Floats] = []
    for shape, own in zip(draft.shapes, made, strict=True):
        if isinstance(own, InputError):
            defects.append(_located(own, path, shape))
            if own.kind is DefectKind.OPEN:
                bare += [one @ UP[draft.up].T for one in faces_at_holes(shape, scale)]
            own = [None]
        blocks += own if draft.up == "z" else [one and one.transformed(UP[draft.up]) for one in own]
        fixed += [shape.fixed] * len(own)
    place = [i for i, block in enumerate(blocks) if block is not None]
    good = [block for block in blocks if block is not None]
    defects += _name_defects(draft.shapes, path)
    doubled, twice = _duplicate_defects(good, path)
    sized = _size_notes(good, units or draft.units)
    notes = (
        *draft.notes,
        *remarks,
        *said,
        *repair_lines((one.name, what) for one in good for what in one.repairs),
        *sized,
    )
    return Built(
        tuple(blocks),
        tuple(fixed),
        (*defects, *doubled),
        tuple(map(printable, notes)),
        tuple(bare),
        frozenset(place[i] for i in twice),
    )


def _overruled(draft: Draft, path: Path, units: str | None) -> list[str]:
    """A remark where other units are asked for than the file has."""
    if units is None or draft.units in (None, units):
        return []
    if draft.finish is not None:
        raise FormatError(
            f"its lengths are in {draft.units}, not in {units}",
            where=str(path),
            remedy="leave --units out",
        )
    return [f"lengths are read as {units}, as asked; the file says {draft.units}"]


def _located(error: InputError, path: Path, shape: DraftBlock) -> InputError:
    place = f"{shape.where} " if shape.where else ""
    where = f"{path}, {place}block '{shape.name}'"
    return FormatError(error.what, where=where, remedy=error.remedy, kind=error.kind)


def _name_defects(shapes: tuple[DraftBlock, ...], path: Path) -> list[InputError]:
    places: dict[str, list[str]] = defaultdict(list)
    for i, shape in enumerate(shapes):
        places[shape.name].append(shape.where or f"block {i}")
    return [
        FormatError(
            f"{len(at)} blocks have the same name, '{name}' ({' and '.join(at[:3])})",
            where=str(path),
            remedy="rename all but one of them",
        )
        for name, at in places.items()
        if len(at) > 1
    ]


def _duplicate_defects(blocks: list[Block], path: Path) -> tuple[list[InputError], list[int]]:
    """A defect for each pair of duplicate blocks, and the second of each pair."""
    pairs = coincidence.duplicates([block.vertices for block in blocks], ROUNDING)
    return [
        FormatError(
            f"blocks '{blocks[a].name}' and '{blocks[b].name}' are the same block twice,"
            " at the same place",
            where=str(path),
            remedy="remove one of them",
            kind=DefectKind.TWICE,
        )
        for a, b in pairs
    ], [max(a, b) for a, b in pairs]


def _size_notes(blocks: list[Block], units: str | None) -> list[str]:
    if not blocks:
        return []
    low = np.min([block.bounds[0] for block in blocks], axis=0)
    high = np.max([block.bounds[1] for block in blocks], axis=0)
    extent = float((high - low).max())
    block = float(np.median([(one.bounds[1] - one.bounds[0]).max() for one in blocks]))
    weight = sum(one.mass for one in blocks)
    what = f"the model is {extent:.3g} m across, its median block {block:.3g} m, and weighs"
    return doubtful_size(what, extent, block, weight, units)


def doubtful_size(
    what: str, extent: float, block: float, weight: float, units: str | None
) -> list[str]:
    """A remark where a size [m], that of a block [m] or a mass [kg] is improbable, else none."""
    usual = _LIKELY_BLOCK[0] <= block <= _LIKELY_BLOCK[1] and weight <= _LIKELY_MASS
    if usual and _LIKELY_EXTENT[0] <= extent <= _LIKELY_EXTENT[1]:
        return []
    read_in = f"read in {units}" if units else "no unit was given, metres assumed"
    now = UNITS[units or "m"]
    likely = min(_METRIC, key=lambda unit: abs(np.log(block * UNITS[unit] / now / _USUAL_BLOCK)))
    remedy = f"--units {likely}" if likely != (units or "m") else "--units"
    return [f"{what} {mass(weight)}; {read_in}: is the unit right ({remedy})?"]


def doubtful_density(assembly: Assembly) -> tuple[str, ...]:
    """A remark where a density of the blocks [kg/m3] is improbable, else none."""
    density = np.array([one.density for one in assembly.blocks])[own_blocks(assembly)]
    low, high = float(density.min(initial=np.inf)), float(density.max(initial=0.0))
    least, most = 100.0, 22_600.0  # cork has more, osmium 22,590; lighter foams are told as well
    if least <= low and high <= most:
        return ()
    odd, what = (low, "less than cork has") if low < least else (high, "more than any metal has")
    units = np.array([1e12, 1e9, 1e6, 1e3, 1e3 / STANDARD_GRAVITY, 1.0 / STANDARD_GRAVITY, 1e-3])
    likely = odd * units[np.abs(np.log(odd * units / DEFAULT_DENSITY)).argmin()]
    remedy = f"--density {likely:.4g}" if low == high else "--density"
    return (f"a density is {odd:g} kg/m3, {what}: is the unit right ({remedy})?",)
