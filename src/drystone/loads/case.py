"""Load cases: one wrench per block, and motions of supports."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any, SupportsFloat

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, Ints, frozen_floats, number
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.geometry.frames import rotation_about, unit
from drystone.loads.placing import (
    CarriedMass,
    GivenLoad,
    SurfaceLoad,
    at_points,
    filled,
    free_block,
    multiplied,
    off_block,
    surface_forces,
    turned_points,
    turned_wrench,
    wrench_at,
    wrench_of_masses,
    wrench_of_points,
)

STANDARD_GRAVITY = 9.81
"""[m/s2]"""
DOWN = (0.0, 0.0, -1.0)


@dataclass(frozen=True, eq=False)
class LoadCase(OneLine):
    """Wrenches on blocks.

    Parameters
    ----------
    wrench : (n, 6) [N, N m]
        Force and moment about each block's centroid, world axes. Loads on fixed blocks have no
        effect.
    name
        For tables.
    notes
        Remarks for the user, such as a load point that lies outside its block.
    motion : (n, 6) [m, rad], optional
        Prescribed motion of supports: translation of the centroid and rotation vector about it,
        world axes. Only :func:`drystone.settle` uses it; every other analysis refuses it.
    acceleration : (3,) [m/s2]
        Of all masses, as far as it is known: a part of the wrenches, for tables and pictures.
    surface
        The tractions on faces among the wrenches, for pictures.
    fills
        The fill among the wrenches, through which a train presses.
    masses
        What blocks carry, its forces among the wrenches.
    shake : (3,) [m/s2]
        Of an earthquake: of the blocks, of these masses, and of those of all cases that are added.
    given : (n, 4, 3) [N, N m], optional
        Of the forces among the wrenches at points off their blocks: per block their sum, and the
        sums of their arms from its centroid along x, y and z times them.
    each
        The loads among the wrenches as they were asked for, beside accelerations and masses.

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
    acceleration: Floats = field(default_factory=lambda: np.zeros(3))
    surface: SurfaceLoad | None = None
    fills: tuple[Any, ...] = ()
    masses: tuple[CarriedMass, ...] = ()
    shake: Floats = field(default_factory=lambda: np.zeros(3))
    given: Floats | None = None
    each: tuple[GivenLoad, ...] = ()

    def __post_init__(self) -> None:
        for name in ("acceleration", "shake"):
            object.__setattr__(self, name, frozen_floats(getattr(self, name), (3,), name))
        object.__setattr__(self, "wrench", frozen_floats(self.wrench, (None, 6), "wrench"))
        if self.motion is not None:
            given = frozen_floats(self.motion, (len(self.wrench), 6), "motion")
            object.__setattr__(self, "motion", given if given.any() else None)
        if self.given is not None:
            given = frozen_floats(self.given, (len(self.wrench), 4, 3), "given")
            object.__setattr__(self, "given", given if given.any() else None)
        object.__setattr__(self, "notes", tuple(self.notes))
        object.__setattr__(self, "masses", tuple(self.masses))
        if any(len(one.mass) != len(self.wrench) for one in self.masses):
            raise InputError("carried masses and wrenches are of different assemblies")

    def _summary(self) -> str:
        total = ", ".join(f"{x:.4g}" for x in self.wrench[:, :3].sum(axis=0) + 0.0)
        moving = "" if self.motion is None else ", moves supports"
        return (
            f"'{self.name}', {counted(len(self.wrench), 'block')}, total force [{total}] N{moving}"
        )

    @classmethod
    def of(cls, assembly: Assembly, load: Any = None) -> LoadCase:
        """A load case from a load case, a number or a vector.

        Parameters
        ----------
        assembly
        load
            A load case of this assembly; a number, the multiple of gravity along -z; a vector (3,)
            [m/s2], an acceleration of all masses. Self-weight when left out.

        Raises
        ------
        InputError
            The load case belongs to another assembly, or the load is of another type.

        Examples
        --------
        >>> from drystone.models import tower
        >>> LoadCase.of(tower(2), (0.0, 0.0, -9.81)).wrench[1, 2].round(1)
        np.float64(-23544.0)
        """
        if load is None:
            return cls.gravity(assembly)
        if isinstance(load, LoadCase):
            if len(load.wrench) != len(assembly):
                raise InputError(
                    f"the load has {len(load.wrench)} wrenches, the assembly {len(assembly)} blocks"
                )
            return load
        try:
            given = frozen_floats(load, (3,) if np.ndim(load) else (), "load")
        except (TypeError, ValueError) as error:
            raise InputError(
                f"the load is {load!r}",
                remedy="give a load case, a multiple of gravity, or a vector in m/s2",
            ) from error
        if given.ndim == 0:
            return cls.gravity(assembly, float(given) * STANDARD_GRAVITY)
        return cls(wrench_of_masses(assembly, given), "gravity", acceleration=given)

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
        down = number(g, "g") * unit(direction, "gravity direction")
        return cls(wrench_of_masses(assembly, down), "gravity", acceleration=down)

    @classmethod
    def tilt(
        cls, assembly: Assembly, axis: Any, angle_deg: float, g: float = STANDARD_GRAVITY
    ) -> LoadCase:
        """Self-weight when the whole assembly is turned counter-clockwise about ``axis``.

        The blocks are not moved; gravity turns in the opposite sense, which is equivalent.

        Parameters
        ----------
        assembly
        axis : (3,)
        angle_deg : [degrees]
        g : [m/s2]
        """
        direction = rotation_about(axis, angle_deg).T @ np.array(DOWN)
        return replace(cls.gravity(assembly, g, direction), name=f"tilt {angle_deg:g} deg")

    @classmethod
    def seismic(
        cls, assembly: Assembly, kx: float, ky: float = 0.0, g: float = STANDARD_GRAVITY
    ) -> LoadCase:
        """Horizontal forces in proportion to the weight, without the weight itself.

        Those of blocks; with the load cases to which it is added, also those of the masses that
        blocks carry there: fill, and masses in kg. Forces are no masses.

        Parameters
        ----------
        assembly
        kx, ky
            Seismic coefficients: horizontal acceleration along x and y divided by g.
        g : [m/s2]
        """
        x, y = number(kx, "kx"), number(ky, "ky")
        with np.errstate(over="ignore"):  # what overflows is refused below
            level = number(g, "g") * np.array([x, y, 0.0])
        name = f"seismic {x:g}, {y:g} g"
        return cls(wrench_of_masses(assembly, level), name, acceleration=level, shake=level)

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
            The centroid when left out. A point outside the block is used as given, with a note.

        Raises
        ------
        InputError
            There is no such block, or it is fixed.
        """
        i = free_block(assembly, block)
        vector = frozen_floats(force, (3,), "force")
        point = assembly.centroid[i] if at is None else frozen_floats(at, (3,), "at")
        place = "" if at is None else f" at {_listed(point)} m"
        notes = () if at is None else off_block(assembly.blocks[i], point[None])
        name = f"{_listed(vector)} N on '{assembly.names[i]}'{place}"
        wrench = wrench_at(assembly, i, vector[None], point[None])
        given = None if at is None else at_points(assembly, i, vector, point)
        each = GivenLoad.of(name, wrench, given)
        return cls(wrench, name, notes, given=given if notes else None, each=each)

    @classmethod
    def line_load(
        cls, assembly: Assembly, block: int | str, force_per_length: Any, start: Any, end: Any
    ) -> LoadCase:
        """A force per length [N/m] (3,) on a free block, along a line between points [m] (3,)."""
        i = free_block(assembly, block)
        ends = np.stack([frozen_floats(start, (3,), "start"), frozen_floats(end, (3,), "end")])
        length = float(np.linalg.norm(ends[1] - ends[0]))
        if length == 0.0:
            raise InputError("the line has no length", remedy="give two different points")
        total = length * frozen_floats(force_per_length, (3,), "force per length")
        middle = ends.mean(axis=0)
        wrench = wrench_at(assembly, i, total[None], middle[None])
        name = f"{_listed(total)} N along a line of '{assembly.names[i]}'"
        notes = off_block(assembly.blocks[i], ends)
        given = at_points(assembly, i, total, middle)
        each = GivenLoad.of(name, wrench, given)
        return cls(wrench, name, notes, given=given if notes else None, each=each)

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
            Numbers of the faces; or
        facing : (3,)
            the faces with a normal within 30 degrees of this direction. All faces when both are
            left out.

        Raises
        ------
        InputError
            No such face, no face with that direction, or both ways of choosing at once.
        """
        i = free_block(assembly, block)
        force, triangle = surface_forces(assembly.blocks[i], traction, faces, facing)
        name = f"surface load on '{assembly.names[i]}'"
        wrench = wrench_at(assembly, i, force, triangle.mean(axis=1))
        surface = SurfaceLoad.of_triangles(i, force, triangle, wrench)
        return cls(wrench, name, surface=surface, each=GivenLoad.of(name, wrench))

    @classmethod
    def moment(cls, assembly: Assembly, block: int | str, moment: Any) -> LoadCase:
        """A moment [N m] (3,), world axes, on a free block."""
        i = free_block(assembly, block)
        wrench = np.zeros((len(assembly), 6))
        wrench[i, 3:] = frozen_floats(moment, (3,), "moment")
        name = f"moment {_listed(wrench[i, 3:])} N m on '{assembly.names[i]}'"
        return cls(wrench, name, each=GivenLoad.of(name, wrench))

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
        """The weight of a mass [kg] on a free block, at a point or at the centroid."""
        carried = float(frozen_floats(mass, (), "mass"))
        if carried < 0.0:
            raise InputError(f"mass is {carried}", remedy="give kg of zero or more")
        with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused below
            down = number(g, "g") * unit(direction, "gravity direction")
            load = cls.point_load(assembly, block, carried * down, at)
        place = load.name.partition(" N on ")[2]
        i = assembly.indices([block])
        point = assembly.centroid[i] if at is None else np.array([at], dtype=np.float64)
        made = CarriedMass.at(assembly, "mass", i, np.array([carried]), point, down)
        return cls(load.wrench, f"{carried:g} kg on {place}", load.notes, masses=(made,))

    @classmethod
    def settlement(cls, assembly: Assembly, block: int | str, motion: Any) -> LoadCase:
        """A prescribed motion of a support, without a force.

        Parameters
        ----------
        assembly
        block
            Position or name. :func:`drystone.settle` checks that it is fixed.
        motion : (3,) [m] or (6,) [m, rad]
            Translation of its centroid, and a rotation vector about it; world axes.

        Raises
        ------
        InputError
            There is no such block, or the motion is not 3 or 6 finite numbers.
        """
        i = int(assembly.indices([block])[0])
        values = frozen_floats(motion, (None,), f"motion of block '{assembly.names[i]}'")
        if len(values) not in (3, 6):
            raise InputError(
                f"the motion of block '{assembly.names[i]}' does not have 3 or 6 numbers",
                remedy="give a translation, or a translation and a rotation vector",
            )
        moved = np.zeros((len(assembly), 6))
        moved[i, : len(values)] = values
        shift, turn = (", ".join(f"{x:g}" for x in part + 0.0) for part in np.split(moved[i], 2))
        name = f"'{assembly.names[i]}' moved by {shift} m"
        name += f" and {turn} rad" if moved[i, 3:].any() else ""
        return cls(np.zeros_like(moved), name, (), moved)

    def turned(self, rotation: Floats) -> LoadCase:
        """The same loads in the axes of a model that was turned by a matrix (3, 3).

        Forces and moments keep their direction in space. Masses turn with their blocks: their
        forces act where they are then.
        """
        masses = tuple(one.turned(rotation) for one in self.masses)
        wrench = turned_wrench(self.beside_masses.wrench, rotation)
        return replace(
            self,
            wrench=sum((one.wrench for one in masses), wrench),
            acceleration=self.acceleration @ rotation,
            surface=None if self.surface is None else self.surface.turned(rotation),
            masses=masses,
            shake=self.shake @ rotation,
            given=None if self.given is None else turned_points(self.given, rotation) @ rotation,
            each=tuple(one.turned(rotation) for one in self.each),
        )

    def refuse_turned_fill(self) -> None:
        """Refuse fill where gravity is turned from -z.

        Raises
        ------
        InputError
        """
        x, y, z = self.acceleration - self.shake
        if self.fills and (x or y or z > 0.0):
            remedy = "leave out --gravity X,Y,Z; 'limit tilt' turns blocks and their fill"
            raise InputError(
                "fill weighs along -z, and gravity is turned", where="load", remedy=remedy
            )

    def require_prescribed(self, assembly: Assembly) -> None:
        """Refuse motions of blocks that are not fixed.

        Raises
        ------
        InputError
        """
        if self.motion is None:
            return
        for i in np.flatnonzero(self.motion.any(axis=1) & ~assembly.fixed):
            raise InputError(
                f"block '{assembly.names[i]}' is not fixed, so its motion is not prescribed",
                remedy="move a support, or load the block",
            )

    @property
    def unit(self) -> str:
        """``g`` of an earthquake of 1 g: a unit, no load that is to be carried; else empty."""
        return "g" if np.isclose(np.linalg.norm(self.shake), STANDARD_GRAVITY) else ""

    @property
    def beside_masses(self) -> LoadCase:
        """The same without the masses that blocks carry, and their forces."""
        wrench = self.wrench - sum((x.wrench for x in self.masses), np.zeros_like(self.wrench))
        return replace(self, wrench=wrench, masses=())

    @property
    def beside_points(self) -> LoadCase:
        """The same without the forces at points off their blocks."""
        theirs = 0.0 if self.given is None else wrench_of_points(self.given)
        return replace(self, wrench=self.wrench - theirs, given=None)

    @property
    def weight_of_masses(self) -> LoadCase:
        """Of what blocks carry, alone."""
        masses = tuple(replace(one, shake=np.zeros(3)) for one in self.masses)
        wrench = sum((one.wrench for one in masses), np.zeros_like(self.wrench))
        return LoadCase(wrench, "carried masses", masses=masses)

    def of_blocks(self, chosen: Ints, count: int | None = None) -> LoadCase:
        """The loads of some blocks of an assembly, which are the first of ``count``."""
        every = len(chosen) if count is None else count
        wrench = filled(self.wrench[chosen], every)
        motion, given = (
            None if one is None else filled(one[chosen], every) for one in (self.motion, self.given)
        )
        surface = None if self.surface is None else self.surface.of_blocks(chosen, every)
        masses = tuple(one.of_blocks(chosen, every) for one in self.masses)
        each = tuple(one.of_blocks(chosen, len(self.wrench)) for one in self.each)
        return replace(
            self, wrench=wrench, motion=motion, surface=surface, masses=masses, given=given,
            each=each,
        )  # fmt: skip

    def without(self, some: Sequence[GivenLoad]) -> LoadCase:
        """Without some of the loads of ``each``."""
        wrench = sum((-one.on(len(self.wrench))["wrench"] for one in some), self.wrench)
        names = {one.words for one in some}
        name = " + ".join(part for part in self.name.split(" + ") if part not in names)
        each = tuple(one for one in self.each if one not in some)
        return replace(self, wrench=wrench, name=name, each=each)

    def beside(self, other: LoadCase) -> LoadCase:
        """By what the sum with another case is more than the other.

        Itself, and the earthquake of each on the masses of the other.
        """
        own = [one.shaken(other.shake) for one in self.masses]
        theirs = [replace(x, gravity=np.zeros(3), shake=self.shake) for x in other.masses]
        wrench = sum((one.wrench for one in (*own, *theirs)), self.beside_masses.wrench)
        return replace(self, wrench=wrench, masses=(*own, *theirs))

    @classmethod
    def combine(
        cls, parts: Iterable[tuple[float, LoadCase]], name: str = "combination"
    ) -> LoadCase:
        """The sum of load cases, each multiplied by its factor.

        Examples
        --------
        >>> from drystone.models import tower
        >>> dead = LoadCase.gravity(tower(2))
        >>> quake = LoadCase.seismic(tower(2), 0.2)
        >>> LoadCase.combine([(1.0, dead), (1.5, quake)]).wrench[1, [0, 2]].round(1).tolist()
        [7063.2, -23544.0]
        """
        try:
            cases = [float(factor) * load for factor, load in parts]
        except (TypeError, ValueError) as error:
            remedy = "give pairs of a factor and a load case"
            raise InputError("load cases are combined as pairs", remedy=remedy) from error
        if not cases:
            raise InputError("there is nothing to combine", remedy="give a load case")
        return replace(cls._of_all(cases), name=name)

    def __add__(self, other: LoadCase) -> LoadCase:
        if not isinstance(other, LoadCase):
            return NotImplemented
        return LoadCase._of_all([self, other])

    @classmethod
    def _of_all(cls, cases: Sequence[LoadCase]) -> LoadCase:
        """The sum of some load cases."""
        wrench, names, notes, motion, acceleration, surface, shake, given = zip(
            *(
                (x.wrench, x.name, x.notes, x.motion, x.acceleration, x.surface, x.shake, x.given)
                for x in cases
            ),
            strict=True,
        )
        if len({one.shape for one in wrench}) > 1:
            raise InputError("load cases of different assemblies cannot be added")
        surfaces = [one for one in surface if one is not None]
        total = cls(
            _added(wrench),
            name_of_sum(names),
            tuple(dict.fromkeys(chain.from_iterable(notes))),
            _added(motion),
            _added(acceleration),
            SurfaceLoad.of_all(surfaces),
            tuple(chain.from_iterable(x.fills for x in cases)),
            shake=_added(shake),
            given=_added(given),
            each=tuple(chain.from_iterable(x.each for x in cases)),
        )
        return total._with_masses_of(cases)

    def _with_masses_of(self, cases: Sequence[LoadCase]) -> LoadCase:
        """The sum of some cases with their masses, each shaken by the earthquakes of the others."""
        others = [(mass, self.shake - case.shake) for case in cases for mass in case.masses]
        wrench = sum((mass.pushed(more) for mass, more in others if more.any()), self.wrench)
        masses = tuple(mass.shaken(more) for mass, more in others)
        return replace(self, wrench=wrench, masses=masses)

    def __mul__(self, factor: float) -> LoadCase:
        if isinstance(factor, str) or np.ndim(factor) or not isinstance(factor, SupportsFloat):
            return NotImplemented
        by = float(factor)
        with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused below
            moved = None if self.motion is None else self.motion * by
            surface = None if self.surface is None else self.surface.by(by)
            wrench, known = self.wrench * by, self.acceleration * by
            masses = tuple(one.by(by) for one in self.masses)
            shake = self.shake * by
            given = None if self.given is None else self.given * by
            each = tuple(one.by(by) for one in self.each)
        fills = tuple(replace(one, weight=by * one.weight) for one in self.fills if by > 0.0)
        return LoadCase(wrench, multiplied(by, self.name), self.notes, moved, known, surface,
                        fills, masses, shake, given, each)  # fmt: skip

    __rmul__ = __mul__
    __array_ufunc__ = None  # a numpy number times a load case is a load case


def _added(values: Sequence[Any]) -> Any:
    """The sum of those that are not None."""
    known = [one for one in values if one is not None]
    return sum(known[1:], known[0]) if known else None


def name_of_sum(names: Iterable[str]) -> str:
    """Three of the names, and how many more there are.

    Examples
    --------
    >>> name_of_sum([name_of_sum(["gravity", "snow", "wind", "a tank"]), "a crane"])
    'gravity + snow + wind + 2 more'
    """
    parts = [part for name in names for part in name.split(" + ")]
    more = [int(part[:-5]) for part in parts if part.endswith(" more") and part[:-5].isdecimal()]
    named = [part for part in parts if not (part.endswith(" more") and part[:-5].isdecimal())]
    others = sum(more) + len(named[3:])
    return " + ".join([*named[:3], *([f"{others} more"] if others else [])])


def _listed(vector: Floats) -> str:
    return ", ".join(f"{x + 0.0:{'.4g' if abs(x) < 1e4 else '.0f'}}" for x in vector)
