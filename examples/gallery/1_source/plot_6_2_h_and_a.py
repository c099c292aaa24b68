"""
Blocks between walls (section 6.2)
==================================

Equilibrium alone believes in prestress that nothing brings about. A block between two vertical
walls passes it at any friction. The coupled analysis says that it falls.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("6.2")
case.table()

# %%
# The block between the posts falls. No load presses it against them.

Frame(case.pictures["h"])
