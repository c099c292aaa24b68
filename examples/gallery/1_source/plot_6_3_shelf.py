"""
Shelf (section 6.3, figure 6.18)
================================

Ten slanted pieces in a frame. Equilibrium exists, and yet two pieces fall. Three partial fixes
of the source each leave one that falls.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.3")
case.table()

# %%
# Pieces 9 and 10 slide out.

Frame(case.pictures["shelf"])

# %%
# With the first fix piece 9 is held. Piece 10 still falls.

Frame(case.pictures["shelf-fix-1"])

# %%
# With the second.

Frame(case.pictures["shelf-fix-2"])

# %%
# With the third.

Frame(case.pictures["shelf-fix-3"])
