"""
An order of assembly
====================

The structure is taken apart block by block, so that the rest always stands. The order of assembly
is the reverse. Each block is free, held or propped.
"""

import drystone
from drystone.models import corbelled_bridge
from drystone.view import Frame

plan = drystone.plan(drystone.Model.of(corbelled_bridge(), friction=0.7))
print(plan)
Frame(plan)

# %%
# Each block has the number of its step.
