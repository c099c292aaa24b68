"""
Shells (section 7.5)
====================

A vault, a dome and a shell of three vaults: how many blocks can be set freely, and how many
have to be held or propped.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("7.5")
case.table()

# %%
# The shell of three vaults with its forces.

Frame(case.pictures["three-vault-shell"])
