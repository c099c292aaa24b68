"""The verdict on a model, with forces, motion, and the residuals that prove it."""

from drystone.answer import Verdict as Verdict
from drystone.base.settings import hold
from drystone.checks import Residuals as Residuals
from drystone.results.result import Result as Result
from drystone.results.solution import Samples as Samples
from drystone.results.solution import Sensitivity as Sensitivity

__all__ = hold(globals())
