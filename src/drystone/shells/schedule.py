"""The frame of each block for fabrication, and a schedule."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base.arrays import Floats, cross, dot
from drystone.base.ragged import Ragged
from drystone.base.table import Table
from drystone.geometry import polygon
from drystone.geometry.polyhedron import loop_edges
from drystone.shells.materialise import cell_faces
from drystone.shells.shell_of_blocks import Shell


def block_frame(shell: Shell, block: int) -> tuple[Floats, Floats]:
    """A block's own frame.

    Returns
    -------
    axes : (3, 3)
        Rows: along the course, across the courses, out through the thickness; right-handed.
    origin : (3,) [m], its centre of mass
    """
    cell = shell.mesh.cells[block]
    low, high, _ = cell_faces(shell.mesh, shell.pins, cell)
    middle = 0.5 * (shell.pins.point[list(reversed(low))] + shell.pins.point[list(high)])
    out = polygon.area_vector(middle)
    out /= np.linalg.norm(out)
    up = shell.mesh.up[list(cell)].mean(axis=0)
    up -= (up @ out) * out
    up /= np.linalg.norm(up)
    return np.stack([np.cross(up, out), up, out]), shell.assembly.blocks[block].centroid


def schedule(shell: Shell) -> Table:
    """A row per voussoir, in the order of the assembly; angles of each one separated by blanks.

    ``centre`` is the centre of mass in the shell, ``extent`` the bounding box in the block's own
    frame. ``bevels`` are the angles between each side face and the middle plane of the block: 90 is
    square. ``corners`` are the interior angles between two neighbouring side faces, at each edge
    that they share, in the order of the faces. A bed joint with a joggle has three faces; the
    angles at their two edges are included.

    Examples
    --------
    >>> from drystone.shells import Layout, barrel_vault, build_shell, schedule
    >>> shell = build_shell(barrel_vault(6.0, 6.0), Layout(courses=10, blocks=4))
    >>> row = list(schedule(shell))[5]
    >>> row["block"], row["joints"], row["bevels"][:10]
    ('c01-b01', 6, '81.000000 ')
    """
    blocks = [shell.assembly.blocks[i] for i in shell.voussoirs]
    extent, bevels, corners = [], [], []
    for i, body in zip(shell.voussoirs.tolist(), blocks, strict=True):
        axes, origin = block_frame(shell, i)
        extent.append(np.ptp((body.vertices - origin) @ axes.T, axis=0))
        bevel, corner = _angles(shell, i, axes[2])
        bevels.append(bevel)
        corners.append(corner)
    columns = {
        "block": [body.name for body in blocks],
        **{key: [b.metadata[key] for b in blocks] for key in ("role", "course", "position")},
        "volume": [body.volume for body in blocks],
        "mass": [body.mass for body in blocks],
        "centre": shell.assembly.centroid[shell.voussoirs],
        "extent": np.array(extent),
        "joints": [len(each) for each in bevels],
        "bevels": [_in_a_row(each) for each in bevels],
        "corners": [_in_a_row(each) for each in corners],
    }
    units = {"volume": "m3", "mass": "kg", "centre": "m", "extent": "m"}
    return Table("schedule", columns, {**units, "bevels": "deg", "corners": "deg"})


def _angles(shell: Shell, block: int, out: Floats) -> tuple[Floats, Floats]:
    """Bevels and corners of a block [degrees]."""
    sides = cell_faces(shell.mesh, shell.pins, shell.mesh.cells[block])[2]
    start = Ragged.of(sides).start
    area = polygon.area_vectors(shell.pins.point[np.concatenate(sides)], start)
    normal = area / np.linalg.norm(area, axis=1, keepdims=True)
    bevel = 90.0 + np.rad2deg(np.arcsin(np.clip(normal @ out, -1.0, 1.0)))
    shared = _shared_edges(sides)
    along = np.array([shell.pins.point[b] - shell.pins.point[a] for _, _, a, b in shared])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    one, other = (normal[[edge[k] for edge in shared]] for k in (0, 1))
    turn = np.arctan2(dot(cross(one, other), along), dot(one, other))
    return bevel, 180.0 - np.rad2deg(turn)


def _shared_edges(sides: Sequence[Sequence[int]]) -> list[tuple[int, int, int, int]]:
    """Edges between two side faces: both faces, the ends in the direction of the first."""
    face_of = {edge: f for f, face in enumerate(sides) for edge in loop_edges(face)}
    shared = [
        (f, face_of[b, a], a, b) for (a, b), f in face_of.items() if a < b and (b, a) in face_of
    ]
    return sorted(shared)


def _in_a_row(angle: Floats) -> str:
    return " ".join(f"{value:.6f}" for value in angle)
