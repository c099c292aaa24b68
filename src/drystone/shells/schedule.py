"""The frame of each block for fabrication, and a schedule."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields

import numpy as np

from drystone.base.arrays import Floats, cross, dot
from drystone.base.display import OneLine
from drystone.base.files import PathLike, write_bytes
from drystone.base.ragged import Ragged
from drystone.geometry import polygon
from drystone.geometry.polyhedron import loop_edges
from drystone.shells.materialise import cell_faces
from drystone.shells.shell_of_blocks import Shell


@dataclass(frozen=True)
class ScheduleRow(OneLine):
    """One row of the schedule; lengths and angles in the block's own frame.

    Attributes
    ----------
    name, role
    course, position
    volume_m3, mass_kg
    x_m, y_m, z_m
        Centre of mass in the shell.
    along_m, across_m, through_m
        Bounding box in the block's own frame: along the course, across the courses, through the
        thickness.
    joints
        Number of side faces.
    bevel_deg
        Per side face the angle between it and the middle plane of the block; 90 is square.
    corner_deg
        The interior angle between two neighbouring side faces, at each edge that they share, in the
        order of the faces. A bed joint with a joggle has three faces; the angles at their two edges
        are included.
    """

    name: str
    role: str
    course: int
    position: int
    volume_m3: float
    mass_kg: float
    x_m: float
    y_m: float
    z_m: float
    along_m: float
    across_m: float
    through_m: float
    joints: int
    bevel_deg: tuple[float, ...]
    corner_deg: tuple[float, ...]


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


def schedule(shell: Shell) -> tuple[ScheduleRow, ...]:
    """The schedule of the voussoirs, in the order of the assembly.

    Examples
    --------
    >>> from drystone.shells import Layout, barrel_vault, build_shell, schedule
    >>> shell = build_shell(barrel_vault(6.0, 6.0), Layout(courses=10, blocks=4))
    >>> row = schedule(shell)[5]
    >>> row.name, row.joints, round(min(row.bevel_deg), 3)
    ('c01-b01', 6, 81.0)
    """
    rows = []
    for block in shell.voussoirs.tolist():
        body = shell.assembly.blocks[block]
        axes, origin = block_frame(shell, block)
        extent = np.ptp((body.vertices - origin) @ axes.T, axis=0)
        bevel, corner = _angles(shell, block, axes[2])
        rows.append(
            ScheduleRow(
                name=body.name,
                role=str(body.metadata["role"]),
                course=int(body.metadata["course"]),
                position=int(body.metadata["position"]),
                volume_m3=body.volume,
                mass_kg=body.mass,
                x_m=float(origin[0]),
                y_m=float(origin[1]),
                z_m=float(origin[2]),
                along_m=float(extent[0]),
                across_m=float(extent[1]),
                through_m=float(extent[2]),
                joints=len(bevel),
                bevel_deg=bevel,
                corner_deg=corner,
            )
        )
    return tuple(rows)


def write_schedule(shell: Shell, path: PathLike) -> None:
    """The schedule as CSV: one row per voussoir, angles separated by blanks.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([field.name for field in fields(ScheduleRow)])
    for row in schedule(shell):
        writer.writerow([_text(value) for value in asdict(row).values()])
    write_bytes(path, text.getvalue().encode())


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(f"{angle:.3f}" for angle in value)
    return f"{value:.6f}" if isinstance(value, float) else str(value)


def _angles(shell: Shell, block: int, out: Floats) -> tuple[tuple[float, ...], tuple[float, ...]]:
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
    corner = 180.0 - np.rad2deg(turn)
    return tuple(_rounded(bevel)), tuple(_rounded(corner))


def _shared_edges(sides: Sequence[Sequence[int]]) -> list[tuple[int, int, int, int]]:
    """Edges between two side faces: both faces, the ends in the direction of the first."""
    face_of = {edge: f for f, face in enumerate(sides) for edge in loop_edges(face)}
    shared = [
        (f, face_of[b, a], a, b) for (a, b), f in face_of.items() if a < b and (b, a) in face_of
    ]
    return sorted(shared)


def _rounded(angle: Floats) -> list[float]:
    return [round(float(value), 6) for value in angle]
