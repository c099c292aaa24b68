"""Whether a model stands, for searches, and the safety margin with which it must."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drystone.base.arrays import ROUNDING, Floats
from drystone.base.errors import InputError
from drystone.base.settings import Options, Stopped
from drystone.base.units import quantity
from drystone.geometry.frames import LEVEL_AXES, axis_words, rotation_about
from drystone.loads import STANDARD_GRAVITY, LoadCase
from drystone.loads.placing import wrench_of_masses
from drystone.model import Model
from drystone.results import Result
from drystone.stability import CheckOptions, check
from drystone.stability.asked import SAMPLES
from drystone.stability.attempts import PATIENT, try_rest
from drystone.stability.attempts import QUICK as QUICKLY

SMALL_REGION = 4
"""Largest number of blocks with which all places are tried; with more blocks only the middle of
each face."""

LARGE_REGION = 40
"""Number of blocks of a region above which less is tried: each trial takes a second with 350."""

SPARE = 0.8
"""Share of the friction with which what is proposed had better stand, too. Chosen."""

QUICK = CheckOptions(samples=0, settle=False)
"""One stiffness: if a model stands with it, it stands; the full check follows."""


def quick_check(model: Model, stop: Callable[[], bool] | None = None) -> Result:
    """The check with one stiffness, for searches.

    Raises
    ------
    Stopped
        ``stop`` said so; what the check found by then says nothing.
    """
    result = check(model, options=QUICK, stop=stop)
    if result.stopped:
        raise Stopped
    return result


def rest_found(
    model: Model, stop: Callable[[], bool] | None = None, start: Floats | None = None
) -> Result:
    """The forces of a model that was found to stand; followed, where one stiffness does not do.

    Raises
    ------
    Stopped
        As above.
    """
    quick = soon_at_rest(model, stop, start)
    result = quick if quick.stable else check(model, stop=stop)
    if result.stopped:
        raise Stopped
    return result


def soon_at_rest(
    model: Model, stop: Callable[[], bool] | None = None, start: Floats | None = None
) -> Result:
    """The rest state with uniform stiffness, if one is soon found; else it is not stable.

    In a large region as quickly as in the stages of a plan: of 51 trials on a wall, a vault and a
    dome of 97 to 160 blocks it missed none that the check found, in a tenth to all of its time on
    what falls. Of few blocks it missed larger shares (props with twice the force on an overhang).

    Raises
    ------
    Stopped
        As above.
    """
    level = QUICKLY if model.assembly.free.size > LARGE_REGION else PATIENT
    found = try_rest(model, screening=level, start=start, stop=stop)
    if not found.stable and model.contacts.crushes.any():  # it missed rings 1.3 times as thick
        found = quick_check(model, stop)
    if found.stopped and not found.stable:
        raise Stopped
    return found


@dataclass(frozen=True)
class DesignMargin(Options):
    """The safety margin of a structure.

    Attributes
    ----------
    tilt : [degrees] >= 0, < 90
        It must stand tilted by this angle to each of four sides.
    load : >= 1, < inf
        It must stand under its weight and this multiple of what else loads it; of its weight, where
        nothing else does. ``variable`` says of which loads alone.
    friction : > 0, <= 1
        It must stand with this share of the friction of each joint.
    robust
        It must stand for all contact stiffnesses of the check. Without this, STABLE is enough,
        also after settling. A mend that holds only after settling is told too, at a higher
        cost, where no value of it stands for all.
    variable
        How the words of those loads begin that ``load`` multiplies, such as those of a train;
        earth and fill beside them are as they are. Empty: all beside the weight.
    """

    tilt: float = 0.0
    load: float = 1.0
    friction: float = 1.0
    robust: bool = True
    variable: str = ""

    @classmethod
    def of_words(cls, words: Sequence[str]) -> DesignMargin:
        """The margin of words: ``tilt=2deg``, ``load=1.2``, ``friction=0.9x``, ``sensitive``.

        ``sensitive`` is for ``robust=False``: STABLE after settling is enough.

        Raises
        ------
        InputError
            One of them is not known, has no number, or is given twice.

        Examples
        --------
        >>> DesignMargin.of_words(["tilt=2deg", "sensitive"])
        DesignMargin(tilt=2, robust=False)
        """
        ends = {"tilt": "deg", "load": "", "friction": "x"}
        remedy = "write tilt=2deg, load=1.2, friction=0.9x or sensitive"
        given: dict[str, Any] = {}
        for text in words:
            name, _, value = text.partition("=")
            number: float | bool = False
            if name == "sensitive" and not value:
                name = "robust"
            elif name not in ends:
                raise InputError(f"'{text}' is no margin", where="margin", remedy=remedy)
            else:
                try:
                    number = float(value.removesuffix(ends[name]))
                except ValueError as error:
                    what = f"'{text}' has no number"
                    raise InputError(what, where="margin", remedy=remedy) from error
            if name in given:
                raise InputError(f"{name} is given twice", where="margin", remedy="give it once")
            given[name] = number
        return cls(**given)

    def eased(self, less: float) -> DesignMargin:
        """The same without a share of it, from 0 to 1."""
        kept = 1.0 - less
        load, friction = 1.0 + kept * (self.load - 1.0), 1.0 - kept * (1.0 - self.friction)
        return replace(self, tilt=kept * self.tilt, load=load, friction=friction)

    @property
    def words(self) -> str:
        """What :meth:`of_words` reads; empty where there is none.

        Examples
        --------
        >>> DesignMargin(tilt=2.0, friction=0.9).words
        'tilt=2deg friction=0.9x'
        """
        parts = (
            f"tilt={self.tilt:.4g}deg" if self.tilt else "",
            f"load={self.load:.4g}" if self.load != 1.0 else "",
            f"friction={self.friction:.4g}x" if self.friction != 1.0 else "",
            "" if self.robust else "sensitive",
        )
        return " ".join(part for part in parts if part)

    def cases(self, model: Model) -> list[Model]:
        """The model in each additional case in which it must stand."""
        return list(self._cases(model).values())

    def _cases(self, model: Model) -> dict[str, Model]:
        """The same by the words of each case."""
        cases: dict[str, Model] = {}
        if self.friction < 1.0:
            less = model.with_friction(self.friction * model.contacts.friction)
            cases[f"with {100.0 * self.friction:g} % of its friction"] = less
        if self.load != 1.0:
            words, more = self._loaded(model)
            if words:
                cases[f"under {self.load:g} times {words}"] = model.with_load(more)
        if self.tilt > 0.0:
            for axis in LEVEL_AXES.values():
                way = axis_words(np.array(axis))
                cases[f"tilted by {self.tilt:g} degrees {way}"] = tilted(model, axis, self.tilt)
        return cases

    def _loaded(self, model: Model) -> tuple[str, LoadCase]:
        """What is multiplied, in words, and the load with it; no words where nothing is.

        Weight times a factor moves no dry block, so it is not multiplied with what else acts.
        """
        load, free = model.load, model.assembly.free
        if self.variable:
            some = [one for one in load.each if one.words.startswith(self.variable)]
            rest = load.without(some)
            each = (*rest.each, *(one.by(self.load) for one in some))
            added = [self.load * one.on(len(load.wrench))["wrench"] for one in some]
            words = " and ".join(one.words for one in some)
            return words, replace(load, wrench=sum(added, rest.wrench), each=each)
        own = wrench_of_masses(model.assembly, load.acceleration - load.shake)
        beside = load.wrench - own - load.weight_of_masses.wrench
        rounding = ROUNDING * np.abs(load.wrench[free]).max(initial=0.0)
        if (np.abs(beside[free]) <= rounding).all():
            return "its weight", self.load * load
        more = self.load - 1.0
        return "what loads it beside its weight", replace(
            self.load * load,
            name=load.name,
            wrench=load.wrench + more * beside,
            acceleration=load.acceleration + more * load.shake,
            fills=load.fills,
            masses=tuple(replace(one, shake=self.load * one.shake) for one in load.masses),
        )

    def remarks(self, model: Model) -> list[str]:
        """What the margin multiplies that helps, or that there is nothing; what is not asked."""
        x, y = 0.0 - model.load.shake[:2] / STANDARD_GRAVITY
        way = f"the earthquake acts one way: ask for the other, --seismic {x:g},{y:g} in its place"
        return [*self._multiplied(model), *([f"{way}, too"] if x or y else [])]

    def _multiplied(self, model: Model) -> list[str]:
        if self.load == 1.0 or self.variable:
            return []
        words, more = self._loaded(model)
        if words == "its weight":
            only = "multiplies weight alone, which moves no dry block: no other load acts"
            return [f"load={self.load:g} {only}"]
        x, y, z = (more.wrench - model.load.wrench)[model.assembly.free, :3].sum(axis=0)
        down = quantity(-z / (self.load - 1.0), "N")
        also = f"load={self.load:g} also multiplies the {down} that press down, which may help"
        return [also] if z < 0.0 and np.hypot(x, y) > ROUNDING * -z else []

    def case_of(self, result: Result, model: Model) -> str:
        """Words for the case that a result of :meth:`holds` is of; empty for the model itself."""
        if result.model is model:
            return ""
        loads, friction = result.model.load.wrench, result.model.contacts.friction
        for words, case in self._cases(model).items():
            same = np.array_equal(case.contacts.friction, friction)
            if same and np.array_equal(case.load.wrench, loads):
                return words
        return ""

    def holds(
        self,
        model: Model,
        stop: Callable[[], bool] | None = None,
        *,
        settle: bool = True,
        near: list[dict[int, Floats]] | None = None,
    ) -> Result:
        """The check of the model, or of the first case in which it does not stand.

        Parameters
        ----------
        model
        stop
            Asked often; True ends a check with what is known.
        settle
            Follow settlement also where it cannot make the structure meet the margin.
        near
            As for :meth:`stands`. What uniform stiffness does not hold is then not followed.
        """
        options = replace(self.options(settle), uniform=near is not None)
        found: list[Result] = []
        cases = (model, *self.cases(model))
        for case, rests in zip(cases, _rests(near, len(cases)), strict=True):
            result = check(case, options=options, start=rests.get(0), stop=stop)
            if not self.meets(result):
                return result
            if result.displacement is not None:
                rests[0] = result.displacement
            found.append(result)
        return found[0]

    def stands(
        self,
        model: Model,
        *,
        quick: bool = False,
        stop: Callable[[], bool] | None = None,
        near: list[dict[int, Floats]] | None = None,
    ) -> bool:
        """Whether a model stands at the margin, for searches: the first case that falls ends it.

        Parameters
        ----------
        model
        quick
            Try one stiffness only, and do not follow settlement.
        stop
            Asked often; once it is True, nothing is found to stand.
        near
            Rest states in each case of the last model that stood, among models with the same
            blocks; changed.
        """
        if not quick:
            known = [] if near is None and self.robust else near
            result = self.holds(model, stop, near=known)
            return self.meets(result) and not result.stopped
        cases = (model, *self.cases(model))
        for case, rests in zip(cases, _rests(near, len(cases)), strict=True):
            found = soon_at_rest(case, stop, rests.get(0))
            standing = found.samples.standing == found.samples.tried
            if not (found.stable and standing) or found.stopped:
                return False
            if found.displacement is not None:
                rests[0] = found.displacement
        return True

    def options(self, settle: bool = False) -> CheckOptions:
        """Of the check of each case; with ``settle`` blocks are followed in any case."""
        return CheckOptions(samples=SAMPLES if self.robust else 0, settle=settle or not self.robust)

    def meets(self, result: Result) -> bool:
        """Whether a result is good enough."""
        samples = result.samples
        return result.stable and (not self.robust or samples.standing == samples.tried)


def tilted(model: Model, axis: tuple[float, float, float], angle: float) -> Model:
    """The model turned counter-clockwise about an axis; its load keeps its direction in space."""
    return model.with_load(model.load.turned(rotation_about(np.array(axis), angle)))


def _rests(near: list[dict[int, Floats]] | None, count: int) -> list[dict[int, Floats]]:
    """Rest states in each of some cases, to change."""
    rests: list[dict[int, Floats]] = [] if near is None else near
    rests.extend({} for _ in range(count - len(rests)))
    return rests
