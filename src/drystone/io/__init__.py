"""Reading and writing of model files: one module per format, and a registry.

>>> from drystone.io import FORMATS
>>> {".json", ".obj"} <= {suffix for format in FORMATS for suffix in format.suffixes}
True
"""

from drystone.base.settings import hold
from drystone.io.draft import Contents
from drystone.io.inspection import Inspection
from drystone.io.opening import as_model, read
from drystone.io.registry import FORMATS, Format, files_at, format_of, inspect, read_file, write

__all__ = [
    "FORMATS",
    "Contents",
    "Format",
    "Inspection",
    "as_model",
    "files_at",
    "format_of",
    "inspect",
    "read",
    "read_file",
    "write",
]

hold(globals())
