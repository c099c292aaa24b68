"""Distance of a mesh from a patch, at vertices, edges and faces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.base.arrays import Floats
from drystone.shells.bond.tessellation import directed
from drystone.shells.surface.patch import Patch

PROJECTED = 2_000
"""Number of mesh points, those farthest from the patch, for which the nearest point of the patch is
searched. Chosen: bounds the time on large meshes."""


def distances(patch: Patch, at: Floats, loops: Sequence[Sequence[int]]) -> Floats:
    """Distance (k,) [m] from the patch of the vertices, then of the middles of edges and faces.

    ``at`` (p, 5) holds u, v and the position of every vertex. A few Gauss-Newton steps correct the
    parameters to those of the nearest point of the patch.
    """
    pairs = np.array([pair for loop in loops for pair in directed(loop)])
    ends = np.unique(np.sort(pairs, axis=1), axis=0)
    middles = np.array([at[list(loop)].mean(axis=0) for loop in loops])
    sample = np.concatenate([at, 0.5 * (at[ends[:, 0]] + at[ends[:, 1]]), middles])
    distance: Floats = np.linalg.norm(patch.point(*sample[:, :2].T) - sample[:, 2:], axis=1)
    worst = np.argsort(-distance, kind="stable")[:PROJECTED]
    uv, place = sample[worst, :2].copy(), sample[worst, 2:]
    for _ in range(4):
        tangent = np.stack(patch.tangents(*uv.T), axis=1)
        off = np.einsum("kai,ki->ka", tangent, place - patch.point(*uv.T))
        gram = np.einsum("kai,kbi->kab", tangent, tangent)
        determinant = gram[:, 0, 0] * gram[:, 1, 1] - gram[:, 0, 1] ** 2
        safe = np.where(determinant > 0.0, determinant, np.inf)
        step_u = (gram[:, 1, 1] * off[:, 0] - gram[:, 0, 1] * off[:, 1]) / safe
        step_v = (gram[:, 0, 0] * off[:, 1] - gram[:, 0, 1] * off[:, 0]) / safe
        uv = np.clip(uv + np.stack([step_u, step_v], axis=1), 0.0, 1.0)
        nearer = np.linalg.norm(patch.point(*uv.T) - place, axis=1)
        distance[worst] = np.minimum(distance[worst], nearer)
    return distance
