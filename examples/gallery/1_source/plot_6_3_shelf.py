"""
Shelf (section 6.3)
===================

Ten slanted pieces in a frame. Equilibrium exists, and yet two pieces fall. Three partial fixes
of the source each leave one that falls.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.3")
case.table()

# %%
# Pieces 9 and 10 slide out: figure 6.18 of the source.

Frame(case.pictures["shelf"])
