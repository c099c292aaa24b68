"""
A joint turned
==============

A joint can be turned, moved or cut into a wedge. Both blocks change together and stay closed.
"""

import drystone
from drystone.design import wedge_joint
from drystone.models import arch
from drystone.view import Frame

model = drystone.Model.of(arch(thickness_ratio=0.15), friction=0.7)
sharper = wedge_joint(model, 5, 20.0)
print(model.assembly.volume.sum(), sharper.assembly.volume.sum())
Frame(sharper)

# %%
# The sum of the volumes is the same.
