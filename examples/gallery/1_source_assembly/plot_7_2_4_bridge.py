"""
Bridge (section 7.2.4, figure 7.3)
==================================

Nine blocks hook into each other over two abutments: eleven together. All nine can be set without a
prop.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("7.2.4")
case.table()

# %%
# The order in which the bridge is built. Each block comes in along a free path.

Frame(case.pictures["bridge"])
