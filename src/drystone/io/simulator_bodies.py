"""Bodies of simulators: their scenes as blocks, and the data of blocks for them.

Every reader of a scene (MJCF, URDF, USD) makes :class:`PlacedBody`; here they become shapes. The
parts of one body are united, since simulators want concave bodies in convex parts.

What is written are convex pieces about the centroid, mass and inertia. A simulator pushes bodies
apart that begin inside each other. Blocks do so by little where they were drawn so, and where their
joints are warped: each block divides a warped face in its own way. A body that is convex but for
its warp gets the mean planes of its faces, so that two blocks with the same corners touch in one
plane. What overlaps even so is cut back, one half each.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

import manifold3d
import numpy as np
from scipy.spatial import HalfspaceIntersection, QhullError

from drystone.assembly import DEFAULT_DENSITY, Block
from drystone.base.arrays import FARTHEST, SAME, Bools, Floats, Ints, dot, frozen_floats
from drystone.base.errors import FormatError, InputError, counted
from drystone.base.files import read_bytes
from drystone.base.units import scale_of
from drystone.geometry import boxes
from drystone.geometry.convex_pieces import ConvexPiece, convex_pieces, hull_of, mesh_of, solid_of
from drystone.geometry.frames import area_vector
from drystone.geometry.polyhedron import (
    BOX,
    Loop,
    box_corners,
    mass_properties,
    prism_faces,
    stack_faces,
)
from drystone.geometry.surface import edge_defects
from drystone.geometry.triangulate import fan_warped
from drystone.io.draft import (
    Contents,
    DraftBlock,
    FaceSoup,
    moved,
    named_apart,
    shape_of,
    shapes_of,
)
from drystone.io.outside import Unfolded
from drystone.io.registry import format_of
from drystone.model import Model

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


@dataclass(eq=False)
class PlacedBody:
    """What moves as one in a scene; readers gather it: a body, and those that are joined to it.

    Attributes
    ----------
    name
    fixed
        Whether it is joined to the world.
    where
        Place in the file, for errors.
    parts
        In the frame of the scene [m].
    mass : [kg]
        Zero where the file has none; then ``density`` holds.
    density : [kg/m3]
    friction
        Coefficients, of which the least counts; none where the file has none.
    planes
        Poses (4, 4) of planes, in their xy plane: each is a slab of ground below all bodies.
    """

    name: str
    fixed: bool
    where: str
    parts: list[Part] = field(default_factory=list)
    mass: float = 0.0
    density: float = DEFAULT_DENSITY
    friction: list[float] = field(default_factory=list)
    planes: list[Floats] = field(default_factory=list)


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
            solid.append(replace(body, parts=[slab], fixed=True, mass=0.0, planes=[]))
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
    if body.mass:
        volume = volume_of(np.asarray(shape.vertices), [tuple(face) for face in shape.faces])
        density = body.mass / volume if volume > 0.0 else density
    told = {} if not body.friction else {"friction": min(body.friction)}
    return replace(shape, density=density, fixed=body.fixed, metadata=told)


def volume_of(vertices: Floats, faces: Sequence[Loop]) -> float:
    """Volume [m3] within some faces, whichever way round they are."""
    if not faces:
        return 0.0
    with np.errstate(all="ignore"):  # what is not finite is refused with the vertices
        return abs(float(mass_properties(stack_faces([vertices], [faces]), 1)[0][0]))


def placed(part: Part, pose: Floats) -> Part:
    """A part moved by a pose (4, 4)."""
    return moved(*part, pose)


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


PLANE = 1e-7
"""A face is plane where its corners lie nearer than this share of the body's size to its mean
plane: the single precision of simulators."""


def levelled(vertices: Floats, faces: Sequence[Loop]) -> ConvexPiece | None:
    """The body between the mean planes of the faces of a body with warped faces.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops, oriented outwards.

    Returns
    -------
    ConvexPiece or None
        ``None`` where all faces are plane. And where a vertex lies above the plane of a face, of
        which it is no corner, by more than that face is warped: the body is not convex.
    """
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    planes, most = [], 0.0
    for face in faces:
        corner = vertices[list(face)]
        area = area_vector(corner)
        normal = area / max(float(np.linalg.norm(area)), np.finfo(float).tiny)
        offset = float(normal @ corner.mean(axis=0))
        height = vertices @ normal - offset
        own = float(np.abs(height[list(face)]).max())
        height[list(face)] = 0.0
        if height.max() > own + PLANE * size:
            return None
        planes.append([*normal, -offset])
        most = max(most, own)
    if most <= PLANE * size:
        return None
    try:
        found = HalfspaceIntersection(np.array(planes), vertices.mean(axis=0)).intersections
    except QhullError:  # it is thinner than its warp
        return None
    return ConvexPiece.around(np.asarray(found))


def set_apart(
    pieces: Sequence[ConvexPiece], owner: Ints, still: Bools
) -> tuple[list[ConvexPiece | None], float]:
    """The pieces, cut back where those of two bodies overlap, and the largest depth of that [m].

    Each pair is cut by the plane in the middle of its overlap, in the direction in which they
    overlap least: across a face of one of them, or across an edge of each. A piece of which nothing
    is left is ``None``, unless it is the last of its body.

    Parameters
    ----------
    pieces
    owner : (p,)
        Body of each, from 0 on.
    still : (p,)
        Pieces that cannot move: two of them are left as they are.

    Examples
    --------
    >>> cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    >>> low, high = ConvexPiece.around(cube), ConvexPiece.around(cube + [0.2, 0.0, 0.9])
    >>> (low, high), deep = set_apart([low, high], np.array([0, 1]), np.zeros(2, dtype=bool))
    >>> [round(float(z), 9) for z in (deep, low.point[:, 2].max(), high.point[:, 2].min())]
    [0.1, 0.95, 0.95]
    """
    made: list[ConvexPiece | None] = list(pieces)
    left = np.bincount(owner).tolist()
    low = np.array([one.point.min(axis=0) for one in pieces]).reshape(-1, 3)
    high = np.array([one.point.max(axis=0) for one in pieces]).reshape(-1, 3)
    size = np.linalg.norm(high - low, axis=1)
    first, second = boxes.overlapping(low, high)
    asked = (owner[first] != owner[second]) & ~(still[first] & still[second])
    deepest = 0.0
    for i, j in zip(first[asked].tolist(), second[asked].tolist(), strict=True):
        one, other = made[i], made[j]
        if one is None or other is None:
            continue
        touching = PLANE * min(size[i], size[j])
        normal, middle, depth = _least_overlap(
            one, other, np.concatenate([one.normal, -other.normal])
        )
        if depth > touching:  # they may cross with two edges
            edges = _least_overlap(one, other, _across_edges(one, other))
            normal, middle, depth = min((normal, middle, depth), edges, key=lambda cut: cut[2])
        if depth <= touching:
            continue
        deepest = max(deepest, depth)
        cut = _below(one, normal, middle), _below(other, -normal, -middle)
        gone = [k for k, part in zip((i, j), cut, strict=True) if part is None]
        if not gone:
            made[i], made[j] = cut
        for k in gone[:1]:
            if left[owner[k]] > 1:
                made[k] = None
                left[owner[k]] -= 1
    return made, deepest


def _least_overlap(
    one: ConvexPiece, other: ConvexPiece, normal: Floats
) -> tuple[Floats, float, float]:
    """Of some directions (d, 3) that in which a piece reaches least into another.

    With the middle of that overlap [m] along it, and its depth [m].
    """
    top = (one.point @ normal.T).max(axis=0)
    bottom = (other.point @ normal.T).min(axis=0)
    least = int(np.argmin(top - bottom))
    middle = 0.5 * float(top[least] + bottom[least])
    return normal[least], middle, float(top[least] - bottom[least])


def _across_edges(one: ConvexPiece, other: ConvexPiece) -> Floats:
    """Directions (d, 3) across an edge of each piece, either way.

    With those of their faces they are all that can part two convex bodies.
    """
    across = np.cross(_edges(one)[:, None], _edges(other)[None]).reshape(-1, 3)
    size = np.linalg.norm(across, axis=1)
    across = across[size > PLANE] / size[size > PLANE, None]
    return np.concatenate([across, -across])


def _edges(piece: ConvexPiece) -> Floats:
    """Unit directions (e, 3) of the edges of a piece: of two corners that share two faces."""
    height = np.abs(piece.point @ piece.normal.T - piece.offset)
    at = (height <= PLANE * np.ptp(piece.point, axis=0).max()).astype(np.intp)
    first, second = np.nonzero(np.triu(at @ at.T >= 2, 1))
    along = piece.point[second] - piece.point[first]
    return along / np.linalg.norm(along, axis=1, keepdims=True)


def _below(piece: ConvexPiece, normal: Floats, offset: float) -> ConvexPiece | None:
    """The part of a piece where ``normal @ x <= offset``; ``None`` where nothing is left."""
    solid = manifold3d.Manifold.hull_points(piece.point).trim_by_plane(-normal, -offset)
    return None if solid.volume() <= 0.0 else ConvexPiece.around(mesh_of(solid)[0])


_SLACK = 0.02
"""Dents of blocks with warped faces that are filled, by the size of the block. Measured: with half
of it a dome of 237 warped voussoirs has 764 pieces in place of 432, of which thin ones end up to
8 mm inside a neighbour. Blocks with plane faces are divided exactly."""
_TOLD = 1e-4
"""[m] Blocks that were nearer to touching are cut back without a word. Chosen: the depth at which a
simulator begins to push them apart visibly."""


@dataclass(frozen=True, eq=False)
class SimulatorBody:
    """A block for a simulator. Its frame has its origin at the centroid and the world's axes.

    Attributes
    ----------
    name
        Letters, digits, dots, dashes and underscores.
    fixed
    place : (3,) [m]
        Of its centroid.
    mass : [kg]
    inertia : (3, 3) [kg m2]
        About the centroid.
    pieces
        Per convex piece its corners (p, 3) [m] and its triangles (t, 3), outwards.
    """

    name: str
    fixed: bool
    place: Floats
    mass: float
    inertia: Floats
    pieces: tuple[tuple[Floats, Ints], ...]


def bodies(model: Model) -> tuple[list[SimulatorBody], str]:
    """The blocks of a model, in their order, and a remark on how far they are from rest.

    No piece begins inside one of another block. The remark says how deep they were drawn in each
    other, and how wide the widest gap is that a block crosses first.
    """
    assembly = model.assembly
    names = _plain_names(assembly.names)
    every = [_pieces(block) for block in assembly.blocks]
    owner = np.repeat(np.arange(len(every)), [len(own) for own in every])
    pieces, deepest = set_apart(
        [piece for own in every for piece in own], owner, assembly.fixed[owner]
    )
    out = []
    for i, block in enumerate(assembly.blocks):
        left = [piece for k in np.flatnonzero(owner == i) if (piece := pieces[k]) is not None]
        own = tuple(hull_of(piece.point - block.centroid) for piece in left)
        inertia, fixed = _inertia(block, own), bool(assembly.fixed[i])
        out.append(SimulatorBody(names[i], fixed, block.centroid, block.mass, inertia, own))
    said = []
    if deepest >= _TOLD:
        said.append(f"blocks up to {1e3 * deepest:.2g} mm inside each other are cut back")
    widest = _widest_gap(out, model)
    if widest >= _TOLD:
        said.append(f"blocks with a joint begin up to {1e3 * widest:.2g} mm apart")
    return out, "; ".join(said)


def _widest_gap(found: Sequence[SimulatorBody], model: Model) -> float:
    """The largest of the distances [m] between two blocks that have a joint."""
    solids = [
        manifold3d.Manifold.compose(
            [solid_of(at + one.place, face.tolist()) for at, face in one.pieces]
        )
        for one in found
    ]
    contacts = model.contacts
    pairs = np.unique(np.c_[contacts.block_a, contacts.block_b], axis=0)
    reach = [float(model.assembly.blocks[i].size) for i in range(len(found))]
    gaps = [solids[a].min_gap(solids[b], min(reach[a], reach[b])) for a, b in pairs.tolist()]
    return max(gaps, default=0.0)


def _pieces(block: Block) -> list[ConvexPiece]:
    """Convex pieces of a block, in the world."""
    level = levelled(block.vertices, block.faces)
    if level is not None:
        return [level]
    fan = fan_warped(stack_faces([block.vertices], [block.faces]), PLANE)
    loops = np.split(fan.loop, fan.start[1:-1])
    slack = _SLACK if len(fan.point) > len(block.vertices) else 0.0
    return convex_pieces(fan.point, [tuple(loop) for loop in loops], slack)


def model_of(contents: Contents) -> Model:
    """The model of what is written, its contacts found if there are none."""
    assembly, load = contents.assembly, next(iter(contents.loads), None)
    if contents.contacts is None:
        return Model.of(assembly, load=load, anyway=True)
    made = Model(assembly, contents.contacts)
    return made if load is None else made.with_load(load)


def gravity_of(model: Model) -> Floats:
    """The acceleration (3,) [m/s2] that the load gives to all free blocks.

    Raises
    ------
    InputError
        The load differs from block to block, or has moments.
    """
    free = model.assembly.free
    if not len(free):
        return np.array([0.0, 0.0, -9.81])
    wrench = model.load.wrench[free]
    each = wrench[:, :3] / model.assembly.mass[free][:, None]
    common: Floats = each[0]
    scale = max(float(np.abs(each).max()), 1e-300)
    alike = np.abs(each - common).max() <= SAME * scale
    if not alike or np.abs(wrench[:, 3:]).max() > 1e-9 * np.abs(wrench).max():
        raise InputError(
            f"the load case '{model.load.name}' is not a uniform acceleration",
            where="load",
            remedy="give a load that accelerates all masses equally, or model loads as blocks",
        )
    return common


def _plain_names(names: tuple[str, ...]) -> list[str]:
    """Names that are valid in every format, all different; ``world`` is that of the ground."""
    out: list[str] = ["world"]
    for i, name in enumerate(names):
        plain = re.sub(r"[^A-Za-z0-9._-]", "_", name)
        out.append(plain if plain not in out and plain == name else f"{plain}_{i}")
    return out[1:]


def _inertia(block: Block, pieces: tuple[tuple[Floats, Ints], ...]) -> Floats:
    """(3, 3) [kg m2] about the centroid: tetrahedra from it to the triangles of the pieces."""
    second, volume = np.zeros((3, 3)), 0.0
    for point, triangle in pieces:
        corner = point[triangle]
        six = dot(corner[:, 0], np.cross(corner[:, 1], corner[:, 2]))
        total = corner.sum(axis=1)
        moment = np.einsum("tki,tkj->tij", corner, corner) + np.einsum("ti,tj->tij", total, total)
        second += np.einsum("t,tij->ij", six, moment) / 120.0
        volume += float(six.sum()) / 6.0
    second *= block.mass / volume
    return np.trace(second) * np.eye(3) - second
