"""Shells: from a surface to courses, a staggered pattern, and blocks with planar joints."""

from drystone.shells.build import (
    Body,
    Ground,
    Intrados,
    Layout,
    SharedFace,
    Shell,
    build_shell,
    shape_volume,
)
from drystone.shells.families import barrel_vault, cross_vault, dome, pavilion_vault
from drystone.shells.patch import Patch, Side
from drystone.shells.planarise import PlanarOptions, PlanarReport, planarise
from drystone.shells.shape import Edge, Seam, Shape
from drystone.shells.sources import (
    curve_through,
    patch_from_curves,
    patch_from_function,
    patch_from_grid,
    patch_from_sections,
)

__all__ = [
    "Body",
    "Edge",
    "Ground",
    "Intrados",
    "Layout",
    "Patch",
    "PlanarOptions",
    "PlanarReport",
    "Seam",
    "Shape",
    "SharedFace",
    "Shell",
    "Side",
    "barrel_vault",
    "build_shell",
    "cross_vault",
    "curve_through",
    "dome",
    "patch_from_curves",
    "patch_from_function",
    "patch_from_grid",
    "patch_from_sections",
    "pavilion_vault",
    "planarise",
    "shape_volume",
]
