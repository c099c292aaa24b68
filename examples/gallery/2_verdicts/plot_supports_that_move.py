"""
Supports that move
==================

When a support moves, some joints open and others press more. The blocks follow by finite steps.
"""

import drystone
from drystone.models import arch
from drystone.view import Frame

model = drystone.Model.of(arch(thickness_ratio=0.2, voussoirs=7), friction=0.7)
last = model.assembly.names[int(model.assembly.fixed.nonzero()[0][-1])]
found = drystone.settle(model, {last: (0.005, 0.0, 0.0)})
print(found.message)
Frame(found)

# %%
# The page plays the motion, with the joints that open.
