"""Conic programs built from named variables and named rows.

minimise  1/2 x' diag(quadratic) x + linear' x   subject to   right - matrix x  in cones

They are solved as convex quadratic programs over second-order cones, by Clarabel:

    minimise  1/2 x' P x + c' x   subject to  A x + s = b,  s in a product of cones

Source of the method: Goulart and Chen 2024 (Clarabel).
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias, cast

import clarabel
import numpy as np
from scipy import sparse

from drystone.base.arrays import Floats, Ints, frozen
from drystone.base.display import OneLine
from drystone.base.errors import SolverError, counted
from drystone.base.settings import Options


@dataclass(frozen=True)
class Variable:
    """Consecutive unknowns of a program under one name."""

    name: str
    start: int
    count: int

    @property
    def place(self) -> slice:
        """Their slice of x."""
        return slice(self.start, self.start + self.count)


Term: TypeAlias = tuple[Variable, Any]
"""A variable and its coefficient: a matrix, sparse or not, a vector (a diagonal) or a number (times
the identity)."""


@dataclass(frozen=True, eq=False)
class ConicProgram(OneLine):
    """A convex program with named variables and rows.

    Attributes
    ----------
    quadratic, linear : (x,)
        Costs: the diagonal of the quadratic part, and the linear part.
    matrix : (r, x) sparse
    right : (r,)
    cones
        ``right - matrix @ x`` lies in them: zeros first, then the nonnegative rows, then the
        second-order cones.
    variables, rows
        Their slices of x and of the rows, by name.
    unit
        Unit of each variable, such as newtons; 1 if not given.
    """

    quadratic: Floats
    linear: Floats
    matrix: sparse.csc_matrix
    right: Floats
    cones: Cones
    variables: Mapping[str, slice]
    rows: Mapping[str, slice]
    unit: Mapping[str, float] = field(default_factory=dict)

    def solve(
        self, options: ConicOptions | None = None, *, stop: Callable[[], bool] | None = None
    ) -> ConicSolution:
        """The solution; parameters as for ``drystone.solvers.program``."""
        return solution(self.solver(options), stop)

    def solver(self, options: ConicOptions | None = None) -> Any:
        """A solver, as ``drystone.solvers.program.prepared`` makes it."""
        return prepared(self.quadratic, self.linear, self.matrix, self.right, self.cones, options)

    def at_vertex(self, found: ConicSolution, time_limit_s: float = np.inf) -> ConicSolution:
        """A vertex of the set of solutions, by the simplex method.

        Parameters
        ----------
        found
            Of a linear program without second-order cones.
        time_limit_s

        Raises
        ------
        DrystoneError
            The simplex method ended without one.
        """
        first = self.cones.zero
        form: dict[str, Any] = {  # sparse, of which the types of linprog know nothing
            "A_eq": self.matrix[:first],
            "b_eq": self.right[:first],
            "A_ub": self.matrix[first:],
            "b_ub": self.right[first:],
            "bounds": (None, None),
            "method": "highs-ds",
            "options": {} if np.isinf(time_limit_s) else {"time_limit": max(time_limit_s, 0.0)},
        }
        from scipy.optimize import linprog  # slow to import, as its package is

        vertex = linprog(self.linear, **form)
        if vertex.x is None:
            raise SolverError(f"the simplex method found no vertex: {vertex.message}")
        steps = found.iterations + int(vertex.nit)
        return replace(found, x=vertex.x, iterations=steps, solver="HiGHS dual simplex")

    def value(self, x: Floats, name: str) -> Floats:
        """The part of a solution x that belongs to a variable, in its unit."""
        return x[self.variables[name]] * self.unit.get(name, 1.0)

    def _summary(self) -> str:
        rows, columns = self.matrix.shape
        return f"{counted(columns, 'unknown')}, {counted(rows, 'row')}, {', '.join(self.variables)}"


class ProgramBuilder:
    """Collects variables and rows; :meth:`build` puts them in order.

    Rows of one kind keep the order in which they were added.

    Examples
    --------
    The smallest x + y with x >= 1 and y >= 2:

    >>> program = ProgramBuilder()
    >>> x = program.variable("x", 1, linear=1.0)
    >>> y = program.variable("y", 1, linear=1.0)
    >>> program.at_most("least x", np.array([-1.0]), (x, -1.0))
    >>> program.at_most("least y", np.array([-2.0]), (y, -1.0))
    >>> made = program.build()
    >>> made.solve().x.round(6).tolist()
    [1.0, 2.0]
    """

    def __init__(self) -> None:
        self._variables: list[tuple[Variable, Any, Any, float]] = []
        self._rows: dict[str, list[tuple[str, Floats, tuple[Term, ...]]]] = {
            "equal": [],
            "at most": [],
            "cone": [],
        }
        self._cones: list[int] = []

    def variable(
        self,
        name: str,
        count: int,
        *,
        linear: Floats | float = 0.0,
        quadratic: Floats | float = 0.0,
        unit: float = 1.0,
    ) -> Variable:
        """New unknowns, with their costs."""
        start = self._variables[-1][0].place.stop if self._variables else 0
        made = Variable(name, start, count)
        self._variables.append((made, linear, quadratic, unit))
        return made

    def equal(self, name: str, right: Floats, *terms: Term) -> None:
        """Rows ``sum of terms == right``."""
        self._rows["equal"].append((name, right, terms))

    def at_most(self, name: str, right: Floats, *terms: Term) -> None:
        """Rows ``sum of terms <= right``."""
        self._rows["at most"].append((name, right, terms))

    def cone(self, name: str, size: int, right: Floats, *terms: Term) -> None:
        """Rows ``s = right - sum of terms``; of each ``size`` the first bounds the others' norm."""
        self._rows["cone"].append((name, right, terms))
        self._cones += [size] * (len(right) // size)

    def build(self) -> ConicProgram:
        """The program."""
        groups = [group for kind in self._rows.values() for group in kind]
        last = self._variables[-1][0].place.stop if self._variables else 0
        first = np.cumsum([0, *(len(right) for _, right, _ in groups)])
        rows = list(zip(first[:-1].tolist(), groups, strict=True))
        none = np.zeros(0, dtype=np.intp)
        row, column, value = [none], [none], [np.zeros(0)]
        for begin, (_, right, terms) in rows:
            for variable, coefficient in terms:
                rows_of, columns_of, values_of = _entries(coefficient, len(right))
                row.append(begin + rows_of)
                column.append(variable.start + columns_of)
                value.append(values_of)
        places = np.concatenate(row), np.concatenate(column)
        matrix = sparse.csc_matrix((np.concatenate(value), places), shape=(int(first[-1]), last))
        linear, quadratic = np.zeros(last), np.zeros(last)
        for variable, price, weight, _ in self._variables:
            linear[variable.place], quadratic[variable.place] = price, weight
        return ConicProgram(
            frozen(quadratic),
            frozen(linear),
            matrix,
            frozen(np.concatenate([np.zeros(0), *(right for _, right, _ in groups)])),
            Cones(
                sum(len(right) for _, right, _ in self._rows["equal"]),
                sum(len(right) for _, right, _ in self._rows["at most"]),
                tuple(self._cones),
            ),
            {v.name: v.place for v, *_ in self._variables},
            {name: slice(a, a + len(right)) for a, (name, right, _) in rows},
            {v.name: unit for v, _, _, unit in self._variables},
        )


def _entries(coefficient: Any, rows: int) -> tuple[Ints, Ints, Floats]:
    """Rows, columns and values of a coefficient."""
    if sparse.issparse(coefficient):
        found = cast(Any, coefficient).tocoo()
        return found.row, found.col, found.data
    if np.ndim(coefficient) == 2:
        row, column = np.nonzero(coefficient)
        return row, column, coefficient[row, column]
    place = np.arange(rows)
    return place, place, np.full(rows, coefficient)


class ConicStatus(enum.Enum):
    """Status reported by a back end; results are checked before use."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    FAILED = "failed"


@dataclass(frozen=True)
class Cones:
    """Cones of the rows, in this order.

    Attributes
    ----------
    zero
        Number of equality rows.
    nonnegative
        Number of rows with s >= 0.
    second_order
        Size of each second-order cone; its first row is the bound.
    """

    zero: int = 0
    nonnegative: int = 0
    second_order: tuple[int, ...] = ()


@dataclass(frozen=True)
class ConicOptions(Options):
    """Settings of the interior point.

    Attributes
    ----------
    tolerance : > 0
        Relative feasibility, dimensionless; 1e-9 is close to what doubles allow.
    gap : > 0
        Relative distance from the optimum; the same as ``tolerance`` when left out. If any feasible
        point is sufficient, a coarse gap saves a third of the steps.
    iteration_limit : >= 1
    time_limit_s : [s] >= 0
    """

    tolerance: float = 1e-9
    gap: float | None = None
    iteration_limit: int = 200
    time_limit_s: float = float("inf")


@dataclass(frozen=True, eq=False)
class ConicSolution:
    """Primal x and dual z; when infeasible, z is the certificate: A'z = 0, b'z < 0."""

    status: ConicStatus
    x: Floats
    z: Floats
    iterations: int
    solver: str
    message: str


def prepared(
    quadratic: Floats,
    linear: Floats,
    matrix: Any,
    right: Floats,
    cones: Cones,
    options: ConicOptions | None = None,
) -> Any:
    """A solver of a conic program; its method ``update`` changes entries.

    Parameters
    ----------
    quadratic, linear : (x,)
        Of the quadratic part its diagonal.
    matrix : (r, x) sparse
    right : (r,)
    cones
        Cones of the r rows, in the order of :class:`Cones`.
    options
    """
    chosen = options if options is not None else ConicOptions()
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = chosen.iteration_limit
    settings.tol_feas = chosen.tolerance
    settings.tol_gap_abs = settings.tol_gap_rel = chosen.gap or chosen.tolerance
    settings.tol_infeas_abs = settings.tol_infeas_rel = chosen.tolerance
    settings.max_threads = 1
    if np.isfinite(chosen.time_limit_s):
        settings.time_limit = max(chosen.time_limit_s, 1e-3)
    flat = (clarabel.ZeroConeT, cones.zero), (clarabel.NonnegativeConeT, cones.nonnegative)
    kinds = [kind(count) for kind, count in flat if count]
    kinds.extend(clarabel.SecondOrderConeT(size) for size in cones.second_order)
    size = len(quadratic)
    place = np.arange(size + 1)
    upper = sparse.csc_matrix((quadratic, place[:-1], place), shape=(size, size))
    return clarabel.DefaultSolver(upper, linear, sparse.csc_matrix(matrix), right, kinds, settings)


def solution(solver: Any, stop: Callable[[], bool] | None = None) -> ConicSolution:
    """The solution by a solver.

    Parameters
    ----------
    solver
    stop
        Called at every step with Clarabel 0.11 and later; True ends the program as FAILED. An
        exception in it, or Ctrl-C, is raised from here at the next step.
    """
    raw = _watched(solver, stop)
    name = str(raw.status)
    known = {
        "Solved": ConicStatus.SOLVED,
        "PrimalInfeasible": ConicStatus.INFEASIBLE,
        "DualInfeasible": ConicStatus.UNBOUNDED,
    }
    status = known.get(name.removeprefix("Almost"), ConicStatus.FAILED)
    x, z = np.asarray(raw.x), np.asarray(raw.z)
    solver_name = f"clarabel {clarabel.__version__}"
    return ConicSolution(status, x, z, int(raw.iterations), solver_name, name)


def _watched(solver: Any, stop: Callable[[], bool] | None) -> Any:
    """The solution of a solver that asks at every step whether to continue.

    Clarabel prints and discards exceptions of its callback, so none may leave it. Python handles a
    signal at the next instruction, which in a function comes before any ``try``. A generator
    resumes inside its ``try``.
    """
    raised: list[BaseException] = []

    def answers() -> Generator[bool, object, None]:
        answer = False
        while True:
            try:
                yield answer
                answer = bool(raised) or (stop is not None and stop())
            except GeneratorExit:
                return
            except BaseException as error:  # raised again below
                raised.append(error)
                answer = True

    asking = answers()
    next(asking)
    if hasattr(solver, "set_termination_callback"):
        solver.set_termination_callback(asking.send)
    raw = solver.solve()
    if raised:
        raise raised[0]
    return raw
