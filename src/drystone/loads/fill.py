"""Fill of a bridge: pressure on the faces that it touches, and how a load on the road spreads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, Self

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Bools, Floats, lengths
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.base.units import quantity
from drystone.loads.case import DOWN, STANDARD_GRAVITY, LoadCase
from drystone.loads.ground_words import (
    Reader,
    between,
    grade,
    length,
    pressure_ratio,
    read_words,
    spread,
    weight,
)
from drystone.loads.placing import CarriedMass, GivenLoad, SurfaceLoad
from drystone.loads.roadway import Roadway
from drystone.loads.seen_strips import SeenStrips, Spots, Traction


@dataclass(frozen=True)
class Fill(Options):
    """Fill between the tops of blocks and a road.

    Attributes
    ----------
    cover : [m] >= 0, <= 100
        Of the road above the highest block, at the middle of the bridge.
    weight : [N/m3] >= 0, <= 1e6
        By volume.
    k : >= 0, <= 15
        Horizontal by vertical pressure on what is inclined.
    passive : >= 0, <= 15
        Largest such ratio that fill mobilises against what moves into it; none at zero. ``limit
        train`` uses it, and all that is asked with the tie ``fill``.
    spread : >= 0, <= 2
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
        if not (self.cover or self.weight or self.spread):
            return "no fill: a load acts where it stands"
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
            "between": between,
        }
        example = "cover=0.3m,weight=20kN/m3"
        return read_words(
            cls, text, "fill", known, example, k="active:", passive="passive:", spread=""
        )

    def on(self, assembly: Assembly) -> LoadCase:
        """Its weight, and its pressure by ``k``, on the free blocks."""
        return Tops.of(assembly, self).load


def _area(at: Spots, axes: Floats) -> Floats:
    """Of the face (p, 3), along its normal in world axes, by the area that is seen."""
    return np.asarray(np.column_stack([-at.slope, np.ones(len(at.slope))]) @ axes)


_LANES = 16
"""Of trains side by side on a skew bridge, staggered: 8 carry 1 % more at 20 degrees and 10 m."""


@dataclass(frozen=True, eq=False)
class Tops:
    """Tops of blocks under fill.

    Attributes
    ----------
    fill
    road
        What lies below it.
    """

    fill: Fill
    road: Roadway

    @classmethod
    def of(cls, assembly: Assembly, fill: Fill) -> Self:
        """Those of an assembly; see :meth:`Roadway.of`."""
        made = cls(fill, Roadway.of(assembly, fill.cover, fill.grade, fill.between))
        _ = made._outside
        return made

    @property
    def _presses(self) -> bool:
        """Whether fill does more than weigh."""
        return max(self.fill.k, self.fill.passive) > 0.0

    @property
    def _outside(self) -> Bools:
        """Which strips fill only weighs on: none where it does no more."""
        road = self.road
        return road.outside if self._presses else np.zeros(len(road.strips.t), dtype=bool)

    @property
    def notes(self) -> tuple[str, ...]:
        """Which upright faces it presses, and which not."""
        return self.road.notes if self._presses else ()

    def pressed(self, vertical: float, horizontal: float) -> Floats:
        """Wrenches (n, 6) of shares of the pressure of the weight, down and inwards."""
        each = self.pressures(vertical, horizontal)
        wrenches = [strips.wrenches(self.road.assembly, law) for strips, law in each]
        return sum(wrenches[1:], wrenches[0])

    def pressures(
        self, vertical: float, horizontal: float
    ) -> Sequence[tuple[SeenStrips, Traction]]:
        """What is pressed by these shares, seen from above and beside, and with what."""
        inside, outside = (self.road.strips.chosen(self._outside == one) for one in (False, True))
        beside = self.road.beside if horizontal else self.road.beside[2:]
        each = [(outside, 0.0), *((one, horizontal) for one in (inside, *beside))]
        return [(one, self._pressure(one.axes, vertical, share)) for one, share in each
                if len(one.block)]  # fmt: skip

    @cached_property
    def resisting(self) -> Floats:
        """Wrenches (n, 6) of all that the fill resists beyond its pressure by ``k``.

        Of a block with fill on two sides it is their difference.
        """
        wrench = self.pressed(0.0, max(self.fill.passive - self.fill.k, 0.0))
        size = lengths(wrench[:, :3])
        return wrench * (size > SAME * size.max(initial=0.0))[:, None]

    @property
    def load(self) -> LoadCase:
        """The weight of the fill, and its pressure by ``k``, on the free blocks."""
        fill, assembly = self.fill, self.road.assembly
        fields = (strips.surface(assembly, law) for strips, law in self.pressures(1.0, fill.k))
        wrench = self.pressed(1.0, fill.k)
        return LoadCase(
            wrench,
            fill.words,
            (*fill.notes, *self.notes),
            surface=SurfaceLoad.of_all([one for one in fields if len(one.block)]),
            fills=(fill,),
            masses=(self.mass,),
            each=GivenLoad.of("pressure of fill", self.pressed(0.0, fill.k)),
        )

    @property
    def mass(self) -> CarriedMass:
        """Of the fill: its columns lie on the blocks under them, each at its own place."""
        down = self.pressed(1.0, 0.0)

        def pushed(axes: Floats) -> Traction:
            def traction(at: Spots) -> Floats:
                deep = self.road.deep(at.point)
                line = self.fill.weight * deep * np.maximum(_area(at, axes)[:, 2], 0.0)
                local = np.column_stack([line, 0.5 * deep * line, 0.0 * line])
                return np.asarray(local @ self.road.strips.axes @ axes.T)

            return traction

        # by a push along the torque about across has the heights of the tops, that across the half
        # depths
        push = np.zeros((len(self.road.assembly), 6))
        for one in (self.road.strips, *self.road.beside[2:]):
            push += one.wrenches(self.road.assembly, pushed(one.axes))
        height = (push[:, 3:] + push[:, :3]) @ self.road.strips.axes[1]
        place = np.column_stack([down[:, 4], -down[:, 3], height])
        by, gravity = 1.0 / STANDARD_GRAVITY, STANDARD_GRAVITY * np.array(DOWN)
        kind = "resisting fill" if self.fill.passive > self.fill.k else "fill"
        return CarriedMass(kind, -by * down[:, 2], by * place, gravity)

    def _pressure(self, axes: Floats, vertical: float, horizontal: float) -> Traction:
        """Shares of the pressure of the weight, on what looks up and across the vertical."""
        shares = np.array([horizontal, horizontal, vertical])

        def traction(at: Spots) -> Floats:
            area = _area(at, axes)
            area[:, 2] = np.maximum(area[:, 2], 0.0)
            down = self.fill.weight * self.road.deep(at.point)
            return np.asarray(-down[:, None] * (shares * area) @ axes.T)

        return traction

    def pieces(self, line: float, across: float, ends: Floats) -> Floats:
        """Wrenches (p, n, 6) of a line load [N/m] on pieces (p, 2) of the road; kept."""
        asked = [(line, across, *each) for each in ends.tolist()]
        new = [i for i, each in enumerate(asked) if each not in self._pieces]
        if new:
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
        fill, road = replace(self.fill, between=None), self.road
        return Tops(fill, Roadway.along(road.assembly, fill.cover, fill.grade, None, road.above))

    @cached_property
    def whole(self) -> bool:
        """Whether fill is held or ends at its sides; else it may be a strip of a wider bridge."""
        return self.fill.between is not None or self.road.held > 0.0

    def _lanes(self, across: float) -> Sequence[tuple[Roadway, float]]:
        """Parts of a skew road wider than an axle counts on, and how far on they are; else all."""
        if across == 0.0 or self.road.skew == 0.0:
            return [(self.road, 0.0)]
        if across not in self._parted:
            least = across + 2.0 * self.fill.spread * self.fill.cover
            wide = self.road.breadth > (1.0 + SAME) * least
            self._parted[across] = self.road.lanes(_LANES if wide else 1)
        return self._parted[across]

    @cached_property
    def _parted(self) -> dict[float, Sequence[tuple[Roadway, float]]]:
        return {}

    def depth(self, x: Floats, across: float) -> Floats:
        """(p,) [m], below forces on the road, the mean of those side by side."""
        return np.asarray(self._depths(x, across).mean(axis=0))

    def _depths(self, x: Floats, across: float) -> Floats:
        """(l, p) [m], of each of those side by side."""
        return np.array([road.depth(x + on) for road, on in self._lanes(across)])

    def _reach(self, deep: Floats, contact: Floats | float) -> Floats:
        """(p,) [m], to each side along the road, to which forces spread."""
        return np.maximum(0.5 * contact + self.fill.spread * deep, 1e-6 * self.road.breadth)

    def effective(self, x: Floats, contact: Floats | float, across: float) -> tuple[Floats, Floats]:
        """Widths (p,) [m] on which forces on the road count, and those of the bridge there.

        To the width on which it acts that to which it spreads is added at both sides: no ring
        beside it helps, as in CS 454, where a wheel has a strip of 1.5 m and the depth of fill.
        It is not more than that of a bridge, if that is ``whole``.
        """
        return self._widths(x, self.depth(x, across), contact, across)

    def _widths(
        self, x: Floats, deep: Floats, contact: Floats | float, across: float
    ) -> tuple[Floats, Floats]:
        reach, whole = self._reach(deep, contact), self.bridge.road
        wide = whole.wide(x - reach, x + reach)
        if len(self._lanes(across)) > 1:
            wide = np.full(len(x), whole.breadth)
        if across == 0.0:
            return wide, wide
        spread = across + 2.0 * self.fill.spread * deep
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
        lanes, depths = self._lanes(across), self._depths(x, across)
        deep, contact = depths.mean(axis=0), np.broadcast_to(contact, len(x))
        effective, wide = self._widths(x, deep, contact, across)
        force, reach = force * (wide / effective) / len(lanes), self._reach(deep, contact)
        total = np.zeros((len(x), len(self.road.assembly), 6))
        for (road, on), depth in zip(lanes, depths, strict=True):
            total += self._on(road, force, x + on, contact, reach, depth)
        return total

    def _on(
        self, road: Roadway, force: Floats, x: Floats, contact: Floats, reach: Floats, depth: Floats
    ) -> Floats:
        even = 0.5 * force / (reach * road.wide(x - reach, x + reach))
        part, one = road.carriageway.within(x - reach, x + reach)
        found = even[:, None, None] * part.wrenches_of(
            one, len(x), road.assembly, lambda at: np.tile(DOWN, (len(at.point), 1))
        )
        if self.fill.law == "boussinesq":
            for i in np.flatnonzero(depth > 0.0):
                places = x[i] + np.linspace(-8.0, 8.0, 129) * max(depth[i], 0.5 * contact[i])
                part = road.carriageway.within(places[:1], places[-1:])[0].cut_at(places)
                law = _elastic(road, force[i], places, contact[i], depth[i])
                found[i] = part.wrenches(road.assembly, law)
        return np.asarray(found)


def _elastic(road: Roadway, force: float, places: Floats, contact: float, depth: float) -> Traction:
    """Vertical pressure below an even strip load on an elastic half space, over the width.

    Source: Boussinesq 1885, as integrated over a strip by Terzaghi 1943, section 136.
    """
    half = max(0.5 * contact, 1e-6 * depth)
    wide = road.wide(places[:-1], places[1:])

    def traction(at: Spots) -> Floats:
        along = at.point @ road.strips.axes[0]
        away = along - 0.5 * (places[0] + places[-1])
        near, far = np.arctan((away - half) / depth), np.arctan((away + half) / depth)
        share = (far - near + 0.5 * (np.sin(2.0 * far) - np.sin(2.0 * near))) / np.pi
        line = force / wide[np.searchsorted(places[1:-1], along)]
        return np.column_stack([np.zeros((len(share), 2)), -share * line / (2.0 * half)])

    return traction
