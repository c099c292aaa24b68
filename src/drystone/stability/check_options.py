"""Options of a check."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.settlement import SettlementOptions


@dataclass(frozen=True)
class CheckOptions(Options):
    """Options of :func:`check`.

    Attributes
    ----------
    samples
        Number of stiffness distributions besides the uniform one. They distinguish robust from
        sensitive, and may have a rest state where uniform stiffness has none.
    settle
        Where the stiffness decides, follow the blocks by finite steps (:func:`drystone.settle`);
        their motion gives the verdict.
    settlement
        How they are followed; by default until a block has moved by a twentieth of its size. What
        stands moves no farther than a fiftieth.
    uniform
        Stable only where uniform contact stiffness holds it too. What falls with it is not
        followed. Other stiffnesses are then tried until one does not hold it.
    search
        Check whether it could stand with shims (:func:`could_hold`): where the stiffness decides
        and blocks are not followed, search a rest state by convex steps.
    search_tries
        Random motions from which the search starts on small models; fewer on larger ones. One in
        30 to 60 leads to a state of a wedge that a joint ten or eighty times as stiff would hold.
    stiffness_ratio
        Largest ratio of two contact stiffnesses in a state of the search. The default follows the
        wedge of type b of Kao 2023, which needs a ratio of 92 to stand at 58.0 degrees and of 265
        at 59.5 degrees; with discrete elements (3DEC) it stands up to 58.7.
    reduce_ratio
        Whether the search reduces the stiffness ratio of a state, if possible to equal overlaps.
        The verdict does not depend on it; it can take most of the time.
    seed
        Of the random stiffness distributions.
    """

    samples: int = 4
    settle: bool = True
    settlement: SettlementOptions = SettlementOptions(fall=0.05)  # noqa: RUF009 - frozen
    uniform: bool = False
    search: bool = False
    search_tries: int = 250
    stiffness_ratio: float = 200.0
    reduce_ratio: bool = True
    seed: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.samples < 0 or self.search_tries < 0:
            raise InputError("numbers of tries cannot be negative", remedy="give 0 or more")
        if not 1.0 <= self.stiffness_ratio < np.inf:
            raise InputError(
                f"the stiffness ratio is {self.stiffness_ratio}",
                remedy="give a number of 1 or more",
            )
        if self.seed < 0:
            raise InputError(f"the seed is {self.seed}", remedy="give 0 or more")
