"""The verdict with its proof, and the analyses that it uses."""

from drystone.base.settings import hold
from drystone.stability.asked import CheckOptions as CheckOptions
from drystone.stability.attempts import PATIENT as PATIENT
from drystone.stability.attempts import QUICK as QUICK
from drystone.stability.attempts import Screening as Screening
from drystone.stability.attempts import try_rest as try_rest
from drystone.stability.check_many import check_many as check_many
from drystone.stability.verdict import check as check

__all__ = hold(globals())
