"""Vertices that pass through a face of another block on a path, as contacts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.ragged import Ragged, expand
from drystone.contacts import Contacts
from drystone.detection.candidates import near_blocks
from drystone.detection.edgecontacts import Wires
from drystone.detection.patches import Patches, kept_patches_of
from drystone.detection.tolerances import LARGEST, DetectionOptions
from drystone.geometry import planar
from drystone.geometry.frames import frames_from_normals, rotations
from drystone.mechanics.meeting import PARALLEL, Apart, least_friction
from drystone.model import Model

THROUGH = 1e-4
"""Depth below a face, by the smaller block's size, at which a vertex has passed through it. Chosen:
far above the overlap of springs, far below what a block moves until it falls."""
INSIDE = 1e-2
"""Distance from the outline of the face, by that size, above which it is inside. Nearer to it, a
vertex slides along the next face, which carries it."""
NEAR = 1e-3
"""Distance from the face, by the same size, within which such a vertex is still on it. Chosen."""
ROWS = 100_000
"""Corners or vertices times poses that are looked at together."""
MOVED = 1e-3
"""Travel by size from which on the vertices of a block, and those near it, are looked at."""


def vertices_met(model: Model, positions: Floats, reach: float) -> Apart:
    """The vertices that pass through a face on a path, with their gap at the beginning.

    A vertex of a joint in the plane of the face is none: the law of the joint moves its corner.

    Parameters
    ----------
    model
        With all contacts that were followed.
    positions : (s, n, 6) [m, rad]
        From the beginning.
    reach
        Largest distance from the face at the beginning, by the smaller block's size.
    """
    assembly = model.assembly
    patches, size = kept_patches_of(assembly), np.cbrt(assembly.volume)
    distance = min(reach, LARGEST["search"])
    a, b = near_blocks(patches, DetectionOptions(gap=0.0, search=distance))
    travel = np.linalg.norm(positions[-1, :, :3], axis=1)
    moved = travel + np.linalg.norm(positions[-1, :, 3:], axis=1) * size > MOVED * size
    chosen = moved[a] | moved[b]
    a, b = a[chosen], b[chosen]
    body, other = np.concatenate([a, b]), np.concatenate([b, a])
    vertex, patch, mine, theirs = _candidates(model, patches, body, other, reach)
    smaller, region = np.minimum(size[mine], size[theirs]), _Regions(patches)
    found = np.zeros(len(patch), dtype=bool)
    left, centre = np.arange(len(patch)), assembly.centroid - patches.origin
    step = max(ROWS // max(len(patch), 1), 1)
    for first in range(1, len(positions), step):
        some = positions[first : first + step]
        turn = rotations(some[..., 3:].reshape(-1, 3)).reshape(*some.shape[:2], 3, 3)
        i, j = mine[left], theirs[left]
        arm = (vertex[left] - centre[i])[:, :, None]
        moved = (turn[:, i] @ arm)[..., 0] + (centre[i] - centre[j]) + some[:, i, :3]
        local = (turn[:, j].swapaxes(2, 3) @ (moved - some[:, j, :3])[..., None])[..., 0]
        off = local + (centre[j] - patches.centre[patch[left]])
        below = (off * patches.normal[patch[left]]).sum(axis=2) < -THROUGH * smaller[left]
        gone = np.flatnonzero(below.any(axis=0))
        which, at = left[gone], off[below[:, gone].argmax(axis=0), gone]
        found[which] = region.contain(patch[which], at, -INSIDE * smaller[which])
        left = np.delete(left, gone)
    keep = np.flatnonzero(found)
    return _contacts(model, patches, vertex[keep], patch[keep], mine[keep], theirs[keep])


def still_on_faces(model: Model, motion: Floats, point: Floats, interfaces: Sequence[int]) -> bool:
    """Whether contacts at points lie on a face of both of their blocks.

    Parameters
    ----------
    model
    motion : (n, 6) [m, rad]
        Of the blocks from the beginning.
    point : (k, 3) [m]
        Where the corners are.
    interfaces
        With one corner each.
    """
    assembly, contacts = model.assembly, model.contacts
    patches = kept_patches_of(assembly)
    region, size = _Regions(patches), np.cbrt(assembly.volume)
    turn, centre = rotations(motion[:, 3:]), assembly.centroid
    for i in interfaces:
        at = point[contacts.start[i]]
        blocks = int(contacts.block_a[i]), int(contacts.block_b[i])
        margin = NEAR * min(size[list(blocks)])
        for block in blocks:
            local = turn[block].T @ (at - centre[block] - motion[block, :3]) + centre[block]
            patch = np.arange(*patches.first_patch[block : block + 2])
            off = local - patches.origin - patches.centre[patch]
            level = np.abs((off * patches.normal[patch]).sum(axis=1)) <= margin
            if not region.contain(patch[level], off[level], margin).any():
                return False
    return True


class _Regions:
    """Patches as shapely polygons in their own planes, made when they are asked for."""

    def __init__(self, patches: Patches) -> None:
        self.patches, self.known = patches, dict[int, shapely.Polygon]()
        self.frame = frames_from_normals(patches.normal)

    def contain(self, patch: Ints, off: Floats, margin: Floats | float) -> Bools:
        """Whether points, relative to the centres of patches (q,), lie over them.

        Nearer than the margin to the outline they do not, where it is negative; where it is
        positive those so far outside do.
        """
        flat = np.einsum("qij,qj->qi", self.frame[patch, 1:], off)
        shapes = np.array([self._of(one) for one in patch.tolist()], dtype=object)
        points = shapely.points(flat)
        within = shapely.contains(shapes, points)
        off_outline = shapely.distance(shapely.boundary(shapes), points)
        return np.where(within, off_outline, -off_outline) >= -np.asarray(margin)

    def _of(self, patch: int) -> shapely.Polygon:
        if patch not in self.known:
            p = self.patches
            part, ring = Ragged(p.first_ring).take([patch])
            corners, corner = Ragged(p.ring_start).take(ring)
            flat = (p.corner[corner] - p.centre[patch]) @ self.frame[patch, 1:].T
            self.known[patch] = planar.regions(flat, corners.start, part.owner)[0]
        return self.known[patch]


def _candidates(
    model: Model, patches: Patches, body: Ints, other: Ints, reach: float
) -> tuple[Floats, Ints, Ints, Ints]:
    """Vertices (c, 3), patches that they are in front of, and the blocks of both."""
    assembly = model.assembly
    wires = Wires.of(assembly, patches.origin, np.unique(body))
    count = np.array([len(block.vertices) for block in assembly.blocks])
    first = np.zeros(len(assembly), dtype=np.intp)
    used = np.unique(body)
    first[used] = np.cumsum(count[used]) - count[used]
    size, boxes = np.cbrt(assembly.volume), assembly.bounds - patches.origin
    pair, own = expand(np.zeros(len(body), dtype=np.intp), count[body])
    point = wires.point[first[body[pair]] + own]
    wide = reach * np.minimum(size[body], size[other])[pair, None]
    box = boxes[other[pair]]
    around = ((point >= box[:, 0] - wide) & (point <= box[:, 1] + wide)).all(axis=1)
    pair, point = pair[around], point[around]
    row, patch = expand(patches.first_patch[other[pair]], patches.of_block.counts[other[pair]])
    vertex, mine, theirs = point[row], body[pair[row]], other[pair[row]]
    smaller = np.minimum(size[mine], size[theirs])
    height = ((vertex - patches.centre[patch]) * patches.normal[patch]).sum(axis=1)
    wide = (reach * smaller)[:, None]
    near = (height >= -THROUGH * smaller) & (height <= reach * smaller)
    near &= (vertex >= patches.low[patch] - wide).all(axis=1)
    near &= (vertex <= patches.high[patch] + wide).all(axis=1)
    near &= ~_of_joint(model, patches, patch, mine, theirs, height, smaller)
    return vertex[near], patch[near], mine[near], theirs[near]


def _of_joint(
    model: Model,
    patches: Patches,
    patch: Ints,
    mine: Ints,
    theirs: Ints,
    height: Floats,
    smaller: Floats,
) -> Bools:
    """Which vertices lie in the plane of a face that carries a joint of the two blocks."""
    contacts, count = model.contacts, len(model)
    low, high = (
        np.minimum(contacts.block_a, contacts.block_b),
        np.maximum(contacts.block_a, contacts.block_b),
    )
    found = np.zeros(len(patch), dtype=bool)
    level = np.flatnonzero(height < THROUGH * smaller)
    order = np.argsort(low * count + high, kind="stable")
    keys = (low * count + high)[order]
    wanted = np.minimum(mine, theirs)[level] * count + np.maximum(mine, theirs)[level]
    begin, end = np.searchsorted(keys, wanted), np.searchsorted(keys, wanted, side="right")
    row, at = expand(begin, end - begin)
    joint = order[at]
    alike = (
        np.abs((contacts.frame[joint, 0] * patches.normal[patch[level[row]]]).sum(axis=1))
        > PARALLEL
    )
    found[level[row[alike]]] = True
    return found


def _contacts(
    model: Model, patches: Patches, vertex: Floats, patch: Ints, mine: Ints, theirs: Ints
) -> Apart:
    """A contact at each vertex, open by its height above the face."""
    normal = patches.normal[patch]
    height = ((vertex - patches.centre[patch]) * normal).sum(axis=1)
    of_a = mine < theirs  # the vertex is of block a
    count = len(patch)
    found = Contacts(
        np.minimum(mine, theirs),
        np.maximum(mine, theirs),
        frames_from_normals(np.where(of_a[:, None], -normal, normal)),
        np.zeros(count),
        np.zeros(count),
        vertex + patches.origin,
        np.arange(count, dtype=np.intp),
    )
    none = np.zeros(count)
    gap = np.stack([np.where(of_a, none, height), np.where(of_a, height, none)], axis=1)
    return Apart(found.with_friction(least_friction(model, found)), gap)
