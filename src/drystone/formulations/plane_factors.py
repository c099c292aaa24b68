"""The largest load factors of what is the same across its whole width, by a plane program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import sparse

from drystone.base.arrays import ROUNDING, Floats, Ints, lengths, plane_cross
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import EquilibriumSolution, FactorSolution, LoadFactors
from drystone.mechanics.statics import UNLIMITED, Statics
from drystone.solvers.program import ConicProgram, ConicSolution, ProgramBuilder, Term

_PLANE = np.array([0, 2, 4])
"""Of the wrench of a block: the force along x and along z, the moment along y."""


class PlaneFactors(LoadFactors):
    """As :class:`LoadFactors`, of joints whose corners lie in pairs across y, as a bridge's do.

    Both corners of a pair carry the same, so that a joint has a force at each of its two edges, and
    the moments that would turn it over cancel. Nothing is lost: of forces that balance a load in
    the plane those that are mirrored balance it too, and so does their mean.

    Where joints crush, the stress block of a rectangle is exact: with the forces p and q at its
    edges and the strength S of what its corners enclose it is (p + q)^2 <= 2 S min(p, q), two cones
    a joint. The corners of ties are drawn together.

    :meth:`of` tells whether it can be; a load out of the plane is left to the whole program.
    """

    def __init__(
        self,
        whole: LoadFactors,
        statics: Statics,
        cone: FrictionCone,
        reserve: sparse.csc_matrix,
        spread: sparse.csc_matrix,
        faces: tuple[Ints, Floats],
    ) -> None:
        super().__init__(replace(statics, crushing=None), cone, reserve)
        self._whole, self._spread, self._faces = whole, spread, faces
        self._friction = spread[::3, ::2].T @ statics.friction  # half of it at either corner

    @classmethod
    def of(
        cls, statics: Statics, cone: FrictionCone, reserve: sparse.csc_matrix | None
    ) -> LoadFactors:
        """Those of a problem: in the plane where it is plane, else of the whole."""
        whole = LoadFactors(statics, cone, reserve)
        if cone.sides or cone.local is not None or _beyond_friction(statics):
            return whole
        spread, pair = _pairs(statics)
        faces = _faces(statics, pair)
        held = [statics.matrix @ spread, sparse.csc_matrix(statics.load.reshape(-1, 1))]
        held += [] if reserve is None else [reserve]
        if faces is None or (np.bincount(pair) != 2).any() or any(map(_leaves, held)):
            return whole
        plane = sparse.csc_matrix((0, 0)) if reserve is None else _kept(reserve)
        return cls(whole, statics, cone, plane, spread, faces)

    def __call__(self, live: Floats, stop: Callable[[], bool] | None = None) -> FactorSolution:
        """The largest factor of a live load (n, 6), scaled as ``statics.load`` is."""
        if _leaves(sparse.csc_matrix(live.reshape(-1, 1))):
            return self._whole(live, stop)
        return super().__call__(live[:, _PLANE], stop)

    def _built(self, builder: ProgramBuilder, statics: Statics, terms: list[Term]) -> ConicProgram:
        count = self._spread.shape[1] // 2
        force = builder.variable("force", 2 * count, unit=statics.force_unit)
        arms = _kept(statics.matrix @ self._spread)
        builder.equal("equilibrium", -statics.load[:, _PLANE].ravel(), (force, arms), *terms)
        one = sparse.identity(count, format="csr")
        builder.at_most(
            "no pull", np.zeros(count), (force, sparse.kron(one, np.array([[-1.0, 0.0]])))
        )
        rough = sparse.kron(sparse.diags(self._friction), np.array([[-1.0, 0.0], [-1.0, 0.0]]))
        slides = rough + sparse.kron(one, np.array([[0.0, 1.0], [0.0, -1.0]]))
        builder.at_most("friction", np.zeros(2 * count), (force, slides))
        edges, strength = self._faces
        at_edge = [
            sparse.csr_matrix(
                (1.0 / strength, (np.arange(len(edges)), 2 * edge)), (len(edges), 2 * count)
            )
            for edge in edges.T
        ]
        whole = sparse.kron(at_edge[0] + at_edge[1], np.array([[0.0], [-2.0], [0.0]]))
        for number, one in enumerate(at_edge if len(edges) else ()):
            rows = whole + sparse.kron(one, np.array([[-1.0], [0.0], [-1.0]]))
            builder.cone(
                f"strength {number}", 3, np.tile([2.0, 0.0, -2.0], len(edges)), (force, rows)
            )
        return builder.build()

    def _state(self, program: ConicProgram, raw: ConicSolution) -> EquilibriumSolution:
        force = (self._spread @ raw.x[program.variables["force"]]).reshape(-1, 3)
        multiplier = np.zeros(self._statics.load.shape)
        multiplier[:, _PLANE] = raw.z[program.rows["equilibrium"]].reshape(-1, 3)
        return EquilibriumSolution(force, np.zeros(len(force)), multiplier, raw)


def _beyond_friction(statics: Statics) -> bool:
    return bool((statics.tension + statics.cohesion).any() or (statics.shear < UNLIMITED).any())


def _rows(matrix: Any) -> Ints:
    """Which of the rows of wrenches are in the plane."""
    return (6 * np.arange(matrix.shape[0] // 6)[:, None] + _PLANE).ravel()


def _kept(matrix: Any) -> sparse.csc_matrix:
    """The rows in the plane."""
    return sparse.csc_matrix(matrix.tocsr()[_rows(matrix)])


def _leaves(matrix: Any) -> bool:
    """Whether wrenches have parts out of the plane."""
    out = np.delete(np.arange(matrix.shape[0]), _rows(matrix))
    size = abs(matrix)
    return bool(size.tocsr()[out].max() > ROUNDING * size.max()) if size.nnz else False


def _pairs(statics: Statics) -> tuple[sparse.csc_matrix, Ints]:
    """The force of corners (3 k, 2 g) from normal and shear of pairs, and the pair of each corner.

    A pair are the corners of a joint at the same place along x and z.
    """
    onto = statics.block_b >= 0
    lever = np.where(onto[:, None], statics.lever_b, statics.lever_a)[:, [0, 2]]
    at = np.column_stack([statics.interface, np.rint(1e6 * lever)])
    _, pair = np.unique(at, axis=0, return_inverse=True)
    pair = pair.ravel()
    along = np.cross([0.0, 1.0, 0.0], statics.frame[:, 0])
    flat = np.einsum("kij,kj->ki", statics.frame[:, 1:], along)
    k = np.arange(len(pair))
    row = np.concatenate([3 * k, 3 * k + 1, 3 * k + 2])
    column = np.concatenate([2 * pair, 2 * pair + 1, 2 * pair + 1])
    value = 0.5 * np.concatenate([np.ones(len(k)), flat[:, 0], flat[:, 1]])
    shape = 3 * len(k), 2 * (int(pair.max(initial=-1)) + 1)
    return sparse.csc_matrix((value, (row, column)), shape=shape), pair


def _faces(statics: Statics, pair: Ints) -> tuple[Ints, Floats] | None:
    """The two pairs of each face that crushes, and its strength; None where one is no rectangle."""
    crushing = statics.crushing
    if crushing is None:
        return np.zeros((0, 2), dtype=np.intp), np.zeros(0)
    if (np.diff(crushing.start) != 4).any():
        return None
    corner = crushing.place.reshape(-1, 4, 2)
    side = np.roll(corner, -1, axis=1) - corner
    area, length = plane_cross(side[:, 0], side[:, 1]), lengths(side)
    bent = np.abs(length[:, 0] * length[:, 1] - area) > 1e-6 * area
    skew = lengths(side[:, 0] + side[:, 2]) > 1e-6 * length[:, 0]
    if (bent | skew | (area <= 0.0)).any():
        return None
    edges = np.sort(pair[crushing.corner].reshape(-1, 4), axis=1)[:, [0, 3]]
    return edges, crushing.strength * area
