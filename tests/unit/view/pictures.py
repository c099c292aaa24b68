"""Small models with hand-made answers, and readers of what was written."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace
from typing import Any

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.contacts import Contacts
from drystone.geometry.frames import frames_from_normals
from drystone.model import Model
from drystone.models import box, tower
from drystone.results import Result, Verdict

EVIL = "</script><b onclick=\"alert('x')\">&amp;$\\u0000{{DATA}}"


def stacked(heights: list[float], rectangle: tuple[float, float, float, float]) -> Contacts:
    """Contacts of blocks on top of each other: block i under block i + 1 at ``heights[i]``."""
    x0, y0, x1, y1 = rectangle
    corners = [[(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)] for z in heights]
    m = len(heights)
    return Contacts(
        np.arange(m),
        np.arange(m) + 1,
        frames_from_normals(np.tile([0.0, 0.0, 1.0], (m, 1))),
        np.full(m, (x1 - x0) * (y1 - y0)),
        np.full(m, 0.5),
        np.array(corners, dtype=float).reshape(-1, 3),
        np.repeat(np.arange(m), 4),
    )


def falling_tower(names: tuple[str, ...] = ("foot", "middle", "top")) -> Result:
    """Three unit cubes; the top one falls, so there are no forces."""
    assembly = Assembly(
        tuple(b.renamed(n) for b, n in zip(tower(3).blocks, names, strict=True)),
        np.array([True, False, False]),
    )
    contacts = stacked([1.0, 2.0], (0.0, 0.0, 1.0, 1.0))
    motion = np.zeros((3, 6))
    motion[2] = [0.5, 0.0, -0.2, 0.0, 0.4, 0.0]
    model = Model(assembly, contacts)
    return Result(
        "check",
        Verdict.UNSTABLE,
        model,
        "The top falls.",
        mechanism=motion,
        falling=(2,),
    )


def pulled_tower() -> Result:
    """The same tower as a result that has forces, one of them a pull."""
    force = np.zeros((8, 3))
    force[:, 0] = [3000.0, 3000.0, 3000.0, 3000.0, 2000.0, 2000.0, 2000.0, -500.0]
    force[0, 1] = 400.0
    return replace(falling_tower(), verdict=Verdict.STABLE, falling=(), mechanism=None, force=force)


def l_block(name: str = "L") -> Block:
    """A concave block: an L of three unit cells each way, one deep."""
    profile = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    vertices = np.array([(x, y, z) for y in (0, 1) for x, z in profile], dtype=float)
    sides = [(i, i + 6, (i + 1) % 6 + 6, (i + 1) % 6) for i in range(6)]
    return Block(vertices, ((0, 1, 2, 3, 4, 5), (11, 10, 9, 8, 7, 6), *sides), name)


def notched() -> Assembly:
    """An L with a box in its notch and one beside it, on a slab."""
    return Assembly(
        (
            l_block(),
            box((1, 1, 1), (1, 0, 1), "inner"),
            box((1, 1, 1), (2, 0, 1), "outer"),
            box((4, 2, 0.3), (-0.5, -0.5, -0.3), "slab"),
        ),
        np.array([False, False, False, True]),
    )


def page_data(text: str) -> dict[str, Any]:
    """The data of a page, arrays decoded."""
    found = re.search(r'<script id="drystone-data" type="application/json">(.*?)</script>', text)
    assert found is not None
    data = json.loads(found.group(1))
    blobs = [base64.b64decode(blob, validate=True) for blob in data.pop("blobs")]

    def decoded(value: Any) -> Any:
        if isinstance(value, dict) and "blob" in value:
            return np.frombuffer(blobs[value["blob"]], dtype=f"<{value['type']}").reshape(
                value["shape"]
            )
        if isinstance(value, dict):
            return {key: decoded(item) for key, item in value.items()}
        if isinstance(value, list):
            return [decoded(item) for item in value]
        return value

    result: dict[str, Any] = decoded(data)
    return result
