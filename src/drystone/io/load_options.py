"""The loads of a model as they are asked for: gravity, words, cases of the file, earthquakes."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import texts
from drystone.base.errors import InputError, located, quoted
from drystone.io.jsontext import Field, parse
from drystone.loads import Earth, Fill, LoadCase
from drystone.loads.applied import Shaken, common_acceleration, with_shaken_weights
from drystone.loads.load_words import (
    case_named,
    combined,
    gravity_size,
    gravity_vector,
    load_of_words,
    seismic_of_words,
)
from drystone.loads.placing import wrench_of_masses
from drystone.model import Model

WEIGHT = "weight"
"""The name of the weight of the blocks alone, without the loads of the file."""
TWICE = "acts twice, in the load case of the file and as given: is it meant once (--case weight)?"
"""Follows what the load case of a file, as of a mended one, has already."""


@dataclass(frozen=True, eq=False)
class Loads:
    """Loads by the names of the arguments of :func:`drystone.read`.

    Attributes
    ----------
    gravity
    load
        Words, parts as in our JSON, or several of both, which are added; else the whole load.
    case
    seismic
    shaken
        Whether downward forces are weights of masses.

    Raises
    ------
    InputError
        Some contradict each other.
    """

    gravity: Any = None
    load: Any = None
    case: str | Sequence[str] = ()
    seismic: Any = None
    shaken: bool = False

    @classmethod
    def of(cls, how: Mapping[str, Any]) -> Loads:
        """Those among the arguments of :func:`drystone.read`."""
        known = {one.name for one in fields(cls)}
        return cls(**{name: value for name, value in how.items() if name in known})

    @property
    def given(self) -> bool:
        """Whether one of them is given."""
        one = any(each is not None for each in (self.gravity, self.load, self.seismic))
        return one or self.shaken or len(self.case) > 0

    def __post_init__(self) -> None:
        if len(self.case) and not self._weight and self.acceleration is not None:
            said = "the cases of the file have their own weight"
            raise InputError(said, where="case", remedy="leave out --gravity")
        if self.gravity is not None and self._whole is not None:
            raise InputError("contradicts load", where="gravity", remedy="give one of them")

    @cached_property
    def acceleration(self) -> Any:
        """The whole load that is given, gravity (3,) [m/s2] or another; ``None`` where none is."""
        if self.gravity is None:
            return self._whole
        given = self.gravity
        text = given if isinstance(given, str) else ",".join(map(repr, np.ravel(given).tolist()))
        with located("gravity"):
            return gravity_vector(text)

    @property
    def _weight(self) -> bool:
        """Whether weight alone is asked for, unless a case of the file has that name."""
        return texts(self.case) == [WEIGHT]

    @property
    def _added(self) -> list[Any]:
        """Words and parts."""
        given = [self.load] if isinstance(self.load, str | Mapping) else self.load
        words = isinstance(given, list | tuple) and all(
            isinstance(one, str | Mapping) for one in given
        )
        return list(given) if words else []

    @property
    def _whole(self) -> Any:
        empty = isinstance(self.load, list | tuple) and not self.load
        return None if self._added or empty else self.load

    def on(
        self,
        assembly: Assembly,
        cases: Sequence[LoadCase] = (),
        *,
        base: LoadCase | None = None,
    ) -> tuple[LoadCase, list[str]]:
        """The load case of an assembly, and what is to be said of it.

        Parameters
        ----------
        assembly
        cases
            Of the file; the first is used where nothing else is asked for.
        base
            The load to which others are added, where no whole load is given.

        Raises
        ------
        InputError
            Gravity is given, and would leave out other loads of the file.
        """
        notes: list[str] = []
        whole = self.acceleration
        if len(self.case) and not (self._weight and all(one.name != WEIGHT for one in cases)):
            total = combined(texts(self.case), cases)
        elif whole is None and base is not None and not self._weight:
            total = base
        elif whole is None and cases and not self._weight:
            total = cases[0]
            if len(cases) > 1 or not _is_weight(assembly, total):
                notes.append(f"the load case '{total.name}' of the file is used")
        else:
            total = LoadCase.of(assembly, whole)
            if cases and not self._weight and not _is_weight(assembly, cases[0]):
                said = f"the load case '{cases[0].name}' of the file"
                if self.gravity is not None:
                    remedy = f"leave out --gravity, or give --case {WEIGHT} for weight alone"
                    raise InputError(f"{said} is more than weight", where="gravity", remedy=remedy)
                notes.append(f"{said} is not used: another load was given")
        gravity = whole if self.gravity is not None else None
        if self.shaken:
            total = with_shaken_weights(assembly, total, gravity_size(gravity))
        of_file = total
        if self._added:
            each = _each(self._added, assembly, gravity, self.shaken)
            total = total + (extra := _sum(each))
            had = partial(_has, assembly, of_file)
            twice = [extra] if had(extra) else filter(had, each)
            notes += [f"'{one.name}' {TWICE}" for one in twice if cases]
        if self.seismic is not None:
            if of_file.shake.any():
                notes.append(f"an earthquake {TWICE}")
            text = ",".join(str(one) for one in np.atleast_1d(self.seismic).tolist())
            total = total + seismic_of_words(text, assembly)
        total.refuse_turned_fill()
        told = Shaken.of(assembly, total)
        return total, [*notes, *total.notes, *([] if told is None else [told.words])]


def weighed_anew(case: LoadCase, before: Assembly, after: Assembly) -> LoadCase:
    """A load case of blocks that have other masses now: other loads stay as they are."""
    along = common_acceleration(before, case)
    more = wrench_of_masses(after, along) - wrench_of_masses(before, along)
    return replace(case, wrench=case.wrench + more)


def _sum(each: Sequence[LoadCase]) -> LoadCase:
    return LoadCase.combine([(1.0, one) for one in each], " + ".join(one.name for one in each))


def _each(given: Any, assembly: Assembly, gravity: Any, shaken: bool) -> list[LoadCase]:
    each = [given] if isinstance(given, str | Mapping) else given
    if not isinstance(each, list | tuple):
        remedy = "give words, such as block-1:5kN, or parts as in our JSON"
        raise InputError(f"is {quoted(given)}", where="load", remedy=remedy)
    cases = [
        load_of_words(one, assembly, gravity=gravity)
        if isinstance(one, str) and not one.startswith("{")
        else load_of_parts(Field([_part(one)], "", Path("load")), assembly, "load")
        for one in each
    ]
    if shaken:
        size = gravity_size(gravity)
        cases = [with_shaken_weights(assembly, one, size, one.acceleration) for one in cases]
    return cases


def _part(given: str | Mapping[str, Any]) -> Any:
    """A part of a load case as our JSON has it."""
    return parse(given.encode(), Path("load")).value if isinstance(given, str) else given


def grown(given: Any, model: Model, gravity: Any = None, shaken: bool = False) -> LoadCase:
    """A load that grows: of the file by its name, in words, or parts as in our JSON.

    Its downward forces are weights of masses where they are ``shaken``.

    Raises
    ------
    InputError
        It cannot be read.
    """
    along, assembly = Loads(gravity).acceleration, model.assembly
    if not isinstance(given, str) or given.startswith("{"):
        return _sum(_each(given, assembly, along, shaken))
    if ":" not in given or any(one.name == given for one in model.cases):
        words = "; or write seismic:KX,KY or BLOCK:FX,FY,FZ[@X,Y,Z]"
        case = case_named(given, model.cases, "CASE", words)
    elif given.startswith("seismic:"):
        case = seismic_of_words(given.removeprefix("seismic:"), assembly)
    else:
        case = load_of_words(given, assembly, "CASE", along)
    return with_shaken_weights(assembly, case, gravity_size(along)) if shaken else case


def _is_weight(assembly: Assembly, case: LoadCase) -> bool:
    """Whether a load case accelerates all free blocks alike along -z, and does nothing else."""
    free = ~assembly.fixed
    each = case.wrench[free, :3] / assembly.mass[free, None]
    size = float(np.abs(each).max(initial=0.0))
    alike = np.abs(each - np.array([0.0, 0.0, -size])).max(initial=0.0) <= 1e-9 * size
    return bool(alike) and not case.wrench[free, 3:].any() and case.motion is None


def _has(assembly: Assembly, case: LoadCase, other: LoadCase) -> bool:
    """Whether a load case has, beside weight, the loads of another one on the blocks of that."""
    own = case.wrench - wrench_of_masses(assembly, common_acceleration(assembly, case))
    size = np.abs(other.wrench).max(axis=1)
    near = 1e-6 * size[:, None]
    alike = np.abs(own - other.wrench) <= near
    return bool(size.any() and alike[size > 0.0].all())


_KINDS: dict[str, Callable[..., LoadCase]] = {
    "gravity": LoadCase.gravity,
    "seismic": LoadCase.seismic,
    "point": LoadCase.point_load,
    "line": LoadCase.line_load,
    "surface": LoadCase.surface_load,
    "moment": LoadCase.moment,
    "mass": LoadCase.extra_mass,
    "settlement": LoadCase.settlement,
    "fill": lambda assembly, words: Fill.named(words).on(assembly),
    "earth": lambda assembly, words: Earth.named(words).on(assembly),
}
"""Kinds of parts. The keys of each are what its constructor takes, in SI units, and its factor."""


def load_of_parts(field: Field, assembly: Assembly, name: str) -> LoadCase:
    """The sum of the parts of a load case.

    Parameters
    ----------
    field
        A list of objects, each with ``kind``, an optional ``factor``, and the keys of its kind.
    assembly
    name

    Raises
    ------
    FormatError
        A field is wrong; its path is named.
    """
    parts = []
    for part in field.elements():
        kind = part["kind"].text()
        if kind not in _KINDS:
            raise part["kind"].error(f"'{kind[:40]}' is no load", f"known are {', '.join(_KINDS)}")
        try:
            parts.append((part.get("factor", 1.0).number(), _made(part, kind, assembly)))
        except InputError as error:
            if error.where.startswith(str(field.file)):
                raise
            raise part.error(str(error)) from error
    if not parts:
        raise field.error("has no parts", "give one or more")
    return LoadCase.combine(parts, name)


def _made(part: Field, kind: str, assembly: Assembly) -> LoadCase:
    """What the constructor of a kind makes of the keys of a part."""
    make = _KINDS[kind]
    _, *takes = inspect.signature(make).parameters.values()
    names = {one.name: one.name for one in takes}
    if kind == "surface":
        if part.has("traction") == part.has("pressure"):
            raise part.error("needs either a traction or a pressure")
        names["traction"] = "pressure" if part.has("pressure") else "traction"
    part.only(("kind", "factor", *names.values()))
    given = {
        one.name: part[names[one.name]].value
        for one in takes
        if part.has(names[one.name]) or one.default is one.empty
    }
    return make(assembly, **given)
