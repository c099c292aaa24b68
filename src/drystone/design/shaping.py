"""Vertices moved by gradient until a structure stands, weighs least, or reaches farthest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Unpack

import numpy as np

from drystone.base.arrays import ROUNDING, Floats, of_type
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Stopped
from drystone.base.settings import checked_call
from drystone.design.changed import Changed
from drystone.design.needs import GROUND
from drystone.design.search import bracket
from drystone.design.shape_search import USED_UP, ShapeSearch, ended, farthest
from drystone.design.shape_values import ShapeAim, ShapeOptions, ShapeVariables
from drystone.io.opening import Given, LongHow, as_model
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


FIRST, CLOSE = 1.0, 0.1
"""[degrees] The first step of the tilt, and the smallest one; chosen."""

_STEEPEST = 89.0
"""[degrees] Largest tilt that is asked for."""


@checked_call
def shape(
    given: Given,
    moves: ShapeVariables | Callable[[Model], ShapeVariables],
    *,
    options: ShapeOptions | None = None,
    **how: Unpack[LongHow],
) -> Changed:
    """Move vertices until a structure stands, or to the best shape that stands.

    The help that it needs, and its derivative by all variables (one more solve), come from the
    compliant state; see ``drystone.design.needs``. In each round scipy's SLSQP
    moves the variables within a region of trust. Contacts are then found anew, and the check
    decides. Each round needs the one before, so an ``executor`` has nothing to share.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    moves
        The variables, or what makes them of the model: :func:`free_vertices`, :func:`thickening`,
        :func:`block_moves`, or :class:`FamilyMoves` of a parametric family.
    options

    Returns
    -------
    Changed
        The best shape that stands; where none does, the one that needs least help.

    Raises
    ------
    InputError
        What was given cannot be made into a model, the moves are those of another model, a joint is
        curved, an edge is shorter than the least, or a model that is to be made lighter does not
        stand.

    Examples
    --------
    >>> from drystone.design import shape, thickening
    >>> from drystone.models import arch
    >>> found = shape(arch(0.09, 8), lambda model: thickening(model, (0, 0, 0), 0.05), friction=0.8)
    >>> found.stands, round(0.09 + float(found.x[0]), 2)
    (True, 0.1)
    """
    chosen = ShapeOptions.of(options)
    clock = Clock.of(how)
    model = as_model(given, **how)
    made = moves(model) if callable(moves) else moves
    variables = of_type(made, ShapeVariables, "moves", "give block_moves(...)")  # type: ignore[type-abstract]
    vertex = model.assembly.faces.point
    here = variables.moved(vertex, np.zeros(variables.count))
    if np.abs(here - vertex).max() > ROUNDING * float(np.ptp(vertex, axis=0).max()):
        raise InputError(
            "the values that the family starts with are not those of the model",
            remedy="build the model with them",
        )
    stand_only = chosen.aim in (ShapeAim.STAND, ShapeAim.TILT)
    kind = ShapeSearch if stand_only else BestShapeSearch
    search = kind(model, variables, chosen, clock)
    shortest = search.shortest(vertex)
    if shortest < chosen.least_edge:
        raise InputError(
            f"an edge that moves is {shortest:.4g} m long already, shorter than the least of "
            f"{chosen.least_edge:.4g} m",
            remedy=f"give a least edge of {shortest:.4g} m or less",
        )
    return _raise_tilt(search) if chosen.aim is ShapeAim.TILT else search.run()


def _raise_tilt(search: ShapeSearch) -> Changed:
    """Shape a structure to stand at a tilt, then at a larger one, until no larger one is reached.

    Each shape starts from the last one that stands. The step is doubled after each success, and
    halved after each failure.

    Raises
    ------
    InputError
        It does not stand without a tilt.
    """
    x, now = np.zeros(search.moves.count), search.model
    if not _stands(search, now, 0.0):
        raise InputError(
            "it does not stand as it is, at the margin that is asked for",
            remedy="shape it to stand first",
        )
    first = tilt = _largest(search, now)
    step, rounds, words = FIRST, 0, "no larger tilt was reached"
    while step >= CLOSE:
        if search.late():
            words = "it was stopped"
            break
        wanted = min(tilt + step, _STEEPEST)
        found = _at(search, wanted).run(x)
        rounds += found.rounds
        if not found.stands:
            step *= 0.5
            continue
        x, now, tilt = found.x, found.model, wanted
        if tilt == _STEEPEST:
            words = f"stands at {_STEEPEST:g} degrees, and no more was tried"
            break
        step *= 2.0
    result = replace(search.options.margin, tilt=tilt).holds(now)
    words = f"stands tilted by {tilt:.1f} degrees, {first:.1f} before; {words}"
    return search.shaped(x, now, result, (tilt, first), rounds, words)


def _at(search: ShapeSearch, tilt: float) -> ShapeSearch:
    """A search for a shape that stands at a tilt [degrees]."""
    margin = replace(search.options.margin, tilt=tilt)
    options = replace(search.options, aim=ShapeAim.STAND, margin=margin)
    return ShapeSearch(search.model, search.moves, options, search.clock)


def _stands(search: ShapeSearch, model: Model, tilt: float) -> bool:
    return replace(search.options.margin, tilt=tilt).stands(model)


def _largest(search: ShapeSearch, model: Model) -> float:
    """The largest tilt [degrees] to each side at which a model stands, to :data:`CLOSE`."""
    low, high = 0.0, FIRST
    while high < _STEEPEST and _stands(search, model, high):
        low, high = high, 2.0 * high
    high = min(high, _STEEPEST)
    return bracket(lambda tilt: not _stands(search, model, tilt), low, high, CLOSE)[0]
