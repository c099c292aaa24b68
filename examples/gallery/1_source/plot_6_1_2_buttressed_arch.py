"""
Buttressed arch (section 6.1.2, figures 6.4 to 6.6)
===================================================

An arch on two buttresses: the least friction with which it stands, and its limit of tilt.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.1.2")
case.table()

# %%
# The forces just below the limit of tilt (figure 6.6b), at friction 0.6.

Frame(case.pictures["tilted"])
