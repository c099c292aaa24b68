"""
The deformed state, analysed again (section 6.2.3, figure 6.14c)
================================================================

A wedge in a groove is tilted and comes to rest after it has slid and turned a little. The blocks
where they rest are a model of their own, which is checked again.

Between 40 and 48 degrees about the axis xy30 the source's wedge of type c slides a little and
rests. From 38.1 degrees on our check is undecided, since which block carries the common edge of
both joints decides. With the edge on the moving block it rests, and the moved blocks stand.
"""

import drystone
from drystone.models import wedge
from drystone.view import Frame

blocks = wedge("c")
load = drystone.LoadCase.tilt(blocks, (3.0**0.5, 1.0, 0.0), 46.0)
tilted = drystone.Model.of(blocks, load=load, friction=0.84)
print("where it was drawn:", drystone.check(tilted).verdict.value)
settled = drystone.settle(tilted)
print(settled.outcome.value, "-", settled.message)

# %%
# The check of the moved blocks.

moved = settled.path.moved_model()
print("where it rests:", drystone.check(moved).verdict.value)
Frame(settled)
