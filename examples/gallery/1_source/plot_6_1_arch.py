"""
Arch and pi (section 6.1)
=========================

A semicircular arch is tilted until no forces balance it. The angle depends on friction only
when friction is small.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.1")
case.table()

# %%
# The arch beyond its limit of tilt: figure 6.3 of the source. Four hinges open, and the page
# plays the motion.

Frame(case.pictures["arch"])
