"""What a search for a path answers: the path on which a block is removed, or what blocks it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.sequence.freedom import Obstacle
from drystone.sequence.sweeps import PLAY, Pose


@dataclass(frozen=True)
class PathOptions(OneLine):
    """Options of the search for paths.

    Attributes
    ----------
    play
        How much the moving block is reduced on all sides, relative to its size.
    turning
        Whether to search paths with rotation if there is no straight path.
    effort
        Largest number of swept volumes that are tested for one block.
    up : (3,)
        The preferred direction of paths.
    """

    play: float = PLAY
    turning: bool = True
    effort: int = 6000
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        if not 0.0 < self.play < 0.1:
            raise InputError(f"the play is {self.play}", remedy="give a share of the block's size")
        if self.effort < 1:
            raise InputError(f"the effort is {self.effort}", remedy="give one or more")
        if not np.linalg.norm(self.up) > 0.0:
            raise InputError("up is zero", remedy="give a direction")


@dataclass(frozen=True, eq=False)
class RemovalPath(OneLine):
    """A path on which a block is removed from its place without collision.

    Attributes
    ----------
    block
        Position of the block.
    poses
        Rigid motions of the block, from its place (the first) to a pose away from all blocks in
        place. Between two poses it moves with a constant twist.
    turning
        Whether it rotates.
    clearance : (p,) [m]
        Distance of the block from the blocks in place at each pose, at most its size.
    """

    block: int
    poses: tuple[Pose, ...]
    turning: bool
    clearance: Floats

    @property
    def matrices(self) -> Floats:
        """(p, 4, 4), homogeneous, from its place outwards."""
        return np.stack([pose.matrix for pose in self.poses])

    @property
    def approach(self) -> Floats:
        """(p, 4, 4), homogeneous, from outside to its place."""
        return self.matrices[::-1]


@dataclass(frozen=True, eq=False)
class NoPath(OneLine):
    """Why a block cannot be removed from its place.

    Attributes
    ----------
    block
        Position of the block.
    reason
        One sentence, with blocks and faces.
    faces
        The blocking faces.
    proved
        Whether the joints alone block every small motion. Otherwise paths begin, and all that were
        tried end at the named faces.
    """

    block: int
    reason: str
    faces: tuple[Obstacle, ...]
    proved: bool
