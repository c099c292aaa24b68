"""Make polygons with shared corners planar, with the smallest moves of the corners.

Newton steps: the smallest move that satisfies the linearised planarity conditions. Each step
doubles the number of correct digits.

Source: Tang et al. 2014, "Form-finding with polyhedral meshes made simple".

Pins with planar or faceted joints between them, with the required thickness.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from drystone.base.arrays import SAME, Floats, Ints, dot
from drystone.base.errors import InputError
from drystone.base.settings import Progress
from drystone.geometry.polyhedron import loop_edges
from drystone.shells.materialise import (
    Pins,
    add_joggle,
    cell_faces,
    joint_polygons,
    keep_thickness,
    raise_pins,
)
from drystone.shells.patch import Shape, Side
from drystone.shells.pattern import Tessellation
from drystone.shells.shell_options import Intrados, JointForm, ShellBody

_TOLERANCE = 1e-10
"""Largest distance of a corner from its polygon's plane, relative to the length scale: far below
the 1e-6 that joints need, far above rounding."""

_REGULAR = 1e-12
"""Added to the diagonal of the Newton system, relative: conditions may depend on each other."""


@dataclass(frozen=True)
class PlanarReport:
    """Result of the planarisation; lengths are relative to the given length scale.

    Attributes
    ----------
    warp_before, warp_after
        Largest distance of a corner from the plane of its polygon.
    drift
        Largest move of a corner.
    steps
        Newton steps taken.
    reached
        Whether the tolerance was reached.
    """

    warp_before: float
    warp_after: float
    drift: float
    steps: int
    reached: bool


def planarise(
    points: Floats,
    polygons: list[tuple[int, ...]],
    *,
    scale: float,
    most: int = 30,
    progress: Progress | None = None,
) -> tuple[Floats, PlanarReport]:
    """Points near the given ones that make every polygon planar.

    Parameters
    ----------
    points : (p, 3) [m]
    polygons
        Loops of points; triangles are planar already.
    scale : [m]
        Length to which warp and drift are related, such as the size of a block.
    most
        Newton steps.
    progress
        Called as ``progress(stage, done, total)``, with 0 <= done <= total.

    Returns
    -------
    moved : (p, 3) [m]
    report

    Examples
    --------
    >>> import numpy as np
    >>> square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.1], [0, 1, 0]], dtype=float)
    >>> moved, report = planarise(square, [(0, 1, 2, 3)], scale=1.0)
    >>> report.reached, round(report.drift, 3)
    (True, 0.025)
    """
    groups = _groups(polygons)
    start = np.asarray(points, dtype=np.float64)
    x = start.copy()
    before = _warp(x, groups)
    warp, steps = before, 0
    goal = _TOLERANCE * scale
    while warp > goal and steps < most:
        move = _newton_move(x, groups, scale)
        trial = x + move
        new = _warp(trial, groups)
        length = 1.0
        while not new < warp and length > 1e-3:  # the step is too long for the linearisation
            length *= 0.5
            trial = x + length * move
            new = _warp(trial, groups)
        steps += 1
        if not new < warp:
            break
        x, warp = trial, new
        if progress is not None:
            progress("planarise", steps, most)
    drift = float(np.linalg.norm(x - start, axis=1).max(initial=0.0))
    report = PlanarReport(
        float(before / scale), float(warp / scale), drift / scale, steps, bool(warp <= goal)
    )
    return x, report


def _groups(polygons: list[tuple[int, ...]]) -> list[Ints]:
    """Points (m, k) of the polygons with the same number k of corners, above three."""
    by_size: dict[int, list[tuple[int, ...]]] = {}
    for polygon in polygons:
        if len(polygon) > 3:
            by_size.setdefault(len(polygon), []).append(polygon)
    return [np.array(by_size[k], dtype=np.intp) for k in sorted(by_size)]


def _warp(x: Floats, groups: list[Ints]) -> float:
    """Largest distance of a corner from the least-squares plane of its polygon."""
    largest = 0.0
    for group in groups:
        centred = x[group] - x[group].mean(axis=1, keepdims=True)
        normal = np.linalg.eigh(np.einsum("mki,mkj->mij", centred, centred))[1][:, :, 0]
        largest = max(largest, float(np.abs(np.einsum("mki,mi->mk", centred, normal)).max()))
    return largest


def _newton_move(x: Floats, groups: list[Ints], scale: float) -> Floats:
    """The smallest move that satisfies the linearised conditions.

    One condition per corner beyond three, c = (x_j - x_0) . n with n the unit normal of a triangle
    of the polygon: minimise ``sum |move|^2`` subject to ``J move = -c``.
    """
    rows, columns, values, residual = [], [], [], []
    offset = 0
    for group in groups:
        m, k = group.shape
        a, b = k // 3, (2 * k) // 3
        rest = [j for j in range(k) if j not in (0, a, b)]
        o, p, q = x[group[:, 0]], x[group[:, a]], x[group[:, b]]
        raw = np.cross(p - o, q - o)
        area = np.linalg.norm(raw, axis=1, keepdims=True)
        n = raw / np.maximum(area, 1e-30 * scale**2)
        for j in rest:
            r = x[group[:, j]] - o
            # r . n with r = s (p - o) + t (q - o) + c n: the plane follows its three corners
            s = dot(np.cross(r, q - o), n)[:, None] / area
            t = dot(np.cross(p - o, r), n)[:, None] / area
            for at, weight in ((j, 1.0), (a, -s), (b, -t), (0, s + t - 1.0)):
                rows.append(np.repeat(offset + np.arange(m), 3))
                columns.append((3 * group[:, at, None] + np.arange(3)).ravel())
                values.append((weight * n).ravel())
            residual.append(dot(r, n))
            offset += m
    J = sparse.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        (offset, 3 * len(x)),
    )
    normal_matrix = (J @ J.T).tocsc()
    normal_matrix = normal_matrix + _REGULAR * float(normal_matrix.diagonal().mean()) * sparse.eye(
        offset, format="csc"
    )
    factor = splu(
        normal_matrix,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    multiplier = factor.solve(-np.concatenate(residual))
    return (J.T @ multiplier).reshape(-1, 3)


_LARGE_DRIFT = 0.25
"""Drift, relative to the width of a block, above which a shell has a note. Chosen: the lap of head
joints is as large."""


@dataclass(frozen=True, eq=False)
class PlanarPins:
    """Result of :func:`planar_pins`.

    Attributes
    ----------
    pins
    report
        Lengths are relative to the width of a block.
    off_surface
        Largest component of a corner's move normal to its face, relative to that width.
    worst
        Vertex of the mesh whose corners moved most.
    """

    pins: Pins
    report: PlanarReport
    off_surface: float
    worst: int


def planar_pins(
    mesh: Tessellation, thickness: Floats, width: float, body: ShellBody, progress: Progress | None
) -> PlanarPins:
    """Pins with planar joints between them, at the thickness asked for.

    Faceted joints stay as warped as they are; the report says how much that is.

    The pins are planarised, lengthened, given their joggle, and planarised again. The second time
    changes something only with joggles or planar intrados, and then little: a step in a planar
    joint hardly warps it.

    Where the surface twists, pins must lean; those with all of the twist on one side lean most. A
    larger weight for these pins was tried. It reduced the largest drift by a third, but more joints
    leaned, and the sample of 40 blocks needed a friction of 0.38 instead of 0.24.
    """
    raised = raise_pins(mesh, thickness)
    faceted = body.joints is JointForm.FACETED

    def planar(pins: Pins) -> tuple[Pins, PlanarReport]:
        polygons = joint_polygons(mesh, pins)
        if body.intrados is Intrados.STRAIGHT:
            polygons += [cell_faces(mesh, pins, cell)[0] for cell in mesh.cells]
        point, report = planarise(
            pins.point, polygons, scale=width, most=0 if faceted else 30, progress=progress
        )
        return Pins(point, pins.start), report

    tilted, first = planar(raised)
    grown = keep_thickness(mesh, tilted, thickness)
    if body.joggle_deg:
        grown = add_joggle(mesh, grown, body.joggle_deg)
    pins, last = planar(grown)
    ends = np.stack([pins.start[:-1], pins.start[1:] - 1], axis=1)
    move = (pins.point[ends] - raised.point.reshape(-1, 2, 3)) / width
    drift = np.linalg.norm(move, axis=2).max(axis=1)
    across = np.abs(np.einsum("vki,vi->vk", move, mesh.normal))
    report = replace(
        last,
        warp_before=max(first.warp_before, last.warp_before),
        drift=float(drift.max()),
        steps=first.steps + last.steps,
    )
    pins = replace(pins, faceted=faceted)
    return PlanarPins(pins, report, float(across.max()), int(drift.argmax()))


_STRAIGHT_REMEDY = (
    "planar inner faces need the wedge of the curvatures (wedge=None; leave --wedge out) "
    "or none (0) where the surface is bent both ways, and blocks no wider than twice their height; "
    "else leave the inner faces as they are"
)
_JOGGLE_REMEDY = "leave the joggle out: surfaces of one patch, barrels and domes, take it"


def special_remedy(shape: Shape, body: ShellBody) -> str | None:
    """The most likely remedy where blocks do not fit; None where it depends on the sizes."""
    if body.intrados is Intrados.STRAIGHT:
        return _STRAIGHT_REMEDY
    return _JOGGLE_REMEDY if body.joggle_deg and shape.seams else None


def refuse_joggle_at_sides(shape: Shape, body: ShellBody) -> None:
    """Refuse joggles where courses end at a seam.

    A joggle runs along a bed joint. It cannot continue where the bed joints of two patches meet at
    an angle.

    Raises
    ------
    InputError
        There is a joggle, and a seam at which courses end.
    """
    sides = {edge.side for seam in shape.seams for edge in (seam.one, seam.other)}
    if body.joggle_deg and sides & {Side.LEFT, Side.RIGHT}:
        raise InputError(
            "takes no joggle: its courses end at seams between patches",
            where=f"shape '{shape.name}'",
            remedy=_JOGGLE_REMEDY,
        )


def refuse_warped(shape: Shape, made: PlanarPins, body: ShellBody) -> None:
    """Refuse joints and straight inner faces that are not planar to 1e-6 of a block.

    Raises
    ------
    InputError
        They are neither planar nor faceted.
    """
    if made.report.warp_after > SAME and not made.pins.faceted:
        what = "joints and inner faces" if body.intrados is Intrados.STRAIGHT else "joints"
        raise InputError(
            f"{what} stay {made.report.warp_after:.1e} of a block's width from planar",
            where=f"shape '{shape.name}'",
            remedy=special_remedy(shape, body) or "use another wedge or joggle, or larger blocks",
        )


def hook_notes(mesh: Tessellation, body: ShellBody) -> tuple[str, ...]:
    """A line where a block hooks over beds that meet at an angle: it cannot be turned in there."""
    if not body.joggle_deg:
        return ()
    largest, worst = 1.0, -1
    for number, cell in enumerate(mesh.cells):
        edges = loop_edges(cell)
        for (a, b), (_, c) in zip(edges, (*edges[1:], *edges[:1]), strict=True):
            beds = mesh.inner[[a, b, c]].all() and not mesh.heads & {
                (min(pair), max(pair)) for pair in ((a, b), (b, c))
            }
            one, other = mesh.point[b] - mesh.point[a], mesh.point[c] - mesh.point[b]
            turn = np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other)
            if beds and np.rad2deg(turn) > largest:
                largest, worst = float(np.rad2deg(turn)), number
    if worst < 0:
        return ()
    return (
        f"block '{mesh.names[worst]}' hooks over beds that meet at {largest:.0f} degrees, so it "
        "cannot be turned in: give no joggle where courses are bent",
    )


def drift_notes(mesh: Tessellation, made: PlanarPins) -> tuple[str, ...]:
    """Notes about joints that are not planar and about a large drift, with the block."""
    report = made.report
    notes = []
    if not report.reached and not made.pins.faceted:
        notes.append(f"joints are up to {report.warp_after:.1e} of a block from planar")
    if report.drift > _LARGE_DRIFT:
        notes.append(
            f"the surface twists at block '{mesh.name_at(made.worst)}': its joints lean, and a "
            f"corner moved by {report.drift:.2f} of a block's width "
            f"(noted above {_LARGE_DRIFT})"
        )
    return tuple(notes)
