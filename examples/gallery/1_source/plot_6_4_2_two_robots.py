"""
Two robots (section 6.4.2, figure 6.21)
=======================================

The source builds a shell, a tri-dome, with two robots and no props: one holds a block while the
other one places its neighbours. We have no dimensions of it: the tri-dome here has a shape of ours.
A robot in place of each prop of its plan, and in place of each partner, makes two. An arch of 11
voussoirs is built by two that hold the last block in turn.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.4.2")
case.table()

# %%
# The tri-dome, block by block.

Frame(case.pictures["tri-dome"])

# %%
# The arch when it is complete.

Frame(case.pictures["arch"])
