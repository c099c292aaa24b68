"""
Plan, change, plan again (section 7.3, figure 7.5)
==================================================

The loop of the source: blocks are checked and planned, and where one needs help a joint is changed,
and the plan is made again. Here it runs on the source's snake. At a friction of 0.66 two of its
three blocks have to be held.
"""

import drystone
from drystone.design import recut_joints
from drystone.models import snake
from drystone.view import Frame

model = drystone.Model.of(snake(), friction=0.66)
print("before:", drystone.plan(model).counts)
found = recut_joints(model)
print("after: ", found.plan.counts)
for change in found.changes:
    print(change.kind, "by", change.value, "degrees:", change.description)

# %%
# The plan with the changed joint.

Frame(found.plan)
