"""What a train that moves over a bridge is answered: the factor at every place, and the worst."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from drystone.answer import Answer, Role, Scene, SceneStage, Sentence
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.answer.drawing import bare_scene
from drystone.answer.scene import Layer, LayerKind
from drystone.base.arrays import SAME, Floats
from drystone.base.display import rounded_down
from drystone.base.errors import InputError, counted
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.limits.crossing import Crossing, PlacedTrain
from drystone.limits.limit_answer import Limit
from drystone.limits.limit_types import LimitOptions
from drystone.loads import Fill, LoadCase, Train
from drystone.model import Model
from drystone.results import Result

_MENDED = "drystone mend with this --train, and the fill as --load, asks each mend of all places"


@dataclass(frozen=True, eq=False)
class TrainEnvelope(Answer):
    """Largest load factors of a train on a bridge, by its place.

    Attributes
    ----------
    places : (p,) [m]
        Of the middle of the train, along the road.
    factors : (p,)
        By equilibrium, with joints that are ductile: NaN where none was found, infinite where
        nothing ends it, minus infinity where no factor is balanced.
    limit
        That of the full verdict at the worst place, under which it stands with the train at all
        others too; ``None`` where fill resists, of which no verdict knows.
    asked_for
        Number of places, without those between.
    stopped
        Why some are missing; else empty.
    """

    places: Floats
    factors: Floats
    limit: Limit | None
    asked_for: int
    _crossing: Crossing
    _placed: tuple[PlacedTrain, ...]
    options: LimitOptions
    _governs: int | None = None
    _undecided: tuple[int, ...] = ()

    @property
    def train(self) -> Train:
        """The train."""
        return self._crossing.train

    @property
    def fill(self) -> Fill:
        """The fill; without weight where there is none."""
        return self._crossing.tops.fill

    def live(self, place: float) -> LoadCase:
        """The train at the known place nearest to one [m], spread through the fill."""
        return self._placed[int(np.argmin(np.abs(self.places - place)))].live

    @property
    def loaded(self) -> Model:
        """The bridge with the train at the worst place."""
        one = self._placed[self.worst]
        place = f"'{self.train.name}' stands at {one.at.words} alone"
        note = f"{place}: what holds that may fall with it elsewhere; {_MENDED}"
        return self.model.with_load(self.model.load + replace(one.live, notes=(note,)))

    @property
    def worst(self) -> int:
        """The place with the least factor, by the verdict where that is known.

        Raises
        ------
        InputError
            No place is known.
        """
        return self._by_equilibrium if self._governs is None else self._governs

    @property
    def _by_equilibrium(self) -> int:
        """The place with the least factor by equilibrium; of equal ones the first."""
        if not len(self.places) or np.isnan(self.factors).all():
            raise InputError("no place is known", remedy="let the search go on")
        least = float(np.nanmin(self.factors))
        room = SAME * abs(least) if np.isfinite(least) else 0.0
        return int(np.flatnonzero(self.factors <= least + room)[0])

    @property
    def falls_alone(self) -> bool:
        """Whether no forces balance the bridge without the train."""
        return bool((self.factors < 0.0).any())

    @property
    def carries(self) -> tuple[str, ...]:
        """What each factor says: ``this factor``, ``any factor``, ``not found``, or ``none``.

        And what the verdict says where it is less, at the worst place, or undecided under the least
        one of all.
        """
        if self.falls_alone:
            return ("none (falls without the train)",) * len(self.places)
        told = {True: "any factor", False: "this factor"}
        told = {known: words + self._ductile for known, words in told.items()}
        each = ["not found" if np.isnan(x) else told[x == np.inf] for x in self.factors]
        known = dict.fromkeys(self._undecided, "a verdict is undecided")
        if self._rest is not None:
            rest, factor = self._rest, float(self.factors[self.worst])
            if rounded_down(rest, 3) < rounded_down(factor, 3):
                known[self.worst] = f"{rounded_down(rest):g} by the verdict"
            if self._ductile and not self.stopped:
                least = f"{rounded_down(rest):g} or more by the verdict"
                known = dict.fromkeys(range(len(each)), least) | known
        for i, words in known.items():
            each[i] += f" by equilibrium; {words}"
        return tuple(each)

    @property
    def model(self) -> Model:
        """The bridge with its fill, without the train."""
        return self._crossing.problem.model

    @cached_property
    def proven(self) -> bool:
        """Whether forces at the least factor, and a mechanism just beyond, were checked."""
        one = self._placed[self._by_equilibrium]
        return self._crossing.result(one) is not None and self._crossing.falls(one)

    @property
    def standing(self) -> Result | None:
        """The forces at the worst place, up to which it stands or forces balance the train."""
        if self.limit is not None:
            return self.limit.best.standing
        return self._crossing.result(self._placed[self.worst]) if len(self.places) else None

    def axles(self, place: int | None = None) -> Table:
        """The axles at a place, by its position: where they are, what they weigh, how they spread.

        Parameters
        ----------
        place
            The worst one when left out.
        """
        one, tops = self._placed[self.worst if place is None else place], self._crossing.tops
        train = one.at.train
        x = one.at.place - 0.5 * train.length + np.array(train.places)
        low, high = tops.road.ends
        depth = tops.depth(x, train.across)
        effective, wide = tops.effective(x, train.contact, train.across)
        columns = {
            "axle": np.arange(1, len(x) + 1),
            "x": x,
            "road": tops.road.level(x),
            "load": np.array(train.loads),
            "fill_below": depth,
            "spread_along": train.contact + 2.0 * self.fill.spread * depth,
            "effective_width": effective,
            "borne": wide / effective,
            "on_the_bridge": (x >= low) & (x <= high),
        }
        units = dict.fromkeys(("x", "road", "fill_below", "spread_along", "effective_width"), "m")
        where = "the worst place" if place is None else one.at.words
        return Table(
            f"axles at {where}, at factor 1", columns, {**units, "load": "N", "borne": "1"}
        )

    @property
    def line(self) -> Floats:
        """Stretches (s, 2) [m] of the road with the line load at the worst place."""
        return self._placed[self.worst].line

    def _axle_layers(self, place: int) -> tuple[Layer, ...]:
        axles, tops = self.axles(place), self._crossing.tops
        flat = np.zeros(len(axles))
        at = tops.road.on_road(axles["x"])
        down = np.column_stack([flat, flat, -axles["load"]])
        ends = tops.road.on_road(np.array(tops.road.ends))
        road = Layer("road", "road", LayerKind.LINES, "load", ends[:1], ends[1:] - ends[:1])
        layers = [road, Layer(
            "axles", "axles",
            LayerKind.ARROWS, "load", at, down, single=True, width=3.0, group="axles",
        )]  # fmt: skip
        stretches = self._placed[place].line.tolist()
        if stretches:
            cuts = [np.linspace(a, b, int(b - a) + 2) for a, b in stretches]
            # arrows a metre apart at most
            at = tops.road.on_road(np.concatenate([0.5 * (one[1:] + one[:-1]) for one in cuts]))
            down = np.tile([0.0, 0.0, -self.train.line], (len(at), 1))
            layers.append(Layer(
                "line", "line load", LayerKind.ARROWS, "load", at, down, unit="N/m", single=True,
                group="axles",
            ))  # fmt: skip
        return tuple(layers)

    @property
    def _most(self) -> float:
        """Four times the least factor; NaN where there is none."""
        known = len(self.places) and not self.falls_alone
        return 4.0 * abs(float(self.factors[self.worst])) if known else np.nan

    @property
    def _near(self) -> Floats:
        """The factors (p,) up to four times the least; NaN for the others."""
        near = np.isfinite(self.factors) & (self.factors <= self._most)
        return np.where(near, self.factors, np.nan)

    @property
    def title(self) -> str:
        """The least factor, and where."""
        train = self.train.name
        if not len(self.places):
            return f"No place of '{train}' is known"
        if self.falls_alone:
            return f"Falls without '{train}'"
        at, factor = self._placed[self.worst].at.words, float(self.factors[self.worst])
        if not factor > 0.0:
            return f"Forces balance no share of '{train}' at {at}"
        known, asked = len(self.places), self.asked_for
        among = f" of {known} of {asked} places" if known < asked else ""
        place = f"least{self._ductile if self._rest is None else ''}{among} at {at}"
        if self._rest is not None and self._rest < 1.0:
            only = "at most" if self._undecided else "only"
            return f"Does not carry '{train}', {only} {rounded_down(self._rest):g} of it, {place}"
        if self._rest is not None and not self._undecided and not self.stopped:
            stands = rounded_down(self._rest)
            return f"Stands under '{train}' up to load factor {stands:g}, {place}"
        if factor < 1.0:
            return f"Forces balance '{train}' up to {rounded_down(factor):g} of it only, {place}"
        told = "any load factor" if np.isinf(factor) else f"load factor {rounded_down(factor):g}"
        return f"Forces balance '{train}' up to {told}, {place}"

    @property
    def _ductile(self) -> str:
        return " with ductile joints" if self.model.contacts.brittle else ""

    @property
    def _rest(self) -> float | None:
        """The factor up to which it stands by the verdict at the worst place, if known."""
        rest = None if self.limit is None else self.limit.rest
        return None if rest is None else rest.stands

    @property
    def carried(self) -> bool:
        """Whether the whole train is, by equilibrium and by the verdict where there is one."""
        good = bool(len(self.places)) and bool(self.factors[self.worst] >= 1.0)
        return good and (self.limit is None or float(self.limit.stands or 0.0) >= 1.0)

    def sentences(self) -> Sequence[Sentence]:
        """The least factor, how it was found, and what it does not say."""
        unsure = self.stopped or self._undecided or np.isnan(self.factors).any()
        role = Role.BAD if not self.carried else Role.UNSURE if unsure else Role.GOOD
        said = [Sentence(self.title, role)]
        x, y, _ = self._crossing.tops.road.strips.axes[0]
        if y != 0.0:
            turn = f"the road is taken along {x:.3g}, {y:.3g} in plan, and x of a place along it"
            said.append(Sentence(turn, Role.REMARK))
        said += [Sentence(self.train.words), Sentence(self.fill.words)]
        said += [Sentence(note, Role.REMARK) for note in self._crossing.tops.notes]
        if self.train.source:
            said.append(Sentence(f"'{self.train.name}' is {self.train.source}", Role.REMARK))
        if not len(self.places):
            return said + self._unfinished()
        known, more = counted(len(self.places), "place"), len(self.places) - self.asked_for
        between = f" ({more} of them where mechanisms of others end it sooner)" if more > 0 else ""
        checked = "forces there and a mechanism beyond are checked" if self.proven else "not proved"
        if self.falls_alone:
            alone = f"no forces balance the bridge alone, as found at {known}; 'check' tells why"
            return [*said, Sentence(alone)]
        said += [self._of_width, self._of_place, *self._of_approaches]
        least = float(self.factors[self._by_equilibrium])
        factor = "any factor" if np.isinf(least) else f"{rounded_down(least):g} and more"
        said.append(
            Sentence(f"by equilibrium{self._ductile} at {known}{between}: {factor}; {checked}")
        )
        lost = self.places[np.isnan(self.factors)]
        if len(lost):
            at = ", ".join(f"{x:.3g}" for x in lost)
            why = f"not found at x = {at} m, where it may be less: ask with other steps"
            said.append(Sentence(why, Role.BAD))
        if self.train.line:
            said.append(self._of_line)
        everywhere = bool(self._rest) and not self.stopped
        if self._ductile:
            why = (
                "mortar is brittle, and places are compared with ductile joints: only the "
                "verdict knows brittle ones, and other places may carry less"
            )
            if everywhere:
                why = (
                    "mortar is brittle, and only the verdict knows that: the others are held "
                    "against the least factor; between them it may be less: more --steps tell"
                )
            said.append(Sentence(why, Role.REMARK))
        if len(self._crossing.resisted):
            why = (
                f"fill resists up to {self.fill.passive:g} times its vertical pressure, which "
                "verdicts count with the tie 'fill' only: none was asked"
            )
            said.append(Sentence(why, Role.REMARK))
        elif self.limit is not None:
            at = self._placed[self.worst].at.words
            why = f"the verdict was searched at {at} alone; by the verdict another may carry less"
            if everywhere:
                why = f"the verdict is least at {at} of {known}: at the others it stands under that"
            if everywhere and self._undecided:
                why = (
                    f"the verdict was searched at {at}; at {len(self._undecided)} of {known} it is "
                    "undecided under that factor, where 'check' tells why"
                )
            said.append(Sentence(why))
            said += self.limit.sentences()[self.limit.stands is not None :]
        if not self.carried:
            said.append(Sentence(f"what would carry the train: {_MENDED}"))
        if self.limit is not None and self.limit.stopped:
            return said  # which says so
        every = counted(max(self.asked_for, len(self.places)), "place")
        return said + self._unfinished(f" after {len(self.places)} of {every}")

    @property
    def _of_width(self) -> Sentence:
        """For what width the answer is, and what of the train that bears."""
        tops, axles = self._crossing.tops, self.axles()
        on = axles["on_the_bridge"]
        shares, effective = axles["borne"][on], axles["effective_width"][on]
        line = ""
        if len(self.line):
            line = f", and {100.0 * self._line_borne:.3g} % of the line load"
        wide = f"the answer is for all of the model, {tops.bridge.road.breadth:.3g} m wide"
        beside = self._beside(effective)
        if (np.abs(shares - 1.0) <= SAME).all():
            return Sentence(f"{wide}: it bears the whole of each axle{line}{beside}", Role.REMARK)
        told = f"{_range(100.0 * shares)} % of an axle at the worst place{line}"
        by = f"by its width over the effective one of {_range(effective)} m, to which axles spread"
        skew = " along the skew" if tops.road.skew else ""
        how = (
            f"as if trains stood side by side{skew}: one counts on no more than its effective "
            "width, and lighter ones beside it, as on lanes 2 and 3, are not added where they "
            "overlap it; for one lane only give the fill 'between', or a train without 'across' "
            "and 'lane'"
        )
        if shares.min() < 1.0:
            how = (
                "as a strip of a wider bridge: if this is the whole width, nothing spreads beyond "
                "it, and a train of your own is to have no 'across' and 'lane'"
            )
        return Sentence(f"{wide}: it bears, {by}, {told}, {how}{beside}", Role.REMARK)

    def _beside(self, effective: Floats) -> str:
        """What lighter lanes add where axles count on their width too, and what a kerb takes."""
        train, told = self.train, ""
        if self._crossing.tops.whole and 0.0 < train.lane < effective.max(initial=0.0):
            told = (
                "; where lanes 2 and 3 are on this width as well, those of EN 1991-2 add 67 and "
                "33 % of the axles and 28 % each of the line load of lane 1: give a train with "
                "the sum, without 'across' and 'lane'"
            )
        if train.across:
            told += (
                "; at a kerb an axle spreads to one side only: give 'across' less by what does "
                "not spread there, 'spread' times the depth"
            )
        return told

    @property
    def _of_place(self) -> Sentence:
        """What a place is, and what is not tried across the bridge."""
        low, high = self._crossing.tops.road.ends
        told = "places are x of the middle of the train; the bridge lies from "
        wide = "; an axle acts evenly over its width: a wheel alone may be worse, and is not tried"
        ends = f"{told}{low:.3g} to {high:.3g} m"
        if len(self.train.ways) > 1:
            given = self._placed[self.worst].at.train == self.train
            ends += f"; of both ways the train is worst {'as given' if given else 'turned round'}"
        return Sentence(ends + (wide if self.train.across else ""), Role.REMARK)

    @property
    def _of_approaches(self) -> Iterator[Sentence]:
        """That a train behind free abutments presses the earth there, and how to add that."""
        (x, y, _), train = self._crossing.tops.road.strips.axes[0], self.train
        axis, name = (1, "y") if abs(y) > abs(x) else (0, "x")
        low, high = self.model.assembly.bounds.swapaxes(0, 1)
        first, last = low.min(axis=0), high.max(axis=0)
        near, half = 0.01 * (last - first)[axis], 0.5 * (last - first)[2]
        free, sides = ~self.model.assembly.fixed, []
        for side, away in ((f"-{name}", low - first), (name, last - high)):
            there = free & (away[:, axis] < near)
            if high[there, 2].max(initial=first[2]) - low[there, 2].min(initial=last[2]) > half:
                sides.append(side)
        if sides:
            pressed = train.line / train.lane if train.line and train.lane else 20e3
            how = f"earth:side={sides[0]},weight=0kN/m3,k=0.3,surcharge={pressed / 1e3:.3g}kPa"
            yield Sentence(
                f"behind free abutments (side {' and '.join(sides)}) the road is not loaded: "
                "traffic there presses them through the earth, and they may carry less; add that "
                f"for one side, not multiplied, such as by --load {how}",
                Role.REMARK,
            )

    @property
    def _line_borne(self) -> float:
        """The share of the line load that bears at the worst place."""
        worst = self._placed[self.worst]
        ends = worst.at.ends[worst.adverse]
        long = np.ptp(ends, axis=1)
        each = self._crossing.tops.borne(ends.mean(axis=1), long, self.train.lane)
        return float(np.average(each, weights=long))

    def by_hand(self) -> Table:
        """The vertical load of the train at the worst place by hand, and that on the blocks."""
        axles, down = self.axles(), -self._placed[self.worst].live.wrench[:, 2]
        each = zip(axles["axle"].tolist(), axles["load"].tolist(), axles["borne"], strict=True)
        rows = [(f"axle {i}", load, share, share * load) for i, load, share in each]
        if len(self.line):
            long, share = float(np.ptp(self.line, axis=1).sum()), self._line_borne
            load, line = self.train.line * long, quantity(self.train.line, "N/m")
            rows.append((f"line load, {line} on {long:.4g} m", load, share, share * load))
        fixed, rest = self.model.assembly.fixed, (np.nan, np.nan)
        borne = sum(row[3] for row in rows)
        rows += [
            ("sum of what the model bears", *rest, borne),
            ("found on free blocks", *rest, float(down[~fixed].sum())),
            ("found on supports and ground", *rest, float(down[fixed].sum())),
        ]
        beyond = borne - float(down.sum())
        if beyond > SAME * borne:
            rows.append(("spread beyond the ends of the bridge, on no block", *rest, beyond))
        names, units = ("of", "load", "borne", "vertical"), ("", "N", "1", "N")
        columns = {name: [row[i] for row in rows] for i, name in enumerate(names)}
        title = "vertical load of the train at the worst place, at factor 1"
        return Table(title, columns, dict(zip(names[1:], units[1:], strict=True)))

    @property
    def _of_line(self) -> Sentence:
        """Where the line load acts."""
        each = " and ".join(f"{a:.3g} to {b:.3g}" for a, b in self.line.tolist())
        where = f"it acts at x = {each} m" if each else "it is adverse nowhere"
        return Sentence(f"line load at the worst place: {where}")

    def tables(self) -> Sequence[Table]:
        """The factors by place."""
        columns = {"place": self.places, "load_factor": self.factors, "carries": list(self.carries)}
        return [Table(f"load factor by place{self._ductile}", columns, {"place": "m"},
                     {"load_factor": False})]  # fmt: skip

    def numbers(self) -> Mapping[str, Any]:
        """Places, factors, the worst one, the train and the fill."""
        return {
            "train": self.train,
            "fill": self.fill,
            "places": self.places,
            "factors": self.factors,
            "carries": self.carries,
            "worst": float(self.places[self.worst]) if len(self.places) else None,
            "line": self.line if len(self.places) else (),
            "proven": bool(len(self.places)) and self.proven,
            "limit": None if self.limit is None else self.limit.numbers(),
        }

    def layers(self) -> Scene:
        """The worst place, then the others, each with its forces and its mechanism.

        Those where much more is carried are left out: beside them the worst has no visible forces.
        """
        scene = bare_scene(self.model)
        if not len(self.places) or self.falls_alone:
            return replace(scene, title=self.title)
        worst, axles = [], self._axle_layers(self.worst)
        found = () if self.limit is None else self.limit.layers().stages
        for one in found:  # with the words of this answer
            told = self.title + one.headline.removeprefix(self.limit.title if self.limit else "")
            role = one.role if self.carried else Role.BAD
            layers = (*one.layers, *axles)
            worst.append(replace(one, headline=told, role=role, layers=layers))
        stages = worst or self._stage(self.worst)
        still = max(len(found) - 1, 0)
        for i in np.flatnonzero(np.isfinite(self._near)).tolist():
            stages += self._stage(i)
        charts = (self.figure(),)
        every = tuple(stages) or scene.stages  # no factor is finite where any is carried
        return replace(scene, title=self.title, stages=every, charts=charts, still=still)

    def _stage(self, i: int) -> list[SceneStage]:
        one = self._placed[i]
        result = self._crossing.result(one)
        if result is None:
            return []
        stage = result.stage(one.at.words)
        way = "" if one.at.train == self.train else ", turned round"
        headline = f"Load factor {rounded_down(one.found.factor):.4g} at {one.at.words}{way}"
        layers = (*stage.layers, *self._axle_layers(i))
        spot = one.at.place, one.found.factor
        return [replace(stage, headline=headline, layers=layers, spot=spot)]

    def figure(self) -> Chart:
        """The factor by the place of the train; what is much higher at the upper edge."""
        told = self.title if self.falls_alone else ""
        factor = np.minimum(self.factors, self._most)
        known, high = np.isfinite(factor), self.factors > self._most
        ends = np.flatnonzero(np.diff(known)) + 1  # pages draw no gaps in lines
        runs = [run for run in np.split(np.arange(len(known)), ends) if known[run].any()]
        marks = [
            Marks(MarkKind.LINE, self.places[run], factor[run], "accent",
                  "forces balance it" if i == 0 else "")
            for i, run in enumerate(runs)
        ]  # fmt: skip
        if runs:
            at = self.worst
            spot = self.places[at : at + 1], factor[at : at + 1]
            marks.append(Marks(MarkKind.DIAMOND, *spot, "bad", "the worst place"))
            if spot[1][0] < 4.0:
                whole = self.places[[0, -1]]
                marks.append(Marks(MarkKind.LINE, whole, np.ones(2), "bad", "the train: 1"))
            told = f"least at {self._placed[at].at.words}: {rounded_down(spot[1][0]):g}"
            if self.limit is not None and self.limit.stands is not None:
                told += f" by equilibrium, {rounded_down(self.limit.stands):g} by the verdict"
            if high.any():
                beyond = self.places[high], factor[high]
                marks.append(Marks(MarkKind.RING, *beyond, label=f"above {self._most:.3g}"))
            told += "" if known.all() else "; where none is drawn it was not found"
        name = self.train.name
        return Chart(
            f"Largest load factor of '{name}' by its place{self._ductile}", tuple(marks),
            "middle of the train", "load factor", ("m", ""), told,
        )  # fmt: skip


def _range(values: Floats) -> str:
    """The least and the largest, or the one."""
    low, high = (f"{each:.3g}" for each in (values.min(), values.max()))
    return high if low == high else f"{low} to {high}"
