"""Options of a shell: division of the surface, blocks."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from drystone.assembly import DEFAULT_DENSITY
from drystone.base.arrays import whole
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.shells.materialise import Thickness
from drystone.shells.pattern import Wedge


class Intrados(enum.Enum):
    """The inner faces of the blocks."""

    OFFSET = "offset"
    """They follow the surface; slightly warped where it is doubly curved."""
    STRAIGHT = "straight"
    """Each is planar, so that a block can be sawn; the thickness varies a little. Planar faces in a
    staggered bond need the wedge that the curvatures ask for: ``Layout(wedge=None)``."""


class JointForm(enum.Enum):
    """The joints between blocks of a surface that is curved both ways."""

    PLANE = "plane"
    """Corners are moved until each joint is plane."""
    FACETED = "faceted"
    """Corners stay where the normals of the surface put them; a warped joint is two triangles."""


class Ground(enum.Enum):
    """How a shell is supported."""

    BLOCKS = "blocks"
    """A fixed block is added under every springer."""
    SPRINGERS = "springers"
    """The springers themselves are fixed."""


@dataclass(frozen=True)
class Layout(Options):
    """Courses and blocks of a patch.

    Attributes
    ----------
    courses, height
        One of them: number of courses, or target height [m].
    blocks, width
        One of them: number per course (one value or one per course), or target width [m].
    staggered
    wedge
        Shift of bed-joint corners towards the neighbouring course, relative to its height. None:
        from the curvatures of the surface, for planar inner faces.

    Raises
    ------
    InputError
        The number of courses or blocks is not a whole number.
    """

    courses: int | None = None
    height: float | None = None
    blocks: int | Sequence[int] | None = None
    width: float | None = None
    staggered: bool = True
    wedge: Wedge | None = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        blocks: Any = self.blocks
        for number in blocks if isinstance(blocks, (Sequence, np.ndarray)) else (blocks,):
            if blocks is not None:
                whole(number, "the number of blocks")


LEAST_JOGGLE, LARGEST_JOGGLE = 10.0, 25.0
"""[degrees] A smaller joggle is too flat for the contact search; a larger one blocks every
rotation."""


@dataclass(frozen=True)
class ShellBody(Options):
    """Thickness, material and joints of the blocks of a shell.

    Attributes
    ----------
    thickness : [m]
        One value, one per course, or a function of points; that of the shape when left out. Half
        of it is on each side of the surface.
    density : [kg/m3]
    joggle_deg : [degrees]
        Joggle that hooks every block over the course below: the slope of its first face, 10 to 25
        or -25 to -10; 0 for none. A block is then removed by a rotation, not by a straight lift;
        see ``add_joggle``.
    intrados
    joints
    ground
    ground_depth : [m]
        Depth of the ground blocks; the mean thickness when left out.

    Raises
    ------
    InputError
        A joggle out of range, a joggle or straight intrados with faceted joints, or a value of
        another type.
    """

    thickness: Thickness | None = None
    density: float = DEFAULT_DENSITY
    joggle_deg: float = 0.0
    intrados: Intrados = Intrados.OFFSET
    joints: JointForm = JointForm.PLANE
    ground: Ground = Ground.BLOCKS
    ground_depth: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        size = abs(self.joggle_deg)
        if size != 0.0 and not LEAST_JOGGLE <= size <= LARGEST_JOGGLE:
            raise InputError(
                f"the joggle is {self.joggle_deg} degrees",
                remedy=f"give {LEAST_JOGGLE:g} to {LARGEST_JOGGLE:g}, the same below zero, "
                "or 0 for none",
            )
        straight = self.intrados is Intrados.STRAIGHT
        if self.joints is JointForm.FACETED and (size != 0.0 or straight):
            raise InputError(
                f"{'a straight intrados' if straight else 'a joggle'} needs plane joints",
                remedy="leave it out, or the faceted joints",
            )
