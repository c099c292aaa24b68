"""Blocks followed by finite steps to rest or into a fall, and what moving supports cause."""

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
