"""Changes of joints: rotation, translation, and cuts as a wedge, a key or a hook."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.design.joint_cut import Cell, JointPlane, JointRecut, ends_of, joint_plane, recut
from drystone.geometry.frames import rotation_about, unit
from drystone.model import Model


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
    along = _axis(joint, axis)
    across = np.cross(joint.normal, along)
    low, high = joint.reach(across)
    at = joint.centre + (high if pivot > 0.0 else -low) * pivot * across
    normal = rotation_about(along, angle) @ joint.normal
    return _divided(joint, normal[None], at[None], f"a turn by {angle:g} degrees")


def still_edge(model: Model, interface: int, side: float, first: int | None = None) -> float:
    """The pivot of :func:`turn_joint` with which a joint stays one plane.

    The block that ends at the joint only loses volume. With a rotation about the other edge it
    would be let into the other block, with a step.

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

    If block b extends beyond the joint, block a is let into it.
    """
    return recut(model, [move_cut(joint_plane(model, interface, first), distance)])


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
    along = _axis(joint, axis)
    across = np.cross(joint.normal, along)
    low, high = joint.reach(across)
    half = 0.5 * (high - low)
    middle = joint.centre + 0.5 * (low + high) * across
    ridge = middle + 0.5 * half * np.tan(np.deg2rad(sharpness)) * joint.normal
    normals = np.array([rotation_about(along, s * sharpness) @ joint.normal for s in (-1.0, 1.0)])
    words = f"a wedge of {sharpness:g} degrees"
    return _divided(joint, normals, np.array([ridge, ridge]), words, sharpness > 0.0)


def key_joint(
    model: Model, interface: int, depth: float, share: float = 0.5, axis: Floats | None = None
) -> Model:
    """The model with a key: in a strip of the joint block a extends into block b.

    Parameters
    ----------
    model
    interface
    depth : [m] > 0
    share : > 0, < 1
        Width of the key by that of the joint.
    axis : (3,), optional
        Along which the key runs. Left out, the horizontal line in the joint.
    """
    joint = joint_plane(model, interface)
    along = _axis(joint, axis)
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
    """The model with a hook: in half of the joint block a extends into block b.

    Parameters
    ----------
    model
    interface
    depth : [m] > 0
    undercut : [degrees]
        Inclination of the face in the middle over block b: the hook then carries tension.
    axis : (3,), optional
        Along which the hook runs. Left out, the horizontal line in the joint.
    side
        1 or -1, the half that reaches over.
    """
    joint = joint_plane(model, interface)
    along = _axis(joint, axis)
    across = np.sign(side) * np.cross(joint.normal, along)
    low, high = joint.reach(across)
    lean = np.tan(np.deg2rad(undercut))
    normal = -across - lean * joint.normal
    return _strip(model, joint, [(normal, -0.5 * (low + high))], depth, "a hook")


def _strip(
    model: Model,
    joint: JointPlane,
    sides: list[tuple[Floats, float]],
    depth: float,
    what: str,
) -> Model:
    """The part of block b within planes about the centre, to a depth, given to block a."""
    planes = [*sides, (joint.normal, depth)]
    normals = np.array([normal for normal, _ in planes])
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    at = np.array([offset for _, offset in planes])[:, None] * normals / size**2
    cell = Cell.below(normals, joint.centre + at)
    return recut(model, [JointRecut(joint, (cell,), (), what)])


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


def _axis(joint: JointPlane, axis: Floats | None) -> Floats:
    """A unit vector (3,) in the plane of a joint."""
    if axis is None:
        return joint.frame[1]
    given = unit(axis, "axis")
    flat = given - (given @ joint.normal) * joint.normal
    if float(np.linalg.norm(flat)) < 1e-6:
        raise InputError("the axis is normal to the joint", remedy="give one that lies in it")
    return unit(flat, "axis")
