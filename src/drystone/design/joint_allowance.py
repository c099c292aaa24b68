"""Blocks made smaller at their joints, to be fabricated with something between them."""

from __future__ import annotations

import numpy as np
import shapely

from drystone.assembly import Assembly
from drystone.base.arrays import number
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
    planes = [face_plane(body, k) for k in range(len(body.faces))]
    mine = (contacts.block_a == block) | (contacts.block_b == block)
    found = set()
    for i in np.flatnonzero(mine & (contacts.corners.counts > 2)).tolist():
        joint = contacts.polygon(i)
        outward = contacts.frame[i, 0] * (1.0 if contacts.block_a[i] == block else -1.0)
        across = contacts.frame[i, 1:].T
        cover = shapely.Polygon(joint @ across)
        for k, (normal, offset) in enumerate(planes):
            if (
                normal @ outward > 1.0 - NEAR
                and np.abs(joint @ normal - offset).max() < NEAR * body.size
            ):
                face = shapely.Polygon(body.vertices[list(body.faces[k])] @ across)
                common = face.intersection(cover).area
                if common > NEAR * min(face.area, cover.area):
                    found.add(k)
    return [
        k
        for k, ((normal, _), loop) in enumerate(zip(planes, body.faces, strict=True))
        if any(
            normal @ planes[j][0] > 1.0 - EQUAL
            and np.abs(body.vertices[list(loop)] @ planes[j][0] - planes[j][1]).max()
            < EQUAL * body.size
            for j in found
        )
    ]
