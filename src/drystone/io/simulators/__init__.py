"""Models for rigid-body simulators: MJCF and URDF, with blocks as convex pieces."""

from drystone.io.simulators.mjcf import mjcf_text, write_mjcf
from drystone.io.simulators.urdf import write_urdf

__all__ = ["mjcf_text", "write_mjcf", "write_urdf"]
