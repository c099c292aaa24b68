"""Many plane polygons at once: convex intersection, clean-up, areas, perimeters.

Polygons are counter-clockwise. *Padded* arrays (q, c, 2) hold one polygon per row, its number of
corners in ``count``; entries beyond are arbitrary. *Flat* arrays hold the corners (l, 2) one after
another with ``start`` (q + 1,).
"""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, marked, plane_cross
from drystone.base.ragged import Ragged

Padded = tuple[Floats, Ints]
_Flat = tuple[Floats, Ints]


def pad(corner: Floats, first: Ints, count: Ints, *, reverse: bool = False) -> Padded:
    """Rows of a padded array from ranges of flat corners (l, d), each range one polygon.

    Parameters
    ----------
    first, count : (q,)
    reverse
        Whether to run through each range backwards.
    """
    width = int(count.max(initial=0))
    step = np.minimum(np.arange(width), count[:, None] - 1)
    place = (first + count - 1)[:, None] - step if reverse else first[:, None] + step
    return corner[place], count


def flatten(polygons: Padded) -> _Flat:
    """Flat corners of padded ones."""
    corner, count = polygons
    keep = np.arange(corner.shape[1]) < count[:, None]
    return corner[keep], Ragged.from_counts(count).start


def cut(polygons: Padded, offset: Floats, slope: Floats) -> Padded:
    """The part of each convex polygon where ``offset + slope . x >= 0``.

    Parameters
    ----------
    offset : (q,)
    slope : (q, 2)

    Notes
    -----
    Source: Sutherland, Hodgman 1974, Reentrant polygon clipping.
    """
    corner, count = polygons
    side = offset[:, None] + corner[:, :, 0] * slope[:, :1] + corner[:, :, 1] * slope[:, 1:]
    valid = np.arange(corner.shape[1]) < count[:, None]
    inside = (side >= 0.0) & valid
    left = inside.sum(axis=1)
    rows = np.flatnonzero((left < count) & (left > 0))
    count = np.where(left == 0, 0, count)
    if len(rows) == 0:
        return corner, count
    part, width = _cut_rows(corner[rows], count[rows], side[rows], inside[rows], valid[rows])
    wide = max(corner.shape[1], part.shape[1])
    result = np.zeros((len(corner), wide, 2))
    result[:, : corner.shape[1]] = corner
    result[rows, : part.shape[1]] = part
    count[rows] = width
    return result, count


def _cut_rows(
    corner: Floats, count: Ints, side: Floats, inside: Bools, valid: Bools
) -> tuple[Floats, Ints]:
    number = np.arange(len(corner))[:, None]
    after = np.arange(1, corner.shape[1] + 1)[None, :] % np.maximum(count[:, None], 1)
    after = np.minimum(after, corner.shape[1] - 1)
    side_after = side[number, after]
    crossing = (inside != inside[number, after]) & valid
    drop = side - side_after
    share = np.where(crossing, side, 0.0) / np.where(crossing, drop, 1.0)
    meet = corner + share[:, :, None] * (corner[number, after] - corner)
    emit = np.stack([inside, crossing], axis=2).reshape(len(corner), -1)
    points = np.stack([corner, meet], axis=2).reshape(len(corner), -1, 2)
    width = emit.sum(axis=1)
    place = np.cumsum(emit, axis=1) - 1
    out = np.zeros((len(corner), int(width.max()), 2))
    row, column = np.nonzero(emit)
    out[row, place[row, column]] = points[row, column]
    return out, width


def intersect_convex(subject: Padded, clip: Padded) -> Padded:
    """Intersection of convex polygons with convex polygons, row by row.

    Examples
    --------
    >>> square = np.array([[[0.0, 0], [2, 0], [2, 2], [0, 2]]])
    >>> four = np.array([4])
    >>> corner, count = intersect_convex((square, four), (square + 1.0, four))
    >>> corner[0, : count[0]].tolist()
    [[2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [1.0, 1.0]]
    """
    corner, count = clip
    for edge in range(corner.shape[1]):
        here = corner[:, edge]
        after = corner[np.arange(len(corner)), (edge + 1) % np.maximum(count, 1)]
        along = after - here
        along[edge >= count] = 0.0
        inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
        subject = cut(subject, -(inward * here).sum(axis=1), inward)
    return subject


def areas(corner: Floats, start: Ints) -> Floats:
    """Signed area (q,) of flat polygons, positive counter-clockwise."""
    loops = Ragged(start)
    local = corner - corner[loops.spread(loops.first)]
    after = local[loops.following]
    return 0.5 * loops.sum(plane_cross(local, after))


def perimeters(corner: Floats, start: Ints) -> Floats:
    """Length (q,) of the outline of flat polygons."""
    loops = Ragged(start)
    edge = corner[loops.following] - corner
    return loops.sum(np.hypot(edge[:, 0], edge[:, 1]))


def cleaned(corner: Floats, start: Ints, tolerance: Floats) -> _Flat:
    """Polygons without repeated corners and corners on a straight line.

    Parameters
    ----------
    tolerance : (q,)
        Distance to the next corner, or to the line between the neighbours, that counts as zero.

    Returns
    -------
    corner, start
        Polygons that vanish keep zero corners.
    """
    while len(corner):
        loops = Ragged(start)
        loop, after = loops.owner, loops.following
        before = np.argsort(after)
        forth, back = corner[after] - corner, corner - corner[before]
        near = np.hypot(forth[:, 0], forth[:, 1]) <= tolerance[loop]
        chord = corner[after] - corner[before]
        twice = np.abs(plane_cross(forth, back))
        spare = near | (twice <= tolerance[loop] * np.hypot(chord[:, 0], chord[:, 1]))
        if not spare.any():
            break
        spare &= ~spare[before] | _alternate(spare, before, loops)
        spare |= loops.spread(loops.sum(~spare) < 3)
        corner, start = corner[~spare], loops.keep(~spare).start
    return corner, start


def _alternate(spare: Bools, before: Ints, loops: Ragged) -> Bools:
    """The first corner of each polygon whose corners could all be removed."""
    first = marked(loops.first[loops.all(spare) & (loops.counts > 0)], len(spare))
    return first & spare[before]
