"""Parametric model families, used by docs, tests and benchmarks.

Every family is a function that returns an :class:`~drystone.assembly.Assembly` of closed blocks
with planar faces that touch exactly; lengths are in metres, gravity is along -z.
"""

from drystone.base.settings import hold
from drystone.models.arches import arch, barrel_vault, buttressed_arch, vault
from drystone.models.bridges import segmental_bridge
from drystone.models.domes import cube_curve, curve_three_blocks, dome, lune
from drystone.models.joinery import bayonet, burr, dovetail, hooked_bar
from drystone.models.published import a_model, bridge, concave, h_model, shelf, snake, wedge
from drystone.models.simple import (
    box,
    harmonic_offsets,
    incline,
    overhang,
    prism,
    random_pack,
    stool,
    tower,
    two_blocks_on_incline,
    welded,
)
from drystone.models.walls import (
    buttressed_wall,
    corbelled_bridge,
    corbelled_wall,
    ferris_wall,
    leaning_column,
    wall,
    winding_column,
)

__all__ = [
    "a_model",
    "arch",
    "barrel_vault",
    "bayonet",
    "box",
    "bridge",
    "burr",
    "buttressed_arch",
    "buttressed_wall",
    "concave",
    "corbelled_bridge",
    "corbelled_wall",
    "cube_curve",
    "curve_three_blocks",
    "dome",
    "dovetail",
    "ferris_wall",
    "h_model",
    "harmonic_offsets",
    "hooked_bar",
    "incline",
    "leaning_column",
    "lune",
    "overhang",
    "prism",
    "random_pack",
    "segmental_bridge",
    "shelf",
    "snake",
    "stool",
    "tower",
    "two_blocks_on_incline",
    "vault",
    "wall",
    "wedge",
    "welded",
    "winding_column",
]

hold(globals())
