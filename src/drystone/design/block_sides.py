"""The sides of an arch, and the directions along them in which the ends of its joints slide."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.base.errors import InputError
from drystone.design.vertex_measures import BlockVertices, owners_of
from drystone.design.vertex_places import TOGETHER, Places, axis_of
from drystone.geometry.polygon import area_vector
from drystone.model import Model

SIDES = {"intrados": 1.0, "extrados": -1.0}
"""Sides by whether their faces look to the middle of the supports, or away from it."""


def on_side(model: Model, side: str, along: str | None) -> Bools:
    """Whether each vertex (v,) is on the intrados, or on the extrados.

    That is where a free block has a face that no joint covers and that looks to the middle of the
    joints with supports, or away from it. Faces across the axis of the prisms are on neither side.

    Raises
    ------
    InputError
        The side is unknown, nothing stands on supports, or no face is on that side.
    """
    if side not in SIDES:
        raise InputError(f"there is no side '{side}'", remedy="give intrados or extrados")
    assembly, contacts = model.assembly, model.contacts
    fixed = assembly.fixed
    feet = fixed[contacts.block_a] != fixed[contacts.block_b]
    if not feet.any():
        raise InputError("nothing stands on supports", remedy="fix the blocks that it stands on")
    middle = contacts.centroid[feet].mean(axis=0)
    start = BlockVertices.of(assembly).start
    found = np.zeros(int(start[-1]), dtype=bool)
    for i in np.flatnonzero(~fixed).tolist():
        block = assembly.blocks[i]
        own = (contacts.block_a == i) | (contacts.block_b == i)
        for loop in block.faces:
            corner = block.vertices[list(loop)]
            area = area_vector(corner)
            normal = area / np.linalg.norm(area)
            if along is not None and abs(normal[axis_of(along)]) > 1.0 - TOGETHER:
                continue
            flat = np.abs(contacts.frame[own, 0] @ normal) > 1.0 - TOGETHER
            away = np.abs((contacts.centroid[own] - corner[0]) @ normal)
            if (flat & (away < TOGETHER * block.size)).any():
                continue
            if SIDES[side] * float(normal @ (middle - corner.mean(axis=0))) > 0.0:
                found[int(start[i]) + np.array(loop)] = True
    if not found.any():
        raise InputError(f"no face is on the {side}", remedy="leave that side out")
    return found


def slides(model: Model, places: Places) -> list[Floats]:
    """The directions (w, 3), one or none, in which the end of a joint at each place slides.

    An end is a place that two blocks share. From it one edge of each block leads away from the
    joint; the direction is that between the ends of the two edges.

    Raises
    ------
    InputError
        No joint has such ends.
    """
    edges: list[set[tuple[int, int]]] = [set() for _ in range(len(model))]
    start = BlockVertices.of(model.assembly).start
    for i, block in enumerate(model.assembly.blocks):
        for loop in block.faces:
            ring = places.group[int(start[i]) + np.array([*loop, loop[0]])].tolist()
            for one, other in pairwise(ring):
                if one != other:
                    edges[i] |= {(one, other), (other, one)}
    at = [{one for one, _ in each} for each in edges]
    owner = owners_of(model.assembly)
    ways = []
    for place in range(places.count):
        blocks = np.unique(owner[places.group == place]).tolist()
        ends: list[int] = []
        if len(blocks) == 2:
            shared = at[blocks[0]] & at[blocks[1]]
            away = [{b for a, b in edges[i] if a == place} - shared for i in blocks]
            ends = [next(iter(one)) for one in away if len(one) == 1]
        if len(ends) != 2:
            ways.append(np.zeros((0, 3)))
            continue
        along = places.point[ends[1]] - places.point[ends[0]]
        ways.append((along / np.linalg.norm(along))[None])
    if not any(len(one) for one in ways):
        raise InputError(
            "no joint has ends that two blocks share",
            remedy="move vertices freely, or blocks as a whole",
        )
    return ways
