"""
An arch that stands, and one that falls
=======================================

A semicircular arch under its own weight needs a thickness of 0.1075 times its radius
(Milankovitch 1907).
"""

import drystone
from drystone.models import arch
from drystone.view import Frame

stands = drystone.check(arch(thickness_ratio=0.12), friction=0.7)
print(stands.verdict.value, "-", stands.message)
Frame(stands)

# %%
# In a thinner arch the thrust line does not fit. The page plays how it falls: hinges are blue.

falls = drystone.check(arch(thickness_ratio=0.1), friction=0.7)
print(falls.verdict.value, "-", falls.message)
Frame(falls)
