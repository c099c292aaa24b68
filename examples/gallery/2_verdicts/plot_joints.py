"""
The forces in every joint
=========================

A verdict comes with the forces that prove it, as a table that can become a data frame.
"""

import drystone
from drystone.models import vault

result = drystone.check(vault(), friction=0.6)
joints = result.joints()
joints.to_pandas().head()

# %%
# The joint with the largest utilisation, and the figure of the whole vault.

rows = sorted(joints, key=lambda row: -row["friction_use"])
print(rows[0]["joint"], f"uses {rows[0]['friction_use']:.0%} of its friction")
figure = drystone.save_figure(result)
