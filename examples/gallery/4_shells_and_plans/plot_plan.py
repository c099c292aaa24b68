"""
An order of assembly
====================

The structure is taken apart so that what remains stands, and that is reversed. Each block is
free, held or propped.
"""

import drystone
from drystone.models import corbelled_bridge
from drystone.view import Frame

plan = drystone.plan(drystone.Model.of(corbelled_bridge(), friction=0.7))
print(plan)
Frame(plan)
