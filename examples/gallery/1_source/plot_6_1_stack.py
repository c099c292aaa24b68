"""
Stack (figure 6.1)
==================

Two blocks with a joint that is inclined by 23.6 degrees. The least friction is the tangent of this
angle, 0.4369; the source gives 0.44.
"""

from scipy.optimize import linprog

import drystone
from drystone.limits import limit_friction
from drystone.models import two_blocks_on_incline
from drystone.programs import FrictionCone, Objective, RBEOptions, build_rbe, solve_rbe
from drystone.view import Frame

model = drystone.Model.of(two_blocks_on_incline(23.6), friction=0.5)
print(limit_friction(model))

# %%
# Equilibrium does not determine how the four corners of a joint share the force. The quadratic
# program of RBE uses all of them:

print("quadratic program [N]:", solve_rbe(model).force[:, 0].round())

# %%
# A linear program has many solutions here. The simplex method ends in a vertex of the set of
# solutions, where one corner carries nothing. Figure 6.1b of the source has one with two corners.

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
# The forces with a friction of 0.5, on contact springs. The upper block presses more on the lower
# corners of the joint.

Frame(drystone.check(model))
