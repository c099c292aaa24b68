"""Faces by which a block can be gripped when it is in place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drystone.assembly import Block
from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.sequence.freedom import Joints, face_at

COVERED = 0.01
"""Largest share of a face that joints may cover while it counts as free to grip. Chosen: a
neighbour may touch its edge."""
OPPOSITE = 0.996
"""Cosine between one face and the opposite of another above which a gripper can hold both: 5
degrees, chosen."""


@dataclass(frozen=True, eq=False)
class GripFace(OneLine):
    """A face without contact when the block is in place.

    Attributes
    ----------
    face
        Position in ``block.faces``.
    centre : (3,) [m]
    normal : (3,) unit
        Outward. Both in the frame of the block.
    area : [m2]
    """

    face: int
    centre: Floats
    normal: Floats
    area: float


def grip_faces(body: Block, joints: Joints) -> list[GripFace]:
    """Faces of a block without any of the given joints, the largest first.

    Parameters
    ----------
    body
    joints
        With the blocks that are in place.
    """
    covered = np.zeros(len(body.faces))
    for joint in range(len(joints.other)):
        corner = joints.corner[joints.interface == joint]
        face, _ = face_at(body, corner.mean(axis=0), -joints.normal[joint])
        area = np.cross(corner[1:-1] - corner[0], corner[2:] - corner[0]).sum(axis=0)
        covered[face] += max(0.5 * float(np.linalg.norm(area)), 1e-300)
    found = []
    for face, loop in enumerate(body.faces):
        corner = body.vertices[list(loop)]
        vector = 0.5 * np.cross(corner[1:-1] - corner[0], corner[2:] - corner[0]).sum(axis=0)
        area = float(np.linalg.norm(vector))
        if covered[face] <= COVERED * area and area > 0.0:
            centre = corner.mean(axis=0) - body.centroid
            found.append(GripFace(face, centre, vector / area, area))
    return sorted(found, key=lambda one: -one.area)


def grip_pairs(grips: Sequence[GripFace]) -> list[tuple[int, int, float]]:
    """Pairs of opposite faces, the largest first, and their distance."""
    out = []
    for i, one in enumerate(grips):
        for j in range(i + 1, len(grips)):
            other = grips[j]
            if one.normal @ other.normal < -OPPOSITE:
                width = float((one.centre - other.centre) @ one.normal)
                if width > 0.0:
                    out.append((i, j, width))
    return out
