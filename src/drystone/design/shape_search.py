"""The search for a shape: rounds of an optimiser within a region of trust, each one checked."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import minimize

from drystone.base.arrays import Floats
from drystone.base.errors import DrystoneError, InputError, counted
from drystone.base.progress import Progress, Stop, Stopped
from drystone.design.changed import Changed, Kept
from drystone.design.help_needed import GROUND
from drystone.design.mends import stands_already
from drystone.design.shape_options import MEASURES, HelpMeasure, ShapeAim, ShapeOptions
from drystone.design.shape_values import ShapeValues
from drystone.design.shape_variables import ShapeVariables
from drystone.model import Model
from drystone.results import Result

_HELPED = 1e-4
"""Share of the load on the ground up to which a shape is taken to stand in the first round; at
least four times that of the last shape that stands. Chosen: of three stacked bricks it leads within
0.1 % of the largest overhang. Both are reduced where a target falls. The check decides."""

_CLOSE = 2.0**-7
"""Share of a step to which the last shape that stands is bisected."""


_DRAWN = tuple(2.0**-power for power in range(13, 1, -3))
"""Shares of the way by which a target that falls is drawn back, chosen."""


_SOFT = 1e-2
"""Stiffness of the ground with which a structure that falls is shaped at first, chosen: the help
that it needs then changes smoothly with the shape. It is reduced where that leads no further."""


_AT_END = 0.999
"""A variable is at the end of its range from this share of its largest move on."""

KEPT = 0.1
"""Least length of an edge, by the shortest one as given, once blocks crossed themselves, chosen."""


class ShapeSearch(ShapeValues):
    """One search for a shape."""

    def __init__(
        self,
        model: Model,
        moves: ShapeVariables,
        options: ShapeOptions,
        progress: Progress | None,
        late: Stop,
    ) -> None:
        super().__init__(model, moves, options, late)
        self.progress = progress
        self.firmest: tuple[float, Floats] = np.inf, np.zeros(moves.count)

    def run(self, start: Floats | None = None) -> Changed:
        """The best shape, from variables (p,) that nearly stand; from zero when left out.

        A structure that falls is shaped on stiff ground first, and where that leads to nothing that
        stands, on weak ground from the beginning. Where blocks cross themselves on stiff ground,
        the search begins again, and edges keep a length from then on.
        """
        options = self.options
        rests = options.aim is ShapeAim.STAND and options.help is HelpMeasure.REST
        if not rests or start is not None:
            return self.followed(start, GROUND)
        best = self.followed(None, _SOFT)
        grounds = [GROUND]
        if self.crossed and self.least_edge == 0.0:
            self.least_edge = KEPT * self.shortest(self.bodies.vertex)
            grounds = [_SOFT, GROUND]
        for ground in grounds:
            if best.stands or self.late():
                break
            self.crossed = False
            found = self.followed(None, ground)
            best = found if found.stands or found.value < best.value else best
        return best

    def followed(self, start: Floats | None, ground: float) -> Changed:
        """The best shape with a stiffness of the ground at first."""
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
        trust, slack, rounds, centred = options.trust, 1.0, 0, False
        self.ground = ground
        words = "the rounds were used up"
        try:
            for rounds in range(1, options.rounds + 1):
                self.tell(rounds)
                self.found_anew(now, best)
                before = self.objective(best)[0]
                self.firmest = min(self.firmest, (self.help_at(best)[0], best), key=lambda p: p[0])
                target = self.step(best, trust, slack)
                share, place, found = self.accepted(best, target, before)
                if share < 0.5 and not stand_only:
                    wished = before - self.objective(target)[0]
                    if centred and wished <= options.close * abs(before):
                        words = "the next round would gain almost nothing"
                        break
                    if not centred:
                        centred = True
                        self.centre(best)
                        share = 0.5
                elif share > 0.5:
                    centred = False
                if self.crossed and self.ground > GROUND:
                    words = "blocks crossed themselves"
                    break
                gained = 0.0
                if found is not None:
                    best, now = place, found
                    if stand_only and self.options.margin.stands(now):
                        words = "it stands"
                        break
                    gained = before - self.objective(best)[0]
                if share != 0.5:
                    trust = min(2.0 * trust, options.trust) if share > 0.5 else 0.5 * trust
                slack *= 1.0 if share == 1.0 else 0.25
                far = share == 1.0 or (share > 0.5 and not stand_only)
                ends = far and gained <= options.close * abs(before)
                if self.ground > GROUND and (ends or trust < options.close):
                    self.ground, trust = 0.1 * self.ground, options.trust
                    continue
                if ends:
                    words = "the last round gained almost nothing"
                    break
                if trust < options.close:
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
        for share in (0.0, *_DRAWN):
            place = x + share * (inner - x)
            model = self.made(place) if share else now
            if model is not None and margin.meets(margin.holds(model)):
                return place, model
        return x, now

    def centre(self, x: Floats) -> None:
        """Take the shape near variables (p,) that needs least help as the firmest, if it stands."""
        place = self.step(x, self.options.trust, None)
        model = self.made(place)
        if model is not None and self.options.margin.stands(model):
            self.firmest = min(self.firmest, (self.help_at(place)[0], place), key=lambda p: p[0])

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
        for share in () if stand_only else _DRAWN:
            place = target + share * (inner - target)
            if self.objective(place)[0] >= before:
                break
            found = kept(place)
            if found is not None:
                return 1.0 - share, place, found
        low, high, found = 0.0, 1.0, None
        while high - low > (0.25 if stand_only else _CLOSE):
            middle = 0.5 * (low + high)
            tried = kept(x + middle * (target - x))
            if tried is not None:
                low, found = middle, tried
            else:
                high = middle
        return low, x + low * (target - x), found

    def tell(self, rounds: int) -> None:
        """Report the progress."""
        if self.progress is not None:
            self.progress("shaping", rounds - 1, self.options.rounds)

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
        moved = 1e3 * float(abs(x).max(initial=0.0))
        words = f"{counted(len(x), 'variable')}: vertices moved by up to {moved:.1f} mm"
        value, first = values
        told = f"{MEASURES[self.options.aim]} {value:.4g}, {first:.4g} before"
        names = tuple(model.assembly.names)
        kept = (Kept("shape", names, words, value),) if x.any() else ()
        return Changed(
            self.model, model, result, self.options.margin.meets(result), words, kept,
            (told, message), x, value, first, rounds,
        )  # fmt: skip
