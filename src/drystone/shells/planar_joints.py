"""Pins with planar or faceted joints between them, with the required thickness."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.base.progress import Progress
from drystone.geometry.polyhedron import loop_edges
from drystone.shells.materialise import (
    Pins,
    add_joggle,
    cell_faces,
    joint_polygons,
    keep_thickness,
    raise_pins,
)
from drystone.shells.patch import Side
from drystone.shells.pattern import Tessellation
from drystone.shells.planarise import PlanarReport, planarise
from drystone.shells.shape import Shape
from drystone.shells.shell_options import Intrados, JointForm, ShellBody

_LARGE_DRIFT = 0.25
"""Drift, relative to the width of a block, above which a shell has a note. Chosen: the lap of head
joints is as large."""

_LARGEST_WARP = 1e-6
"""Largest warp of a joint, relative to the width of a block. Contacts and volumes have this
accuracy."""


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
    if made.report.warp_after > _LARGEST_WARP and not made.pins.faceted:
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
