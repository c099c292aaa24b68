"""How a surface is divided, and what its cells become."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drystone.assembly import DEFAULT_DENSITY
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.shells.blocks.planarise import PlanarOptions
from drystone.shells.blocks.thickness import Thickness
from drystone.shells.bond.wedge import Wedge
from drystone.shells.surface.lengths import refuse_unless_count


class Intrados(enum.Enum):
    """The inner faces of the blocks."""

    OFFSET = "offset"
    """They follow the surface at the thickness; slightly warped where it is doubly curved."""
    STRAIGHT = "straight"
    """Each is planar, so that a block can be sawn; the thickness varies a little. Planar faces in a
    staggered bond need the wedge that the curvatures ask for: ``Layout(wedge=None)``."""


class Ground(enum.Enum):
    """What holds a shell."""

    BLOCKS = "blocks"
    """A fixed block is added under every springer."""
    SPRINGERS = "springers"
    """The springers themselves are fixed."""


@dataclass(frozen=True)
class Layout(Options):
    """Courses and blocks of a patch.

    Attributes
    ----------
    courses, height, heights
        One of them: number of full courses, height wanted [m], or relative heights.
    partial
        Courses that end inside; None lets the height decide.
    blocks, width
        One of them: number per course, one or one each, or width wanted [m].
    staggered
    wedge
        Shift of bed-joint corners towards the neighbouring course, by its height. None takes it
        from the curvatures of the surface, for planar inner faces.

    Raises
    ------
    InputError
        A number of courses or blocks that is not whole.
    """

    courses: int | None = None
    height: float | None = None
    heights: Sequence[float] | None = None
    partial: int | None = 0
    blocks: int | Sequence[int] | None = None
    width: float | None = None
    staggered: bool = True
    wedge: Wedge | None = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        blocks: Any = self.blocks
        for number in blocks if isinstance(blocks, (Sequence, np.ndarray)) else (blocks,):
            if blocks is not None:
                refuse_unless_count(number, "blocks")


LARGEST_REGISTER = 35.0
"""[degrees] Chosen: steeper than the friction angle of dry stone, 31 to 35 degrees, both halves of
a bed slide on each other under the thrust, and the step is no hook but a wedge."""


@dataclass(frozen=True)
class Body(Options):
    """What the cells become.

    Attributes
    ----------
    thickness : [m]
        One, one per course, or a function of points; left out, that of the shape.
    density : [kg/m3]
    register_deg : [degrees]
        Hooks every block over the course below, -35 to 35; see
        ``add_register``.
    intrados
    ground
    ground_depth : [m]
        Depth of the ground blocks; left out, the mean thickness.
    planar

    Raises
    ------
    InputError
        A register out of range, or a value of another type.
    """

    thickness: Thickness | None = None
    density: float = DEFAULT_DENSITY
    register_deg: float = 0.0
    intrados: Intrados = Intrados.OFFSET
    ground: Ground = Ground.BLOCKS
    ground_depth: float | None = None
    planar: PlanarOptions = field(default_factory=PlanarOptions)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not abs(self.register_deg) <= LARGEST_REGISTER:
            raise InputError(
                f"the register is {self.register_deg} degrees",
                remedy=f"give -{LARGEST_REGISTER:g} to {LARGEST_REGISTER:g}",
            )


@dataclass(frozen=True)
class FormOptions(Options):
    """Options of form finding.

    Attributes
    ----------
    rows, columns
        Nodes of the net along u and v of each patch.
    edge_density
        Force density of bars on free edges, by that of the others: the higher, the straighter they
        stay in plan.
    density : [kg/m3]

    Raises
    ------
    InputError
        A density that is not positive, or a number of nodes that is not whole.
    """

    rows: int = 25
    columns: int = 25
    edge_density: float = 8.0
    density: float = DEFAULT_DENSITY

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, value in (("edge density", self.edge_density), ("density", self.density)):
            if not 0.0 < value < math.inf:
                raise InputError(
                    f"the {name} of a net is {value!r}", remedy="give a number above zero"
                )
