"""Many checks of one structure: combinations with partial factors, tables of parameters."""

from drystone.base.settings import hold
from drystone.studies.combination_file import Action as Action
from drystone.studies.combination_file import Combination as Combination
from drystone.studies.combination_file import Situation as Situation
from drystone.studies.combination_file import read_combinations as read_combinations
from drystone.studies.combinations import Combinations as Combinations
from drystone.studies.combinations import combinations as combinations
from drystone.studies.study import study as study
from drystone.studies.study import study_chart as study_chart
from drystone.studies.study import study_map as study_map
from drystone.studies.study import study_told as study_told

__all__ = hold(globals())
