"""Rigid-block equilibrium (RBE) as a convex program over the corner forces.

    minimise  1/2 f' H f  (or c' f)   subject to   A f = -p,  friction,  no pull or a penalised one

Sources: Livesley 1978 (limit analysis of blocks); Whiting et al. 2009 (penalised tension);
Kao et al. 2022, section 3.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from drystone.errors import InputError
from drystone.geometry.arrays import Floats
from drystone.solvers.conic import Cones, ConicOptions, ConicSolution, solve_conic
from drystone.statics import Statics


class Objective(enum.Enum):
    """What is minimised."""

    QUADRATIC = "quadratic"
    """Sum of weighted squares: unique, and even-handed between corners."""
    LINEAR = "linear"
    """Sum of weighted forces: a vertex of the set of admissible forces, not unique."""


class FrictionRule(enum.Enum):
    """Which normal force carries friction where tension is allowed."""

    PLUS = "friction+"
    """Compression only: always feasible."""
    NET = "friction-net"
    """Compression less tension: may be infeasible."""


@dataclass(frozen=True)
class FrictionCone:
    """The set of admissible corner forces.

    Attributes
    ----------
    sides
        0 for the exact cone, else the number of sides of a pyramid.
    circumscribed
        Pyramid around the cone (claims of impossibility) or inside it (claims of equilibrium).

    Notes
    -----
    ``FrictionCone.octagon()`` is the eight-sided circumscribed pyramid of the source: it grants up
    to 1 / cos(22.5 deg) - 1 = 8.2 % more friction than the coefficient says.
    """

    sides: int = 0
    circumscribed: bool = True

    def __post_init__(self) -> None:
        if self.sides != 0 and self.sides < 3:
            raise InputError(f"a friction pyramid has {self.sides} sides", remedy="0 or 3 and more")

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
class Weights:
    """Weights of the objective, per unit of scaled force (squared).

    Values of Kao et al. 2022, section 3: tension is a million times as dear as compression.
    """

    compression: float = 1.0
    tension: float = 1e6
    friction: float = 0.0


@dataclass(frozen=True, eq=False)
class EquilibriumSolution:
    """Scaled answer of the program.

    Attributes
    ----------
    force : (k, 3) net of tension, when solved
    tension : (k,) when it was allowed
    multiplier : (n, 6) virtual velocity of the blocks: the mechanism when infeasible
    raw
    """

    force: Floats
    tension: Floats
    multiplier: Floats
    raw: ConicSolution


def solve_equilibrium(
    statics: Statics,
    *,
    cone: FrictionCone,
    objective: Objective = Objective.QUADRATIC,
    weights: Weights | None = None,
    tension: bool = False,
    rule: FrictionRule = FrictionRule.PLUS,
    options: ConicOptions | None = None,
) -> EquilibriumSolution:
    """Solve RBE.

    Parameters
    ----------
    statics
    cone
    objective
    weights
    tension
        Allow a penalised pull.
    rule
        Matters with tension only.
    options
    """
    chosen = weights if weights is not None else Weights()
    k = statics.corner_count
    width = 4 if tension else 3
    # columns per corner: fn+ (, fn-), fu, fv
    spread = sparse.kron(sparse.identity(k), _net(tension), format="csr")
    balance = statics.matrix @ spread
    rows: list[Any] = [balance]
    right, cones = [-statics.load.ravel()], {"zero": balance.shape[0]}
    bearing = [1.0] if not tension else [1.0, 0.0 if rule is FrictionRule.PLUS else -1.0]
    linear_rows: list[Any] = []
    if tension or cone.sides:
        signs = np.zeros((2 if tension else 1, width))
        signs[range(len(signs)), range(len(signs))] = -1.0
        linear_rows.append(sparse.kron(sparse.identity(k), signs))
    if cone.sides:
        directions, reach = cone.directions()
        per_friction = np.zeros((cone.sides, width))
        per_friction[:, : len(bearing)] = -reach * np.array(bearing)
        slide = np.zeros((cone.sides, width))
        slide[:, -2:] = directions
        linear_rows.append(
            sparse.kron(sparse.diags(statics.friction), per_friction)
            + sparse.kron(sparse.identity(k), slide)
        )
    if linear_rows:
        stacked = sparse.vstack(linear_rows)
        rows.append(stacked)
        right.append(np.zeros(stacked.shape[0]))
        cones["nonnegative"] = stacked.shape[0]
    second: tuple[int, ...] = ()
    if not cone.sides:
        axis = np.zeros((3, width))
        axis[0, : len(bearing)] = -np.array(bearing)
        slide = np.zeros((3, width))
        slide[1, -2] = slide[2, -1] = -1.0
        rows.append(
            sparse.kron(sparse.diags(statics.friction), axis)
            + sparse.kron(sparse.identity(k), slide)
        )
        right.append(np.zeros(3 * k))
        second = (3,) * k
    price = np.array(
        [chosen.compression, *([chosen.tension] if tension else []), *[chosen.friction] * 2]
    )
    if objective is Objective.QUADRATIC:
        # a trace of weight keeps the friction forces unique where they cost nothing
        cost = np.maximum(price, 1e-6 * chosen.compression)
        quadratic: Any = sparse.diags(np.tile(cost, k))
        linear = np.zeros(width * k)
    else:
        quadratic = sparse.csc_matrix((width * k, width * k))
        price[-2:] = 0.0  # a signed force has no linear price
        linear = np.tile(price, k)
    raw = solve_conic(
        quadratic,
        linear,
        sparse.vstack(rows, format="csc"),
        np.concatenate(right),
        Cones(cones["zero"], cones.get("nonnegative", 0), second),
        options,
    )
    x = raw.x.reshape(k, width)
    pull = np.maximum(0.0, x[:, 1]) if tension else np.zeros(k)
    force = np.stack([x[:, 0] - (x[:, 1] if tension else 0.0), x[:, -2], x[:, -1]], axis=1)
    multiplier = raw.z[: balance.shape[0]].reshape(-1, 6)
    return EquilibriumSolution(force, pull, multiplier, raw)


def _net(tension: bool) -> Floats:
    """Corner force (n, u, v) from the columns of one corner."""
    if not tension:
        return np.eye(3)
    return np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
