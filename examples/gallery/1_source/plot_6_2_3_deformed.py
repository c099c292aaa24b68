"""
The deformed state, analysed again (section 6.2.3)
==================================================

A wedge in a groove is tilted and comes to rest after it has slid and turned a little. The blocks
where they rest are a model of their own, which is checked again.

The source tilts the wedge by 48 degrees. There the ends of the joints decide, so the tilt here
is 30 degrees.
"""

import drystone
from drystone.models import wedge
from drystone.view import Frame

blocks = wedge("c")
load = drystone.LoadCase.tilt(blocks, (1.0, 0.0, 0.0), 30.0)
settled = drystone.settle(blocks, load=load, friction=0.84)
print(settled.outcome.value, "-", settled.message)

# %%
# The check of the moved blocks.

moved = settled.path.moved_model()
print(drystone.check(moved).verdict.value)
Frame(settled)
