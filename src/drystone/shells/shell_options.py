"""Options of a shell: division of the surface, blocks.

Wedge: shift of the corners of bed joints towards the neighbouring course.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, TypeAlias

import numpy as np

from drystone.assembly import DEFAULT_DENSITY
from drystone.base.arrays import Floats, Ints, whole
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.shells.courses import Courses
from drystone.shells.materialise import Thickness
from drystone.shells.patch import line_curvatures, numbers

Wedge: TypeAlias = float | Sequence[float] | Callable[[Floats, Floats], Floats]
"""Shift of bed-joint corners towards the neighbouring course, relative to its height: one value,
one per bed line between two courses, or a function of (u, v)."""

_FLAT_WEDGE = 0.4
"""Largest wedge from the curvatures. Chosen: a little below the largest possible one."""

LARGEST_WEDGE = 0.45
"""Largest wedge. Chosen: at half the height of a course head joints have no length."""


def wedge_amount(
    courses: Courses, wedge: Wedge | None, lines: Floats, v: Floats, line: Ints
) -> Floats:
    """Wedge (p,) at each vertex, relative to the height of the course.

    Parameters
    ----------
    courses
    wedge
        None: the wedge of planar cells.
    lines : (p, c + 1) position of every bed line at each vertex, relative to the length along u
    v, line : (p,) position and bed line of each vertex

    Raises
    ------
    InputError
        Not finite, too large, or of another length.
    """
    if wedge is None:
        return _flat_wedge(courses, lines, v, line)
    share = lines[np.arange(len(v)), line]
    where = f"patch '{courses.patch.name}'"
    if callable(wedge):
        amount = numbers(wedge(courses.parameter(share, v), v), "wedges", where)
        if amount.shape != v.shape:
            raise InputError(f"the wedge function gave shape {amount.shape} for {len(v)} corners")
    elif isinstance(wedge, Real):
        amount = np.full(len(v), float(wedge))
    else:
        values = numbers(wedge, "wedges", where)
        if values.shape != (courses.count - 1,):
            raise InputError(
                f"{values.size} wedges for {courses.count - 1} bed lines between courses"
            )
        amount = np.concatenate([[0.0], values, [0.0]])[line]
    if not np.isfinite(amount).all():
        raise InputError(
            f"the wedge is {amount[~np.isfinite(amount)][0]}",
            where=where,
            remedy=f"give numbers from -{LARGEST_WEDGE} to {LARGEST_WEDGE}",
        )
    bad = np.abs(amount) > LARGEST_WEDGE
    if bad.any():
        k = int(np.flatnonzero(bad)[0])
        raise InputError(
            f"the wedge {amount[k]:.3g} of a course's height turns blocks inside out",
            where=f"block 'c{int(min(line[k], courses.count - 1)):02d}-b00' and its neighbours",
            remedy=f"stay within -{LARGEST_WEDGE} and {LARGEST_WEDGE}",
        )
    return amount


def _flat_wedge(courses: Courses, lines: Floats, v: Floats, line: Ints) -> Floats:
    """Wedge (p,) of planar cells on a surface with these curvatures, at most the largest.

    The tangent planes at the middles of the cells intersect in the edges of a power diagram of
    these middles, with lengths along u and v scaled by the root of the curvatures. In a bond of
    width w and height h the corners are shifted by ``k_v w^2 / (8 k_u h^2)`` of the height. Source
    (tangent planes of a paraboloid): Aurenhammer 1987, Power diagrams.
    """
    row = np.arange(len(v))
    at_u = [
        courses.parameter(lines[row, np.clip(line + step, 0, courses.count)], v)
        for step in (-1, 0, 1)
    ]
    low, here, high = (courses.patch.point(u, v) for u in at_u)
    height = 0.5 * (np.linalg.norm(high - here, axis=1) + np.linalg.norm(here - low, axis=1))
    width = np.zeros(len(v))
    for level in np.unique(line):
        on = np.flatnonzero(line == level)
        on = on[np.argsort(v[on], kind="stable")]
        gap = np.diff(v[on], append=v[on[:1]] + 1.0)
        width[on] = gap + np.roll(gap, 1)
    along = np.linalg.norm(courses.patch.tangents(at_u[1], v)[1], axis=1)
    across, around = line_curvatures(courses.patch, at_u[1], v)
    wanted = around * (width * along) ** 2
    given = 8.0 * across * height**2
    given = np.where(np.abs(given) > 1e-12 * np.abs(wanted), given, 1e-12 * np.abs(wanted) + 1e-300)
    return np.clip(wanted / given, -_FLAT_WEDGE, _FLAT_WEDGE)


def eased_share(v: Floats, line: Ints, direction: Floats, *, closed: bool) -> Floats:
    """Share (p,) of the wedge at each vertex: smaller where joints above and below are close.

    The share is 2 d / D. D is the distance between the previous and the next vertex with the
    opposite shift; d is the distance to the nearer of them. It is 1 in a regular bond, so no bed
    joint is steeper than there.
    """
    share = np.ones(len(v))
    for level in np.unique(line):
        on = np.flatnonzero(line == level)
        on = on[np.argsort(v[on], kind="stable")]
        if len(on) < 3:
            continue
        gap = np.diff(v[on], append=v[on[:1]] + 1.0)
        turn = direction[on] != direction[np.roll(on, -1)]
        left, right = np.roll(gap, 1), gap
        nearer = np.minimum(np.where(np.roll(turn, 1), left, np.inf), np.where(turn, right, np.inf))
        eased = np.minimum(1.0, 2.0 * nearer / (left + right))
        share[on] = eased
        if not closed:
            share[on[[0, -1]]] = 1.0
    return share


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
    courses, height, heights
        One of them: number of full courses, target height [m], or relative heights.
    partial
        Number of courses that end inside the patch; None: from the height.
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
