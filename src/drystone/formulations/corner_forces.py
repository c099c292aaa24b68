"""Corner forces as unknowns of a convex program: equilibrium, no pull, and friction as rows."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import sparse

from drystone.arrays import Floats
from drystone.errors import InputError
from drystone.settings import Options
from drystone.solvers.conic import Cones
from drystone.statics import Statics

SLIPPERY = 0.01
"""Below this friction coefficient the exact cone does not say precisely enough that a corner cannot
pull, at zero it does not say so at all; chosen, so that a tolerance on the cone is no larger than a
hundred times itself on the pull."""


class FrictionRule(enum.Enum):
    """Which normal force carries friction where tension is allowed."""

    PLUS = "friction+"
    """Compression only: always feasible."""
    NET = "friction-net"
    """Compression less tension: may be infeasible."""


@dataclass(frozen=True)
class FrictionCone(Options):
    """The set of admissible corner forces.

    Attributes
    ----------
    sides
        0 for the exact cone, else the number of sides of a pyramid.
    circumscribed
        Pyramid around the cone (claims of impossibility) or inside it (claims of equilibrium).
    local
        Coefficient at single corners, where that of the interface bounds the resultant of the whole
        interface only: a corner may then use more friction than its own pressure allows, on account
        of its neighbours. ``None``: every corner obeys the coefficient of the interface.

    Notes
    -----
    ``FrictionCone.octagon()`` is the eight-sided circumscribed pyramid of the source: it grants up
    to 1 / cos(22.5 deg) - 1 = 8.2 % more friction than the coefficient says.
    """

    sides: int = 0
    circumscribed: bool = True
    local: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.sides != 0 and self.sides < 3:
            raise InputError(f"a friction pyramid has {self.sides} sides", remedy="0 or 3 and more")
        if self.local is not None and not 0.0 <= self.local < float("inf"):
            raise InputError(f"local friction is {self.local}", remedy="give zero or more")

    @classmethod
    def exact(cls) -> FrictionCone:
        """The Coulomb cone itself."""
        return cls(0)

    @classmethod
    def octagon(cls) -> FrictionCone:
        """Eight sides, circumscribed: for reproducing published figures."""
        return cls(8, circumscribed=True)

    def directions(self) -> tuple[Floats, float]:
        """Unit outward normals (s, 2) of the pyramid's sides, and their distance from the axis."""
        angle = 2.0 * np.pi * np.arange(self.sides) / self.sides
        reach = 1.0 if self.circumscribed else float(np.cos(np.pi / self.sides))
        return np.stack([np.cos(angle), np.sin(angle)], axis=1), reach


@dataclass(frozen=True)
class Columns:
    """Unknowns of one corner: pressing, pulling if allowed, slide along u and v, price of slide.

    Attributes
    ----------
    tension
        Whether there is a pull.
    rule
    priced
        Whether there is a bound on the length of the friction force, to put a price on.
    """

    tension: bool = False
    rule: FrictionRule = FrictionRule.PLUS
    priced: bool = False

    @property
    def width(self) -> int:
        """Number of unknowns per corner."""
        return 3 + self.tension + self.priced

    @property
    def slide(self) -> list[int]:
        """Columns of the friction force."""
        first = 1 + self.tension
        return [first, first + 1]

    @property
    def net(self) -> Floats:
        """(3, width): the corner force n, u, v."""
        out = np.zeros((3, self.width))
        out[0, 0] = 1.0
        if self.tension:
            out[0, 1] = -1.0
        out[[1, 2], self.slide] = 1.0
        return out

    @property
    def bearing(self) -> Floats:
        """(width,): the normal force that carries friction."""
        out = np.zeros(self.width)
        out[0] = 1.0
        if self.tension and self.rule is FrictionRule.NET:
            out[1] = -1.0
        return out

    @property
    def length(self) -> Floats:
        """(width,): the bound on the length of the friction force."""
        out = np.zeros(self.width)
        out[-1] = 1.0
        return out


@dataclass(frozen=True, eq=False)
class ForceRows:
    """Rows of the program over the unknowns of all corners.

    Attributes
    ----------
    matrix
    cones
    balance
        Number of the first rows, which are equilibrium, ``A f = -p``; the others have zero on
        their right side.
    """

    matrix: sparse.csc_matrix
    cones: Cones
    balance: int

    @property
    def count(self) -> int:
        """Number of rows."""
        return int(self.matrix.shape[0])


def force_rows(statics: Statics, cone: FrictionCone, columns: Columns) -> ForceRows:
    """Equilibrium, no pull and friction as rows over the unknowns of all corners."""
    k = statics.corner_count
    one = sparse.identity(k, format="csr")
    balance = statics.matrix @ sparse.kron(one, columns.net, format="csr")
    slide = columns.net[1:]
    linear: list[Any] = []
    second: list[Any] = []

    def friction(
        each: Any, coefficient: Floats, bound: Floats, reach_of: FrictionCone = cone
    ) -> None:
        """``|each slide| <= coefficient (each bound)``, exact or as a pyramid."""
        scaled = sparse.diags(coefficient) @ each
        if reach_of.sides:
            directions, reach = reach_of.directions()
            sides = np.ones((reach_of.sides, 1))
            linear.append(
                sparse.kron(each, directions @ slide) - reach * sparse.kron(scaled, sides * bound)
            )
        else:
            axis, across = np.zeros((3, columns.width)), np.zeros((3, columns.width))
            axis[0], across[1:] = bound, slide
            second.append(-sparse.kron(scaled, axis) - sparse.kron(each, across))

    if columns.tension or cone.sides:
        signs = np.zeros((1 + columns.tension, columns.width))
        signs[range(len(signs)), range(len(signs))] = -1.0
        linear.append(sparse.kron(one, signs))
    at_corner = statics.friction if cone.local is None else np.full(k, cone.local)
    slippery = np.flatnonzero(at_corner < SLIPPERY)
    if not (columns.tension or cone.sides) and len(slippery):
        pull = np.zeros((1, columns.width))
        pull[0, 0] = -1.0
        linear.append(sparse.kron(one[slippery], pull))
    if columns.priced:
        friction(one, np.ones(k), columns.length, replace(cone, circumscribed=True))
    friction(one, at_corner, columns.bearing)
    if cone.local is not None and k:
        joints, first = np.unique(statics.interface, return_index=True)
        row = np.searchsorted(joints, statics.interface)
        together = sparse.csr_matrix((np.ones(k), (row, np.arange(k))), shape=(len(joints), k))
        friction(together, statics.friction[first], columns.bearing)
    blocks = [balance, *linear, *second]
    cones = Cones(
        balance.shape[0],
        sum(part.shape[0] for part in linear),
        (3,) * (sum(part.shape[0] for part in second) // 3),
    )
    return ForceRows(sparse.vstack(blocks, format="csc"), cones, balance.shape[0])
