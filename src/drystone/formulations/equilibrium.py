"""Rigid-block equilibrium (RBE) as a convex program over the corner forces.

    minimise  1/2 f' H f  (or c' f)   subject to   A f = -p,  friction,  no pull or a penalised one

Sources: Livesley 1978 (limit analysis of blocks); Whiting et al. 2009 (penalised tension);
Kao et al. 2022, section 3.

The mechanism nearest to the loads as a conic program, and corners of a mechanism held still.

Load factors of what is the same across its whole width are found by a plane program.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from drystone.base.arrays import ROUNDING, Floats, Ints, lengths, plane_cross
from drystone.base.settings import Options
from drystone.formulations.corner_forces import (
    STRENGTH,
    CornerForces,
    FrictionCone,
    FrictionRule,
    add_contact_rows,
    add_corner_forces,
)
from drystone.mechanics.statics import UNLIMITED, Statics
from drystone.solvers.program import (
    ConicOptions,
    ConicProgram,
    ConicSolution,
    ConicStatus,
    ProgramBuilder,
    Term,
    solution,
)

ANY_FORCES = 1e-3
"""Gap to the least forces at which to stop where any forces will do."""

_MISSING = 1e-5
"""Share of the optimum that missing parts of crushing faces may add: a tenth of the width of a
limit."""

_ROUNDS = 20
"""Largest number of times that parts are added. A bridge of 30 voussoirs takes 10 at most
with strengths that matter. What is missing then makes limits smaller."""


class Objective(enum.Enum):
    """What is minimised."""

    QUADRATIC = "quadratic"
    """Sum of weighted squares: unique, with forces spread evenly over corners."""
    LINEAR = "linear"
    """Sum of weighted forces. Not unique: this is a solution from the middle of the set."""
    VERTEX = "vertex"
    """The same sum, and of its solutions one with as few forces as can be, by the simplex method:
    it needs a friction pyramid."""


@dataclass(frozen=True)
class Weights(Options):
    """Weights of the objective, per unit of scaled force (squared).

    Values of Kao et al. 2022, section 3: tension costs a million times as much as
    compression. The cost of friction applies to the length of the friction force (linear objective)
    or to its square (quadratic objective), so it does not depend on the frame.

    Attributes
    ----------
    compression, tension, friction : >= 0
    """

    compression: float = 1.0
    tension: float = 1e6
    friction: float = 0.0

    def levelled(self) -> Weights:
        """The same ratios, with compression as far below one as tension is above.

        The solution is the same. With a cost of tension of a million, interior points ended early
        for one in fourteen overhanging blocks.
        """
        mean = math.sqrt(self.compression * self.tension)
        if mean == 0.0:
            return self
        return Weights(self.compression / mean, self.tension / mean, self.friction / mean)


@dataclass(frozen=True, eq=False)
class EquilibriumSolution:
    """Scaled answer of the program.

    Attributes
    ----------
    force : (k, 3) minus tension, when solved
    tension : (k,) when it was allowed
    multiplier : (n, 6) virtual velocity of the blocks: the mechanism when infeasible
    raw
    pull : (k,) what pulls where corners of a face that crushes press as well
    """

    force: Floats
    tension: Floats
    multiplier: Floats
    raw: ConicSolution
    pull: Floats | None = None


@dataclass(frozen=True, eq=False)
class FactorSolution:
    """The largest load factor, and the state at it.

    Attributes
    ----------
    factor
        Infinite if every live load can be balanced, minus infinity if no factor can, NaN if the
        solver failed.
    state
        Forces at the limit; its multiplier is the mechanism.
    reserve : (r,)
        Share of each reserve that is used, from 0 to 1.
    """

    factor: float
    state: EquilibriumSolution
    reserve: Floats = field(default_factory=lambda: np.zeros(0))


def build_equilibrium(
    statics: Statics,
    *,
    cone: FrictionCone,
    objective: Objective = Objective.QUADRATIC,
    weights: Weights | None = None,
    tension: bool = False,
    rule: FrictionRule = FrictionRule.PLUS,
) -> ConicProgram:
    """The program of RBE in scaled numbers.

    Parameters
    ----------
    statics
    cone
    objective
    weights
    tension
        Whether to allow tension at a cost.
    rule
        Used with tension only.
    """
    chosen = weights if weights is not None else Weights()
    if tension:
        chosen = chosen.levelled()
    k, unit = statics.corner_count, statics.force_unit
    program = ProgramBuilder()
    if objective is Objective.QUADRATIC:
        # a small weight keeps friction forces without cost unique
        least = 1e-6 * chosen.compression
        across = max(chosen.friction, least)
        costs = np.tile([max(chosen.compression, least), across, across], k)
        unknowns = add_corner_forces(program, statics, quadratic=costs)
        price = {"quadratic": max(chosen.tension, least)}
    else:
        costs = np.tile([chosen.compression, 0.0, 0.0], k)
        unknowns = add_corner_forces(program, statics, linear=costs)
        price = {"linear": chosen.tension}
        if chosen.friction > 0.0:
            length = program.variable("length", k, linear=chosen.friction, unit=unit)
            unknowns = replace(unknowns, length=length)
    if tension:
        pull = program.variable("tension", k, unit=unit, **price)
        unknowns = replace(unknowns, tension=pull, rule=rule)
    return _balanced(program, statics, unknowns, cone)


def _balanced(
    program: ProgramBuilder,
    statics: Statics,
    unknowns: CornerForces,
    cone: FrictionCone,
    *more: Term,
) -> ConicProgram:
    """The program in which corner forces, and more terms, balance the loads within the cone."""
    load = -statics.load.ravel()
    program.equal("equilibrium", load, *unknowns.wrench(statics), *more)
    add_contact_rows(program, statics, cone, unknowns)
    return program.build()


def solve_equilibrium(
    statics: Statics,
    *,
    options: ConicOptions | None = None,
    stop: Callable[[], bool] | None = None,
    **form: Any,
) -> EquilibriumSolution:
    """Solve RBE: the program of :func:`build_equilibrium`, which ``form`` is for.

    Parameters
    ----------
    statics
    options
    stop
        Called at every step of the interior-point solver.
    """
    return solved(partial(build_equilibrium, **form), statics, options, stop=stop)


class LoadFactors:
    """The largest factors of live loads on top of the load of ``statics`` that can be balanced.

    ::

        maximise  lambda   subject to   A f + p + lambda live + R s = 0,  0 <= s <= 1,  friction,
                                        no pull

    The program is built once, and only the live load changes in it, unless joints crush.

    Parameters
    ----------
    statics
    cone
    reserve : (6 n, r)
        R: wrenches of which any share may act, such as what fill resists; scaled alike.
    enough
        A factor from which on no larger one is asked for.
    whether
        Of a smaller factor no more is asked than that: where joints crush it may be too small.
    rubs : (k,)
        Friction of corners: those of a joint rub no more than all of it, and than they press for.

    Notes
    -----
    The multiplier is a collapse mechanism on which the live load does unit work: the kinematic
    theorem. Source: Livesley 1978; Ferris and Tin-Loi 2001, the associative bound.
    """

    def __init__(
        self,
        statics: Statics,
        cone: FrictionCone,
        reserve: sparse.csc_matrix | None = None,
        enough: float = np.inf,
        whether: bool = False,
        rubs: Floats | None = None,
    ) -> None:
        self._statics, self._cone, self._enough = statics, cone, enough
        self._whether, self._rubs = whether, rubs
        self._reserve = sparse.csc_matrix((0, 0)) if reserve is None else reserve
        self._kept: tuple[ConicProgram, Any] | None = None
        self._place: Ints = np.zeros(0, dtype=np.intp)  # of the live loads in it

    def __call__(self, live: Floats, stop: Callable[[], bool] | None = None) -> FactorSolution:
        """The largest factor of a live load (n, 6), scaled as ``statics.load`` is."""
        column, place = sparse.csc_matrix(live.reshape(-1, 1)), np.flatnonzero(live)
        if self._statics.crushing is not None:
            build = partial(self._program, column)
            # the next load finds most parts of faces that it needs
            state, self._statics = solved_by_parts(
                build, self._statics, stop=stop, ends=self._is_known
            )
        else:
            if np.isin(place, self._place).all() and self._kept is not None:
                program, solver = self._kept
                solver.update(A=(np.arange(len(self._place)), live.ravel()[self._place]))
            else:
                program = self._program(column, self._statics)
                solver = program.solver()
                self._place, self._kept = place, (program, solver)
            state = self._state(program, solution(solver, stop))
        x, known = state.raw.x, {ConicStatus.UNBOUNDED: np.inf, ConicStatus.INFEASIBLE: -np.inf}
        known[ConicStatus.SOLVED] = float(x[0])
        factor = known.get(state.raw.status, np.nan)
        return FactorSolution(factor, state, x[1 : 1 + self._reserve.shape[1]].copy())

    def _is_known(self, value: float, gap: float) -> bool:
        """Whether it is enough; or not, however much the missing parts add: twice, for a proof."""
        least = -self._enough
        return value <= least or (self._whether and value - 2.0 * gap > least)

    def _state(self, program: ConicProgram, raw: ConicSolution) -> EquilibriumSolution:
        return _state(program, raw)

    def _program(self, column: sparse.csc_matrix, statics: Statics) -> ConicProgram:
        builder = ProgramBuilder()
        terms: list[Term] = [(builder.variable("factor", 1, linear=-1.0), column)]
        count = self._reserve.shape[1]
        if count:
            share = builder.variable("reserve", count)
            terms.append((share, self._reserve))
            builder.at_most("reserve from 0", np.zeros(count), (share, -1.0))
            builder.at_most("reserve to 1", np.ones(count), (share, 1.0))
        if self._enough < np.inf:  # a little more, so that forces at that factor are well inside
            builder.at_most("enough", np.array([1.001 * self._enough]), (terms[0][0], 1.0))
        return self._built(builder, statics, terms)

    def _built(self, builder: ProgramBuilder, statics: Statics, terms: list[Term]) -> ConicProgram:
        unknowns = add_corner_forces(builder, statics)
        if self._rubs is not None:
            row = np.unique(statics.interface, return_inverse=True)[1]
            most = np.bincount(row, self._rubs).astype(np.float64)
            held, shape = np.flatnonzero(most < UNLIMITED), (len(most), len(row))
            whole = sparse.csr_matrix((np.ones(len(row)), (row, np.arange(len(row)))), shape=shape)
            length = builder.variable("length", len(row), unit=statics.force_unit)
            builder.at_most("friction of joints", most[held], (length, whole[held]))
            unknowns = replace(unknowns, length=length)
        return _balanced(builder, statics, unknowns, self._cone, *terms)


def solve_extreme_force(
    statics: Statics,
    price: Floats,
    *,
    cone: FrictionCone,
) -> EquilibriumSolution:
    """The forces in equilibrium that minimise ``sum(price * force)``: thrust bounds.

    Parameters
    ----------
    statics
    price : (k, 3) per unit of scaled force, local n, u, v
    cone
    """

    def build(given: Statics) -> ConicProgram:
        program = ProgramBuilder()
        unknowns = add_corner_forces(program, given, linear=price.ravel())
        return _balanced(program, given, unknowns, cone)

    return solved(build, statics)


def solved(
    build: Callable[[Statics], ConicProgram],
    statics: Statics,
    options: ConicOptions | None = None,
    *,
    stop: Callable[[], bool] | None = None,
    vertex: bool = False,
) -> EquilibriumSolution:
    """Solution of a program over corner forces; with ``vertex`` one of its linear program's.

    Where joints crush it is built and solved again, with more parts of their faces, until these add
    nothing.
    """
    return solved_by_parts(build, statics, options, stop=stop, vertex=vertex)[0]


def solved_by_parts(
    build: Callable[[Statics], ConicProgram],
    statics: Statics,
    options: ConicOptions | None = None,
    *,
    stop: Callable[[], bool] | None = None,
    vertex: bool = False,
    ends: Callable[[float, float], bool] | None = None,
) -> tuple[EquilibriumSolution, Statics]:
    """As :func:`solved`, with the problem as it has all parts of faces.

    ``ends``: whether a value, and by how much missing parts may lower it, is all that is asked.
    """
    steps, finer = 0, statics
    for _ in range(_ROUNDS):
        statics, program = finer, build(finer)
        raw = program.solve(options, stop=stop)
        steps += raw.iterations
        finer = _finer(statics, program, raw, ends) or statics
        if finer is statics:
            break
    raw = replace(raw, iterations=steps)
    if vertex and raw.status is ConicStatus.SOLVED:
        raw = program.at_vertex(raw, ConicOptions.of(options).time_limit_s)
    state = _state(program, raw)
    if "pull" not in program.variables or statics.crushing is None:
        return state, statics
    pull = np.zeros(len(state.force))
    pull[statics.crushing.corner] = raw.x[program.variables["pull"]]
    return replace(state, pull=pull), statics


def _state(program: ConicProgram, raw: ConicSolution) -> EquilibriumSolution:
    """The state of a solution."""
    force = raw.x[program.variables["force"]].reshape(-1, 3).copy()
    tension = np.zeros(len(force))
    if "tension" in program.variables:
        net = raw.x[program.variables["tension"]]
        force[:, 0] -= net
        tension = np.maximum(0.0, net)
    multiplier = raw.z[program.rows["equilibrium"]].reshape(-1, 6)
    return EquilibriumSolution(force, tension, multiplier, raw)


def _finer(
    statics: Statics,
    program: ConicProgram,
    raw: ConicSolution,
    ends: Callable[[float, float], bool] | None,
) -> Statics | None:
    """The problem with more parts of the faces that crush; None where these add nothing."""
    crushing = statics.crushing
    if crushing is None or raw.status not in (ConicStatus.SOLVED, ConicStatus.INFEASIBLE):
        return None
    plane = raw.z[program.rows[STRENGTH]].reshape(-1, 3)
    gap = float(crushing.missing(plane).sum())
    if raw.status is ConicStatus.INFEASIBLE:
        proven = float(program.right @ raw.z) + gap < 0.0  # the motion holds for whole faces too
        return None if proven else replace(statics, crushing=crushing.refined(plane))
    value = float(program.linear @ raw.x + 0.5 * program.quadratic @ raw.x**2)
    if gap <= _MISSING * abs(value) or (ends is not None and ends(value, gap)):
        return None
    normal = np.maximum(raw.x[program.variables["force"]][3 * crushing.corner], 0.0)
    return replace(statics, crushing=crushing.refined(plane, normal))


STILL = 1e-4
"""A corner that opens or slides by less than this share of the fastest one counts as fixed, if the
result is a mechanism. Chosen: on 11 tilted shelves all values from 1e-5 to 3e-2 give a
mechanism."""

SLIGHT = 1e-10
"""Weight, by the largest diagonal, that makes the matrix of the fixed corners regular."""


def held_still(statics: Statics, solution: EquilibriumSolution) -> EquilibriumSolution:
    """The nearest velocity at which nearly fixed corners are fixed.

    The solution of an interior-point method lies strictly inside the cone of mechanisms. For blocks
    between parallel faces this cone has no interior. There the solver leaves small motions at
    corners that do not move.
    """
    moved = np.abs(statics.displacement(solution.multiplier)).max(axis=1)
    still = np.flatnonzero(moved < STILL * moved.max(initial=0.0))
    if not len(still):
        return solution
    rows = statics.matrix_transposed[(3 * still[:, None] + np.arange(3)).ravel()]
    normal = (rows.T @ rows).tocsc()
    slight = SLIGHT * normal.diagonal().max() * sparse.identity(normal.shape[0], format="csc")
    solve = splu(normal + slight).solve
    motion = solution.multiplier.ravel()
    for _ in range(3):  # each takes off all but a small share of what the rows still see
        motion = motion - solve(rows.T @ (rows @ motion))
    return replace(solution, multiplier=motion.reshape(-1, 6))


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
        if cone.sides or not replace(statics, crushing=None).dry:
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
        shape = len(edges), 2 * count
        at_edge = [
            sparse.csr_matrix((np.ones(len(edges)), (np.arange(len(edges)), 2 * edge)), shape)
            for edge in edges.T
        ]
        both = sparse.diags(-np.sqrt(2.0 / strength)) @ (at_edge[0] + at_edge[1])
        # in units of weights: in those of strengths, a thousand times as much, programs fail
        for number, one in enumerate(at_edge if len(edges) else ()):
            outer = sparse.kron(one, np.array([[-1.0], [0.0], [-1.0]]))
            middle = sparse.kron(both, np.array([[0.0], [1.0], [0.0]]))
            right = np.tile([1.0, 0.0, -1.0], len(edges))
            builder.cone(f"strength {number}", 3, right, (force, outer + middle))
        return builder.build()

    def _state(self, program: ConicProgram, raw: ConicSolution) -> EquilibriumSolution:
        force = (self._spread @ raw.x[program.variables["force"]]).reshape(-1, 3)
        multiplier = np.zeros(self._statics.load.shape)
        multiplier[:, _PLANE] = raw.z[program.rows["equilibrium"]].reshape(-1, 3)
        return EquilibriumSolution(force, np.zeros(len(force)), multiplier, raw)


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
