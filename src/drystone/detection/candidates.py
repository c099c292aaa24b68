"""Pairs of patches that may touch: near each other and facing each other."""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, dot
from drystone.base.ragged import expand
from drystone.detection.patches import Patches
from drystone.detection.tolerances import LARGEST, DetectionOptions
from drystone.geometry import boxes

_MISSED_ANGLE = np.deg2rad(10.0)
"""[rad] Patches that exceed the angle tolerance by less are reported as near misses."""
_WIDEST_ANGLE = np.deg2rad(50.0)
"""[rad] Patches with a larger angle between them never touch, however curved they are. Chosen:
below the 60 degrees between the sides of a tetrahedral notch."""
NEAR = 0.25
"""A gap up to this share of the size of a block may be an error of the drawing. Chosen: a cube of
50 mm may hover 10 mm high."""
NEAR_BESIDE = 0.15
"""The same of blocks that touch elsewhere, and so are in place. Chosen: below the 0.2 of play that
the lugs of a bayonet have beside the faces on which they rest."""
Pairs = tuple[Ints, Ints]


def most_slack(patches: Patches, options: DetectionOptions) -> Floats:
    """Largest distance (p,) [m] that may be added to the gap: tolerated warp plus sag."""
    return np.minimum(patches.warp + patches.sag, _tolerated(patches, options))


def warp_slack(patches: Patches, options: DetectionOptions) -> Floats:
    """Distance (p,) [m] added to the gap for warp, independent of the opposite patch."""
    return np.minimum(patches.warp, _tolerated(patches, options))


def _tolerated(patches: Patches, options: DetectionOptions) -> Floats:
    return options.warp * patches.size[patches.owner]


def fits(patches: Patches, f: Ints, g: Ints) -> Bools:
    """Whether facing patches (q,) may be chords of one curved surface: one convex, one concave.

    Only such patches get the tolerance for sag. A roller on a plane, or two rollers side by side,
    are no curved joint.
    """
    one: Bools = patches.bulges[f] & patches.hollow[g]
    other: Bools = patches.hollow[f] & patches.bulges[g]
    return one | other


def granted_to(
    patches: Patches, f: Ints, g: Ints, options: DetectionOptions
) -> tuple[Floats, Floats]:
    """Distance (q,) [m] and angle (q,) [rad] added to the tolerances of pairs of patches."""
    curved = fits(patches, f, g)
    flat, most = warp_slack(patches, options), most_slack(patches, options)
    distance: Floats = np.where(curved, most[f] + most[g], flat[f] + flat[g])
    angle: Floats = patches.tilt[f] + patches.tilt[g]
    angle = angle + np.where(curved, patches.bend[f] + patches.bend[g], 0.0)
    return distance, angle


def reach(
    patches: Patches,
    blocks: Ints,
    options: DetectionOptions,
    width: Floats | float = np.inf,
    near: float = NEAR,
) -> Floats:
    """Largest distance (q,) [m] in the search about some blocks (q,); of a pair, the smaller.

    It is ``near`` of their size, or a fiftieth of their length up to half of their size. Chosen:
    drawings of thin legs are off by a share of their length. No facet is searched farther than it
    is wide, unless the options say so: a fine mesh has very many facets within reach of each other.
    """
    size = patches.size[blocks]
    told = np.maximum(options.reach(size), options.search * size)
    farther = np.clip(0.02 * patches.length[blocks], near * size, LARGEST["gap"] * size)
    return np.maximum(told, np.minimum(farther, width))


def reach_of_pairs(patches: Patches, pairs: Pairs, options: DetectionOptions) -> Floats:
    """Largest distance (q,) [m] in the search between the blocks of pairs."""
    a, b = (reach(patches, block, options) for block in pairs)
    return np.minimum(a, b)


def reach_of_patches(
    patches: Patches, f: Ints, g: Ints, options: DetectionOptions, near: float = NEAR
) -> Floats:
    """Largest distance (q,) [m] in the search between patches, less what warp and sag add."""
    width = np.sqrt(np.minimum(patches.area[f], patches.area[g]))
    a, b = (reach(patches, patches.owner[patch], options, width, near) for patch in (f, g))
    return np.minimum(a, b)


def near_blocks(patches: Patches, options: DetectionOptions) -> Pairs:
    """Blocks (a < b) whose boxes come within reach of each other."""
    most = patches.of_block.max(most_slack(patches, options))
    every = np.arange(len(patches.size))
    margin = (0.5 * reach(patches, every, options) + most)[:, None]
    low, high = patches.boxes
    return boxes.overlapping(low - margin, high + margin)


def facing_patches(patches: Patches, pairs: Pairs, options: DetectionOptions) -> Pairs:
    """Patches f of the first and g of the second block of each pair that may touch.

    They face each other within the widest angle, and their boxes come within reach.
    """
    a, b = pairs
    reach_of_pair = reach_of_pairs(patches, pairs, options)
    granted = most_slack(patches, options)
    most = patches.of_block.max(granted)
    one = _patches_near(patches, a, b, reach_of_pair + most[a] + most[b])
    other = _patches_near(patches, b, a, reach_of_pair + most[a] + most[b])
    f, g = _products(patches, one, other, (a, b), options)
    limit = np.deg2rad(options.angle) + _MISSED_ANGLE + granted_to(patches, f, g, options)[1]
    limit[fits(patches, f, g)] = _WIDEST_ANGLE  # to report the missing area of curved joints
    cosine = -dot(patches.normal[f], patches.normal[g])
    keep = cosine >= np.cos(np.minimum(limit, _WIDEST_ANGLE))
    f, g = f[keep], g[keep]
    margin = (reach_of_patches(patches, f, g, options) + granted[f] + granted[g])[:, None]
    keep = boxes.touching(
        patches.low[f] - margin, patches.high[f] + margin, patches.low[g], patches.high[g]
    )
    f, g = f[keep], g[keep]
    if len(f) <= 4 * patches.count:  # few are beside each other
        return f, g
    beside = _beside(patches, f, g, margin[keep, 0])
    return f[~beside], g[~beside]


def _beside(patches: Patches, f: Ints, g: Ints, margin: Floats) -> Bools:
    """Whether facing patches (q,) share no area in projection, as their rectangles show.

    Of strips across a curved joint each is within reach of very many that it does not face.
    """
    axes, half, middle = patches.rectangles
    halfway = 0.5 * (patches.normal[f] + patches.normal[g])  # as long as the sine of half the angle
    astray = margin * np.sqrt(dot(halfway, halfway)) + patches.warp[f] + patches.warp[g]
    between = middle[g] - middle[f]
    beside = np.zeros(len(f), dtype=bool)
    for one, other in ((f, g), (g, f)):
        for k in (0, 1):
            axis = axes[one, k]
            reach = half[one, k] + astray
            for j in (0, 1):
                reach = reach + half[other, j] * np.abs(dot(axes[other, j], axis))
            beside |= np.abs(dot(between, axis)) > reach
    return beside


def _patches_near(patches: Patches, block: Ints, other: Ints, margin: Floats) -> Pairs:
    """Pair and patch of every patch that is near the other block and faces it."""
    low, high = patches.boxes
    first = patches.first_patch
    pair, patch = expand(first[block], first[block + 1] - first[block])
    for axis in range(3):  # most are far away along one axis
        below = (low[:, axis][other] - margin)[pair]
        above = (high[:, axis][other] + margin)[pair]
        near = (patches.high[:, axis][patch] >= below) & (patches.low[:, axis][patch] <= above)
        pair, patch = pair[near], patch[near]
    looks = _looks_at(patches, patch, other[pair], margin[pair], low, high)
    return pair[looks], patch[looks]


def _looks_at(
    patches: Patches, patch: Ints, other: Ints, margin: Floats, low: Floats, high: Floats
) -> Bools:
    """Whether a part of the other block's box lies in front of the patch."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    normal = patches.normal[patch]
    ahead = dot(middle[other] - patches.centre[patch], normal)
    ahead += dot(half[other], np.abs(normal))
    return ahead >= -margin


def _products(
    patches: Patches, one: Pairs, other: Pairs, pairs: Pairs, options: DetectionOptions
) -> Pairs:
    """Every patch of one side with every patch of the other, pair by pair."""
    a, b = pairs
    count = len(a)
    granted = most_slack(patches, options)
    most = patches.of_block.max(granted)
    pair_f, f = one
    pair_g, g = other
    begin = np.searchsorted(pair_g, np.arange(count + 1))
    per_pair = np.diff(begin)
    product = np.bincount(pair_f, minlength=count) * per_pair
    large = product > boxes.FEW
    small = np.flatnonzero(~large[pair_f])
    source, place = expand(begin[pair_f[small]], per_pair[pair_f[small]])
    found_f, found_g = [f[small][source]], [g[place]]
    for pair in np.flatnonzero(large):
        mine, theirs = f[pair_f == pair], g[pair_g == pair]
        width = np.sqrt(patches.area[mine])
        about = [reach(patches, block[pair], options, width) for block in (a, b)]
        margin = np.minimum(*about) + granted[mine]
        margin = (margin + most[b[pair]])[:, None]
        i, j = boxes.between(
            patches.low[mine] - margin,
            patches.high[mine] + margin,
            patches.low[theirs],
            patches.high[theirs],
        )
        found_f.append(mine[i])
        found_g.append(theirs[j])
    return np.concatenate(found_f), np.concatenate(found_g)
