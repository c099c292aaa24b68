"""
The largest tilt, in every direction
====================================

An arch is tilted towards four sides until it falls.
"""

import drystone
from drystone.limits import tilt_sweep
from drystone.models import arch
from drystone.view import save_figure

model = drystone.Model.of(arch(voussoirs=9), friction=0.6)
limits = tilt_sweep(model, 4)
print(limits)
figure = save_figure(limits)

# %%
# The figure has the limit in each direction, and the weakest one.
