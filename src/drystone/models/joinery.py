"""Joints that hold by their shape: a dovetail, a hooked bar, a bayonet, a burr puzzle."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from drystone.assembly import Assembly
from drystone.geometry.frames import rotation_about
from drystone.models.simple import box, of_boxes, prism, require, sections


def dovetail(
    flare_deg: float = 15.0, width: float = 0.4, height: float = 0.3, length: float = 1.0
) -> Assembly:
    """A dovetail: a tenon, wider at its bottom, that slides only along its groove (y).

    Parameters
    ----------
    flare_deg : [degrees] > 0, < 60
        Of the sides of the tenon, from the vertical.
    width, height, length : [m]
        Of the tenon: its neck, its height, and along y.

    Returns
    -------
    Assembly
        ``groove``, fixed, and ``tenon``.

    Examples
    --------
    >>> dovetail().names
    ('groove', 'tenon')
    """
    neck = 0.5 * width
    foot = neck + height * float(np.tan(np.deg2rad(flare_deg)))
    low, side = -0.5 * height, foot + 0.5 * width
    tenon = [(-foot, 0.0), (foot, 0.0), (neck, height), (-neck, height)]
    groove = [
        (-side, low), (side, low), (side, height), (neck, height),
        (foot, 0.0), (-foot, 0.0), (-neck, height), (-side, height),
    ]  # fmt: skip
    span = (0.0, length)
    return Assembly(
        (prism(groove, span, "groove"), prism(tenon, span, "tenon")), np.array([True, False])
    )


def hooked_bar(length: float = 3.0, height: float = 0.5, cheeks: bool = True) -> Assembly:
    """A bar under a ledge and against a slope. Only a rotation removes it.

    The ledge prevents lifting. The slope and the wall behind the toe prevent sliding along x, the
    cheeks along y. A rotation about the edge of the ledge frees it.

    Parameters
    ----------
    length, height : [m]
        Of the bar.
    cheeks
        Whether walls on both sides keep it from sliding out along y.

    Returns
    -------
    Assembly
        ``bed``, fixed, ``bar``, and with cheeks ``near`` and ``far``, fixed.
    """
    require(length > 4.0 * height > 0.0, f"a bar of {length} by {height} m", "make it longer")
    toe, ledge, slope = 0.2 * height, 0.8 * height, 0.6 * height
    top = 1.6 * height
    bar = [
        (0.0, height), (0.0, height - toe), (height, 0.0), (length - slope, 0.0), (length, height),
    ]  # fmt: skip
    bed = [
        (-ledge, -height), (length + slope, -height), (length + slope, height), (length, height),
        (length - slope, 0.0), (height, 0.0), (0.0, 0.0), (0.0, height), (ledge, height),
        (ledge, top), (-ledge, top),
    ]  # fmt: skip
    deep = height
    blocks = [prism(bed, (0.0, deep), "bed"), prism(bar, (0.0, deep), "bar")]
    if cheeks:
        size = (length + slope + ledge, 0.5 * height, top + height)
        for name, y in (("near", -0.5 * height), ("far", deep)):
            blocks.append(box(size, (-ledge, y, -height), name))
    return Assembly(tuple(blocks), np.array([name != "bar" for name in (b.name for b in blocks)]))


def bayonet(locked_deg: float = 90.0) -> Assembly:
    """A peg with a crossbar under a slotted plate: it is turned to the slot, then lifted.

    Parameters
    ----------
    locked_deg : [degrees] >= 0, <= 90
        Angle between the crossbar and the slot; at zero it lifts straight out.

    Returns
    -------
    Assembly
        ``socket``, ``plate-left`` and ``plate-right``, fixed, and ``peg``.
    """
    floor, under, top = -0.4, 0.5, 0.8
    half, slot = 2.5, 0.5
    walls = [
        (-half, floor), (half, floor), (half, under), (2.0, under), (2.0, 0.0), (-2.0, 0.0),
        (-2.0, under), (-half, under),
    ]  # fmt: skip
    socket = prism(walls, (-half, half), "socket")
    plates = [
        box((2.0 * half, half - slot, top - under), (-half, y, under), name)
        for name, y in (("plate-left", -half), ("plate-right", slot))
    ]
    crossbar, shaft = (
        ((-1.8, -0.4, 0.0), (1.8, 0.4, under)),
        ((-0.35, -0.35, under), (0.35, 0.35, 1.4)),
    )
    about = rotation_about(np.array([0.0, 0.0, 1.0]), locked_deg)
    peg = of_boxes("peg", crossbar, shaft).transformed(about)
    return Assembly((socket, *plates, peg), np.array([True, True, True, False]))


STICKS: dict[str, tuple[int, int]] = {
    "key": (0, 1), "x-low": (0, -1), "y-high": (1, 1), "y-low": (1, -1),
    "z-high": (2, 1), "z-low": (2, -1),
}  # fmt: skip
"""Sticks of the burr: the axis of each, and on which side of the middle it is."""


def _stick_cells(axis: int, side: int, length: int = 6) -> set[tuple[int, int, int]]:
    """Unit cells, by their lowest corner, of a stick 2 x 2 x ``length`` before notches are cut.

    The two sticks along x are stacked in z, those along y in x, and those along z in y.
    """
    half = length // 2
    ranges: list[Iterable[int]] = [(-1, 0), (-1, 0), (-1, 0)]
    ranges[axis] = range(-half, half)
    ranges[(axis + 2) % 3] = (0, 1) if side > 0 else (-2, -1)
    return {(x, y, z) for x in ranges[0] for y in ranges[1] for z in ranges[2]}


def burr(cell: float = 0.1) -> Assembly:
    """A burr puzzle: six notched sticks that cross and interlock; the key slides out.

    Parameters
    ----------
    cell : [m] > 0
        Edge of a cell; a stick is two cells wide and six long.

    Returns
    -------
    Assembly
        ``key`` and ``x-low``, along x, then two sticks along y and two along z. None is fixed.

    Examples
    --------
    >>> burr().names
    ('key', 'x-low', 'y-high', 'y-low', 'z-high', 'z-low')
    """
    # cut out of each stick; found by trial: only the key, which is whole, can be moved first
    notches = sections("burr")
    blocks = []
    for name, (axis, side) in STICKS.items():
        cells = _stick_cells(axis, side) - set(map(tuple, notches.get(name, ())))
        ends = ((cell * np.array([one, np.add(one, 1)])).tolist() for one in sorted(cells))
        blocks.append(of_boxes(name, *((tuple(low), tuple(high)) for low, high in ends)))
    return Assembly(tuple(blocks))
