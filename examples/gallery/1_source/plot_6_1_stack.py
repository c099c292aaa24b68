"""
Stack (figure 6.1)
==================

Two blocks with a joint that is inclined by 23.6 degrees. The least friction is the tangent of this
angle, 0.4369; the source gives 0.44.
"""

import drystone
from drystone.limits import limit_friction
from drystone.models import two_blocks_on_incline
from drystone.view import Frame

model = drystone.Model.of(two_blocks_on_incline(23.6), friction=0.5)
print(limit_friction(model))

# %%
# The forces with a friction of 0.5. The upper block presses more on the lower corners of the joint.

Frame(drystone.check(model))
