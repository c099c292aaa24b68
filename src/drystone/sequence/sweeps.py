"""Collisions of a moving block: swept volumes of its convex pieces against the solids in place.

Between two poses a piece stays inside the convex hull of its two positions, except for the sagitta
of a rotation; steps are so small that the sagitta is below a quarter of the play. The hull is
tested against the solids, so thin obstacles are not missed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import manifold3d
import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.geometry.convex_pieces import convex_pieces, solid_of

PLAY = 1e-3
"""Default play: how much a moving block is reduced on all sides, relative to its size. It allows
sliding along joints. Chosen: above the rounding of files and of convex pieces."""


@dataclass(frozen=True, eq=False)
class Pose(OneLine):
    """A rigid motion: a point x of the block in its place moves to ``turn @ x + shift``.

    Attributes
    ----------
    turn : (3, 3)
    shift : (3,) [m]
    """

    turn: Floats
    shift: Floats

    def of(self, points: Floats) -> Floats:
        """Points (p, 3) [m] moved."""
        return points @ self.turn.T + self.shift

    def then(self, later: Pose) -> Pose:
        """The motion followed by another one."""
        return Pose(later.turn @ self.turn, later.turn @ self.shift + later.shift)

    @property
    def matrix(self) -> Floats:
        """(4, 4), homogeneous."""
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = self.turn, self.shift
        return out


HERE = Pose(np.eye(3), np.zeros(3))
"""The pose of the block in its place."""


def moved_along(twist: Floats, centre: Floats, amount: float) -> Pose:
    """The motion of a constant twist about a point.

    Parameters
    ----------
    twist : (6,)
        Velocity [m / s] of the point, and angular velocity [rad / s].
    centre : (3,) [m]
    amount : [s]
    """
    velocity, spin = twist[:3] * amount, twist[3:] * amount
    angle = float(np.linalg.norm(spin))
    if angle < 1e-12:
        return Pose(np.eye(3), velocity)
    x, y, z = spin / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    square = cross @ cross
    turn = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * square
    along = (
        np.eye(3) + (1.0 - np.cos(angle)) / angle * cross + (1.0 - np.sin(angle) / angle) * square
    )
    return Pose(turn, centre - turn @ centre + along @ velocity)


class Solids:
    """The blocks of an assembly as solids, each made when it is first needed."""

    def __init__(self, assembly: Assembly) -> None:
        self.assembly = assembly
        self.low = np.array([block.bounds[0] for block in assembly.blocks])
        self.high = np.array([block.bounds[1] for block in assembly.blocks])
        self._solid: dict[int, manifold3d.Manifold] = {}

    def __getitem__(self, block: int) -> manifold3d.Manifold:
        if block not in self._solid:
            one = self.assembly.blocks[block]
            self._solid[block] = solid_of(one.vertices, one.faces)
        return self._solid[block]


class Mover:
    """A moving block: its convex pieces, reduced by the play.

    Parameters
    ----------
    block
    play : [m]
        Distance by which every face is moved inwards.
    """

    def __init__(self, block: Block, play: float) -> None:
        self.block = block
        pieces = [one.inset(play) for one in convex_pieces(block.vertices, block.faces)]
        self.pieces = [points for points in pieces if points is not None]

    @cached_property
    def reach(self) -> float:
        """[m], distance of the farthest corner from the centroid."""
        return float(np.linalg.norm(self.block.vertices - self.block.centroid, axis=1).max())


@dataclass(frozen=True, eq=False)
class Hit:
    """A collision at the end of a path.

    Attributes
    ----------
    block
        The block that is hit.
    point : (3,) [m]
        Middle of the volume that the swept volume shares with it.
    """

    block: int
    point: Floats


class Surroundings:
    """The blocks in place, tested for collision with a moving block.

    Attributes
    ----------
    sweeps
        Swept volumes that were tested.
    """

    def __init__(self, solids: Solids, blocks: Sequence[int]) -> None:
        self.solids = solids
        self.blocks = np.array(blocks, dtype=np.intp)
        self.low, self.high = solids.low[self.blocks], solids.high[self.blocks]
        self.sweeps = 0

    def hit(self, mover: Mover, first: Pose, second: Pose) -> Hit | None:
        """The collision of a block between two poses; None if there is none."""
        for piece in mover.pieces:
            ends = np.concatenate([first.of(piece), second.of(piece)])
            self.sweeps += 1
            near = self._near(ends)
            if not len(near):
                continue
            swept = manifold3d.Manifold.hull_points(ends)
            for block in near.tolist():
                common = swept ^ self.solids[block]
                if not common.is_empty():
                    low_high = np.array(common.bounding_box()).reshape(2, 3)
                    return Hit(block, low_high.mean(axis=0))
        return None

    def _near(self, points: Floats) -> Floats:
        low, high = points.min(axis=0), points.max(axis=0)
        return self.blocks[((self.low < high) & (self.high > low)).all(axis=1)]

    def gap(self, mover: Mover, pose: Pose, farthest: float) -> float:
        """Distance [m] of the full block from the blocks in place, at most ``farthest``."""
        points = pose.of(mover.block.vertices)
        low, high = points.min(axis=0) - farthest, points.max(axis=0) + farthest
        near = self.blocks[((self.low < high) & (self.high > low)).all(axis=1)]
        if not len(near):
            return farthest
        solid = solid_of(points, mover.block.faces)
        return min(float(solid.min_gap(self.solids[b], farthest)) for b in near.tolist())

    @cached_property
    def extent(self) -> tuple[Floats, float]:
        """Middle (3,) and radius [m] of a ball around all of them."""
        if not len(self.blocks):
            return np.zeros(3), 0.0
        low, high = self.low.min(axis=0), self.high.max(axis=0)
        return 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
