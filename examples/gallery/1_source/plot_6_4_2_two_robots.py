"""
Two robots in turn (section 6.4.2)
==================================

One robot holds the last block while the other places the next one. The source builds a shell in
this way. We have no dimensions of it, so an arch of 11 voussoirs is built instead.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.4.2")
case.table()

# %%
# The arch when it is complete.

Frame(case.pictures["arch"])
