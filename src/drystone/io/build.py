"""Blocks from the data of a file: scaled, closed, repaired where that is safe, and checked."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from drystone.assembly import Assembly, Block, replace_block
from drystone.base.arrays import Bools, Floats, frozen_floats
from drystone.base.display import named
from drystone.base.errors import DefectKind, FormatError, InputError, counted, printable
from drystone.base.units import UNITS, mass, scale_of
from drystone.geometry import coincidence, selfcontact
from drystone.geometry.closing import separate_parts
from drystone.geometry.surface import open_faces
from drystone.io.draft import Contents, Draft, DraftBlock
from drystone.repair import mended_blocks, support_from_surface
from drystone.supports import may_hold

_LARGEST_COORDINATE = 1e9
"""[m], chosen: far above any structure, far below where products of coordinates overflow."""
_LIKELY_EXTENT = (0.01, 1000.0)
_LIKELY_BLOCK = (0.002, 4.0)
_LIKELY_MASS = 1e10
"""[m, m, kg], chosen: range of the model size, range of the median block size, largest mass (the
Great Pyramid has 6e9 kg). Outside them the model is accepted, with a remark on its unit."""
_USUAL_BLOCK = 0.5
_METRIC = ("mm", "cm", "m")
"""[m], chosen: the suggested unit is the metric unit that brings the median block nearest to this
size."""
_SAME_PLACE = 1e-9
"""Vertices nearer than this share of their block's size are the same point."""
_HINTED = 2000
"""Faces up to which a repair is tried only to say that it would work. Chosen: some tenths of a
second."""
_MANY = 5
"""Names listed in one note."""


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
        Positions of blocks that must not be used: they touch themselves, or are duplicates.
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
    assembly = built.assembly
    if assembly is None and skip_defects and built.usable is not None:
        left = len(built.blocks) - len(built.usable)
        said = [
            f"{counted(left, 'block')} with defects left out ('drystone inspect' lists them)",
            *(["contacts, loads and results of the file left out"] if draft.finish else []),
        ]
        return Contents(built.usable, notes=(*built.notes, *said))
    if assembly is None:
        first = built.defects[0]
        more = len(built.defects) - 1
        tail = f" ({more} more; 'drystone inspect' lists all)" if more else ""
        raise first.located(first.where, first.remedy + tail) from first
    scale = scale_of(units or draft.units or "m")
    contacts, loads, results = draft.finish(assembly, scale) if draft.finish else (None, (), ())
    return Contents(assembly, contacts, loads, results, built.notes)


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
    :func:`drystone.repair.mended_blocks`.
    """
    if units is not None and draft.units is not None and units != draft.units:
        if draft.finish is not None:
            raise FormatError(
                f"its lengths are in {draft.units}, not in {units}",
                where=str(path),
                remedy="leave --units out",
            )
        overruled: tuple[str, ...] = (
            f"lengths are read as {units}, as asked; the file says {draft.units}",
        )
    else:
        overruled = ()
    scale = scale_of(units or draft.units or "m")
    if (split or repair) and draft.finish is not None:
        raise FormatError(
            "its contacts, loads and results refer to whole blocks",
            where=str(path),
            remedy="leave --split and --repair out",
        )
    blocks: list[Block | None] = []
    fixed: list[bool] = []
    defects: list[InputError] = []
    remarks: list[str] = []
    bare: list[Floats] = []
    every = _on_surfaces(draft.shapes, _plain(draft.shapes, scale), scale, supports)
    for shape, plain in zip(draft.shapes, every, strict=True):
        try:
            if isinstance(plain, InputError):
                made, said = _repaired(shape, scale, plain, repair, split)
            else:
                made, said = _in_parts(plain, split)
        except InputError as error:
            defects.append(_located(error, path, shape))
            if error.kind is DefectKind.OPEN:
                bare += _faces_at_holes(shape, scale)
            made, said = [None], []
        blocks += made
        fixed += [shape.fixed] * len(made)
        remarks += said
    place = [i for i, block in enumerate(blocks) if block is not None]
    good = [block for block in blocks if block is not None]
    defects += _name_defects(draft.shapes, path)
    inside, pinched = _self_contact_defects(good, path)
    doubled, twice = _duplicate_defects(good, path)
    defects += [*inside, *doubled]
    faulty = frozenset(place[i] for i in (*pinched, *twice))
    sized = _size_notes(good, units or draft.units)
    notes = (*draft.notes, *overruled, *remarks, *_repair_notes(good), *sized)
    return Built(
        tuple(blocks),
        tuple(fixed),
        tuple(defects),
        tuple(map(printable, notes)),
        tuple(bare),
        faulty,
    )


def _in_parts(block: Block, split: bool) -> tuple[list[Block | None], list[str]]:
    """A block with correctly oriented shells, or its parts if ``split``."""
    parts, turned = separate_parts(block.vertices, block.faces)
    if turned:
        loops = tuple(loop for part in parts for loop in part)
        note = f"{turned} of its shells turned"
        block = replace_block(block, faces=loops, repairs=(*block.repairs, note))
    if len(parts) == 1:
        return [block], []
    if not split:
        said = f"block '{block.name}' has {len(parts)} separate parts that move as one (see split)"
        return [block], [said]
    made: list[Block | None] = [
        replace_block(block, faces=tuple(part), name=f"{block.name}-{i}", repairs=())
        for i, part in enumerate(parts)
    ]
    return made, [f"block '{block.name}' split into its {len(parts)} parts"]


def _repaired(
    shape: DraftBlock, scale: float, error: InputError, repair: bool, split: bool
) -> tuple[list[Block | None], list[str]]:
    """The blocks of a broken mesh, and what was done; else its error, with the option to use."""
    if error.kind not in (DefectKind.OPEN, DefectKind.CROWDED):
        raise error
    if not repair and not split and len(shape.faces) > _HINTED:
        raise error
    try:
        blocks = mended_blocks(_scaled(shape, scale), shape.faces, shape.name, shape.density)
    except InputError:
        raise error from None
    if selfcontact.self_contacts([b.vertices for b in blocks], [b.faces for b in blocks]):
        raise error
    notes = blocks[0].repairs
    only_split = len(notes) == 2 and notes[0].startswith("split")
    if not repair and not (split and only_split):
        options = "--split or --repair" if only_split else "--repair"
        said = f"{error.remedy}; {options} would mend it ({'; '.join(notes)})"
        raise error.located(error.where, said)
    made: list[Block | None] = [
        replace_block(block, metadata=shape.metadata, repairs=shape.repairs) for block in blocks
    ]
    return made, [f"block '{shape.name}': {'; '.join(notes)}"]


def _plain(shapes: Sequence[DraftBlock], scale: float) -> list[Block | InputError]:
    """The block of each shape, or its defect.

    Coincident vertices are merged, and repeated faces left out, where this closes the surface.
    """
    made: list[Block | InputError] = []
    for shape in shapes:
        try:
            made.append(_block(shape, _scaled(shape, scale), shape.faces))
        except InputError as error:
            made.append(error)
    opened = [
        i
        for i, one in enumerate(made)
        if isinstance(one, InputError) and one.kind in (DefectKind.OPEN, DefectKind.CROWDED)
    ]
    points = [_scaled(shapes[i], scale) for i in opened]
    loops = [shapes[i].faces for i in opened]
    welded = coincidence.weld_each(points, loops, _SAME_PLACE)
    for i, vertices, (faces, merged) in zip(opened, points, welded, strict=True):
        once = list({frozenset(face): face for face in reversed(faces)}.values())[::-1]
        said = []
        if merged:
            said.append(f"{counted(merged, 'coincident vertex', 'coincident vertices')} merged")
        if len(once) < len(faces):
            twice = counted(
                len(faces) - len(once), "face that occurs twice", "faces that occur twice"
            )
            said.append(f"{twice} left out")
        if said:
            try:
                made[i] = _block(shapes[i], vertices, once, *said)
            except InputError as error:
                made[i] = error
    return made


def _on_surfaces(
    shapes: Sequence[DraftBlock],
    made: list[Block | InputError],
    scale: float,
    supports: str | None,
) -> list[Block | InputError]:
    """The same blocks, and one for each open surface that is fixed."""
    bare = [i for i, one in enumerate(made) if _is_open(one)]
    if not bare:
        return made
    held = np.array([shape.fixed for shape in shapes])
    if supports is not None:
        held = _chosen(shapes, made, scale, supports)
    free = [
        one for one, fixed in zip(made, held, strict=True) if isinstance(one, Block) and not fixed
    ]
    for i in bare:
        if held[i]:
            shape = shapes[i]
            points = _scaled(shape, scale)
            try:
                block = support_from_surface(points, shape.faces, free, shape.name, shape.density)
            except InputError:  # the first error says more
                continue
            notes = (*shape.repairs, *block.repairs)
            made[i] = replace_block(block, metadata=shape.metadata, repairs=notes)
    return made


def _is_open(one: Block | InputError) -> bool:
    return isinstance(one, InputError) and one.kind is DefectKind.OPEN


def _chosen(
    shapes: Sequence[DraftBlock], made: Sequence[Block | InputError], scale: float, supports: str
) -> Bools:
    """Mask of the shapes that ``supports`` would fix; those that cannot be placed are left out."""
    place = [i for i, one in enumerate(made) if isinstance(one, Block) or _is_open(one)]
    points = [_scaled(shapes[i], scale) for i in place]
    bottom = np.array([point[:, 2].min() for point in points])
    top = np.array([point[:, 2].max() for point in points])
    chosen = np.zeros(len(shapes), dtype=bool)
    chosen[place] = may_hold(supports, [shapes[i].name for i in place], bottom, top)
    return chosen


def _faces_at_holes(shape: DraftBlock, scale: float) -> list[Floats]:
    """Corners (c, 3) [m] of the faces with a missing neighbour."""
    vertices = _scaled(shape, scale)
    loops = [tuple(face) for face in shape.faces]
    return [vertices[list(loops[i])] for i in open_faces(loops)]


def _scaled(shape: DraftBlock, scale: float) -> Floats:
    """Vertices (v, 3) [m], within bounds."""
    vertices = frozen_floats(shape.vertices, (None, 3), "vertices")
    if scale != 1.0:
        vertices = frozen_floats(vertices * scale, (None, 3), "vertices")
    far = np.abs(vertices).max(initial=0.0)
    if far > _LARGEST_COORDINATE:
        raise InputError(
            f"a coordinate is {far:.3g} m", remedy=f"stay within {_LARGEST_COORDINATE:g} m"
        )
    return vertices


def _block(
    shape: DraftBlock, vertices: Floats, faces: Sequence[Sequence[int]], *notes: str
) -> Block:
    loops = tuple(tuple(face) for face in faces)
    repairs = (*shape.repairs, *notes)
    return Block(vertices, loops, shape.name, shape.density, shape.metadata, repairs)


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


def _self_contact_defects(blocks: list[Block], path: Path) -> tuple[list[InputError], list[int]]:
    """A defect for each place where a block touches itself, and the positions of these blocks."""
    found = selfcontact.self_contacts([b.vertices for b in blocks], [b.faces for b in blocks])
    return [
        FormatError(
            f"its surface {what}",
            where=f"{path}, block '{blocks[body].name}'",
            remedy="separate the parts there, or split it into two blocks",
        )
        for body, what in found
    ], [body for body, _ in found]


def _duplicate_defects(blocks: list[Block], path: Path) -> tuple[list[InputError], list[int]]:
    """A defect for each pair of duplicate blocks, and the second of each pair."""
    pairs = coincidence.duplicates([block.vertices for block in blocks], _SAME_PLACE)
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


def _repair_notes(blocks: list[Block]) -> list[str]:
    """One note per kind of repair, with the names of the first repaired blocks."""
    names: dict[str, list[str]] = defaultdict(list)
    for block in blocks:
        for repair in block.repairs:
            names[repair].append(f"'{block.name}'")
    notes = []
    for repair, repaired in names.items():
        many = "block" if len(repaired) == 1 else "blocks"
        notes.append(f"{many} {named(repaired, _MANY)}: {repair}")
    return notes


def _size_notes(blocks: list[Block], units: str | None) -> list[str]:
    if not blocks:
        return []
    low = np.min([block.bounds[0] for block in blocks], axis=0)
    high = np.max([block.bounds[1] for block in blocks], axis=0)
    extent = float((high - low).max())
    block = float(np.median([(one.bounds[1] - one.bounds[0]).max() for one in blocks]))
    weight = sum(one.mass for one in blocks)
    usual = _LIKELY_BLOCK[0] <= block <= _LIKELY_BLOCK[1] and weight <= _LIKELY_MASS
    if usual and _LIKELY_EXTENT[0] <= extent <= _LIKELY_EXTENT[1]:
        return []
    read_in = f"read in {units}" if units else "no unit was given, metres assumed"
    now = UNITS[units or "m"]
    likely = min(_METRIC, key=lambda unit: abs(np.log(block * UNITS[unit] / now / _USUAL_BLOCK)))
    remedy = f"--units {likely}" if likely != (units or "m") else "--units"
    return [
        f"the model is {extent:.3g} m across, its median block {block:.3g} m, and weighs"
        f" {mass(weight)}; {read_in}: is the unit right ({remedy})?"
    ]
