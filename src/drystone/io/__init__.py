"""Model files in and out: one file per format, behind a registry.

>>> from drystone.io import FORMATS
>>> {".json", ".obj"} <= {suffix for format in FORMATS for suffix in format.suffixes}
True
"""

from drystone.io import supports
from drystone.io.draft import Model
from drystone.io.formats import Format
from drystone.io.joint_table import write_joints
from drystone.io.registry import FORMATS, format_of, inspect, read, write
from drystone.io.units import UNITS

__all__ = [
    "FORMATS",
    "UNITS",
    "Format",
    "Model",
    "format_of",
    "inspect",
    "read",
    "supports",
    "write",
    "write_joints",
]
