"""The verdict with its proof, and the analyses that it uses."""

from drystone.stability.asked import CheckOptions
from drystone.stability.attempts import PATIENT, QUICK, Screening, try_rest
from drystone.stability.check_many import check_many
from drystone.stability.verdict import check

__all__ = [
    "PATIENT",
    "QUICK",
    "CheckOptions",
    "Screening",
    "check",
    "check_many",
    "try_rest",
]
