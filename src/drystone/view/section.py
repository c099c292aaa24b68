"""A section plane across an axis: what lies between it and the eye is not drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drystone.answer.scene import Layer, LayerKind, Scene
from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.geometry.polyhedron import Faces, rings
from drystone.geometry.slipping import clipped

AXES = "xyz"
NEAR = 1e-3
"""By the size of a block: forces, marks and joints so near the plane lie in it, and are drawn. A
thrust line in the middle of an arch is there up to the accuracy of the forces. Blocks that reach
so far through a plane between them are on either side of it. Chosen."""
_WRITE = "write an axis, such as x, or an axis and a coordinate in metres, such as x=1.2"


@dataclass(frozen=True)
class Plane:
    """What is above it is not drawn.

    Attributes
    ----------
    normal : (3,) unit
    offset : [m], of the points of the plane along the normal
    """

    normal: Floats
    offset: float

    def heights(self, points: Floats) -> Floats:
        """[m] of points (p, 3) above the plane."""
        return points @ self.normal - self.offset


def read_section(text: str) -> tuple[int, float | None]:
    """The axis (0, 1, 2) and the coordinate [m] of a section, such as ``x=1.2``.

    The coordinate is None for a section through the middle of the model, such as ``x``.

    Raises
    ------
    InputError

    Examples
    --------
    >>> read_section("x=1.2"), read_section("z")
    ((0, 1.2), (2, None))
    """
    name, given, number = text.partition("=")
    axis = AXES.find(name.strip()) if name.strip() else -1
    at: float | None = None
    if given:
        try:
            at = float(number)
        except ValueError as error:
            raise InputError(f"'{number}' is not a coordinate", remedy=_WRITE) from error
        if not np.isfinite(at):
            raise InputError(f"the coordinate of the section is {at}", remedy=_WRITE)
    if axis < 0 or len(name.strip()) != 1:
        raise InputError(f"there is no section '{text}'", remedy=_WRITE)
    return axis, at


def section_through(assembly: Assembly, section: str) -> tuple[int, float]:
    """The axis and the coordinate [m] of a section through an assembly.

    Raises
    ------
    InputError
        The section is not an axis with or without a coordinate, or does not pass through a block.
    """
    axis, at = read_section(section)
    low = float(assembly.bounds[:, 0, axis].min())
    high = float(assembly.bounds[:, 1, axis].max())
    at = 0.5 * (low + high) if at is None else at
    if not low < at < high:
        raise InputError(
            f"the section {AXES[axis]} = {at:g} m does not pass through the model",
            remedy=f"give {AXES[axis]} between {low:.6g} and {high:.6g} m",
        )
    return axis, at


def cut_at(scene: Scene, section: str) -> Scene:
    """A scene with a section.

    Raises
    ------
    InputError
        As :func:`section_through`.
    """
    return replace(scene, section=section_through(scene.assembly, section))


def plane_of(scene: Scene, eye: Floats) -> Plane | None:
    """The section plane of a scene, its normal towards the eye (3,); None where there is none."""
    if scene.section is None:
        return None
    axis, at = scene.section
    side = 1.0 if eye[axis] >= 0.0 else -1.0
    normal = np.zeros(3)
    normal[axis] = side
    return Plane(normal, side * at)


def seen_behind(layers: list[Layer], plane: Plane, block_size: float) -> list[Layer]:
    """The parts of layers that a section leaves, of those of which something is left."""
    left = [behind(layer, plane, block_size) for layer in layers]
    return [layer for layer in left if layer.count]


def behind(layer: Layer, plane: Plane, block_size: float) -> Layer:
    """The part of a layer that a section leaves; ``block_size`` [m] tells what is in the plane."""
    plane = Plane(plane.normal, plane.offset + NEAR * block_size)
    height = plane.heights(layer.position)
    if layer.kind is LayerKind.POLYGONS:
        return _polygons_behind(layer, height)
    shown = height <= 0.0
    position, vector = layer.position, layer.vector
    if layer.kind is LayerKind.LINES and vector is not None:
        other = plane.heights(position + vector)
        shown |= other <= 0.0
        share = height / np.where(height == other, 1.0, height - other)
        first = np.where(height > 0.0, share, 0.0)
        last = np.where(other > 0.0, share, 1.0)
        position = position + first[:, None] * vector
        vector = (last - first)[:, None] * vector
    return replace(
        layer,
        position=position[shown],
        vector=None if vector is None else vector[shown],
        value=None if layer.value is None else layer.value[shown],
        interface=None if layer.interface is None else layer.interface[shown],
        block=None if layer.block is None else layer.block[shown],
    )


def _polygons_behind(layer: Layer, height: Floats) -> Layer:
    loops = Ragged(np.zeros(1, dtype=np.intp) if layer.start is None else layer.start)
    value = np.zeros(len(layer.position)) if layer.value is None else layer.value
    part, told = clipped(loops, np.c_[layer.position, value], -height)
    kept = part.counts > 0
    return replace(
        layer,
        position=told[:, :3],
        value=None if layer.value is None else told[:, 3],
        start=Ragged.from_counts(part.counts[kept]).start,
        interface=None if layer.interface is None else layer.interface[kept],
        block=None if layer.block is None else layer.block[kept],
    )


def clip_loop(corner: Floats, height: Floats, marked: Bools) -> tuple[Floats, Bools]:
    """The part of a polygon that is not beyond a plane.

    Parameters
    ----------
    corner : (c, d)
        Coordinates, and other values that are interpolated along the sides.
    height : (c,)
        Of the corners above the plane.
    marked : (c,)
        Whether the side from each corner to the next is marked.

    Returns
    -------
    corner : (e, d)
    marked : (e,)
        Sides that lie in the plane are not.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> part, marked = clip_loop(square, square[:, 0] - 0.5, np.ones(4, dtype=bool))
    >>> part.tolist(), marked.tolist()
    ([[0.0, 0.0], [0.5, 0.0], [0.5, 2.0], [0.0, 2.0]], [True, False, True, True])
    """
    beyond = height > 0.0
    if not beyond.any():
        return corner, marked
    after = np.roll(np.arange(len(corner)), -1)
    points: list[Floats] = []
    sides: list[bool] = []
    for i, j in enumerate(after.tolist()):
        if not beyond[i]:
            points.append(corner[i])
            sides.append(bool(marked[i]))
        if beyond[i] != beyond[j]:
            share = height[i] / (height[i] - height[j])
            points.append(corner[i] + share * (corner[j] - corner[i]))
            sides.append(bool(marked[i] and beyond[i]))
    return np.array(points).reshape(-1, corner.shape[1]), np.array(sides, dtype=bool)


def cut_faces(faces: Faces, normal: Floats, offset: float) -> list[tuple[int, Floats]]:
    """The sections of closed bodies by the plane ``normal @ x = offset``.

    Parameters
    ----------
    faces
        Of closed bodies, oriented outwards.
    normal : (3,) unit
    offset : [m]

    Returns
    -------
    Body and corners (c, 3) [m] of each ring, counter-clockwise seen from the side of the normal;
    holes run the other way round.

    Examples
    --------
    >>> from drystone.geometry.polyhedron import stack_faces
    >>> from drystone.models import box
    >>> cube = box((1.0, 1.0, 1.0))
    >>> faces = stack_faces([cube.vertices], [cube.faces])
    >>> (body, ring), = cut_faces(faces, np.array([0.0, 0.0, 1.0]), 0.25)
    >>> body, ring.shape, ring[:, 2].tolist()
    (0, (4, 3), [0.25, 0.25, 0.25, 0.25])
    """
    height = faces.point @ normal - offset
    beyond = height > 0.0
    corner_beyond = beyond[faces.loop]
    mixed = faces.corners.any(corner_beyond) & ~faces.corners.all(corner_beyond)
    follows: dict[tuple[int, int], tuple[int, int]] = {}
    place: dict[tuple[int, int], Floats] = {}
    body: dict[tuple[int, int], int] = {}
    area = faces.area_vectors
    for face in np.flatnonzero(mixed).tolist():
        loop = faces.loop[faces.start[face] : faces.start[face + 1]]
        crossed = [
            (min(i, j), max(i, j))
            for i, j in zip(loop.tolist(), np.roll(loop, -1).tolist(), strict=True)
            if beyond[i] != beyond[j]
        ]
        for i, j in crossed:
            share = height[i] / (height[i] - height[j])
            place[i, j] = faces.point[i] + share * (faces.point[j] - faces.point[i])
            body[i, j] = int(faces.owner[face])
        along = np.cross(normal, area[face])  # the body lies to the left
        crossed.sort(key=lambda edge: float(place[edge] @ along))
        follows.update(zip(crossed[::2], crossed[1::2], strict=True))
    return [(body[ring[0]], np.array([place[one] for one in ring])) for ring in rings(follows)]
