"""Parametric model families, used by docs, tests and benchmarks.

Every family is a function that returns an :class:`~drystone.assembly.Assembly` of closed blocks
with planar faces that touch exactly; lengths are in metres, gravity is along -z.
"""

from drystone.base.settings import hold
from drystone.models.arches import arch as arch
from drystone.models.arches import barrel_vault as barrel_vault
from drystone.models.arches import buttressed_arch as buttressed_arch
from drystone.models.arches import vault as vault
from drystone.models.bridges import segmental_bridge as segmental_bridge
from drystone.models.domes import cube_curve as cube_curve
from drystone.models.domes import curve_three_blocks as curve_three_blocks
from drystone.models.domes import dome as dome
from drystone.models.domes import lune as lune
from drystone.models.joinery import bayonet as bayonet
from drystone.models.joinery import burr as burr
from drystone.models.joinery import dovetail as dovetail
from drystone.models.joinery import hooked_bar as hooked_bar
from drystone.models.published import a_model as a_model
from drystone.models.published import bridge as bridge
from drystone.models.published import concave as concave
from drystone.models.published import h_model as h_model
from drystone.models.published import shelf as shelf
from drystone.models.published import snake as snake
from drystone.models.published import wedge as wedge
from drystone.models.simple import box as box
from drystone.models.simple import harmonic_offsets as harmonic_offsets
from drystone.models.simple import incline as incline
from drystone.models.simple import overhang as overhang
from drystone.models.simple import prism as prism
from drystone.models.simple import random_pack as random_pack
from drystone.models.simple import stool as stool
from drystone.models.simple import tower as tower
from drystone.models.simple import two_blocks_on_incline as two_blocks_on_incline
from drystone.models.simple import welded as welded
from drystone.models.walls import buttressed_wall as buttressed_wall
from drystone.models.walls import corbelled_bridge as corbelled_bridge
from drystone.models.walls import corbelled_wall as corbelled_wall
from drystone.models.walls import ferris_wall as ferris_wall
from drystone.models.walls import leaning_column as leaning_column
from drystone.models.walls import wall as wall
from drystone.models.walls import winding_column as winding_column

__all__ = hold(globals())
