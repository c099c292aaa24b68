"""
The least thickness of an arch
==============================

The least thickness of a semicircular arch is 0.1075 of its radius (Milankovitch 1907). Heyman 1969
gives 0.106.
"""

import drystone
from drystone.limits import limit_thickness
from drystone.models import arch
from drystone.view import Frame

limit = limit_thickness(lambda t: arch(thickness_ratio=t), thick=0.2, thin=0.05, friction=0.9)
print(limit)

# %%
# The thickest arch that falls, and its hinges.

Frame(drystone.check(arch(thickness_ratio=limit.rest.falls), friction=0.9))
