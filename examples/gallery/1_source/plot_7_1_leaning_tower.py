"""
Leaning tower (figure 7.1)
==========================

A column leans and is cut square to its axis. It is built from the ground without a prop. The shape
is ours: the source gives no dimensions.
"""

import drystone
from drystone.models import leaning_column
from drystone.view import Frame

plan = drystone.plan(drystone.Model.of(leaning_column(), friction=0.7))
print(plan)
Frame(plan)
