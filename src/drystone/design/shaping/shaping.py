"""Vertices moved by gradient until a structure stands, weighs least, or reaches farthest."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Unpack

import numpy as np
from scipy.optimize import minimize

from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import DrystoneError, InputError
from drystone.base.progress import Progress
from drystone.base.settings import Options, checked_call
from drystone.design.mends.margin import DesignMargin
from drystone.design.mends.mends import stands_already
from drystone.design.shaping.free_moves import Moves
from drystone.design.shaping.help_needed import Form
from drystone.design.shaping.vertex_measures import Bodies
from drystone.design.surgery.changed_model import changed
from drystone.geometry.body.polyhedron import edges_of
from drystone.io.opening import Given, How, as_model
from drystone.model import Model
from drystone.results import Result
from drystone.stability import CheckOptions, check

HELPED = 1e-4
"""Share of the load on the ground up to which a shape is taken to stand during the search; at least
four times that of the shape that stands. Chosen: of three stacked bricks it leads within 0.1 % of
the largest overhang. The check decides."""

CLOSE = 2.0**-7
"""Share of a step to which the last shape that stands is bisected."""


class ShapeAim(enum.Enum):
    """What a shape is changed for."""

    STAND = "stand"
    VOLUME = "volume"
    REACH = "reach"


@dataclass(frozen=True)
class ShapeOptions(Options):
    """Options of :func:`shape`.

    Attributes
    ----------
    aim
        To stand; the least volume, or the farthest reach, with which it stands.
    margin
        How far from falling the shape has to stand.
    reach : (3,)
        The direction of the farthest reach.
    block
        Name or position of the block that reaches out.
    rounds
        Steps of the search at most; contacts are found anew after each.
    iterations
        Iterations of the optimiser in one round at most.
    least_edge : [m]
        No edge that moves gets shorter: the least thickness of blocks.
    trust
        Largest change of a variable in the first round, by its largest move.
    close
        The search ends when a round gains less than this share.
    """

    aim: ShapeAim = ShapeAim.STAND
    margin: DesignMargin = field(default_factory=DesignMargin)
    reach: tuple[float, float, float] = (1.0, 0.0, 0.0)
    block: int | str = -1
    rounds: int = 20
    iterations: int = 40
    least_edge: float = 0.0
    trust: float = 0.25
    close: float = 1e-3

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rounds < 1 or self.iterations < 1:
            raise InputError("there is no round or no iteration", remedy="give 1 or more")
        if not 0.0 < self.trust <= 1.0:
            raise InputError(f"the trust is {self.trust}", remedy="give a share above 0, up to 1")
        if not 0.0 <= self.least_edge < np.inf:
            raise InputError(
                f"the least edge is {self.least_edge} m", remedy="give metres, 0 or more"
            )
        if not 0.0 < self.close < 1.0:
            raise InputError(f"close is {self.close}", remedy="give a share between 0 and 1")


@dataclass(frozen=True, eq=False)
class Shaped(OneLine):
    """A structure with another shape.

    Attributes
    ----------
    before, model
    x : (p,) [m]
        The variables.
    result
        The check of ``model``, or that of the case of the margin in which it falls.
    stands
        Whether it stands at the margin.
    value
        Volume [m3] or reach [m] of ``model``; the help that it needs where it was to stand.
    first
        The same of ``before``.
    rounds
    message
    """

    before: Model
    model: Model
    x: Floats
    result: Result
    stands: bool
    value: float
    first: float
    rounds: int
    message: str

    def _summary(self) -> str:
        return self.message

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "stands": self.stands,
            "verdict": self.result.verdict.value,
            "message": self.message,
            "check": self.result.message,
            "value": self.value,
            "first": self.first,
            "rounds": self.rounds,
            "variables": [float(one) for one in self.x],
        }


@checked_call
def shape(
    given: Given,
    moves: Moves | Callable[[Model], Moves],
    *,
    options: ShapeOptions | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
    **how: Unpack[How],
) -> Shaped:
    """Move vertices until a structure stands, or as far as it stands at least volume or farthest.

    The help that it needs, and its derivative by all variables (one more solve), come from the
    compliant state; see :mod:`drystone.design.shaping.help_needed`. In each round scipy's SLSQP
    moves the variables within a region of trust. Contacts are then found anew, and the check
    decides.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    moves
        The variables, or what makes them of the model.
    options
    progress
    stop
        Asked between two evaluations; True ends with the best shape so far.

    Returns
    -------
    Shaped
        The best shape that stands; where none does, the one that needs least help.

    Raises
    ------
    InputError
        What was given cannot be made into a model, the moves are those of another model, a joint is
        curved, or a model that is to be made lighter does not stand.

    Examples
    --------
    >>> from drystone.design import shape, thickening
    >>> from drystone.models import arch
    >>> found = shape(arch(0.09, 8), lambda model: thickening(model, (0, 0, 0), 0.05), friction=0.8)
    >>> found.stands, round(0.09 + found.x[0], 2)
    (True, 0.1)
    """
    chosen = ShapeOptions.of(options)
    model = as_model(given, **how)
    variables = moves if isinstance(moves, Moves) else moves(model)
    count = sum(len(block.vertices) for block in model.assembly.blocks)
    if variables.matrix.shape[0] != 3 * count:
        raise InputError(
            f"the moves are of {variables.matrix.shape[0] // 3} vertices, the model has {count}",
            remedy="make the moves of this model",
        )
    return _Search(model, variables, chosen, progress, stop).run()


class _Stopped(Exception):
    """The search was asked to end."""


class _Search:
    """One search for a shape."""

    def __init__(
        self,
        model: Model,
        moves: Moves,
        options: ShapeOptions,
        progress: Progress | None,
        stop: Callable[[], bool] | None,
    ) -> None:
        self.model, self.moves, self.options = model, moves, options
        self.progress, self.stop = progress, stop
        self.bodies = Bodies.of(model.assembly)
        self.known: dict[bytes, tuple[float, Floats]] = {}
        self.forms: list[Form] = []

    def run(self) -> Shaped:
        options, moves = self.options, self.moves
        stand_only = options.aim is ShapeAim.STAND
        best, now = np.zeros(moves.count), self.model
        stands = self.stands(now)
        if stands and stand_only:
            return self.answer(best, now, 0, stands_already(options.margin))
        if not stands and not stand_only:
            raise InputError(
                "it does not stand as it is, at the margin that is asked for",
                remedy="shape it to stand first",
            )
        trust, rounds = options.trust, 0
        words = "the rounds were used up"
        try:
            for rounds in range(1, options.rounds + 1):
                self.tell(rounds)
                self.found_anew(now)
                before = self.objective(best)[0]
                target = self.step(best, trust)
                following, found = self.accepted(best, target, stand_only)
                if found is None:
                    trust *= 0.25
                    if trust < options.close:
                        words = "no smaller step leads further"
                        break
                    continue
                best, now = following, found
                gained = before - self.objective(best)[0]
                if stand_only and self.stands(now):
                    words = "it stands"
                    break
                if gained <= options.close * abs(before):
                    words = "the last round gained next to nothing"
                    break
        except _Stopped:
            words = "it was stopped"
        return self.answer(best, now, rounds, words)

    # -- one round ------------------------------------------------------------------------------
    def found_anew(self, model: Model) -> None:
        """The forms of the model in all its cases, with the contacts that it has now."""
        self.known.clear()
        self.forms = [Form.of(one) for one in (model, *self.options.margin.cases(model))]

    def step(self, x: Floats, trust: float) -> Floats:
        """Where the optimiser goes from variables (p,) within a region of trust."""
        most = self.moves.most
        low = np.maximum(x - trust * most, -most)
        high = np.minimum(x + trust * most, most)
        # in units of the largest moves, and about the size of the first value
        scale = max(abs(self.objective(x)[0]), np.finfo(float).tiny)

        def value(y: Floats) -> tuple[float, Floats]:
            found, gradient = self.objective(most * y)
            return found / scale, most * gradient / scale

        allowed = max(HELPED, 4.0 * self.help_at(x)[0])
        rows: list[Any] = []
        if self.options.aim is not ShapeAim.STAND:
            rows += [
                {
                    "type": "ineq",
                    "fun": lambda y: 1.0 - self.help_at(most * y)[0] / allowed,
                    "jac": lambda y: -most * self.help_at(most * y)[1] / allowed,
                }
            ]
        if self.options.least_edge > 0.0:
            rows += [
                {
                    "type": "ineq",
                    "fun": lambda y: self.edges(most * y)[0],
                    "jac": lambda y: self.edges(most * y)[1] * most,
                }
            ]
        found = minimize(
            value,
            x / most,
            jac=True,
            method="SLSQP",
            bounds=list(zip(low / most, high / most, strict=True)),
            constraints=rows,
            options={"maxiter": self.options.iterations, "ftol": 1e-9},
        )
        return np.clip(most * found.x, low, high)

    def accepted(self, x: Floats, target: Floats, stand_only: bool) -> tuple[Floats, Model | None]:
        """The farthest shape on the way to a target that may be kept: it stands, or needs less."""
        if np.array_equal(x, target):
            return x, None
        whole = self.made(target)
        if whole is not None and (stand_only or self.stands(whole)):
            return target, whole
        low, high, found = 0.0, 1.0, None
        while high - low > CLOSE:
            middle = 0.5 * (low + high)
            tried = self.made(x + middle * (target - x))
            if tried is not None and (stand_only or self.stands(tried)):
                low, found = middle, tried
            else:
                high = middle
        return x + low * (target - x), found

    def made(self, x: Floats) -> Model | None:
        """The model with variables (p,), its contacts found anew; ``None`` where it cannot be."""
        vertex = self.moves.moved(self.bodies.vertex, x)
        try:
            assembly = self.bodies.assembly_at(vertex)
            moved = {
                i: block
                for i, block in enumerate(assembly.blocks)
                if block is not self.model.assembly.blocks[i]
            }
            return changed(self.model, moved)
        except InputError:
            return None

    # -- values and gradients -------------------------------------------------------------------
    def objective(self, x: Floats) -> tuple[float, Floats]:
        """What is to be least, and its derivative (p,)."""
        aim = self.options.aim
        if aim is ShapeAim.STAND:
            value, gradient = self.help_at(x)
            return value, gradient
        vertex = self.moves.moved(self.bodies.vertex, x)
        if aim is ShapeAim.VOLUME:
            volume, _ = self.bodies.measures(vertex)
            by_vertex = self.bodies.measures_pulled_back(
                vertex, np.ones(len(volume)), np.zeros((len(volume), 3))
            )
            return float(volume.sum()), self.moves.pulled_back(by_vertex)
        block = int(self.model.assembly.indices([self.options.block])[0])
        own = self.bodies.owner == block
        by_vertex = np.where(own[:, None], -self.direction / own.sum(), 0.0)
        return float((by_vertex * vertex).sum()), self.moves.pulled_back(by_vertex)

    def edges(self, x: Floats) -> tuple[Floats, Floats]:
        """By how much the squares of moving edges (e,) are above that of the least; (e, p)."""
        vertex = self.moves.moved(self.bodies.vertex, x)
        i, j = self.moving.T
        along = (vertex[i] - vertex[j]) / self.options.least_edge
        slope = np.zeros((len(i), len(x)))
        for axis in range(3):
            both = self.moves.matrix[3 * i + axis] - self.moves.matrix[3 * j + axis]
            slope += 2.0 * along[:, axis, None] * both.toarray() / self.options.least_edge
        return (along**2).sum(axis=1) - 1.0, slope

    @cached_property
    def moving(self) -> Ints:
        """The edges (e, 2) of all blocks whose length changes with a variable."""
        matrix, starts = self.moves.matrix, self.bodies.start
        edges = np.concatenate(
            [
                starts[i] + edges_of(block.faces)
                for i, block in enumerate(self.model.assembly.blocks)
            ]
        )
        changes = np.zeros(len(edges), dtype=bool)
        for axis in range(3):
            both = matrix[3 * edges[:, 0] + axis] - matrix[3 * edges[:, 1] + axis]
            changes |= abs(both).max(axis=1).toarray().ravel() > 0.0
        return edges[changes]

    @property
    def direction(self) -> Floats:
        given = np.asarray(self.options.reach, dtype=np.float64)
        size = float(np.linalg.norm(given))
        if not 0.0 < size < np.inf:
            raise InputError("the direction of the reach has no length", remedy="give X,Y,Z")
        return given / size

    def help_at(self, x: Floats) -> tuple[float, Floats]:
        """Share of the load on the ground, over all cases, and its derivative (p,)."""
        if self.stop is not None and self.stop():
            raise _Stopped
        key = np.asarray(x).tobytes()
        if key not in self.known:
            vertex = self.moves.moved(self.bodies.vertex, x)
            both = [form.help_at(vertex) for form in self.forms]
            size = float(np.sqrt(sum(value for value, _ in both)))
            gradient = np.sum([one for _, one in both], axis=0) / (2.0 * max(size, 1e-30))
            self.known[key] = size, self.moves.pulled_back(gradient)
        return self.known[key]

    def stands(self, model: Model) -> bool:
        margin = self.options.margin
        options = CheckOptions(settle=not margin.robust)
        return all(
            margin.meets(check(one, options=options)) for one in (model, *margin.cases(model))
        )

    def tell(self, rounds: int) -> None:
        if self.progress is not None:
            self.progress("shaping", rounds - 1, self.options.rounds)

    def answer(self, x: Floats, model: Model, rounds: int, words: str) -> Shaped:
        result = self.options.margin.holds(model)
        stands = self.options.margin.meets(result)
        stop, self.stop = self.stop, None
        values = []
        for where, one in ((x, model), (np.zeros_like(x), self.model)):
            try:
                self.found_anew(one)
                value = self.objective(where)[0]
            except DrystoneError:
                value = float("nan")
            values.append(-value if self.options.aim is ShapeAim.REACH else value)
        self.stop = stop
        if not stands:
            words += ": it does not stand"
        return Shaped(self.model, model, x, result, stands, values[0], values[1], rounds, words)


__all__ = ["ShapeAim", "ShapeOptions", "Shaped", "shape"]
