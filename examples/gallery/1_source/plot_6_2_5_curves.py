"""
Curved joints (section 6.2.5, table 6.4, figure 6.16)
=====================================================

Three blocks with curved joints, each made of 20 plane strips, are tilted about y. 3DEC, Sofistik,
CRA and RBE all give a limit of 8 degrees.
"""

import drystone
from drystone.models import curve_three_blocks
from drystone.view import Frame

blocks = curve_three_blocks()
results = {}
for angle in (7.0, 9.0):
    load = drystone.LoadCase.tilt(blocks, (0.0, 1.0, 0.0), angle)
    results[angle] = drystone.check(drystone.Model.of(blocks, friction=0.84, load=load))
    print(f"at {angle:g} degrees: {results[angle].verdict.value} - {results[angle].message}")

# %%
# The forces at 7 degrees.

Frame(results[7.0])
