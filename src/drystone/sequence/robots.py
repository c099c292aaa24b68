"""Robots: base, reach and payload."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Bools, Floats, frozen_floats
from drystone.base.display import rounded_up
from drystone.base.errors import InputError
from drystone.base.settings import Options

FAR = "out of reach"
"""How the reason begins where no robot reaches a block."""


@dataclass(frozen=True)
class Robot(Options):
    """A robot arm that places blocks and may hold one.

    Attributes
    ----------
    name
    base : (3,) [m]
        Position of its first axis.
    reach : [m] > 0
        Farthest distance from the base at which it can hold the centroid of a block.
    payload : [kg] > 0
        Heaviest block that it carries. The holding force is limited to the weight of this mass.
    """

    name: str
    base: tuple[float, float, float] = (0.0, 0.0, 0.0)
    reach: float = float("inf")
    payload: float = float("inf")

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.name:
            raise InputError("a robot needs a name", remedy="give a non-empty string")
        base = frozen_floats(self.base, (3,), f"robot '{self.name}': its base")
        object.__setattr__(self, "base", tuple(base.tolist()))

    def distance(self, points: Floats) -> Floats:
        """[m] (p,) from its base to points (p, 3) [m]."""
        return np.linalg.norm(np.asarray(points) - np.array(self.base), axis=-1)

    def manages(self, centroid: Floats, mass: Floats) -> Bools:
        """Whether it reaches and carries blocks with centroids (n, 3) [m] and masses (n,) [kg]."""
        return (self.distance(centroid) <= self.reach) & (
            np.asarray(mass) <= self.payload * (1.0 + 1e-9)
        )


def check_robots(robots: Sequence[Robot]) -> tuple[Robot, ...]:
    """Robots whose names differ.

    Raises
    ------
    InputError
        Two robots have the same name.
    """
    names = [robot.name for robot in robots]
    if len(set(names)) != len(names):
        raise InputError(
            "two robots have the same name", where="robots", remedy="rename one of them"
        )
    return tuple(robots)


def why_not(
    robots: Sequence[Robot], name: str, centroid: Floats, mass: float, *, turn: bool = False
) -> str:
    """Why no robot can place a block: it is out of reach, or too heavy.

    In ``turn`` there is one, whose turn it is; others may be able to.
    """
    near = [robot for robot in robots if robot.distance(centroid) <= robot.reach]
    if near:
        strong = max(near, key=lambda robot: robot.payload)
        which = "whose turn it is" if turn else "the strongest robot that reaches it"
        return (
            f"too heavy: '{name}' has {rounded_up(mass):g} kg, and '{strong.name}', {which}, "
            f"carries {strong.payload:.4g} kg"
        )
    short = min(robots, key=lambda robot: float(robot.distance(centroid)) - robot.reach)
    missing = rounded_up(float(short.distance(centroid)) - short.reach, 3)
    which = "whose turn it is" if turn else "the robot that comes nearest"
    return (
        f"{FAR}: '{name}' is {missing:g} m too far for '{short.name}', {which}; give it a longer "
        "reach or another base"
    )
