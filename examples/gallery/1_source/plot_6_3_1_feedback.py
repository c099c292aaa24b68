"""
Design with feedback (section 6.3.1, figure 6.17)
=================================================

A designer changes a block and sees at once what it does. Here a script does this. With the first
fix one piece of the shelf still falls. Its lower joint is turned, degree by degree. After each step
the verdict says whether the shelf stands, and how large a force would have to hold the piece.
``drystone live`` does the same on a page, with a mouse.
"""

import numpy as np

import drystone
from drystone.design import still_edge, turn_joint
from drystone.models import shelf
from drystone.view import Frame

model = drystone.Model.of(shelf(1), friction=0.9)
names = model.assembly.names
pairs = zip(model.contacts.block_a, model.contacts.block_b, strict=True)
joint = [{names[a], names[b]} for a, b in pairs].index({"block-8", "block-10"})
for angle in (0.0, 3.0, 6.0, 8.0, 8.2, 9.0):
    turned = model
    if angle:
        turned = turn_joint(model, joint, -angle, pivot=still_edge(model, joint, -angle))
    result = drystone.check(turned)
    held = "" if result.stable else f", held by {np.linalg.norm(result.prop[:, :3]):.0f} N"
    print(f"turned by {angle:g} degrees: {result.verdict.value}{held}")

# %%
# The piece rests on its turned joint.

Frame(result)
