"""
Blocks between walls (section 5.1.1, figure 5.1)
================================================

Equilibrium alone includes prestress that nothing causes. A block between two vertical
walls passes it at any friction. The coupled analysis says that it falls.
"""

from drystone.reproduce import reproduce
from drystone.view import Frame

case = reproduce("5.1.1")
case.table()

# %%
# The block between the posts falls. No load presses it against them.

Frame(case.pictures["h"])
