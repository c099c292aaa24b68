"""Load cases: one wrench per block, and motions of supports."""

from drystone.loads.case import DOWN, STANDARD_GRAVITY, LoadCase

__all__ = ["DOWN", "STANDARD_GRAVITY", "LoadCase"]
