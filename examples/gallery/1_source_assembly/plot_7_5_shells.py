"""
Shells (section 7.5)
====================

A vault, a dome, a shell of three vaults and a tri-dome, which is a dome on three feet: how many
blocks can be set freely, and how many have to be held or propped. The shapes are ours: the source's
dimensions are not known to us.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("7.5")
case.table()

# %%
# The vault, course by course.

Frame(case.pictures["vault"])

# %%
# The dome.

Frame(case.pictures["dome"])

# %%
# The shell of three vaults.

Frame(case.pictures["three-vault-shell"])

# %%
# The tri-dome.

Frame(case.pictures["tri-dome"])
