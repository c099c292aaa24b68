"""
From a surface to voussoirs (sections 7.4.1 to 7.4.3, figures 7.6 to 7.8)
=========================================================================

A cross vault of four patches. In each of them courses follow the springings, and head joints are
shifted from course to course. Two patches share the blocks at their seam. Then all joints are made
planar together. The shape is ours: the source's dimensions are not known to us.
"""

import drystone
from drystone.shells import Layout, ShellBody, build_shell, cross_vault
from drystone.view import Frame

shell = build_shell(
    cross_vault(), Layout(courses=11, width=0.8, wedge=0.1), ShellBody(thickness=0.2)
)
print(shell)
print(shell.planar)

# %%
# Each joint has one plane, so the contacts need no search.

result = drystone.check(shell.model(friction=0.84))
print(result.verdict.value, "-", result.message)
Frame(result)
