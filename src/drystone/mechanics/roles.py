"""Which block of a joint is the one whose face the corners slide over.

The corners of a joint lie on the face of one block, and the gap is that of the face of the other.
As long as the faces are parallel it is the same which is which; once one block has turned, the two
choices differ by a small share of the way. So the choice goes by the geometry, not by the numbers
of the blocks, and a path does not depend on the numbering.
"""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import ROUNDING, SAME, Bools, Floats
from drystone.mechanics.corners import Ends, distance_from_supports
from drystone.model import Model


def turned_joints(model: Model) -> Bools:
    """(m,) whether the corners of an interface slide over the face of b, not over that of a.

    They slide over the block with fewer joints to a support; of two with the same number over the
    larger one, then over the lower one along the load, then over the one nearer to the centroid of
    the model. Only blocks that are alike in all of this go by their numbers.
    """
    assembly, contacts = model.assembly, model.contacts
    a, b = contacts.block_a, contacts.block_b
    away = distance_from_supports(assembly, contacts)
    size = np.cbrt(assembly.volume)
    least = SAME * np.minimum(size[a], size[b])
    loads = model.load.wrench[assembly.free, :3]
    load = loads.sum(axis=0)
    strength = float(np.linalg.norm(load))
    some = strength > ROUNDING * float(np.linalg.norm(loads, axis=1).sum())
    down = load / strength if some else np.zeros(3)
    middle = assembly.volume @ assembly.centroid / assembly.volume.sum()
    from_middle = assembly.centroid - middle
    turned = np.zeros(len(a), dtype=bool)
    decided = np.zeros(len(a), dtype=bool)
    ranks: tuple[tuple[Floats, Floats | float], ...] = (
        (-away.astype(np.float64), 0.0),
        (size, least),
        (from_middle @ down, least),
        (-np.linalg.norm(from_middle, axis=1), least),
    )
    for rank, margin in ranks:
        more = rank[b] - rank[a]
        turned |= ~decided & (more > margin)
        decided |= np.abs(more) > margin
    return turned


def as_turned(ends: Ends, turned: Bools) -> Ends:
    """The ends of joints, where a and b change their roles at some corners (k,).

    The normal n and the axis v change their signs, u does not. What moved with b moves with a, and
    the corners go round the other way.
    """
    mirror = np.array([1.0, -1.0])
    before = np.argsort(ends.after)
    here = turned[:, None]
    # the edge that follows becomes the one before
    outward, tangent = ends.outward[:, ::-1] * mirror, np.eye(2) - ends.tangent
    return Ends(
        outward=np.where(here[:, :, None], outward, ends.outward),
        share=np.where(here, 1.0 - ends.share[:, ::-1], ends.share),
        tangent=np.where(here[:, :, None], mirror[:, None] * tangent * mirror, ends.tangent),
        sense=np.where(here, -ends.sense[:, ::-1], ends.sense),
        reach=np.where(here, ends.reach[:, ::-1], ends.reach),
        joint=ends.joint,
        after=np.where(turned, before, ends.after),
        place=np.where(here, ends.place * mirror, ends.place),
        drawn=np.where(here, ends.drawn[:, ::-1], ends.drawn),
    )
