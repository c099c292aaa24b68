"""Blocks from a section or from faces, published sections, and checks of parameters."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from drystone.assembly import DEFAULT_DENSITY, Block
from drystone.base.arrays import ROUNDING, Floats, frozen_floats
from drystone.base.errors import InputError
from drystone.geometry.coincidence import distinct
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
    text = resources.files("drystone.models").joinpath("sections.json").read_text("utf-8")
    return json.loads(text)[model]


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


def rectangle(axis: int, at: float, first: Sequence[float], second: Sequence[float]) -> Floats:
    """A rectangle (4, 3) [m] in the plane where coordinate ``axis`` is ``at``.

    Parameters
    ----------
    axis
        0, 1 or 2.
    at : [m]
    first, second : (2,) [m]
        Extent along the two other axes, in the order x, y, z.
    """
    (a0, a1), (b0, b1) = first, second
    plane = np.array([(a0, b0), (a1, b0), (a1, b1), (a0, b1)], dtype=np.float64)
    return np.insert(plane, axis, at, axis=1)


def shell_faces(shell: Floats) -> list[Floats]:
    """Faces of a piece of shell (2, 2, s, 3): inner and outer, lower and upper, stations."""
    faces = [shell[:, :, end].reshape(4, 3)[[0, 1, 3, 2]] for end in (0, -1)]
    for i in range(shell.shape[2] - 1):
        faces += [shell[side, :, i : i + 2].reshape(4, 3)[[0, 1, 3, 2]] for side in (0, 1)]
        faces += [shell[:, bed, i : i + 2].reshape(4, 3)[[0, 1, 3, 2]] for bed in (0, 1)]
    return faces
