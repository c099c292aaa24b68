"""An assembly: the blocks of a structure, and which of them are fixed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral
from typing import Any, TypeAlias

import numpy as np

from drystone.assembly.block import Block, replace_block
from drystone.base import units
from drystone.base.arrays import Bools, Floats, Ints, frozen, frozen_floats, marked, of_type, whole
from drystone.base.display import Card
from drystone.base.errors import InputError, counted, meant, quoted
from drystone.geometry import polyhedron
from drystone.geometry.frames import rotations

Blocks: TypeAlias = int | str | Iterable[int | str] | Bools
"""Some blocks: names and positions, or one of them; or a mask (n,)."""


@dataclass(frozen=True, eq=False)
class Assembly(Card):
    """Blocks, some of them fixed. The position of a block identifies it in all results.

    Parameters
    ----------
    blocks
        Names are unique.
    fixed : (n,) bool
        Supports; all free when left out.

    Raises
    ------
    InputError
        No block, two blocks with one name, or a mask of another length.

    Examples
    --------
    >>> from drystone.models import tower
    >>> assembly = tower(3)
    >>> assembly.names
    ('block-0', 'block-1', 'block-2')
    >>> assembly.fixed.tolist()
    [True, False, False]
    >>> assembly["block-1"].mass, "block-7" in assembly, len(assembly)
    (2400.0, False, 3)
    """

    blocks: tuple[Block, ...]
    fixed: Bools = None  # type: ignore[assignment]  # filled in below

    def __post_init__(self) -> None:
        blocks = tuple(self.blocks) if isinstance(self.blocks, Iterable) else (self.blocks,)
        strange = [block for block in blocks if not isinstance(block, Block)]
        if strange:
            said = quoted(strange[0])
            raise InputError(f"{said} is not a block", remedy="give a list of Block(...)")
        if not blocks:
            raise InputError("the assembly has no blocks", remedy="give at least one")
        seen: dict[str, int] = {}
        for i, block in enumerate(blocks):
            if block.name in seen:
                raise InputError(
                    f"blocks {seen[block.name]} and {i} have the same name, '{block.name}'",
                    remedy="rename one of them",
                )
            seen[block.name] = i
        mask = np.zeros(len(blocks), dtype=bool) if self.fixed is None else np.array(self.fixed)
        if mask.shape != (len(blocks),) or mask.dtype != bool:
            raise InputError(f"fixed must hold {len(blocks)} booleans, got {mask.shape}")
        object.__setattr__(self, "blocks", blocks)
        object.__setattr__(self, "fixed", frozen(mask))
        object.__setattr__(self, "_position", seen)

    def _summary(self) -> str:
        return f"{counted(len(self), 'block')}, {int(self.fixed.sum())} fixed"

    def _facts(self) -> tuple[str, Mapping[str, object]]:
        low, high = self.bounds[:, 0].min(axis=0), self.bounds[:, 1].max(axis=0)
        return f"{counted(len(self), 'block')}, {int(self.fixed.sum())} of them fixed", {
            "size": units.extent(high - low),
            "volume": f"{self.volume.sum():.4g} m3",
            "mass": units.mass(float(self.mass.sum())),
            "fixed": ", ".join(self.names[i] for i in np.flatnonzero(self.fixed)),
        }

    def __len__(self) -> int:
        return len(self.blocks)

    def __iter__(self) -> Iterator[Block]:
        return iter(self.blocks)

    def __contains__(self, block: object) -> bool:
        """Whether there is a block with this name, or this block."""
        if isinstance(block, str):
            return block in self._position  # type: ignore[attr-defined]
        return any(block is one for one in self.blocks)

    def __getitem__(self, block: int | str) -> Block:
        """The block of a name or a position; negative positions count from the end."""
        if isinstance(block, Integral) and -len(self) <= block < 0:
            block = int(block) + len(self)
        elif not isinstance(block, str | Integral):
            raise InputError(
                f"a block is asked for by {quoted(block)}",
                remedy="give its name or position; subset(...) takes several",
            )
        return self.blocks[self.indices(block)[0]]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Block names, by position."""
        return tuple(block.name for block in self.blocks)

    @cached_property
    def free(self) -> Ints:
        """Positions of the blocks that are not fixed."""
        return frozen(np.flatnonzero(~self.fixed))

    @cached_property
    def volume(self) -> Floats:
        """(n,) [m3]"""
        return frozen(np.array([block.volume for block in self.blocks]))

    @cached_property
    def mass(self) -> Floats:
        """(n,) [kg]"""
        return frozen(np.array([block.mass for block in self.blocks]))

    @cached_property
    def centroid(self) -> Floats:
        """(n, 3) [m]"""
        return frozen(np.array([block.centroid for block in self.blocks]))

    @cached_property
    def bounds(self) -> Floats:
        """(n, 2, 3) [m], axis-aligned bounding box of each block."""
        return frozen(np.stack([block.bounds for block in self.blocks]))

    @cached_property
    def size(self) -> Floats:
        """(n,) [m], bounding box diagonal of each block."""
        return frozen(np.linalg.norm(self.bounds[:, 1] - self.bounds[:, 0], axis=1))

    @cached_property
    def faces(self) -> polyhedron.Faces:
        """The faces of all blocks as flat arrays."""
        return polyhedron.stack_faces(
            [block.vertices for block in self.blocks], [block.faces for block in self.blocks]
        )

    def index(self, name: str) -> int:
        """Position of the block called ``name``.

        Raises
        ------
        InputError
            There is none; close names are suggested.
        """
        position: dict[str, int] = self._position  # type: ignore[attr-defined]
        of_type(name, str, "the name of a block", "give a string; indices(...) takes positions")
        if name not in position:
            raise InputError(f"no block is called '{name}'", remedy=meant(name, self.names))
        return position[name]

    def indices(self, blocks: Blocks) -> Ints:
        """Positions of blocks.

        Parameters
        ----------
        blocks
            Names and positions, or one of them; or a mask (n,) bool, as an array or a list.

        Raises
        ------
        InputError
            There is no such block, or it is none of these; or 0 and 1 are given once per block,
            which may be a mask or positions.
        """
        if isinstance(blocks, str | Integral):
            blocks = [blocks]
        if isinstance(blocks, np.ndarray):
            blocks = np.atleast_1d(blocks)
        if not isinstance(blocks, Iterable):
            said = quoted(blocks)
            raise InputError(f"blocks are {said}", remedy="give names or positions of blocks")
        if not isinstance(blocks, np.ndarray):
            blocks = list(blocks)
        kinds = {type(b) for b in blocks} if isinstance(blocks, list) else {blocks.dtype.type}
        if kinds and kinds <= {bool, np.bool_}:
            shape = np.shape(blocks)
            if shape != (len(self),):
                raise InputError(f"a mask of blocks has shape {shape}, not ({len(self)},)")
            return np.flatnonzero(blocks)
        found = [
            b if type(b) is int else self.index(b) if isinstance(b, str) else whole(b, "a block")
            for b in blocks
        ]
        if found and not (min(found) >= 0 and max(found) < len(self)):
            strange = next(i for i in found if not 0 <= i < len(self))
            raise InputError(f"there is no block {strange}", remedy=f"0 to {len(self) - 1} exist")
        if 2 < len(found) == len(self) and max(found) <= 1 and kinds.isdisjoint({str, np.str_}):
            remedy = "give a mask of bool, such as mask.astype(bool), or each position once"
            raise InputError("blocks are 0 and 1, one for each block", remedy=remedy)
        return np.array(found, dtype=np.intp)

    def subset(self, blocks: Blocks) -> Assembly:
        """The assembly of some of the blocks, in the given order."""
        chosen = self.indices(blocks)
        return Assembly(tuple(self.blocks[i] for i in chosen), self.fixed[chosen])

    def without(self, blocks: Blocks) -> Assembly:
        """The assembly without some of the blocks."""
        gone = marked(self.indices(blocks), len(self))
        return self.subset(np.flatnonzero(~gone).tolist())

    def with_fixed(self, blocks: Blocks) -> Assembly:
        """The same blocks with exactly the given ones fixed."""
        mask = marked(self.indices(blocks), len(self))
        return Assembly(self.blocks, mask)

    def moved(self, motion: Floats) -> Assembly:
        """The blocks after a motion (n, 6) [m, rad]: translation, and rotation about centroids."""
        rows = zip(self.blocks, self.centroid, motion, rotations(motion[:, 3:]), strict=True)
        moved = [
            block.transformed(turn, at + move[:3] - turn @ at) if move.any() else block
            for block, at, move, turn in rows
        ]
        return Assembly(tuple(moved), self.fixed)

    def transformed(self, rotation: Any = None, translation: Any = (0.0, 0.0, 0.0)) -> Assembly:
        """Every block moved by ``rotation @ x + translation``; see :meth:`Block.transformed`."""
        return Assembly(
            tuple(block.transformed(rotation, translation) for block in self.blocks), self.fixed
        )

    def with_density(self, density: float | Sequence[float]) -> Assembly:
        """The same blocks with another density [kg/m3], one value or one per block."""
        given = frozen_floats(density, (len(self),) if np.ndim(density) else (), "density")
        each = np.broadcast_to(given, (len(self),))
        return Assembly(
            tuple(
                replace_block(block, density=float(rho))
                for block, rho in zip(self.blocks, each, strict=True)
            ),
            self.fixed,
        )
