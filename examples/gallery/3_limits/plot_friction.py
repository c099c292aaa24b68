"""
The least friction
==================

A barrel vault stands down to some friction coefficient, and slides apart below it.
"""

import drystone
from drystone.limits import limit_friction
from drystone.models import barrel_vault
from drystone.view import Frame

limit = limit_friction(drystone.Model.of(barrel_vault(), friction=0.8))
print(limit)
Frame(limit)
