"""
Why does it fall?
=================

The diagnosis names each region that falls, how its blocks begin to move, and what is missing.
"""

import drystone
from drystone.models import shelf
from drystone.view import Frame

why = drystone.diagnose(shelf(), friction=0.9)
for sentence in why.reasons:
    print(sentence)

# %%
# The first motion, the joints that carry nothing, and the props that would hold the pieces.

Frame(why)
