"""Boxes of random sizes that fill a cube; their joints are not aligned."""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np

from drystone.assembly import Assembly
from drystone.models.simple import box
from drystone.models.solids import require


def random_pack(count: int = 30, seed: int = 0, edge: float = 1.0) -> Assembly:
    """A cube that is cut into boxes: again and again the largest box is cut in two at random.

    The boxes touch exactly, partly, and in T-junctions. Those on the ground are fixed.

    Parameters
    ----------
    count
        Number of boxes.
    seed
        Of numpy's default generator; the same seed gives the same pack.
    edge : [m]
        Of the whole cube.

    Examples
    --------
    >>> pack = random_pack(12)
    >>> len(pack), round(float(pack.volume.sum()), 12)
    (12, 1.0)
    """
    require(count > 0, f"a pack of {count} boxes", "one or more")
    random = np.random.default_rng(seed)
    boxes = [(-(edge**3), (0.0, 0.0, 0.0), (edge, edge, edge))]
    while len(boxes) < count:
        _, low, high = heappop(boxes)
        length = np.subtract(high, low)
        axis = int(random.choice(3, p=length / length.sum()))
        place = low[axis] + float(random.uniform(0.3, 0.7)) * float(length[axis])
        for child in (
            (low, (*high[:axis], place, *high[axis + 1 :])),
            ((*low[:axis], place, *low[axis + 1 :]), high),
        ):
            heappush(boxes, (-float(np.prod(np.subtract(child[1], child[0]))), *child))
    corners = sorted((low, high) for _, low, high in boxes)
    blocks = tuple(
        box(np.subtract(high, low).tolist(), low, f"box-{i}")
        for i, (low, high) in enumerate(corners)
    )
    return Assembly(blocks, np.array([low[2] == 0.0 for low, _ in corners]))


__all__ = ["random_pack"]
