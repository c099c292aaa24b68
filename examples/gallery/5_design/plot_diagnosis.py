"""
Why does it fall?
=================

The diagnosis names each region that falls, how its blocks begin to move, and what is missing.
"""

import drystone
from drystone.models import shelf

why = drystone.diagnose(shelf(), friction=0.9)
for sentence in why.sentences:
    print(sentence)
