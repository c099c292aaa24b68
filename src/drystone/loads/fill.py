"""Earth and water behind a wall, and fill of a bridge: pressure on faces that they touch.

Words of the ground: ``name=value`` pairs of weights, pressures, levels and their ratios.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, Self

import numpy as np
import shapely

from drystone.assembly import Assembly
from drystone.base import units
from drystone.base.arrays import FARTHEST, SAME, Bools, Floats, lengths
from drystone.base.display import named
from drystone.base.errors import InputError, meant
from drystone.base.settings import Options
from drystone.base.units import quantity
from drystone.geometry.frames import AXES
from drystone.loads.case import DOWN, STANDARD_GRAVITY, LoadCase
from drystone.loads.masses import CarriedMass
from drystone.loads.placing import SurfaceLoad
from drystone.loads.seen_strips import SeenStrips, Spots, Traction
from drystone.supports import select

_UPRIGHT = 1e-3
"""Rise of the normal of a side of a bridge. Chosen: coordinates in whole millimetres have less."""
_SLOPES = 0.1
"""Share by which soffits slope one way more than square to it; of domes with few stones less."""
_PLUMB = 20.0
"""Slope from which on a face is the side of a bridge. Chosen: no batter and no dome is as steep."""
_SLIT = 0.01
"""Of the breadth of a bridge: into narrower gaps no fill falls. Chosen: joints of 1 cm are open."""


@dataclass(frozen=True)
class Fill(Options):
    """Fill between the tops of blocks and a road.

    Attributes
    ----------
    cover : [m] >= 0, <= 100
        Of the road above the highest block, at the middle of the bridge.
    weight : [N/m3] >= 0, <= 1e6
        By volume.
    k : >= 0, <= 100
        Horizontal by vertical pressure on what is inclined.
    passive : >= 0, <= 100
        Largest such ratio that fill mobilises against what moves into it; none at zero. ``limit
        train`` uses it, and all that is asked with the tie ``fill``.
    spread : >= 0, <= 100
        Of a load, horizontal by vertical, to each side.
    grade : >= -10, <= 10
        Rise of the road by length along it.
    between : (2,) [m]
        Places across the road between which fill lies; all tops when left out.
    law
        How a load spreads: ``even`` over that width, or ``boussinesq`` of an elastic half space.

    Notes
    -----
    An earthquake shakes its weight: the column on each block moves with it, and its force acts in
    the middle of the column. The vertical pressure at depth h is ``weight * h``, on each
    horizontal area. The horizontal one
    is ``k`` times that, on each vertical area. Fill lies on what is seen from above.

    Examples
    --------
    >>> Fill.named("cover=0.3m,weight=20kN/m3,spread=2:1,k=0.3")
    Fill(cover=0.3, weight=20000, k=0.3)
    """

    cover: float
    weight: float
    k: float = 0.0
    passive: float = 0.0
    spread: float = 0.5
    grade: float = 0.0
    between: tuple[float, float] | None = None
    law: Literal["even", "boussinesq"] = "even"

    def __post_init__(self) -> None:
        super().__post_init__()
        if 0.0 < self.passive < self.k:
            raise InputError(
                f"passive is {self.passive:g}, k {self.k:g}", remedy="give more than k"
            )
        if self.between is not None and not self.between[0] < self.between[1]:
            raise InputError(f"between is {self.between}", remedy="give the lesser place first")

    @property
    def words(self) -> str:
        """All of it: what weighs and presses, what it resists, and how an axle spreads.

        Examples
        --------
        >>> fill, _, rest = Fill(cover=0.3, weight=2e4).words.partition(", ")
        >>> fill
        'fill of 20 kN/m3 to 0.3 m above the crown with K 0'
        >>> rest
        'passive none (a load spreads 0.5 by depth, evenly)'
        """
        fill = f"fill of {quantity(self.weight, 'N')}/m3" if self.weight else "no weight of fill"
        law = "evenly" if self.law == "even" else "as in an elastic half space"
        passive = f"{self.passive:.3g}" if self.passive else "none"
        low, high = self.between or (0.0, 0.0)
        where = f", between {low:g} and {high:g} m across" if self.between else ""
        rise = f", road rising by {self.grade:g}" if self.grade else ""
        return (
            f"{fill} to {self.cover:g} m above the crown{where}{rise} with K {self.k:.3g}, "
            f"passive {passive} (a load spreads {self.spread:.3g} by depth, {law})"
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """That the weight alone is not all that it does, where it resists more."""
        said = "what fill resists beyond k counts in 'limit train', and with the tie 'fill'"
        return (said,) if self.passive else ()

    @classmethod
    def named(cls, text: str) -> Self:
        """From ``cover=0.3m,weight=20kN/m3``, and the other attributes.

        Raises
        ------
        InputError
            It cannot be read, or one of the first two is missing.
        """
        known: Mapping[str, Reader] = {
            "cover": length,
            "weight": weight,
            "k": pressure_ratio,
            "law": str,
            "passive": pressure_ratio,
            "spread": spread,
            "grade": grade,
            "between": _between,
        }
        return cls(**read_words(text, "fill", known, "cover=0.3m,weight=20kN/m3"))

    def on(self, assembly: Assembly) -> LoadCase:
        """Its weight, and its pressure by ``k``, on the free blocks."""
        top = Tops.of(assembly, self)
        fields = (strips.surface(assembly, law) for strips, law in top.pressures(1.0, self.k))
        surface = SurfaceLoad.of_all([one for one in fields if len(one.block)])
        return LoadCase(
            top.pressed(1.0, self.k), self.words, (*self.notes, *top.notes),
            surface=surface, fills=(self,), masses=(top.mass,),
        )  # fmt: skip


def _road_axes(assembly: Assembly) -> Sequence[Floats]:
    """Ways a road may run: each along, across it and up, rows (3, 3); they turn with the model.

    Across is where the largest area of upright faces looks, by its part square to the direction in
    which soffits slope: so piers and abutments do not count, if the bridge is skew or not. A soffit
    is the largest face of a block that looks down: no chamfer below a coping. Without
    upright faces the road runs as soffits slope. Where these have no direction, as in domes and
    slabs, it runs square to the largest area or along it, first the way nearer to x; if faces that
    look along y have as much as any, these are x and y.
    """
    mine = ~assembly.fixed[assembly.faces.owner]
    area, normal = lengths(assembly.faces.area_vectors[mine]), assembly.faces.normals[mine]
    twice = (normal[:, 0] + 1j * normal[:, 1]) ** 2  # the same for both sides of a wall
    soffit = area * np.where(normal[:, 2] < -1.0 / _PLUMB, -normal[:, 2], 0.0)
    owner, largest = assembly.faces.owner[mine], np.zeros(len(assembly))
    np.maximum.at(largest, owner, soffit)
    soffit[soffit < (1.0 - SAME) * largest[owner]] = 0.0
    slope = complex(soffit @ twice)
    upright = np.abs(normal[:, 2]) < _UPRIGHT
    ways, which = np.unique(np.round(twice[upright], 3), return_inverse=True)
    size = np.bincount(which.ravel(), area[upright], len(ways))
    mean = np.zeros(len(ways), dtype=complex)
    np.add.at(mean, which.ravel(), area[upright] * twice[upright])
    along = 1.0 + 0.0j
    if abs(slope) > _SLOPES * float(soffit @ np.abs(twice)) > 0.0:
        square = 0.5 * size * (1.0 - (ways * (slope / abs(slope)).conjugate()).real)
        best = int(square.argmax()) if len(ways) else 0
        sides = len(ways) > 0 and square[best] > SAME * size.max()
        along = np.sqrt(-mean[best] if sides else slope)
        return [_axes(along)]
    if not len(ways):
        return [_axes(along)]
    if (np.abs(ways + 1.0)[size >= (1.0 - SAME) * size.max()] > SAME).all():
        along = np.sqrt(np.sqrt(mean[size.argmax()] ** 2))
    return [_axes(along), _axes(1j * along)]


def _axes(along: complex) -> Floats:
    along /= abs(along)
    if along.real <= -along.imag:  # from -45 to 135 degrees
        along = -along
    x, y = np.round([along.real, along.imag], 12) + 0.0
    return np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])


def _plumb(strips: SeenStrips) -> Bools:
    """Which faces (m,), seen from above, are upright, or sides of a bridge that nearly are."""
    along, across, up = np.abs(np.round(strips.normal @ strips.axes.T, 6)).T
    return (strips.normal[:, 2] <= SAME) | ((up <= 1.0 / _PLUMB) & (across > along))


def _area(at: Spots, axes: Floats) -> Floats:
    """Of the face (p, 3), along its normal in world axes, by the area that is seen."""
    return np.asarray(np.column_stack([-at.slope, np.ones(len(at.slope))]) @ axes)


@dataclass(frozen=True, eq=False)
class Tops:
    """Tops of blocks under fill.

    Attributes
    ----------
    assembly
    fill
    strips
        Seen from above, t along the road and s across it.
    road : [m]
        Level of the road at ``middle``.
    middle : [m]
        Of the bridge, along the road.
    above
        All that is seen from above, and not only between two places.
    """

    assembly: Assembly
    fill: Fill
    strips: SeenStrips
    road: float
    middle: float
    above: SeenStrips

    @classmethod
    def of(cls, assembly: Assembly, fill: Fill) -> Self:
        """Those of an assembly; of the ways a road may run that on whose sides most holds fill."""
        ways = _road_axes(assembly)
        if len(ways) > 1:
            wide = replace(fill, between=fill.between and (-FARTHEST, FARTHEST))
            held = np.array([cls._along(assembly, wide, axes)._held for axes in ways])
            ways = [ways[int((held >= (1.0 - SAME) * held.max()).argmax())]]
        made = cls._along(assembly, fill, ways[0])
        free = made.strips.chosen(~assembly.fixed[made.strips.block])
        over = free.highest - made.level(free.t)
        if over.max() > 1e-9 * made.breadth:
            at = int(over.max(axis=1).argmax())
            name = assembly.names[free.block[at]]
            raise InputError(
                f"the road would be {over.max():.3g} m below the top of '{name}'",
                where="fill",
                remedy="give more cover",
            )
        _ = made._outside
        return made

    @classmethod
    def _along(cls, assembly: Assembly, fill: Fill, axes: Floats) -> Self:
        strips = above = SeenStrips.of(assembly, axes)
        if fill.between is not None:
            strips = strips.across(*fill.between)
        strips = strips.chosen(~_plumb(strips))  # those are seen from beside
        free = ~assembly.fixed[strips.block]
        if not free.any():
            raise InputError(
                "no free block has a top there", where="fill", remedy="see 'between' and supports"
            )
        road = float(strips.highest[free].max()) + fill.cover
        middle = 0.5 * float(strips.t[free].min() + strips.t[free].max())
        return cls(assembly, fill, strips, road, middle, above)

    @property
    def _held(self) -> float:
        """[m2], of upright faces that look across and have fill before them.

        That of the side with less, without ``between``: fill is held on both.
        """
        each = [float(one.area.sum()) for one in self.beside[2:]]
        return sum(each) if self.fill.between is not None else min(each)

    @cached_property
    def _outside(self) -> Bools:
        """Which strips look outwards and across where nothing higher holds fill: it only weighs.

        None where ``between`` says where fill is. Refuse those above 45 degrees and upright faces.
        """
        if self.fill.between is not None or not max(self.fill.k, self.fill.passive):
            return np.zeros(len(self.strips.t), dtype=bool)
        plans, (low, high) = (self.above, self.above.turned()), self.sides
        slopes, blocks, ends = [], [], []
        for plan, (steps, held) in zip(plans, self._steps[2:], strict=True):
            slope = -plan.slope[:, 1]
            steep = (slope > 1.0 / _PLUMB) & (slope > (1.0 + SAME) * np.abs(plan.slope[:, 0]))
            steep &= (plan.width.max(axis=1) > _UPRIGHT * self.breadth) & ~_plumb(plan)
            steep &= ~self.assembly.fixed[plan.block] & (plan.beyond <= plan.r.mean(axis=1))
            middle = self.sides.mean() * (plan.axes[1] @ self.strips.axes[1])
            steep &= plan.s.mean(axis=1) > middle
            held = held | (steps.r.mean(axis=1) < middle)  # it looks inwards
            slopes.append(steep)
            bad, faces = plan.chosen(steep & (slope > 1.0)), self._behind(steps.chosen(~held))
            blocks += [bad.block, faces.block]
            near = (bad.s - 0.5 * bad.width).mean(axis=1), faces.middle @ plan.axes[1]
            ends.append(np.concatenate(near).min(initial=high if plan is self.above else -low))
        block, first, last = np.concatenate(blocks), -ends[1], ends[0]
        if len(block):
            step = 10.0 ** math.floor(math.log10(self.breadth) - 3.0)  # of the digits that are told
            inside = math.ceil(first / step - SAME), math.floor(last / step + SAME)
            whole = math.floor(low / step) - 1, math.ceil(high / step) + 1
            each = [f"between={a * step + 0.0:.12g}m:{b * step + 0.0:.12g}m"
                    for a, b in (inside, whole) if a < b]  # fmt: skip
            names = named([self.assembly.names[i] for i in np.unique(block)], 2)
            raise InputError(
                f"it would press {names} from outside, where nothing higher holds it",
                where="fill",
                remedy=f"say where it lies, {' or, on all tops, '.join(each)}",
            )
        return (slopes[0] | slopes[1][::-1])[~_plumb(self.above)]

    def level(self, x: Floats) -> Floats:
        """Of the road [m] at places along it."""
        return np.asarray(self.road + self.fill.grade * (x - self.middle))

    def on_road(self, x: Floats) -> Floats:
        """Points (m, 3) [m] in the middle of the road at places along it (m,)."""
        local = np.column_stack([x, 0.0 * x + self.sides.mean(), self.level(x)])
        return np.asarray(local @ self.strips.axes)

    @property
    def ends(self) -> tuple[float, float]:
        """Least and largest place [m] along the road of the free blocks under fill."""
        return float(self._free.t.min()), float(self._free.t.max())

    @cached_property
    def _free(self) -> SeenStrips:
        return self.strips.chosen(~self.assembly.fixed[self.strips.block])

    @cached_property
    def sides(self) -> Floats:
        """Least and largest place (2,) [m] across the road of the tops of free blocks."""
        edge = 0.5 * self._free.width
        return np.array([(self._free.s - edge).min(), (self._free.s + edge).max()])

    @cached_property
    def _carriageway(self) -> SeenStrips:
        """What is between the sides of free blocks."""
        return self.strips.across(*self.sides)

    @property
    def breadth(self) -> float:
        """[m], across the road, of the free blocks."""
        return float(np.ptp(self.sides))

    def _wide(self, low: Floats, high: Floats) -> Floats:
        """Mean width (p,) [m] of the tops between two places along the road."""
        part, one = self._carriageway.within(low, high)
        first, last = np.full(len(low), np.inf), np.full(len(low), -np.inf)
        np.minimum.at(first, one, part.t[:, 0])
        np.maximum.at(last, one, part.t[:, 1])
        area = np.bincount(one, part.width.mean(axis=1) * np.ptp(part.t, axis=1), len(low))
        return np.divide(area, last - first, np.full(len(low), self.breadth), where=last > first)

    def depth(self, x: Floats) -> Floats:
        """(p,) [m], from the road to the mean free top at places, or at the nearest with one."""
        low, high = self._free.t.T
        away = np.maximum(np.maximum(low - x[:, None], x[:, None] - high), 0.0)
        one, own = np.nonzero(away <= away.min(axis=1, keepdims=True) + 1e-9 * self.breadth)
        here = self._free.chosen(own)
        share = np.clip((x[one] - here.t[:, 0]) / np.ptp(here.t, axis=1), 1e-9, 1.0 - 1e-9)
        width, top = (each[:, 0] + share * np.diff(each)[:, 0] for each in (here.width, here.r))
        mean = np.bincount(one, width * top) / np.bincount(one, width)
        return np.maximum(self.level(x) - mean, 0.0)

    def pressed(self, vertical: float, horizontal: float) -> Floats:
        """Wrenches (n, 6) of shares of the pressure of the weight, down and inwards."""
        each = self.pressures(vertical, horizontal)
        wrenches = [strips.wrenches(self.assembly, law) for strips, law in each]
        return sum(wrenches[1:], wrenches[0])

    def pressures(
        self, vertical: float, horizontal: float
    ) -> Sequence[tuple[SeenStrips, Traction]]:
        """What is pressed by these shares, seen from above and beside, and with what."""
        inside, outside = (self.strips.chosen(self._outside == one) for one in (False, True))
        beside = self.beside if horizontal else self.beside[2:]
        each = [(outside, 0.0), *((one, horizontal) for one in (inside, *beside))]
        return [(one, self._pressure(one.axes, vertical, share)) for one, share in each
                if len(one.block)]  # fmt: skip

    @cached_property
    def beside(self) -> Sequence[SeenStrips]:
        """Faces of free blocks, hidden from above, that fill presses: along and back, both across.

        Level before each of them, with no block between, fill is seen from above.
        """
        return [self._behind(steps) for steps, _ in self._steps]

    def _behind(self, steps: SeenStrips) -> SeenStrips:
        """What of free blocks is nearest behind steps, below the road, and looks most that way."""
        faces = SeenStrips.all_of(self.assembly, steps.axes)
        seen = steps.behind(faces, SAME * self.breadth)
        seen = seen.chosen(~self.assembly.fixed[seen.block] & self._looks(seen))
        ends = np.stack([seen.t, seen.s, seen.r], axis=2) @ seen.axes
        road = self.level(ends @ self.strips.axes[0])
        return seen.limited(np.full(road.shape, -FARTHEST), road)

    def _looks(self, seen: SeenStrips) -> Bools:
        """Which of some look most towards the eye, of the two ways along and the two across."""
        along, aside, _ = self.strips.axes
        ways = np.column_stack([along, -along, aside, -aside])
        level = np.round(seen.normal @ ways, 6)  # of two ways alike the first
        return np.asarray(np.argmax(level, axis=1) == np.argmax(seen.axes[2] @ ways))

    @cached_property
    def _steps(self) -> Sequence[tuple[SeenStrips, Bools]]:
        """Upright openings through which fill borders on what is higher, along and both across.

        With them comes whether, across, something as high stands beyond the fill.
        """
        aside, least, found = self.strips.axes[1], SAME * self.breadth, []
        for way, (steps, held) in enumerate(self._every_step):
            low, high = np.sort((steps.axes[0 if way < 2 else 2] @ aside) * self._sides)
            if way < 2:
                part, _ = steps.within(np.array([low]), np.array([high]))
                found.append((part, np.ones(len(part.t), dtype=bool)))
            else:
                near = steps.r.mean(axis=1) + least
                some = (near > low) & (near < high)
                found.append((steps.chosen(some), held[some]))
        return found

    @cached_property
    def _every_step(self) -> Sequence[tuple[SeenStrips, Bools]]:
        along, aside, up = self.strips.axes
        ahead = SeenStrips.of(self.assembly, np.stack([-aside, along, up]))
        plans = ahead, ahead.turned(), self.above, self.above.turned()
        return [self._stepped(plan, i < 2) for i, plan in enumerate(plans)]

    def _stepped(self, plan: SeenStrips, at_ends: bool) -> tuple[SeenStrips, Bools]:
        """Where strips are higher than the next along s, and where they end without a next."""
        least, slit = SAME * self.breadth, _SLIT * self.breadth
        band = plan.band
        low, high = plan.s - 0.5 * plan.width, plan.s + 0.5 * plan.width
        half = 0.5 * plan.slope[:, 1:] * plan.width
        first, last = plan.r - half, plan.r + half
        follows = np.diff(band) == 0
        follows &= (low[1:] - high[:-1]).mean(axis=1) <= slit
        chain = np.cumsum(np.append(False, ~follows))
        clear = _plumb(plan) & (not at_ends)
        deep = ((last[:-1] - first[1:]).mean(axis=1) > slit)[:-1] & follows[:-1]
        deep &= ((first[1:] - last[:-1]).mean(axis=1) > slit)[1:] & follows[1:]
        clear[1:-1] |= deep & (plan.width.max(axis=1) <= slit)[1:-1]
        one = np.flatnonzero(~clear)
        other = np.append(one[1:], one[-1:])
        goes_on = (one != other) & (chain[one] == chain[other])
        beyond = high[one].mean(axis=1) > self.middle * (plan.axes[1] @ self.strips.axes[0])
        ended = at_ends & beyond & ((one == other) | (band[one] != band[other]))
        floor = np.where(goes_on[:, None], first[other], self.assembly.bounds[..., 2].min())
        edge = np.where(goes_on[:, None], low[other], high[one])
        rise = last[one] - floor
        most = np.maximum(plan.beyond, plan.highest.max(axis=1))[other]
        held = most > (0.5 * (last[one] + floor)).mean(axis=1)
        if not at_ends and self.fill.between is None:  # fixed ground outside holds none
            free, final = (
                np.flatnonzero(~self.assembly.fixed[plan.block]),
                np.full(band[-1] + 1, -1),
            )
            np.maximum.at(final, band[free], free)
            inwards = edge.mean(axis=1) < self.sides.mean() * (plan.axes[1] @ self.strips.axes[1])
            goes_on &= held | inwards | (final[band[other]] >= other)
        turn = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
        t, s, width, r = (x[:, ::-1] for x in (-plan.t[one], 0.5 * (last[one] + floor), rise, edge))
        steps = SeenStrips(turn @ plan.axes, plan.block[one], t, s, width, r, 0.0 * plan.slope[one])
        steps, whose = steps.parted(rise[:, ::-1], least)
        some = (steps.width.mean(axis=1) > least) & (goes_on | ended)[whose]
        return steps.chosen(some), held[whose[some]]

    @cached_property
    def _sides(self) -> Floats:
        """Places (2,) [m] across between which fill lies: as given, or the sides of free blocks.

        Where these hold none, one free wall may do, with fixed blocks as high on one side.
        """
        if self.fill.between is not None:
            return np.array(self.fill.between)
        held, aside = np.zeros(3, dtype=bool), self.strips.axes[1]
        for steps, holds in self._every_step[2:]:
            free = holds & ~self.assembly.fixed[steps.block]
            near = (steps.r.mean(axis=1) + SAME * self.breadth) * (steps.axes[2] @ aside)
            held[np.searchsorted(self.sides, near[free])] = True
        far = held & (held.sum() == 1) & ~np.array([False, True, False])
        return self.sides + FARTHEST * (1.0 * far[2] * np.array([0, 1]) - far[0] * np.array([1, 0]))

    def _covered(self, at: Floats) -> Bools:
        """Whether there is a block above points (m, 3) [m] along the axes."""
        point, top = self._plan.query(shapely.points(at[:, :2]), "intersects")
        found = np.zeros(len(at), dtype=bool)
        each, x, y = self.above.chosen(top), *at[point, :2].T
        share = ((x - each.t[:, 0]) / np.ptp(each.t, axis=1))[:, None]
        s, r = (one[:, 0] + (share * np.diff(one))[:, 0] for one in (each.s, each.r))
        found[point[r + each.slope[:, 1] * (y - s) > at[point, 2]]] = True
        return found

    @cached_property
    def _plan(self) -> shapely.STRtree:
        """Outlines of all that is seen from above."""
        t, s, width = self.above.t, self.above.s, self.above.width
        low, high = s - 0.5 * width, s + 0.5 * width
        corner = np.concatenate([np.stack([t, low], 2), np.stack([t, high], 2)[:, ::-1]], axis=1)
        return shapely.STRtree(shapely.polygons(corner))

    @property
    def notes(self) -> tuple[str, ...]:
        """Which upright faces it presses, and which not."""
        if not max(self.fill.k, self.fill.passive):
            return ()
        axes, slit = self.strips.axes, _SLIT * self.breadth
        middle = np.average(self.above.s.mean(axis=1), weights=self.above.area)
        skew, below, bare = [], [], []
        for way, seen in enumerate(self.beside):
            eye = seen.axes[2]
            below.append(seen.block[self._covered((seen.middle + slit * eye) @ axes.T)])
            if way < 2:
                skew.append(seen.block[np.abs(seen.normal @ axes[1]) > 1.0 / _PLUMB])
            every = SeenStrips.all_of(self.assembly, seen.axes)
            away = (every.middle @ axes.T - [self.middle, middle, 0.0]) @ axes @ eye
            held = away > 0.0 if way < 2 else away < slit
            held &= (np.abs(every.normal[:, 2]) <= 1.0 / _PLUMB) & self._looks(every)
            every = every.chosen(held & ~self.assembly.fixed[every.block])
            near = (every.middle + slit * every.normal) @ axes.T
            open_ = ~self._covered(near) & (near[:, 2] < self.level(near[:, 0]))
            if way < 2:
                open_ &= (near[:, 1] > self._sides[0]) & (near[:, 1] < self._sides[1])
            bare.append(np.setdiff1d(every.block[open_], seen.block))
        several = ([one.block for one in self.beside], skew, below, bare)
        each = (
            named([self.assembly.names[i] for i in np.unique(np.concatenate(some))], 2)
            for some in several
        )
        words = (
            "fill acts on upright faces of {}, also at the ends, as if the road went on",
            "oblique faces of {} are pressed as ends of the road: check wings by hand",
            "fill below what juts out presses {}; its weight there is left out",
            "no fill is seen before upright faces of {}: it does not press them; see 'between', or "
            "check them by hand",
        )
        return tuple(told.format(names) for told, names in zip(words, each, strict=True) if names)

    @cached_property
    def resisting(self) -> Floats:
        """Wrenches (n, 6) of all that the fill resists beyond its pressure by ``k``.

        Of a block with fill on two sides it is their difference.
        """
        wrench = self.pressed(0.0, max(self.fill.passive - self.fill.k, 0.0))
        size = lengths(wrench[:, :3])
        return wrench * (size > SAME * size.max(initial=0.0))[:, None]

    @property
    def mass(self) -> CarriedMass:
        """Of the fill: its columns lie on the blocks under them, each at its own place."""
        down = self.pressed(1.0, 0.0)

        def pushed(axes: Floats) -> Traction:
            def traction(at: Spots) -> Floats:
                deep = self._deep(at.point)
                line = self.fill.weight * deep * np.maximum(_area(at, axes)[:, 2], 0.0)
                local = np.column_stack([line, 0.5 * deep * line, 0.0 * line])
                return np.asarray(local @ self.strips.axes @ axes.T)

            return traction

        # by a push along the torque about across has the heights of the tops, that across the half
        # depths
        push = np.zeros((len(self.assembly), 6))
        for one in (self.strips, *self.beside[2:]):
            push += one.wrenches(self.assembly, pushed(one.axes))
        height = (push[:, 3:] + push[:, :3]) @ self.strips.axes[1]
        place = np.column_stack([down[:, 4], -down[:, 3], height])
        by, gravity = 1.0 / STANDARD_GRAVITY, STANDARD_GRAVITY * np.array(DOWN)
        kind = "resisting fill" if self.fill.passive > self.fill.k else "fill"
        return CarriedMass(kind, -by * down[:, 2], by * place, gravity)

    def _deep(self, point: Floats) -> Floats:
        """[m], of points (p, 3) below the road."""
        return np.maximum(self.level(point @ self.strips.axes[0]) - point[:, 2], 0.0)

    def _pressure(self, axes: Floats, vertical: float, horizontal: float) -> Traction:
        """Shares of the pressure of the weight, on what looks up and across the vertical."""
        shares = np.array([horizontal, horizontal, vertical])

        def traction(at: Spots) -> Floats:
            area = _area(at, axes)
            area[:, 2] = np.maximum(area[:, 2], 0.0)
            down = self.fill.weight * self._deep(at.point)
            return np.asarray(-down[:, None] * (shares * area) @ axes.T)

        return traction

    def pieces(self, line: float, across: float, ends: Floats) -> Floats:
        """Wrenches (p, n, 6) of a line load [N/m] on pieces (p, 2) of the road; kept."""
        asked = [(line, across, *each) for each in ends.tolist()]
        new = [i for i, each in enumerate(asked) if each not in self._pieces]
        long = np.ptp(ends[new], axis=1)
        made = self.spread(line * long, ends[new].mean(axis=1), long, across)
        self._pieces.update(zip([asked[i] for i in new], made, strict=True))
        return np.array([self._pieces[each] for each in asked])

    @cached_property
    def _pieces(self) -> dict[tuple[float, ...], Floats]:
        return {}

    @cached_property
    def bridge(self) -> Tops:
        """With the tops beside ``between``."""
        if self.fill.between is None:
            return self
        return self._along(self.assembly, replace(self.fill, between=None), self.strips.axes)

    @cached_property
    def whole(self) -> bool:
        """Whether fill is held or ends at its sides; else it may be a strip of a wider bridge."""
        return self.fill.between is not None or self._held > 0.0

    def _reach(self, x: Floats, contact: Floats | float) -> Floats:
        """(p,) [m], to each side along the road, to which forces spread."""
        return np.maximum(0.5 * contact + self.fill.spread * self.depth(x), 1e-6 * self.breadth)

    def effective(self, x: Floats, contact: Floats | float, across: float) -> tuple[Floats, Floats]:
        """Widths (p,) [m] on which forces on the road count, and those of the bridge there.

        To the width on which it acts that to which it spreads is added at both sides: no ring
        beside it helps, as in CS 454, where a wheel has a strip of 1.5 m and the depth of fill.
        It is not more than that of a bridge, if that is ``whole``.
        """
        reach = self._reach(x, contact)
        wide = self.bridge._wide(x - reach, x + reach)
        if across == 0.0:
            return wide, wide
        spread = across + 2.0 * self.fill.spread * self.depth(x)
        return np.minimum(spread, wide) if self.whole else spread, wide

    def borne(self, x: Floats, contact: Floats | float, across: float) -> Floats:
        """The shares (p,) of forces on the road that act: width by effective width.

        Above one on a model that is wider: as if such forces stood side by side.
        """
        effective, wide = self.effective(x, contact, across)
        return np.asarray(wide / effective)

    def spread(
        self, force: Floats | float, x: Floats, contact: Floats | float, across: float
    ) -> Floats:
        """Wrenches (p, n, 6) of forces [N] down on the road at places (p,), each alone.

        Parameters
        ----------
        force : (p,) [N]
            One for all, or of each, as the contact.
        x
        contact : (p,) [m]
            Length along the road on which it acts.
        across : [m]
            Width on which it acts; the whole one where it is zero. Else it is ``borne``, evenly.
        """
        depth, contact = self.depth(x), np.broadcast_to(contact, len(x))
        reach = self._reach(x, contact)
        force = force * self.borne(x, contact, across)
        even = 0.5 * force / (reach * self._wide(x - reach, x + reach))
        part, one = self._carriageway.within(x - reach, x + reach)
        found = even[:, None, None] * part.wrenches_of(
            one, len(x), self.assembly, lambda at: np.tile(DOWN, (len(at.point), 1))
        )
        if self.fill.law == "boussinesq":
            for i in np.flatnonzero(depth > 0.0):
                places = x[i] + np.linspace(-8.0, 8.0, 129) * max(depth[i], 0.5 * contact[i])
                part = self._carriageway.within(places[:1], places[-1:])[0].cut_at(places)
                law = self._elastic(force[i], places, contact[i], depth[i])
                found[i] = part.wrenches(self.assembly, law)
        return found

    def _elastic(self, force: float, places: Floats, contact: float, depth: float) -> Traction:
        """Vertical pressure below an even strip load on an elastic half space, over the width.

        Source: Boussinesq 1885, as integrated over a strip by Terzaghi 1943, section 136.
        """
        half = max(0.5 * contact, 1e-6 * depth)
        wide = self._wide(places[:-1], places[1:])

        def traction(at: Spots) -> Floats:
            along = at.point @ self.strips.axes[0]
            away = along - 0.5 * (places[0] + places[-1])
            near, far = np.arctan((away - half) / depth), np.arctan((away + half) / depth)
            share = (far - near + 0.5 * (np.sin(2.0 * far) - np.sin(2.0 * near))) / np.pi
            line = force / wide[np.searchsorted(places[1:-1], along)]
            return np.column_stack([np.zeros((len(share), 2)), -share * line / (2.0 * half)])

        return traction


_GRAZED = math.tan(math.radians(80.0))
"""Slope of a face across the line of sight. Chosen: a splayed wing wall has less."""
_WATER = 9810.0
"""[N/m3]"""


@dataclass(frozen=True)
class Earth(Options):
    """Level earth on one side of a wall.

    Attributes
    ----------
    side
        On which it lies: ``x``, ``-x``, ``y`` or ``-y``.
    weight : [N/m3] >= 0, <= 1e6
        By volume, also where it is saturated.
    k : >= 0, <= 100
        Horizontal by vertical pressure.
    top : [m] >= -1e5, <= 1e5
        Level of its surface; the top of what is seen when left out.
    surcharge : [Pa] >= 0, <= 1e9
        On its surface.
    water : [m] >= -1e5, <= 1e5
        Level of the water in it; none when left out.
    wall_friction : coefficient >= 0, <= 100
        Of the wall: the earth drags it down by this share of its pressure. No more than its own.
    blocks
        On which it presses, names and patterns with ``+`` between them; all that are seen when left
        out.

    Notes
    -----
    At depth h the vertical pressure is ``surcharge + weight * h``, less that of water below its
    level. It acts on what is inclined and looks up, and ``k`` times it on vertical areas, level and
    square to the face in plan, both where no other block lies before a face; the pressure of water
    is added.

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
            size, angle = pressure_ratio(text), text.partition(":")[2]
            soil.extend([units.coefficient(angle)] if angle else [])
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
        made = cls(**read_words(text, "earth", known, "side=-x,weight=18kN/m3,k=0.33"))
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
        if top <= float(strips.t.min()):
            raise InputError(
                f"its top, {top:g} m, is below the wall", where="earth", remedy="give a level"
            )
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

        kind = f"earth of {quantity(self.weight, 'N')}/m3 on side {self.side} with K {self.k:.3g}"
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
        notes = (f"{note}10 degrees, square to them",) if ends else ()
        return LoadCase(strips.wrenches(assembly, traction), name, notes, surface=surface)


Reader = Callable[[str], Any]
_MASSES = {name: STANDARD_GRAVITY * kg for name, kg in units.MASSES.items()}


def read_words(text: str, what: str, known: Mapping[str, Reader], example: str) -> dict[str, Any]:
    """The values of ``name=value,name=value``.

    Parameters
    ----------
    text
    what
        Is described.
    known
        Names, and what reads the value of each.
    example
        Its names must be given.

    Raises
    ------
    InputError
        A name is unknown, given twice or missing, or its value cannot be read.
    """
    found: dict[str, Any] = {}
    for part in text.split(","):
        name, _, value = (one.strip() for one in part.partition("="))
        names = f"give some of {', '.join(known)}, each once; such as {example}"
        if not value:
            raise InputError(f"'{part}' is not NAME=VALUE", remedy=names)
        if name not in known:
            raise InputError(f"{what} has no '{name}'", remedy=meant(name, known, names))
        if name in found:
            raise InputError(f"'{name}' is given twice", remedy=names)
        try:
            found[name] = known[name](value)
        except InputError as error:
            raise InputError(f"{name}: {error.what}", remedy=error.remedy) from error
    for part in example.split(","):
        name = part.partition("=")[0]
        if name not in found:
            raise InputError(f"{what} has no {name}", remedy=f"write {example}")
    return found


def weight(text: str) -> float:
    """A weight by volume [N/m3], such as ``20kN/m3`` or ``2000kg/m3``.

    Examples
    --------
    >>> weight("20kN/m3"), weight("2000kg/m3")
    (20000.0, 19620.0)
    """
    size, slash, _ = text.partition("/m3")
    if not slash:
        raise InputError(f"'{text}' has no unit", remedy="write 20kN/m3 or 2000kg/m3")
    return units.measured(size, units.FORCES | _MASSES, what="weight")


def force(text: str) -> float:
    """A force [N], such as ``300kN``, or the weight of a mass such as ``22.5t``."""
    return units.measured(text, units.FORCES | _MASSES, what="load")


def pressure(text: str) -> float:
    """A pressure [Pa], such as ``10kPa`` or ``10kN/m2``."""
    size, slash, _ = text.partition("/m2")
    known = units.FORCES if slash else units.PRESSURES | {"kN/m2": 1e3}  # to be told
    return units.measured(size, known, what="pressure")


def length(text: str) -> float:
    """A length [m]."""
    return units.length(text, "length")


def spread(text: str) -> float:
    """Horizontal by vertical: ``2:1`` (down to across), ``30deg`` from the vertical, or a number.

    Examples
    --------
    >>> spread("2:1"), round(spread("45deg"), 6)
    (0.5, 1.0)
    """
    down, colon, across = text.partition(":")
    if not colon:
        return units.coefficient(text)
    try:
        return float(across) / float(down)
    except (ValueError, ZeroDivisionError) as error:
        raise InputError(f"'{text}' is no slope", remedy="write 2:1 or 30deg") from error


def _between(text: str) -> tuple[float, float]:
    """Two places [m], such as ``-1.5m:1.5m``."""
    low, colon, high = text.partition(":")
    if not colon:
        raise InputError(f"'{text}' is one place", remedy="write two, such as -1.5m:1.5m")
    return length(low), length(high)


def grade(text: str) -> float:
    """A rise by length: ``3%``, or a number.

    Examples
    --------
    >>> grade("3%"), grade("-0.02")
    (0.03, -0.02)
    """
    number = units.measured(text.removesuffix("%"), {}, 1.0, "grade")
    return number / 100.0 if text.endswith("%") else number


def pressure_ratio(text: str) -> float:
    """Horizontal by vertical pressure: a number, or ``active:``, ``rest:``, ``passive:30deg``.

    Rankine 1857 for the active and the passive one of an angle of friction, Jaky 1944 at rest.

    Examples
    --------
    >>> [round(pressure_ratio(f"{state}:30deg"), 3) for state in ("active", "rest", "passive")]
    [0.333, 0.5, 3.0]
    """
    state, colon, angle = text.partition(":")
    if not colon and text.endswith(units.ANGLES):
        raise InputError(f"'{text}' is an angle", remedy=f"write active:{text}, or the ratio")
    if not colon:
        return units.coefficient(text)
    if not angle.endswith(units.ANGLES):
        raise InputError(f"'{angle}' is no angle", remedy=f"write {state}:30deg")
    sine = math.sin(math.atan(units.coefficient(angle)))
    known = {
        "active": (1.0 - sine) / (1.0 + sine),
        "rest": 1.0 - sine,
        "passive": (1.0 + sine) / (1.0 - sine),
    }
    if state not in known:
        raise InputError(f"'{state}' is no state of earth", remedy="active, rest or passive")
    return known[state]
