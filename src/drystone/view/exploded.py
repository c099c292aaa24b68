"""Exploded views: each block is moved along a free direction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.answer.scene import Layer, Scene
from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats
from drystone.contacts import Contacts
from drystone.sequence.freedom import TOLERANCE, freedom

_MOST_CONES = 400
"""Largest number of blocks whose free directions are searched. Chosen: it takes a third of a
second."""
_LOOKED_AT = 20
"""Number of blocks of which the freest is removed if none can be removed straight. Chosen."""


def exploded(assembly: Assembly, contacts: Contacts, foot: Floats) -> Floats:
    """Translations (n, 3) [m] of the blocks of a model that is taken apart.

    Blocks are taken out one after the other. Each leaves in the free direction that is nearest to
    the one away from the ``foot`` (3,), as far as it is from there. Supports stay. Blocks that no
    translation frees, and all blocks of large models, move straight away from the foot.

    Examples
    --------
    The blocks of a tower go up:

    >>> from drystone.detection import find_contacts
    >>> from drystone.models import tower
    >>> blocks = tower(3)
    >>> found = find_contacts(blocks).contacts
    >>> exploded(blocks, found, np.array([0.5, 0.5, 0.0])).round(2).tolist()
    [[0.0, 0.0, 0.0], [0.0, 0.0, 1.5], [0.0, 0.0, 2.5]]
    """
    from_foot = assembly.centroid - foot
    far = np.linalg.norm(from_foot, axis=1)
    away = np.where(
        far[:, None] > 0.0, from_foot / np.maximum(far, 1e-300)[:, None], [[0.0, 0.0, 1.0]]
    )
    a, b, normal = contacts.block_a, contacts.block_b, contacts.frame[:, 0]
    opening = np.stack([-(normal * away[a]).sum(axis=1), (normal * away[b]).sum(axis=1)])
    direction, cones = away.copy(), 0
    left: Bools = ~assembly.fixed
    while left.any():
        here = left | assembly.fixed
        both = here[a] & here[b]
        least = np.full(len(assembly), np.inf)
        np.minimum.at(least, a[both], opening[0, both])
        np.minimum.at(least, b[both], opening[1, both])
        leaves = left & (least >= -TOLERANCE)
        if not leaves.any():
            if cones >= _MOST_CONES:
                break
            tried = np.flatnonzero(left)
            tried = tried[np.argsort(-far[tried], kind="stable")][:_LOOKED_AT]
            cones += len(tried)
            best, share = -1, -np.inf
            for i in tried.tolist():
                into = np.concatenate([-normal[both & (a == i)], normal[both & (b == i)]])
                free = freedom(into, away[i]).preferred
                if free is not None and float(free @ away[i]) > share:
                    best, share, direction[i] = i, float(free @ away[i]), free
            if best < 0:
                break
            leaves = np.arange(len(assembly)) == best
        left = left & ~leaves
    direction[left] = away[left]
    return np.where(assembly.fixed[:, None], 0.0, far[:, None] * direction)


def ways_apart(scene: Scene) -> Floats:
    """Translations (n, 3) [m] of :func:`exploded` from the middle of the foot of a scene."""
    foot = scene.centre.copy()
    foot[2] = scene.bounds[0, 2]
    return exploded(scene.assembly, scene.contacts, foot)


def taken_apart(scene: Scene, share: float) -> Scene:
    """A scene whose blocks have gone a share of their ways; joints stay between their blocks."""
    away = share * ways_apart(scene)
    contacts, assembly = scene.contacts, scene.assembly
    between = 0.5 * (away[contacts.block_a] + away[contacts.block_b])

    def carried(layer: Layer) -> Layer:
        owner = layer.interface if layer.interface is not None else layer.block
        if owner is None:
            return layer
        shift = (between if layer.interface is not None else away)[owner]
        if layer.start is not None:
            shift = np.repeat(shift, np.diff(layer.start), axis=0)
        return replace(layer, position=layer.position + shift)

    blocks = [b.transformed(translation=v) for b, v in zip(assembly.blocks, away, strict=True)]
    return replace(
        scene,
        assembly=replace(assembly, blocks=tuple(blocks)),
        contacts=replace(contacts, point=contacts.point + between[contacts.interface]),
        stages=tuple(
            replace(one, motion=None, path=None, layers=tuple(carried(x) for x in one.layers))
            for one in scene.stages
        ),
    )
