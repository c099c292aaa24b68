"""
Wedges in a groove (section 6.2.3, table 6.2, figure 6.14)
==========================================================

Four blocks that rest in a groove are tilted about y, with a friction of 0.2. The limits of 3DEC, of
the source's CRA and of RBE are the same here. Below each limit the block stands, above it falls.
``drystone reproduce 6.2.3`` has all 24 rows.
"""

import drystone
from drystone.models import wedge
from drystone.view import Frame

PUBLISHED = {"a": 71.3, "b": 67.4, "c": 41.3, "d": 41.3}
"""Degrees."""
for kind, limit in PUBLISHED.items():
    blocks = wedge(kind)
    for angle in (limit - 1.0, limit + 1.0):
        load = drystone.LoadCase.tilt(blocks, (0.0, 1.0, 0.0), angle)
        result = drystone.check(drystone.Model.of(blocks, friction=0.2, load=load))
        print(f"type {kind}, published {limit:g}, at {angle:.1f} degrees: {result.verdict.value}")

# %%
# Type d at the last angle: the first motion.

Frame(result)
