"""Corner forces as unknowns of a convex program: equilibrium, no tension, friction."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy import sparse

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged
from drystone.base.settings import Options
from drystone.mechanics.statics import UNLIMITED, Statics
from drystone.solvers.program import ProgramBuilder, Term, Variable

SLIPPERY = 0.01
"""Below this friction coefficient, separate rows exclude tension: the exact cone limits mu times
the normal force with a tolerance. Chosen: the tolerance on the normal force is at most a hundred
times the tolerance on the cone."""


STRENGTH = "strength"
"""Name of the rows whose multipliers are planes over the faces that crush."""


class FrictionRule(enum.Enum):
    """Which normal force carries friction where tension is allowed."""

    PLUS = "friction+"
    """Compression only: always feasible."""
    NET = "friction-net"
    """Compression minus tension: may be infeasible."""


@dataclass(frozen=True)
class FrictionCone(Options):
    """The set of admissible corner forces.

    Attributes
    ----------
    sides
        0 for the exact cone, else the number of sides of a pyramid around it.

    Notes
    -----
    ``FrictionCone.octagon()`` is the eight-sided circumscribed pyramid of the source: it allows up
    to 1 / cos(22.5 deg) - 1 = 8.2 % more friction than the coefficient.
    """

    sides: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.sides != 0 and self.sides < 3:
            raise InputError(f"a friction pyramid has {self.sides} sides", remedy="0 or 3 and more")

    @classmethod
    def exact(cls) -> FrictionCone:
        """The exact Coulomb cone."""
        return cls(0)

    @classmethod
    def octagon(cls) -> FrictionCone:
        """Eight sides, circumscribed, to reproduce published figures."""
        return cls(8)

    @classmethod
    def named(cls, name: str) -> FrictionCone:
        """The cone of a name: ``exact`` or ``octagon``.

        Raises
        ------
        InputError
            It is not known.
        """
        if name not in ("exact", "octagon"):
            raise InputError(f"is '{name}'", remedy="use one of exact, octagon")
        return cls.exact() if name == "exact" else cls.octagon()

    @property
    def normals(self) -> Floats:
        """Unit outward normals (s, 2) of the pyramid's sides."""
        angle = 2.0 * np.pi * np.arange(self.sides) / self.sides
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)


@dataclass(frozen=True)
class CornerForces:
    """The unknowns of all corners in a program.

    Attributes
    ----------
    force
        (k, 3) in local n, u, v; its normal part is compression.
    tension
        (k,) subtracted from the normal part, where tension is allowed.
    length
        (k,) bound on the length of the friction force, where it has a cost.
    rule
    part
        (g,) shares of the known parts of faces that crush.
    pull
        (c,) within the capacity at the corners of faces that crush, which lets them press more.
    """

    force: Variable
    tension: Variable | None = None
    length: Variable | None = None
    rule: FrictionRule = FrictionRule.PLUS
    part: Variable | None = None
    pull: Variable | None = None

    def wrench(self, statics: Statics) -> list[Term]:
        """The terms of the corner forces in the equilibrium of the blocks."""
        terms: list[Term] = [(self.force, statics.matrix)]
        if self.tension is not None:
            terms.append((self.tension, -statics.matrix_transposed[::3].T))
        return terms

    @property
    def bearing(self) -> list[tuple[Variable, Floats]]:
        """The normal force that carries friction, as factors of the unknowns."""
        shares = [(self.force, np.array([1.0, 0.0, 0.0]))]
        if self.tension is not None and self.rule is FrictionRule.NET:
            shares.append((self.tension, np.array([-1.0])))
        return shares


def add_corner_forces(
    program: ProgramBuilder,
    statics: Statics,
    *,
    linear: Floats | float = 0.0,
    quadratic: Floats | float = 0.0,
) -> CornerForces:
    """New unknowns for corner forces without tension."""
    count = 3 * statics.corner_count
    unit = statics.force_unit
    force = program.variable("force", count, linear=linear, quadratic=quadratic, unit=unit)
    crushing = statics.crushing
    if crushing is None:
        return CornerForces(force)
    part = program.variable("part", len(crushing.face))
    if not statics.tension[crushing.corner].any():
        return CornerForces(force, part=part)
    pull = program.variable("pull", len(crushing.corner), unit=unit)
    return CornerForces(force, part=part, pull=pull)


def add_contact_rows(
    program: ProgramBuilder, statics: Statics, cone: FrictionCone, unknowns: CornerForces
) -> None:
    """Rows that exclude tension and limit friction."""
    k = statics.corner_count
    one = sparse.identity(k, format="csr")
    pull = sparse.kron(one, np.array([[-1.0, 0.0, 0.0]])).tocsr()
    rubs = statics.friction
    bounded = np.ones(k, dtype=bool)
    if unknowns.tension is None and not cone.sides:  # the exact cone of a dry corner says it
        bounded = (rubs < SLIPPERY) | (statics.cohesion > 0.0)
    bounded &= statics.tension < UNLIMITED
    if bounded.any():
        program.at_most("no pull", statics.tension[bounded], (unknowns.force, pull[bounded]))
    if unknowns.part is not None:
        _within_strength(program, statics, unknowns, unknowns.part)
    if unknowns.tension is not None:
        program.at_most("tension", np.zeros(k), (unknowns.tension, -1.0))
    if unknowns.length is not None:
        length = [(unknowns.length, np.ones(1))]
        _bounded(program, "length of friction", unknowns.force, one, np.ones(k), length, cone)
    cohesion = statics.cohesion
    bound = partial(_bounded, program, force=unknowns.force, bound=unknowns.bearing, cone=cone)
    holds, limited = cohesion < UNLIMITED, statics.shear < UNLIMITED
    bound("friction", sums=one[holds], coefficient=rubs[holds], constant=cohesion[holds])
    if limited.any():
        most = statics.shear[limited]
        bound("shear", sums=one[limited], coefficient=np.zeros(len(most)), constant=most)


def _within_strength(
    program: ProgramBuilder, statics: Statics, unknowns: CornerForces, part: Variable
) -> None:
    """Rows for faces that crush: normal force and moments are those of parts under the strength."""
    crushing = statics.crushing
    if crushing is None:
        return
    faces, corners = len(crushing), len(crushing.corner)
    lever = np.column_stack([np.ones(corners), crushing.place])
    face = Ragged(crushing.start).owner
    rows = (3 * face[:, None] + np.arange(3)).ravel()

    def summed(column: Ints, count: int) -> sparse.csr_matrix:
        """Normal force and moments of all faces, from a value per corner."""
        places = rows, np.repeat(column, 3)
        return sparse.csr_matrix((lever.ravel(), places), shape=(3 * faces, count))

    terms: list[Term] = [(unknowns.force, summed(3 * crushing.corner, 3 * statics.corner_count))]
    if unknowns.pull is not None:
        terms.append((unknowns.pull, summed(np.arange(corners), corners)))
        most = statics.tension[crushing.corner]
        program.at_most("pulled apart", np.zeros(corners), (unknowns.pull, -1.0))
        held = np.flatnonzero(most < UNLIMITED)
        bound = sparse.identity(corners, format="csr")[held]
        program.at_most("most pull", most[held], (unknowns.pull, bound))
    known = len(crushing.face)
    rows = (3 * crushing.face[:, None] + np.arange(3)).ravel()
    places = rows, np.repeat(np.arange(known), 3)
    force = -crushing.strength[crushing.face, None] * crushing.part
    terms.append((part, sparse.csr_matrix((force.ravel(), places), shape=(3 * faces, known))))
    program.equal(STRENGTH, np.zeros(3 * faces), *terms)
    places = crushing.face, np.arange(known)
    shares = sparse.csr_matrix((np.ones(known), places), shape=(faces, known))
    program.at_most("whole faces", np.ones(faces), (part, shares))
    program.at_most("parts", np.zeros(known), (part, -1.0))


def _bounded(
    program: ProgramBuilder,
    name: str,
    force: Variable,
    sums: Any,
    coefficient: Floats,
    bound: list[tuple[Variable, Floats]],
    cone: FrictionCone,
    *,
    constant: Floats | float = 0.0,
) -> None:
    """``|sums of tangential forces| <= coefficient (sums of the bound) + constant``.

    Exact or as a pyramid.
    """
    # the rows of a cone are divided by its coefficient where that is large
    row = 1.0 / np.maximum(coefficient, 1.0)
    scaled, sums = sparse.diags(row * coefficient) @ sums, sparse.diags(row) @ sums
    if cone.sides:
        sides = np.hstack([np.zeros((cone.sides, 1)), cone.normals])
        terms = [(force, sparse.kron(sums, sides))]
        each = np.full((cone.sides, 1), -1.0)
    else:
        terms = [(force, -sparse.kron(sums, np.diag([0.0, 1.0, 1.0])))]
        each = np.array([[-1.0], [0.0], [0.0]])
    terms += [(variable, sparse.kron(scaled, each * share)) for variable, share in bound]
    # the constant enters as the bound does: with its factor of every row
    right = np.kron(row * constant, -each[:, 0])
    if cone.sides:
        program.at_most(name, right, *terms)
    else:
        program.cone(name, 3, right, *terms)
