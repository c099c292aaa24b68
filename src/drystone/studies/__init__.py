"""Many checks of one structure: combinations with partial factors, tables of parameters."""

from drystone.base.settings import hold
from drystone.studies.combination_file import Action, Combination, Situation, read_combinations
from drystone.studies.combinations import Combinations, combinations
from drystone.studies.study import study, study_chart, study_map, study_told

__all__ = [
    "Action",
    "Combination",
    "Combinations",
    "Situation",
    "combinations",
    "read_combinations",
    "study",
    "study_chart",
    "study_map",
    "study_told",
]

hold(globals())
