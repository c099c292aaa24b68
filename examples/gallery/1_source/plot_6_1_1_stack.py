"""
Stack (section 6.1.1, figures 6.1 to 6.3)
=========================================

Two stacked blocks: level (figure 6.1), pushed out (6.2), and with a joint that is inclined by 23.6
degrees (6.3). There the least friction is the tangent of this angle, 0.4369; the source gives 0.44.
"""

import drystone
from drystone.models import overhang, two_blocks_on_incline
from drystone.programs import FrictionRule, Objective, find_forces, solve_rbe
from drystone.reproduce import reproduce
from drystone.view import Frame

reproduce("6.1.1").table()

# %%
# The level joint. Equilibrium does not determine how its four corners share the force.

model = drystone.Model.of(two_blocks_on_incline(0.0), friction=0.8)
print("quadratic program [N]:", solve_rbe(model).force[:, 0].round())

# %%
# A linear program has many solutions here. The simplex method ends in a vertex of the set of
# solutions, where two corners carry all, as in figure 6.1b.

vertex = find_forces(model, objective=Objective.VERTEX).result
print("linear program, simplex [N]:", vertex.force[:, 0].round())

# %%
# A block that is pushed out too far falls. The penalty form shows the pull that would hold it.

Frame(find_forces(overhang([0.6]), friction=0.8))

# %%
# The inclined joint. Friction bounds the forces at corners by 0.8; the joint as a whole is held
# against a threshold of 0.6, and within it.

inclined = drystone.Model.of(two_blocks_on_incline(23.6), friction=0.8)
Frame(find_forces(inclined, rule=FrictionRule.NET, threshold=0.6))
