"""The search for a shape: rounds of an optimiser within a region of trust, each one checked."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import minimize

from drystone.base.arrays import Floats, lengths
from drystone.base.errors import DrystoneError, counted
from drystone.base.progress import Clock, Stopped
from drystone.design.changed import Changed, Kept
from drystone.design.mends import stands_already
from drystone.design.needs import GROUND
from drystone.design.search import bracket
from drystone.design.shape_values import (
    MEASURES,
    ShapeAim,
    ShapeOptions,
    ShapeValues,
    ShapeVariables,
)
from drystone.model import Model
from drystone.results import Result

_HELPED = 1e-4
"""Share of the load on the ground up to which a shape is taken to stand in the first round; at
least four times that of the last shape that stands. Chosen: of three stacked bricks it leads within
0.1 % of the largest overhang. Both are reduced where a target falls. The check decides."""

_SOFT = 1e-2
"""Stiffness of the ground with which a structure that falls is shaped at first, chosen: the help
that it needs then changes smoothly with the shape. It is reduced where that leads no further."""


_AT_END = 0.999
"""A variable is at the end of its range from this share of its largest move on."""

KEPT = 0.1
"""Least length of an edge, by the shortest one as given, once blocks crossed themselves, chosen."""

USED_UP = "the rounds were used up"


class ShapeSearch(ShapeValues):
    """The search for a shape that stands."""

    def __init__(
        self, model: Model, moves: ShapeVariables, options: ShapeOptions, clock: Clock
    ) -> None:
        super().__init__(model, moves, options, clock.late)
        self.clock = clock

    def run(self, start: Floats | None = None) -> Changed:
        """The best shape, from variables (p,) that nearly stand; from zero when left out.

        A structure that falls is shaped on stiff ground first, and where that leads to nothing that
        stands, on weak ground from the beginning. Where blocks cross themselves on stiff ground,
        the search begins again, and edges keep a length from then on.
        """
        if start is not None:
            return self.made_to_stand(start, GROUND)
        none = np.zeros(self.moves.count)
        best = self.made_to_stand(none, _SOFT)
        grounds = [GROUND]
        if self.crossed and self.least_edge == 0.0:
            self.least_edge = KEPT * self.shortest(self.bodies.vertex)
            grounds = [_SOFT, GROUND]
        for ground in grounds:
            if best.stands or self.late():
                break
            self.crossed = False
            found = self.made_to_stand(none, ground)
            best = found if found.stands or found.value < best.value else best
        return best

    def made_to_stand(self, x: Floats, ground: float) -> Changed:
        """A shape that stands, else the one that needs least help.

        Parameters
        ----------
        x : (p,)
        ground
            Its stiffness at first.
        """
        options = self.options
        made = self.made(x) if x.any() else None
        now = self.model if made is None else made
        if options.margin.stands(now):
            offer = f"{stands_already(options.margin)}, or for the least volume"
            return self.answer(x, now, 0, offer)
        trust, rounds, words = options.trust, 0, USED_UP
        self.ground = ground
        try:
            for rounds in range(1, options.rounds + 1):
                self.clock.tell("shaping", rounds - 1, options.rounds)
                self.found_anew(now, x)
                before = self.objective(x)[0]
                share, place, found = self.needs_less(x, self.step(x, trust, 1.0), before)
                if self.crossed and self.ground > GROUND:
                    words = "blocks crossed themselves"
                    break
                if found is not None:
                    x, now = place, found
                    if options.margin.stands(now):
                        words = "it stands"
                        break
                gained = 0.0 if found is None else before - self.objective(x)[0]
                ends = share == 1.0 and gained <= options.close * abs(before)
                trust = self.trusted(trust, share)
                if self.ground > GROUND and (ends or trust < options.close):
                    self.ground, trust = 0.1 * self.ground, options.trust
                elif ends or trust < options.close:
                    words = ended(ends)
                    break
        except Stopped:
            words = "it was stopped"
        return self.answer(x, now, rounds, words)

    def needs_less(
        self, x: Floats, target: Floats, before: float
    ) -> tuple[float, Floats, Model | None]:
        """How far of the way to a target less help is needed than before, with contacts found anew.

        The variables and the model there come with it.
        """

        def kept(place: Floats) -> Model | None:
            model = self.made(place)
            if model is None:
                return None
            self.found_anew(model, place)
            return model if self.help_at(place)[0] < before else None

        return farthest(x, target, kept, 0.25)

    def trusted(self, trust: float, share: float) -> float:
        """The next largest change of a variable, after a share of the way was gone."""
        if share == 0.5:
            return trust
        return min(2.0 * trust, self.options.trust) if share > 0.5 else 0.5 * trust

    def step(self, x: Floats, trust: float, slack: float | None) -> Floats:
        """Where the optimiser goes from variables (p,) within a region of trust.

        Parameters
        ----------
        x : (p,)
        trust
            Largest change of a variable, by its largest move.
        slack
            How much more help than at ``x`` is allowed: 1 in the first round, less where targets
            fell. Left out, the help is what is to be least.
        """
        aim = self.help_at if slack is None else self.objective
        most = self.moves.most
        low = np.maximum(x - trust * most, -most)
        high = np.minimum(x + trust * most, most)
        # in units of the largest moves, and about the size of the first value
        scale = max(abs(aim(x)[0]), np.finfo(float).tiny)

        def value(y: Floats) -> tuple[float, Floats]:
            found, gradient = aim(most * y)
            return found / scale, most * gradient / scale

        rows: list[Any] = []
        if slack is not None and self.options.aim is not ShapeAim.STAND:
            allowed = max(slack * _HELPED, (1.0 + 3.0 * slack) * self.help_at(x)[0])
            rows += [
                {
                    "type": "ineq",
                    "fun": lambda y: 1.0 - self.help_at(most * y)[0] / allowed,
                    "jac": lambda y: -most * self.help_at(most * y)[1] / allowed,
                }
            ]
        if self.least_edge > 0.0:
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

    def answer(self, x: Floats, model: Model, rounds: int, words: str) -> Changed:
        """What was found, checked in full."""
        result = self.options.margin.holds(model)
        stands = self.options.margin.meets(result)
        late, self.late, self.ground = self.late, bool, GROUND
        values = []
        for where, one in ((x, model), (np.zeros_like(x), self.model)):
            try:
                self.found_anew(one, where)
                value = self.objective(where)[0]
            except DrystoneError:
                value = float("nan")
            values.append(-value if self.options.aim is ShapeAim.REACH else value)
        self.late = late
        if not stands:
            words += ": it does not stand"
            ends = int((np.abs(x) > _AT_END * self.moves.most).sum())
            if ends:
                words += f", with {counted(ends, 'move')} of {len(x)} as large as allowed: "
                words += "larger ones may help"
        return self.shaped(x, model, result, (values[0], values[1]), rounds, words)

    def shaped(
        self,
        x: Floats,
        model: Model,
        result: Result,
        values: tuple[float, float],
        rounds: int,
        message: str,
    ) -> Changed:
        """The answer with a shape; ``values`` of it and of the model as given."""
        pairs = list(zip(self.model.assembly.blocks, model.assembly.blocks, strict=True))
        far = [float(lengths(new.vertices - old.vertices).max()) for old, new in pairs]
        moved = 1e3 * max(far)
        words = f"{counted(len(x), 'variable')}: vertices moved by up to {moved:.1f} mm"
        value, first = values
        told = f"{MEASURES[self.options.aim]} {value:.4g}, {first:.4g} before"
        names = tuple(np.array(model.assembly.names)[np.array(far) > 0.0].tolist())
        kept = (Kept("shape", names, words, value),) if x.any() else ()
        return Changed(
            self.model, model, result, self.options.margin.meets(result), words, kept,
            (told, message), x, value, first, rounds,
        )  # fmt: skip


def farthest(
    x: Floats,
    target: Floats,
    kept: Callable[[Floats], Model | None],
    width: float,
    *,
    fell: bool = False,
) -> tuple[float, Floats, Model | None]:
    """The share of the way to a target up to which a shape is kept, its variables, and its model.

    ``fell`` says that the target itself is known not to be kept.
    """
    if np.array_equal(x, target):
        return 1.0, x, None
    found: dict[float, Model | None] = {}

    def falls(share: float) -> bool:
        found[share] = kept(x + share * (target - x))
        return found[share] is None

    if not fell and not falls(1.0):
        return 1.0, target, found[1.0]
    share, _ = bracket(falls, 0.0, 1.0, width)
    return share, x + share * (target - x), found.get(share)


def ended(ends: bool) -> str:
    """Why a search ends: the last step led to its end, or no step leads further."""
    if ends:
        return "the last round gained almost nothing"
    return "no smaller step leads further"
