"""Below a road and beside it: tops of blocks that are seen, and faces that these hide."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Self

import numpy as np
import shapely

from drystone.assembly import Assembly
from drystone.base.arrays import FARTHEST, SAME, Bools, Floats, lengths
from drystone.base.display import named
from drystone.base.errors import InputError
from drystone.loads.seen_strips import SeenStrips

_UPRIGHT = 1e-3
"""Rise of the normal of a side of a bridge. Chosen: coordinates in whole millimetres have less."""
_SLOPES = 0.1
"""Share by which soffits slope one way more than square to it; of domes with few stones less."""
_PLUMB = 20.0
"""Slope from which on a face is the side of a bridge. Chosen: no batter and no dome is as steep."""
_SLIT = 0.01
"""Of the breadth of a bridge: into narrower gaps no fill falls. Chosen: joints of 1 cm are open."""


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


@dataclass(frozen=True, eq=False)
class Roadway:
    """What lies below a road and beside it.

    Attributes
    ----------
    assembly
    grade
        Rise of the road by length along it.
    between : (2,) [m]
        Places across the road between which fill lies; ``None`` for all tops.
    strips
        Seen from above, t along the road and s across it.
    height : [m]
        Level of the road at ``middle``.
    middle : [m]
        Of the bridge, along the road.
    above
        All that is seen from above, and not only between two places.
    """

    assembly: Assembly
    grade: float
    between: tuple[float, float] | None
    strips: SeenStrips
    height: float
    middle: float
    above: SeenStrips

    @classmethod
    @lru_cache(maxsize=1)  # a load, what resists it and each train ask for that of the same model
    def of(
        cls, assembly: Assembly, cover: float, grade: float, between: tuple[float, float] | None
    ) -> Self:
        """Of the ways a road may run that on whose sides most holds fill.

        Parameters
        ----------
        assembly
        cover : [m]
            Of the road above the highest block, at the middle of the bridge.
        grade
        between

        Raises
        ------
        InputError
            No free block has a top there, or one is above the road.
        """
        ways = [SeenStrips.of(assembly, axes) for axes in _road_axes(assembly)]
        if len(ways) > 1:
            wide = between and (-FARTHEST, FARTHEST)
            held = np.array([cls.along(assembly, cover, grade, wide, one).held for one in ways])
            ways = [ways[int((held >= (1.0 - SAME) * held.max()).argmax())]]
        made = cls.along(assembly, cover, grade, between, ways[0])
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
        return made

    @classmethod
    def along(
        cls,
        assembly: Assembly,
        cover: float,
        grade: float,
        between: tuple[float, float] | None,
        above: SeenStrips,
    ) -> Self:
        """The same of a road along ``above.axes[0]``, if blocks are above it or not."""
        strips = above if between is None else above.across(*between)
        strips = strips.chosen(~_plumb(strips))  # those are seen from beside
        free = ~assembly.fixed[strips.block]
        if not free.any():
            raise InputError(
                "no free block has a top there", where="fill", remedy="see 'between' and supports"
            )
        height = float(strips.highest[free].max()) + cover
        middle = 0.5 * float(strips.t[free].min() + strips.t[free].max())
        return cls(assembly, grade, between, strips, height, middle, above)

    @property
    def held(self) -> float:
        """[m2], of upright faces that look across and have fill before them.

        That of the side with less, without ``between``: fill is held on both.
        """
        each = [float(one.area.sum()) for one in self.beside[2:]]
        return sum(each) if self.between is not None else min(each)

    @cached_property
    def outside(self) -> Bools:
        """Which strips look outwards and across where nothing higher holds fill: it only weighs.

        None where ``between`` says where fill is. Refuse those above 45 degrees and upright faces.
        """
        if self.between is not None:
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
            bad = plan.chosen(steep & (slope > 1.0))
            faces = self._behind(steps.chosen(~held), self._faces(steps))
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
        return np.asarray(self.height + self.grade * (x - self.middle))

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
    def carriageway(self) -> SeenStrips:
        """What is between the sides of free blocks."""
        return self.strips.across(*self.sides)

    @property
    def breadth(self) -> float:
        """[m], across the road, of the free blocks."""
        return float(np.ptp(self.sides))

    @cached_property
    def skew(self) -> float:
        """How far the middle between the ends moves along the road by length across; else zero."""
        low, high = self.sides
        halves = [self._free.across(*half).t for half in ((low, self.sides.mean()),
                  (self.sides.mean(), high))]  # fmt: skip
        left, right = (0.5 * (t.min() + t.max()) for t in halves)
        skew = float(right - left) / (0.5 * self.breadth)
        return skew if abs(skew) > _UPRIGHT else 0.0

    def lanes(self, count: int) -> Sequence[tuple[Self, float]]:
        """Parts side by side, as wide as each other, and how far [m] on along it each lies."""
        if count == 1:
            return [(self, 0.0)]
        cuts = np.linspace(self.sides[0], self.sides[1], count + 1)
        middle = 0.5 * (cuts[1:] + cuts[:-1])
        parts = [replace(self, strips=self.strips.across(*one)) for one in pairwise(cuts.tolist())]
        return [*zip(parts, (self.skew * (middle - middle.mean())).tolist(), strict=True)]

    def wide(self, low: Floats, high: Floats) -> Floats:
        """Mean width (p,) [m] of the tops between two places along the road."""
        part, one = self.carriageway.within(low, high)
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

    def deep(self, point: Floats) -> Floats:
        """[m], of points (p, 3) below the road."""
        return np.maximum(self.level(point @ self.strips.axes[0]) - point[:, 2], 0.0)

    @cached_property
    def beside(self) -> Sequence[SeenStrips]:
        """Faces of free blocks, hidden from above, that fill presses: along and back, both across.

        Level before each of them, with no block between, fill is seen from above. Along, the ground
        below what is fixed is between.
        """
        return [
            self._behind(steps, self._grounded(steps) if way < 2 else self._faces(steps))
            for way, (steps, _) in enumerate(self._steps)
        ]

    def _grounded(self, steps: SeenStrips) -> SeenStrips:
        """The same, with the ground below what is fixed."""
        faces = self._faces(steps)
        return faces.down_to(self.assembly.bounds[..., 2].min(), self.assembly.fixed[faces.block])

    def _faces(self, steps: SeenStrips) -> SeenStrips:
        """All faces that look as steps do."""
        return SeenStrips.all_of(self.assembly, steps.axes)

    def _behind(self, steps: SeenStrips, faces: SeenStrips) -> SeenStrips:
        """Which free faces are nearest behind steps, below the road, and look most that way."""
        seen, fixed = steps.behind(faces, SAME * self.breadth), self.assembly.fixed
        seen = seen.chosen(~fixed[seen.block] & self._looks(seen))
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
        if not at_ends and self.between is None:  # fixed ground outside holds none
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
        if self.between is not None:
            return np.array(self.between)
        held, aside = np.zeros(3, dtype=bool), self.strips.axes[1]
        for steps, holds in self._every_step[2:]:
            free = holds & ~self.assembly.fixed[steps.block]
            near = (steps.r.mean(axis=1) + SAME * self.breadth) * (steps.axes[2] @ aside)
            held[np.searchsorted(self.sides, near[free])] = True
        far = held & (held.sum() == 1) & ~np.array([False, True, False])
        return self.sides + FARTHEST * (1.0 * far[2] * np.array([0, 1]) - far[0] * np.array([1, 0]))

    @property
    def notes(self) -> tuple[str, ...]:
        """Which upright faces it presses, and which not."""
        axes, slit = self.strips.axes, _SLIT * self.breadth
        middle = np.average(self.above.s.mean(axis=1), weights=self.above.area)
        skew, below, bare, kept = [], [], [], []
        for way, seen in enumerate(self.beside):
            eye, every = seen.axes[2], self._faces(seen)
            below.append(seen.block[self._covered((seen.middle + slit * eye) @ axes.T)])
            if way < 2:
                skew.append(seen.block[np.abs(seen.normal @ axes[1]) > 1.0 / _PLUMB])
                bare_ground = self._behind(self._steps[way][0], every)
                areas = (np.bincount(one.block, one.area, len(self.assembly.fixed))
                         for one in (bare_ground, seen))  # fmt: skip
                kept.append(np.flatnonzero(np.subtract(*areas) > slit**2))
            away = (every.middle @ axes.T - [self.middle, middle, 0.0]) @ axes @ eye
            held = away > 0.0 if way < 2 else away < slit
            held &= (np.abs(every.normal[:, 2]) <= 1.0 / _PLUMB) & self._looks(every)
            every = every.chosen(held & ~self.assembly.fixed[every.block])
            near = (every.middle + slit * every.normal) @ axes.T
            open_ = ~self._covered(near) & (near[:, 2] < self.level(near[:, 0]))
            if way < 2:
                open_ &= (near[:, 1] > self._sides[0]) & (near[:, 1] < self._sides[1])
            bare.append(np.setdiff1d(every.block[open_], seen.block))
        several = ([one.block for one in self.beside], skew, below, bare, kept)
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
            "the ground below fixed blocks keeps fill from upright faces of {}: check them by hand "
            "where fill goes on below those",
        )
        return tuple(told.format(names) for told, names in zip(words, each, strict=True) if names)

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
