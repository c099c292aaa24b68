"""The shape with the largest tilt at which it stands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.base.errors import InputError
from drystone.design.shaping.shape_options import ShapeAim, Shaped
from drystone.design.shaping.shape_search import ShapeSearch
from drystone.model import Model

FIRST, CLOSE = 1.0, 0.1
"""[degrees] The first step of the tilt, and the smallest one; chosen."""

STEEPEST = 89.0
"""[degrees] Largest tilt that is asked for."""


def raise_tilt(search: ShapeSearch) -> Shaped:
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
        wanted = min(tilt + step, STEEPEST)
        found = _at(search, wanted).run(x)
        rounds += found.rounds
        if not found.stands:
            step *= 0.5
            continue
        x, now, tilt = found.x, found.model, wanted
        if tilt == STEEPEST:
            words = f"stands at {STEEPEST:g} degrees, and no more was tried"
            break
        step *= 2.0
    margin = replace(search.options.margin, tilt=tilt)
    result = margin.holds(now)
    stands = margin.meets(result)
    words = f"stands tilted by {tilt:.1f} degrees, {first:.1f} before; {words}"
    return Shaped(search.model, now, result, stands, rounds, words, x, tilt, first)


def _at(search: ShapeSearch, tilt: float) -> ShapeSearch:
    """A search for a shape that stands at a tilt [degrees]."""
    margin = replace(search.options.margin, tilt=tilt)
    options = replace(search.options, aim=ShapeAim.STAND, margin=margin)
    return ShapeSearch(search.model, search.moves, options, search.progress, search.late)


def _stands(search: ShapeSearch, model: Model, tilt: float) -> bool:
    return replace(search.options.margin, tilt=tilt).stands(model)


def _largest(search: ShapeSearch, model: Model) -> float:
    """The largest tilt [degrees] to each side at which a model stands, to :data:`CLOSE`."""
    low, high = 0.0, FIRST
    while high < STEEPEST and _stands(search, model, high):
        low, high = high, 2.0 * high
    high = min(high, STEEPEST)
    while high - low > CLOSE:
        middle = 0.5 * (low + high)
        if _stands(search, model, middle):
            low = middle
        else:
            high = middle
    return low
