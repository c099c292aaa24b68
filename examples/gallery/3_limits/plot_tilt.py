"""
The largest tilt, in every direction
====================================

A vault is tilted in eight directions until it falls.
"""

import drystone
from drystone.limits import tilt_sweep
from drystone.models import vault
from drystone.view import save_polar

model = drystone.Model.of(vault(), friction=0.6)
limits = tilt_sweep(model, 8)
print(limits)
figure = save_polar(limits)
