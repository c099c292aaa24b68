"""Blocks followed by finite steps until they rest or fall, and effects of moving supports."""

from drystone.base.settings import hold
from drystone.mechanics.corners import Carrier
from drystone.model import FlushEnds
from drystone.settlement.first_order import (
    SupportResponse,
    SupportResponseOptions,
    support_forces,
    support_response,
)
from drystone.settlement.large_displacement import move_supports, push, reduce_friction
from drystone.settlement.large_types import Drive, End, LargeDisplacement, LargeState
from drystone.settlement.settlement_types import (
    UNDECIDED,
    Loading,
    Outcome,
    Settlement,
    SettlementOptions,
    SettlementPath,
)
from drystone.settlement.settling import settle

__all__ = [
    "UNDECIDED",
    "Carrier",
    "Drive",
    "End",
    "FlushEnds",
    "LargeDisplacement",
    "LargeState",
    "Loading",
    "Outcome",
    "Settlement",
    "SettlementOptions",
    "SettlementPath",
    "SupportResponse",
    "SupportResponseOptions",
    "move_supports",
    "push",
    "reduce_friction",
    "settle",
    "support_forces",
    "support_response",
]

hold(globals())
