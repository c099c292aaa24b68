"""How thoroughly a check looks."""

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
        Stiffness distributions tried beyond the uniform one, to tell robust from sensitive and to
        find a rest state where uniform stiffness has none.
    settle
        Where the stiffness decides whether it stands, follow the blocks by finite steps
        (:func:`drystone.settle`) and answer with where they go.
    settlement
        How they are followed; by default until a block has moved by a twentieth of its size. What
        stands moves no farther than a fiftieth.
    search
        Ask whether it could be wedged to hold (:func:`could_hold`): where the stiffness decides and
        blocks are not followed, look for a rest state by convex steps.
    search_tries
        Random motions from which the search starts on small models; fewer on larger ones.
    stiffness_ratio
        Largest ratio of two contact stiffnesses in a state that the search answers with. The
        default follows the wedge of type b of Kao 2023, which needs a ratio of 92 to stand at 58.0
        degrees and of 265 at 59.5 degrees; discrete elements (3DEC) let it stand up to 58.7.
    reduce_ratio
        Whether the search reduces the stiffness ratio of a state that it found, down to equal
        overlaps where steps lead there. The verdict does not depend on it; it can take most of the
        time.
    seed
        Of the random stiffness distributions.
    """

    samples: int = 4
    settle: bool = True
    settlement: SettlementOptions = SettlementOptions(fall=0.05)  # noqa: RUF009 - frozen
    search: bool = False
    search_tries: int = 48
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
