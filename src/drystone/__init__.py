"""drystone: does a structure of loose blocks stand by contact and friction alone?"""

from drystone.assembly import Assembly, Block
from drystone.contacts import Contacts
from drystone.errors import (
    DrystoneError,
    FormatError,
    InputError,
    MissingDependency,
    SolverError,
)
from drystone.loads import LoadCase
from drystone.results import Residuals, Result, Verdict

__version__ = "0.1.0"

__all__ = [
    "Assembly",
    "Block",
    "Contacts",
    "DrystoneError",
    "FormatError",
    "InputError",
    "LoadCase",
    "MissingDependency",
    "Residuals",
    "Result",
    "SolverError",
    "Verdict",
]
