"""Earth and water behind a wall: pressure on the faces that they touch."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Self

import numpy as np

from drystone.assembly import Assembly
from drystone.base import units
from drystone.base.arrays import SAME, Floats
from drystone.base.display import named
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.base.units import quantity
from drystone.geometry.frames import AXES
from drystone.loads.case import LoadCase
from drystone.loads.ground_words import (
    Reader,
    length,
    pressure,
    pressure_ratio,
    read_words,
    weight,
)
from drystone.loads.placing import GivenLoad
from drystone.loads.seen_strips import SeenStrips, Spots
from drystone.supports import select

_GRAZED = math.tan(math.radians(80.0))
"""Slope of a face across the line of sight. Chosen: a splayed wing wall has less."""
_WATER = 9810.0
"""[N/m3]"""
_FAR = 10.0
"""Times the height of a model above a wall at which a level is refused: millimetres as metres."""


@dataclass(frozen=True)
class Earth(Options):
    """Level earth on one side of a wall.

    Attributes
    ----------
    side
        On which it lies: ``x``, ``-x``, ``y`` or ``-y``.
    weight : [N/m3] >= 0, <= 1e6
        By volume, also where it is saturated.
    k : >= 0, <= 15
        Horizontal by vertical pressure.
    top : [m] >= -1e5, <= 1e5
        Level of its surface; the top of what is seen when left out.
    surcharge : [Pa] >= 0, <= 1e9
        On its surface.
    water : [m] >= -1e5, <= 1e5
        Level of the water in it; none when left out.
    wall_friction : coefficient >= 0, <= 1.2
        Of the wall: the earth drags it down by this share of its pressure. No more than its own.
    blocks
        On which it presses, names and patterns with ``+`` between them; all that are seen when left
        out.

    Notes
    -----
    At depth h the vertical pressure is ``surcharge + weight * h``, less that of water below its
    level. It acts on what is inclined and looks up, and ``k`` times it on vertical areas, level and
    square to the face in plan, both where no other block lies before a face; the pressure of water
    is added, and a note says that its uplift below the wall is not.

    Examples
    --------
    >>> from drystone.models import tower
    >>> load = Earth.named("side=-x,weight=18kN/m3,k=active:30deg").on(tower(3))
    >>> load.wrench[:, 0].round(1).tolist()  # the lowest block is fixed
    [15000.0, 9000.0, 3000.0]
    """

    side: Literal["x", "-x", "y", "-y"]
    weight: float
    k: float
    top: float | None = None
    surcharge: float = 0.0
    water: float | None = None
    wall_friction: float = 0.0
    blocks: str = ""

    @classmethod
    def named(cls, text: str) -> Self:
        """From ``side=-x,weight=18kN/m3,k=active:30deg``, and the other attributes.

        Raises
        ------
        InputError
            It cannot be read, one of the first three is missing, or the wall is said to be rougher
            than the earth: that slides on itself first.
        """
        soil: list[float] = []

        def ratio(text: str) -> float:
            size, angle = pressure_ratio(text), text.split(":")[1:2]
            soil.extend(map(units.coefficient, angle))
            return size

        known: Mapping[str, Reader] = {
            "side": str,
            "weight": weight,
            "k": ratio,
            "top": length,
            "surcharge": pressure,
            "water": length,
            "wall_friction": units.coefficient,
            "blocks": str,
        }
        example = "side=-x,weight=18kN/m3,k=0.33"
        made = read_words(cls, text, "earth", known, example, k="active:", wall_friction="")
        if soil and made.wall_friction > (1.0 + SAME) * soil[0]:
            wall, own = (f"{math.degrees(math.atan(x)):.3g}" for x in (made.wall_friction, soil[0]))
            raise InputError(
                f"wall friction of {wall} degrees is more than that of the earth, {own}",
                where="earth", remedy=f"give no more than {own}deg",
            )  # fmt: skip
        return made

    def on(self, assembly: Assembly) -> LoadCase:
        """Its pressure on the free blocks."""
        away = np.array(AXES[self.side])
        up = np.array([0.0, 0.0, 1.0])
        strips = SeenStrips.of(assembly, np.stack([up, np.cross(away, up), away]))
        if self.blocks:
            strips = strips.chosen(
                select(assembly, self.blocks.replace("+", ",")).fixed[strips.block]
            )
        if not len(strips.block):
            raise InputError("it touches no face", where="earth", remedy="see 'side'")
        top = float(strips.t.max()) if self.top is None else self.top
        if assembly.fixed[strips.block].all():
            who = named([assembly.names[i] for i in np.unique(strips.block)], 2)
            raise InputError(
                f"all that it touches, {who}, is fixed: a load on it changes nothing",
                where="earth", remedy="name free blocks, or leave out 'blocks'; see 'side'",
            )  # fmt: skip
        lowest, high = float(strips.t.min()), float(strips.t.max())
        for what, level in (("top", top), ("water", self.water)):
            if level is not None and (level < lowest or (level == lowest and what == "top")):
                raise InputError(
                    f"its {what}, {level:g} m, is below the wall", where="earth",
                    remedy=f"give a level above {lowest:g} m, not a height, or leave it out",
                )  # fmt: skip
            if level is not None and level - high > _FAR * np.ptp(assembly.bounds[..., 2]):
                raise InputError(
                    f"its {what}, {level:g} m, is {level - high:.4g} m above the wall",
                    where="earth", remedy=f"give a level in m, or its unit, as {level:g}mm",
                )  # fmt: skip
        if self.water is not None and 0.0 < self.weight < _WATER:
            raise InputError(
                f"it weighs {quantity(self.weight, 'N')}/m3, less than the water in it",
                where="earth", remedy="give its saturated weight; uplift is taken off here",
            )  # fmt: skip
        levels = [top] if self.water is None else [top, self.water]
        strips = strips.cut_at(np.sort(levels))

        def traction(at: Spots) -> Floats:
            t, slope = at.point[:, 2], at.slope
            depth = np.maximum(top - t, 0.0)
            wet = np.zeros(len(t)) if self.water is None else np.maximum(self.water - t, 0.0)
            down = np.where(depth > 0.0, self.surcharge, 0.0) + self.weight * depth
            down = np.maximum(down - _WATER * np.minimum(wet, depth), 0.0)
            level, tread = self.k * down, np.maximum(-slope[:, 0], 0.0)  # it looks up
            aside = level * slope[:, 1]  # square to a face that stands oblique in plan
            drag = self.wall_friction * np.hypot(level, aside)
            force = np.column_stack([-down * tread - drag, aside, -level])
            skew = np.column_stack([slope, np.full(len(t), -1.0)])
            return force + _WATER * wet[:, None] * skew

        kind = (
            f"earth of {quantity(self.weight, 'N')}/m3 to {top:g} m on side {self.side} "
            f"with K {self.k:.3g}"
        )
        more = {
            f" on {self.blocks}": self.blocks,
            f" and wall friction {self.wall_friction:.3g}, at most its own": self.wall_friction,
            f" and surcharge {quantity(self.surcharge, 'Pa')}": self.surcharge,
            f" and water to {self.water} m": self.water is not None,
        }
        name = kind + "".join(words for words, given in more.items() if given)
        surface = strips.surface(assembly, traction)
        grazed = ~assembly.fixed[strips.block] & (np.abs(strips.slope[:, 1]) > _GRAZED)
        ends = named([assembly.names[i] for i in np.unique(strips.block[grazed])], 2)
        note = (
            f"earth presses also faces of {ends} that are seen from side {self.side} at less than "
        )
        notes: tuple[str, ...] = (f"{note}10 degrees, square to them",) if ends else ()
        if self.water is not None:
            free = strips.chosen(~assembly.fixed[strips.block])
            foot = float(free.t.min())
            near = SAME * float(np.abs(strips.t).max())
            if (head := self.water - foot) > near:
                under = free.block[free.t.min(axis=1) <= foot + near].min()
                notes += (_uplift(foot, head, assembly.names[under]),)
            if (over := self.water - high) > near:
                notes += (f"water, a level, stands {over:.3g} m above what it presses",)
        wrench = strips.wrenches(assembly, traction)
        return LoadCase(wrench, name, notes, surface=surface, each=GivenLoad.of(name, wrench))


def _uplift(foot: float, head: float, block: str) -> str:
    """The uplift in the joint below a wall, of a head [m] that falls evenly to none, as an option.

    A triangle has half its largest pressure on average, and turns the wall about its far edge as
    two thirds of it everywhere would.
    """
    full = _WATER * head
    part = {"kind": "surface", "block": block, "pressure": round(full / 2), "facing": [0, 0, -1]}
    most, mean, turning = (quantity(one, "Pa") for one in (full, full / 2, full / 1.5))
    return (
        f"uplift below the wall is not counted: at {foot:.3g} m, {most} at the wet side, none at a "
        f"drained one, {mean} on average, turning it as {turning} would: add a pressure to each "
        f"block there, such as --load {shlex.quote(json.dumps(part))}"
    )
