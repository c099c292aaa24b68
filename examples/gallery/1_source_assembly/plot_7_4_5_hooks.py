"""
Blocks that hook and are turned in (section 7.4.5, figure 7.10)
===============================================================

A joggle along the bed joint hooks a voussoir over the course below. No straight motion takes it out
or in. A rotation about the direction of its course does. The shape is ours.
"""

from drystone.sequence import find_path
from drystone.shells import Layout, ShellBody, barrel_vault, build_shell
from drystone.view import Frame

for joggle in (0.0, 10.0, 20.0):
    shell = build_shell(barrel_vault(), Layout(courses=6, blocks=3), ShellBody(joggle_deg=joggle))
    model = shell.model(friction=0.6)
    lower = [n for n in model.assembly.names if n.startswith(("ground-c00", "c00", "c01", "c02"))]
    half = model.subset(lower)
    path = find_path(half, "c02-b01")
    way = "is turned out" if path.turning else "is lifted straight"
    print(f"joggle of {joggle:g} degrees: c02-b01 {way}, {len(path.poses)} poses")

# %%
# The lower courses of the last one, with their hooks.

Frame(half)
