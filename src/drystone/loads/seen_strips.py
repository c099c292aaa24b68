"""What can be seen of blocks from one side, in strips: where fill lies on them, or earth behind."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple, TypeAlias

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import ROUNDING, SAME, Bools, Floats, Ints, frozen, lengths
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.base.ragged import expand
from drystone.geometry.triangulate import triangulate
from drystone.loads.placing import SurfaceLoad

_GAUSS = 0.5 + np.array([-0.5, 0.0, 0.5]) * np.sqrt(0.6)
_SHARE = np.array([5.0, 8.0, 5.0]) / 18.0
"""Points and weights by which polynomials up to the fifth degree are integrated."""


class Spots(NamedTuple):
    """Points (p, 3) [m] of strips, and the slope (p, 2) of r along t and s."""

    point: Floats
    slope: Floats


Traction: TypeAlias = Callable[[Spots], Floats]
"""Traction along the axes (p, 3) [Pa], by area seen, at points."""


@dataclass(frozen=True, eq=False)
class SeenStrips(OneLine):
    """Strips of faces seen along ``-axes[2]``, cut across ``axes[0]``.

    Coordinates are along the axes: t along the first, s along the second, r towards the eye.

    Attributes
    ----------
    axes : (3, 3)
        Rows, right-handed.
    block : (m,)
    t : (m, 2) [m]
        Its two ends.
    s, width : (m, 2) [m]
        Middle and width of both ends.
    r : (m, 2) [m]
        At the middle of both ends.
    slope : (m, 2)
        Of r along t and s.
    """

    axes: Floats
    block: Ints
    t: Floats
    s: Floats
    width: Floats
    r: Floats
    slope: Floats

    def _summary(self) -> str:
        blocks = counted(len(np.unique(self.block)), "block")
        return f"{counted(len(self.block), 'strip')} of {blocks}"

    @classmethod
    def of(
        cls,
        assembly: Assembly,
        axes: Floats,
    ) -> SeenStrips:
        """Those of an assembly that no other block hides.

        Parameters
        ----------
        assembly
        axes : (3, 3)

        Examples
        --------
        >>> from drystone.models import tower
        >>> seen = SeenStrips.of(tower(3), np.eye(3))
        >>> float((seen.width.mean(axis=1) * np.diff(seen.t)[:, 0]).sum())
        1.0
        """
        return cls.all_of(assembly, axes)._nearest(ROUNDING * _extent(assembly))

    @classmethod
    def all_of(cls, assembly: Assembly, axes: Floats) -> SeenStrips:
        """Those of all faces that look towards the eye, hidden or not."""
        faces = assembly.faces
        corner = faces.point[faces.loop]
        triangle, face = triangulate(corner, faces.start)
        at = corner[triangle] @ axes.T
        normal = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
        towards = normal[:, 2] > ROUNDING * np.linalg.norm(normal, axis=1)
        at, normal, block = at[towards], normal[towards], faces.owner[face[towards]]
        slope = -normal[:, :2] / normal[:, 2:]
        at = np.take_along_axis(at, np.argsort(at[..., 0], axis=1)[..., None], axis=1)
        cut = _on_line(at[:, 0], at[:, 2], at[:, 1, 0])
        ends = (
            np.stack([at[:, 0], at[:, 0], at[:, 1], cut], axis=1),
            np.stack([at[:, 1], cut, at[:, 2], at[:, 2]], axis=1),
        )
        both = np.concatenate(ends).reshape(-1, 2, 2, 3)  # strip, end, side
        middle, across = both.mean(axis=2), np.abs(np.diff(both[..., 1], axis=2))[..., 0]
        twice = np.tile(np.arange(len(at)), 2)
        made = cls(
            axes, block[twice], middle[..., 0], middle[..., 1], across, middle[..., 2], slope[twice]
        )
        least = ROUNDING * _extent(assembly)
        return made.chosen((np.ptp(made.t, axis=1) > least) & (made.width.max(axis=1) > least))

    def _nearest(self, least: float) -> SeenStrips:
        """What no other of them hides."""
        made = self.cut_at(self._places(least))
        made = made.chosen(np.ptp(made.t, axis=1) > 2.0 * least)
        return _visible(made._joined(), least)

    def behind(self, faces: SeenStrips, least: float) -> SeenStrips:
        """What is nearest behind openings, each seen from itself: no farther than below its top.

        Parameters
        ----------
        faces
            All that look towards the eye, along the same axes, of which s is up.
        least : [m]
            Of which faces may lie before an opening.
        """
        places = self._places(least)
        opening, faces = self.cut_at(places), faces.cut_at(places)
        opening = opening.chosen(np.ptp(opening.t, axis=1) > least)
        opening = opening.chosen(np.argsort(opening.t.mean(axis=1), kind="stable"))
        band = np.searchsorted(places, opening.t.mean(axis=1))
        rank = np.arange(len(band)) - np.searchsorted(band, band)
        found = []
        for k in range(int(rank.max(initial=-1)) + 1):
            here = np.full(len(places) + 1, -1)
            here[band[rank == k]] = np.flatnonzero(rank == k)
            which = here[np.searchsorted(places, faces.t.mean(axis=1))]
            some = faces.chosen(which >= 0)
            one = opening.chosen(which[which >= 0])._between(*some.t.T)
            juts = np.maximum(one.r - some.r, 0.0) * (some.slope[:, 1:] > -SAME)  # no batter does
            high = one.s + 0.5 * one.width - juts
            some = some.limited(one.s - 0.5 * one.width, high)
            one = opening.chosen(here[np.searchsorted(places, some.t.mean(axis=1))])
            eye = one._between(*some.t.T).r.mean(axis=1)
            found.append(some.chosen(some.r.mean(axis=1) <= eye + least)._nearest(least))
        return opening.chosen(np.zeros(0, dtype=np.intp))._and(found)

    def down_to(self, floor: float, some: Bools) -> SeenStrips:
        """With plumb ones from the lower edges of some (m,) along s down to a place [m]."""
        edge, which = self.s - 0.5 * self.width, some[:, None]
        place, width = 0.5 * (edge + floor), np.maximum(edge - floor, 0.0) * which
        r = self.r - 0.5 * self.slope[:, 1:] * self.width
        slope = self.slope * np.array([1.0, 0.0])
        below = SeenStrips(self.axes, self.block, self.t, place, width, r, slope)
        return self._and([below.chosen(width.max(axis=1) > 0.0)])

    def turned(self) -> SeenStrips:
        """The same in the other order, with the first two axes the other way."""
        axes, back = self.axes * np.array([[-1.0], [-1.0], [1.0]]), slice(None, None, -1)
        t, s, width, r = (one[::-1, ::-1] for one in (-self.t, -self.s, self.width, self.r))
        return SeenStrips(axes, self.block[back], t, s, width, r, -self.slope[back])

    @property
    def band(self) -> Ints:
        """(m,), at which place along t each is, of all that are seen: these are in its order."""
        t, least = self.t.mean(axis=1), ROUNDING * float(np.abs(self.t).max(initial=0.0))
        return np.cumsum(np.abs(np.diff(t, prepend=t[:1])) > least)

    @property
    def beyond(self) -> Floats:
        """(m,) [m], the largest r of what is seen farther along s at the same place along t."""
        most = self.highest.max(axis=1)
        apart = 2.0 * np.ptp(most) * self.band
        after = np.append((most - apart)[1:], -np.inf)
        return np.asarray(np.maximum.accumulate(after[::-1])[::-1] + apart)

    @property
    def normal(self) -> Floats:
        """(m, 3), of length 1."""
        towards = np.column_stack([-self.slope, np.ones(len(self.slope))]) @ self.axes
        return np.asarray(towards / lengths(towards)[:, None])

    @property
    def area(self) -> Floats:
        """(m,) [m2], of the faces."""
        seen = self.width.mean(axis=1) * np.ptp(self.t, axis=1)
        return np.asarray(seen / (self.normal @ self.axes[2]))

    @property
    def highest(self) -> Floats:
        """Largest r (m, 2) [m] at both ends."""
        return np.asarray(self.r + 0.5 * np.abs(self.slope[:, 1:]) * self.width)

    @property
    def middle(self) -> Floats:
        """(m, 3) [m], inside, where half of each lies on both sides along t; world axes."""
        share = self.width @ [1.0, 2.0] / (3.0 * self.width.sum(axis=1))
        ends = np.stack([self.t, self.s, self.r], axis=2)
        return np.asarray((ends[:, 0] + share[:, None] * np.diff(ends, axis=1)[:, 0]) @ self.axes)

    def chosen(self, which: Bools | Ints) -> SeenStrips:
        """Some of them."""
        return SeenStrips(
            self.axes,
            frozen(self.block[which]),
            *(frozen(one[which]) for one in (self.t, self.s, self.width, self.r, self.slope)),
        )

    def cut_at(self, places: Floats) -> SeenStrips:
        """The same strips, cut at places (c,) [m] along t."""
        first = np.searchsorted(places, self.t[:, 0], side="right")
        count = np.maximum(np.searchsorted(places, self.t[:, 1], side="left") - first, 0)
        own = np.repeat(np.arange(len(self.block)), count + 1)
        rank = np.arange(len(own)) - np.repeat(np.cumsum(count + 1) - count - 1, count + 1)
        inner = np.append(places, np.inf)
        low = np.where(rank == 0, self.t[own, 0], inner[first[own] + rank - 1])
        high = np.where(rank == count[own], self.t[own, 1], inner[first[own] + rank])
        return self.chosen(own)._between(low, high)

    def within(self, low: Floats, high: Floats) -> tuple[SeenStrips, Ints]:
        """Their parts between two places (p,) [m] along t, and between which each is."""
        one, own = np.nonzero((self.t[:, 0] < high[:, None]) & (self.t[:, 1] > low[:, None]))
        t = self.t[own]
        part = self.chosen(own)._between(
            np.maximum(t[:, 0], low[one]), np.minimum(t[:, 1], high[one])
        )
        return part, one

    def parted(self, value: Floats, least: float) -> tuple[SeenStrips, Ints]:
        """The same strips, cut where a value is zero that goes from one end to the other.

        With them comes of which strip each is a part.

        Parameters
        ----------
        value : (m, 2)
            At both ends.
        least
            What is taken for zero.
        """
        crosses = (value.min(axis=1) < -least) & (value.max(axis=1) > least)
        share = value[:, 0] / np.where(crosses, value[:, 0] - value[:, 1], 1.0)
        at = np.where(crosses, self.t[:, 0] + share * np.ptp(self.t, axis=1), self.t[:, 1])
        rest = self.chosen(crosses)._between(at[crosses], self.t[crosses, 1])
        whose = np.append(np.arange(len(at)), np.flatnonzero(crosses))
        return self._between(self.t[:, 0], at)._and([rest]), whose

    def across(self, *places: float) -> SeenStrips:
        """Their parts between the first and the last of some places [m] along s, cut at each."""
        edge = np.array(places)
        ends = np.stack([self.s - 0.5 * self.width, self.s + 0.5 * self.width])
        low, high = ends.min(axis=(0, 2)), ends.max(axis=(0, 2))
        strip, piece = np.nonzero((low[:, None] < edge[1:]) & (high[:, None] > edge[:-1]))
        each = (np.repeat(edge[piece + one, None], 2, axis=1) for one in (0, 1))
        return self.chosen(strip).limited(*each)

    def limited(self, low: Floats, high: Floats) -> SeenStrips:
        """Their parts between two lines, whose places (m, 2) [m] along s are given at both ends."""
        least = ROUNDING * float(np.abs(self.s).max(initial=0.0))
        made, whose = self.parted(high - low, least)
        line = np.stack([low, high], axis=1)  # strip, line, end
        slope = np.diff(line) / np.diff(self.t)[:, None]
        start = line[..., :1] - slope * self.t[:, None, :1]
        start, slope = start[whose], slope[whose]
        for one, half in product((0, 1), (-0.5, 0.5)):
            away = made.s + half * made.width - start[:, one] - slope[:, one] * made.t
            made, whose = made.parted(away, least)
            start, slope = start[whose], slope[whose]
        between = np.moveaxis(start + slope * made.t[:, None], 1, 0)
        first, last = (np.clip(made.s + half * made.width, *between) for half in (-0.5, 0.5))
        s = 0.5 * (first + last)
        r = made.r + made.slope[:, 1:] * (s - made.s)
        cut = SeenStrips(made.axes, made.block, made.t, s, last - first, r, made.slope)
        return cut.chosen((last - first).max(axis=1) > least)

    def _places(self, least: float) -> Floats:
        """Places (p,) [m] along t at which some begin or end, so many [m] apart."""
        places = np.unique(self.t)
        return places[np.diff(places, prepend=-np.inf) > least]

    def _bands(self, least: float) -> Iterator[SeenStrips]:
        """Those of each place along t, where these have the same ends to so many [m]."""
        middle = self.t.mean(axis=1)
        order = np.argsort(middle, kind="stable")
        ends = np.flatnonzero(np.diff(middle[order]) > least) + 1
        yield from (self.chosen(here) for here in np.split(order, ends) if len(here))

    def _and(self, others: Sequence[SeenStrips]) -> SeenStrips:
        names = "block", "t", "s", "width", "r", "slope"
        each = ([getattr(one, name) for one in (self, *others)] for name in names)
        return SeenStrips(self.axes, *(frozen(np.concatenate(some)) for some in each))

    def _between(self, low: Floats, high: Floats) -> SeenStrips:
        share = (np.stack([low, high], axis=1) - self.t[:, :1]) / np.diff(self.t)
        s, width, r = (
            frozen(one[:, :1] + share * np.diff(one)) for one in (self.s, self.width, self.r)
        )
        t = frozen(np.stack([low, high], axis=1))
        return SeenStrips(self.axes, self.block, t, s, width, r, self.slope)

    def _joined(self) -> SeenStrips:
        """One strip for those side by side of a plane face between two places: its triangles."""
        least = ROUNDING * max(float(np.abs(self.t).max(initial=0.0)), 1e-300)
        plane = self.r - (self.slope[:, :1] * self.t + self.slope[:, 1:] * self.s)
        alike = np.rint(np.column_stack([self.t, plane]) / least)
        key = np.column_stack([self.block, alike, np.rint(self.slope / ROUNDING)])
        order = np.lexsort((self.s.mean(axis=1), *key.T[::-1]))
        starts, stops = self.s - 0.5 * self.width, self.s + 0.5 * self.width
        apart = np.abs(starts[order[1:]] - stops[order[:-1]]).max(axis=1, initial=0.0) > least
        other = (key[order[1:]] != key[order[:-1]]).any(axis=1)
        new = np.append(True, other | apart)[: len(order)]
        group, first = np.cumsum(new) - 1, order[new]
        low, high = np.full((2, len(first), 2), np.inf)
        np.minimum.at(low, group, starts[order])
        np.minimum.at(high, group, -stops[order])
        one = self.chosen(first)
        s = 0.5 * (low - high)
        r = one.r + one.slope[:, 1:] * (s - one.s)
        return SeenStrips(
            one.axes, one.block, one.t, frozen(s), frozen(-high - low), frozen(r), one.slope
        )

    def surface(self, assembly: Assembly, traction: Traction) -> SurfaceLoad:
        """Traction by area of the face along the middles of strips of free blocks, if not zero.

        Those middles are across t where s is up, since pressure grows downwards.
        """
        free = self.chosen(~assembly.fixed[self.block])
        mine = free._joined()
        steep = np.repeat(mine.slope, 2, axis=0)
        inside = np.eye(2) + 1e-6 * np.array([[-1.0, 1.0], [1.0, -1.0]])  # where levels end
        ends = np.stack([mine.t, mine.s, mine.r], axis=2)
        if self.axes[1, 2] > SAME:
            up = np.insert(mine.slope, 1, 1.0, axis=1) * np.array([0.0, 1.0, 1.0])
            half = 0.5 * mine.width.mean(axis=1)[:, None, None] * up[:, None]
            ends = ends.mean(axis=1, keepdims=True) + half * np.array([[[-1.0], [1.0]]])
        point = ends @ self.axes
        spots = Spots((inside @ point).reshape(-1, 3), steep)
        by_area = (mine.normal @ self.axes[2])[:, None, None]
        pressed = by_area * (traction(spots) @ self.axes).reshape(-1, 2, 3)
        some = pressed.any(axis=(1, 2))
        wrench = free.wrenches(assembly, traction)
        return SurfaceLoad(mine.block[some], point[some], pressed[some], wrench)

    def wrenches(self, assembly: Assembly, traction: Traction) -> Floats:
        """Wrenches (n, 6) [N, N m] of a traction on the blocks."""
        return self.wrenches_of(np.zeros(len(self.block), dtype=np.intp), 1, assembly, traction)[0]

    def wrenches_of(
        self, group: Ints, count: int, assembly: Assembly, traction: Traction
    ) -> Floats:
        """Wrenches (count, n, 6) [N, N m] of a traction on each group (m,) of them."""
        ends = np.stack([1.0 - _GAUSS, _GAUSS]).repeat(2, axis=1)  # (2, 6)
        t, s, width, r = (one @ ends for one in (self.t, self.s, self.width, self.r))
        beside = width * np.tile([-0.5, 0.5], 3) / np.sqrt(3.0)  # exact to the third degree
        area = 0.5 * width * np.diff(self.t) * _SHARE.repeat(2)
        s, r = s + beside, r + self.slope[:, 1:] * beside
        steep = np.repeat(self.slope, 6, axis=0)
        point = np.stack([t.ravel(), s.ravel(), r.ravel()], axis=1) @ self.axes
        force = area.reshape(-1, 1) * traction(Spots(point, steep)) @ self.axes
        block, found = np.repeat(self.block, 6), np.zeros((count, len(assembly), 6))
        moment = np.cross(point - assembly.centroid[block], force)
        np.add.at(found, (np.repeat(group, 6), block), np.column_stack([force, moment]))
        return found


def _extent(assembly: Assembly) -> float:
    return float(np.ptp(assembly.bounds.reshape(-1, 3), axis=0).max())


def _on_line(start: Floats, end: Floats, t: Floats) -> Floats:
    """Points (m, 3) on lines at their first coordinate (m,)."""
    length = end[:, 0] - start[:, 0]
    share = (t - start[:, 0]) / np.where(length > 0.0, length, 1.0)
    return np.asarray(start + share[:, None] * (end - start))


def _visible(strips: SeenStrips, least: float) -> SeenStrips:
    """What no other strip hides, where all strips at one place along t have the same ends.

    The lines along which strips end part what is between two ends: each part is that of the strip
    nearest to the eye. Strips are cut as well where such lines cross.
    """
    seen = []
    for band in strips._bands(least):
        crossed = _crossings(band, least)
        pieces = band.cut_at(crossed)._bands(least) if len(crossed) else [band]
        seen += [_parts(one, least) for one in pieces]
    return strips.chosen(np.zeros(0, dtype=np.intp))._and(seen)


def _lines(band: SeenStrips) -> Floats:
    """Lines (l, 2) [m] along which strips begin, then those along which they end, at both ends."""
    return np.concatenate([band.s - 0.5 * band.width, band.s + 0.5 * band.width])


def _crossings(band: SeenStrips, least: float) -> Floats:
    """Places [m] along t, inside, at which sides of strips of a band cross with no other before."""
    start, end = _lines(band).T
    order = np.argsort(start)
    passed = order[np.maximum.accumulate(end[order]) - end[order] > least]
    before, after = (each[passed, None] - each for each in (start, end))
    one, other = np.nonzero((before > least) & (after < -least))
    if not len(one):
        return np.zeros(0)
    share = before[one, other] / (before - after)[one, other]
    one = passed[one]
    at = start[one] + share * (end - start)[one]
    s, width, r = (x[:, :1] + share * np.diff(x) for x in (band.s, band.width, band.r))
    r = r + band.slope[:, 1:] * (at - s)
    each, pair = np.arange(len(share)), np.stack([one, other]) % len(band.block)
    lower = r[pair, each].min(axis=0)
    away, half = at - s, 0.5 * width
    # Of what sinks by rounding no line is hidden. Measured: of coordinates of four digits, without
    # this tolerance, 1.4 % more than the plan was seen.
    covers = (np.abs(away) <= half + least) & (r > lower + 1e5 * least)
    hidden = [(covers & (half - side > least)).any(axis=0) for side in (away, -away)]
    low, high = band.t[0]
    found = np.unique(low + share[~np.logical_and(*hidden)] * (high - low))
    inside = (np.diff(found, prepend=low) > 2.0 * least) & (high - found > 2.0 * least)
    return np.asarray(found[inside])


def _parts(band: SeenStrips, least: float) -> SeenStrips:
    """What is seen of strips between the same ends, whose sides do not cross."""
    own, count = _lines(band), len(band.block)
    middle = 0.5 * (own[:, 0] + own[:, 1])
    at = np.sort(middle)
    parts = np.flatnonzero(at[1:] - at[:-1] > least)
    centre = 0.5 * (at[parts] + at[parts + 1])
    lowest = np.searchsorted(centre, middle[:count], "right")
    covered = np.searchsorted(centre, middle[count:]) - lowest
    strip, part = expand(lowest, np.maximum(covered, 0))
    s, r = band.s.mean(axis=1)[strip], band.r.mean(axis=1)[strip]
    near = r + band.slope[strip, 1] * (centre[part] - s)
    order = np.lexsort((-strip, near))
    top = np.full(len(parts), -1)
    top[part[order]] = strip[order]  # the nearest is the last
    first = np.flatnonzero(np.diff(top, prepend=-2))
    place = at[np.append(parts[first], parts[-1:] + 1)]
    # a side is that of what begins or ends there
    after, before = np.append(top[first], -1), np.append(-1, top[first])
    begins, ends = (np.abs(middle[one] - place) for one in (after, count + before))
    begins, ends = np.where(after < 0, np.inf, begins), np.where(before < 0, np.inf, ends)
    side = own[np.where(begins <= ends, after, count + before)]
    some = top[first] >= 0
    low, high = side[:-1][some], side[1:][some]
    one, s = band.chosen(top[first[some]]), 0.5 * (low + high)
    r = one.r + one.slope[:, 1:] * (s - one.s)
    width = np.maximum(high - low, 0.0)
    return SeenStrips(one.axes, one.block, one.t, s, width, r, one.slope)
