"""Blocks followed by finite steps until they rest or fall, and effects of moving supports."""

from drystone.settlement.corners import Carrier
from drystone.settlement.first_order import (
    SupportResponse,
    SupportResponseOptions,
    support_forces,
    support_response,
)
from drystone.settlement.settlement_types import (
    Outcome,
    Settlement,
    SettlementOptions,
    SettlementPath,
)
from drystone.settlement.settling import settle

__all__ = [
    "Carrier",
    "Outcome",
    "Settlement",
    "SettlementOptions",
    "SettlementPath",
    "SupportResponse",
    "SupportResponseOptions",
    "settle",
    "support_forces",
    "support_response",
]
