"""Shells: a surface divided into courses and staggered blocks with planar or faceted joints."""

from drystone.base.settings import hold
from drystone.shells.fabrication import FlatFace as FlatFace
from drystone.shells.fabrication import block_frame as block_frame
from drystone.shells.fabrication import flat_faces as flat_faces
from drystone.shells.fabrication import own_frame as own_frame
from drystone.shells.fabrication import schedule as schedule
from drystone.shells.fabrication import write_blocks as write_blocks
from drystone.shells.fabrication import write_unrolled as write_unrolled
from drystone.shells.formfinding import FormFound as FormFound
from drystone.shells.formfinding import find_form as find_form
from drystone.shells.materialise import shape_volume as shape_volume
from drystone.shells.meshfit import MeshFit as MeshFit
from drystone.shells.meshfit import patch_from_mesh as patch_from_mesh
from drystone.shells.meshfit import several_supports as several_supports
from drystone.shells.meshfit import vaults_from_mesh as vaults_from_mesh
from drystone.shells.patch import Edge as Edge
from drystone.shells.patch import Patch as Patch
from drystone.shells.patch import Seam as Seam
from drystone.shells.patch import Shape as Shape
from drystone.shells.patch import Side as Side
from drystone.shells.planarise import PlanarReport as PlanarReport
from drystone.shells.planarise import planarise as planarise
from drystone.shells.shell_families import barrel_vault as barrel_vault
from drystone.shells.shell_families import cross_vault as cross_vault
from drystone.shells.shell_families import dome as dome
from drystone.shells.shell_families import pavilion_vault as pavilion_vault
from drystone.shells.shell_families import rectangular_plan as rectangular_plan
from drystone.shells.shell_families import shell_by_name as shell_by_name
from drystone.shells.shell_families import three_legged_plan as three_legged_plan
from drystone.shells.shell_families import three_vault_plan as three_vault_plan
from drystone.shells.shell_families import tri_dome as tri_dome
from drystone.shells.shell_of_blocks import Shell as Shell
from drystone.shells.shell_of_blocks import build_shell as build_shell
from drystone.shells.shell_options import Ground as Ground
from drystone.shells.shell_options import Intrados as Intrados
from drystone.shells.shell_options import JointForm as JointForm
from drystone.shells.shell_options import Layout as Layout
from drystone.shells.shell_options import ShellBody as ShellBody
from drystone.shells.sources import curve_through as curve_through
from drystone.shells.sources import patch_from_function as patch_from_function
from drystone.shells.sources import patch_from_grid as patch_from_grid
from drystone.shells.sources import patch_from_sections as patch_from_sections
from drystone.shells.sources import read_surface as read_surface

__all__ = hold(globals())
