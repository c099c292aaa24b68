"""What a shape is changed for."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

import numpy as np

from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.design.margin import DesignMargin


class ShapeAim(enum.Enum):
    """What a shape is changed for."""

    STAND = "stand"
    VOLUME = "volume"
    REACH = "reach"
    TILT = "tilt"


class HelpMeasure(enum.Enum):
    """How the help that a structure needs is measured."""

    REST = "rest"
    BALANCE = "balance"


MEASURES = {
    ShapeAim.STAND: "share of the load that needs help",
    ShapeAim.VOLUME: "volume [m3]",
    ShapeAim.REACH: "reach [m]",
    ShapeAim.TILT: "tilt [degrees]",
}
"""What is to be best."""


@dataclass(frozen=True)
class ShapeOptions(Options):
    """Options of :func:`shape`.

    Attributes
    ----------
    aim
        To stand; the least volume, or the farthest reach, with which it stands at the margin; or
        the largest tilt to each of four sides at which it stands.
    help
        What weak ground carries in the rest state; or the convex problem, which shapes until forces
        balance the load. Some structures in balance fall, so the second one may end at a false
        shape, and says so. It is for shapes that are to stand.
    margin
        How far from falling the shape has to stand.
    reach : (3,)
        The direction of the farthest reach.
    block
        Name or position of the block that reaches out.
    rounds
        Steps of the search at most; contacts are found anew after each.
    iterations
        Iterations of the optimiser in one round at most.
    least_edge : [m]
        No edge that moves gets shorter: the least thickness of blocks.
    trust
        Largest change of a variable in the first round, by its largest move.
    close
        The search ends when a round gains less than this share.
    """

    aim: ShapeAim = ShapeAim.STAND
    help: HelpMeasure = HelpMeasure.REST
    margin: DesignMargin = field(default_factory=DesignMargin)
    reach: tuple[float, float, float] = (1.0, 0.0, 0.0)
    block: int | str = -1
    rounds: int = 20
    iterations: int = 40
    least_edge: float = 0.0
    trust: float = 0.25
    close: float = 1e-3

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rounds < 1 or self.iterations < 1:
            raise InputError("there is no round or no iteration", remedy="give 1 or more")
        if self.aim is not ShapeAim.STAND and self.help is HelpMeasure.BALANCE:
            raise InputError(
                f"the convex problem and the aim '{self.aim.value}' contradict each other",
                remedy="shape it to stand, or measure help by rest states",
            )
        if self.aim is ShapeAim.TILT and self.margin.tilt > 0.0:
            raise InputError(
                "the largest tilt and a margin of tilt contradict each other",
                remedy="leave the margin of tilt out",
            )
        if not 0.0 < self.trust <= 1.0:
            raise InputError(f"the trust is {self.trust}", remedy="give a share above 0, up to 1")
        if not 0.0 <= self.least_edge < np.inf:
            raise InputError(
                f"the least edge is {self.least_edge} m", remedy="give metres, 0 or more"
            )
        if not 0.0 < self.close < 1.0:
            raise InputError(f"close is {self.close}", remedy="give a share between 0 and 1")
