"""
Arch and pi (section 6.2.1, table 6.1, figure 6.11)
===================================================

A semicircular arch is tilted until no forces balance it. The angle depends on friction only
when friction is small.
"""

import math

import drystone
from drystone.limits import limit_friction
from drystone.models import arch
from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.2.1")
case.table()

# %%
# The arch just beyond its limit of tilt (figure 6.11). Four hinges open, and the page plays the
# motion.

blocks, friction = arch(0.15, 36), math.tan(math.radians(43.0))
load = drystone.LoadCase.tilt(blocks, (0.0, 1.0, 0.0), 8.3)
beyond = drystone.check(drystone.Model.of(blocks, friction=friction, load=load))
print(beyond.verdict.value, "-", beyond.message)
Frame(beyond)

# %%
# How much friction does it need ? Each joint needs its shear force divided by its
# normal force; the figure shows this as a share of the friction coefficient. The whole arch falls
# only below the least friction of any force distribution, which is smaller.

model = drystone.Model.of(blocks, friction=friction)
result = drystone.check(model)
forces = result.resultants
print(f"largest friction that a joint needs: {(forces.tangential / forces.normal).max():.3f}")
print(limit_friction(model))
drystone.save_figure(result, preset="utilisation")
