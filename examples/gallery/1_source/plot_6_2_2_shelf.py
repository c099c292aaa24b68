"""
Shelf (sections 6.2.2 and 6.3.2, figures 6.12 and 6.18)
=======================================================

Ten slanted pieces in a frame. Equilibrium exists, and yet two pieces fall. Three partial fixes
of the source each leave one that falls.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.2.2")
case.table()

# %%
# Each fix of figure 6.18 holds one piece; the other one still falls.

fixes = reproduce("6.3.2")
fixes.table()

# %%
# Pieces 9 and 10 slide out.

Frame(case.pictures["shelf"])

# %%
# With the first fix piece 9 is held. Piece 10 still falls.

Frame(fixes.pictures["fix-1"])

# %%
# With the second.

Frame(fixes.pictures["fix-2"])

# %%
# With the third.

Frame(fixes.pictures["fix-3"])
