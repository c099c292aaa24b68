"""Structures that can be built without props: two columns and a corbelled bridge.

Each is a section in a vertical plane, cut by joints and extruded along y. Every block can be placed
on those before it.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats
from drystone.models.solids import prism, require


def leaning_column(
    blocks: int = 8,
    lean_deg: float = 8.0,
    width: float = 1.0,
    height: float = 4.0,
    depth: float = 1.0,
) -> Assembly:
    """A column that leans towards +x, cut square to its axis, on a fixed wedge.

    It stands while the centroid of the part above each joint is over that joint. Its blocks do not
    slide while friction exceeds ``tan(lean_deg)``, the slope of the joints.

    Parameters
    ----------
    blocks : >= 1
        Free blocks.
    lean_deg : [degrees] >= 0, < 45
    width, height, depth : [m]
        Across the axis, along the axis of all free blocks, and along y.

    Returns
    -------
    Assembly
        ``base``, fixed, and ``c01`` ... upwards.

    Examples
    --------
    >>> leaning_column(3).names
    ('base', 'c01-block', 'c02-block', 'c03-block')
    """
    lean = np.deg2rad(lean_deg)
    axis, across = np.array([np.sin(lean), np.cos(lean)]), np.array([np.cos(lean), -np.sin(lean)])
    step = height / blocks
    foot = np.array([0.0, width])
    joints = np.array(
        [
            [foot + i * step * axis + s * 0.5 * width * across for s in (-1, 1)]
            for i in range(blocks + 1)
        ]
    )
    return _stacked(joints, depth)


def winding_column(
    blocks: int = 8,
    swing: float = 0.25,
    width: float = 0.8,
    height: float = 4.0,
    depth: float = 0.8,
) -> Assembly:
    """A column whose centre line is one full wave, with joints normal to it.

    Parameters
    ----------
    blocks : >= 2
        Free blocks.
    swing : [m]
        Amplitude of the centre line.
    width, height, depth : [m]
        Across the centre line, of the wave, and along y.

    Returns
    -------
    Assembly
        ``base``, fixed, and ``c01`` ... upwards.
    """
    steepest = 2.0 * np.pi * abs(swing) / height
    require(steepest < 1.0, f"a swing of {swing} m", "less than the height by 2 pi")
    z = np.linspace(0.0, height, blocks + 1)
    phase = 2.0 * np.pi * z / height
    centre = np.column_stack([swing * np.sin(phase), width + z])
    slope = 2.0 * np.pi * swing / height * np.cos(phase)
    across = np.column_stack([np.ones(blocks + 1), -slope]) / np.hypot(1.0, slope)[:, None]
    joints = np.stack([centre - 0.5 * width * across, centre + 0.5 * width * across], axis=1)
    return _stacked(joints, depth)


def corbelled_bridge(
    corbels: int = 3,
    reach: float = 0.45,
    tail: float = 1.2,
    height: float = 0.4,
    gap: float = 1.0,
    batter_deg: float = 12.0,
    depth: float = 0.8,
) -> Assembly:
    """Two corbelled arms and a wedge-shaped key, built without centring.

    Every corbel is longer than the one below on both sides, so that it stands when it is placed.
    The key is placed from above. Its ends lean by ``batter_deg``, so it presses the arms apart;
    friction under the topmost corbels resists.

    Parameters
    ----------
    corbels : >= 1
        In each arm, over a fixed pier.
    reach, tail : [m] > 0
        By how much each corbel projects beyond the one below, and its length behind the face of the
        pier.
    height, depth : [m] > 0
        Of every block.
    gap : [m] > 0
        Length of the key at its bottom.
    batter_deg : [degrees] >= 0, < 45
        Of its ends against the vertical, wider at the top.

    Returns
    -------
    Assembly
        ``pier-left``, ``pier-right``, fixed; ``left-1`` ... upwards, ``right-1`` ..., ``key``.
    """
    half = 0.5 * gap + corbels * reach
    rise = float(np.tan(np.deg2rad(batter_deg))) * height
    require(rise < reach, "the key cuts through the corbels", "less batter, or more reach")
    span = (-0.5 * depth, 0.5 * depth)
    arms: dict[str, list[Block]] = {"left": [], "right": []}
    piers = []
    for name, side in (("left", -1.0), ("right", 1.0)):
        back = half + tail
        pier = np.array([(half, 0.0), (back, 0.0), (back, height), (half, height)])
        piers.append(prism(pier * (side, 1.0), span, f"pier-{name}"))
        for i in range(corbels):
            tip = half - (i + 1) * reach
            low, high = (i + 1) * height, (i + 2) * height
            top = tip + rise if i == corbels - 1 else tip
            arm = np.array([(tip, low), (back, low), (back, high), (top, high)])
            arms[name].append(prism(arm * (side, 1.0), span, f"{name}-{i + 1}"))
    low, high = corbels * height, (corbels + 1) * height
    wide = 0.5 * gap
    key = [(-wide, low), (wide, low), (wide + rise, high), (-wide - rise, high)]
    blocks = (*piers, *arms["left"], *arms["right"], prism(key, span, "key"))
    return Assembly(blocks, np.arange(len(blocks)) < 2)


def _stacked(joints: Floats, depth: float) -> Assembly:
    """Blocks between joints (j, 2, 2), each from left to right, over a base from the ground."""
    left, right = joints[0]
    base = prism([(left[0], 0.0), (right[0], 0.0), right, left], (0.0, depth), "base")
    made = [
        prism([a[0], a[1], b[1], b[0]], (0.0, depth), f"c{i:02d}-block")
        for i, (a, b) in enumerate(pairwise(joints), 1)
    ]
    return Assembly((base, *made), np.arange(len(made) + 1) == 0)
