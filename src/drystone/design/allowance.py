"""Blocks made smaller at their joints, to be fabricated with something between them."""

from __future__ import annotations

import numpy as np
import shapely

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, number
from drystone.base.errors import InputError
from drystone.design.block_surgery import face_plane, with_moved_faces
from drystone.design.changed_model import EQUAL
from drystone.free_faces import NEAR
from drystone.geometry.selfcontact import self_contacts
from drystone.model import Model


def joint_allowance(model: Model, allowance: float) -> Assembly:
    """The blocks to fabricate: each face in a joint is moved inward by half the allowance.

    So each joint of faces is open by the allowance along its normal; a support gives its half like
    any block. Faces of a block in one plane move together, others stay in their planes. Where
    blocks touch along an edge or at a corner only, nothing moves. Gaps that are drawn stay and are
    added. Analyses are of the model as it is, without the allowance.

    Parameters
    ----------
    model
    allowance : [m]
        At the scale of the model: the thickness of what lies in each joint.

    Raises
    ------
    InputError
        The allowance is not above zero, or so large that a face or an edge would be swallowed or a
        block would cross itself; no faces touch; or a corner is left with no point on its planes.

    Examples
    --------
    >>> from drystone.models import tower
    >>> made = joint_allowance(Model.of(tower(3), friction=0.6), 0.01)
    >>> [round(float(high - low), 6) for low, high in made.bounds[:, :, 2]]
    [0.995, 0.99, 0.995]

    Notes
    -----
    Source: Kao 2023, section 7.2.4: sandpaper of 0.58 mm between printed blocks.
    """
    if not number(allowance, "the joint allowance") > 0.0:
        raise InputError(f"the joint allowance is {allowance} m", remedy="give one above zero")
    assembly = model.assembly
    blocks = list(assembly.blocks)
    for i, body in enumerate(blocks):
        joined = _joined_faces(model, i)
        if joined:
            blocks[i] = with_moved_faces(body, dict.fromkeys(joined, -0.5 * allowance))
    moved = [i for i, body in enumerate(blocks) if body is not assembly.blocks[i]]
    if not moved:
        raise InputError("no faces touch", remedy="give a model with joints of faces")
    for one, what in self_contacts(
        [blocks[i].vertices for i in moved], [blocks[i].faces for i in moved]
    ):
        raise InputError(
            f"with the joint allowance it {what}",
            where=f"block '{blocks[moved[one]].name}'",
            remedy="give a smaller one",
        )
    return Assembly(tuple(blocks), assembly.fixed)


def _joined_faces(model: Model, block: int) -> list[int]:
    """The faces of a block on which a joint lies, and those in one plane with them."""
    body, contacts = model.assembly.blocks[block], model.contacts
    mine = (contacts.block_a == block) | (contacts.block_b == block)
    found = set()
    for i in np.flatnonzero(mine & (contacts.corners.counts > 2)).tolist():
        outward = contacts.frame[i] * (1.0 if contacts.block_a[i] == block else -1.0)
        joint = contacts.polygon(i)
        found |= {k for k in range(len(body.faces)) if _lies_on(joint, outward, body, k)}
    planes = [face_plane(body, k) for k in sorted(found)]
    return [
        k
        for k, loop in enumerate(body.faces)
        if any(
            face_plane(body, k)[0] @ normal > 1.0 - EQUAL
            and np.abs(body.vertices[list(loop)] @ normal - offset).max() < EQUAL * body.size
            for normal, offset in planes
        )
    ]


def _lies_on(joint: Floats, outward: Floats, body: Block, face: int) -> bool:
    """Whether a joint (c, 3), with rows n, u, v and n out of the block, lies on a face."""
    normal, offset = face_plane(body, face)
    if normal @ outward[0] < 1.0 - NEAR or np.abs(joint @ normal - offset).max() > NEAR * body.size:
        return False
    cover, whole = (
        shapely.Polygon(corner @ outward[1:].T)
        for corner in (joint, body.vertices[list(body.faces[face])])
    )
    return bool(cover.intersection(whole).area > NEAR * min(cover.area, whole.area))
