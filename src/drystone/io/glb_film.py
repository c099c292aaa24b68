"""Writing an animated GLB: a node per block that moves, with the keys of its frames.

Source of the format: Khronos glTF 2.0 specification, section 3.11 (animations).
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.base.arrays import Floats
from drystone.base.files import PathLike, write_bytes
from drystone.io.draft import Contents
from drystone.io.glb import FLOAT, Z_UP
from drystone.io.glb_write import container, glb_content
from drystone.model import Model


def write_film(model: Model, time: Floats, positions: Floats, path: PathLike) -> None:
    """Write blocks that move as an animated GLB, to a temporary name that is then renamed.

    Every block is a node of its name about its centroid; those that move have keys of translation
    and rotation, between which viewers interpolate.

    Parameters
    ----------
    model
    time : (s,) [s], ascending
    positions : (s, n, 6) [m, rad]
        Translations of the centroids and rotation vectors from the beginning.
    path
    """
    content, binary = glb_content(Contents(model.assembly))
    keys = _Keys(binary, content)
    centroid = model.assembly.centroid @ Z_UP
    nodes = content["nodes"]
    channels: list[dict[str, Any]] = []
    samplers: list[dict[str, int]] = []
    when = keys.add(time[:, None], "SCALAR", bounds=True)
    for i in range(len(model.assembly)):
        # the surface is in world coordinates: a child that is moved back has it
        inner = {"mesh": nodes[i].pop("mesh"), "translation": (-centroid[i]).tolist()}
        nodes[i] |= {"children": [len(nodes)], "translation": centroid[i].tolist()}
        nodes.append(inner)
        if not positions[:, i].any():
            continue
        place = centroid[i] + positions[:, i, :3] @ Z_UP
        turn = Rotation.from_rotvec(positions[:, i, 3:] @ Z_UP).as_quat()
        # the same rotation has two quaternions: viewers take the short way between near ones
        flips = np.cumprod(np.where((turn[1:] * turn[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))
        turn[1:] *= flips[:, None]
        for path_of, values, kind in (("translation", place, "VEC3"), ("rotation", turn, "VEC4")):
            channels.append({"sampler": len(samplers), "target": {"node": i, "path": path_of}})
            samplers.append({"input": when, "output": keys.add(values, kind)})
    if channels:
        content["animations"] = [{"name": "film", "channels": channels, "samplers": samplers}]
    binary = keys.binary()
    content["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
    write_bytes(path, container(text, binary))


class _Keys:
    """Arrays of keys, put behind the surfaces."""

    def __init__(self, surfaces: bytes, content: dict[str, Any]) -> None:
        self.parts = [surfaces + b"\0" * (-len(surfaces) % 4)]
        self.length = len(self.parts[0])
        self.content = content

    def add(self, values: Floats, kind: str, *, bounds: bool = False) -> int:
        """The number of the accessor of an array (s, c)."""
        data = np.ascontiguousarray(values, dtype="<f4")
        views, accessors = self.content["bufferViews"], self.content["accessors"]
        views.append({"buffer": 0, "byteOffset": self.length, "byteLength": data.nbytes})
        made = {
            "bufferView": len(views) - 1,
            "componentType": FLOAT,
            "count": len(data),
            "type": kind,
        }
        if bounds:
            made |= {"min": data.min(axis=0).tolist(), "max": data.max(axis=0).tolist()}
        accessors.append(made)
        self.parts.append(data.tobytes())
        self.length += data.nbytes
        return len(accessors) - 1

    def binary(self) -> bytes:
        """All of them."""
        return b"".join(self.parts)
