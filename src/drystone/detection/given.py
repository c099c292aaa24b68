"""Joints that the user gives as a mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, Ints, frozen_points
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.contacts import DEFAULT_FRICTION, Contacts, check_friction
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.polygon import area_vector, area_vectors
from drystone.geometry.solid import distance

_FARTHEST = 0.1
"""Largest warp of a face of a given joint, and its largest distance from its blocks, as a share of
the size of the smaller block. Chosen: the warp that the contact search tolerates."""


def contacts_from_mesh(
    assembly: Assembly,
    block_a: int | str,
    block_b: int | str,
    vertices: Floats,
    faces: Sequence[Sequence[int]],
    *,
    friction: float = DEFAULT_FRICTION,
) -> Contacts:
    """Interfaces between two blocks from a mesh of their joint, one plane interface per face.

    Parameters
    ----------
    assembly
    block_a, block_b
        Position or name.
    vertices : (v, 3) [m]
    faces
        Loops of vertex indices, in either direction. A slightly warped face is projected onto its
        plane.
    friction

    Returns
    -------
    Contacts
        Normals point from the block with the lower position to the one with the higher position:
        outwards from the nearest face of the first, into that of the second.

    Raises
    ------
    InputError
        The two blocks are the same; a face has an unknown vertex or no area; or its warp or its
        distance from a block is more than a tenth of the size of the smaller block (six times
        volume over surface).

    Examples
    --------
    >>> from drystone.models import tower
    >>> joint = [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    >>> found = contacts_from_mesh(tower(2), 0, 1, joint, [(0, 1, 2), (2, 3, 0)])
    >>> found.count, found.frame[:, 0].round(6).tolist()
    (2, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    """
    a, b = sorted(int(i) for i in assembly.indices([block_a, block_b]))
    if a == b:
        raise InputError("a joint needs two blocks", where=f"block '{assembly.names[a]}'")
    where = f"joint of '{assembly.names[a]}' and '{assembly.names[b]}'"
    point = frozen_points(vertices, (None, 3), "vertices")
    loops = [np.array(face, dtype=np.intp) for face in faces]
    for number, loop in enumerate(loops):
        if loop.ndim != 1 or len(loop) < 3 or loop.min() < 0 or loop.max() >= len(point):
            raise InputError(f"face {number} is no loop of vertices", where=where)
    start = Ragged.of(loops).start
    corner = point[np.concatenate([np.zeros(0, dtype=np.intp), *loops])]
    vectors = area_vectors(corner, start)
    area = np.sqrt((vectors * vectors).sum(axis=1))
    if not (area > 0.0).all():
        raise InputError(f"face {int(np.argmin(area))} has no area", where=where)
    normals = vectors / area[:, None]
    mu = float(check_friction(friction, 1)[0])
    most = _FARTHEST * min(_size(assembly, a), _size(assembly, b))
    _refuse_away(assembly, (a, b), corner, start, most, where)
    rows = []
    for i, loop in enumerate(loops):
        middle = corner[start[i] : start[i + 1]].mean(axis=0)
        points = point[loop]
        height = (points - middle) @ normals[i]
        if np.abs(height).max() > most:
            raise InputError(
                f"face {i} is warped: a corner lies {np.abs(height).max():.3g} m from its plane",
                where=where,
                remedy="cut it into triangles",
            )
        points = points - height[:, None] * normals[i]
        outward = _normal_near(assembly, a, middle) - _normal_near(assembly, b, middle)
        turn = -1.0 if normals[i] @ outward < 0.0 else 1.0
        frame = frames_from_normals(turn * normals[i][None])[0]
        rows.append((points if turn > 0.0 else points[::-1], frame, a, b, mu))
    return _contacts_of(rows)


def _size(assembly: Assembly, block: int) -> float:
    """Six times volume over surface [m]."""
    body = assembly.blocks[block]
    surface = sum(float(np.sqrt(v @ v)) for v in _face_vectors(body))
    return 6.0 * body.volume / surface


def _face_vectors(body: Block) -> Floats:
    """Area vectors (f, 3) [m2] of the faces of a block."""
    length = [len(face) for face in body.faces]
    start = Ragged.from_counts(length).start
    return area_vectors(body.vertices[[i for face in body.faces for i in face]], start)


def _refuse_away(
    assembly: Assembly,
    blocks: tuple[int, int],
    corner: Floats,
    start: Ints,
    most: float,
    where: str,
) -> None:
    """Raise if a corner of a face is too far from one of the blocks."""
    for block in blocks:
        body = assembly.blocks[block]
        surface = np.concatenate([_fan(body.vertices[list(face)]) for face in body.faces])
        away = distance(corner, surface)
        worst = int(np.argmax(away))
        if away[worst] > most:
            face = int(np.searchsorted(start, worst, side="right")) - 1
            raise InputError(
                f"face {face} is {away[worst]:.3g} m away from block '{assembly.names[block]}'",
                where=where,
                remedy="give the joint where the blocks touch, in metres",
            )


def _fan(corner: Floats) -> Floats:
    """Triangles (c, 3, 3) of a face (c, 3) about the mean of its corners."""
    middle = np.broadcast_to(corner.mean(axis=0), corner.shape)
    fan: Floats = np.stack([middle, corner, np.roll(corner, -1, axis=0)], axis=1)
    return fan


def _normal_near(assembly: Assembly, block: int, point: Floats) -> Floats:
    """Outward normal (3,) of the face of a block that is nearest to a point."""
    body = assembly.blocks[block]
    best, normal = np.inf, np.zeros(3)
    for face in body.faces:
        corner = body.vertices[list(face)]
        vector = area_vector(corner)
        away = float(distance(point[None], _fan(corner))[0])
        length = float(np.sqrt(vector @ vector))
        if away < best and length > 0.0:
            best, normal = away, vector / length
    return normal


def _contacts_of(rows: Sequence[tuple[Floats, Floats, int, int, float]]) -> Contacts:
    """Contacts from (corners, frame, block a, block b, friction) each."""
    if not rows:
        return Contacts.empty()
    count = np.array([len(row[0]) for row in rows], dtype=np.intp)
    start = Ragged.from_counts(count).start
    point = np.concatenate([row[0] for row in rows])
    vectors = area_vectors(point, start)
    return Contacts(
        np.array([row[2] for row in rows], dtype=np.intp),
        np.array([row[3] for row in rows], dtype=np.intp),
        np.array([row[1] for row in rows]),
        np.where(count > 2, np.sqrt((vectors * vectors).sum(axis=1)), 0.0),
        np.array([row[4] for row in rows]),
        point,
        np.repeat(np.arange(len(rows), dtype=np.intp), count),
    )
