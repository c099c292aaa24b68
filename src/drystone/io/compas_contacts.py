"""Interfaces in a COMPAS file: polygons with a frame whose z axis goes from block to block."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from drystone.assembly import Assembly
from drystone.contacts import DEFAULT_FRICTION, Contacts
from drystone.geometry import polygon
from drystone.geometry.arrays import Floats
from drystone.geometry.frames import frames_from_normals
from drystone.io.draft import Extras
from drystone.io.jsontext import Field


def reader(
    graph: Field, key: str, nodes: Sequence[str]
) -> Callable[[Assembly, float], Extras] | None:
    """What makes the contacts of a graph's edges; ``None`` when it stores none.

    Parameters
    ----------
    graph
    key
        Attribute of the edges: ``interfaces`` in compas_assembly, ``contacts`` in compas_model.
    nodes
        Node of each block, by position.
    """
    position = {node: i for i, node in enumerate(nodes)}
    stored: list[tuple[int, int, Field]] = []
    for start, neighbours in graph.get("edge", {}).items():
        for end, edge in neighbours.items():
            if isinstance(edge.value, dict) and edge.has(key):
                for interface in edge[key].elements():
                    if start not in position or end not in position:
                        raise edge.error("joins nodes that are no blocks")
                    stored.append((position[start], position[end], interface))
    if not stored:
        return None

    def finish(assembly: Assembly, scale: float) -> Extras:
        return _contacts(stored, assembly, scale), (), ()

    return finish


def _contacts(
    stored: Sequence[tuple[int, int, Field]], assembly: Assembly, scale: float
) -> Contacts:
    block_a = np.array([a for a, _, _ in stored], dtype=np.intp)
    block_b = np.array([b for _, b, _ in stored], dtype=np.intp)
    corners = [scale * _points(field) for _, _, field in stored]
    start = np.concatenate([[0], np.cumsum([len(points) for points in corners])])
    point = np.concatenate(corners)
    area = polygon.area_vectors(point, start)
    frame = np.stack(
        [_frame(field, vector) for (_, _, field), vector in zip(stored, area, strict=True)]
    )
    middle = polygon.loop_means(point, start)
    side_a = ((assembly.centroid[block_a] - middle) * frame[:, 0]).sum(axis=1)
    side_b = ((assembly.centroid[block_b] - middle) * frame[:, 0]).sum(axis=1)
    turned = (side_a > 0.0) & (side_b < 0.0)  # some writers let the normal point from b to a
    frame[turned] *= np.array([-1.0, 1.0, -1.0])[:, None]
    signed = (area * frame[:, 0]).sum(axis=1)
    return Contacts(
        block_a,
        block_b,
        frame,
        np.abs(signed),
        np.full(len(stored), DEFAULT_FRICTION),
        np.concatenate(
            [
                points if sign >= 0.0 else points[::-1]
                for points, sign in zip(corners, signed, strict=True)
            ]
        ),
        np.repeat(np.arange(len(stored)), np.diff(start)),
    )


def _plain(field: Field) -> Field:
    value = field.value
    if isinstance(value, dict) and "dtype" in value:
        return field["data"] if "data" in value else field["value"]
    return field


def _points(interface: Field) -> Floats:
    points = [_plain(point).floats(3) for point in _plain(interface)["points"].elements()]
    if not points:
        raise interface.error("has no points")
    return np.array(points)


def _frame(interface: Field, area: Floats) -> Floats:
    """Rows n, u, v: the stored frame made orthonormal, or one about the polygon's own normal."""
    inside = _plain(interface)
    if not inside.has("frame"):
        if not area.any():
            raise interface.error("has neither a frame nor an area")
        return frames_from_normals((area / np.linalg.norm(area))[None])[0]
    stored = _plain(inside["frame"])
    x, y = stored["xaxis"].floats(3), stored["yaxis"].floats(3)
    normal = np.cross(x, y)
    size = float(np.linalg.norm(normal))
    if not 1e-12 < size < np.inf:
        raise inside["frame"].error("has axes that span no plane")
    normal = normal / size
    u = x / np.linalg.norm(x)
    return np.stack([normal, u, np.cross(normal, u)])
