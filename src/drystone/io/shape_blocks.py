"""The blocks of unchecked shapes: closed and split where that is safe, mended where it is asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from drystone.assembly import Block, replace_block
from drystone.assembly.block import self_touching
from drystone.base.arrays import ROUNDING, Bools, Floats, frozen_floats
from drystone.base.errors import DefectKind, InputError, counted
from drystone.geometry import coincidence
from drystone.geometry.soup import separate_parts
from drystone.geometry.surface import open_faces
from drystone.io.draft import DraftBlock
from drystone.repair import mended_blocks, support_from_surface
from drystone.supports import may_hold

_LARGEST_COORDINATE = 1e9
"""[m], chosen: far above any structure, far below where products of coordinates overflow."""
_HINTED = 2000
"""Faces up to which a repair, or a split, is tried only to say that it would work. Chosen: some
tenths of a second."""
_MENDABLE = (DefectKind.OPEN, DefectKind.CROWDED, DefectKind.TOUCHING)

Made: TypeAlias = list[Block | None] | InputError
"""The blocks of one shape, or its defect."""


def blocks_of(
    shapes: Sequence[DraftBlock],
    scale: float,
    supports: str | None,
    *,
    split: bool,
    repair: bool,
) -> tuple[list[Made], list[str]]:
    """The blocks of each shape or its defect, and notes.

    Parameters
    ----------
    shapes
    scale
        [m per unit]
    supports, split, repair
        As in :func:`drystone.io.build.try_blocks`.
    """
    made: list[Made] = []
    notes: list[list[str]] = []
    for plain in _with_supports(shapes, scale, supports):
        try:
            own, said = _in_parts(plain, split) if isinstance(plain, Block) else (plain, [])
        except InputError as error:
            own, said = error, []
        made.append(own)
        notes.append(said)
    for i, touching in _touching(made):
        made[i] = touching
    for i, one in enumerate(made):
        if isinstance(one, InputError):
            try:
                made[i], notes[i] = _repaired(shapes[i], scale, one, repair, split)
            except InputError as error:
                made[i], notes[i] = error, []
    return made, [note for said in notes for note in said]


def _touching(made: Sequence[Made]) -> list[tuple[int, InputError]]:
    """The shapes with a block that touches itself, and the error of each."""
    owned = [(i, b) for i, own in enumerate(made) if isinstance(own, list) for b in own if b]
    first: dict[int, InputError] = {}
    for body, error in self_touching([block for _, block in owned]):
        first.setdefault(owned[body][0], error)
    return [*first.items()]


def _in_parts(block: Block, split: bool) -> tuple[Made, list[str]]:
    """A block with correctly oriented shells, or its parts if ``split``."""
    parts, turned = separate_parts(block.vertices, block.faces)
    if turned:
        loops = tuple(loop for part in parts for loop in part)
        note = f"{turned} of its shells turned"
        block = replace_block(block, faces=loops, repairs=(*block.repairs, note))
    if len(parts) == 1:
        return [block], []
    corners = [block.vertices[sorted({i for loop in part for i in loop})] for part in parts]
    if coincidence.duplicates(corners, ROUNDING):
        raise InputError(
            "a part of it is there twice, at the same place",
            where=f"block '{block.name}'",
            remedy="remove one of them",
            kind=DefectKind.TOUCHING,
        )
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
) -> tuple[Made, list[str]]:
    """The blocks of a broken mesh, and what was done; else its error, with the option to use."""
    if error.kind is DefectKind.CROSSING:
        raise _or_split(shape, scale, error, split)
    if error.kind not in _MENDABLE or (not (repair or split) and len(shape.faces) > _HINTED):
        raise error
    try:
        blocks = mended_blocks(_scaled(shape, scale), shape.faces, shape.name, shape.density)
    except InputError:
        raise error from None
    notes = blocks[0].repairs
    if self_touching(blocks) or not notes:
        raise error
    mends = notes[:-1]  # the last one tells the volume
    parted = mends[-1].startswith("split")
    if not repair and not (split and parted and len(mends) == 1):
        by_split = parted and (len(mends) == 1 or error.kind is DefectKind.TOUCHING)
        options = "--split or --repair" if by_split else "--repair"
        said = f"{error.remedy}; {options} would mend it ({'; '.join(notes)})"
        raise error.located(error.where, said)
    made: list[Block | None] = [
        replace_block(block, metadata=shape.metadata, repairs=shape.repairs) for block in blocks
    ]
    return made, [f"block '{shape.name}': {'; '.join(notes)}"]


def _or_split(shape: DraftBlock, scale: float, error: InputError, split: bool) -> InputError:
    """The error, with the option that makes blocks of its parts where these are sound."""
    block = _tried(shape, scale)
    if split or isinstance(block, InputError) or len(shape.faces) > _HINTED:
        return error
    try:
        made, _ = _in_parts(block, split=True)
    except InputError:
        return error
    parts = [part for part in made if part] if isinstance(made, list) else []
    if len(parts) < 2 or self_touching(parts):
        return error
    said = f"{error.remedy}; --split makes blocks of its {len(parts)} parts"
    return error.located(error.where, said)


def _plain(shapes: Sequence[DraftBlock], scale: float) -> list[Block | InputError]:
    """The block of each shape, or its defect.

    Coincident vertices are merged, and repeated faces left out, where this closes the surface.
    """
    made = [_tried(shape, scale) for shape in shapes]
    opened = [
        i for i, one in enumerate(made) if isinstance(one, InputError) and one.kind in _MENDABLE
    ]
    points = [_scaled(shapes[i], scale) for i in opened]
    loops = [shapes[i].faces for i in opened]
    welded = coincidence.weld_each(points, loops, ROUNDING)
    for i, vertices, (faces, merged) in zip(opened, points, welded, strict=True):
        once = list({frozenset(face): face for face in reversed(faces)}.values())[::-1]
        twice = len(faces) - len(once)
        said = []
        if merged:
            said.append(f"{counted(merged, 'coincident vertex', 'coincident vertices')} merged")
        if twice:
            what = counted(twice, "face that occurs twice", "faces that occur twice")
            said.append(f"{what} left out")
        if said:
            made[i] = _tried(replace(shapes[i], vertices=vertices, faces=once), 1.0, *said)
    return made


def _tried(shape: DraftBlock, scale: float, *notes: str) -> Block | InputError:
    """The block of a shape, or its defect."""
    if shape.defect is not None:
        return shape.defect
    try:
        loops = tuple(tuple(face) for face in shape.faces)
        repairs = (*shape.repairs, *notes)
        points = _scaled(shape, scale)
        return Block(points, loops, shape.name, shape.density, shape.metadata, repairs)
    except InputError as error:
        return error


def _with_supports(
    shapes: Sequence[DraftBlock], scale: float, supports: str | None
) -> list[Block | InputError]:
    """The block of each shape, also of an open surface that is fixed, or its defect."""
    made = _plain(shapes, scale)
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
            except InputError as error:
                remedy = error.remedy or "draw a face, a terrain, a frame or a closed body"
                made[i] = InputError(error.what, remedy=remedy, kind=DefectKind.OPEN)
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


def faces_at_holes(shape: DraftBlock, scale: float) -> list[Floats]:
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
