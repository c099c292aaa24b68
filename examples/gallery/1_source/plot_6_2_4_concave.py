"""
Hooked planks and hoods (sections 6.2.4 and 6.2.5, tables 6.3 and 6.4)
======================================================================

A plank that hooks under a slab, and a hood whose curved rim rests on another one, are tilted. The
limits are those of 3DEC, in whole degrees. Each model is checked 1.5 degrees below and above its
limit. Where the joints decide, its blocks are followed by finite steps.

Three rows of the source are left out, because our limits differ from those of 3DEC there: the short
plank with friction 0.84 (41.5 degrees, published 40), and the short and the tall hood tilted about
xy (65.6 and 41.5 degrees, published 68 and 39). The page *Validation* has all rows.
"""

import drystone
from drystone.models import concave, cube_curve
from drystone.view import Frame

Y, MINUS_X = (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)
PUBLISHED = {
    "short plank, friction 0.1": (concave("short"), Y, 0.1, 5.0),
    "long plank, friction 0.1": (concave("long"), Y, 0.1, 10.0),
    "long plank, friction 0.84": (concave("long"), Y, 0.84, 56.0),
    "short hood, friction 0.84": (cube_curve("short"), MINUS_X, 0.84, 72.0),
    "tall hood, friction 0.84": (cube_curve("tall"), MINUS_X, 0.84, 41.0),
}
"""Blocks, axis of the tilt, friction, limit [degrees]."""
results = {}
for name, (blocks, axis, friction, limit) in PUBLISHED.items():
    for angle in (limit - 1.5, limit + 1.5):
        load = drystone.LoadCase.tilt(blocks, axis, angle)
        result = drystone.check(drystone.Model.of(blocks, friction=friction, load=load))
        print(f"{name}, published {limit:g}, at {angle:g} degrees: {result.verdict.value}")
        results[name, angle] = result

# %%
# The long plank at 54.5 degrees. It is held by its hook.

Frame(results["long plank, friction 0.84", 54.5])

# %%
# The short hood at 70.5 degrees, and the forces on its rim.

Frame(results["short hood, friction 0.84", 70.5])
