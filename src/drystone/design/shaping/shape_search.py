"""The search for a shape: rounds of an optimiser within a region of trust, each one checked."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import minimize

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import DrystoneError, InputError
from drystone.base.progress import Progress, Stop
from drystone.design.mends.mends import stands_already
from drystone.design.shaping.help_needed import Form
from drystone.design.shaping.shape_options import ShapeAim, Shaped, ShapeOptions
from drystone.design.shaping.variables import ShapeVariables
from drystone.design.shaping.vertex_measures import Bodies
from drystone.design.surgery.changed_model import changed
from drystone.geometry.body.polyhedron import edges_of
from drystone.model import Model

HELPED = 1e-4
"""Share of the load on the ground up to which a shape is taken to stand during the search; at least
four times that of the shape that stands. Chosen: of three stacked bricks it leads within 0.1 % of
the largest overhang. The check decides."""

CLOSE = 2.0**-7
"""Share of a step to which the last shape that stands is bisected."""


class Stopped(Exception):
    """The search was asked to end."""


class ShapeSearch:
    """One search for a shape."""

    def __init__(
        self,
        model: Model,
        moves: ShapeVariables,
        options: ShapeOptions,
        progress: Progress | None,
        late: Stop,
    ) -> None:
        self.model, self.moves, self.options = model, moves, options
        self.progress, self.late = progress, late
        self.bodies = Bodies.of(model.assembly)
        self.known: dict[bytes, tuple[float, Floats]] = {}
        self.forms: list[Form] = []

    def run(self, start: Floats | None = None) -> Shaped:
        """The best shape, from variables (p,) to start with; zero when left out."""
        options, moves = self.options, self.moves
        stand_only = options.aim is ShapeAim.STAND
        best = np.zeros(moves.count) if start is None else start
        now = self.model if start is None else self.made(start) or self.model
        stands = self.options.margin.stands(now)
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
                        words = "no smaller step improves it"
                        break
                    continue
                best, now = following, found
                gained = before - self.objective(best)[0]
                if stand_only and self.options.margin.stands(now):
                    words = "it stands"
                    break
                if gained <= options.close * abs(before):
                    words = "the last round gained almost nothing"
                    break
        except Stopped:
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
        """The farthest shape towards a target that may be kept: it stands, or needs less."""
        if np.array_equal(x, target):
            return x, None
        whole = self.made(target)
        if whole is not None and (stand_only or self.options.margin.stands(whole)):
            return target, whole
        low, high, found = 0.0, 1.0, None
        while high - low > CLOSE:
            middle = 0.5 * (low + high)
            tried = self.made(x + middle * (target - x))
            if tried is not None and (stand_only or self.options.margin.stands(tried)):
                low, found = middle, tried
            else:
                high = middle
        return x + low * (target - x), found

    def made(self, x: Floats) -> Model | None:
        """The model with variables (p,), its contacts found anew; ``None`` where it cannot be."""
        try:
            vertex = self.moves.moved(self.bodies.vertex, x)
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
            return float(volume.sum()), self.pulled_back(x, by_vertex)
        block = int(self.model.assembly.indices([self.options.block])[0])
        own = self.bodies.owner == block
        by_vertex = np.where(own[:, None], -self.direction / own.sum(), 0.0)
        return float((by_vertex * vertex).sum()), self.pulled_back(x, by_vertex)

    def pulled_back(self, x: Floats, by_vertex: Floats) -> Floats:
        """The derivative (p,) by the variables, from that by the vertices (v, 3)."""
        out: Floats = self.moves.matrix_at(x).T @ by_vertex.ravel()
        return out

    def edges(self, x: Floats) -> tuple[Floats, Floats]:
        """By how much the squares of moving edges (e,) are above that of the least; (e, p)."""
        vertex = self.moves.moved(self.bodies.vertex, x)
        i, j = self.moving.T
        matrix = self.moves.matrix_at(x)
        along = (vertex[i] - vertex[j]) / self.options.least_edge
        slope = np.zeros((len(i), len(x)))
        for axis in range(3):
            both = matrix[3 * i + axis] - matrix[3 * j + axis]
            slope += 2.0 * along[:, axis, None] * both.toarray() / self.options.least_edge
        return (along**2).sum(axis=1) - 1.0, slope

    @cached_property
    def moving(self) -> Ints:
        """The edges (e, 2) of all blocks whose length changes with a variable."""
        matrix, starts = self.moves.matrix_at(np.zeros(self.moves.count)), self.bodies.start
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
        """Of the farthest reach (3,), unit."""
        given = np.asarray(self.options.reach, dtype=np.float64)
        size = float(np.linalg.norm(given))
        if not 0.0 < size < np.inf:
            raise InputError("the direction of the reach has no length", remedy="give X,Y,Z")
        return given / size

    def help_at(self, x: Floats) -> tuple[float, Floats]:
        """Share of the load on the ground, over all cases, and its derivative (p,)."""
        if self.late():
            raise Stopped
        key = np.asarray(x).tobytes()
        if key not in self.known:
            vertex = self.moves.moved(self.bodies.vertex, x)
            both = [form.help_at(vertex) for form in self.forms]
            size = float(np.sqrt(sum(value for value, _ in both)))
            gradient = np.sum([one for _, one in both], axis=0) / (2.0 * max(size, 1e-30))
            self.known[key] = size, self.pulled_back(x, gradient)
        return self.known[key]

    def tell(self, rounds: int) -> None:
        """Report the progress."""
        if self.progress is not None:
            self.progress("shaping", rounds - 1, self.options.rounds)

    def answer(self, x: Floats, model: Model, rounds: int, words: str) -> Shaped:
        """What was found, checked in full."""
        result = self.options.margin.holds(model)
        stands = self.options.margin.meets(result)
        late, self.late = self.late, bool
        values = []
        for where, one in ((x, model), (np.zeros_like(x), self.model)):
            try:
                self.found_anew(one)
                value = self.objective(where)[0]
            except DrystoneError:
                value = float("nan")
            values.append(-value if self.options.aim is ShapeAim.REACH else value)
        self.late = late
        if not stands:
            words += ": it does not stand"
        return Shaped(self.model, model, result, stands, rounds, words, x, *values)


__all__ = ["ShapeSearch", "Stopped"]
