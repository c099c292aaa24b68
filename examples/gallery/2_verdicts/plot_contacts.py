"""
What touches what
=================

The search for contacts reports what it found, what it left out and why. Read this report before
the verdict.
"""

import drystone
from drystone.models import bridge
from drystone.view import Frame

found = drystone.find_contacts(bridge(), friction=0.66)
print(found.report)
print(found.contacts)
found.contacts[0]

# %%
# All of them on the blocks.

Frame(drystone.Model.of(bridge(), friction=0.66))
