"""Load cases: one wrench per block, and motions of supports."""

from drystone.loads.case import DOWN, STANDARD_GRAVITY, LoadCase
from drystone.loads.earth import Earth
from drystone.loads.fill import Fill
from drystone.loads.train import Train

__all__ = ["DOWN", "STANDARD_GRAVITY", "Earth", "Fill", "LoadCase", "Train"]
