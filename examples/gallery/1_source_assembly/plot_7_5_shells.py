"""
Shells (section 7.5, figures 7.11 to 7.17)
==========================================

A vault, a dome, a shell of three vaults and a tri-dome, which is a dome on three feet: how many
blocks can be set freely, and how many have to be held or propped. The shapes are ours: the source's
dimensions are not known to us.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("7.5.1")
case.table()

# %%
# The vault, arch by arch, with the wedges that the search finds.

Frame(case.pictures["vault"])

# %%
# Before the loop, with shallow wedges: six blocks are held and five propped.

Frame(case.pictures["vault-first"])

# %%
# The dome.

dome = reproduce("7.5.2")
dome.table()

# %%

Frame(dome.pictures["dome"])

# %%
# The shell of three vaults, and the tri-dome.

shells = reproduce("7.5.3")
shells.table()

# %%

Frame(shells.pictures["three-vault-shell"])

# %%

Frame(shells.pictures["tri-dome"])
