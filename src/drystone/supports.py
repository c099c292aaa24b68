"""Which blocks are fixed: lowest ones, names and patterns, or all below a height."""

from __future__ import annotations

import difflib
from fnmatch import fnmatchcase

import numpy as np

from drystone.arrays import Bools
from drystone.assembly import Assembly
from drystone.errors import InputError
from drystone.units import length

LOWEST = 0.1
"""Blocks whose lowest corner is within this share of the median block height of the lowest corner
of all are the lowest blocks."""


def select(assembly: Assembly, spec: str) -> Assembly:
    """The same blocks, with those fixed that ``spec`` names.

    Parameters
    ----------
    assembly
    spec
        Any of these, separated by commas: ``lowest``; ``below:Z``, the blocks whose lowest corner
        is at or below Z (metres, or with a unit: ``below:150mm``); block names and patterns
        (``*``, ``?``, ``[...]``). A name that holds a comma is understood when it stands alone; a
        block called ``lowest`` is reached by the pattern ``[l]owest``.

    Raises
    ------
    InputError
        A name or pattern that fits no block (close names are suggested), or no block below Z.

    Examples
    --------
    >>> from drystone.models import tower
    >>> select(tower(3), "block-[12]").fixed.tolist()
    [False, True, True]
    """
    fixed = np.zeros(len(assembly), dtype=bool)
    alone = spec in assembly.names
    for part in [spec] if alone else [part.strip() for part in spec.split(",")]:
        if part == "lowest":
            fixed |= lowest(assembly)
        elif part.startswith("below:"):
            fixed |= _below(assembly, part.removeprefix("below:"))
        else:
            fixed |= _named(assembly, part)
    return Assembly(assembly.blocks, fixed)


def lowest(assembly: Assembly) -> Bools:
    """Mask (n,) of the lowest blocks; see :data:`LOWEST`."""
    bottom = assembly.bounds[:, 0, 2]
    height = assembly.bounds[:, 1, 2] - bottom
    out: Bools = bottom <= bottom.min() + LOWEST * np.median(height)
    return out


def _below(assembly: Assembly, text: str) -> Bools:
    level = length(text, "height")
    bottom = assembly.bounds[:, 0, 2]
    out: Bools = bottom <= level
    if not out.any():
        raise InputError(
            f"no block reaches down to {level:g} m",
            where="supports",
            remedy=f"the lowest corner is at {bottom.min():g} m",
        )
    return out


def _named(assembly: Assembly, part: str) -> Bools:
    names = assembly.names
    if part in names:
        return np.array([name == part for name in names])
    pattern = any(c in part for c in "*?[")
    if pattern:
        fits = np.array([fnmatchcase(name, part) for name in names])
        if fits.any():
            return fits
    if not part:
        what = "an empty name"
    else:
        what = f"no block fits '{part}'" if pattern else f"no block is called '{part}'"
    close = difflib.get_close_matches(part, names, n=3, cutoff=0.4)
    shown = ", ".join(close or names[:3])
    remedy = f"did you mean {shown}?" if close else f"names are like {shown}"
    raise InputError(what, where="supports", remedy=remedy)
