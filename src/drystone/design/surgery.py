"""Changes of blocks: cut, merge, insert, move a face, thicken; and of joints: turn, move, cut."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drystone.assembly import Block, replace_block
from drystone.base.arrays import SAME, Bools, Floats, dot, frozen_floats, lengths, marked, number
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged, runs_by_length
from drystone.design.changed_model import acceleration_of, changed, fresh_name
from drystone.design.joint_cut import (
    Cell,
    JointPlane,
    JointRecut,
    block_with,
    body_of,
    ends_of,
    joint_plane,
    recut,
    snapped,
)
from drystone.free_faces import NEAR
from drystone.geometry.frames import rotation_about, unit
from drystone.geometry.glue import cut_cell, glue
from drystone.geometry.polyhedron import Piece, stack_faces
from drystone.model import Model

PARALLEL = 0.99
"""Cosine from which on blocks get thicker along one line: 8 degrees. Chosen."""


@dataclass(frozen=True, eq=False)
class Cut(OneLine):
    """A plane, or a wedge of two planes, between a part below and a part above.

    Attributes
    ----------
    point : (3,) [m]
        On the plane; on the edge of the wedge.
    normal : (3,)
        Towards the part above.
    wedge_deg : [degrees]
        Angle of each plane of a wedge to the plane of ``normal``. Positive: the part above sits in
        a groove. Zero for a plane, negative for a ridge.
    edge : (3,)
        Direction of the wedge's edge.
    """

    point: Floats
    normal: Floats
    wedge_deg: float = 0.0
    edge: Floats | None = None

    def planes(self) -> tuple[Floats, Floats]:
        """Normals and points (p, 3) of the half spaces of the part above a plane or a groove."""
        point = frozen_floats(self.point, (3,), "point of a cut")
        normal = unit(self.normal, "normal of a cut")
        if self.wedge_deg == 0.0:
            return normal[None], point[None]
        if not abs(self.wedge_deg) < 60.0:
            raise InputError(f"a wedge of {self.wedge_deg} degrees", remedy="give -60 to 60")
        edge = np.zeros(3) if self.edge is None else np.asarray(self.edge, dtype=np.float64)
        edge = edge - (edge @ normal) * normal
        if np.linalg.norm(edge) < 1e-9:
            raise InputError("a wedge needs an edge across the normal", remedy="give its direction")
        sides = [rotation_about(edge, s * abs(self.wedge_deg)) @ normal for s in (1.0, -1.0)]
        return np.array(sides), np.stack([point, point])


def tilted_cuts(
    point: Floats, normal: Floats, edge: Floats, tilts_deg: Sequence[float]
) -> tuple[Cut, ...]:
    """The cut rotated by several angles about an edge through its point.

    Parameters
    ----------
    point : (3,) [m]
        On the edge.
    normal : (3,)
        Of the cut before it is rotated, of any length.
    edge : (3,)
        Direction of the edge, of any length.
    tilts_deg : (t,) [degrees]
        Angles, counter-clockwise about the edge; one cut for each.
    """
    axis, base = unit(edge, "edge"), unit(normal, "normal")
    return tuple(Cut(point, rotation_about(axis, tilt) @ base, edge=axis) for tilt in tilts_deg)


def split_block(block: Block, cut: Cut) -> tuple[list[Block], list[Block]]:
    """The pieces above and below a cut, as blocks with names derived from the whole.

    Parameters
    ----------
    block
        The whole; it is not changed.
    cut
        Plane or wedge; its normal points to what is above.

    Raises
    ------
    InputError
        The cut misses the block, or only touches it.

    Examples
    --------
    >>> from drystone.models import box
    >>> above, below = split_block(box((1.0, 1.0, 2.0)), Cut((0.5, 0.5, 0.5), (0.0, 0.0, 1.0)))
    >>> [float(piece.volume) for piece in (*above, *below)]
    [1.5, 0.5]
    """
    normals, points = cut.planes()
    ridge = cut.wedge_deg < 0.0  # the groove of the part below, seen upside down
    normals = normals if ridge else -normals
    offsets = (normals * points).sum(axis=1)
    inside, outside = cut_cell([(block.vertices, list(block.faces))], normals, offsets)
    if len(normals) > 1:
        outside = glue(outside)
    above, below = (outside, inside) if ridge else (inside, outside)
    if not above or not below:
        raise InputError(f"the cut misses block '{block.name}'", remedy="move it into the block")
    return _blocks(above, block, "above"), _blocks(below, block, "below")


def _blocks(pieces: Sequence[Piece], whole: Block, side: str) -> list[Block]:
    names = [f"{whole.name}-{side}"]
    if len(pieces) > 1:
        names = [f"{names[0]}-{number}" for number in range(len(pieces))]
    return [
        block_with(whole, piece).renamed(name) for piece, name in zip(pieces, names, strict=True)
    ]


def cut_block(model: Model, block: int | str, point: Floats, normal: Floats) -> Model:
    """The model with a block cut in two by a plane; the part in front becomes a new block.

    Parameters
    ----------
    model
        Is not changed.
    block
        Name or number of the one that is cut.
    point : (3,) [m]
        On the plane.
    normal : (3,)
        Of the plane, of any length: towards the part that becomes a new block.
    """
    i = int(model.assembly.indices([block])[0])
    body = model.assembly.blocks[i]
    front, behind = split_block(body, Cut(point, normal))
    first, *others = [*behind, *front]
    added: list[Block] = []
    for part in others:
        name = fresh_name(model, f"{body.name}-part", [one.name for one in added])
        added.append(part.renamed(name))
    fixed = [bool(model.assembly.fixed[i])] * len(added)
    return changed(model, {i: first.renamed(body.name)}, added=added, fixed=fixed, parts_of=i)


def merge_blocks(model: Model, one: int | str, other: int | str) -> Model:
    """The model with two touching blocks merged into one, as if glued, with the first name.

    Parameters
    ----------
    model
        Is not changed.
    one, other
        Names or numbers. The merged block has the name of the first; it is fixed if one of them is.

    Raises
    ------
    InputError
        They do not touch, or their densities differ.
    """
    i, j = (int(k) for k in model.assembly.indices([one, other]))
    contacts = model.contacts
    ends = np.stack([contacts.block_a, contacts.block_b], axis=1)
    between = np.flatnonzero((np.sort(ends, axis=1) == sorted((i, j))).all(axis=1)).tolist()
    first, second = model.assembly.blocks[i], model.assembly.blocks[j]
    where = f"'{first.name}' and '{second.name}'"
    if not between:
        raise InputError("do not touch", where=where, remedy="merge blocks with a joint")
    if first.density != second.density:
        raise InputError("differ in density", where=where, remedy="give both the same density")
    bodies = [body_of(first), body_of(second)]
    for k in between:
        joint = joint_plane(model, k)
        bodies = [snapped(body, joint) for body in bodies]
    merged = glue(bodies)
    if len(merged) != 1:
        raise InputError("do not touch along a face", where=where, remedy="merge others")
    fixed = bool(model.assembly.fixed[i] or model.assembly.fixed[j])
    made = changed(model, {i: block_with(first, merged[0])}, removed=[j], heirs={j: i})
    if fixed and not model.assembly.fixed[i]:
        at = made.assembly.index(first.name)
        return made.with_supports([*np.flatnonzero(made.assembly.fixed).tolist(), at])
    return made


def move_face(model: Model, block: int | str, face: int, distance: float) -> Model:
    """The model with a face of a block moved outward: thicker or longer, or thinner below zero.

    The sides of the block are prolonged or shortened; its other planes stay.

    Parameters
    ----------
    model
    block
        Its name or number.
    face
        Its number; ``faces_toward`` finds it.
    distance : [m]

    Raises
    ------
    InputError
        A corner of the face is left with no point on all its planes, or a face would be swallowed.
    """
    i = int(model.assembly.indices([block])[0])
    body = model.assembly.blocks[i]
    if not 0 <= face < len(body.faces):
        raise InputError(f"block '{body.name}' has no face {face}", remedy="number them from 0")
    moved = with_moved_faces([body], [{face: number(distance, "the distance")}])
    return changed(model, {i: moved[0]})


def thicken_blocks(
    model: Model, blocks: Sequence[int], share: float, axes: Floats | None = None
) -> Model:
    """The model with blocks thicker by a share of their thickness, thinner below zero.

    The thickness of a block is between the two largest faces that are in no joint and look away
    from each other; each of them is moved by half of it, or the other one by all of it where earth
    or fill presses on one of most of them. What turns and has no two such faces across its axis is
    thicker from the most level free one through the block: that one is moved by all of it, and so
    is the same side of blocks beside it that get thicker along the same line.

    Parameters
    ----------
    model
        Is not changed.
    blocks
        Numbers of the blocks, b of them.
    share
        Of their thickness, such as 0.1 for a tenth more; below zero they become thinner.
    axes : (b, 3)
        Axes about which the blocks turn: their thickness is across these. Left out, none.

    Raises
    ------
    InputError
        A block has no such faces, or one of them cannot be moved.
    """
    about = np.zeros((len(blocks), 3)) if axes is None else axes
    faces, across = thickness_of(model, blocks, about)
    bodies = thickened(model, blocks, share, faces, across)
    return changed(model, dict(zip(blocks, bodies, strict=True)))


def thickened(
    model: Model, blocks: Sequence[int], share: float, faces: Sequence[list[int]], across: Floats
) -> list[Block]:
    """The blocks of :func:`thicken_blocks`; their thickness as of :func:`thickness_of`."""
    bare = [model.assembly.names[i] for i, own in zip(blocks, faces, strict=True) if not own]
    if bare:
        where = f"block '{bare[0]}'"
        raise InputError("has no two free faces", where=where, remedy="choose another")
    steps = (share * lengths(across)).tolist()
    sides = zip(free_sides(model, blocks, faces), steps, strict=True)
    moved = [dict.fromkeys(some, step / len(some)) for some, step in sides]
    return with_moved_faces([model.assembly.blocks[i] for i in blocks], moved)


def thickness_of(
    model: Model, blocks: Sequence[int], axes: Floats
) -> tuple[list[list[int]], Floats]:
    """The faces of each block between which its thickness is, and the way (b, 3) [m] across.

    Two faces, one, or none and a way of zero; ``axes`` (b, 3) as for :func:`thicken_blocks`, zero
    where a block does not turn.
    """
    faces, own = model.assembly.faces, Ragged.from_owners(model.assembly.faces.owner, len(model))
    area, offset = lengths(faces.area_vectors), dot(faces.normals, faces.middles)
    bound, down = in_joints(model), acceleration_of(model)
    found, across = [], []
    for i, axis in zip(blocks, axes, strict=True):
        first, normal = own[i].start, faces.normals[own[i]]
        along = np.abs(normal @ axis) > (np.sqrt(0.5) + SAME) * np.linalg.norm(axis)
        share = np.round(area[own[i]] / area[own[i]].max(), 6)  # of a prism many are the same
        order = np.argsort(-share, kind="stable").tolist()
        free = [k for k in order if not (bound[first + k] or along[k])]
        away = np.triu((normal @ normal.T)[np.ix_(free, free)] < -0.5 - SAME)
        some, way = list[int](), np.zeros(3)
        if away.any():
            some = [free[k] for k in divmod(int(away.argmax()), len(free))]
            behind = float(normal[some[0]] @ faces.middles[first + some[1]])
        elif free and axis.any():
            steep = np.round(np.abs(normal[free] @ down) / (np.linalg.norm(down) or 1.0), 6)
            some = [free[int(steep.argmin())]]
            behind = float((model.assembly.blocks[i].vertices @ normal[some[0]]).min())
        if some:
            way = (offset[first + some[0]] - behind) * normal[some[0]]
        found.append(some)
        across.append(way)
    return found, np.array(across).reshape(-1, 3)


def free_sides(model: Model, blocks: Sequence[int], faces: Sequence[list[int]]) -> list[list[int]]:
    """Of the faces of blocks between which their thickness is those that move, one or two of each.

    ``faces`` are those of :func:`thickness_of`, one at least of each; see :func:`thicken_blocks`.
    """
    surface, sides = model.load.surface, list(faces)
    planes = [face_planes(model.assembly.blocks[i]) for i in blocks]
    if surface is not None:
        for at, (i, (normal, offset)) in enumerate(zip(blocks, planes, strict=True)):
            pressed = surface.lies_on(i, normal, offset, 1e-3 * model.assembly.size[i])
            sides[at] = [k for k in faces[at] if not pressed[k]] or faces[at]
    most = 2 * sum(map(len, faces)) - 2 * sum(map(len, sides)) > len(blocks)
    sides = sides if most else list(faces)
    one = [at for at, some in enumerate(sides) if len(some) == 1]
    place = model.assembly.centroid[list(blocks)]
    for at in set(range(len(blocks))) - set(one) if one else ():
        near = min(one, key=lambda other: float(np.linalg.norm(place[other] - place[at])))
        cosine = planes[at][0][faces[at]] @ planes[near][0][sides[near][0]]
        if most or cosine.max() > PARALLEL:
            sides[at] = [faces[at][int(cosine.argmax())]]
    return sides


def in_joints(model: Model, near: float = NEAR) -> Bools:
    """Whether a joint of its block lies in the plane of each face (f,), by its size as near."""
    contacts, faces = model.contacts, model.assembly.faces
    own, offset = Ragged.from_owners(faces.owner, len(model)), dot(faces.normals, faces.middles)
    part, face = own.take(np.concatenate([contacts.block_a, contacts.block_b]))
    joint = part.owner % contacts.count if contacts.count else part.owner
    alike = np.abs(dot(contacts.frame[joint, 0], faces.normals[face])) > 1.0 - NEAR
    part, corner = contacts.corners.take(joint[alike])
    face, at = face[alike], face[alike][part.owner]
    off = part.max(np.abs(dot(contacts.point[corner], faces.normals[at]) - offset[at]))
    return marked(face[off < near * model.assembly.size[faces.owner[face]]], faces.count)


class CornerError(InputError):
    """More than three faces meet at a corner, and no point is on all of their moved planes."""


def with_moved_faces(
    bodies: Sequence[Block], distances: Sequence[Mapping[int, float]]
) -> list[Block]:
    """Blocks with some faces of each moved outward by distances [m], their other planes as before.

    A corner takes the shortest way that moves it as far along the normal of each of its faces as
    the face moves: warped faces stay as warped as they are.

    Raises
    ------
    CornerError
        A corner is left with no point on all its planes.
    InputError
        A face or an edge would be swallowed.
    """
    faces = stack_faces([one.vertices for one in bodies], [one.faces for one in bodies])
    body = Ragged.from_owners(faces.owner, len(bodies))
    away = np.zeros(faces.count)
    for first, some in zip(body.first.tolist(), distances, strict=True):
        away[[first + k for k in some]] = list(some.values())
    moved = body.max(np.abs(away))[faces.owner]
    meeting = np.unique(np.stack([faces.loop, faces.corners.owner], axis=1), axis=0)
    vertex, face = meeting.T
    vertices = np.array(faces.point)
    for runs, rows in runs_by_length(np.flatnonzero(np.diff(vertex, prepend=-1)), len(face)):
        some = face[rows].reshape(len(runs), -1)
        normal, aim = faces.normals[some], away[some][:, :, None]
        step = np.linalg.pinv(normal, rcond=SAME) @ aim
        vertices[vertex[rows].reshape(some.shape)[:, 0]] += step[:, :, 0]
        wrong = (np.abs(normal @ step - aim)[:, :, 0] > 1e-3 * moved[some]).any(axis=1)
        if wrong.any():
            at = some[int(wrong.argmax())]
            raise CornerError(
                "more than three faces meet at a corner of the face that moves, and no point is "
                "on all of their planes",
                where=_face_words(bodies, body, int(at[away[at] != 0.0][0])),
                remedy="shape the block so that three faces meet there",
            )
    new = np.split(vertices, np.cumsum([len(one.vertices) for one in bodies])[:-1])
    _refuse_swallowed(bodies, body, new)
    return [replace_block(one, vertices=at) for one, at in zip(bodies, new, strict=True)]


def _refuse_swallowed(bodies: Sequence[Block], own: Ragged, new: Sequence[Floats]) -> None:
    """Refuse new vertices with which a face or an edge of a block is gone or turned around."""
    faces = stack_faces(
        [*(one.vertices for one in bodies), *new], [one.faces for one in (*bodies, *bodies)]
    )
    corner = faces.point[faces.loop]
    was, area = faces.area_vectors.reshape(2, -1, 3)
    edge, turned = (corner[faces.corners.following] - corner).reshape(2, -1, 3)
    gone = dot(was, area) <= 0.999 * lengths(was) * lengths(area)
    lost = (dot(edge, turned) <= 0.0) & edge.any(axis=1)
    gone[faces.corners.owner[: len(edge)][lost]] = True
    if gone.any():
        raise InputError(
            "would remove a whole face",
            where=_face_words(bodies, own, int(gone.argmax())),
            remedy="move it less",
        )


def _face_words(bodies: Sequence[Block], own: Ragged, face: int) -> str:
    """A face of one of some blocks as text; they are numbered one block after the other."""
    i = int(own.owner[face])
    return f"block '{bodies[i].name}', face {face - int(own.first[i])}"


def face_planes(block: Block) -> tuple[Floats, Floats]:
    """Unit normals (f, 3) and offsets (f,) [m] of the faces of a block."""
    faces = stack_faces([block.vertices], [block.faces])
    return faces.normals, dot(faces.normals, faces.middles)


def faces_toward(block: Block, direction: Floats) -> list[int]:
    """Faces of a block whose normals are within 45 degrees of a direction, the nearest first.

    Parameters
    ----------
    block
        Whose faces are looked at.
    direction : (3,)
        Of any length.
    """
    cosine = face_planes(block)[0] @ unit(direction)
    return [k for k in np.argsort(-cosine, kind="stable").tolist() if cosine[k] > 0.7]


def insert_block(model: Model, block: Block) -> Model:
    """The model with an additional free block and its contacts.

    Parameters
    ----------
    model
        Is not changed.
    block
        The new one, in its place.

    Raises
    ------
    InputError
        A block has its name already.
    """
    return changed(model, added=(block,), fixed=(False,))


def turn_joint(
    model: Model,
    interface: int,
    angle: float,
    axis: Floats | None = None,
    pivot: float = 0.0,
    first: int | None = None,
) -> Model:
    """The model with a rotated joint; the sum of the two volumes does not change.

    Parameters
    ----------
    model
    interface
        Number of an interface of the joint.
    angle : [degrees] > -80, < 80
        Counter-clockwise about the axis.
    axis : (3,), optional
        Projected into the plane of the joint. When left out, the horizontal line in it.
    pivot
        Line of the joint that does not move: 0 through its middle, -1 and 1 the edges.
    first
        Which of the two blocks is block a; left out, that of the contacts.

    Raises
    ------
    InputError
        The rotation is too large: a face would be removed.

    Examples
    --------
    >>> from drystone.models import tower
    >>> model = Model.of(tower(2), friction=0.6)
    >>> turned = turn_joint(model, 0, 5.0)
    >>> turned.assembly.volume.sum().round(9), turned.contacts.count
    (np.float64(2.0), 1)
    """
    return recut(model, [turn_cut(joint_plane(model, interface, first), angle, axis, pivot)])


def turn_cut(
    joint: JointPlane, angle: float, axis: Floats | None = None, pivot: float = 0.0
) -> JointRecut:
    """The new cut of a joint with :func:`turn_joint`."""
    along, across, low, high = _lines(joint, axis)
    at = joint.centre + (high if pivot > 0.0 else -low) * pivot * across
    normal = rotation_about(along, angle) @ joint.normal
    return _divided(joint, normal[None], at[None], f"a turn by {angle:g} degrees")


def still_edge(model: Model, interface: int, side: float, first: int | None = None) -> float:
    """The pivot of :func:`turn_joint` with which a joint stays one plane.

    The block that ends at the joint only loses volume. With a rotation about the other edge it
    would be let into the other block, with a step.

    Parameters
    ----------
    model
    interface
        Number of an interface of the joint.
    side
        Sign of the angle.
    first
        Which of the two blocks is block a; left out, that of the contacts.
    """
    joint = joint_plane(model, interface, first)
    ends = ends_of(model, joint)
    return float(-np.sign(side) if ends[1] and not ends[0] else np.sign(side))


def move_joint(model: Model, interface: int, distance: float) -> Model:
    """The model with a joint moved along its normal, into block b where ``distance`` [m] > 0.

    If block b extends beyond the joint, block a is let into it.

    Parameters
    ----------
    model
        Is not changed.
    interface
        Number of an interface of the joint.
    distance : [m]
        Into block b where it is above zero, into block a below.
    """
    return recut(model, [move_cut(joint_plane(model, interface), distance)])


def move_cut(joint: JointPlane, distance: float) -> JointRecut:
    """The new cut of a joint with :func:`move_joint`."""
    at = joint.centre + distance * joint.normal
    return _divided(joint, joint.normal[None], at[None], f"a move by {distance:g} m")


def wedge_joint(
    model: Model,
    interface: int,
    sharpness: float,
    axis: Floats | None = None,
    first: int | None = None,
) -> Model:
    """The model with a plane joint replaced by two planes that meet in a ridge.

    Parameters
    ----------
    model
    interface
        Number of an interface of the joint.
    sharpness : [degrees] > -80, < 80
        Angle of each plane with the joint. Above zero, block a is the wedge and block b the groove.
    axis : (3,), optional
        Direction of the ridge, projected into the plane of the joint. When left out, the horizontal
        line in it.
    first
        Which of the two blocks is block a; left out, that of the contacts.

    Notes
    -----
    The ridge and the edges of the joint have the same distance from the old plane, so both blocks
    exchange about equal volumes.
    """
    return recut(model, [wedge_cut(joint_plane(model, interface, first), sharpness, axis)])


def wedge_cut(joint: JointPlane, sharpness: float, axis: Floats | None = None) -> JointRecut:
    """The new cut of a joint with :func:`wedge_joint`."""
    along, across, low, high = _lines(joint, axis)
    half = 0.5 * (high - low)
    middle = joint.centre + 0.5 * (low + high) * across
    ridge = middle + 0.5 * half * np.tan(np.deg2rad(sharpness)) * joint.normal
    normals = np.array([rotation_about(along, s * sharpness) @ joint.normal for s in (-1.0, 1.0)])
    words = f"a wedge of {sharpness:g} degrees"
    return _divided(joint, normals, np.array([ridge, ridge]), words, sharpness > 0.0)


def _divided(
    joint: JointPlane, normals: Floats, points: Floats, words: str, a_convex: bool = True
) -> JointRecut:
    """A cut after which block a is behind all of some planes, or behind any of them."""
    behind = [Cell.below(n[None], p[None]) for n, p in zip(normals, points, strict=True)]
    before = [Cell.below(-n[None], p[None]) for n, p in zip(normals, points, strict=True)]
    if len(behind) > 1:
        some = behind if a_convex else before
        some[:] = [some[0].within(some[1])]
    return JointRecut(joint, tuple(behind), tuple(before), words)


def _lines(joint: JointPlane, axis: Floats | None) -> tuple[Floats, Floats, float, float]:
    """An axis in the plane of a joint, the direction across it, and how far the joint reaches."""
    along = joint.frame[1]
    if axis is not None:
        given = unit(axis, "axis")
        flat = given - (given @ joint.normal) * joint.normal
        if float(np.linalg.norm(flat)) < 1e-6:
            raise InputError("the axis is normal to the joint", remedy="give one that lies in it")
        along = unit(flat, "axis")
    across = np.cross(joint.normal, along)
    return along, across, *joint.reach(across)
