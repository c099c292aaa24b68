"""Random imperfections of joints, and the share of the structures that stand with them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Unpack

import numpy as np

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.answer.drawing import bare_scene
from drystone.base.arrays import Floats, frozen, frozen_floats
from drystone.base.errors import InputError, counted
from drystone.base.ragged import Ragged
from drystone.base.settings import Clock, Options, checked_call, member_of
from drystone.base.table import Table
from drystone.base.workers import WorkerPool
from drystone.contacts import Contacts
from drystone.geometry.frames import rotations
from drystone.io.opening import Given, LongHow, as_model
from drystone.limits.limit_types import STANDS, Check, verdict
from drystone.model import Model
from drystone.results import Verdict
from drystone.settlement import Loading, Outcome, SettlementOptions, settle

_FOLLOWED: Mapping[Outcome, Verdict] = {
    Outcome.RESTS: Verdict.STABLE,
    Outcome.DISPLACED: Verdict.UNSTABLE,
    Outcome.FALLS: Verdict.UNSTABLE,
}
"""What following the blocks by steps says; everything else is undecided."""


@dataclass(frozen=True)
class Imperfections(Options):
    """Random deviations; independent for every joint.

    Attributes
    ----------
    friction_range
        Lowest and highest coefficient, uniform between them; not changed when left out.
    corner_loss : >= 0, <= 1
        Probability that a corner of a joint is broken off.
    loss_reach : >= 0, <= 0.5
        Length of a broken corner along its two edges, as a share of them; at most one half.
    offset : >= 0, <= 1e30
        Standard deviation of the shift of a joint in its plane, relative to the root of its area.
    turn : [degrees] >= 0, <= 1e30
        Standard deviation of the rotation of a joint about each of two axes in its plane.
    tolerance : [m] >= 0, <= 1e30
        Standard deviation of the place of the rim of a joint, from how exactly blocks are made:
        every joint is shifted by it in each direction of its plane, and turned about each of two
        axes in its plane by it over half the root of its area. Added to ``offset`` and ``turn``
        as independent of them.
    """

    friction_range: tuple[float, float] | None = None
    corner_loss: float = 0.0
    loss_reach: float = 0.25
    offset: float = 0.0
    turn: float = 0.0
    tolerance: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.friction_range is not None:
            low, high = frozen_floats(self.friction_range, (2,), "friction_range")
            if not 0.0 <= low <= high < float("inf"):
                raise InputError(
                    f"friction from {low} to {high}", remedy="give the lower one first, from zero"
                )


@dataclass(frozen=True, eq=False)
class StandingShare(Answer):
    """The share of imperfect structures that stand.

    Attributes
    ----------
    verdicts
        Verdict on every draw, in order; with several orders of loading one for each, draw by draw.
    share
        Share of draws that stand, with several orders of loading in each of them.
    interval
        Interval of the true share, at the confidence level.
    confidence
    loading
        Orders of loading that every draw was followed with; empty where it was checked.
    friction : (d,)
        Mean friction coefficient of every draw.
    model
        Without imperfections.
    options
        The imperfections.
    """

    verdicts: tuple[Verdict, ...]
    share: float
    interval: tuple[float, float]
    confidence: float
    loading: tuple[Loading, ...] = ()
    friction: Floats = field(default_factory=lambda: np.zeros(0))
    model: Model = field(kw_only=True)
    options: Imperfections = field(kw_only=True)

    @property
    def draws(self) -> int:
        """Number of draws."""
        return len(self.verdicts) // max(len(self.loading), 1)

    @property
    def by_draw(self) -> tuple[bool | None, ...]:
        """Whether every draw stands, in every order; None where that is undecided."""
        count = max(len(self.loading), 1)
        told = [STANDS[one] for one in self.verdicts]
        draws = [told[at : at + count] for at in range(0, len(told), count)]
        return tuple(False if False in some else (None if None in some else True) for some in draws)

    def _names(self) -> list[str]:
        return [one.value for one in self.loading] or ["check"]

    def table(self) -> Table:
        """Every draw: its number, mean friction, order of loading and verdict."""
        names = self._names()
        number = np.arange(len(self.verdicts)) // len(names)
        columns = {
            "draw": number,
            "friction": self.friction[number],
            "loading": [names[i % len(names)] for i in range(len(self.verdicts))],
            "verdict": [one.value for one in self.verdicts],
            "stands": [STANDS[one] is True for one in self.verdicts],
        }
        return Table("imperfect structures", columns)

    def by_loading(self) -> Table:
        """Per order of loading the share that stands and its interval."""
        names = self._names()
        rows = []
        for i, name in enumerate(names):
            mine = self.verdicts[i :: len(names)]
            standing = sum(STANDS[one] is True for one in mine)
            undecided = sum(one is Verdict.UNDECIDED for one in mine)
            low, high = share_interval(standing, len(mine), self.confidence)
            share = standing / len(mine) if mine else float("nan")
            rows.append((name, len(mine), standing, undecided, share, low, high))
        titles = ("loading", "draws", "standing", "undecided", "share", "low", "high")
        columns = dict(zip(titles, zip(*rows, strict=True), strict=True))
        units = dict.fromkeys(("share", "low", "high"), "1")
        return Table("by loading", {key: list(each) for key, each in columns.items()}, units)

    @property
    def title(self) -> str:
        """How many stand."""
        where = " in every order of loading" if len(self.loading) > 1 else ""
        count = self.by_draw.count(True)
        return f"{count} of {self.draws} imperfect structures stand{where}"

    def sentences(self) -> Sequence[Sentence]:
        """How many stand, and the interval of the share."""
        low, high = self.interval
        level = f"at {self.confidence:.0%} confidence"
        said = [
            Sentence(self.title, Role.GOOD if self.share == 1.0 else Role.BAD),
            Sentence(f"share {self.share:.1%}, between {low:.1%} and {high:.1%} {level}"),
        ]
        if unsure := self.by_draw.count(None):
            said.append(Sentence(f"{counted(unsure, 'draw')} undecided", Role.REMARK))
        return said + self._unfinished()

    def tables(self) -> Sequence[Table]:
        """The share by the order of loading."""
        return [self.by_loading()]

    def numbers(self) -> Mapping[str, Any]:
        """The share, its interval, and every draw."""
        return {
            "draws": self.draws,
            "standing": self.by_draw.count(True),
            "undecided": self.by_draw.count(None),
            "share": self.share,
            "interval": self.interval,
            "confidence": self.confidence,
            "verdicts": list(self.table()),
        }

    def layers(self) -> Scene:
        """The model without imperfections."""
        scene = bare_scene(self.model)
        return replace(scene, title=f"drystone: {self.title}", charts=(self.figure(),))

    def figure(self) -> Chart:
        """The share that stands against the number of draws, with its interval."""
        table, marks = self.table(), []
        for row, ink in zip(self.by_loading(), ("accent", "bad", "good"), strict=False):
            stands = np.cumsum(table["stands"][table["loading"] == row["loading"]])
            count = np.arange(1.0, len(stands) + 1.0)
            each = [(k, n) for n, k in enumerate(stands.tolist(), 1)]
            bounds = [share_interval(k, n, self.confidence) for k, n in each]
            low, high = np.array(bounds).reshape(-1, 2).T
            label = f"{row['loading']}: {row['share']:.1%} ({row['low']:.1%} to {row['high']:.1%})"
            marks += [
                Marks(MarkKind.AREA, count, high, ink, low=low),
                Marks(MarkKind.LINE, count, stands / count, ink, label),
            ]
        up = f"share that stands, interval at {self.confidence:.0%} confidence"
        return Chart("Share that stands", tuple(marks), "draws", up, top=1.0)


def share_interval(standing: int, made: int, confidence: float) -> tuple[float, float]:
    """Of a share, after Clopper and Pearson 1934: exact for any number of draws."""
    from scipy.special import betaincinv  # slow to import

    if made == 0:
        return 0.0, 1.0
    fallen, beyond = made - standing, 0.5 * (1.0 - confidence)
    low = betaincinv(standing, fallen + 1.0, beyond) if standing else 0.0
    high = betaincinv(standing + 1.0, fallen, 1.0 - beyond) if fallen else 1.0
    return float(low), float(high)


@checked_call
def imperfections(
    given: Given,
    kinds: Imperfections | None = None,
    *,
    draws: int = 100,
    seed: int = 0,
    confidence: float = 0.95,
    check: Check = verdict,
    loading: Loading | str | Sequence[Loading | str] = (),
    **how: Unpack[LongHow],
) -> StandingShare:
    """Draw imperfect joints and count the structures that stand.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    kinds
        Kinds and sizes of imperfections.
    draws : >= 1
        Number of random structures.
    seed : >= 0
        The same seed gives the same draws, with any executor.
    confidence : > 0, < 1
        Confidence level of the interval (Clopper and Pearson 1934, exact for any number of draws).
    check
        Any function that answers whether an assembly stands. An undecided draw does not count as
        standing.
    loading
        Orders in which the load is put on: ``at once``, ``ramp``, ``turned`` from upright. Each
        draw is then followed by steps in each of these orders, instead of ``check``. It stands
        where it comes to rest near its first position (:func:`drystone.settle`). Draws of a model
        of up to 8 free blocks are followed 16 at once.
    """
    if kinds is None:
        raise InputError(
            "nothing is imperfect", remedy="give Imperfections(tolerance=0.002) or others"
        )
    orders = _orders(loading)
    clock = Clock.of(how)
    model = as_model(given, **how)
    task = partial(_draws, model, kinds, check, orders)
    seeds = np.random.SeedSequence(seed).spawn(draws)
    verdicts: list[Verdict] = []
    friction: list[float] = []
    with WorkerPool(clock.workers) as pool:
        late = lambda: bool(verdicts) and clock.late()  # noqa: E731
        for answers, mean in pool.answers(task, seeds, late):
            verdicts += answers
            friction.append(mean)
            clock.tell("draws", len(friction), draws)
    made, empty = len(friction), (0.0, 1.0)
    stopped = f"{clock.reason} after {made} of {draws} draws" if made < draws else ""
    found = StandingShare(
        tuple(verdicts), 0.0, empty, confidence, orders, frozen(np.array(friction)),
        stopped=stopped, model=model, options=kinds,
    )  # fmt: skip
    standing = found.by_draw.count(True)
    # the verdicts on one draw depend on each other: it counts once
    interval = share_interval(standing, found.draws, confidence)
    return replace(found, share=standing / found.draws, interval=interval)


def _orders(loading: Loading | str | Sequence[Loading | str]) -> tuple[Loading, ...]:
    """Orders of loading by their names, each once."""
    given = (loading,) if isinstance(loading, str | Loading) else tuple(loading)
    orders = tuple(member_of(Loading, one, "loading") for one in given)
    if len(set(orders)) < len(orders):
        raise InputError("an order of loading is named twice", remedy="name each once")
    return orders


def _draws(
    model: Model,
    imperfections: Imperfections,
    check: Check,
    orders: tuple[Loading, ...],
    seed: np.random.SeedSequence,
) -> tuple[list[Verdict], float]:
    """The verdicts on one draw, in every order of loading, and its mean friction."""
    drawn = imperfect(model.contacts, imperfections, seed)
    made, friction = model.with_contacts(drawn), float(drawn.friction.mean()) if len(drawn) else 0.0
    if not orders:
        return [check(made).verdict], friction
    ended = [settle(made, options=SettlementOptions(loading=order)).outcome for order in orders]
    return [_FOLLOWED.get(one, Verdict.UNDECIDED) for one in ended], friction


def imperfect(
    contacts: Contacts, imperfections: Imperfections, seed: int | np.random.SeedSequence
) -> Contacts:
    """One draw of imperfect joints.

    Parameters
    ----------
    contacts
        Joints as they are drawn.
    imperfections
        How far joints may be from the drawing.
    seed
        Of the random numbers: the same seed gives the same draw.
    """
    rng = np.random.default_rng(seed)
    m = contacts.count
    friction = contacts.friction
    if imperfections.friction_range is not None:
        friction = rng.uniform(*imperfections.friction_range, m)
    lost = rng.random(contacts.corner_count) < imperfections.corner_loss
    point, interface = _chipped(contacts, lost, imperfections.loss_reach)
    size = np.sqrt(contacts.area)
    slide = imperfections.offset * size[:, None] * rng.standard_normal((m, 2))
    point = point + np.einsum("mi,mij->mj", slide, contacts.frame[:, 1:])[interface]
    frame = contacts.frame
    turn = imperfections.turn * rng.standard_normal((m, 2))
    if imperfections.tolerance > 0.0:
        moved = imperfections.tolerance * rng.standard_normal((2, m, 2))
        point = point + np.einsum("mi,mij->mj", moved[0], contacts.frame[:, 1:])[interface]
        half = np.where(size > 0.0, 0.5 * size, np.inf)
        turn = turn + np.rad2deg(np.arctan(moved[1] / half[:, None]))
    if imperfections.turn > 0.0 or imperfections.tolerance > 0.0:
        axis = np.einsum("mi,mij->mj", turn, frame[:, 1:])
        turns = rotations(np.deg2rad(axis))
        frame = frame @ np.swapaxes(turns, 1, 2)
        arm = point - contacts.centroid[interface]
        point = contacts.centroid[interface] + np.einsum("kij,kj->ki", turns[interface], arm)
    changed = replace(contacts, frame=frame, friction=friction, point=point, interface=interface)
    area = np.where(contacts.area > 0.0, changed.corners.sum(changed.tributary), 0.0)
    return replace(changed, area=contacts.area).with_areas(area)


def _chipped(contacts: Contacts, lost: np.ndarray, reach: float) -> tuple[Floats, np.ndarray]:
    """Corners with some of them cut off: each is replaced by two corners on its edges."""
    after = Ragged(contacts.start).following
    before = np.argsort(after)
    here = contacts.point
    polygonal = np.diff(contacts.start)[contacts.interface] > 2
    cut = lost & polygonal
    pieces = np.where(cut, 2, 1)
    point = np.repeat(here, pieces, axis=0)
    first = np.cumsum(pieces) - pieces
    point[first[cut]] = here[cut] + reach * (here[before[cut]] - here[cut])
    point[first[cut] + 1] = here[cut] + reach * (here[after[cut]] - here[cut])
    return point, np.repeat(contacts.interface, pieces)
