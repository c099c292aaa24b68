"""Load cases: one wrench per block. Nothing is implicit, gravity included."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.errors import InputError
from drystone.geometry.arrays import Floats, frozen_floats
from drystone.geometry.frames import rotation_about, unit

STANDARD_GRAVITY = 9.81
"""[m/s2]"""
DOWN = (0.0, 0.0, -1.0)


@dataclass(frozen=True, eq=False)
class LoadCase:
    """Wrenches on blocks.

    Parameters
    ----------
    wrench : (n, 6) [N, N m]
        Force and moment about each block's centroid, world axes. Loads on fixed blocks are carried
        by the ground and change nothing.
    name
        For tables.

    Examples
    --------
    >>> from drystone.models import tower
    >>> assembly = tower(2)
    >>> load = LoadCase.gravity(assembly) + 0.5 * LoadCase.point_load(
    ...     assembly, "block-1", force=(100.0, 0.0, 0.0))
    >>> load.wrench[1].round(1).tolist()
    [50.0, 0.0, -23544.0, 0.0, 0.0, 0.0]
    """

    wrench: Floats
    name: str = "load"

    def __post_init__(self) -> None:
        object.__setattr__(self, "wrench", frozen_floats(self.wrench, (None, 6), "wrench"))

    @classmethod
    def gravity(
        cls, assembly: Assembly, g: float = STANDARD_GRAVITY, direction: Any = DOWN
    ) -> LoadCase:
        """Self-weight.

        Parameters
        ----------
        assembly
        g : [m/s2]
        direction : (3,)
            Any length; gravity acts along it.
        """
        wrench = np.zeros((len(assembly), 6))
        wrench[:, :3] = assembly.mass[:, None] * (float(g) * unit(direction, "gravity direction"))
        return cls(wrench, "gravity")

    @classmethod
    def tilt(
        cls, assembly: Assembly, axis: Any, angle_deg: float, g: float = STANDARD_GRAVITY
    ) -> LoadCase:
        """Self-weight when the whole assembly is turned counter-clockwise about ``axis``.

        The blocks stay where they are and gravity turns the other way, which is the same.

        Parameters
        ----------
        assembly
        axis : (3,)
        angle_deg : [degrees]
        g : [m/s2]
        """
        direction = rotation_about(axis, angle_deg).T @ np.array(DOWN)
        return cls(cls.gravity(assembly, g, direction).wrench, f"tilt {angle_deg:g} deg")

    @classmethod
    def point_load(
        cls, assembly: Assembly, block: int | str, force: Any, at: Any = None
    ) -> LoadCase:
        """A force [N] (3,) on a block, at a point [m] (3,) or, left out, at its centroid."""
        i = int(assembly.indices([block])[0])
        vector = frozen_floats(force, (3,), "force")
        wrench = np.zeros((len(assembly), 6))
        wrench[i, :3] = vector
        if at is not None:
            arm = frozen_floats(at, (3,), "at") - assembly.centroid[i]
            wrench[i, 3:] = np.cross(arm, vector)
        return cls(wrench, "point load")

    def __add__(self, other: LoadCase) -> LoadCase:
        if self.wrench.shape != other.wrench.shape:
            raise InputError("load cases of different assemblies cannot be added")
        return LoadCase(self.wrench + other.wrench, f"{self.name} + {other.name}")

    def __mul__(self, factor: float) -> LoadCase:
        return LoadCase(self.wrench * float(factor), f"{float(factor):g} {self.name}")

    __rmul__ = __mul__
