"""Vertices moved by gradient until a structure stands, weighs least, or reaches farthest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Unpack

import numpy as np

from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.design.shaping.raised_tilt import raise_tilt
from drystone.design.shaping.shape_options import ShapeAim, Shaped, ShapeOptions
from drystone.design.shaping.shape_search import ShapeSearch
from drystone.design.shaping.variables import ShapeVariables
from drystone.design.shaping.vertex_measures import vertices_of
from drystone.io.opening import Given, How, as_model
from drystone.model import Model

OF_THE_MODEL = 1e-9
"""Vertices with variables of zero are those of the model to this share of its size: rounding."""


@checked_call
def shape(
    given: Given,
    moves: ShapeVariables | Callable[[Model], ShapeVariables],
    *,
    options: ShapeOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Shaped:
    """Move vertices until a structure stands, or to the best shape that stands.

    The help that it needs, and its derivative by all variables (one more solve), come from the
    compliant state; see ``drystone.design.shaping.help_needed``. In each round scipy's SLSQP
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
    Shaped
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
    del executor  # one chain of rounds
    chosen = ShapeOptions.of(options)
    clock = Clock(time_limit_s, stop)
    model = as_model(given, **how)
    variables = moves(model) if callable(moves) else moves
    vertex = vertices_of(model.assembly)
    here = variables.moved(vertex, np.zeros(variables.count))
    if np.abs(here - vertex).max() > OF_THE_MODEL * float(np.ptp(vertex, axis=0).max()):
        raise InputError(
            "the values that the family starts with are not those of the model",
            remedy="build the model with them",
        )
    search = ShapeSearch(model, variables, chosen, progress, clock.late)
    shortest = search.shortest(vertex)
    if shortest < chosen.least_edge:
        raise InputError(
            f"an edge that moves is {shortest:.4g} m long already, shorter than the least of "
            f"{chosen.least_edge:.4g} m",
            remedy=f"give a least edge of {shortest:.4g} m or less",
        )
    return raise_tilt(search) if chosen.aim is ShapeAim.TILT else search.run()
