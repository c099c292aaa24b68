"""Cells with shared vertices, staggered and wedged: on one patch, and of all patches in space.

A cell is the outline of one block on the surface. The head joints of both neighbouring courses end
on a bed line. Every cell that touches such an end has it as a vertex, so neighbours share whole
edges.

Wedge: shift of the corners of bed joints towards the neighbouring course.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import ROUNDING, Bools, Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.shells.courses import Courses
from drystone.shells.patch import Side, line_curvatures, numbers

Wedge: TypeAlias = float | Sequence[float] | Callable[[Floats, Floats], Floats]
"""Shift of bed-joint corners towards the neighbouring course, relative to its height: one value,
one per bed line between two courses, or a function of (u, v)."""

_FLAT_WEDGE = 0.4
"""Largest wedge from the curvatures. Chosen: a little below the largest possible one."""

LARGEST_WEDGE = 0.45
"""Largest wedge. Chosen: at half the height of a course head joints have no length."""


def wedge_amount(courses: Courses, wedge: Wedge | None, v: Floats, line: Ints) -> Floats:
    """Wedge (p,) at each vertex, relative to the height of the course.

    Parameters
    ----------
    courses
    wedge
        None: the wedge of planar cells.
    v, line : (p,) position and bed line of each vertex

    Raises
    ------
    InputError
        Not finite, too large, or of another length.
    """
    if wedge is None:
        return _flat_wedge(courses, v, line)
    where = f"patch '{courses.patch.name}'"
    if callable(wedge):
        amount = numbers(wedge(courses.parameter(courses.share[line], v), v), "wedges", where)
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


def _flat_wedge(courses: Courses, v: Floats, line: Ints) -> Floats:
    """Wedge (p,) of planar cells on a surface with these curvatures, at most the largest.

    The tangent planes at the middles of the cells intersect in the edges of a power diagram of
    these middles, with lengths along u and v scaled by the root of the curvatures. In a bond of
    width w and height h the corners are shifted by ``k_v w^2 / (8 k_u h^2)`` of the height. Source
    (tangent planes of a paraboloid): Aurenhammer 1987, Power diagrams.
    """
    at_u = [
        courses.parameter(courses.share[np.clip(line + step, 0, courses.count)], v)
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


@dataclass(frozen=True, eq=False)
class Cells(OneLine):
    """Cells that share vertices.

    Attributes
    ----------
    cells
        Loops of vertices, counter-clockwise seen from outside.
    names
    course, position : (c,) course of each cell, and its place in it
    inner : (p,) whether a vertex is on a bed line between two courses of one patch
    """

    cells: tuple[tuple[int, ...], ...]
    names: tuple[str, ...]
    course: Ints
    position: Ints
    inner: Bools

    @property
    def loops(self) -> tuple[Ints, Ints]:
        """The vertices of all cells, one after the other, and where each cell starts."""
        return np.concatenate(self.cells).astype(np.intp), Ragged.of(self.cells).start


@dataclass(frozen=True, eq=False)
class Pattern(Cells):
    """Cells on a surface.

    Attributes
    ----------
    uv : (p, 2) parameters of each vertex in its patch
    centre : (c, 2) parameters of the middle of each cell
    heads : (h, 2) vertices at the bottom and the top of every head joint
    borders
        Per side its vertices in order and their positions along it.
    """

    uv: Floats
    centre: Floats
    heads: Ints
    borders: dict[Side, tuple[Ints, Floats]]


def lay_pattern(
    courses: Courses, joints: Sequence[Floats], *, wedge: Wedge | None = 0.0
) -> Pattern:
    """Cells of one patch from its courses and head joints.

    Parameters
    ----------
    courses
    joints
        Per course the positions of its head joints along v.
    wedge
        Positive: the bed line rises at head joints of the course above and falls at head joints of
        the course below. Blocks are hexagons, and each lies between two blocks of the course below.
        Half blocks at an open end then taper inwards and are held by friction only. Negative:
        blocks are narrow in the middle, and none can be pulled out of an open end. The wedge is
        reduced where head joints above and below are close to each other. None: the wedge of planar
        cells.

    Raises
    ------
    InputError
        The wedge turns a block inside out, or the list has another length.
    """
    head_course = np.concatenate([np.full(len(x), i) for i, x in enumerate(joints)]).astype(np.intp)
    head_v = np.concatenate(list(joints))
    number = len(head_v)
    level = np.concatenate([head_course, head_course + 1])
    at_v = np.tile(head_v, 2)
    vertex, first = _merge(level, _wrapped(at_v, courses), closed=courses.patch.closed)
    bottom, top = vertex[:number], vertex[number:]
    v = _wrapped(at_v, courses)[first]
    line = level[first].astype(np.intp)
    u = _shifted(courses, v, line, bottom, top, wedge)
    cells, course, position = _cells(courses, joints, v, line, bottom, top)
    pattern = Pattern(
        uv=np.stack([u, v], axis=1),
        cells=tuple(cells),
        names=tuple(f"c{c:02d}-b{b:02d}" for c, b in zip(course, position, strict=True)),
        course=course,
        position=position,
        centre=_centres(u, v, cells, closed=courses.patch.closed),
        heads=np.stack([bottom, top], axis=1),
        inner=(line > 0) & (line < courses.count),
        borders=_borders(courses, u, v, line),
    )
    _refuse_inside_out(pattern)
    if courses.patch.turn > 0.0:  # a loop along v and back has the normal dv x du
        pattern = replace(pattern, cells=tuple(cell[::-1] for cell in pattern.cells))
    return pattern


def _wrapped(v: Floats, courses: Courses) -> Floats:
    return v % 1.0 if courses.patch.closed else v


def _merge(level: Ints, v: Floats, *, closed: bool) -> tuple[Ints, Ints]:
    """Vertex of each corner, and the first corner of each vertex; equal bed line and v."""
    cyclic = np.where(v > 1.0 - ROUNDING, 0.0, v) if closed else v
    order = np.lexsort((cyclic, level))
    new = np.ones(len(v), dtype=bool)
    new[1:] = (np.diff(level[order]) != 0) | (np.diff(cyclic[order]) > ROUNDING)
    vertex = np.empty(len(v), dtype=np.intp)
    vertex[order] = np.cumsum(new) - 1
    return vertex, order[new]


def _shifted(
    courses: Courses, v: Floats, line: Ints, bottom: Ints, top: Ints, wedge: Wedge | None
) -> Floats:
    """Parameter u of each vertex: that of its bed line plus or minus the wedge."""
    lines, share = courses.share, courses.share[line]
    starts, ends = np.zeros(len(v), dtype=bool), np.zeros(len(v), dtype=bool)
    starts[bottom], ends[top] = True, True
    inner = (line > 0) & (line < courses.count)
    if not courses.patch.closed:
        inner &= (v > 0.0) & (v < 1.0)
    direction = np.where(inner, starts.astype(float) - ends.astype(float), 0.0)
    amount = wedge_amount(courses, wedge, v, line)
    above = lines[np.minimum(line + 1, courses.count)] - share
    under = share - lines[np.maximum(line - 1, 0)]
    reach = np.minimum(np.where(above > 0.0, above, under), np.where(under > 0.0, under, above))
    eased = eased_share(v, line, direction, closed=courses.patch.closed)
    return courses.parameter(share + direction * eased * amount * reach, v)


def _cells(
    courses: Courses, joints: Sequence[Floats], v: Floats, line: Ints, bottom: Ints, top: Ints
) -> tuple[list[tuple[int, ...]], Ints, Ints]:
    """Loops of every course: along its lower bed line, back along its upper one."""
    closed = courses.patch.closed
    cells: list[tuple[int, ...]] = []
    course: list[int] = []
    position: list[int] = []
    chains = []
    for i in range(courses.count + 1):
        on = np.flatnonzero(line == i)
        on = on[np.argsort(v[on], kind="stable")]
        at = v[on]
        if closed:
            on, at = np.tile(on, 3), np.concatenate([at, at + 1.0, at + 2.0])
        chains.append((on, at))
    first = 0
    for i, heads in enumerate(joints):
        (low_on, low_at), (high_on, high_at) = chains[i], chains[i + 1]
        low = np.searchsorted(low_at, np.stack([heads + ROUNDING, heads - ROUNDING]))
        high = np.searchsorted(high_at, np.stack([heads + ROUNDING, heads - ROUNDING]))
        for j in range(len(heads) - 1):
            under = low_on[low[0, j] : low[1, j + 1]].tolist()
            over = high_on[high[0, j] : high[1, j + 1]].tolist()
            right = [int(bottom[first + j + 1]), int(top[first + j + 1])]
            left = [int(top[first + j]), int(bottom[first + j])]
            loop = [left[1], *under, *right, *over[::-1], left[0]]
            cells.append(tuple(dict.fromkeys(loop)))
            course.append(i)
            position.append(j)
        first += len(heads)
    return cells, np.array(course, dtype=np.intp), np.array(position, dtype=np.intp)


def _centres(u: Floats, v: Floats, cells: list[tuple[int, ...]], *, closed: bool) -> Floats:
    loop = np.concatenate(cells).astype(np.intp)
    corners = Ragged.of(cells)
    base = corners.spread(v[loop[corners.first]])
    along = (v[loop] - base + 0.5) % 1.0 - 0.5 + base if closed else v[loop]
    both = np.stack([u[loop], along], axis=1)
    return 0.5 * (corners.min(both) + corners.max(both))


def _borders(courses: Courses, u: Floats, v: Floats, line: Ints) -> dict[Side, tuple[Ints, Floats]]:
    def run(chosen: Ints, along: Floats) -> tuple[Ints, Floats]:
        order = np.argsort(along[chosen], kind="stable")
        return chosen[order], along[chosen][order]

    borders = {
        Side.BOTTOM: run(np.flatnonzero(line == 0), v),
        Side.TOP: run(np.flatnonzero(line == courses.count), v),
    }
    if not courses.patch.closed:
        borders[Side.LEFT] = run(np.flatnonzero(v <= 0.0), u)
        borders[Side.RIGHT] = run(np.flatnonzero(v >= 1.0), u)
    return borders


def _refuse_inside_out(pattern: Pattern) -> None:
    """Raise for a head joint that does not rise, or a cell without area in (u, v)."""
    rise = pattern.uv[pattern.heads[:, 1], 0] - pattern.uv[pattern.heads[:, 0], 0]
    bad = rise <= 0.0
    if bad.any():
        low = int(pattern.heads[np.flatnonzero(bad)[0], 0])
        name = next(n for n, c in zip(pattern.names, pattern.cells, strict=True) if low in c)
        raise InputError(
            "is turned inside out: its head joint has no height left",
            where=f"block '{name}'",
            remedy="use a smaller wedge",
        )


@dataclass(frozen=True, eq=False)
class Tessellation(Cells):
    """Cells in space.

    Attributes
    ----------
    point : (p, 3) [m]
    normal : (p, 3) unit, outwards; at a seam the mean of both sides
    up : (p, 3) unit tangent across the courses
    of_patch : (c,)
        -1 for a keystone, which closes several patches.
    crest : (c, 3) [m] point of the surface over the middle of each cell; NaN for a keystone
    heads
        Pairs of vertices, lower number first, at the ends of the head joints.
    supported
        Edges on which the shell is supported, directed as in their cell.
    """

    point: Floats
    normal: Floats
    up: Floats
    of_patch: Ints
    crest: Floats
    heads: frozenset[tuple[int, int]]
    supported: tuple[tuple[int, int], ...]

    def name_at(self, vertex: int) -> str:
        """Name of the first cell that has a vertex."""
        return next(n for n, c in zip(self.names, self.cells, strict=True) if vertex in c)
