"""Screening levels: how thoroughly a rest state is looked for, from quick to full.

A level that finds a rest state proves that the model stands. A level that finds none proves
nothing: a more thorough level, or the full analysis, may still find one.

==========  =====================================================================================
level       what it does
==========  =====================================================================================
NEAREST     follows the stick-slip law from a given start; ends at the first step that must be cut
QUICK       follows the stick-slip law; ends after a few steps without progress
PATIENT     follows the stick-slip law as far as :func:`drystone.check` does
==========  =====================================================================================
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.mechanics.rest_state import RestOptions

AT_REST = RestOptions(ground=1e-14, iteration_limit=30, warm_relaxation=1e-8)
"""Ground so weak that its forces are below every tolerance."""

PROVED = replace(AT_REST, tolerance=3e-9)
"""A third of what a proof allows is unbalanced. Measured from the forces of other rest states, on
eleven models: 1.70 in place of 1.75 times the factorisations of the uniform stiffness, and a tenth
fewer solutions. From the path: 827 factorisations in place of 837 for all stiffnesses of eleven
models, 9 in place of 11 for one of a wall of 10,000 blocks."""

TO_REST = RestOptions(ground=1e-7, tolerance=1e-7, iteration_limit=60, end=PROVED)
"""With ground springs this weak, a structure at rest leans on them by 1e-6 of its load."""


@dataclass(frozen=True)
class Screening(Options):
    """How thoroughly :func:`try_rest` looks for a rest state.

    Attributes
    ----------
    slip_lengths : > 0, < inf
        One friction law each, tried in this order; by the local overlap. ``None`` is the stick-slip
        law.
    numerics
        Of the Newton iteration.
    patient
        Whether a state that leans on the ground springs, or has not converged, is followed on
        weaker ground springs.
    """

    slip_lengths: tuple[float | None, ...] = (None,)
    numerics: RestOptions = TO_REST
    patient: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.slip_lengths:
            raise InputError("there is no slip length", remedy="give None for the stick-slip law")

    def with_slip_lengths(self, *slip_lengths: float | None) -> Screening:
        """The same level with other friction laws."""
        return replace(self, slip_lengths=slip_lengths)


PATIENT = Screening()

QUICK = Screening(numerics=replace(TO_REST, stall=8), patient=False)
"""Measured on stages of vaults and domes: 9 of 10 that rest do so within 8 steps without progress.
Stages that fall are given up after half of the steps."""

NEAREST = replace(QUICK, numerics=replace(QUICK.numerics, warm_relaxation=1e-3, give_up=0.04))
"""Measured on stages of vaults and domes of up to 60 blocks: all 15 that rest are found, and 136
that do not rest take half of the time. In a vault of 366 blocks many that rest are missed. Without
a start it is the level QUICK."""

FEW_BLOCKS, MANY_BLOCKS = 25, 100
"""Free blocks of models whose stages are screened by NEAREST. With fewer blocks the search goes on
for so long that a missed rest state loses the best order (3 of 50 random piles of up to 8 blocks).
With more blocks a missed rest state costs a prop (a vault of 366 blocks: a sixth more props).

Plans check every stage of fewer blocks; of more, where a stage has no more help than the one before
(propped after a quick look only, a vault of 85 blocks has 17 props, not 8). With many, not every
prop is tested at all of its stages: a vault of 366 has hundreds, each in dozens of stages."""


def stage_screening(blocks: int) -> Screening:
    """The level for the stages of a model with some number of free blocks."""
    return NEAREST if FEW_BLOCKS <= blocks <= MANY_BLOCKS else QUICK
