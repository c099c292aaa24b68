"""Files for fabrication: blocks in their own frames, a schedule, and joint faces in a plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, cross, dot
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.files import Job, PathLike, write_text, write_together
from drystone.base.ragged import Ragged
from drystone.base.table import Table
from drystone.geometry.frames import area_vector, area_vectors
from drystone.geometry.polyhedron import loop_edges
from drystone.io import write
from drystone.shells.materialise import cell_faces
from drystone.shells.shell_of_blocks import Shell


def block_frame(shell: Shell, block: int) -> tuple[Floats, Floats]:
    """A block's own frame.

    Parameters
    ----------
    shell
        It has the block.
    block
        Its number in ``shell.assembly``.

    Returns
    -------
    axes : (3, 3)
        Rows: along the course, across the courses, out through the thickness; right-handed.
    origin : (3,) [m], its centre of mass
    """
    cell = shell.mesh.cells[block]
    low, high, _ = cell_faces(shell.mesh, shell.pins, cell)
    middle = 0.5 * (shell.pins.point[list(reversed(low))] + shell.pins.point[list(high)])
    out = area_vector(middle)
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

    Parameters
    ----------
    shell
        Its voussoirs are listed.

    Examples
    --------
    >>> from drystone.shells import Layout, barrel_vault, build_shell, schedule
    >>> shell = build_shell(barrel_vault(6.0, 6.0), Layout(courses=10, blocks=4))
    >>> row = list(schedule(shell))[5]
    >>> row["block"], row["joints"], row["bevels"][:10]
    ('c01-b01', 6, '81.000000 ')
    """
    assembly = shell.assembly
    blocks = [assembly.blocks[i] for i in shell.voussoirs]
    extent, bevels, corners = [], [], []
    for i, body in zip(shell.voussoirs.tolist(), blocks, strict=True):
        axes, origin = block_frame(shell, i)
        extent.append(np.ptp((body.vertices - origin) @ axes.T, axis=0))
        bevel, corner = _angles(shell, i, axes[2])
        bevels.append(bevel)
        corners.append(corner)
    columns = {
        "block": [assembly.names[i] for i in shell.voussoirs],
        **{key: [b.metadata[key] for b in blocks] for key in ("role", "course", "position")},
        "volume": assembly.volume[shell.voussoirs],
        "mass": assembly.mass[shell.voussoirs],
        "centre": assembly.centroid[shell.voussoirs],
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
    area = area_vectors(shell.pins.point[np.concatenate(sides)], start)
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


_MARGIN = 0.25
"""Space between drawn faces, relative to the mean height of a face."""

_LABEL = 0.06
"""Height of a label relative to the width of its face. Chosen: two names fit."""


@dataclass(frozen=True, eq=False)
class FlatFace(OneLine):
    """A side face in its own plane.

    Attributes
    ----------
    block, neighbour
        Names; the neighbour is empty on a free edge.
    corner : (k, 2) [m]
        Seen from outside the block, the intrados edge along x; of a triangle its first edge.
    """

    block: str
    neighbour: str
    corner: Floats


def own_frame(shell: Shell, block: int | str) -> Block:
    """A block moved into its own frame (``drystone.shells.fabrication.block_frame``).

    Parameters
    ----------
    shell
        It has the block.
    block
        Its name or number.
    """
    i = int(shell.assembly.indices([block])[0])
    axes, origin = block_frame(shell, i)
    return shell.assembly.blocks[i].transformed(axes, -axes @ origin)


def write_blocks(shell: Shell, folder: PathLike, *, suffix: str = ".obj") -> list[Path]:
    """A file per voussoir, in its own frame, with the name of the block.

    Parameters
    ----------
    shell
    folder
        Created if it does not exist.
    suffix
        ``.obj`` keeps polygons; any other format that :func:`drystone.write` knows.

    Raises
    ------
    FormatError
        The format is not known or the folder cannot be written.
    """
    target = Path(folder)
    blocks = [own_frame(shell, i) for i in shell.voussoirs.tolist()]
    jobs: list[Job] = [
        (target / f"{block.name}{suffix}", partial(write, Assembly((block,)))) for block in blocks
    ]
    return [Path(path) for path in write_together(jobs, into=target)]


def flat_faces(shell: Shell, block: int | str) -> tuple[FlatFace, ...]:
    """The side faces of a block, each in its own plane.

    Parameters
    ----------
    shell
        It has the block.
    block
        Its name or number.

    Examples
    --------
    >>> from drystone.shells import Layout, barrel_vault, build_shell, flat_faces
    >>> shell = build_shell(barrel_vault(6.0, 6.0), Layout(courses=10, blocks=4))
    >>> sorted(face.neighbour for face in flat_faces(shell, "c01-b01"))[:3]
    ['c00-b00', 'c00-b01', 'c01-b00']
    """
    i = int(shell.assembly.indices([block])[0])
    point = shell.pins.point
    beside = shell.beside
    faces = []
    for face in cell_faces(shell.mesh, shell.pins, shell.mesh.cells[i])[2]:
        corner = point[list(face)]
        out = area_vector(corner)
        along = corner[1] - corner[0] if len(face) <= 4 else corner[0] - corner[-1]
        x = along / np.linalg.norm(along)
        y = np.cross(out / np.linalg.norm(out), x)
        flat = (corner - corner[0]) @ np.stack([x, y], axis=1)
        others = [b for b in beside[frozenset(face)] if b != i]
        faces.append(
            FlatFace(
                shell.assembly.names[i],
                shell.assembly.names[others[0]] if others else "",
                flat - flat.min(axis=0),
            )
        )
    return tuple(faces)


def write_unrolled(
    shell: Shell, path: PathLike, *, blocks: Sequence[int | str] | None = None
) -> None:
    """The side faces of blocks as SVG or DXF, in millimetres: a row per block, labelled.

    Parameters
    ----------
    shell
    path
        Ends in ``.svg`` or ``.dxf`` (release 12, which every program reads).
    blocks
        All voussoirs when left out.

    Raises
    ------
    InputError
        Another suffix, or a block that does not exist.
    FormatError
        The file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in (".svg", ".dxf"):
        raise InputError(
            f"the suffix '{suffix}' is not known", where=str(path), remedy="use .svg or .dxf"
        )
    chosen = shell.voussoirs.tolist() if blocks is None else shell.assembly.indices(blocks).tolist()
    placed = _rows([flat_faces(shell, i) for i in chosen])
    text = _svg(placed) if suffix == ".svg" else _dxf(placed)
    write_text(path, text)


def _rows(blocks: Sequence[Sequence[FlatFace]]) -> list[tuple[FlatFace, Floats]]:
    """Faces with their corners [mm] in the drawing, a row per block."""
    heights = [float(np.ptp(face.corner[:, 1])) for faces in blocks for face in faces]
    gap = _MARGIN * float(np.mean(heights))
    placed, y = [], 0.0
    for faces in blocks:
        x, tallest = 0.0, 0.0
        for face in faces:
            width, height = np.ptp(face.corner, axis=0)
            placed.append((face, 1e3 * (face.corner + np.array([x, y]))))
            x += float(width) + gap
            tallest = max(tallest, float(height))
        y += tallest + 2.0 * gap
    return placed


def _label(face: FlatFace) -> str:
    return f"{face.block} | {face.neighbour or 'free'}"


_ON_A_SCREEN = (
    "@media screen { svg { width: 100vw; height: auto; background: white } "
    "polygon { vector-effect: non-scaling-stroke; stroke-width: 1px } }"
)
"""A browser shows the whole width: of 9 m of paper it showed an empty corner."""


def _svg(placed: Sequence[tuple[FlatFace, Floats]]) -> str:
    every = np.concatenate([corner for _, corner in placed])
    width, height = np.ceil(every.max(axis=0)) + 20.0
    size = _LABEL * float(np.mean([np.ptp(c[:, 0]) for _, c in placed]))
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}mm" height="{height:.0f}mm" '
        f'viewBox="-10 -10 {width:.0f} {height:.0f}">',
        f"<style>{_ON_A_SCREEN}</style>",
        f'<g fill="none" stroke="black" stroke-width="{0.05 * size:.2f}">',
    ]
    for _, corner in placed:
        points = " ".join(f"{x:.3f},{height - 20.0 - y:.3f}" for x, y in corner)
        lines.append(f'<polygon points="{points}"/>')
    lines.append(f'</g><g font-family="sans-serif" font-size="{size:.2f}" text-anchor="middle">')
    for face, corner in placed:
        x, y = corner.mean(axis=0)
        lines.append(f'<text x="{x:.3f}" y="{height - 20.0 - y:.3f}">{_label(face)}</text>')
    return "\n".join([*lines, "</g></svg>", ""])


def _dxf(placed: Sequence[tuple[FlatFace, Floats]]) -> str:
    """Source: AutoCAD DXF reference, release 12 (entities POLYLINE, VERTEX, TEXT)."""
    out: list[tuple[int, object]] = [(0, "SECTION"), (2, "ENTITIES")]
    for face, corner in placed:
        out += [(0, "POLYLINE"), (8, "JOINTS"), (66, 1), (70, 1)]
        for x, y in corner:
            out += [(0, "VERTEX"), (8, "JOINTS"), (10, f"{x:.4f}"), (20, f"{y:.4f}"), (30, 0)]
        out += [(0, "SEQEND"), (8, "JOINTS")]
        x, y = corner.mean(axis=0)
        size = _LABEL * float(np.ptp(corner[:, 0]))
        out += [(0, "TEXT"), (8, "LABELS"), (10, f"{x:.4f}"), (20, f"{y:.4f}"), (30, 0)]
        out += [(40, f"{size:.3f}"), (1, _label(face))]
    out += [(0, "ENDSEC"), (0, "EOF")]
    return "".join(f"{code}\n{value}\n" for code, value in out)
