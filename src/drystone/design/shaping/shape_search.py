"""The search for a shape: rounds of an optimiser within a region of trust, each one checked."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import minimize

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import DrystoneError, InputError
from drystone.base.progress import Progress
from drystone.design.mends.mends import stands_already
from drystone.design.shaping.help_needed import Form
from drystone.design.shaping.shape_options import ShapeAim, Shaped, ShapeOptions
from drystone.design.shaping.variables import ShapeVariables
from drystone.design.shaping.vertex_measures import Bodies
from drystone.design.surgery.changed_model import changed
from drystone.geometry.body.polyhedron import edges_of
from drystone.model import Model

HELPED = 1e-4
"""Share of the load on the ground up to which a shape is taken to stand in the first round; at
least that of the last shape that stands. Chosen: of three stacked bricks it leads within 0.1 % of
the largest overhang. It is reduced where the target falls. The check decides."""

CLOSE = 2.0**-7
"""Share of a step to which the last shape that stands is bisected."""


DRAWN = tuple(2.0**-power for power in range(13, 1, -3))
"""Shares of the way by which a target that falls is drawn back, chosen."""

ENOUGH = 1e-4
"""The search ends where a target that was drawn back gains less than this share, chosen."""


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
        stop: Callable[[], bool] | None,
    ) -> None:
        self.model, self.moves, self.options = model, moves, options
        self.progress, self.stop = progress, stop
        self.bodies = Bodies.of(model.assembly)
        self.known: dict[bytes, tuple[float, Floats]] = {}
        self.forms: list[Form] = []
        self.firmest: tuple[float, Floats] = np.inf, np.zeros(moves.count)

    def run(self, start: Floats | None = None) -> Shaped:
        """The best shape, from variables (p,) to start with; zero when left out."""
        options, moves = self.options, self.moves
        stand_only = options.aim is ShapeAim.STAND
        best = np.zeros(moves.count) if start is None else start
        now = self.model if start is None else self.made(start) or self.model
        stands = self.options.margin.stands(now)
        if stands and stand_only:
            offer = f"{stands_already(options.margin)}, or for the least volume"
            return self.answer(best, now, 0, offer)
        if not stands and not stand_only:
            raise InputError(
                "it does not stand as it is, at the margin that is asked for",
                remedy="shape it to stand first",
            )
        trust, allowed, rounds = options.trust, HELPED, 0
        words = "the rounds were used up"
        try:
            for rounds in range(1, options.rounds + 1):
                self.tell(rounds)
                self.found_anew(now, best)
                before = self.objective(best)[0]
                self.firmest = min(self.firmest, (self.help_at(best)[0], best), key=lambda p: p[0])
                target = self.step(best, trust, allowed)
                share, place, found = self.accepted(best, target, before)
                gained = 0.0
                if found is not None:
                    best, now = place, found
                    if stand_only and self.options.margin.stands(now):
                        words = "it stands"
                        break
                    gained = before - self.objective(best)[0]
                if share == 1.0 and gained <= options.close * abs(before):
                    words = "the last round gained almost nothing"
                    break
                trust = min(2.0 * trust, options.trust) if share > 0.5 else 0.5 * trust
                allowed *= 1.0 if share == 1.0 else 0.25
                drawn = share > 0.5 and not stand_only
                if trust < options.close or (drawn and gained <= ENOUGH * abs(before)):
                    words = "no smaller step leads further"
                    break
        except Stopped:
            words = "it was stopped"
        if not stand_only:
            best, now = self.confirmed(best, now)
        return self.answer(best, now, rounds, words)

    def confirmed(self, x: Floats, now: Model) -> tuple[Floats, Model]:
        """The shape, or one nearer to the firmest, that stands by the check with settlement.

        Where hardly anything presses on some blocks at first, as between vertical joints, rest
        states are not enough.
        """
        margin, inner = self.options.margin, self.firmest[1]
        for share in (0.0, *DRAWN):
            place = x + share * (inner - x)
            model = self.made(place) if share else now
            if model is not None and margin.meets(margin.holds(model)):
                return place, model
        return x, now

    # -- one round ------------------------------------------------------------------------------
    def found_anew(self, model: Model, x: Floats) -> None:
        """The forms of the model with variables (p,), in all its cases, with its contacts now.

        From here on vertices are followed along their tangents.
        """
        self.known.clear()
        self.forms = [Form.of(one) for one in (model, *self.options.margin.cases(model))]
        self.at, self.here = x, self.moves.moved(self.bodies.vertex, x)
        self.matrix = self.moves.matrix_at(x)

    def vertices(self, x: Floats) -> Floats:
        """The vertices (v, 3) with variables (p,), along their tangents."""
        out: Floats = self.here + (self.matrix @ (x - self.at)).reshape(-1, 3)
        return out

    def step(self, x: Floats, trust: float, allowed: float) -> Floats:
        """Where the optimiser goes from variables (p,) within a region of trust.

        Parameters
        ----------
        x : (p,)
        trust
            Largest change of a variable, by its largest move.
        allowed
            Share of the load on the ground up to which a shape is taken to stand.
        """
        most = self.moves.most
        low = np.maximum(x - trust * most, -most)
        high = np.minimum(x + trust * most, most)
        # in units of the largest moves, and about the size of the first value
        scale = max(abs(self.objective(x)[0]), np.finfo(float).tiny)

        def value(y: Floats) -> tuple[float, Floats]:
            found, gradient = self.objective(most * y)
            return found / scale, most * gradient / scale

        allowed = max(allowed, self.help_at(x)[0])
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

    def accepted(
        self, x: Floats, target: Floats, before: float
    ) -> tuple[float, Floats, Model | None]:
        """How far of the way to a target the shape may be kept, its variables, and the model there.

        It may be kept where it stands; of a structure that is to stand, where it needs less help
        than ``before`` with its contacts found anew. A target that falls is drawn back towards the
        shape that needed least help, as long as that leads further than ``x``, else towards ``x``.
        """
        if np.array_equal(x, target):
            return 1.0, x, None
        stand_only = self.options.aim is ShapeAim.STAND

        def kept(place: Floats) -> Model | None:
            model = self.made(place)
            if model is None:
                return None
            if not stand_only:
                return model if self.options.margin.stands(model) else None
            self.found_anew(model, place)
            return model if self.help_at(place)[0] < before else None

        whole = kept(target)
        if whole is not None:
            return 1.0, target, whole
        inner = self.firmest[1]
        for share in () if stand_only else DRAWN:
            place = target + share * (inner - target)
            if self.objective(place)[0] >= before:
                break
            found = kept(place)
            if found is not None:
                return 1.0 - share, place, found
        low, high, found = 0.0, 1.0, None
        while high - low > (0.25 if stand_only else CLOSE):
            middle = 0.5 * (low + high)
            tried = kept(x + middle * (target - x))
            if tried is not None:
                low, found = middle, tried
            else:
                high = middle
        return low, x + low * (target - x), found

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
        vertex = self.vertices(x)
        if aim is ShapeAim.VOLUME:
            volume, _ = self.bodies.measures(vertex)
            by_vertex = self.bodies.measures_pulled_back(
                vertex, np.ones(len(volume)), np.zeros((len(volume), 3))
            )
            return float(volume.sum()), self.pulled_back(by_vertex)
        block = int(self.model.assembly.indices([self.options.block])[0])
        own = self.bodies.owner == block
        by_vertex = np.where(own[:, None], -self.direction / own.sum(), 0.0)
        return float((by_vertex * vertex).sum()), self.pulled_back(by_vertex)

    def pulled_back(self, by_vertex: Floats) -> Floats:
        """The derivative (p,) by the variables, from that by the vertices (v, 3)."""
        out: Floats = self.matrix.T @ by_vertex.ravel()
        return out

    def edges(self, x: Floats) -> tuple[Floats, Floats]:
        """By how much the squares of moving edges (e,) are above that of the least; (e, p)."""
        vertex, matrix = self.vertices(x), self.matrix
        i, j = self.moving.T
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
        if self.stop is not None and self.stop():
            raise Stopped
        key = np.asarray(x).tobytes()
        if key not in self.known:
            vertex = self.vertices(x)
            both = [form.help_at(vertex) for form in self.forms]
            size = float(np.sqrt(sum(value for value, _ in both)))
            gradient = np.sum([one for _, one in both], axis=0) / (2.0 * max(size, 1e-30))
            self.known[key] = size, self.pulled_back(gradient)
        return self.known[key]

    def tell(self, rounds: int) -> None:
        """Report the progress."""
        if self.progress is not None:
            self.progress("shaping", rounds - 1, self.options.rounds)

    def answer(self, x: Floats, model: Model, rounds: int, words: str) -> Shaped:
        """What was found, checked in full."""
        result = self.options.margin.holds(model)
        stands = self.options.margin.meets(result)
        stop, self.stop = self.stop, None
        values = []
        for where, one in ((x, model), (np.zeros_like(x), self.model)):
            try:
                self.found_anew(one, where)
                value = self.objective(where)[0]
            except DrystoneError:
                value = float("nan")
            values.append(-value if self.options.aim is ShapeAim.REACH else value)
        self.stop = stop
        if not stands:
            words += ": it does not stand"
        return Shaped(self.model, model, x, result, stands, values[0], values[1], rounds, words)


__all__ = ["ShapeSearch", "Stopped"]
