"""Load cases: one wrench per block, and motions of supports."""

from drystone.base.settings import hold
from drystone.loads.case import DOWN as DOWN
from drystone.loads.case import STANDARD_GRAVITY as STANDARD_GRAVITY
from drystone.loads.case import LoadCase as LoadCase
from drystone.loads.earth import Earth as Earth
from drystone.loads.fill import Fill as Fill
from drystone.loads.train import Train as Train

__all__ = hold(globals())
