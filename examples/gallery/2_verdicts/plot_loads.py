"""
Loads besides the weight
========================

A load acts on a block, at a point, or on all blocks as an earthquake would.
"""

import drystone
from drystone.models import arch
from drystone.view import Frame

model = drystone.Model.of(arch(thickness_ratio=0.15), friction=0.7)
for share in (0.02, 0.05, 0.1):
    quake = model.with_load(drystone.LoadCase.seismic(model.assembly, share, 0.0))
    print(f"horizontal force of {share:.0%} of the weight:", drystone.check(quake).verdict.value)

# %%
# The forces with 2 % of the weight as a horizontal force.

quake = model.with_load(drystone.LoadCase.seismic(model.assembly, 0.02, 0.0))
Frame(drystone.check(quake))
