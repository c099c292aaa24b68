"""Vertices moved by gradient until a structure stands, weighs least, or reaches farthest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Unpack

import numpy as np

from drystone.base.arrays import ROUNDING, Floats, lengths, of_type
from drystone.base.errors import DrystoneError, InputError, counted
from drystone.base.settings import Clock, Stopped, checked_call
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
from drystone.io.opening import Given, LongHow, as_model
from drystone.model import Model

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

    def run(self) -> Changed:
        """The best shape.

        A structure that falls is shaped on stiff ground first, and where that leads to nothing that
        stands, on weak ground from the beginning. Where blocks cross themselves on stiff ground,
        the search begins again, and edges keep a length from then on.
        """
        best = self.made_to_stand(_SOFT)
        grounds = [GROUND]
        if self.crossed and self.least_edge == 0.0:
            self.least_edge = KEPT * self.shortest(self.bodies.vertex)
            grounds = [_SOFT, GROUND]
        for ground in grounds:
            if best.stands or self.late():
                break
            self.crossed = False
            found = self.made_to_stand(ground)
            best = found if found.stands or found.value < best.value else best
        return best

    def made_to_stand(self, ground: float) -> Changed:
        """A shape that stands, else that with the least help, on ground as stiff as this first."""
        options, now, x = self.options, self.model, np.zeros(self.moves.count)
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
        from scipy.optimize import minimize  # slow to import

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
                words += f"larger ones may help: --most above {self.moves.most.max():.3g}"
        pairs = list(zip(self.model.assembly.blocks, model.assembly.blocks, strict=True))
        far = [float(lengths(new.vertices - old.vertices).max()) for old, new in pairs]
        moved = 1e3 * max(far)
        moved_words = f"{counted(len(x), 'variable')}: vertices moved by up to {moved:.1f} mm"
        value, first = values
        told = f"{MEASURES[self.options.aim]} {value:.4g}, {first:.4g} before"
        names = tuple(np.array(model.assembly.names)[np.array(far) > 0.0].tolist())
        kept = (Kept("shape", names, moved_words, value),) if x.any() else ()
        return Changed(
            self.model, model, result, stands, moved_words, kept, (told, words), x, value, first,
            rounds,
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

    def run(self) -> Changed:
        """The best shape that stands, from that of the model as given."""
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
    kind = ShapeSearch if chosen.aim is ShapeAim.STAND else BestShapeSearch
    search = kind(model, variables, chosen, clock)
    shortest = search.shortest(vertex)
    if shortest < chosen.least_edge:
        raise InputError(
            f"an edge that moves is {shortest:.4g} m long already, shorter than the least of "
            f"{chosen.least_edge:.4g} m",
            remedy=f"give a least edge of {shortest:.4g} m or less",
        )
    return search.run()
