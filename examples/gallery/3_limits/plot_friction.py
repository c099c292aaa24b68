"""
The least friction
==================

A barrel vault stands with enough friction. Below some friction coefficient it slides apart.
"""

import drystone
from drystone.limits import limit_friction
from drystone.models import barrel_vault
from drystone.view import Frame

limit = limit_friction(drystone.Model.of(barrel_vault(), friction=0.8))
print(limit)
Frame(limit)

# %%
# The two stages are the last friction at which it stands, and the first at which it falls.
