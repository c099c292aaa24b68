"""
A barrel vault of wedged voussoirs
==================================

A surface is divided into courses, and courses into voussoirs in running bond. Each bed joint is a
wedge of two planes.
"""

import drystone
from drystone.shells import Layout, ShellBody, barrel_vault, build_shell
from drystone.view import Frame

shape = barrel_vault(span=5.0, length=4.0, rise=2.0)
shell = build_shell(shape, Layout(courses=9, blocks=3, wedge=0.2), ShellBody(thickness=0.35))
result = drystone.check(shell.model(friction=0.6))
print(result.verdict.value, "-", result.message)
Frame(result)

# %%
# Each voussoir lies in a notch between two blocks below.
