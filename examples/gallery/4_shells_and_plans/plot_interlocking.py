"""
A puzzle that holds itself
==========================

A burr puzzle stays together under every load once its key piece is fixed to another piece. Without
this, the key slides out first.
"""

import drystone
from drystone.models import burr
from drystone.sequence import gravity_region, interlocking
from drystone.view import save_chart

model = drystone.Model.of(burr(), friction=0.3)
print("key and x-low held:", interlocking(model, ("key", "x-low")).holds)
print("x-low held, first to move:", interlocking(model, "x-low").names)

# %%
# Directions of gravity in which it stays together with x-low held: straight down is in the middle,
# straight up at the rim.

figure = save_chart(gravity_region(model, "x-low", directions=60).figure())
