"""The parts of faces that no joint covers: where props, struts and centring can touch a block."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely

from drystone.base.arrays import Floats, frozen
from drystone.base.display import OneLine
from drystone.geometry.frames import area_vector, frames_from_normals
from drystone.geometry.planar import inside
from drystone.model import Model

NEAR = 0.01
"""A joint lies on a face when its distance and its angle are below this share (of the size of the
block). Chosen: above the tolerance of the contact search."""


@dataclass(frozen=True, eq=False)
class FreePart(OneLine):
    """A connected part of a face that no joint covers.

    Attributes
    ----------
    block
    share
        Of the face.
    origin : (3,) [m]
        A corner of the face.
    frame : (3, 3)
        Rows n, u, v with n inward.
    shape
        The part in u and v about the origin.
    """

    block: int
    share: float
    origin: Floats
    frame: Floats
    shape: shapely.Polygon

    @property
    def normal(self) -> Floats:
        """(3,) unit, outward."""
        return -self.frame[0]

    @property
    def area(self) -> float:
        """[m2]."""
        return float(self.shape.area)

    @property
    def covered(self) -> bool:
        """Whether joints cover the rest of the face."""
        return self.share < 1.0 - 1e-6

    @property
    def middle(self) -> Floats:
        """A point (3,) [m] of the part: its centroid, or where the part is widest."""
        return self.origin + self.inside @ self.frame[1:]

    @property
    def inside(self) -> Floats:
        """The same in u and v (2,)."""
        return inside(self.shape, np.array(self.shape.centroid.coords[0]))

    @property
    def outline(self) -> Floats:
        """Its outer corners (c, 3) [m], counter-clockwise from outside of the block."""
        ring = np.array(shapely.geometry.polygon.orient(self.shape).exterior.coords)[:-1]
        corners: Floats = self.origin + ring[::-1] @ self.frame[1:]
        return frozen(corners)


def free_parts(model: Model, block: int, away: float = NEAR) -> Iterator[FreePart]:
    """The parts of the faces of a block that no joint covers, the largest of each face first.

    Parameters
    ----------
    model
    block
    away
        Distance that a part keeps from joints, by the size of the block.

    Examples
    --------
    >>> from drystone.models import tower
    >>> model = Model.of(tower(2), friction=0.6)
    >>> sorted(round(float(part.normal[2]), 3) + 0.0 for part in free_parts(model, 1))
    [0.0, 0.0, 0.0, 0.0, 1.0]
    """
    body, contacts = model.assembly.blocks[block], model.contacts
    size = float(model.assembly.size[block])
    own = np.flatnonzero((contacts.block_a == block) | (contacts.block_b == block))
    for loop in body.faces:
        corner = body.vertices[list(loop)]
        area = area_vector(corner)
        whole = float(np.linalg.norm(area))
        frame = frames_from_normals(-area[None] / whole)[0]
        face, covers = shapely.Polygon((corner - corner[0]) @ frame[1:].T), []
        for i in own.tolist():
            joint = contacts.polygon(i) - corner[0]
            flat = abs(float(contacts.frame[i, 0] @ frame[0])) > 1.0 - NEAR
            if len(joint) > 2 and flat and np.abs(joint @ frame[0]).max() < NEAR * size:
                covers.append(shapely.Polygon(joint @ frame[1:].T).buffer(away * size))
        # edges of joints nearly coincide with those of the face: the exact difference of cross
        # vaults and of barrels with joggles fails, or is not valid
        grid = 1e-9 * size
        covered = shapely.union_all(covers, grid_size=grid)
        left = shapely.difference(face, covered, grid_size=grid)
        parts = [part for part in shapely.get_parts(left) if part.area > 0.0]
        for part in sorted(parts, key=lambda one: -one.area):
            yield FreePart(
                block, part.area / whole, frozen(np.array(corner[0])), frozen(frame), part
            )  # fmt: skip
