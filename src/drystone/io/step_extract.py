"""The solids of a STEP file as a GLB: run by ``extract.py``, never imported."""

import importlib
from typing import Any

ANGLE = 0.0873
"""[rad] Largest angle between the normals of neighbouring facets of a curved face: 5 degrees."""
_CHORD = 0.01
"""Largest distance of a facet from its face, by the size of an edge."""


def content(data: bytes, options: dict[str, Any]) -> bytes:  # noqa: ARG001
    """The GLB, in metres with z up; nothing if there is none."""
    cascadio: Any = importlib.import_module("cascadio")
    try:
        return bytes(
            cascadio.load(data, tol_linear=_CHORD, tol_angular=ANGLE, tol_relative=True,
                          use_parallel=False)
        )  # fmt: skip
    except RuntimeError:
        return b""
