"""Struts: blocks that fit between a falling block and a near block."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from drystone.assembly import Block
from drystone.base.arrays import Floats, Ints
from drystone.base.errors import InputError
from drystone.design.changed_model import fresh_name, usual_friction
from drystone.design.props import seats
from drystone.geometry.convex_pieces import solid_of
from drystone.geometry.frames import frames_from_normals, rotation_about
from drystone.geometry.glue import cut_cell
from drystone.geometry.solid import crossings
from drystone.geometry.triangulate import triangulate
from drystone.model import Model
from drystone.ties import PLATE

_LEANS = (0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0)
"""[degrees] Tried inclinations of a strut from the normal of the face. Chosen."""

_WITHIN = 0.9
"""Largest inclination of a strut at both ends, as a share of the friction angle. Chosen: it does
not slide under any force."""

_LONGEST = 2.0
"""Longest strut relative to the size of the block. Chosen."""


def struts(model: Model, block: int, motion: Floats) -> list[tuple[float, int, Block]]:
    """Struts that fit against a block: lengths [m], the blocks that they stand on, and the struts.

    The shortest one is the first. A strut goes from a free face that moves forward to the next
    block, with an inclination below the friction angle at both ends, and through no other block.

    Parameters
    ----------
    model
    block
    motion : (6,)
        How the block begins to move.
    """
    return sorted(_all(model, block, motion), key=lambda strut: strut[0])


def _all(model: Model, block: int, motion: Floats) -> Iterator[tuple[float, int, Block]]:
    limit = _WITHIN * np.arctan(usual_friction(model))
    body = model.assembly.blocks[block]
    triangles, owner = _triangles(model)
    for seat, lean in product(seats(model, block, motion), _LEANS):
        if abs(np.deg2rad(lean)) > limit:
            continue
        frame = frames_from_normals(-np.asarray(seat.normal)[None])[0]
        point, along = seat.outline.mean(axis=0), rotation_about(frame[1], lean) @ frame[0]
        hit = _first_hit(triangles, owner, block, point, along, _LONGEST * body.size)
        if hit is None:
            continue
        on, length, normal = hit
        if -normal @ along >= np.cos(limit):
            strut = _fitted(model, block, point, along, length, -seat.normal, normal)
            if strut is not None:
                yield length, on, strut


def _triangles(model: Model) -> tuple[Floats, Ints]:
    """All faces as triangles (t, 3, 3), and the block of each (t,)."""
    faces = model.assembly.faces
    triangle, face = triangulate(faces.point[faces.loop], faces.start)
    return faces.point[faces.loop][triangle], faces.owner[face]


def _first_hit(
    triangles: Floats, owner: Ints, block: int, point: Floats, along: Floats, reach: float
) -> tuple[int, float, Floats] | None:
    """The first block that a ray hits, its distance, and the normal of its face there."""
    others = owner != block
    shape = (int(others.sum()), 3)
    start, end = np.broadcast_to(point, shape), np.broadcast_to(point + reach * along, shape)
    hit, share = crossings(start, end, triangles[others])
    if not hit.any():
        return None
    first = int(np.argmin(np.where(hit, share, np.inf)))
    corner = triangles[others][first]
    normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    size = float(np.linalg.norm(normal))
    if size == 0.0 or share[first] * reach < 1e-3 * reach:
        return None
    return int(owner[others][first]), float(share[first]) * reach, normal / size


def _fitted(
    model: Model,
    block: int,
    point: Floats,
    along: Floats,
    length: float,
    seat: Floats,
    landing: Floats,
) -> Block | None:
    """A bar between two faces, cut to them; ``None`` if another block is between them.

    Parameters
    ----------
    model, block, point, along, length
    seat, landing : (3,) unit
        Outward normals of the face of the block, and of the face that the strut stands on.
    """
    body = model.assembly.blocks[block]
    half = 0.5 * PLATE * body.size
    frame = frames_from_normals(along[None])[0]
    # the line across the strut that lies in both faces stays whole; as deep as the block
    across = np.cross(along, seat) if abs(along @ seat) < 0.999 else frame[1]
    across /= np.linalg.norm(across)
    deep = body.vertices @ across
    low, high = float(deep.min()), float(deep.max())
    other = np.cross(along, across)
    start = point - 2.0 * half * along
    end = point + (length + 2.0 * half) * along
    ring = [(low, -half), (high, -half), (high, half), (low, half)]
    base = np.array(
        [p + (a - p @ across) * across + b * other for p in (start, end) for a, b in ring]
    )
    here = range(4)
    sides: list[tuple[int, ...]] = [(i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in here]
    faces: list[tuple[int, ...]] = [(3, 2, 1, 0), (4, 5, 6, 7), *sides]
    if np.linalg.det(np.array([across, other, along])) < 0.0:
        faces = [face[::-1] for face in faces]
    far = point + length * along
    normals = -np.array([seat, landing])
    offsets = np.array([-seat @ point, -landing @ far])
    try:
        (piece, *_), _ = cut_cell([(base, faces)], normals, offsets)
        made = Block(piece[0], tuple(piece[1]), fresh_name(model, "strut"), body.density)
    except (InputError, ValueError):
        return None
    return None if _in_the_way(model, made) else made


def _in_the_way(model: Model, body: Block) -> bool:
    """Whether a body shares volume with a block of the model."""
    solid = solid_of(body.vertices, body.faces)
    low, high = body.bounds
    for other in model.assembly.blocks:
        if (other.bounds[0] >= high).any() or (other.bounds[1] <= low).any():
            continue
        common = (solid ^ solid_of(other.vertices, other.faces)).volume()
        if common > 1e-6 * body.volume:
            return True
    return False
