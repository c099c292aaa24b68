"""
What would make it stand?
=========================

Changes of the joints are tried region by region. Each one that is listed was checked on the
whole structure.
"""

import drystone
from drystone.design import find_mends
from drystone.models import shelf
from drystone.view import Frame

mends = find_mends(drystone.Model.of(shelf(), friction=0.9), regions=1)
for mend in mends.mends[:5]:
    print(mend)

# %%
# The shelf after the first of them. One region was mended, the other one still falls.

Frame(mends.mends[0].result)
