"""Open meshes from files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import FormatError
from drystone.base.files import PathLike, read_bytes
from drystone.base.units import scale_of
from drystone.io import format_of


def read_surface(
    path: PathLike, *, units: str | None = None
) -> tuple[Floats, list[tuple[int, ...]]]:
    """Vertices (p, 3) [m] and faces of an open mesh, from any format that has faces.

    Parameters
    ----------
    path
    units
        Of the numbers in the file: mm, cm, m, in or ft. When left out: the unit in the file, else
        metres.

    Raises
    ------
    FormatError
        The file cannot be read.
    InputError
        The unit is not known.
    """
    chosen = format_of(path)
    if chosen.read is None:
        raise FormatError(f"{chosen.title} can be written but not read", where=str(path))
    draft = chosen.read(read_bytes(path), Path(path))
    vertices, faces, offset = [], [], 0
    for shape in draft.shapes:
        points = np.asarray(shape.vertices, dtype=np.float64).reshape(-1, 3)
        vertices.append(points)
        faces += [tuple(int(i) + offset for i in face) for face in shape.faces]
        offset += len(points)
    if not faces:
        raise FormatError("holds no faces", where=str(path), remedy="export the surface as a mesh")
    return scale_of(units or draft.units or "m") * np.concatenate(vertices), faces
