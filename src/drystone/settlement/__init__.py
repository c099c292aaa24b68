"""Blocks followed by finite steps until they rest or fall, and effects of moving supports."""

from drystone.base.settings import hold
from drystone.mechanics.corners import Carrier as Carrier
from drystone.model import FlushEnds as FlushEnds
from drystone.settlement.first_order import SupportResponse as SupportResponse
from drystone.settlement.first_order import SupportResponseOptions as SupportResponseOptions
from drystone.settlement.first_order import support_forces as support_forces
from drystone.settlement.first_order import support_response as support_response
from drystone.settlement.large_displacement import move_supports as move_supports
from drystone.settlement.large_displacement import push as push
from drystone.settlement.large_displacement import reduce_friction as reduce_friction
from drystone.settlement.large_types import Drive as Drive
from drystone.settlement.large_types import End as End
from drystone.settlement.large_types import LargeDisplacement as LargeDisplacement
from drystone.settlement.large_types import LargeState as LargeState
from drystone.settlement.settlement_types import UNDECIDED as UNDECIDED
from drystone.settlement.settlement_types import Loading as Loading
from drystone.settlement.settlement_types import Outcome as Outcome
from drystone.settlement.settlement_types import Settlement as Settlement
from drystone.settlement.settlement_types import SettlementOptions as SettlementOptions
from drystone.settlement.settlement_types import SettlementPath as SettlementPath
from drystone.settlement.settling import settle as settle

__all__ = hold(globals())
