"""Load cases: one wrench per block, and motions of supports. Nothing is implicit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.errors import InputError
from drystone.geometry.arrays import Floats, Ints, frozen_floats
from drystone.geometry.frames import rotation_about, unit
from drystone.geometry.polygon import area_vectors
from drystone.geometry.polyhedron import Faces, fan_triangles, stack_faces
from drystone.geometry.solid import outside_distance
from drystone.geometry.triangulate import triangulate

STANDARD_GRAVITY = 9.81
"""[m/s2]"""
DOWN = (0.0, 0.0, -1.0)
OFF_BLOCK = 1e-6
"""A point farther from a block than this share of the block's size is told to be off it; chosen,
above the rounding of coordinates in model files."""
FACING = np.cos(np.deg2rad(30.0))
"""A face looks along a direction when its normal is within 30 degrees of it; chosen, so that the
top of a voussoir counts as its top."""


@dataclass(frozen=True, eq=False)
class LoadCase:
    """Wrenches on blocks.

    Parameters
    ----------
    wrench : (n, 6) [N, N m]
        Force and moment about each block's centroid, world axes. What acts on fixed blocks is
        carried by the ground and changes nothing.
    name
        For tables.
    notes
        What the user should hear about the load: a point that lies off its block.
    motion : (n, 6) [m, rad], optional
        Prescribed motion of supports: translation of the centroid and rotation vector about it,
        world axes. Only :func:`drystone.settle` answers to it; every other analysis refuses it.

    Examples
    --------
    >>> from drystone.models import tower
    >>> assembly = tower(2)
    >>> load = LoadCase.gravity(assembly) + 0.5 * LoadCase.point_load(
    ...     assembly, "block-1", force=(100.0, 0.0, 0.0))
    >>> load.wrench[1].round(1).tolist()
    [50.0, 0.0, -23544.0, 0.0, 0.0, 0.0]
    """

    wrench: Floats
    name: str = "load"
    notes: tuple[str, ...] = ()
    motion: Floats | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "wrench", frozen_floats(self.wrench, (None, 6), "wrench"))
        if self.motion is not None:
            given = frozen_floats(self.motion, (len(self.wrench), 6), "motion")
            object.__setattr__(self, "motion", given if given.any() else None)
        object.__setattr__(self, "notes", tuple(self.notes))

    @classmethod
    def gravity(
        cls, assembly: Assembly, g: float = STANDARD_GRAVITY, direction: Any = DOWN
    ) -> LoadCase:
        """Self-weight.

        Parameters
        ----------
        assembly
        g : [m/s2]
        direction : (3,)
            Any length; gravity acts along it.
        """
        wrench = np.zeros((len(assembly), 6))
        wrench[:, :3] = assembly.mass[:, None] * (float(g) * unit(direction, "gravity direction"))
        return cls(wrench, "gravity")

    @classmethod
    def tilt(
        cls, assembly: Assembly, axis: Any, angle_deg: float, g: float = STANDARD_GRAVITY
    ) -> LoadCase:
        """Self-weight when the whole assembly is turned counter-clockwise about ``axis``.

        The blocks stay where they are and gravity turns the other way, which is the same.

        Parameters
        ----------
        assembly
        axis : (3,)
        angle_deg : [degrees]
        g : [m/s2]
        """
        direction = rotation_about(axis, angle_deg).T @ np.array(DOWN)
        return cls(cls.gravity(assembly, g, direction).wrench, f"tilt {angle_deg:g} deg")

    @classmethod
    def seismic(
        cls, assembly: Assembly, kx: float, ky: float = 0.0, g: float = STANDARD_GRAVITY
    ) -> LoadCase:
        """Horizontal forces in proportion to the weight, without the weight itself.

        Parameters
        ----------
        assembly
        kx, ky
            Seismic coefficients: horizontal acceleration along x and y by that of gravity.
        g : [m/s2]
        """
        shares = frozen_floats((kx, ky, 0.0), (3,), "seismic coefficient")
        wrench = np.zeros((len(assembly), 6))
        wrench[:, :3] = assembly.mass[:, None] * (float(g) * shares)
        return cls(wrench, f"seismic {float(kx):g}, {float(ky):g}")

    @classmethod
    def point_load(
        cls, assembly: Assembly, block: int | str, force: Any, at: Any = None
    ) -> LoadCase:
        """A force on a block.

        Parameters
        ----------
        assembly
        block
            Position or name of a free block.
        force : (3,) [N]
        at : (3,) [m], optional
            Left out, the centroid. A point off the block is used as given, with a note.

        Raises
        ------
        InputError
            There is no such block, or it is fixed.
        """
        i = _free_block(assembly, block)
        vector = frozen_floats(force, (3,), "force")
        point = assembly.centroid[i] if at is None else frozen_floats(at, (3,), "at")
        return cls(
            _on_one(assembly, i, vector[None], point[None]),
            "point load",
            _off_block(assembly, i, point),
        )

    @classmethod
    def line_load(
        cls, assembly: Assembly, block: int | str, force_per_length: Any, start: Any, end: Any
    ) -> LoadCase:
        """A force per length [N/m] (3,) on a free block, along a line between points [m] (3,)."""
        i = _free_block(assembly, block)
        ends = np.stack([frozen_floats(start, (3,), "start"), frozen_floats(end, (3,), "end")])
        length = float(np.linalg.norm(ends[1] - ends[0]))
        if length == 0.0:
            raise InputError("the line has no length", remedy="give two different points")
        total = length * frozen_floats(force_per_length, (3,), "force per length")
        notes = [note for point in ends for note in _off_block(assembly, i, point)]
        wrench = _on_one(assembly, i, total[None], ends.mean(axis=0)[None])
        return cls(wrench, "line load", tuple(notes))

    @classmethod
    def surface_load(
        cls,
        assembly: Assembly,
        block: int | str,
        traction: Any,
        faces: Sequence[int] | None = None,
        facing: Any = None,
    ) -> LoadCase:
        """A force per area on faces of a free block.

        Parameters
        ----------
        assembly
        block
        traction : (3,) or number [Pa]
            A vector, or a pressure against the faces.
        faces
            Which faces of the block; or
        facing : (3,)
            those that look along this direction, within 30 degrees. Left out both, all.

        Raises
        ------
        InputError
            No such face, none that looks that way, or faces chosen in both ways.
        """
        i = _free_block(assembly, block)
        part = stack_faces([assembly.blocks[i].vertices], [assembly.blocks[i].faces])
        chosen = _faces(part, faces, facing, assembly.names[i])
        triangles, face = fan_triangles(part)
        triangles = triangles[np.isin(face, chosen)]
        area = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        if np.ndim(traction) == 0:
            force = -float(frozen_floats(traction, (), "pressure")) * area
        else:
            size = np.linalg.norm(area, axis=1)
            force = size[:, None] * frozen_floats(traction, (3,), "traction")
        return cls(_on_one(assembly, i, force, triangles.mean(axis=1)), "surface load")

    @classmethod
    def moment(cls, assembly: Assembly, block: int | str, moment: Any) -> LoadCase:
        """A moment [N m] (3,), world axes, on a free block."""
        wrench = np.zeros((len(assembly), 6))
        wrench[_free_block(assembly, block), 3:] = frozen_floats(moment, (3,), "moment")
        return cls(wrench, "moment")

    @classmethod
    def extra_mass(
        cls,
        assembly: Assembly,
        block: int | str,
        mass: float,
        at: Any = None,
        g: float = STANDARD_GRAVITY,
        direction: Any = DOWN,
    ) -> LoadCase:
        """The weight of something [kg] that stands on a free block, at a point or its centroid."""
        carried = float(frozen_floats(mass, (), "mass"))
        if carried < 0.0:
            raise InputError(f"mass is {carried}", remedy="give kg of zero or more")
        force = carried * float(g) * unit(direction, "gravity direction")
        load = cls.point_load(assembly, block, force, at)
        return cls(load.wrench, f"{carried:g} kg", load.notes)

    @classmethod
    def settlement(cls, assembly: Assembly, block: int | str, motion: Any) -> LoadCase:
        """A prescribed motion of a support; no force by itself.

        Parameters
        ----------
        assembly
        block
            Position or name; whether it is fixed is asked where the case is used.
        motion : (3,) [m] or (6,) [m, rad]
            Translation of its centroid, and a rotation vector about it; world axes.

        Raises
        ------
        InputError
            There is no such block, or not 3 or 6 finite numbers.
        """
        i = int(assembly.indices([block])[0])
        values = frozen_floats(motion, (None,), f"motion of block '{assembly.names[i]}'")
        if len(values) not in (3, 6):
            raise InputError(
                f"the motion of block '{assembly.names[i]}' has not 3 or 6 numbers",
                remedy="give a translation, or a translation and a rotation vector",
            )
        moved = np.zeros((len(assembly), 6))
        moved[i, : len(values)] = values
        return cls(np.zeros_like(moved), "settlement", (), moved)

    @classmethod
    def combine(
        cls, parts: Iterable[tuple[float, LoadCase]], name: str = "combination"
    ) -> LoadCase:
        """The sum of load cases times their factors.

        Examples
        --------
        >>> from drystone.models import tower
        >>> dead = LoadCase.gravity(tower(2))
        >>> quake = LoadCase.seismic(tower(2), 0.2)
        >>> LoadCase.combine([(1.0, dead), (1.5, quake)]).wrench[1, [0, 2]].round(1).tolist()
        [7063.2, -23544.0]
        """
        cases = [float(factor) * load for factor, load in parts]
        if not cases:
            raise InputError("there is nothing to combine", remedy="give a load case")
        total = cases[0]
        for load in cases[1:]:
            total = total + load
        return cls(total.wrench, name, total.notes, total.motion)

    def __add__(self, other: LoadCase) -> LoadCase:
        if self.wrench.shape != other.wrench.shape:
            raise InputError("load cases of different assemblies cannot be added")
        notes = dict.fromkeys((*self.notes, *other.notes))
        motions = [one.motion for one in (self, other) if one.motion is not None]
        return LoadCase(
            self.wrench + other.wrench,
            f"{self.name} + {other.name}",
            tuple(notes),
            sum(motions[1:], motions[0]) if motions else None,
        )

    def __mul__(self, factor: float) -> LoadCase:
        by = float(factor)
        moved = None if self.motion is None else self.motion * by
        return LoadCase(self.wrench * by, f"{by:g} {self.name}", self.notes, moved)

    __rmul__ = __mul__


def _free_block(assembly: Assembly, block: int | str) -> int:
    i = int(assembly.indices([block])[0])
    if assembly.fixed[i]:
        raise InputError(
            f"block '{assembly.names[i]}' is fixed: a load on it changes nothing",
            remedy="load a free block",
        )
    return i


def _on_one(assembly: Assembly, block: int, force: Floats, point: Floats) -> Floats:
    """Wrenches (n, 6) of forces (f, 3) at points (f, 3) on one block."""
    wrench = np.zeros((len(assembly), 6))
    wrench[block, :3] = force.sum(axis=0)
    wrench[block, 3:] = np.cross(point - assembly.centroid[block], force).sum(axis=0)
    return wrench


def _off_block(assembly: Assembly, block: int, point: Floats) -> tuple[str, ...]:
    shape = assembly.blocks[block]
    faces = stack_faces([shape.vertices], [shape.faces])
    corner = faces.point[faces.loop]
    triangles = corner[triangulate(corner, faces.start)[0]]
    distance = float(outside_distance(point[None], triangles)[0])
    if distance <= OFF_BLOCK * shape.size:
        return ()
    where = ", ".join(f"{x:g}" for x in point)
    return (f"the point {where} is {distance:.3g} m off block '{shape.name}'",)


def _faces(part: Faces, faces: Sequence[int] | None, facing: Any, name: str) -> Ints:
    where = f"block '{name}'"
    if faces is not None and facing is not None:
        raise InputError("faces are chosen twice", where=where, remedy="by number or by direction")
    if faces is not None:
        chosen = np.asarray(list(faces), dtype=np.intp)
        if len(chosen) == 0 or chosen.min() < 0 or chosen.max() >= part.count:
            raise InputError(
                f"faces {list(faces)} are not all there",
                where=where,
                remedy=f"they are numbered 0 to {part.count - 1}",
            )
        return chosen
    if facing is None:
        return np.arange(part.count, dtype=np.intp)
    area = area_vectors(part.point[part.loop], part.start)
    along = area @ unit(facing, "facing")
    chosen = np.flatnonzero(along > (FACING - 1e-12) * np.linalg.norm(area, axis=1))
    if len(chosen) == 0:
        raise InputError("no face looks that way", where=where, remedy="choose faces by number")
    return chosen
