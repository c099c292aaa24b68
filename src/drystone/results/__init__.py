"""The verdict on a model, with forces, motion, and the residuals that prove it."""

from drystone.answer import Verdict
from drystone.checks import Residuals
from drystone.results.result import Result
from drystone.results.solution import Samples, Sensitivity

__all__ = ["Residuals", "Result", "Samples", "Sensitivity", "Verdict"]
