"""
Where joints decide
===================

For rigid blocks, equilibrium does not determine how joints share a force. Where the answer depends
on it, the blocks are followed by finite steps until they rest or fall.
"""

import drystone
from drystone.models import concave
from drystone.view import Frame

assembly = concave("short")
for angle in (30.0, 38.5, 44.0):
    load = drystone.LoadCase.tilt(assembly, (0.0, 1.0, 0.0), angle)
    result = drystone.check(drystone.Model.of(assembly, friction=0.84, load=load))
    print(f"{angle:g} degrees: {result.verdict.value} - {result.message}")

# %%
# The hooked plank falls at the last of these angles, although prestress could hold it.

Frame(result)
