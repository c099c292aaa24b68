"""STEP of CAD programs: each solid is a block with the name of its part. Needs cascadio.

Curved faces become facets whose normals differ by at most 5 degrees. Units are those of the file.
Source of the format: ISO 10303-21; it is read by Open CASCADE, in a process of its own.
"""

from __future__ import annotations

import re
from pathlib import Path

from drystone.base.errors import FormatError, counted, require
from drystone.io import glb
from drystone.io.draft import Draft
from drystone.io.outside import content_of

PROGRAM = Path(__file__).with_name("step_extract.py")
_SOLID = re.compile(rb"=\s*(MANIFOLD_SOLID_BREP|BREP_WITH_VOIDS|FACETED_BREP)\s*\(")


def read(data: bytes, path: Path) -> Draft:
    """Blocks of a STEP file."""
    require("cascadio", "step", "reading STEP")
    if not data.lstrip().startswith(b"ISO-10303-21"):
        raise FormatError("is no STEP file", where=str(path), remedy="export it as STEP (AP214)")
    solids = len(_SOLID.findall(data))
    scene = content_of(data, path, PROGRAM, {})
    if not scene or not solids:
        what = "holds no solid" if scene else "cannot be read: it is damaged"
        raise FormatError(what, where=str(path), remedy="export the blocks as solids (AP214)")
    draft = glb.read(scene, path)
    if len(draft.shapes) < solids:
        raise FormatError(
            f"{counted(solids - len(draft.shapes), 'solid')} of {solids} cannot be read",
            where=str(path),
            remedy="heal the solids in the CAD program, and export them again",
        )
    return draft
