"""
Snake (section 7.2.3, figure 7.2)
=================================

Three blocks hook over each other on a fixed one. At the source's friction of 0.66 two of ours have
to be held while they are placed: here we disagree. From 0.8 on none has.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("7.2.3")
case.table()

# %%
# Complete, the snake stands at 0.66.

Frame(case.pictures["snake"])
