"""
A puzzle that holds itself
==========================

With one key fixed, a burr puzzle holds in every direction of gravity. The discs show the
directions in which it does.
"""

import drystone
from drystone.models import burr
from drystone.sequence import gravity_region, interlocking
from drystone.view import Frame

model = drystone.Model.of(burr(), friction=0.3)
print(interlocking(model, "key"))
Frame(drystone.check(model.with_supports("lowest")))
