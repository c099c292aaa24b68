"""
Snake (section 7.2)
===================

Three blocks hook over each other on a fixed one.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("7.2")
case.table()

# %%
# The snake stands with friction 0.7.

Frame(case.pictures["snake"])
