"""Scenes of simulators as blocks: rigid bodies with poses, each of one solid part or several.

Every reader of a scene (MJCF, URDF, USD) makes :class:`PlacedBody`; here they become shapes. The
parts of one body are united, since simulators want concave bodies in convex parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

import manifold3d
import numpy as np
from scipy.spatial import QhullError

from drystone.assembly import DEFAULT_DENSITY
from drystone.base.arrays import FARTHEST, SAME, Floats, frozen_floats
from drystone.base.errors import FormatError, InputError, counted
from drystone.base.files import read_bytes
from drystone.base.units import scale_of
from drystone.geometry.convex_pieces import hull_of, mesh_of, solid_of
from drystone.geometry.polyhedron import (
    BOX,
    Loop,
    box_corners,
    mass_properties,
    prism_faces,
    stack_faces,
)
from drystone.geometry.surface import edge_defects
from drystone.io.draft import DraftBlock
from drystone.io.face_soup import FaceSoup, moved, named_apart, shape_of, shapes_of
from drystone.io.outside import Unfolded
from drystone.io.registry import format_of

Part: TypeAlias = tuple[Floats, Sequence[Loop]]
"""Vertices (v, 3) [m] and faces."""

MESHES = (".obj", ".stl", ".ply", ".glb", ".dae")
"""Suffixes of mesh files beside a scene."""
_GROWN, _UNITED = 1e-6, 1e-5
"""Parts are united after they have grown by the first share of their body, so that the gap of a cut
closes; afterwards points nearer than the second are one. Parts of 52 of 53 exported concave blocks
of the catalogue then make one body, without it of none."""
_ROUND = 64
"""Sides of a cylinder. Chosen: its radius is short by a thousandth in the middle of a side."""
_MARGIN = 0.25
"""Of the extent of the scene: how far the ground reaches beyond it, and how thick it is. Chosen."""


@dataclass(frozen=True, eq=False)
class PlacedBody:
    """A rigid body of a scene.

    Attributes
    ----------
    name
    parts
        In the frame of the scene [m].
    fixed
        Whether it is joined to the world.
    where
        Place in the file, for errors.
    mass : [kg]
        ``None`` where the file has none; then ``density`` holds.
    density : [kg/m3]
    friction
        Coefficient, ``None`` where the file has none.
    planes
        Poses (4, 4) of planes, in their xy plane: each is a slab of ground below all bodies.
    """

    name: str
    parts: tuple[Part, ...]
    fixed: bool
    where: str
    mass: float | None = None
    density: float = DEFAULT_DENSITY
    friction: float | None = None
    planes: tuple[Floats, ...] = ()


def shapes_of_bodies(
    bodies: Sequence[PlacedBody], path: Path
) -> tuple[list[DraftBlock], list[str]]:
    """A shape for each body that has a part and for each plane, and notes.

    Raises
    ------
    FormatError
        A part has no faces.
    """
    solid = [body for body in bodies if body.parts]
    empty = sum(not body.parts and not body.planes for body in bodies)
    notes = [f"{counted(empty, 'body', 'bodies')} without a shape left out"] if empty else []
    for body in bodies:
        for pose in body.planes:
            slab = _ground_under(solid, pose)
            solid.append(replace(body, parts=(slab,), fixed=True, mass=None, planes=()))
    shapes, renamed = named_apart([_shape(body, path) for body in solid])
    return shapes, [*notes, *renamed]


def _shape(body: PlacedBody, path: Path) -> DraftBlock:
    """The parts of a body as one shape, of its material."""
    whole = _united(body, path) if len(body.parts) > 1 else None
    if whole is None:
        soups = [FaceSoup(p, f, body.name, body.where, split=False) for p, f in body.parts]
        whole = _together(shapes_of(soups, SAME, path)[0])
    loops = [tuple(face) for face in whole.faces]
    own = shape_of(np.asarray(whole.vertices), loops, body.name, body.where)
    return _with_material(own, body)


def _united(body: PlacedBody, path: Path) -> DraftBlock | None:
    """One closed surface around the parts of a body; ``None`` where they make none."""
    points = np.concatenate([point for point, _ in body.parts])
    if not (np.abs(points) <= FARTHEST).all():
        return None  # it is refused with its vertex
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    solids = []
    for point, faces in body.parts:
        if edge_defects(faces) != ([], [], True):
            return None
        middle, thin = point.mean(axis=0), float(np.ptp(point, axis=0).min())
        if not thin > _UNITED * size:
            return None
        grown = middle + (point - middle) * (1.0 + _GROWN * size / thin)
        solids.append(solid_of(grown, faces))
    whole = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
    if whole.is_empty():
        return None
    point, triangle = mesh_of(whole)
    soup = FaceSoup(point, triangle.tolist(), body.name, body.where, split=False)
    shape = shapes_of([soup], _UNITED, path)[0][0]
    closed = edge_defects([tuple(face) for face in shape.faces]) == ([], [], True)
    return shape if closed else None


def _together(shapes: Sequence[DraftBlock]) -> DraftBlock:
    """The faces of several shapes as one."""
    first = np.cumsum([0, *(len(shape.vertices) for shape in shapes)]).tolist()
    loops = [
        tuple(corner + first[i] for corner in face)
        for i, shape in enumerate(shapes)
        for face in shape.faces
    ]
    points = np.concatenate([np.asarray(shape.vertices) for shape in shapes])
    return replace(shapes[0], vertices=points, faces=loops)


def _with_material(shape: DraftBlock, body: PlacedBody) -> DraftBlock:
    density = body.density
    if body.mass is not None:
        volume = volume_of(np.asarray(shape.vertices), [tuple(face) for face in shape.faces])
        density = body.mass / volume if volume > 0.0 else density
    told = {} if body.friction is None else {"friction": body.friction}
    return replace(shape, density=density, fixed=body.fixed, metadata=told)


def volume_of(vertices: Floats, faces: Sequence[Loop]) -> float:
    """Volume [m3] within some faces, whichever way round they are."""
    if not faces:
        return 0.0
    with np.errstate(all="ignore"):  # what is not finite is refused with the vertices
        return abs(float(mass_properties(stack_faces([vertices], [faces]), 1)[0][0]))


def placed(part: Part, pose: Floats) -> Part:
    """A part moved by a pose (4, 4)."""
    point, mirrored = moved(part[0], pose)
    return point, [tuple(face)[::-1] for face in part[1]] if mirrored else part[1]


def box_part(half: Floats) -> Part:
    """A box about the origin with half sizes (3,) [m]."""
    return box_corners(-half, half), BOX


def cylinder_part(radius: float, half: float) -> Part:
    """A prism about the z axis that fills the circle of a cylinder, ``half`` its height [m]."""
    angle = 2.0 * np.pi * np.arange(_ROUND) / _ROUND
    ring = radius * np.c_[np.cos(angle), np.sin(angle)]
    point = np.concatenate([np.c_[ring, np.full(_ROUND, z)] for z in (-half, half)])
    return point, prism_faces(_ROUND)


def hull_part(point: Floats, where: str) -> Part:
    """The convex hull of some points.

    Raises
    ------
    FormatError
        They lie in one plane.
    """
    try:
        used, triangle = hull_of(point)
    except (QhullError, ValueError) as error:
        raise FormatError(
            "its points enclose no volume", where=where, remedy="give four that are not in a plane"
        ) from error
    return used, [tuple(face) for face in triangle.tolist()]


def _ground_under(bodies: Sequence[PlacedBody], pose: Floats) -> Part:
    """A slab whose top lies in the xy plane of a pose (4, 4), below all of some bodies."""
    points = [point for body in bodies for point, _ in body.parts]
    every = np.concatenate(points) if points else np.zeros((1, 3))
    local = (every - pose[:3, 3]) @ pose[:3, :3]
    low, high = local.min(axis=0), local.max(axis=0)
    reach = _MARGIN * (float((high - low).max()) or 1.0)
    low, high = low - reach, high + reach
    low[2], high[2] = -reach, 0.0
    return placed((box_corners(low, high), BOX), pose)


class MeshesBeside:
    """The mesh files that a scene names, each read once.

    Parameters
    ----------
    path
        The scene. Files in the folder above its own, and below that, are read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.unfolded = Unfolded(path)
        self._known: dict[str, list[Part]] = {}

    def parts(self, name: str, where: str) -> list[Part]:
        """The parts of a mesh, which are counted each time.

        Parameters
        ----------
        name
            Path from the folder of the scene.
        where
            For errors.

        Raises
        ------
        FormatError
            It is not there, lies elsewhere, is no mesh, cannot be read, or is too much.
        """
        if name not in self._known:
            self._known[name] = _mesh_beside(self.path, name, where)
        return self.counted(self._known[name])

    def counted(self, parts: list[Part]) -> list[Part]:
        """Parts that are placed once more; see :meth:`Unfolded.take`."""
        for point, faces in parts:
            self.unfolded.take(len(point), len(faces))
        return parts


def _mesh_beside(path: Path, name: str, where: str) -> list[Part]:
    root, file = path.parent.parent, path.parent / name
    if "\0" in name or not file.resolve().is_relative_to(root.resolve()):
        raise FormatError(
            f"the mesh '{name}' is outside of the folder of the scene",
            where=where,
            remedy="move it there, or name the scene by a path from a folder above both",
        )
    if file.suffix.lower() not in MESHES:
        raise FormatError(
            f"the mesh '{name}' is in no format that is read here",
            where=where,
            remedy=f"these are: {', '.join(MESHES)}",
        )
    if not file.exists():
        raise FormatError(
            f"there is no file '{name}' of its mesh",
            where=where,
            remedy="copy it there, or write the path from the folder of the scene",
        )
    try:
        draft = format_of(file).read(read_bytes(file), file)
    except InputError as error:
        raise error.located(f"{where}, {error.where}") from error
    scale = scale_of(draft.units or "m")
    made: list[Part] = []
    for shape in draft.shapes:
        point = scale * frozen_floats(shape.vertices, (None, 3), "vertices")
        made.append((point, [tuple(face) for face in shape.faces]))
    return made
