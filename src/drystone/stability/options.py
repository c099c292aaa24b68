"""How thoroughly a check looks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.errors import InputError
from drystone.settings import Options


@dataclass(frozen=True)
class CheckOptions(Options):
    """Options of :func:`check`.

    Attributes
    ----------
    samples
        Stiffness distributions tried beyond the uniform one, to tell robust from sensitive and to
        find a rest state where uniform stiffness has none.
    search
        Look for a rest state by convex steps where no sample has one.
    search_tries
        Random motions from which the search starts on small models; fewer on larger ones.
    spread
        How many times as stiff as another a corner may be in a state that the search answers with.
        Chosen between what the wedge of Kao 2023 that needs most takes at 58.0 degrees, 92, and
        at 59.5 degrees, 265; 3DEC gave 58.7.
    seed
        Of the random stiffness distributions.
    time_limit_s
        After it the answer is given from what is known by then.
    """

    samples: int = 4
    search: bool = True
    search_tries: int = 48
    spread: float = 200.0
    seed: int = 0
    time_limit_s: float = float("inf")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.samples < 0 or self.search_tries < 0:
            raise InputError("numbers of tries cannot be negative", remedy="give 0 or more")
        if not 1.0 <= self.spread < np.inf:
            raise InputError(f"the spread is {self.spread}", remedy="give a number of 1 or more")
        if self.seed < 0:
            raise InputError(f"the seed is {self.seed}", remedy="give 0 or more")
        require_time_limit(self.time_limit_s)


def require_time_limit(limit_s: float) -> None:
    """Raise InputError where a time limit is below zero, or no number."""
    if not limit_s >= 0.0:
        raise InputError(f"the time limit is {limit_s} s", remedy="give 0 or more")
