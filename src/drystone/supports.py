"""Which blocks are fixed: by place, names or patterns; or a plane of ground below them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import TypeAlias

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Bools, Floats, Ints, marked
from drystone.base.display import named
from drystone.base.errors import InputError, counted, meant
from drystone.base.units import length
from drystone.geometry.polyhedron import BOX, box_corners

_LOWEST = 0.1
"""Blocks whose lowest corner is within this share of the median block height of the lowest corner
of all are the lowest blocks."""
_FOOT = 0.5
"""A foot is in the lower half of the model: what has nothing below it higher up hangs."""
_PRESSED = -np.sin(np.deg2rad(20.0))
"""A joint presses a block down where the upward part of its normal is below this: friction of
0.36 cannot hold the block there."""
_LEVEL = np.cos(np.deg2rad(5.0))
"""The underside of a foot is level within 5 degrees."""
UP = (0.0, 0.0, 1.0)
_THICK = 0.5
"""Thickness of the ground, by the largest block, and how far it reaches beyond the model, by its
width. Chosen: tolerances are relative to the smaller of two blocks, which the ground never is."""
_GROUND = "ground"
PROP = "prop"
"""Fixed blocks that stand for the head of a prop are called so, with a number."""
_SHOWN = 0.12
"""How far the ground reaches beyond a model in pictures, by its larger side in plan; a quarter of
this is its thickness there. Chosen by eye."""

Joints: TypeAlias = tuple[Ints, Ints, Floats]
"""Blocks a (m,) and b (m,), and normals (m, 3) from a to b, of all interfaces."""


@dataclass(frozen=True)
class GroundPlane:
    """A plane of ground below a model: a fixed block that every other one may rest on.

    Parameters
    ----------
    height : [m], along the upward axis
        The lowest corner of the model when left out.

    Examples
    --------
    >>> from drystone.models import tower
    >>> laid = GroundPlane().under(tower(2).with_fixed(()))
    >>> laid.names, laid.fixed.tolist()
    (('block-0', 'block-1', 'ground'), [False, False, True])
    """

    height: float | None = None

    def under(self, assembly: Assembly, up: Sequence[float] = UP) -> Assembly:
        """The assembly with the ground as its last block, the only one that is fixed."""
        axis = int(np.argmax(np.abs(up)))
        sign = 1.0 if up[axis] > 0.0 else -1.0
        bottom, _ = heights(assembly, up)
        level = sign * (float(bottom.min()) if self.height is None else self.height)
        low, high = assembly.bounds[:, 0].min(axis=0), assembly.bounds[:, 1].max(axis=0)
        reach = _THICK * float((high - low).max())
        low, high = low - reach, high + reach
        below = level - sign * _THICK * max(block.size for block in assembly.blocks)
        low[axis], high[axis] = min(level, below), max(level, below)
        name = _GROUND if _GROUND not in assembly.names else f"{_GROUND}-plane"
        return Assembly(
            (*assembly.blocks, Block(box_corners(low, high), BOX, name)),
            np.append(np.zeros(len(assembly), dtype=bool), True),
        )


def ground_of(
    assembly: Assembly,
    supports: str | Sequence[int | str] | GroundPlane | None,
    up: Sequence[float] = UP,
) -> tuple[Assembly, str | Sequence[int | str] | None]:
    """The assembly with the ground that ``supports`` asks for, and the supports by name.

    ``ground`` is the name of a block where one is called so. What asks for no ground is returned
    as it is.
    """
    if isinstance(supports, GroundPlane):
        laid = supports.under(assembly, up)
        return laid, [len(assembly)]
    if not isinstance(supports, str) or supports in assembly.names:
        return assembly, supports
    parts = [part.strip() for part in supports.split(",")]
    asked = [
        part
        for part in parts
        if part.startswith(f"{_GROUND}:") or (part == _GROUND and part not in assembly.names)
    ]
    if not asked:
        return assembly, supports
    if len(asked) > 1:
        raise InputError("the ground is asked for twice", where="supports")
    plane = GroundPlane()
    if asked[0] != _GROUND:
        plane = GroundPlane(length(asked[0].removeprefix(f"{_GROUND}:"), "height"))
    laid = plane.under(assembly, up)
    named_so = [laid.names[-1] if part == asked[0] else part for part in parts]
    return laid, ",".join(named_so)


def laid_ground(assembly: Assembly) -> int | None:
    """Position of the ground below a model: a fixed box of that name, wider than all others."""
    for name in (_GROUND, f"{_GROUND}-plane"):
        if name not in assembly or len(assembly) == 1:
            continue
        at = assembly.index(name)
        (low, high), (least, most) = assembly.bounds[at], _around(assembly, at)
        wide = (low < least) & (high > most)
        close = 1e-9 * float((high - low).max())
        beside = (high <= least + close) | (low >= most - close)
        whole = bool(np.isclose(assembly.volume[at], np.prod(high - low)))
        if assembly.fixed[at] and whole and wide.sum() == 2 and (beside & ~wide).any():
            return at
    return None


def own_blocks(assembly: Assembly) -> Bools:
    """The blocks (n,) of a model, without the ground laid below them."""
    return np.arange(len(assembly)) != laid_ground(assembly)


def props_of(assembly: Assembly) -> Bools:
    """The fixed blocks (n,) that are props, by their names: mends add such blocks."""
    named_so = [re.fullmatch(rf"{PROP}-\d+", name) is not None for name in assembly.names]
    return assembly.fixed & np.array(named_so, dtype=bool)


def _around(assembly: Assembly, left_out: int | None) -> Floats:
    """Box (2, 3) around all blocks but one."""
    each = assembly.bounds if left_out is None else np.delete(assembly.bounds, left_out, axis=0)
    return np.stack([each[:, 0].min(axis=0), each[:, 1].max(axis=0)])


def bounds_above_ground(assembly: Assembly) -> Floats:
    """Box (2, 3) [m] around the blocks, without the ground laid below them."""
    return _around(assembly, laid_ground(assembly))


def with_thin_ground(assembly: Assembly) -> Assembly:
    """The assembly as pictures show it: the ground laid below it is a plate, its face where it was.

    Examples
    --------
    >>> from drystone.models import tower
    >>> laid = GroundPlane().under(tower(2).with_fixed(()))
    >>> [round(float(one.bounds[-1, 1, 0]), 2) for one in (laid, with_thin_ground(laid))]
    [2.0, 1.12]
    """
    at = laid_ground(assembly)
    if at is None:
        return assembly
    (low, high), (least, most) = assembly.bounds[at].copy(), _around(assembly, at)
    axis = int(np.argmin((low < least) & (high > most)))
    reach = _SHOWN * float(np.delete(most - least, axis).max())
    under = bool(high[axis] <= 0.5 * (least[axis] + most[axis]))
    level = high[axis] if under else low[axis]
    depth = min(0.25 * reach, float(high[axis] - low[axis]))
    low, high = np.maximum(low, least - reach), np.minimum(high, most + reach)
    low[axis], high[axis] = (level - depth, level) if under else (level, level + depth)
    blocks = list(assembly.blocks)
    blocks[at] = replace(blocks[at], vertices=box_corners(low, high), faces=BOX)
    return Assembly(tuple(blocks), assembly.fixed)


def may_hold(spec: str, names: Sequence[str], bottom: Floats, top: Floats) -> Bools:
    """Mask (n,) of the shapes that a spec would fix, by their names and heights alone [m]."""
    parts = _parts(spec, names)
    return np.any([_held(part, names, bottom, top) for part in parts], axis=0)


def _parts(spec: str, names: Sequence[str]) -> list[str]:
    return [spec] if spec in names else [part.strip() for part in spec.split(",")]


def _held(part: str, names: Sequence[str], bottom: Floats, top: Floats) -> Bools:
    """Mask (n,) of what one part of a spec names."""
    if part == "lowest":
        return _lowest_of(bottom, top)
    if part.startswith("below:"):
        return bottom <= length(part.removeprefix("below:"), "height")
    return np.array([name == part if part in names else fnmatchcase(name, part) for name in names])


def select(
    assembly: Assembly, spec: str, *, up: Sequence[float] = UP, joints: Joints | None = None
) -> Assembly:
    """The same blocks, with those fixed that ``spec`` names.

    Parameters
    ----------
    assembly
    spec
        Any of these, separated by commas: ``lowest``; ``below:Z``, the blocks whose lowest corner
        is at or below Z (metres, or with a unit: ``below:150mm``); block names and patterns
        (``*``, ``?``, ``[...]``). For ``ground`` see :func:`ground_of`. A name that holds a comma
        is understood when it stands alone; a block called ``lowest`` is reached by
        the pattern ``[l]owest``.
    up : (3,)
        Unit vector; heights are along it.
    joints
        Where blocks touch. With it, ``lowest`` fixes every foot; see :func:`feet`.

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
    bottom, top = heights(assembly, up)
    fixed = np.zeros(len(assembly), dtype=bool)
    for part in _parts(spec, assembly.names):
        held = _held(part, assembly.names, bottom, top)
        if not held.any():
            raise _unknown(assembly, part, float(bottom.min()))
        fixed |= held | feet(assembly, joints, up) if part == "lowest" else held
    return Assembly(assembly.blocks, fixed)


def lowest(assembly: Assembly, up: Sequence[float] = UP) -> Bools:
    """Mask (n,) of the lowest blocks; see :data:`_LOWEST`."""
    return _lowest_of(*heights(assembly, up))


def _lowest_of(bottom: Floats, top: Floats) -> Bools:
    return bottom <= bottom.min() + _LOWEST * np.median(top - bottom)


def feet(assembly: Assembly, joints: Joints | None, up: Sequence[float] = UP) -> Bools:
    """Mask (n,) of the blocks that only something below the model can hold.

    Such a block is in the lower half of the model, its underside is level, and every joint that it
    has presses it down: the springer of an arch whose feet are at different heights.
    """
    bottom, top = heights(assembly, up)
    if joints is None:
        return np.zeros(len(assembly), dtype=bool)
    low = bottom <= bottom.min() + _FOOT * (top.max() - bottom.min())
    return low & hanging(assembly, joints, up) & _level(assembly, bottom, up)


def hanging(assembly: Assembly, joints: Joints, up: Sequence[float] = UP) -> Bools:
    """Mask (n,) of the blocks that touch others, and that every joint presses down."""
    a, b, normal = joints
    upward = normal @ np.asarray(up, dtype=np.float64)
    most = np.full(len(assembly), -np.inf)
    np.maximum.at(most, b, upward)
    np.maximum.at(most, a, -upward)
    return np.isfinite(most) & (most < _PRESSED)


def heights(assembly: Assembly, up: Sequence[float] = UP) -> tuple[Floats, Floats]:
    """Lowest and highest corner (n,) [m] of each block along ``up``."""
    along = [block.vertices @ np.asarray(up, dtype=np.float64) for block in assembly.blocks]
    return np.array([z.min() for z in along]), np.array([z.max() for z in along])


def up_of(gravity: Sequence[float]) -> tuple[float, float, float]:
    """The axis (3,) that is nearest to straight up where gravity is as given.

    Examples
    --------
    >>> up_of((5.0, 0.0, -9.81)), up_of((0.0, -9.81, 0.0))
    ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    """
    axis = [0.0, 0.0, 0.0]
    largest = max(range(3), key=lambda i: abs(gravity[i]))
    axis[largest] = -1.0 if gravity[largest] > 0.0 else 1.0
    return axis[0], axis[1], axis[2]


def remarks(
    assembly: Assembly, spec: str, joints: Joints, up: Sequence[float] = UP
) -> tuple[str, ...]:
    """What to say about the blocks that ``spec`` has fixed.

    Feet that ``lowest`` has found above the lowest blocks, blocks with nothing below them that are
    not fixed, and a model most of whose blocks are fixed.
    """
    said = []
    bottom, _ = heights(assembly, up)
    fixed = assembly.fixed
    if "lowest" in (part.strip() for part in spec.split(",")):
        higher = feet(assembly, joints, up) & ~lowest(assembly, up)
        if higher.any():
            rise = bottom[higher].max() - bottom.min()
            said.append(
                f"'lowest' also fixes {_list(assembly, higher)}, up to {rise:.3g} m above the"
                " others: nothing else is below"
            )
        left = hanging(assembly, joints, up) & ~fixed
        if left.any():
            said.append(
                f"nothing is below {_list(assembly, left)}, which 'lowest' does not fix: name"
                " what is a support"
            )
    if fixed.sum() > 0.5 * len(fixed) and not fixed.all():
        said.append(f"{fixed.sum()} of {len(fixed)} blocks are fixed by '{spec}'")
    return tuple(said)


def advice(assembly: Assembly, up: Sequence[float] = UP, joints: Joints | None = None) -> str:
    """What ``lowest`` and ``below:`` would fix, counted, as the remedy of an error."""
    low = lowest(assembly, up) | feet(assembly, joints, up)
    bottom, top = heights(assembly, up)
    level = bottom.min() + _LOWEST * (top.max() - bottom.min())
    return (
        f"'lowest' would fix {_list(assembly, low)}; 'below:{level:.3g}' "
        f"{counted(int((bottom <= level).sum()), 'block')}; 'ground' lays a plane below; or give"
        " names"
    )


def require_supports(
    assembly: Assembly,
    joints: Joints | None = None,
    *,
    up: Sequence[float] = UP,
    where: str = "",
    option: str = "supports",
    chosen: bool = True,
    remedy: str = "",
) -> None:
    """Refuse an assembly of which no block is fixed, or every block by choice.

    Parameters
    ----------
    assembly
    joints, up
        See :func:`select`.
    where
        Of the model, for errors.
    option
        Name of the option that fixes blocks.
    chosen
        Whether the supports were chosen for this analysis.
    remedy
        What else to do where every block is fixed.

    Raises
    ------
    InputError
        With what ``lowest`` and ``below:`` would fix, counted.
    """
    fixed = assembly.fixed
    if not fixed.any():
        told = advice(assembly, up, joints)
        raise InputError("no block is fixed", where=where, remedy=f"{option}: {told}")
    if chosen and fixed.all():
        raise InputError(
            f"every block is fixed, all {len(fixed)}: there is nothing to check",
            where=where,
            remedy=remedy or f"name fewer blocks with {option}",
        )


def _list(assembly: Assembly, mask: Bools) -> str:
    names = [assembly.names[i] for i in np.flatnonzero(mask).tolist()]
    return f"{counted(len(names), 'block')} ({named(names, 4)})"


def _level(assembly: Assembly, bottom: Floats, up: Sequence[float]) -> Bools:
    """Mask (n,) of the blocks whose lowest corner is one of a face that looks straight down."""
    faces = assembly.faces
    area = faces.area_vectors
    direction = np.asarray(up, dtype=np.float64)
    size = np.linalg.norm(area, axis=1)
    down = -(area @ direction) >= _LEVEL * size
    least = faces.corners.min(faces.point[faces.loop] @ direction)
    reach = np.array([block.size for block in assembly.blocks])
    down &= least <= bottom[faces.owner] + 1e-3 * reach[faces.owner]
    return marked(faces.owner[down], len(assembly))


def _unknown(assembly: Assembly, part: str, least: float) -> InputError:
    """Why a part of a spec names no block; the lowest corner is at a height [m]."""
    what, remedy = "an empty name", meant(part, (*assembly.names, "lowest"))
    if part.startswith("below:"):
        level = length(part.removeprefix("below:"), "height")
        what, remedy = (
            f"no block reaches down to {level:g} m",
            f"the lowest corner is at {least:g} m",
        )
    elif part:
        pattern = any(c in part for c in "*?[")
        what = f"no block fits '{part}'" if pattern else f"no block is called '{part}'"
    return InputError(what, where="supports", remedy=remedy)
