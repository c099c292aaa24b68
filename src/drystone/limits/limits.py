"""By how much does it stand? Largest tilt and load, least friction, thickness and joint size.

Every limit is found twice: for *equilibrium* (some forces balance the loads, friction associative;
a convex problem, necessary for standing) and for *rest* (the full verdict: the forces arise without
prestress), searched inside the first.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from drystone import stability
from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.errors import InputError
from drystone.formulations.equilibrium import FrictionCone
from drystone.geometry.frames import unit
from drystone.limits.bounds import bisected_bound, load_factor_bound, tilt_bound
from drystone.limits.families import (
    Family,
    Friction,
    LoadFactor,
    Parametric,
    Shrunk,
    Tilt,
    found,
    number,
    resting,
)
from drystone.limits.search import (
    Bracket,
    Check,
    Evaluation,
    Found,
    Search,
    evaluate,
    plain,
    verdict,
)
from drystone.loads import LoadCase
from drystone.progress import Progress
from drystone.statics import build_statics

AXES = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
}
"""Axes by name."""


@dataclass(frozen=True)
class LimitOptions:
    """How a limit is searched.

    Attributes
    ----------
    width
        Of the brackets, in the unit of the parameter; left out, a default of each limit.
    scan
        Steps between the start and the limit of equilibrium at which the full verdict is asked
        before it is bisected: an island narrower than a step can be missed.
    cone
        Of the equilibrium limit.
    full
        Whether to search the full verdict too.
    """

    width: float | None = None
    scan: int = 6
    cone: FrictionCone = field(default_factory=FrictionCone.exact)
    full: bool = True

    def __post_init__(self) -> None:
        if self.width is not None and not 0.0 < self.width < float("inf"):
            raise InputError(f"width is {self.width}", remedy="give a number above zero")
        if self.scan < 1:
            raise InputError(f"scan is {self.scan}", remedy="give one step or more")


@dataclass(frozen=True, eq=False)
class Limit:
    """A limit by both definitions.

    Attributes
    ----------
    parameter, unit
    start, end
        Range that was searched, from where it should stand.
    equilibrium
        Some forces balance the loads (associative friction).
    rest
        The full verdict; ``None`` where it was not asked for.
    islands
        Values beyond the first fall at which it stands again, as far as they were tried.
    evaluations
        Values at which the full verdict was asked.
    time_s
    """

    parameter: str
    unit: str
    start: float
    end: float
    equilibrium: Bracket
    rest: Bracket | None = None
    islands: tuple[tuple[float, float], ...] = ()
    evaluations: tuple[Evaluation, ...] = ()
    time_s: Mapping[str, float] = field(default_factory=dict)

    @property
    def best(self) -> Bracket:
        """The bracket of the full verdict, or that of equilibrium where there is no other."""
        return self.equilibrium if self.rest is None else self.rest

    def to_dict(self) -> dict[str, Any]:
        """Plain values; blocks that fall by name."""
        falling = self.best.falling
        standing = self.best.standing
        return {
            "parameter": self.parameter,
            "unit": self.unit,
            "range": [self.start, self.end],
            "equilibrium": plain(self.equilibrium),
            "rest": plain(self.rest),
            "islands": [list(run) for run in self.islands],
            "falling": [] if falling is None else list(falling.falling_names),
            "message": "" if falling is None else falling.message,
            "sensitive": standing is not None
            and standing.samples.standing < standing.samples.tried,
            "evaluations": [
                {
                    "value": one.value,
                    "verdict": one.verdict.value,
                    "tried": one.samples.tried,
                    "standing": one.samples.standing,
                }
                for one in self.evaluations
            ],
            "time_s": dict(self.time_s),
        }


def limit_tilt(
    assembly: Assembly,
    contacts: Contacts,
    axis: Any = "x",
    load: LoadCase | None = None,
    *,
    upper: float = 180.0,
    check: Check = verdict,
    options: LimitOptions | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Limit:
    """The largest angle [degrees] by which the assembly can be turned about an axis.

    Parameters
    ----------
    assembly, contacts
    axis : (3,) or a name
        ``x``, ``y``, ``-x``, ``-y`` or a vector; the turn is counter-clockwise about it.
    load
        Self-weight when left out. It keeps its direction in space while the assembly turns.
    upper : [degrees]
        Where the search ends.
    check
        Any function that answers whether an assembly stands.
    options
        The default width is 0.01 degree.
    executor
        Works on the values of a scan side by side; the answer does not depend on it.
    progress

    Examples
    --------
    A cube on a cube slides at ``atan(0.6)``:

    >>> import drystone
    >>> from drystone.models import tower
    >>> assembly = tower(2)
    >>> contacts = drystone.find_contacts(assembly, friction=0.6).contacts
    >>> limit = limit_tilt(assembly, contacts, "x")
    >>> round(limit.equilibrium.value, 1), round(limit.rest.value, 1)
    (31.0, 31.0)
    """
    chosen = options if options is not None else LimitOptions()
    family = Tilt(assembly, contacts, resting(assembly, load), axis_vector(axis))
    last = number(upper, "the largest angle")
    if not 0.0 < last <= 360.0:
        raise InputError(f"the largest angle is {last}", remedy="give degrees from 0 to 360")
    width = _width(chosen, 0.01)
    return _searched(
        family,
        0.0,
        last,
        lambda: (tilt_bound(family, last, width=width, cone=chosen.cone), width),
        _Means(check, chosen, executor, progress),
    )


def limit_friction(
    assembly: Assembly,
    contacts: Contacts,
    load: LoadCase | None = None,
    *,
    upper: float | None = None,
    scaled: bool = False,
    check: Check = verdict,
    options: LimitOptions | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Limit:
    """The least friction coefficient of the joints; see :func:`limit_tilt`.

    Parameters
    ----------
    upper
        Where the search starts; left out, the largest coefficient of the joints (with ``scaled``,
        one).
    scaled
        Search the share of each joint's own coefficient instead of one coefficient for all.
    options
        The default width is 0.001.
    """
    chosen = options if options is not None else LimitOptions()
    family = Friction(assembly, contacts, resting(assembly, load), scaled)
    largest = 1.0 if scaled else float(contacts.friction.max(initial=0.0))
    start = largest if upper is None else number(upper, "the largest friction")
    if start <= 0.0:
        raise InputError(f"the largest friction is {start}", remedy="give a number above zero")
    return _bisected(family, start, 0.0, 1e-3, check, chosen, executor, progress)


def limit_load(
    assembly: Assembly,
    contacts: Contacts,
    live: LoadCase,
    dead: LoadCase | None = None,
    *,
    upper: float = 1000.0,
    check: Check = verdict,
    options: LimitOptions | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Limit:
    """The largest factor of a live load on top of a dead one; see :func:`limit_tilt`.

    Parameters
    ----------
    live
    dead
        Self-weight when left out.
    upper
        Where the search ends.
    options
        The default width is 1e-4 of the limit.
    """
    chosen = options if options is not None else LimitOptions()
    family = LoadFactor(assembly, contacts, resting(assembly, dead), live)
    if not live.wrench[assembly.free].any():
        raise InputError("the live load is zero on all free blocks", remedy="load a free block")
    last = number(upper, "the largest factor")
    if last <= 0.0:
        raise InputError(f"the largest factor is {last}", remedy="give a number above zero")
    return _searched(
        family,
        0.0,
        last,
        lambda: load_factor_bound(family, last, share=1e-4, width=chosen.width, cone=chosen.cone),
        _Means(check, chosen, executor, progress),
    )


def limit_shrink(
    assembly: Assembly,
    contacts: Contacts,
    load: LoadCase | None = None,
    *,
    check: Check = verdict,
    options: LimitOptions | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Limit:
    """The least share of the size of all joints at which it stands; see :func:`limit_tilt`.

    Its inverse is a geometric safety factor, after Heyman 1982: how many times larger the joints
    are than they need to be. The default width is 0.001.
    """
    chosen = options if options is not None else LimitOptions()
    family = Shrunk(assembly, contacts, resting(assembly, load))
    return _bisected(family, 1.0, 0.0, 1e-3, check, chosen, executor, progress)


def limit_thickness(
    build: Callable[[float], Assembly],
    thick: float,
    thin: float,
    *,
    friction: float = 0.6,
    find: Callable[[Assembly], Contacts] | None = None,
    parameter: str = "thickness",
    unit: str = "",
    check: Check = verdict,
    options: LimitOptions | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Limit:
    """The least thickness, or another parameter, at which a parametric model stands.

    Parameters
    ----------
    build
        From the parameter to the model.
    thick, thin
        Where the search starts, which should stand, and where it ends.
    friction
        Of all joints.
    find
        The contacts of a model; left out, those of :func:`drystone.find_contacts`.
    parameter, unit
        For tables.
    options
        The default width is 1e-5 of the range.

    Examples
    --------
    >>> from drystone.models import arch
    >>> limit = limit_thickness(lambda t: arch(t, 8), 0.2, 0.05, friction=1.0)
    >>> round(limit.rest.value, 3)
    0.1
    """
    chosen = options if options is not None else LimitOptions()
    first, last = number(thick, "thick"), number(thin, "thin")
    if first == last:
        raise InputError("the range has no length", remedy="give two different values")
    finder = find if find is not None else partial(found, friction)
    family = Parametric(build, finder, parameter, unit)
    width = 1e-5 * abs(first - last)
    return _bisected(family, first, last, width, check, chosen, executor, progress)


def axis_vector(axis: Any) -> Any:
    """An axis (3,) from a name or a vector.

    Raises
    ------
    InputError
        No such name, or a vector without a length.
    """
    if isinstance(axis, str):
        if axis not in AXES:
            raise InputError(f"no axis is called '{axis}'", remedy=f"{', '.join(AXES)} or X,Y,Z")
        return np.array(AXES[axis])
    return unit(axis, "axis")


@dataclass(frozen=True, eq=False)
class _Means:
    """What a search works with."""

    check: Check
    options: LimitOptions
    executor: Executor | None
    progress: Progress | None

    def tell(self, stage: str, done: int) -> None:
        if self.progress is not None:
            self.progress(stage, done, 2)


def _width(options: LimitOptions, default: float) -> float:
    return default if options.width is None else options.width


def _bisected(
    family: Family,
    start: float,
    end: float,
    width: float,
    check: Check,
    options: LimitOptions,
    executor: Executor | None,
    progress: Progress | None,
) -> Limit:
    chosen = _width(options, width)
    return _searched(
        family,
        start,
        end,
        lambda: (bisected_bound(family, start, end, width=chosen, cone=options.cone), chosen),
        _Means(check, options, executor, progress),
    )


def _searched(
    family: Family,
    start: float,
    end: float,
    bound: Callable[[], tuple[Bracket, float]],
    means: _Means,
) -> Limit:
    """The convex bound and its width first, then the full verdict inside it."""
    _refuse_nothing_to_do(family, start)
    began = time.perf_counter()
    means.tell("limit of equilibrium", 0)
    outer, width = bound()
    between = time.perf_counter()
    found: Found | None = None
    if means.options.full:
        means.tell("limit of rest", 1)
        search = Search(family, means.check, means.executor)
        if outer.stands is None:
            found = Found(outer, (), ())
        else:
            found = search.run(
                start, outer.stands, width=width, scan=means.options.scan, beyond=outer
            )
            found = replace(found, bracket=_with_samples(family, found.bracket, means.check))
    means.tell("done", 2)
    ended = time.perf_counter()
    return Limit(
        family.parameter,
        family.unit,
        start,
        end,
        outer,
        None if found is None else found.bracket,
        () if found is None else found.islands,
        () if found is None else found.evaluations,
        {"equilibrium": between - began, "rest": ended - between},
    )


def _with_samples(family: Family, bracket: Bracket, check: Check) -> Bracket:
    """The bracket with all stiffnesses tried at its standing side, to tell how sensitive it is."""
    if check is not verdict or bracket.stands is None:
        return bracket
    return replace(bracket, standing=evaluate(family, stability.check, bracket.stands))


def _refuse_nothing_to_do(family: Family, start: float) -> None:
    problem = family(start)
    statics = build_statics(problem.assembly, problem.contacts, problem.load)
    if statics.free_count == 0:
        raise InputError("every block is fixed", remedy="free some blocks")
    if not statics.load.any():
        raise InputError("nothing loads the free blocks", remedy="give a load")


__all__ = [
    "Limit",
    "LimitOptions",
    "axis_vector",
    "limit_friction",
    "limit_load",
    "limit_shrink",
    "limit_thickness",
    "limit_tilt",
]
