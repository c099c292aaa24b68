"""Boxes, towers and other models with a closed-form answer; cubes cut into boxes at random.

Blocks from a section or from faces, published sections, and checks of parameters.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from heapq import heappop, heappush
from itertools import pairwise, product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from drystone.assembly import DEFAULT_DENSITY, Assembly, Block
from drystone.base.arrays import ROUNDING, Floats, frozen_floats
from drystone.base.errors import InputError
from drystone.base.files import shipped
from drystone.geometry.coincidence import distinct
from drystone.geometry.frames import rotation_about
from drystone.geometry.polyhedron import BOX, body_mass_properties, box_corners
from drystone.geometry.surface import closed_surface


def require(holds: bool, what: str, remedy: str) -> None:
    """Refuse a parameter.

    Raises
    ------
    InputError
        ``holds`` is false.
    """
    if not holds:
        raise InputError(what, remedy=remedy)


@cache
def sections(model: str) -> Any:
    """The sections (x, z) [m] of a model, to a micrometre or as published: ``sections.json``."""
    return json.loads(shipped("models/sections.json"))[model]


def prism(
    section: ArrayLike,
    depth: Sequence[float],
    name: str = "block",
    density: float = DEFAULT_DENSITY,
) -> Block:
    """A section in a vertical plane, extruded along y.

    Parameters
    ----------
    section : (p, 2) [m]
        Corners (x, z) of a simple polygon, concave or not, in either sense of rotation.
    depth : (2,) [m]
        From y to y.
    name
        Of the block.
    density : [kg/m3]

    Examples
    --------
    >>> prism([(0, 0), (2, 0), (0, 1)], (0.0, 0.5)).volume
    0.5
    """
    corners = frozen_floats(section, (None, 2), "section")
    start, end = sorted(float(y) for y in depth)
    require(start < end, "the depth is zero", "give two different values of y")
    x, z = corners[:, 0], corners[:, 1]
    if (x * np.roll(z, -1) - z * np.roll(x, -1)).sum() < 0.0:
        corners = corners[::-1]
    count = len(corners)
    front = np.column_stack([corners[:, 0], np.full(count, start), corners[:, 1]])
    back = front + np.array([0.0, end - start, 0.0])
    here = range(count)
    sides = [((i + 1) % count, i, i + count, (i + 1) % count + count) for i in here]
    faces = (tuple(here), tuple(i + count for i in reversed(here)), *sides)
    return Block(np.concatenate([front, back]), faces, name, density)


def blocks_between(
    joints: Floats, depth: Sequence[float], name: str = "voussoir-{:02d}", first: int = 0
) -> list[Block]:
    """A numbered block between each two successive joints (j, 2, 2), as prisms along y."""
    return [
        prism([a[0], a[1], b[1], b[0]], depth, name.format(i))
        for i, (a, b) in enumerate(pairwise(joints), first)
    ]


def welded(
    loops: Sequence[ArrayLike], name: str = "block", density: float = DEFAULT_DENSITY
) -> Block:
    """A block from its faces, in any order and sense of rotation; common corners are joined.

    Parameters
    ----------
    loops
        The corners (c, 3) [m] of each face. Repeated corners are dropped, and so are faces with
        fewer than three.
    name
        Of the block.
    density : [kg/m3]

    Raises
    ------
    InputError
        The faces do not close. Corners are numbered in the order given.

    Examples
    --------
    >>> a, b, c, d = np.vstack([np.zeros(3), np.eye(3)])
    >>> block = welded([(a, b, c), (a, b, d), (b, c, d), (a, c, d)])
    >>> len(block.vertices), round(block.volume, 4)
    (4, 0.1667)
    """
    faces = [frozen_floats(loop, (None, 3), "loop") for loop in loops]
    points = np.concatenate(faces)
    extent = float(np.ptp(points, axis=0).max())
    first, member = distinct(points, ROUNDING * extent)
    ends = np.cumsum([len(face) for face in faces])[:-1]
    rounds = (tuple(dict.fromkeys(part.tolist())) for part in np.split(member, ends))
    surface = closed_surface([loop for loop in rounds if len(loop) > 2], len(first))
    vertices = surface.select(points[first])
    volume, _ = body_mass_properties(vertices, surface.fan)
    outward = surface if volume > 0.0 else surface.turned()
    return Block(vertices, outward.loops, name, density)


@cache
def of_boxes(name: str, *boxes: tuple[tuple[float, ...], tuple[float, ...]]) -> Block:
    """A block of boxes that share parts of faces, each by its lowest and highest corner [m]."""
    from drystone.geometry.glue import glue  # few models need it

    ((vertices, faces),) = glue([(box_corners(*map(np.array, one)), list(BOX)) for one in boxes])
    return Block(vertices, tuple(faces), name)


def shell_faces(shell: Floats) -> list[Floats]:
    """Faces of a piece of shell (2, 2, s, 3): inner and outer, lower and upper, stations."""
    faces = [shell[:, :, end].reshape(4, 3)[[0, 1, 3, 2]] for end in (0, -1)]
    for i in range(shell.shape[2] - 1):
        faces += [shell[side, :, i : i + 2].reshape(4, 3)[[0, 1, 3, 2]] for side in (0, 1)]
        faces += [shell[:, bed, i : i + 2].reshape(4, 3)[[0, 1, 3, 2]] for bed in (0, 1)]
    return faces


def box(
    size: Sequence[float],
    origin: Sequence[float] = (0.0, 0.0, 0.0),
    name: str = "box",
    density: float = DEFAULT_DENSITY,
) -> Block:
    """An axis-aligned box with its lowest corner at ``origin`` [m] and edges ``size`` [m].

    Parameters
    ----------
    size : (3,) [m]
        Lengths of the edges along x, y and z.
    origin : (3,) [m]
        The lowest corner.
    name
        Of the block.
    density : [kg/m3]
        Of the block.
    """
    low = np.asarray(origin, dtype=np.float64)
    high = low + np.asarray(size, dtype=np.float64)
    return Block(box_corners(low, high), BOX, name, density)


def tower(
    count: int = 5,
    edge: float = 1.0,
    *,
    course: float | None = None,
    thickness: float = 0.0,
    stones: int = 4,
    lean: float = 0.0,
) -> Assembly:
    """A tower of courses, solid or hollow, which may lean; a stack of cubes by default.

    What stands on a bed joint overturns as one from ``atan(edge / its height)`` on, lean and tilt
    together: ``count - 1`` free cubes at ``atan(1 / (count - 1))``. Shafts of more than two stones
    a course fall before, as stones slip. A tower slides where ``tan(lean)`` exceeds the friction.

    Parameters
    ----------
    count : >= 1
        Courses; the lowest is fixed.
    edge : [m]
        Width, from flat side to flat side.
    course : [m]
        Height of a course; ``edge`` when left out.
    thickness : [m] >= 0
        Of the walls around a shaft; 0: solid and square, one block in each course.
    stones : >= 2
        In each course of a hollow tower, with a plan of twice as many sides: 2 for a square of
        L-shaped stones, 4 for an octagon. Courses are turned by half a stone.
    lean : [degrees] >= 0, < 90
        Towards +x, of the whole tower with its joints, as where the ground gave way.

    Returns
    -------
    Assembly
        ``block-i`` upwards; of a hollow tower ``c00-b0``, counter-clockwise in each course.

    Examples
    --------
    >>> tower(2).names
    ('block-0', 'block-1')
    >>> len(tower(10, 4.0, course=0.5, thickness=0.8))
    40
    """
    require(thickness < 0.5 * edge, "the walls leave no shaft", "make them thinner")
    rise = edge if course is None else course
    blocks = (
        [box((edge, edge, rise), (0.0, 0.0, i * rise), f"block-{i}") for i in range(count)]
        if thickness == 0.0
        else _shaft(count, edge, rise, thickness, stones)
    )
    upright = Assembly(tuple(blocks), np.arange(len(blocks)) < len(blocks) // count)
    return upright.transformed(rotation_about(np.array([0.0, 1.0, 0.0]), lean)) if lean else upright


def _shaft(count: int, edge: float, rise: float, thickness: float, stones: int) -> list[Block]:
    """Rings of stones, each over two sides of a polygon."""
    sides = 2 * stones
    turn = 2.0 * np.pi * (np.arange(sides) + 0.5) / sides
    ray = np.column_stack([np.cos(turn), np.sin(turn)])
    across = np.array([0.5 * edge - thickness, 0.5 * edge]) / np.cos(np.pi / sides)
    point = np.empty((2, count + 1, sides, 3))  # inner and outer, bed, corner
    point[..., :2] = 0.5 * edge + across[:, None, None, None] * ray
    point[..., 2] = (rise * np.arange(count + 1))[:, None]
    blocks = []
    for row in range(count):
        for i in range(stones):
            span = (2 * i + row % 2 + np.arange(3)) % sides
            faces = shell_faces(point[:, row : row + 2][:, :, span])
            blocks.append(welded(faces, f"c{row:02d}-b{i}"))
    return blocks


def incline(angle_deg: float = 20.0, size: Sequence[float] = (1.0, 0.8, 0.5)) -> Assembly:
    """A block on a fixed plane inclined by ``angle_deg``, sloping down towards +x.

    It slides when ``tan(angle) > friction`` and topples when ``tan(angle) > length / height``.

    Parameters
    ----------
    angle_deg : [degrees]
    size : (3,) [m]
        Of the block: along the slope, across it, and normal to it.

    Examples
    --------
    >>> incline(20.0).names
    ('plane', 'block')
    """
    length, width, height = (float(s) for s in size)
    plane = box((3.0 * length, 2.0 * width, 0.2 * length), name="plane")
    block = box((length, width, height), (length, 0.5 * width, 0.2 * length), "block")
    flat = Assembly((plane, block), np.array([True, False]))
    return flat.transformed(rotation_about(np.array([0.0, 1.0, 0.0]), angle_deg))


def two_blocks_on_incline(angle: float = 23.6, height: float = 1.0) -> Assembly:
    """Two stacked blocks, the lower one fixed, with a joint inclined by ``angle`` [degrees].

    The upper block rests if and only if the friction coefficient is at least ``tan(angle)``:
    0.4369 for 23.6 degrees.

    Parameters
    ----------
    angle : [degrees]
        The joint goes down towards +x through the middle of the stack, 1 m by 1 m in plan.
    height : [m]
        Of each block on its middle axis.
    """
    drop = 0.5 * float(np.tan(np.deg2rad(angle)))
    require(abs(drop) < height, f"a joint at {angle} deg cuts the stack's ends", "raise the height")
    joint = [(0.5, height - drop), (-0.5, height + drop)]
    lower = prism([(-0.5, 0.0), (0.5, 0.0), *joint], (0.0, 1.0), "lower")
    upper = prism([*joint, (-0.5, 2.0 * height), (0.5, 2.0 * height)], (0.0, 1.0), "upper")
    return Assembly((lower, upper), np.array([True, False]))


def harmonic_offsets(count: int, length: float = 1.0, share: float = 1.0) -> list[float]:
    """Offsets [m] of the longest overhang of ``count`` equal bricks, one on each, bottom up.

    The k-th brick from the top may overhang the one below by ``length / (2 k)``; ``share`` of that
    is given back. Source: Hall 2005, the harmonic stack.

    Parameters
    ----------
    count
        Number of bricks, one or more.
    length : [m]
        Of a brick.
    share
        Of the largest overhang, at each joint.

    Examples
    --------
    >>> round(sum(harmonic_offsets(4)), 4)
    1.0417
    """
    require(count > 0, f"an overhang of {count} bricks", "give one or more")
    return [share * length / (2.0 * (count - i)) for i in range(count)]


def overhang(
    offsets: Sequence[float] = (0.25, 0.5), size: Sequence[float] = (1.0, 0.5, 0.25)
) -> Assembly:
    """A stack of bricks, each shifted along +x from the one below.

    Parameters
    ----------
    offsets : [m]
        Shift of each free brick relative to the brick below, bottom up.
    size : (3,) [m]
        Length along x, depth and height of every brick.

    Returns
    -------
    Assembly
        ``brick-00``, fixed, and a brick for each offset.
    """
    length, depth, height = (float(s) for s in size)
    require(
        all(abs(o) < length for o in offsets),
        "a brick does not rest on the one below",
        "reduce the shift",
    )
    place = np.concatenate([[0.0], np.cumsum(np.asarray(offsets, dtype=np.float64))])
    bricks = [
        box((length, depth, height), (x, 0.0, i * height), f"brick-{i:02d}")
        for i, x in enumerate(place.tolist())
    ]
    return Assembly(tuple(bricks), np.arange(len(bricks)) == 0)


def stool(
    side: float = 0.4, leg: float = 0.08, seat: float = 0.06, height: float = 0.45
) -> Assembly:
    """A square stool with four legs, one concave block, on a fixed floor.

    The forces in its legs are statically indeterminate: they balance whenever both diagonals carry
    the same.

    Parameters
    ----------
    side : [m]
        Of the seat.
    leg : [m]
        Side of the square legs, at the corners of the seat.
    seat : [m]
        Thickness.
    height : [m]
        Seat included.
    """
    require(2.0 * leg < side and seat < height, "the legs do not fit", "make them thinner")
    under = height - seat
    inner = side - leg
    legs = [((x, y, 0.0), (x + leg, y + leg, under)) for x, y in product((0.0, inner), repeat=2)]
    body = of_boxes("stool", ((0.0, 0.0, under), (side, side, height)), *legs)
    floor = box((2.0 * side, 2.0 * side, leg), (-0.5 * side, -0.5 * side, -leg), "floor")
    return Assembly((floor, body), np.array([True, False]))


def random_pack(count: int = 30, seed: int = 0, edge: float = 1.0) -> Assembly:
    """A cube that is cut into boxes: again and again the largest box is cut in two at random.

    The boxes touch exactly, partly, and in T-junctions. Those on the ground are fixed.

    Parameters
    ----------
    count : >= 1
        Number of boxes.
    seed
        Of numpy's default generator; the same seed gives the same pack.
    edge : [m]
        Of the whole cube.

    Examples
    --------
    >>> pack = random_pack(12)
    >>> len(pack), round(float(pack.volume.sum()), 12)
    (12, 1.0)
    """
    random = np.random.default_rng(seed)
    boxes = [(-(edge**3), (0.0, 0.0, 0.0), (edge, edge, edge))]
    while len(boxes) < count:
        _, low, high = heappop(boxes)
        length = np.subtract(high, low)
        axis = int(random.choice(3, p=length / length.sum()))
        place = low[axis] + float(random.uniform(0.3, 0.7)) * float(length[axis])
        for child in (
            (low, (*high[:axis], place, *high[axis + 1 :])),
            ((*low[:axis], place, *low[axis + 1 :]), high),
        ):
            heappush(boxes, (-float(np.prod(np.subtract(child[1], child[0]))), *child))
    corners = sorted((low, high) for _, low, high in boxes)
    blocks = tuple(
        box(np.subtract(high, low).tolist(), low, f"box-{i}")
        for i, (low, high) in enumerate(corners)
    )
    return Assembly(blocks, np.array([low[2] == 0.0 for low, _ in corners]))
