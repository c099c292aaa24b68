"""Reading and writing of model files: one module per format, and a registry.

>>> from drystone.io import FORMATS
>>> {".json", ".obj"} <= {suffix for format in FORMATS for suffix in format.suffixes}
True
"""

from drystone.base.settings import hold
from drystone.io.draft import Contents as Contents
from drystone.io.inspection import Inspection as Inspection
from drystone.io.opening import as_model as as_model
from drystone.io.opening import read as read
from drystone.io.registry import FORMATS as FORMATS
from drystone.io.registry import Format as Format
from drystone.io.registry import files_at as files_at
from drystone.io.registry import format_of as format_of
from drystone.io.registry import inspect as inspect
from drystone.io.registry import read_file as read_file
from drystone.io.registry import write as write

__all__ = hold(globals())
