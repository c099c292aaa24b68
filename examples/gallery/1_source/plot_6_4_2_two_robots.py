"""
Two robots in turn (section 6.4.2, figure 6.21)
===============================================

One robot holds the last block while the other places the next one. The source builds a shell in
this way, a tri-dome. We have no dimensions of it: the tri-dome here has a shape of ours. With two
robots and no props it falls at the second block. An arch of 11 voussoirs is built without props.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.4.2")
case.table()

# %%
# The tri-dome when it is complete: it stands.

Frame(case.pictures["tri-dome"])

# %%
# The arch when it is complete.

Frame(case.pictures["arch"])
