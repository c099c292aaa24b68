"""Many checks of one structure: combinations of loads with partial factors."""

from drystone.studies.combination_file import Action, Combination, Situation, read_combinations
from drystone.studies.combinations import Combinations, combinations

__all__ = [
    "Action",
    "Combination",
    "Combinations",
    "Situation",
    "combinations",
    "read_combinations",
]
