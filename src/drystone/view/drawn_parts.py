"""What pictures for CAD programs consist of: groups of blocks, small solids, and poses in time.

Lines, arrows and marks are small solids, because lines in these programs have no width.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from manifold3d import Manifold

from drystone.answer.scene import Layer, MarkerShape, Scene, SceneStage, State
from drystone.base.arrays import Floats, Ints, unit
from drystone.geometry.convex_pieces import mesh_of
from drystone.geometry.frames import frames_from_normals, rotations
from drystone.view.palette import ROLE_COLOUR, STATE_COLOUR, STATE_LABEL

Triangles: TypeAlias = tuple[Floats, Ints]
"""Points (p, 3) [m] and triangles (t, 3) of points, counter-clockwise from outside."""

SIDES = 8
"""Sides of a tube. Chosen: it looks round at the width of a force line."""

HEAD = 2.6
"""Radius of the head of an arrow, divided by that of its shaft. Chosen by eye."""

_SECONDS = 2.4
"""Duration [s] of a motion, as on the page."""

FRAMES = 25
"""Number of poses of a motion. Chosen: programs interpolate linearly between them."""

NAMES = {State.FREE: "blocks", State.SUPPORT: "supports", State.FALLING: "falling blocks"}


def tubes(start: Floats, end: Floats, radius: Floats) -> Triangles:
    """Prisms from (p, 3) to (p, 3) [m] with the radii (p,) [m]; closed at both ends."""
    return _placed(start, end, radius, Manifold.cylinder(1.0, 1.0, 1.0, SIDES))


def cones(start: Floats, end: Floats, radius: Floats) -> Triangles:
    """Cones whose bases lie at (p, 3) and whose tips lie at (p, 3) [m]."""
    return _placed(start, end, radius, Manifold.cylinder(1.0, 1.0, 0.0, SIDES))


def arrows(start: Floats, end: Floats, radius: float) -> Triangles:
    """Arrows from (p, 3) to (p, 3) [m]; a head is at most half of its arrow."""
    way, length = unit(end - start)
    head = np.minimum(2.0 * HEAD * radius, 0.5 * length)
    neck = end - head[:, None] * way
    thick = np.full(len(start), radius)
    return joined(tubes(start, neck, thick), cones(neck, end, HEAD * thick))


def arrow_ends(layer: Layer, scale: float) -> tuple[Floats, Floats]:
    """Starts and ends (p, 3) [m] of the arrows of a layer; ``scale`` in m/N.

    An arrow that acts on one block ends at its point; others are in pairs, action and reaction.
    """
    if layer.vector is None:
        return np.zeros((0, 3)), np.zeros((0, 3))
    arrow, at = scale * layer.vector, layer.position
    if layer.single:
        start, end = at - arrow, at
    else:
        start, end = np.concatenate([at, at]), np.concatenate([at + 0.5 * arrow, at - 0.5 * arrow])
    return (end, start) if layer.inward else (start, end)


def marks(position: Floats, radius: float, shape: MarkerShape) -> Triangles:
    """Spheres or octahedra about (p, 3) [m]."""
    points, corners = mesh_of(Manifold.sphere(radius, 16 if shape is MarkerShape.DISC else 4))
    return _repeated(position[:, None] + points, corners)


def joined(*parts: Triangles) -> Triangles:
    """Several sets of triangles as one."""
    first = np.cumsum([0, *(len(points) for points, _ in parts[:-1])])
    points = np.concatenate([points for points, _ in parts])
    return points, np.concatenate([c + f for (_, c), f in zip(parts, first, strict=True)])


def _placed(start: Floats, end: Floats, radius: Floats, solid: Manifold) -> Triangles:
    """Copies of a solid of height and radius one along z, from (p, 3) to (p, 3) [m]."""
    points, corners = mesh_of(solid)
    along = end - start
    frame = frames_from_normals(unit(along)[0])  # of a line without length it is of no matter
    across = radius[:, None, None] * (points[:, :2] @ frame[:, 1:])
    return _repeated(start[:, None] + points[:, 2:] * along[:, None] + across, corners)


def _repeated(points: Floats, corners: Ints) -> Triangles:
    """Copies of one set of triangles: points (p, q, 3) of p copies with q points each."""
    copies, each = points.shape[:2]
    shift = each * np.arange(copies)[:, None, None]
    return points.reshape(-1, 3), (corners + shift).reshape(-1, 3)


def fall_moments() -> tuple[Floats, Floats]:
    """Times (t,) [s], and the share (t,) of the motion at each, as in a free fall."""
    share = np.linspace(0.0, 1.0, FRAMES)
    return _SECONDS * share, share**2


def quaternions(rotation: Floats) -> Floats:
    """(t, 4) x, y, z, w of rotation vectors (t, 3) [rad]."""
    from scipy.spatial.transform import Rotation  # slow to import

    return Rotation.from_rotvec(rotation).as_quat()


def matrix_of(motion: Floats, centroid: Floats) -> Floats:
    """(4, 4) of a motion (6,) [m, rad]: translation of the centroid (3,) and rotation about it."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotations(motion[None, 3:])[0]
    matrix[:3, 3] = centroid + motion[:3] - matrix[:3, :3] @ centroid
    return matrix


def stage_of_scene(scene: Scene, stage: int | None) -> SceneStage:
    """A stage by its number; when left out, the one that a figure shows."""
    return scene.stages[scene.still if stage is None else stage]


def block_groups(stage: SceneStage) -> list[tuple[str, str, list[int]]]:
    """The blocks in place, by their state: name, colour ``#rrggbb``, and blocks of each group.

    They share a layer and a material. Free blocks that need help are a group of their own.
    """
    state = stage.state
    needy = np.zeros(len(state), dtype=bool)
    if stage.prop is not None:
        needy = (state == State.FREE) & (np.linalg.norm(stage.prop, axis=1) > 0.0)
    groups = []
    for one in State:
        member = np.flatnonzero((state == one) & ~needy)
        if one is not State.ABSENT and len(member):
            name = NAMES.get(one, STATE_LABEL[one])
            groups.append((name, STATE_COLOUR["light"][one], member.tolist()))
    if needy.any():
        help_colour = ROLE_COLOUR["light"]["help"]
        groups.append(("blocks that need help", help_colour, np.flatnonzero(needy).tolist()))
    return groups
