"""The search for the lightest or farthest shape that stands."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.base.progress import Stopped
from drystone.design.changed import Changed
from drystone.design.help_needed import GROUND
from drystone.design.shape_search import USED_UP, ShapeSearch, ended, farthest
from drystone.model import Model

_CLOSE = 2.0**-7
"""Share of a step to which the last shape that stands is bisected."""

_DRAWN = tuple(2.0**-power for power in range(13, 1, -3))
"""Shares of the way by which a target that falls is drawn back, chosen."""


class BestShapeSearch(ShapeSearch):
    """The search for the best shape among those that stand.

    Attributes
    ----------
    firmest
        The help that is needed, and the variables (p,), of the shape that needs least.
    """

    firmest: tuple[float, Floats]

    def run(self, start: Floats | None = None) -> Changed:
        """The best shape that stands, from that of the model as given."""
        del start
        self.firmest = np.inf, np.zeros(self.moves.count)
        options, now, x = self.options, self.model, np.zeros(self.moves.count)
        if not options.margin.stands(now):
            raise InputError(
                "it does not stand as it is, at the margin that is asked for",
                remedy="shape it to stand first",
            )
        trust, slack, rounds, centred, words = options.trust, 1.0, 0, False, USED_UP
        self.ground = GROUND
        try:
            for rounds in range(1, options.rounds + 1):
                self.clock.tell("shaping", rounds - 1, options.rounds)
                self.found_anew(now, x)
                before = self.objective(x)[0]
                enough = options.close * abs(before)
                self.seen(x)
                target = self.step(x, trust, slack)
                share, place, found = self.still_stands(x, target, before)
                if share < 0.5 and centred and before - self.objective(target)[0] <= enough:
                    words = "the next round would gain almost nothing"
                    break
                if share < 0.5 and not centred:
                    centred, share = True, 0.5
                    self.centre(x)
                elif share > 0.5:
                    centred = False
                if found is not None:
                    x, now = place, found
                gained = 0.0 if found is None else before - self.objective(x)[0]
                trust = self.trusted(trust, share)
                slack *= 1.0 if share == 1.0 else 0.25
                ends = share > 0.5 and gained <= enough
                if ends or trust < options.close:
                    words = ended(ends)
                    break
        except Stopped:
            words = "it was stopped"
        return self.answer(*self.confirmed(x, now), rounds, words)

    def still_stands(
        self, x: Floats, target: Floats, before: float
    ) -> tuple[float, Floats, Model | None]:
        """How far of the way to a target the shape stands, its variables, and the model there.

        A target that falls is drawn back towards the shape that needed least help, as long as that
        leads further than ``x``, else towards ``x``.
        """

        def kept(place: Floats) -> Model | None:
            model = self.made(place)
            return model if model is not None and self.options.margin.stands(model) else None

        whole = None if np.array_equal(x, target) else kept(target)
        if whole is not None or np.array_equal(x, target):
            return 1.0, target, whole
        for share in _DRAWN:
            place = target + share * (self.firmest[1] - target)
            if self.objective(place)[0] >= before:
                break
            found = kept(place)
            if found is not None:
                return 1.0 - share, place, found
        return farthest(x, target, kept, _CLOSE, fell=True)

    def seen(self, x: Floats) -> None:
        """Keep a shape that stands as the firmest if none needed less help."""
        self.firmest = min(self.firmest, (self.help_at(x)[0], x), key=lambda p: p[0])

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
            self.seen(place)
