"""
Dome (section 6.1.3, figures 6.7 to 6.10)
=========================================

A hemispherical dome of plane-faced voussoirs, tilted as a whole.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.1.3")
case.table()

# %%
# The dome upright, with the force in every joint.

Frame(case.pictures["dome"])
