"""Random imperfections of joints, and the share of the structures that stand with them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Unpack

import numpy as np
from scipy import stats

from drystone.base.arrays import Floats, frozen_floats, number, of_type, whole
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.progress import Progress
from drystone.base.settings import Options, checked_call
from drystone.contacts import Contacts
from drystone.geometry.frames import rotation_about
from drystone.geometry.plane.polygon import following
from drystone.io.opening import Given, How, as_model
from drystone.limits.search import STANDS, Check, verdict
from drystone.model import Model
from drystone.results import Verdict
from drystone.stability.problem import Clock


@dataclass(frozen=True)
class Imperfections(Options):
    """Random deviations; independent for every joint.

    Attributes
    ----------
    friction
        Lowest and highest coefficient, uniform between them; ``None``: not changed.
    corner_loss
        Probability that a corner of a joint is broken off.
    loss_reach
        Length of a broken corner along its two edges, as a share of them; at most one half.
    offset
        Standard deviation of the shift of a joint in its plane, relative to the root of its area.
    tilt_deg : [degrees]
        Standard deviation of the rotation of a joint about each of two axes in its plane.
    """

    friction: tuple[float, float] | None = None
    corner_loss: float = 0.0
    loss_reach: float = 0.25
    offset: float = 0.0
    tilt_deg: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.friction is not None:
            low, high = frozen_floats(self.friction, (2,), "friction")
            if not 0.0 <= low <= high < float("inf"):
                raise InputError(
                    f"friction from {low} to {high}", remedy="give the lower one first, from zero"
                )
        for name, top in (("corner_loss", 1.0), ("loss_reach", 0.5)):
            if not 0.0 <= getattr(self, name) <= top:
                raise InputError(f"{name} is {getattr(self, name)}", remedy=f"give 0 to {top:g}")
        for name in ("offset", "tilt_deg"):
            if not 0.0 <= getattr(self, name) < float("inf"):
                raise InputError(f"{name} is {getattr(self, name)}", remedy="give zero or more")


@dataclass(frozen=True, eq=False)
class StandingShare(OneLine):
    """The share of imperfect structures that stand.

    Attributes
    ----------
    verdicts
        Verdict on every draw, in order.
    share
        Share of draws that stand.
    interval
        Interval of the true share, at the confidence level.
    confidence
    """

    verdicts: tuple[Verdict, ...]
    share: float
    interval: tuple[float, float]
    confidence: float

    def _summary(self) -> str:
        share, low, high = (f"{100.0 * x:.3g}" for x in (self.share, *self.interval))
        return f"{counted(len(self.verdicts), 'draw')}, {share} % stand, {low} to {high} %"

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "draws": len(self.verdicts),
            "standing": sum(STANDS[v] is True for v in self.verdicts),
            "undecided": sum(v is Verdict.UNDECIDED for v in self.verdicts),
            "share": self.share,
            "interval": list(self.interval),
            "confidence": self.confidence,
        }


@checked_call
def imperfections(
    given: Given,
    kinds: Imperfections,
    *,
    draws: int = 100,
    seed: int = 0,
    confidence: float = 0.95,
    check: Check = verdict,
    executor: Executor | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> StandingShare:
    """Draw imperfect joints and count the structures that stand.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    kinds
        Kinds and sizes of imperfections.
    draws, seed
        The same seed gives the same draws, with any executor.
    confidence
        Confidence level of the interval (Clopper and Pearson 1934, exact for any number of draws).
    check
        A function that gives the verdict on a model. An undecided draw does not count as standing.
    executor
        Computes the draws in parallel.
    progress
    stop
        Called after every draw; True ends the work with the draws made so far.
    time_limit_s
        Time after which the work ends with the draws made so far, at least one.
    """
    of_type(kinds, Imperfections, "the value of imperfections")
    if whole(draws, "the number of draws") < 1:
        raise InputError(f"{draws} draws", remedy="give one or more")
    whole(seed, "the seed", least=0)
    if not 0.0 < number(confidence, "confidence") < 1.0:
        raise InputError(f"confidence is {confidence}", remedy="give a share between 0 and 1")
    task = partial(_draw, as_model(given, **how), kinds, check)
    seeds = np.random.SeedSequence(seed).spawn(draws)
    answers: Iterable[Verdict] = map(task, seeds) if executor is None else executor.map(task, seeds)
    clock = Clock(time_limit_s, stop)
    verdicts: list[Verdict] = []
    for answer in answers:
        verdicts.append(answer)
        if progress is not None:
            progress("draws", len(verdicts), draws)
        if clock.late():
            break
    made = len(verdicts)
    standing = sum(STANDS[verdict] is True for verdict in verdicts)
    interval = stats.binomtest(standing, made).proportion_ci(confidence, method="exact")
    return StandingShare(
        tuple(verdicts), standing / made, (float(interval.low), float(interval.high)), confidence
    )


def _draw(
    model: Model,
    imperfections: Imperfections,
    check: Check,
    seed: np.random.SeedSequence,
) -> Verdict:
    drawn = imperfect(model.contacts, imperfections, seed)
    return check(model.with_contacts(drawn)).verdict


def imperfect(
    contacts: Contacts, imperfections: Imperfections, seed: int | np.random.SeedSequence
) -> Contacts:
    """One draw of imperfect joints."""
    rng = np.random.default_rng(seed)
    m = contacts.count
    friction = contacts.friction
    if imperfections.friction is not None:
        friction = rng.uniform(*imperfections.friction, m)
    lost = rng.random(contacts.corner_count) < imperfections.corner_loss
    point, interface = _chipped(contacts, lost, imperfections.loss_reach)
    size = np.sqrt(contacts.area)
    slide = imperfections.offset * size[:, None] * rng.standard_normal((m, 2))
    point = point + np.einsum("mi,mij->mj", slide, contacts.frame[:, 1:])[interface]
    frame = contacts.frame
    turn = imperfections.tilt_deg * rng.standard_normal((m, 2))
    if imperfections.tilt_deg > 0.0:
        axis = np.einsum("mi,mij->mj", turn, frame[:, 1:])
        angle = np.linalg.norm(turn, axis=1)
        turns = np.array([rotation_about(a, t) for a, t in zip(axis, angle, strict=True)])
        frame = frame @ np.swapaxes(turns, 1, 2)
        arm = point - contacts.centroid[interface]
        point = contacts.centroid[interface] + np.einsum("kij,kj->ki", turns[interface], arm)
    changed = replace(contacts, frame=frame, friction=friction, point=point, interface=interface)
    return replace(changed, area=np.where(contacts.area > 0.0, _areas(changed), 0.0))


def _areas(contacts: Contacts) -> Floats:
    total = np.zeros(contacts.count)
    np.add.at(total, contacts.interface, contacts.tributary)
    return total


def _chipped(contacts: Contacts, lost: np.ndarray, reach: float) -> tuple[Floats, np.ndarray]:
    """Corners with some of them cut off: each is replaced by two corners on its edges."""
    after = following(contacts.start)
    before = np.empty_like(after)
    before[after] = np.arange(len(after))
    here = contacts.point
    polygonal = np.diff(contacts.start)[contacts.interface] > 2
    cut = lost & polygonal
    pieces = np.where(cut, 2, 1)
    point = np.repeat(here, pieces, axis=0)
    first = np.cumsum(pieces) - pieces
    point[first[cut]] = here[cut] + reach * (here[before[cut]] - here[cut])
    point[first[cut] + 1] = here[cut] + reach * (here[after[cut]] - here[cut])
    return point, np.repeat(contacts.interface, pieces)


__all__ = ["Imperfections", "StandingShare", "imperfect", "imperfections"]
