"""
Wedge arch (section 6.3.3, figure 6.19)
=======================================

A thin semicircular arch falls. Its joints are made wedges of two planes, only where the penalty
form shows tension, until it stands. Then each wedge is taken back to the least that is needed. The
source's dimensions are not known to us. This arch has 15 voussoirs and a thickness of 0.04 of
its radius.
"""

import drystone
from drystone.design import sharpen
from drystone.models import arch
from drystone.view import Frame

model = drystone.Model.of(arch(0.04, 15), friction=0.7)
print("plane joints:", drystone.check(model).verdict.value)
sharper = sharpen(model)
print(sharper.message)

# %%
# The arch with its wedges. :doc:`/reference/design` has a table of twelve such arches.

result = drystone.check(sharper.model)
print("with wedges:", result.verdict.value, "-", result.message)
Frame(result)
