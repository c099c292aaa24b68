"""What the Grasshopper script makes of meshes, without Rhino."""

from __future__ import annotations

import json
import runpy
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

import drystone
from drystone.models import arch

SCRIPT = Path(__file__).parents[2] / "integrations" / "rhino" / "drystone_grasshopper.py"


def mesh_of(block: drystone.Block, scale: float) -> Any:
    """A stand-in for a mesh of RhinoCommon: triangles and quadrangles only."""
    points = [SimpleNamespace(X=x, Y=y, Z=z) for x, y, z in scale * block.vertices]
    faces = []
    for a, b, c, *rest in block.faces:
        assert len(rest) < 2
        faces.append(SimpleNamespace(A=a, B=b, C=c, D=rest[0] if rest else c, IsTriangle=not rest))
    return SimpleNamespace(Vertices=points, Faces=faces)


def test_meshes_in_millimetres_become_the_model(tmp_path):
    functions = runpy.run_path(str(SCRIPT))
    assembly = arch(0.2, 8)
    meshes = [mesh_of(block, 1000.0) for block in assembly.blocks]
    free = [mesh for mesh, fixed in zip(meshes, assembly.fixed, strict=True) if not fixed]
    held = [mesh for mesh, fixed in zip(meshes, assembly.fixed, strict=True) if fixed]
    asked = functions["model_of"](free, held, 0.7, 0.001)
    path = tmp_path / "model.json"
    path.write_text(json.dumps(asked["content"]))
    model = drystone.read(path, friction=asked["friction"])
    assert np.allclose(sorted(model.assembly.volume), sorted(assembly.volume))
    assert model.assembly.fixed.tolist() == [False] * 8 + [True] * 2
    assert drystone.check(model).stable
    answer = {"falling": {"count": 1, "first": ["block-3"]}}
    assert functions["falling_of"](answer, free) == [free[3]]
