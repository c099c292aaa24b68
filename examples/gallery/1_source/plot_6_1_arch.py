"""
Arch and pi (section 6.1)
=========================

A semicircular arch is tilted until no forces balance it. The angle depends on friction only
when friction is small.
"""

import drystone
from drystone.limits import limit_friction
from drystone.models import arch
from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.1")
case.table()

# %%
# The arch beyond its limit of tilt: figure 6.3 of the source. Four hinges open, and the page
# plays the motion.

Frame(case.pictures["arch"])

# %%
# How much friction does it need (section 6.1.1)? Each joint needs its shear force divided by its
# normal force; the figure shows this as a share of the friction coefficient. The whole arch falls
# only below the least friction of any force distribution, which is smaller.

model = drystone.Model.of(arch(0.15, 36), friction=0.93)
result = drystone.check(model)
forces = result.resultants
print(f"largest friction that a joint needs: {(forces.tangential / forces.normal).max():.3f}")
print(limit_friction(model))
drystone.save_figure(result, preset="utilisation")
