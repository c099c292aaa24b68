"""
Loaded bridge (section 7.2.4, figure 7.4)
=========================================

Five boxes stand on the deck of the bridge. They are 3.51 times as dense as its blocks.
"""

import drystone
from drystone.models import bridge
from drystone.programs import solve_cra
from drystone.programs.cra import CRAOptions
from drystone.view import Frame

model = drystone.Model.of(bridge(load=True), friction=0.9)
result = drystone.check(model)
print(result.verdict.value, "-", result.message)

# %%
# Published is a state of equation 5.6, with equal overlaps. It is found, too:

state = solve_cra(model, options=CRAOptions(tolerance=2e-6))
print(state.method, state.verdict.value)
Frame(result)
