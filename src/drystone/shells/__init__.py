"""Shells: a surface divided into courses and staggered blocks with planar or faceted joints."""

from drystone.base.settings import hold
from drystone.shells.fabrication import (
    FlatFace,
    block_frame,
    flat_faces,
    own_frame,
    schedule,
    write_blocks,
    write_unrolled,
)
from drystone.shells.formfinding import FormFound, find_form
from drystone.shells.materialise import shape_volume
from drystone.shells.meshfit import MeshFit, patch_from_mesh, several_supports, vaults_from_mesh
from drystone.shells.patch import Edge, Patch, Seam, Shape, Side
from drystone.shells.planarise import PlanarReport, planarise
from drystone.shells.shell_families import (
    barrel_vault,
    cross_vault,
    dome,
    pavilion_vault,
    rectangular_plan,
    shell_by_name,
    three_legged_plan,
    three_vault_plan,
    tri_dome,
)
from drystone.shells.shell_of_blocks import Shell, build_shell
from drystone.shells.shell_options import Ground, Intrados, JointForm, Layout, ShellBody
from drystone.shells.sources import (
    curve_through,
    patch_from_curves,
    patch_from_function,
    patch_from_grid,
    patch_from_sections,
    read_surface,
)

__all__ = [
    "Edge",
    "FlatFace",
    "FormFound",
    "Ground",
    "Intrados",
    "JointForm",
    "Layout",
    "MeshFit",
    "Patch",
    "PlanarReport",
    "Seam",
    "Shape",
    "Shell",
    "ShellBody",
    "Side",
    "barrel_vault",
    "block_frame",
    "build_shell",
    "cross_vault",
    "curve_through",
    "dome",
    "find_form",
    "flat_faces",
    "own_frame",
    "patch_from_curves",
    "patch_from_function",
    "patch_from_grid",
    "patch_from_mesh",
    "patch_from_sections",
    "pavilion_vault",
    "planarise",
    "read_surface",
    "rectangular_plan",
    "schedule",
    "several_supports",
    "shape_volume",
    "shell_by_name",
    "three_legged_plan",
    "three_vault_plan",
    "tri_dome",
    "vaults_from_mesh",
    "write_blocks",
    "write_unrolled",
]

hold(globals())
