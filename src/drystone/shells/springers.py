"""Supports of a shell: fixed springers, or ground blocks under them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.geometry.polyhedron import loop_edges
from drystone.shells.materialise import Pins
from drystone.shells.pattern import Tessellation


def springers(mesh: Tessellation) -> Bools:
    """Which cells (c,) stand on a support."""
    supported = set(mesh.supported)
    return np.array([any(edge in supported for edge in loop_edges(cell)) for cell in mesh.cells])


def add_ground(mesh: Tessellation, pins: Pins, depth: float) -> tuple[Tessellation, Pins, Bools]:
    """A ground block under every springer, with the same support face.

    Its other side is the support face moved out of the shell by ``depth`` [m], normal to the
    border. The third value tells which cells (c,) are ground.
    """
    outwards = _outwards(mesh)
    new_vertex = {old: len(mesh.point) + i for i, old in enumerate(outwards)}
    cells, names, place = list(mesh.cells), list(mesh.names), []
    supported = set(mesh.supported)
    for cell, name, course in zip(mesh.cells, mesh.names, mesh.course.tolist(), strict=True):
        for k, chain in enumerate(_chains(cell, supported)):
            cells.append((*reversed(chain), *(new_vertex[v] for v in chain)))
            names.append(f"ground-{name}" + (f"-{k}" if k else ""))
            place.append(course)
    old = list(outwards)
    shift = depth * np.array(list(outwards.values())).reshape(-1, 3)
    low, high = pins.point[pins.start[:-1][old]], pins.point[pins.start[1:][old] - 1]
    far = np.stack([low + shift, high + shift], axis=1).reshape(-1, 3)
    added = len(place)
    grounded = replace(
        mesh,
        point=np.concatenate([mesh.point, mesh.point[old] + shift]),
        normal=np.concatenate([mesh.normal, mesh.normal[old]]),
        up=np.concatenate([mesh.up, mesh.up[old]]),
        inner=np.concatenate([mesh.inner, np.zeros(len(old), dtype=bool)]),
        cells=tuple(cells),
        names=tuple(names),
        course=np.concatenate([mesh.course, np.array(place, dtype=np.intp)]),
        position=np.concatenate([mesh.position, np.full(added, -1, dtype=np.intp)]),
        of_patch=np.concatenate([mesh.of_patch, np.full(added, -1, dtype=np.intp)]),
        crest=np.concatenate([mesh.crest, np.full((added, 3), np.nan)]),
    )
    start = np.concatenate([pins.start, pins.start[-1] + 2 * np.arange(1, len(old) + 1)])
    ground = np.concatenate([np.zeros(len(mesh.cells), dtype=bool), np.ones(added, dtype=bool)])
    extended = replace(pins, point=np.concatenate([pins.point, far]), start=start)
    return grounded, extended, ground


def _outwards(mesh: Tessellation) -> dict[int, Floats]:
    """Per supported vertex the vector that offsets its edges out of the shell by 1, mitred."""
    at: dict[int, list[Floats]] = {}
    for a, b in mesh.supported:
        along = mesh.point[b] - mesh.point[a]
        square = np.cross(along, mesh.normal[a] + mesh.normal[b])
        square /= np.linalg.norm(square)
        at.setdefault(a, []).append(square)
        at.setdefault(b, []).append(square)
    moves = {}
    for vertex, squares in at.items():
        if len(squares) == 1:
            moves[vertex] = squares[0]
        else:
            total = squares[0] + squares[1]
            moves[vertex] = total / max(1.0 + float(squares[0] @ squares[1]), 0.1)
    return moves


def _chains(cell: tuple[int, ...], supported: set[tuple[int, int]]) -> list[list[int]]:
    """Runs of supported edges of one cell, as vertices in its order."""
    edges = loop_edges(cell)
    on = [edge in supported for edge in edges]
    if not any(on):
        return []
    first = next((i for i, flag in enumerate(on) if not flag), 0)
    chains: list[list[int]] = []
    open_chain = False
    for edge, flag in zip(edges[first:] + edges[:first], on[first:] + on[:first], strict=True):
        if flag and open_chain:
            chains[-1].append(edge[1])
        elif flag:
            chains.append([edge[0], edge[1]])
        open_chain = flag
    return chains
