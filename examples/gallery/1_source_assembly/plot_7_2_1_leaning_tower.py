"""
Leaning tower (section 7.2.1, figure 7.1)
=========================================

A leaning monolith is cut from the bottom up; the source cuts from the top. Each cut is chosen so
that the part above it stands on what is below. Then the tower can be built from the ground without
a prop. The shape is ours: the source gives no dimensions.
"""

from drystone.design import CutOptions, cut_until_free
from drystone.models import prism
from drystone.view import Frame

monolith = prism([(0.0, 0.0), (1.0, 0.0), (2.5, 4.0), (1.5, 4.0)], (0.0, 1.0), "tower")
cut = cut_until_free(monolith, options=CutOptions(blocks=8))
print(cut.plan)
Frame(cut.plan)

# %%
# The page plays the order from the ground up.
