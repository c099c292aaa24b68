"""What limits consist of: values that were tried, both sides, options, and what follows.

Families of models that depend on one parameter.

A family can be called and pickled, so any executor can use it.

The checks of one value of a limit: from fast to complete.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Protocol, TypeAlias

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.settings import Clock, MayStop, Options, Stop
from drystone.base.units import NUMBER
from drystone.contacts import Contacts
from drystone.formulations.corner_forces import FrictionCone
from drystone.geometry.frames import axis_words, rotation_about, unit
from drystone.io.capacity_words import with_strength
from drystone.loads import LoadCase
from drystone.loads.applied import Shaken, common_acceleration
from drystone.model import FlushEnds, Model
from drystone.results import Result, Samples, Verdict
from drystone.settlement import Outcome
from drystone.stability import QUICK, CheckOptions, check, try_rest
from drystone.stability.asked import Asked
from drystone.stability.problem import Problem
from drystone.stability.verdict import decided
from drystone.virtual import shrink


@dataclass(frozen=True)
class Evaluation:
    """One value that was tried.

    Attributes
    ----------
    value
    verdict
    samples
    settled
        How it ended where the blocks were followed by finite steps, because contact stiffness
        decides; else ``None``.
    """

    value: float
    verdict: Verdict
    samples: Samples = field(default_factory=Samples)
    settled: Outcome | None = None


@dataclass(frozen=True, eq=False)
class Bracket(OneLine):
    """Both sides of a limit.

    Attributes
    ----------
    stands
        The last value at which it stands; ``None`` if none was found.
    falls
        The first value beyond at which it falls; ``None`` if it stands at all tried values.
    standing, falling
        The states there; the falling one has the mechanism.
    computed
        The limit from a convex program, if there is one.
    undecided
        Why the value between that is farthest from the start and undecided is that; else empty.
    """

    stands: float | None = None
    falls: float | None = None
    standing: Result | None = None
    falling: Result | None = None
    computed: float | None = None
    undecided: str = ""

    def agrees(self, other: Bracket) -> bool:
        """Whether both may be of one limit: they overlap, or their sides are the same."""
        sides = [(one.stands, one.falls) for one in (self, other)]
        known = [[value for value in one if value is not None] for one in sides]
        if min(map(len, known)) < 2:
            return sides[0] == sides[1]
        return max(map(min, known)) <= min(map(max, known))

    def _summary(self) -> str:
        return f"stands={self.stands}, falls={self.falls}, computed={self.computed}"

    @property
    def value(self) -> float | None:
        """The limit: computed, or the middle of the bracket; ``None`` where a side is missing."""
        if self.stands is None or self.falls is None:
            return None
        if self.computed is not None:
            return self.computed
        return 0.5 * (self.stands + self.falls)

    def closes(self, stands: float, distance: float) -> bool:
        """Whether it falls within a distance of a value that stands."""
        return self.falls is not None and abs(self.falls - stands) <= distance


@dataclass(frozen=True, eq=False)
class FoundBracket:
    """Result of a search.

    Attributes
    ----------
    bracket
        Around the first change of the verdict, seen from the start.
    islands
        Values beyond it between which the structure stands again, as far as they were tried.
    evaluations
        In ascending order of the value.
    """

    bracket: Bracket
    islands: tuple[tuple[float, float], ...]
    evaluations: tuple[Evaluation, ...]


def plain(bracket: Bracket | None) -> dict[str, Any] | None:
    """A bracket as plain values."""
    if bracket is None:
        return None
    return {"stands": bracket.stands, "falls": bracket.falls, "value": bracket.value}


@dataclass(frozen=True)
class LimitOptions(Options):
    """Options of the search for a limit.

    Attributes
    ----------
    width : > 0, < inf
        Width of the brackets, in the unit of the parameter; when left out, a default of each limit.
    scan : >= 1
        Number of steps between the start and the limit of equilibrium before bisection. An island
        narrower than a step can be missed.
    cone
        Friction cone of the equilibrium limit: ``exact``, or the ``octagon`` of published figures.
    equilibrium_only
        Whether to search the limit of equilibrium only, without the verdict.
    robust
        Whether to search the limit of standing for every contact stiffness too.
    """

    width: float | None = None
    scan: int = 6
    cone: FrictionCone = field(default_factory=FrictionCone.exact)
    equilibrium_only: bool = False
    robust: bool = False


@dataclass(frozen=True, eq=False)
class LimitValues(MayStop):
    """The numbers of a limit, and what follows from them; see :class:`Limit`."""

    quantity: Quantity
    start: float
    end: float
    equilibrium: Bracket
    rest: Bracket | None = None
    uniform: Bracket | None = None
    robust: Bracket | None = None
    islands: tuple[tuple[float, float], ...] = ()
    evaluations: tuple[Evaluation, ...] = ()
    options: LimitOptions | None = None

    @property
    def stands(self) -> float | None:
        """The last value at which it stands, by the verdict where that was asked for."""
        return self.best.stands

    @property
    def falls(self) -> float | None:
        """The first value beyond it at which it falls; ``None`` where it stands at all."""
        return self.best.falls

    @property
    def best(self) -> Bracket:
        """The bracket of the full verdict, or that of equilibrium if there is no other."""
        return self.equilibrium if self.rest is None else self.rest

    @property
    def capped(self) -> bool:
        """Whether it stands at the end of the search, beyond which there are other values."""
        return self.best.falls is None and self.best.stands == self.end != 0.0

    @property
    def sensitive_between(self) -> tuple[float, float] | None:
        """Values between which contact stiffness decides whether it stands.

        Between them either uniform stiffness holds it or the blocks come to rest, not both; or,
        where the limit for every stiffness was asked for, some stiffness does not hold it. ``None``
        if the verdict changes at one value.
        """
        if self.uniform is None or self.rest is None:
            return None
        falling = self.rest.falling
        # at the start, without any forces that balance the loads or without any that press
        at_once = self.rest.falls == self.start and (falling is None or falling.settlement is None)
        inner = (self.uniform, self.rest, *([] if self.robust is None else [self.robust]))
        low = min(self._from_start(one.stands) for one in inner)
        outer = (self.rest.stands, self.rest.falls, self.uniform.falls)
        high = max(self._from_start(value) for value in outer)
        here = tuple(self._from_start(value) for value in (self.rest.stands, self.rest.falls))
        if at_once or (low, high) == here or low == self._from_start(self.end):
            return None
        way = 1.0 if self.end > self.start else -1.0
        return self.start + way * low, self.start + way * high

    def _from_start(self, value: float | None) -> float:
        """Distance from the start; none where no value was found."""
        return 0.0 if value is None else abs(value - self.start)

    @property
    def is_sensitive(self) -> bool:
        """Whether contact stiffness decides at some value near the limit."""
        return self.sensitive_between is not None

    @property
    def undecided_between(self) -> tuple[float, float] | None:
        """The first and last value between the two sides of the limit that are undecided."""
        inside, outside = self.best.stands, self.best.falls
        if inside is None:
            return None
        low = abs(inside - self.start)
        high = float("inf") if outside is None else abs(outside - self.start)
        within = [
            one.value
            for one in self.evaluations
            if low < abs(one.value - self.start) < high and one.verdict is Verdict.UNDECIDED
        ]
        within.sort(key=lambda value: abs(value - self.start))
        return (within[0], within[-1]) if within else None


@dataclass(frozen=True)
class Quantity(OneLine):
    """What a limit varies, and how it is told.

    Attributes
    ----------
    name
    unit
        Empty when it has none.
    phrase
        Words behind a value and its unit; when left out, the name stands before them.
    replaces
        Attributes of :class:`drystone.answer.Question` that it decides.
    inverse
        What one divided by the limit is called; empty when it has no meaning.
    remark
        What the answer says of how it is varied.
    acting
        How much of it the model has already, beside what is varied.
    load
        What was asked to act, where it is varied.
    """

    name: str
    unit: str = ""
    phrase: str = ""
    replaces: tuple[str, ...] = ()
    inverse: str = ""
    remark: str = ""
    acting: float = 0.0
    load: str = ""

    @property
    def words(self) -> str:
        """The name as a person writes it."""
        return self.name.replace("_", " ")

    def told(self, number: str) -> str:
        """A value in words."""
        if self.acting:
            every = self.acting + float(number)
            return f"{self.words} {number} on top of what acts: {every:.10g} in all"
        if self.phrase:
            unit = "degrees" if self.unit == "deg" else self.unit
            return " ".join(filter(None, (number, unit, self.phrase)))
        return f"{self.words} {number}{f' {self.unit}' if self.unit else ''}"


class Family(Protocol):
    """A model for each value of a quantity."""

    @property
    def quantity(self) -> Quantity:
        """What differs between them."""

    def __call__(self, value: float) -> Model:
        """The model at a value."""


@dataclass(frozen=True, eq=False)
class Tilt(OneLine):
    """The assembly rotated counter-clockwise about an axis; loads keep their direction.

    Attributes
    ----------
    model
        The model before rotation. Its forces and moments keep their direction in space.
    axis : (3,)
    """

    model: Model
    axis: Floats

    @property
    def quantity(self) -> Quantity:
        """The angle about that axis."""
        told = ""
        if self._pushed:
            told = "forces, and pressure of fill and earth, keep their direction while it turns"
        replaces = "load", "acceleration", "loads"
        return Quantity("tilt", "deg", axis_words(self.axis), replaces, remark=told)

    @property
    def _pushed(self) -> bool:
        """Whether anything beside an acceleration of all masses acts."""
        assembly, load = self.model.assembly, self.model.load.beside_masses
        rest = load.wrench.copy()
        rest[:, :3] -= assembly.mass[:, None] * common_acceleration(assembly, load)
        least = 1e-9 * float(np.abs(load.wrench).max(initial=0.0))
        return bool(np.abs(rest[assembly.free]).max(initial=0.0) > least)

    def __call__(self, value: float) -> Model:
        """The model at an angle [degrees]."""
        return self.model.with_load(self.turned(value))

    def turned(self, angle_deg: float) -> LoadCase:
        """The load in the axes of the rotated model."""
        load = self.model.load.turned(rotation_about(self.axis, angle_deg))
        return replace(load, name=f"{self.model.load.name}, tilt {angle_deg:g} deg")

    def is_planar(self) -> bool:
        """Whether forces are normal to the axis, and moments along it."""
        along = self.model.load.wrench.reshape(-1, 3) @ unit(self.axis, "axis")
        return bool(np.abs(along).max() <= 1e-12 * np.abs(self.model.load.wrench).max())


@dataclass(frozen=True, eq=False)
class Friction(OneLine):
    """The same friction coefficient at all joints.

    Attributes
    ----------
    model
    scaled
        Whether the value multiplies the coefficient of each joint instead of replacing it.
    """

    model: Model
    scaled: bool = False

    @property
    def quantity(self) -> Quantity:
        """The coefficient, or a share of the coefficients."""
        name = "share of friction" if self.scaled else "friction"
        return Quantity(name, replaces=("friction",))

    def __call__(self, value: float) -> Model:
        """The model at a coefficient, or at a share of the coefficients."""
        friction = value * self.model.contacts.friction if self.scaled else value
        return self.model.with_friction(friction)


@dataclass(frozen=True, eq=False)
class LoadFactor(OneLine):
    """A live load times a factor, on top of the load of the model."""

    model: Model
    live: LoadCase

    @cached_property
    def quantity(self) -> Quantity:
        """The factor, and how much of the live load the model has: by its name, if it fits."""
        load, name = self.model.load, self.live.name
        parts = [one.removesuffix(name).rstrip(" *") for one in load.name.split(" + ")
                 if one.endswith(name)]  # fmt: skip
        known = [1.0 if not one else float(one) if NUMBER.fullmatch(one) else 0.0 for one in parts]
        along = float((load.wrench * self.acting).sum() / (self.acting**2).sum())
        acting = sum(known) if sum(known) <= along * (1.0 + 1e-9) else 0.0
        asked, replaces = f"{load.name}, and {name} times a factor", ("acceleration", "loads")
        told = Shaken.of(self.model.assembly, load + self.live) if self.live.shake.any() else None
        return Quantity("load factor", self.live.unit, replaces=replaces, acting=acting, load=asked,
                        remark="" if told is None else told.words)  # fmt: skip

    @cached_property
    def acting(self) -> Floats:
        """Wrenches (n, 6) of the live load at a factor of one."""
        return self.live.beside(self.model.load).wrench

    def __call__(self, value: float) -> Model:
        """The model at a factor."""
        return self.model.with_load(self.model.load + value * self.live)


@dataclass(frozen=True, eq=False)
class Shrunk(OneLine):
    """All interfaces scaled about their centroids."""

    model: Model
    quantity: ClassVar[Quantity] = Quantity(
        "size of the joints", phrase="of the size of the joints", inverse="geometric safety factor"
    )

    def __call__(self, value: float) -> Model:
        """The model at a share of the size of the joints, from 0 to 1."""
        return self.model.with_contacts(shrink(self.model.contacts, value))


@dataclass(frozen=True, eq=False)
class Weakened(OneLine):
    """All strengths of the joints times a share."""

    model: Model
    quantity: ClassVar[Quantity] = Quantity(
        "share of strength",
        phrase="of the strength of the joints",
        inverse="factor on the strength",
    )

    def __call__(self, value: float) -> Model:
        """The model at a share of the strengths, from 0 to 1."""
        capacity = self.model.contacts.capacity
        return self.model if capacity is None else self.model.with_capacity(capacity.scaled(value))


@dataclass(frozen=True, eq=False)
class Parametric(OneLine):
    """A parametric model under its own weight, with a contact search for every value.

    Attributes
    ----------
    build
        Function from a value to an assembly.
    model
        Function from an assembly to its model, such as :meth:`drystone.Model.of`.
    quantity
    ends
    """

    build: Callable[[float], Assembly]
    model: Callable[[Assembly], Model]
    quantity: Quantity = Quantity("thickness")
    ends: FlushEnds | None = None

    def __call__(self, value: float) -> Model:
        """The model at a value of the parameter."""
        return replace(self.model(self.build(value)), ends=self.ends)


_Find: TypeAlias = Callable[[Assembly], Contacts] | None


def modelled(friction: float, strength: str | None, find: _Find, assembly: Assembly) -> Model:
    """The model of an assembly, with the contacts that are found or that a search finds.

    A function draws what it means: blocks that are near do not touch.
    """
    if find is not None:
        return Model(assembly, find(assembly))
    model = replace(Model.of(assembly, friction=friction, anyway=True), unjoined=())
    return model if strength is None else with_strength(model, strength)


Check: TypeAlias = Callable[[Model], Result]
"""A function that gives the verdict on a model."""

SEARCHED = 500
"""Largest number of corners with which uniform stiffness is checked as thoroughly as by
:func:`drystone.check`. Chosen: for larger models that fall one such try takes seconds; two quick
ones are made instead."""

_UNIFORM = QUICK.with_slip_lengths(None, 1.0)
"""Screening of large models, for the limit of uniform stiffness. Measured on the Armadillo vault:
the quick level gives the same limits as the patient one in half of the time."""


def one_stiffness(model: Model, *, start: Floats | None = None, stop: Stop | None = None) -> Result:
    """Whether it stands with uniform contact stiffness: the fastest proof."""
    contacts = model.contacts
    if contacts.corner_count > SEARCHED and not (contacts.brittle or contacts.crushes.any()):
        return try_rest(model, screening=_UNIFORM, start=start, stop=stop)
    return check(model, options=CheckOptions(settle=False), start=start, stop=stop)


def every_stiffness(
    model: Model, *, start: Floats | None = None, stop: Stop | None = None
) -> Result:
    """Whether it stands with every contact stiffness that is tried: robust.

    Where they slide far they are followed, and must come to rest.

    Returns
    -------
    Result
        STABLE where it stands with all of them. Otherwise UNSTABLE where no forces balance the
        loads or the blocks fall, or else UNDECIDED.
    """
    options = replace(CheckOptions.robust(), uniform=True)
    found = check(model, options=options, start=start, stop=stop)
    everywhere = found.samples.standing == found.samples.tried
    return found if everywhere or not found.stable else replace(found, verdict=Verdict.UNDECIDED)


def verdict(model: Model, *, start: Floats | None = None, stop: Stop | None = None) -> Result:
    """The verdict of :func:`drystone.check`, which is not asked what would change it."""
    clock, problem = Clock(math.inf, stop), Problem.build(model)
    return decided(Asked(problem, CheckOptions(), clock, explains=False), near=start)


STANDS: Mapping[Verdict, bool | None] = {
    Verdict.STABLE: True,
    Verdict.EQUILIBRIUM_EXISTS: True,
    Verdict.UNSTABLE: False,
    Verdict.UNDECIDED: None,
}
"""Whether a verdict counts as standing; ``None`` counts as neither."""

STANDS_OR_NOT: Mapping[Verdict, bool | None] = {
    kind: stands is True for kind, stands in STANDS.items()
}
"""As above, but an undecided value counts as falling."""
