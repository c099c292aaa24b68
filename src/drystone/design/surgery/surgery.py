"""Changes of joints and blocks: turned, moved, wedged, keyed; cut, merged, made thicker."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from drystone.assembly import Block
from drystone.base.arrays import Floats, number
from drystone.base.errors import InputError
from drystone.design.surgery.changed_model import changed, fresh_name
from drystone.design.surgery.joint_cut import (
    Cell,
    JointPlane,
    block_with,
    body_of,
    ends_of,
    joint_plane,
    recut,
    snapped,
)
from drystone.geometry.body.glue import cut_cell, glue
from drystone.geometry.frames import rotation_about, unit
from drystone.geometry.plane.polygon import area_vectors
from drystone.model import Model

STEEPEST = 80.0
"""[degrees] Largest turn of a joint and sharpness of a wedge, chosen: a slender tip is left."""


def turn_joint(
    model: Model,
    interface: int,
    angle: float,
    axis: Floats | None = None,
    pivot: float = 0.0,
    first: int | None = None,
) -> Model:
    """The model with a joint turned in its place: what one block loses the other gains.

    Parameters
    ----------
    model
    interface
    angle : [degrees]
        Counter-clockwise about the axis.
    axis : (3,), optional
        Taken into the plane of the joint. Left out, the horizontal line in it.
    pivot
        Which line of the joint stays: 0 through its middle, -1 and 1 the edges to either side.
    first
        Which of the two blocks is block a; left out, that of the contacts.

    Raises
    ------
    InputError
        The joint cannot be turned so far: a face would be swallowed.

    Examples
    --------
    >>> from drystone.models import tower
    >>> model = Model.of(tower(2), friction=0.6)
    >>> turned = turn_joint(model, 0, 5.0)
    >>> turned.assembly.volume.sum().round(9), turned.contacts.count
    (np.float64(2.0), 1)
    """
    joint = joint_plane(model, interface, first)
    along = _axis(joint, axis)
    if not abs(number(angle, "the angle")) < STEEPEST:
        raise InputError(f"the angle is {angle}", remedy=f"give less than {STEEPEST:g} degrees")
    across = np.cross(joint.normal, along)
    low, high = joint.reach(across)
    at = joint.centre + (high if pivot > 0.0 else -low) * pivot * across
    normal = rotation_about(along, angle) @ joint.normal
    return _with_planes(model, joint, normal[None], at[None], True, f"a turn by {angle:g} degrees")


def still_edge(model: Model, interface: int, side: float, first: int | None = None) -> float:
    """The pivot of :func:`turn_joint` with which a joint stays one plane.

    The block that ends at the joint only loses; turned about the other edge it would be let into
    the other block, with a step beside it.

    Parameters
    ----------
    model, interface
    side
        Sign of the angle.
    first
    """
    joint = joint_plane(model, interface, first)
    ends = ends_of(model, joint)
    return float(-np.sign(side) if ends[1] and not ends[0] else np.sign(side))


def move_joint(model: Model, interface: int, distance: float, first: int | None = None) -> Model:
    """The model with a joint moved along its normal, into block b where ``distance`` [m] > 0.

    Where block b reaches past the joint, block a is let into it.
    """
    joint = joint_plane(model, interface, first)
    at = joint.centre + number(distance, "the distance") * joint.normal
    return _with_planes(
        model, joint, joint.normal[None], at[None], True, f"a move by {distance:g} m"
    )


def wedge_joint(
    model: Model,
    interface: int,
    sharpness: float,
    axis: Floats | None = None,
    first: int | None = None,
) -> Model:
    """The model with a plane joint made a wedge of two planes, which meet in a ridge.

    Parameters
    ----------
    model
    interface
    sharpness : [degrees]
        Angle of each plane with the joint. Above zero, block a is the wedge and block b the groove.
    axis : (3,), optional
        Of the ridge, taken into the plane of the joint. Left out, the horizontal line in it.
    first
        Which of the two blocks is block a; left out, that of the contacts.

    Notes
    -----
    The ridge and the rims of the joint are as far from the old plane, so that about as much goes to
    one block as to the other.
    """
    joint = joint_plane(model, interface, first)
    along = _axis(joint, axis)
    if not abs(number(sharpness, "the sharpness")) < STEEPEST:
        raise InputError(
            f"the sharpness is {sharpness}", remedy=f"give less than {STEEPEST:g} degrees"
        )
    across = np.cross(joint.normal, along)
    low, high = joint.reach(across)
    half = 0.5 * (high - low)
    middle = joint.centre + 0.5 * (low + high) * across
    ridge = middle + 0.5 * half * np.tan(np.deg2rad(sharpness)) * joint.normal
    normals = np.array([rotation_about(along, s * sharpness) @ joint.normal for s in (-1.0, 1.0)])
    what = f"a wedge of {sharpness:g} degrees"
    return _with_planes(model, joint, normals, np.array([ridge, ridge]), sharpness > 0.0, what)


def key_joint(
    model: Model, interface: int, depth: float, share: float = 0.5, axis: Floats | None = None
) -> Model:
    """The model with a key: a strip of the joint at which block a reaches into block b.

    Parameters
    ----------
    model
    interface
    depth : [m]
    share
        Width of the key by that of the joint.
    axis : (3,), optional
        Along which the key runs. Left out, the horizontal line in the joint.
    """
    joint = joint_plane(model, interface)
    along = _axis(joint, axis)
    if not 0.0 < number(share, "the share") < 1.0:
        raise InputError(f"the share is {share}", remedy="give a number between 0 and 1")
    across = np.cross(joint.normal, along)
    low, high = joint.reach(across)
    middle, half = 0.5 * (low + high), 0.5 * share * (high - low)
    sides = [(across, middle + half), (-across, half - middle)]
    return _strip(model, joint, sides, depth, "a key")


def hook_joint(
    model: Model,
    interface: int,
    depth: float,
    undercut: float = 0.0,
    axis: Floats | None = None,
    side: int = 1,
) -> Model:
    """The model with a hook: over half of the joint block a reaches into block b.

    Parameters
    ----------
    model
    interface
    depth : [m]
    undercut : [degrees]
        By which the face in the middle leans over block b: the hook then holds a pull.
    axis : (3,), optional
        Along which the hook runs. Left out, the horizontal line in the joint.
    side
        1 or -1, the half that reaches over.
    """
    joint = joint_plane(model, interface)
    along = _axis(joint, axis)
    across = np.sign(side) * np.cross(joint.normal, along)
    low, high = joint.reach(across)
    lean = np.tan(np.deg2rad(number(undercut, "the undercut")))
    normal = -across - lean * joint.normal
    return _strip(model, joint, [(normal, -0.5 * (low + high))], depth, "a hook")


def _strip(
    model: Model,
    joint: JointPlane,
    sides: list[tuple[Floats, float]],
    depth: float,
    what: str,
) -> Model:
    """Block a given what of block b is within planes about the centre, down to a depth."""
    if not number(depth, "the depth") > 0.0:
        raise InputError(f"the depth is {depth}", remedy="give metres above zero")
    planes = [*sides, (joint.normal, depth)]
    normals = np.array([normal for normal, _ in planes])
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    at = np.array([offset for _, offset in planes])[:, None] * normals / size**2
    cell = Cell.below(normals, joint.centre + at)
    return recut(model, joint, [cell], [], what)


def _with_planes(
    model: Model, joint: JointPlane, normals: Floats, points: Floats, a_convex: bool, what: str
) -> Model:
    """The joint cut by planes: block a is behind all of them, or behind any."""
    behind = [Cell.below(n[None], p[None]) for n, p in zip(normals, points, strict=True)]
    before = [Cell.below(-n[None], p[None]) for n, p in zip(normals, points, strict=True)]
    if len(behind) == 1:
        return recut(model, joint, behind, before, what)
    if a_convex:
        both = behind[0].within(behind[1])
        return recut(model, joint, [both], [before[0], before[1]], what)
    both = before[0].within(before[1])
    return recut(model, joint, [behind[0], behind[1]], [both], what)


def _axis(joint: JointPlane, axis: Floats | None) -> Floats:
    """A unit vector (3,) in the plane of a joint."""
    if axis is None:
        along: Floats = joint.frame[1]
        return along
    given = unit(axis, "axis")
    flat = given - (given @ joint.normal) * joint.normal
    if float(np.linalg.norm(flat)) < 1e-6:
        raise InputError("the axis is normal to the joint", remedy="give one that lies in it")
    return unit(flat, "axis")


def cut_block(model: Model, block: int | str, point: Floats, normal: Floats) -> Model:
    """The model with a block cut in two by a plane; the part in front becomes a new block."""
    i = int(model.assembly.indices([block])[0])
    body = model.assembly.blocks[i]
    along = unit(normal, "normal")
    offset = np.array([float(along @ np.asarray(point, dtype=np.float64))])
    behind, front = cut_cell([body_of(body)], along[None], offset)
    if not behind or not front:
        raise InputError(
            f"the plane does not pass through block '{body.name}'", remedy="move the plane"
        )
    parts = [*behind, *front]
    blocks = [block_with(body, part) for part in parts]
    added: list[Block] = []
    for part in blocks[1:]:
        name = fresh_name(model, f"{body.name}-part", [one.name for one in added])
        added.append(part.renamed(name))
    fixed = [bool(model.assembly.fixed[i])] * len(added)
    return changed(model, {i: blocks[0]}, added=added, fixed=fixed)


def merge_blocks(model: Model, one: int | str, other: int | str) -> Model:
    """The model with two blocks that touch made one, as if glued; it has the first name.

    Raises
    ------
    InputError
        They do not touch, or their densities differ.
    """
    i, j = (int(k) for k in model.assembly.indices([one, other]))
    contacts = model.contacts
    pair = {i, j}
    between = [
        k
        for k in range(contacts.count)
        if {int(contacts.block_a[k]), int(contacts.block_b[k])} == pair
    ]
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
    made = changed(model, {i: block_with(first, merged[0])}, removed=[j])
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
    face
        Its number; ``faces_toward`` finds it.
    distance : [m]

    Raises
    ------
    InputError
        More than three faces meet at a corner of the face, or a face would be swallowed.
    """
    i = int(model.assembly.indices([block])[0])
    body = model.assembly.blocks[i]
    if not 0 <= face < len(body.faces):
        raise InputError(f"block '{body.name}' has no face {face}", remedy="number them from 0")
    return changed(model, {i: _with_moved(body, {face: number(distance, "the distance")})})


def thicken_blocks(model: Model, blocks: Sequence[int], share: float) -> Model:
    """The model with blocks thicker by a share of their thickness, thinner below zero.

    The thickness of a block is between the two largest faces that are in no joint and look away
    from each other; each of them is moved by half of it.

    Raises
    ------
    InputError
        A block has no such faces, or one of them cannot be moved.
    """
    new = {}
    for i in blocks:
        body = model.assembly.blocks[i]
        planes = [_plane(body, k) for k in range(len(body.faces))]
        free = [k for k in _by_area(body) if not _in_joint(model, i, *planes[k])]
        pairs = [
            (one, two)
            for number_, one in enumerate(free)
            for two in free[number_ + 1 :]
            if planes[one][0] @ planes[two][0] < -0.5
        ]
        if not pairs:
            raise InputError(
                "has no two free faces", where=f"block '{body.name}'", remedy="choose another"
            )
        one, two = pairs[0]
        middle = body.vertices[list(body.faces[two])].mean(axis=0)
        thickness = planes[one][1] - float(planes[one][0] @ middle)
        new[i] = _with_moved(body, dict.fromkeys((one, two), 0.5 * share * thickness))
    return changed(model, new)


def _by_area(block: Block) -> list[int]:
    """The faces of a block, the largest first."""
    size = []
    for loop in block.faces:
        corner = block.vertices[list(loop)]
        size.append(float(np.linalg.norm(area_vectors(corner, np.array([0, len(corner)]))[0])))
    return sorted(range(len(size)), key=lambda k: -size[k])


def _in_joint(model: Model, block: int, normal: Floats, offset: float) -> bool:
    """Whether a joint of a block lies in a plane."""
    contacts = model.contacts
    near = 0.01 * model.assembly.size[block]
    return any(
        abs(contacts.frame[k, 0] @ normal) > 0.99
        and np.abs(contacts.polygon(int(k)) @ normal - offset).max() < near
        for k in np.flatnonzero((contacts.block_a == block) | (contacts.block_b == block))
    )


def _with_moved(body: Block, distances: Mapping[int, float]) -> Block:
    """A block with some faces moved outward by distances [m], its other planes where they are."""
    plane = [_plane(body, k) for k in range(len(body.faces))]
    for face, distance in distances.items():
        plane[face] = (plane[face][0], plane[face][1] + distance)
    vertices = np.array(body.vertices)
    where = f"block '{body.name}'"
    for v in sorted({v for face in distances for v in body.faces[face]}):
        meeting = [k for k, loop in enumerate(body.faces) if v in loop]
        if len(meeting) != 3:
            raise InputError(
                "more than three faces meet at a corner of the face that moves",
                where=where,
                remedy="choose another face",
            )
        vertices[v] = np.linalg.solve(
            np.array([plane[k][0] for k in meeting]), np.array([plane[k][1] for k in meeting])
        )
    for loop in body.faces:
        some, start = list(loop), np.array([0, len(loop)])
        before = area_vectors(body.vertices[some], start)[0]
        after = area_vectors(vertices[some], start)[0]
        sizes = float(np.linalg.norm(before) * np.linalg.norm(after))
        if before @ after < 0.999 * sizes or sizes == 0.0:
            raise InputError("would swallow a face", where=where, remedy="move it less")
    return Block(vertices, body.faces, body.name, body.density, body.metadata)


def _plane(block: Block, face: int) -> tuple[Floats, float]:
    """Unit normal and offset of a face."""
    corner = block.vertices[list(block.faces[face])]
    area = area_vectors(corner, np.array([0, len(corner)]))[0]
    normal = area / np.linalg.norm(area)
    return normal, float(normal @ corner.mean(axis=0))


def faces_toward(block: Block, direction: Floats) -> list[int]:
    """Faces of a block whose normals are within 45 degrees of a direction, the nearest first."""
    along = unit(direction)
    cosine = [float(_plane(block, k)[0] @ along) for k in range(len(block.faces))]
    order = sorted(range(len(cosine)), key=lambda k: -cosine[k])
    return [k for k in order if cosine[k] > 0.7]


def insert_block(model: Model, block: Block, *, fixed: bool = False) -> Model:
    """The model with a block more; its contacts are found.

    Raises
    ------
    InputError
        A block has its name already.
    """
    return changed(model, added=(block,), fixed=(fixed,))


__all__ = [
    "cut_block",
    "faces_toward",
    "hook_joint",
    "insert_block",
    "key_joint",
    "merge_blocks",
    "move_face",
    "move_joint",
    "still_edge",
    "thicken_blocks",
    "turn_joint",
    "wedge_joint",
]
