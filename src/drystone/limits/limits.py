"""Limits: largest tilt and load, least friction, thickness and joint size.

Every limit is found twice. The limit of *equilibrium* is a convex problem: some forces balance the
loads, with associated flow. This is necessary for standing. The limit of *rest* is that of the
full verdict: the forces arise without prestress. It is searched inside the limit of equilibrium.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Unpack

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Floats, number
from drystone.base.errors import InputError
from drystone.base.settings import Clock, LongWork, checked_call
from drystone.contacts import Contacts
from drystone.formulations.equilibrium import FactorSolution
from drystone.geometry.frames import LEVEL_AXES, axis_vector
from drystone.io.load_options import grown
from drystone.io.opening import Given, LongHow, supported_model
from drystone.limits.bounds import friction_bound, load_factor_bound, rbe, tilt_bound, tilt_factor
from drystone.limits.images import unlike_axes
from drystone.limits.inside import (
    MANY,
    Means,
    bisected,
    resting,
    rests_up_to,
    searched,
    stands_up_to,
)
from drystone.limits.limit_answer import Limit
from drystone.limits.limit_types import (
    STANDS,
    Check,
    Friction,
    LimitOptions,
    LoadFactor,
    Parametric,
    Quantity,
    Shrunk,
    Tilt,
    Weakened,
    modelled,
    one_stiffness,
)
from drystone.loads import LoadCase
from drystone.model import FlushEnds
from drystone.results import Result

_WIDTH_DEG = 0.05
"""Default width of a bracket of tilt [degrees]."""
_NARROW = 0.03
"""Share of the vertical force that counts beside the thrust. Chosen: arches, barrel vaults, walls
and a leaning column are asked about the weaker axis first."""
_CLEARLY = 10.0
"""How many times that of the other axis what counts is from which on the other one is not asked
before. Measured: 20 to 55 times for walls, barrel vaults; up to 7 for a short one, a wedge and an
arch, where two of three guesses are wrong."""
_LEAST_TILT = "the least of the tilts about x, -x, y and -y"
_NOT_ALL_AXES = "about other axes it may fall before: not all are searched"
_SHARE = 1e-4
"""Default width of a bracket of a load factor, by the limit."""


@checked_call
def limit_tilt(
    given: Given,
    axis: Floats | Sequence[float] | str | None = None,
    *,
    upper: float = 180.0,
    check: Check | None = None,
    options: LimitOptions | None = None,
    **how: Unpack[LongHow],
) -> Limit:
    """The largest angle [degrees] by which the assembly can be turned about an axis.

    Its load keeps its direction in space while it turns.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    axis : (3,) or a name
        Turned counter-clockwise about ``x``, ``y``, ``-x``, ``-y`` or a vector; when left out, the
        one of those four with the least tilt.
    upper : [degrees] > 0, <= 360
        Largest angle of the search.
    check
        A function that gives the verdict on a model. When left out, that of drystone: first with
        uniform contact stiffness, then with others where it falls.
    options
        The default width is 0.05 degree.

    Examples
    --------
    A cube on a cube slides at ``atan(0.6)``:

    >>> from drystone.models import tower
    >>> limit = limit_tilt(tower(2), "x", friction=0.6)
    >>> round(limit.equilibrium.value, 1), round(limit.rest.value, 1)
    (31.0, 31.0)
    """
    means = Means(check, LimitOptions.of(options), Clock.of(how))
    model = supported_model(given, **how)
    if axis is not None:
        return tilt_limit(Tilt(model, axis_vector(axis)), upper, means)
    axes = unlike_axes(model) if check is None else LEVEL_AXES
    ways: Mapping[str, Tilt] = {name: Tilt(model, np.array(one)) for name, one in axes.items()}
    known: Mapping[Tilt, FactorSolution] = {}
    rest: Result | None = None
    if means.asks:
        means.tell("rest state", 0)
        rest = one_stiffness(model, stop=means.clock.late)
        if model.contacts.corner_count <= MANY and not means.clock.late():
            means.tell("limit of equilibrium", 0)
            ways, known = _weaker_first(ways, means, rest)
    first, *others = ways.values()
    limit = tilt_limit(first, upper, means, known.get(first), rest)
    for family in others:
        last = limit.best.stands
        if not last or limit.stopped:
            break
        if means.asks and stands_up_to(family, last, means, rest):
            continue
        found = tilt_limit(family, last, means, rest=rest)
        if found.stopped:
            limit = replace(limit, stopped=found.stopped)
        elif not found.capped:
            limit = replace(found, end=limit.end)
    told = _NOT_ALL_AXES if limit.stopped else _LEAST_TILT
    remark = "; ".join(filter(None, (told, limit.quantity.remark)))
    return replace(limit, quantity=replace(limit.quantity, remark=remark))


def _weaker_first(
    ways: Mapping[str, Tilt], means: Means, rest: Result
) -> tuple[Mapping[str, Tilt], Mapping[Tilt, FactorSolution]]:
    """The ways to tilt, of x and y first that with the lower limit of equilibrium, and this limit.

    First that is asked which seems lower: about the axis across which it thrusts, or a narrow side.
    Of the other only whether it is more, where it is.
    """
    cone, late = means.options.cone, means.clock.late
    model = ways["x"].model
    width = np.ptp(model.assembly.bounds.reshape(-1, 3), axis=0)[:2]
    force = np.eye(3)[2] if rest.force is None else np.abs(rest.world_force()).sum(axis=0)
    along_x, along_y = (force[:2] + _NARROW * force[2]) / width
    first = along_y >= (1.0 - SAME) * along_x
    order, near = ("xy", 1.0 - _SHARE) if first else ("yx", 1.0 / (1.0 - _SHARE))
    weak, *others = (ways[name] for name in order if name in ways)
    known = {weak: tilt_factor(weak, cone, late)}
    for other in others if max(along_x, along_y) < _CLEARLY * min(along_x, along_y) else ():
        enough = max(0.0, known[weak].factor)  # and 0 where it is NaN, not known
        more = rbe(cone, late, other(np.degrees(np.arctan(near * enough))))
        if not STANDS[more.verdict]:
            known[other] = tilt_factor(other, cone, late, enough)
    x, y = (known[one].factor if (one := ways.get(name)) in known else np.inf for name in "xy")
    if y < (1.0 - _SHARE) * x:
        ways = dict(sorted(ways.items(), key=lambda way: not way[0].endswith("y")))
    return ways, known


def tilt_limit(
    family: Tilt,
    upper: float,
    means: Means,
    first: FactorSolution | None = None,
    rest: Result | None = None,
) -> Limit:
    """As :func:`limit_tilt`; ``first`` as in :func:`drystone.limits.bounds.tilt_bound`.

    ``rest``: of uniform stiffness upright, where it is known.
    """
    chosen, known = means.options, resting(family, means)
    if rest is not None and rest.stable:
        known.results[0.0] = rest
    width = _WIDTH_DEG if chosen.width is None else chosen.width
    return searched(
        family,
        0.0,
        upper,
        lambda stop: (
            tilt_bound(
                family, upper, width=width, cone=chosen.cone, stop=stop, first=first, rest=rest
            ),
            width,
        ),
        means,
        first=known,
    )


@checked_call
def limit_friction(
    given: Given,
    *,
    upper: float | None = None,
    scaled: bool = False,
    check: Check | None = None,
    options: LimitOptions | None = None,
    **how: Unpack[LongHow],
) -> Limit:
    """The least friction coefficient of the joints; see :func:`limit_tilt`.

    Parameters
    ----------
    upper : coefficient > 0, < inf
        Start of the search; when left out, the largest coefficient of the joints (1 with
        ``scaled``).
    scaled
        Search the factor on the coefficient of each joint instead of one coefficient for all.
    options
        The default width is 0.001.
    """
    means = Means(check, LimitOptions.of(options), Clock.of(how))
    model = supported_model(given, **how)
    if not model.contacts.count:
        raise InputError("no blocks touch", remedy="join near ones with a wider gap (--gap)")
    family = Friction(model, scaled)
    largest = 1.0 if scaled else float(model.contacts.friction.max(initial=0.0))
    start = largest if upper is None else upper
    if start <= 0.0:
        raise InputError(f"the largest friction is {start}", remedy="give a number above zero")
    first = resting(family, means)
    rests = partial(rests_up_to, first, start, means) if means.asks else None
    return bisected(family, start, 0.0, 1e-3, means, partial(friction_bound, rests=rests), first)


@checked_call
def limit_load(
    given: Given,
    live: LoadCase | str | float | Sequence[float],
    *,
    upper: float = 1000.0,
    check: Check | None = None,
    options: LimitOptions | None = None,
    **how: Unpack[LongHow],
) -> Limit:
    """The largest factor of a live load on top of the load of the model; see :func:`limit_tilt`.

    Parameters
    ----------
    live
        The load that grows: ``BLOCK:WHAT[@X,Y,Z]`` as for ``--load``, ``seismic:KX,KY``, or a load
        case of the file by its name. In Python also a load case; a number, the multiple of gravity
        along -z; or an acceleration (3,) [m/s2] of all masses.
    upper : > 0, < inf
        Largest factor of the search.
    options
        The default width is 1e-4 of the limit.
    """
    means = Means(check, LimitOptions.of(options), Clock.of(how))
    chosen = means.options
    model = supported_model(given, **how)
    if isinstance(live, str):
        case = grown(live, model, how.get("gravity"), how.get("shaken", False))
    else:
        case = LoadCase.of(model.assembly, live)
        if not isinstance(live, LoadCase):  # of all masses, those that blocks carry too
            case = replace(case, shake=case.acceleration)
    family = LoadFactor(model, case)
    if not family.acting[model.assembly.free].any():
        raise InputError("the live load is zero on all free blocks", remedy="load a free block")
    return searched(
        family,
        0.0,
        upper,
        lambda stop: load_factor_bound(
            family, upper, share=_SHARE, width=chosen.width, cone=chosen.cone, stop=stop
        ),
        means,
        _SHARE,
    )


@checked_call
def limit_shrink(
    given: Given,
    *,
    check: Check | None = None,
    options: LimitOptions | None = None,
    **how: Unpack[LongHow],
) -> Limit:
    """The least share of the size of all joints at which it stands; see :func:`limit_tilt`.

    Its inverse is a geometric safety factor, after Heyman 1982: the size of the joints divided by
    the required size.

    Parameters
    ----------
    options
        The default width is 0.001.
    """
    means = Means(check, LimitOptions.of(options), Clock.of(how))
    family = Shrunk(supported_model(given, **how))
    return bisected(family, 1.0, 0.0, 1e-3, means)


@checked_call
def limit_strength(
    given: Given,
    *,
    check: Check | None = None,
    options: LimitOptions | None = None,
    **how: Unpack[LongHow],
) -> Limit:
    """The least share of the strengths of all joints at which it stands; see :func:`limit_tilt`.

    All that joints carry beyond friction, and what crushes them, is multiplied by it.

    Parameters
    ----------
    options
        The default width is 0.001.

    Raises
    ------
    InputError
        No joint has a strength.
    """
    means = Means(check, LimitOptions.of(options), Clock.of(how))
    model = supported_model(given, **how)
    if model.contacts.capacity is None:
        remedy = "give one, such as --strength 5MPa"
        raise InputError("no joint has a strength", where="strength", remedy=remedy)
    return bisected(Weakened(model), 1.0, 0.0, 1e-3, means)


@checked_call
def limit_thickness(
    build: Callable[[float], Assembly],
    thick: float,
    thin: float,
    *,
    friction: float = 0.6,
    strength: str | None = None,
    find: Callable[[Assembly], Contacts] | None = None,
    parameter: str = "thickness",
    unit: str = "",
    ends: FlushEnds | None = None,
    check: Check | None = None,
    options: LimitOptions | None = None,
    **work: Unpack[LongWork],
) -> Limit:
    """The least thickness, or another parameter, at which a parametric model stands.

    Parameters
    ----------
    build
        Function from the parameter to an assembly.
    thick, thin
        Start of the search, where it should stand, and its end.
    friction
        Of all joints.
    strength
        Pressure under which all joints crush, such as ``5MPa``; without limit when left out.
    find
        Function that finds the contacts; when left out, :func:`drystone.find_contacts`.
    parameter, unit
        For tables.
    ends
        What becomes of flush ends of joints; see :class:`drystone.Model`.
    options
        The default width is 1e-5 of the range.

    Examples
    --------
    >>> from drystone.models import arch
    >>> limit = limit_thickness(lambda t: arch(t, 8), 0.2, 0.05, friction=1.0)
    >>> round(limit.rest.value, 3)
    0.1
    """
    first, last = number(thick, "thick"), number(thin, "thin")
    if first == last:
        raise InputError("the range has no length", remedy="give two different values")
    family = Parametric(
        build, partial(modelled, friction, strength, find), Quantity(parameter, unit), ends
    )
    width = 1e-5 * abs(first - last)
    means = Means(check, LimitOptions.of(options), Clock.of(work))
    return bisected(family, first, last, width, means)
