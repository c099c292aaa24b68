"""Blocks and assemblies: what the structure is made of."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from drystone.errors import InputError
from drystone.geometry import polyhedron
from drystone.geometry.arrays import Bools, Floats, Ints, frozen, frozen_floats, frozen_points
from drystone.geometry.polyhedron import body_mass_properties
from drystone.geometry.surface import closed_surface

DEFAULT_DENSITY = 2400.0
"""[kg/m3], chosen: dense limestone and plain concrete. Verdicts under self-weight do not depend
on a common density."""

FLAT = 1e-12
"""A block whose volume is less than this share of its bounding box diagonal cubed is refused:
rounding of its coordinates decides the sign."""

SMALLEST = 1e-30
"""[m], chosen: as far below any block as :data:`drystone.geometry.arrays.FARTHEST` is above."""


@dataclass(frozen=True, eq=False)
class Block:
    """A rigid polyhedron, convex or concave, with polygon faces.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops of vertex indices, counter-clockwise seen from outside; concave loops are fine. A face
        with a hole is given as several faces.
    name
        Unique in an assembly.
    density : [kg/m3]
    metadata
        Anything a file says about the block; kept, not used.

    Attributes
    ----------
    repairs
        What had to be mended: faces turned, unused vertices dropped. Empty for a clean block.

    Raises
    ------
    InputError
        Open, non-manifold, self-touching, flat, or not finite; the offending edges are named.

    Examples
    --------
    >>> from drystone.models import box
    >>> block = box((1.0, 2.0, 0.5), name="base", density=2000.0)
    >>> float(block.volume), float(block.mass)
    (1.0, 2000.0)
    """

    vertices: Floats
    faces: tuple[tuple[int, ...], ...]
    name: str = "block"
    density: float = DEFAULT_DENSITY
    metadata: Mapping[str, Any] = field(default_factory=dict)
    repairs: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        where = f"block '{self.name}'"
        if not isinstance(self.name, str) or not self.name:
            raise InputError("a block needs a name", remedy="give a non-empty string")
        density = _density(self.density, where)
        try:
            vertices = frozen_points(self.vertices, (None, 3), "vertices")
            surface = closed_surface(self.faces, len(vertices))
        except InputError as error:
            raise InputError(error.what, where=where, remedy=error.remedy) from error
        vertices = frozen(surface.select(vertices))
        bounds = frozen(np.array([vertices.min(axis=0), vertices.max(axis=0)]))
        extent = math.dist(*bounds.tolist())
        if 0.0 < extent < SMALLEST:
            raise InputError(f"it is {extent:.3g} m across", where=where, remedy="give metres")
        volume, centroid = body_mass_properties(vertices, surface.fan)
        if abs(volume) <= FLAT * extent**3:
            raise InputError(
                f"its volume is zero ({volume:.3g} m3)", where=where, remedy="give it a thickness"
            )
        if volume < 0.0:
            surface, volume = surface.turned(), -volume
        set_ = object.__setattr__
        set_(self, "vertices", vertices)
        set_(self, "faces", surface.loops)
        set_(self, "density", density)
        set_(self, "metadata", MappingProxyType(dict(self.metadata)))
        set_(self, "repairs", (*self.repairs, *surface.notes))
        set_(self, "volume", volume)
        set_(self, "centroid", frozen(centroid))
        set_(self, "bounds", bounds)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"metadata": dict(self.metadata)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """A block from another process is as read-only as its original."""
        self.__dict__.update(state | {"metadata": MappingProxyType(state["metadata"])})
        for value in self.__dict__.values():
            if isinstance(value, np.ndarray):
                frozen(value)

    volume: float = field(init=False, repr=False)
    """[m3]"""
    centroid: Floats = field(init=False, repr=False)
    """(3,) [m]"""
    bounds: Floats = field(init=False, repr=False)
    """(2, 3) [m], lowest and highest corner of the axis-aligned bounding box."""

    @property
    def mass(self) -> float:
        """[kg]"""
        return self.volume * self.density

    @property
    def size(self) -> float:
        """[m], diagonal of the bounding box."""
        return float(np.linalg.norm(self.bounds[1] - self.bounds[0]))

    def transformed(self, rotation: Any = None, translation: Any = (0.0, 0.0, 0.0)) -> Block:
        """The block moved by ``rotation @ x + translation``.

        Parameters
        ----------
        rotation : (3, 3), optional
            Any invertible matrix: a mirror image keeps its faces outwards, a scale scales.
        translation : (3,) [m]
        """
        matrix = np.eye(3) if rotation is None else frozen_floats(rotation, (3, 3), "rotation")
        with np.errstate(over="ignore", invalid="ignore"):  # what is too far is refused below
            moved = self.vertices @ matrix.T + frozen_floats(translation, (3,), "translation")
            mirrored = np.linalg.det(matrix) < 0.0
        faces = tuple(f[::-1] for f in self.faces) if mirrored else self.faces
        return Block(moved, faces, self.name, self.density, self.metadata, self.repairs)

    def renamed(self, name: str) -> Block:
        """The same block under another name."""
        return replace_block(self, name=name)


def replace_block(block: Block, **changes: Any) -> Block:
    """A copy of ``block`` with some of its arguments changed."""
    arguments = {
        key: getattr(block, key)
        for key in ("vertices", "faces", "name", "density", "metadata", "repairs")
    }
    return Block(**(arguments | changes))


def _density(value: Any, where: str) -> float:
    try:
        density = float(value)
    except (TypeError, ValueError) as error:
        raise InputError("density must be a number in kg/m3", where=where) from error
    if not (np.isfinite(density) and density > 0.0):
        raise InputError(f"density is {density}", where=where, remedy="give kg/m3 above zero")
    return density


@dataclass(frozen=True, eq=False)
class Assembly:
    """Blocks, some of them fixed. A block is known by its position, everywhere.

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
    """

    blocks: tuple[Block, ...]
    fixed: Bools = None  # type: ignore[assignment]  # filled in below

    def __post_init__(self) -> None:
        blocks = tuple(self.blocks)
        if not blocks:
            raise InputError("the assembly has no blocks", remedy="give at least one")
        seen: dict[str, int] = {}
        for i, block in enumerate(blocks):
            if block.name in seen:
                raise InputError(
                    f"blocks {seen[block.name]} and {i} have one name, '{block.name}'",
                    remedy="rename one of them",
                )
            seen[block.name] = i
        mask = np.zeros(len(blocks), dtype=bool) if self.fixed is None else np.array(self.fixed)
        if mask.shape != (len(blocks),) or mask.dtype != bool:
            raise InputError(f"fixed must hold {len(blocks)} booleans, got {mask.shape}")
        object.__setattr__(self, "blocks", blocks)
        object.__setattr__(self, "fixed", frozen(mask))
        object.__setattr__(self, "_position", seen)

    def __len__(self) -> int:
        return len(self.blocks)

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
        if name not in position:
            import difflib  # only needed to word the error

            close = difflib.get_close_matches(name, self.names, n=3)
            hint = f"did you mean {', '.join(close)}?" if close else "see 'drystone inspect'"
            raise InputError(f"no block is called '{name}'", remedy=hint)
        return position[name]

    def indices(self, blocks: Iterable[int | str]) -> Ints:
        """Positions of blocks given by position or by name."""
        found = [self.index(b) if isinstance(b, str) else int(b) for b in blocks]
        for i in found:
            if not 0 <= i < len(self):
                raise InputError(f"there is no block {i}", remedy=f"0 to {len(self) - 1} exist")
        return np.array(found, dtype=np.intp)

    def subset(self, blocks: Iterable[int | str]) -> Assembly:
        """The assembly of some of the blocks, in the given order."""
        chosen = self.indices(blocks)
        return Assembly(tuple(self.blocks[i] for i in chosen), self.fixed[chosen])

    def without(self, blocks: Iterable[int | str]) -> Assembly:
        """The assembly less some of the blocks."""
        gone = np.zeros(len(self), dtype=bool)
        gone[self.indices(blocks)] = True
        return self.subset(np.flatnonzero(~gone).tolist())

    def with_fixed(self, blocks: Iterable[int | str]) -> Assembly:
        """The same blocks with exactly the given ones fixed."""
        mask = np.zeros(len(self), dtype=bool)
        mask[self.indices(blocks)] = True
        return Assembly(self.blocks, mask)

    def transformed(self, rotation: Any = None, translation: Any = (0.0, 0.0, 0.0)) -> Assembly:
        """Every block moved by ``rotation @ x + translation``; see :meth:`Block.transformed`."""
        return Assembly(
            tuple(block.transformed(rotation, translation) for block in self.blocks), self.fixed
        )

    def with_density(self, density: float | Sequence[float]) -> Assembly:
        """The same blocks with another density [kg/m3], one for all or one each."""
        each = np.broadcast_to(np.asarray(density, dtype=np.float64), (len(self),))
        return Assembly(
            tuple(
                replace_block(block, density=float(rho))
                for block, rho in zip(self.blocks, each, strict=True)
            ),
            self.fixed,
        )


__all__ = ["DEFAULT_DENSITY", "Assembly", "Block", "replace_block"]
