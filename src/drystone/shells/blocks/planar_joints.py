"""Pins with planar joints between them, at the thickness asked for."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.base.progress import Progress
from drystone.shells.blocks.materialise import (
    Pins,
    add_register,
    cell_faces,
    joint_polygons,
    keep_thickness,
    raise_pins,
)
from drystone.shells.blocks.planarise import PlanarReport, planarise
from drystone.shells.bond.tessellation import Tessellation
from drystone.shells.shell_options import Body, Intrados
from drystone.shells.surface.patch import Side
from drystone.shells.surface.shape import Shape

LARGE_DRIFT = 0.25
"""Drift, by the width of a block, above which a shell has a note about it, chosen: the laps of
joints are as large."""

LARGEST_WARP = 1e-6
"""By the width of a block: joints farther from planar are refused, since contacts and volumes are
exact to this only."""


@dataclass(frozen=True, eq=False)
class PlanarPins:
    """What :func:`planar_pins` made.

    Attributes
    ----------
    pins
    report
        Lengths by the width of a block.
    off_surface
        Largest part of a corner's move that leads off the surface of its face, by that width.
    worst
        Vertex of the mesh whose corners moved most.
    """

    pins: Pins
    report: PlanarReport
    off_surface: float
    worst: int


def planar_pins(
    mesh: Tessellation, thickness: Floats, width: float, body: Body, progress: Progress | None
) -> PlanarPins:
    """Pins with planar joints between them, at the thickness asked for.

    Planarised, lengthened, given their register, and planarised again: the second time finds
    nothing to do unless there are registers or planar intrados, and then little, since a step
    raised within planar joints hardly warps them.

    Where the surface twists, pins have to lean, most of all the few that have all of the twist on
    one side. Holding those more was tried: it makes the largest drift a third less and leans the
    joints of many more blocks, so that the sample of 40 blocks needs a friction of 0.38 in place of
    0.24.
    """
    raised = raise_pins(mesh, thickness)

    def planar(pins: Pins) -> tuple[Pins, PlanarReport]:
        polygons = joint_polygons(mesh, pins)
        if body.intrados is Intrados.STRAIGHT:
            polygons += [cell_faces(mesh, pins, cell)[0] for cell in mesh.cells]
        point, report = planarise(
            pins.point, polygons, scale=width, options=body.planar, progress=progress
        )
        return Pins(point, pins.start), report

    tilted, first = planar(raised)
    grown = keep_thickness(mesh, tilted, thickness)
    if body.register_deg:
        grown = add_register(mesh, grown, body.register_deg)
    pins, last = planar(grown)
    ends = np.stack([pins.start[:-1], pins.start[1:] - 1], axis=1)
    move = (pins.point[ends] - raised.point.reshape(-1, 2, 3)) / width
    drift = np.linalg.norm(move, axis=2).max(axis=1)
    across = np.abs(np.einsum("vki,vi->vk", move, mesh.normal))
    report = replace(
        last,
        warp_before=max(first.warp_before, last.warp_before),
        drift=float(drift.max()),
        projections=first.projections + last.projections,
        newton=first.newton + last.newton,
    )
    return PlanarPins(pins, report, float(across.max()), int(drift.argmax()))


STRAIGHT_REMEDY = (
    "planar inner faces need the wedge that the curvatures ask for (wedge=None; leave --wedge out) "
    "or none (0) where the surface is bent both ways, and blocks no wider than twice their height; "
    "else leave the inner faces as they are"
)
REGISTER_REMEDY = "leave the register out: surfaces of one patch, barrels and domes, take it"


def special_remedy(shape: Shape, body: Body) -> str | None:
    """What helps most likely where blocks do not fit; None where the sizes decide."""
    if body.intrados is Intrados.STRAIGHT:
        return STRAIGHT_REMEDY
    return REGISTER_REMEDY if body.register_deg and shape.seams else None


def refuse_register_at_sides(shape: Shape, body: Body) -> None:
    """A step runs along a bed; where the beds of two patches meet at an angle it has no way on.

    Raises
    ------
    InputError
        There is a register, and a seam at which courses end.
    """
    sides = {edge.side for seam in shape.seams for edge in (seam.one, seam.other)}
    if body.register_deg and sides & {Side.LEFT, Side.RIGHT}:
        raise InputError(
            "takes no register: its courses end at seams between patches",
            where=f"shape '{shape.name}'",
            remedy=REGISTER_REMEDY,
        )


def refuse_warped(shape: Shape, made: PlanarPins, body: Body) -> None:
    """Joints, and straight inner faces, are planar to 1e-6 of a block.

    Raises
    ------
    InputError
        They are not, unless the options of planarising ask for less.
    """
    if made.report.warp_after > max(LARGEST_WARP, body.planar.tolerance):
        what = "joints and inner faces" if body.intrados is Intrados.STRAIGHT else "joints"
        raise InputError(
            f"{what} stay {made.report.warp_after:.1e} of a block's width from planar",
            where=f"shape '{shape.name}'",
            remedy=special_remedy(shape, body) or "use another wedge or register, or larger blocks",
        )


def drift_notes(mesh: Tessellation, made: PlanarPins) -> tuple[str, ...]:
    """A line about joints that are not planar, and one about a large drift, naming the block."""
    report = made.report
    notes = []
    if not report.reached:
        notes.append(f"joints are up to {report.warp_after:.1e} of a block from planar")
    if report.drift > LARGE_DRIFT:
        notes.append(
            f"the surface twists at block '{mesh.name_at(made.worst)}': its joints lean, and a "
            f"corner is {report.drift:.2f} of a block's width from where the surface has it "
            f"(noted above {LARGE_DRIFT})"
        )
    return tuple(notes)
