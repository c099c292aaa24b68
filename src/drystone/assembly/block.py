"""A block: a closed polyhedron with a density.

Blocks whose surface touches or crosses itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any
from weakref import WeakSet

import numpy as np

from drystone.base.arrays import Bools, Floats, frozen, frozen_floats, frozen_points, number
from drystone.base.display import OneLine
from drystone.base.errors import DefectKind, InputError, located
from drystone.geometry.polyhedron import Fan, body_mass_properties
from drystone.geometry.selfcontact import self_contacts
from drystone.geometry.soup import separate_parts
from drystone.geometry.surface import closed_surface, fan_of

DEFAULT_DENSITY = 2400.0
"""[kg/m3], chosen: dense limestone and plain concrete. Verdicts under self-weight do not depend
on a common density."""

_FLAT = 1e-12
"""A block whose volume is less than this share of its bounding box diagonal cubed is refused:
rounding of its coordinates decides the sign."""

_SMALLEST = 1e-30
"""[m], chosen: far below the size of any block."""


@dataclass(frozen=True, eq=False)
class Block(OneLine):
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
    checked
        Whether a search of contacts refuses it where its surface touches or crosses itself, as a
        file is refused. ``False`` takes it as it is.

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
    checked: bool = True

    def __post_init__(self) -> None:
        where = f"block '{self.name}'"
        if not isinstance(self.name, str) or not self.name:
            raise InputError("a block needs a name", remedy="give a non-empty string")
        density = _density(self.density, where)
        with located(where):
            vertices = frozen_points(self.vertices, (None, 3), "vertices")
            surface = closed_surface(self.faces, len(vertices))
        set_ = object.__setattr__
        set_(self, "faces", surface.loops)
        set_(self, "density", density)
        set_(self, "metadata", MappingProxyType(dict(self.metadata)))
        set_(self, "repairs", (*self.repairs, *surface.notes))
        if self._lie(frozen(surface.select(vertices)), surface.fan):
            turned = surface.turned()
            set_(self, "faces", turned.loops)
            set_(self, "repairs", (*self.repairs, *turned.notes[len(surface.notes) :]))

    def _lie(self, vertices: Floats, fan: Fan) -> bool:
        """Lay the vertices (v, 3) [m] somewhere; whether the faces point inwards there."""
        where = f"block '{self.name}'"
        bounds = frozen(np.array([vertices.min(axis=0), vertices.max(axis=0)]))
        extent = math.dist(*bounds.tolist())
        if 0.0 < extent < _SMALLEST:
            raise InputError(f"it is {extent:.3g} m across", where=where, remedy="give metres")
        volume, centroid = body_mass_properties(vertices, fan)
        if abs(volume) <= _FLAT * extent**3:
            raise InputError(
                f"its volume is zero ({volume:.3g} m3)", where=where, remedy="give it a thickness"
            )
        set_ = object.__setattr__
        set_(self, "vertices", vertices)
        set_(self, "volume", abs(volume))
        set_(self, "centroid", frozen(centroid))
        set_(self, "bounds", bounds)
        return volume < 0.0

    def _summary(self) -> str:
        return (
            f"'{self.name}', {len(self.vertices)} vertices, {len(self.faces)} faces, "
            f"{self.volume:.3g} m3, {self.density:g} kg/m3"
        )

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"metadata": dict(self.metadata)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Arrays of a block from another process are read-only too."""
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
        made = object.__new__(Block)
        made.__dict__.update(self.__dict__)
        if mirrored:
            object.__setattr__(made, "faces", tuple(face[::-1] for face in self.faces))
        with located(f"block '{self.name}'"):
            vertices = frozen_points(moved, (None, 3), "vertices")
        made._lie(vertices, fan_of(made.faces, len(vertices)))
        return made

    def renamed(self, name: str) -> Block:
        """The same block under another name."""
        return replace_block(self, name=name)


def replace_block(block: Block, **changes: Any) -> Block:
    """A copy of ``block`` with some of its arguments changed.

    Parameters
    ----------
    block
        Is not changed.
    changes
        New values of arguments of :class:`Block`, by their names.
    """
    arguments = {
        key: getattr(block, key)
        for key in ("vertices", "faces", "name", "density", "metadata", "repairs", "checked")
    }
    return Block(**(arguments | changes))


def _density(value: Any, where: str) -> float:
    density = number(value, f"{where}: density", finite=False)
    if not 0.0 < density < float("inf"):
        raise InputError(f"density is {density}", where=where, remedy="give kg/m3 above zero")
    return density


_SOUND: WeakSet[Block] = WeakSet()
"""Blocks that were found sound; a block never changes."""


def self_touching(blocks: Sequence[Block]) -> list[tuple[int, InputError]]:
    """Which of some blocks touch or cross themselves, and the error of each.

    A block that was made with ``checked=False`` is taken as it is.
    """
    new = [i for i, block in enumerate(blocks) if block.checked and block not in _SOUND]
    chosen = [blocks[i] for i in new]
    found = self_contacts([one.vertices for one in chosen], [one.faces for one in chosen])
    faulty = {body for body, _ in found}
    _SOUND.update(block for i, block in enumerate(chosen) if i not in faulty)
    return [
        (
            new[body],
            InputError(
                f"its surface {what}",
                where=f"block '{chosen[body].name}'",
                remedy="separate the parts there, or split it into two blocks",
                kind=DefectKind.TOUCHING if what.startswith("touches") else DefectKind.CROSSING,
            ),
        )
        for body, what in found
    ]


def require_sound(blocks: Sequence[Block], simple: Bools | None = None) -> None:
    """Raise InputError where a block touches or crosses itself, or a shell of it is inside out.

    Not where (n,) it is known not to.

    What is known once is not looked at again.
    """
    if simple is not None:
        _SOUND.update(blocks[i] for i in np.flatnonzero(simple).tolist())
    new = [one for one in blocks if one.checked and one not in _SOUND]
    for one in new:
        if separate_parts(one.vertices, one.faces)[1]:
            raise InputError(
                "a shell of it is inside out: what lies in it counts twice, or is missing",
                where=f"block '{one.name}'",
                remedy="turn the faces of that shell",
            )
    for _, error in self_touching(new) if new else ():
        raise error
