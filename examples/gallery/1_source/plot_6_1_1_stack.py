"""
Stack (section 6.1.1, figures 6.1 to 6.3)
=========================================

Two stacked blocks: level (figure 6.1), pushed out (6.2), and with a joint that is inclined by 23.6
degrees (6.3). There the least friction is the tangent of this angle, 0.4369; the source gives 0.44.
"""

from scipy.optimize import linprog

import drystone
from drystone.models import overhang, two_blocks_on_incline
from drystone.programs import FrictionCone, Objective, RBEOptions, build_rbe, solve_rbe
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

chosen = RBEOptions(objective=Objective.LINEAR, cone=FrictionCone.octagon(), tension=False)
program = build_rbe(model, options=chosen)
equal, rest = slice(None, program.cones.zero), slice(program.cones.zero, None)
vertex = linprog(
    program.linear,
    A_ub=program.matrix[rest],
    b_ub=program.right[rest],
    A_eq=program.matrix[equal],
    b_eq=program.right[equal],
    bounds=(None, None),
    method="highs-ds",
)
corners = program.value(vertex.x, "force").reshape(-1, 3)
print("linear program, simplex [N]:", corners[:, 0].round())

# %%
# A block that is pushed out too far falls. The penalty form shows the pull that would hold it.

Frame(solve_rbe(overhang([0.6]), friction=0.8))
