"""Options of a check."""

from __future__ import annotations

from dataclasses import dataclass

from drystone.base.settings import Options
from drystone.settlement import SettlementOptions

SAMPLES = 4
"""Other contact stiffnesses, at most, that tell robust from sensitive."""


@dataclass(frozen=True)
class CheckOptions(Options):
    """Options of :func:`check`.

    Attributes
    ----------
    samples : >= 0
        Number of contact stiffness distributions that are tried at most besides the uniform one
        where it stands. They change no verdict; with 4 of them it is known whether it stands
        whichever joints press more (robust), or not (sensitive). Two are random; one, with more
        than 120 joints, where all random ones are alike, or where joints turn much. One more
        carries on points spread over such joints then, with 0 as well.
    settle
        Where uniform stiffness does not decide, follow the blocks by finite steps
        (:func:`drystone.settle`); their motion gives the verdict.
    settlement
        How they are followed; by default until a block has moved by a twentieth of its size. What
        stands moves no farther than a fiftieth.
    stiff_shear : > 0, < inf
        Tangential by normal stiffness with which blocks are followed once more, where joints
        decide: UNDECIDED where the two ways end otherwise. With ``None`` they are followed once,
        with that of ``settlement``. Measured on 107 models near limits: three wedges that 0.17
        alone would decide end otherwise at 0.5; at 1 six, the others beyond their limits.
    uniform
        Stable only where uniform contact stiffness holds it too. What falls with it is not
        followed.
    seed : >= 0
        Of the random stiffness distributions.
    """

    samples: int = 0
    settle: bool = True
    settlement: SettlementOptions = SettlementOptions(fall=0.05)  # noqa: RUF009 - frozen
    stiff_shear: float | None = 0.5
    uniform: bool = False
    seed: int = 0

    @classmethod
    def robust(cls) -> CheckOptions:
        """Options of the question whether it stands whichever joints press more."""
        return cls(samples=SAMPLES)
