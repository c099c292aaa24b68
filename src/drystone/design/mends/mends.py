"""Mends: changes that make a structure stand, each one checked, ranked by their cost."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Unpack

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine, shortened
from drystone.base.errors import InputError, counted
from drystone.base.progress import Clock, Progress, Stop, Stopped, Workers
from drystone.base.settings import Options, checked_call
from drystone.base.workers import WorkerPool
from drystone.design.causes.diagnosed import Diagnosis, Region
from drystone.design.causes.diagnosis import diagnose
from drystone.design.causes.prop_forces import QUICK
from drystone.design.mends.bench import Bench, MendCandidate, Tried, volume_changed
from drystone.design.mends.margin import DesignMargin
from drystone.design.mends.mend_kinds import KINDS, MAKERS
from drystone.io.opening import Given, How, as_model
from drystone.model import Model
from drystone.results import Result
from drystone.stability import check
from drystone.supports import select

JOINT, ADDED, VOLUME, FRICTION = 1.0, 2.0, 10.0, 5.0
"""Costs: of a changed joint, of an added part, of a change of the whole volume of a region, and of
an increase of a friction coefficient by 1. Chosen: to change a joint costs less than an additional
part, and a tenth of the volume costs as much as a joint."""

SETTLED = 2.0
"""Cost of standing only after settling, where standing for all contact stiffnesses is asked for and
no value gives it. As much as an additional part: a mend that does is preferred."""


@dataclass(frozen=True)
class MendOptions(Options):
    """Options of :func:`find_mends` and of :func:`drystone.design.mend`.

    Attributes
    ----------
    margin
        The safety margin of the mended structure.
    kinds
        Kinds of mends to try, of support, prop, tie, friction, turn, wedge, let-in, thicker,
        ballast, glue and merge; all when left out.
    keep
        Positions of blocks that may not be changed, and texts that name them, read like supports:
        names and patterns, separated by commas; see ``drystone.supports.select``. Their joints
        are not changed either; what is added may touch them.
    """

    margin: DesignMargin = field(default_factory=DesignMargin)
    kinds: tuple[str, ...] = KINDS
    keep: tuple[int | str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        kinds = _several(self.kinds, str, "kinds")
        keep = _several(self.keep, int | str, "keep")
        for kind in kinds:
            if kind not in KINDS:
                raise InputError(
                    f"there is no kind of mend '{kind}'", remedy=f"choose from {', '.join(KINDS)}"
                )
        if not kinds:
            raise InputError("no kind of mend is allowed", remedy="leave kinds out for all")
        object.__setattr__(self, "kinds", kinds)
        object.__setattr__(self, "keep", keep)


def _several(given: Any, kind: Any, name: str) -> tuple[Any, ...]:
    """One value or several of a kind, as a tuple."""
    if isinstance(given, kind) and not isinstance(given, bool):
        return (given,)
    remedy = "give names" if kind is str else "give names or positions of blocks"
    if not isinstance(given, list | tuple):
        raise InputError(f"{name} is {shortened(repr(given), 60)}", remedy=remedy)
    for one in given:
        if not isinstance(one, kind) or isinstance(one, bool):
            raise InputError(f"{name} has {shortened(repr(one), 60)}", remedy=remedy)
    return tuple(given)


@dataclass(frozen=True, eq=False)
class Mend(OneLine):
    """A change with which a region stands, checked on the whole structure.

    Attributes
    ----------
    kind
        One of those of :class:`MendOptions`.
    blocks
        Names of the blocks of the region.
    description
    value
        The least value, in degrees, as a coefficient, as a share or in newtons; see the
        description.
    joints
        Number of joints that are touched.
    added
        Number of blocks, props, ties or weights that are added, and of joints that are glued.
    volume : [m3]
        Sum of the changes of volume of all blocks.
    cost
        ``joints + 2 added + 10 volume / volume of the region + 5 friction that is added``.
    before, model
        The structure without the change, and with it.
    result
        The full check of it.
    held
        Names of blocks of other regions that were held during the search.
    """

    kind: str
    blocks: tuple[str, ...]
    description: str
    value: float
    joints: int
    added: int
    volume: float
    cost: float
    before: Model
    model: Model
    result: Result
    held: tuple[str, ...] = ()

    def _summary(self) -> str:
        return f"'{self.description}', cost {self.cost:.3g}, {self.result.verdict.value}"

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "kind": self.kind,
            "blocks": list(self.blocks),
            "description": self.description,
            "value": self.value,
            "cost": self.cost,
            "joints": self.joints,
            "added": self.added,
            "volume": self.volume,
            "verdict": self.result.verdict.value,
            "message": self.result.message,
            "held": list(self.held),
        }


@dataclass(frozen=True, eq=False)
class Mends(OneLine):
    """The mends of every region of a structure.

    Attributes
    ----------
    diagnosis
        Of the structure, or of the first case of the margin in which it falls.
    mends
        Per region, in order of cost; of equal cost and kind the smallest value first.
    tried
        Kinds that do not hold a region, by the names of its blocks.
    message
        Why there is nothing to mend; empty otherwise.
    """

    diagnosis: Diagnosis
    mends: tuple[Mend, ...]
    tried: tuple[tuple[tuple[str, ...], Tried], ...] = ()
    message: str = ""

    def _summary(self) -> str:
        return self.message or f"{counted(len(self.mends), 'mend')}"

    def of(self, blocks: Sequence[str]) -> tuple[Mend, ...]:
        """The mends of the region with these blocks."""
        return tuple(mend for mend in self.mends if set(mend.blocks) == set(blocks))

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "mends": [mend.to_dict() for mend in self.mends],
            "tried": [
                {"blocks": list(blocks), "kind": one.kind, "what": one.what}
                for blocks, one in self.tried
            ],
            "mending": self.message,
        }


@checked_call
def find_mends(
    given: Given,
    *,
    options: MendOptions | None = None,
    regions: int | None = None,
    besides: Collection[frozenset[str]] = (),
    found_one: Callable[[Mend], None] | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Mends:
    """Search for changes that make a structure stand.

    For every region each kind of change is tried on its local model, with a search for the least
    value with which it stands. The change is then made on the whole structure, which is checked.
    Other falling regions are held during the search.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    options
    regions
        Number of regions to mend, the heaviest first; all when left out. Regions that nothing holds
        do not count.
    besides
        Regions that are not examined, by the names of their blocks.
    found_one
        Called with each change that holds the whole structure, once all of its kind were checked.

    Raises
    ------
    InputError
        What was given cannot be made into a model, or a block to keep does not exist.
    """
    chosen = MendOptions.of(options)
    clock = Clock(time_limit_s, stop)
    model = as_model(given, **how)
    keep = kept_blocks(model, chosen.keep)
    first = chosen.margin.holds(model, clock.late)
    if chosen.margin.meets(first):
        return Mends(diagnose(first.model, result=first), (), message=stands_already(chosen.margin))
    # what stands for some stiffnesses only is mended as it falls with the uniform one
    falls = check(first.model, options=QUICK, stop=clock.late) if first.stable else first
    found = diagnose(
        first.model, result=falls, executor=executor, progress=progress, stop=clock.late
    )
    if not found.regions:
        told = found.sentences[0]
        if first.stable:
            told = f"{first.message}: no mend makes it stand for all; 'sensitive' accepts it"
        return Mends(found, (), message=told)
    mends: list[Mend] = []
    tried: list[tuple[tuple[str, ...], Tried]] = []
    mended = 0
    others = set(found.others).union(*(region.blocks for region in found.regions))
    others |= _falls_besides(found.model, others, clock.late)
    with WorkerPool(executor) as pool:
        for number, region in enumerate(found.regions):
            names = tuple(model.assembly.names[i] for i in region.blocks)
            if mended == regions or frozenset(names) in besides:
                continue
            held = sorted(others - set(region.blocks))
            own: list[Mend] = []
            task = partial(_of_kind, model, found.motion, region, chosen.margin, keep, held, clock)
            stage = f"mends of region {number + 1}"
            if progress is not None:
                progress(stage, 0, len(chosen.kinds))
            several = pool.answers(task, chosen.kinds, clock.late)
            for done, (made, failed) in enumerate(several, start=1):
                own += made
                tried += [(names, one) for one in failed]
                if found_one is not None:
                    for one in made:
                        found_one(one)
                if progress is not None:
                    progress(stage, done, len(chosen.kinds))
            mended += bool(own)
            mends += sorted(own, key=_rank)
    return Mends(found, tuple(mends), tuple(tried))


def _falls_besides(model: Model, falling: set[int], stop: Stop) -> set[int]:
    """The blocks that fall even where those that fall now are held.

    Where no forces balance the loads, only the blocks without balancing forces are known to fall.
    """
    names, fixed = model.assembly.names, set(np.flatnonzero(model.assembly.fixed).tolist())
    more: set[int] = set()
    while len(fixed | falling | more) < len(model):
        held = model.with_supports([names[i] for i in sorted(fixed | falling | more)])
        new = set(check(held, options=QUICK, stop=stop).falling) - falling - more
        if not new:
            break
        more |= new
    return more


def _rank(one: Mend) -> tuple[float, int, float]:
    """Cost, then kind, then size; costs that differ by rounding are equal."""
    return round(one.cost, 9), KINDS.index(one.kind), one.value


def kept_blocks(model: Model, keep: int | str | Sequence[int | str]) -> frozenset[int]:
    """Positions of the blocks to keep: of names, patterns and positions.

    Raises
    ------
    InputError
        There is no such block.
    """
    found: set[int] = set()
    for one in (keep,) if isinstance(keep, int | str) else keep:
        if isinstance(one, str):
            try:
                fixed = select(model.assembly, one, joints=model.joints).fixed
            except InputError as error:
                raise error.located("keep") from None
            found.update(np.flatnonzero(fixed).tolist())
        else:
            found.update(model.assembly.indices([one]).tolist())
    return frozenset(found)


def stands_already(margin: DesignMargin) -> str:
    """What is said of a structure that needs no change."""
    if margin == DesignMargin():
        return "it stands already: ask for a margin to make it stand more firmly"
    return "it stands already, at the margin that is asked for"


def _of_kind(
    model: Model,
    motion: Floats,
    region: Region,
    margin: DesignMargin,
    keep: frozenset[int],
    held: list[int],
    clock: Clock,
    kind: str,
) -> tuple[list[Mend], list[Tried]]:
    """The mends of one kind for a region, and what was tried without success."""
    bench = Bench(model, motion, region, margin, keep, clock.late)
    made = []
    with contextlib.suppress(Stopped):
        for candidate in MAKERS[kind](bench):
            found = _verified(model, bench, candidate, held)
            if found is not None:
                made.append(found)
    return made, bench.tried


def _verified(model: Model, bench: Bench, candidate: MendCandidate, held: list[int]) -> Mend | None:
    """The change on the whole structure, checked; ``None`` if it falls.

    If the least value of the local model is not sufficient for the whole structure, a larger one is
    searched.
    """
    names = model.assembly.names
    near = bench.nearby()
    sieved = bench.margin.robust and near is not None
    why: dict[float, str] = {}
    largest = candidate.value

    def changed_whole(value: float) -> tuple[Model, Model] | None:
        """The whole model with the change, and the same with other regions held."""
        nonlocal largest
        largest = max(largest, value)
        try:
            made = candidate.make(value)(model, bench.blocks, bench.interfaces)
        except InputError as error:
            why[value] = str(error)
            return None
        still = [names[i] for i in held if names[i] in made.assembly]
        fixed = [made.assembly.names[i] for i in np.flatnonzero(made.assembly.fixed)]
        return made, made.with_supports([*fixed, *still]) if still else made

    def stands(value: float, *, quick: bool) -> bool:
        both = changed_whole(value)
        return both is not None and bench.keeps_margin(both[1], quick=quick, near=near)

    def checked(value: float) -> tuple[Model, Result] | None:
        both = changed_whole(value)
        # a large model that does not stand for all stiffnesses is not followed while it settles
        if both is None or (sieved and not stands(value, quick=False)):
            return None
        result = bench.holds(both[1])
        why[value] = result.message
        return (both[0], result) if bench.margin.meets(result) else None

    def larger(low: float, *, quick: bool) -> float | None:
        """The least value above one that falls."""
        while low + candidate.close < candidate.most:
            high = top = min(2.0 * low + candidate.close, candidate.most)
            if stands(high, quick=quick):
                while high - low > candidate.close:
                    middle = 0.5 * (low + high)
                    if stands(middle, quick=quick):
                        high = middle
                    else:
                        low = middle
                return high
            low = top
        return None

    def settled(value: float) -> tuple[Model, Result] | None:
        """As ``checked``, where standing after settling is enough."""
        both = changed_whole(value)
        if both is None:
            return None
        margin = replace(bench.margin, robust=False)
        result = bench.holds(both[1], margin)
        why[value] = result.message
        return (both[0], result) if margin.meets(result) else None

    def least_settled(low: float) -> tuple[float, tuple[Model, Result]] | None:
        """A value above one that falls with which the structure stands after settling."""
        found, high = None, low
        while found is None and high + candidate.close < candidate.most:
            low, high = high, min(2.0 * high + candidate.close, candidate.most)
            found = settled(high)
        if found is None:
            return None
        middle = 0.5 * (low + high)
        better = settled(middle)
        return (high, found) if better is None else (middle, better)

    value: float | None = candidate.value
    cost, how = 0.0, ""
    # cheap first: what falls with uniform stiffness does not stand for all
    if sieved and not stands(candidate.value, quick=True):
        value = larger(candidate.value, quick=True)
    least = candidate.value if value is None else value
    answer = None if value is None else checked(value)
    if answer is None and value is not None:
        value = larger(value, quick=False)
        answer = None if value is None else checked(value)
    if answer is None and bench.margin.robust:
        settling = least_settled(candidate.value) if not sieved else (least, settled(least))
        if settling is not None and settling[1] is not None:
            value, answer = settling
            cost, how = SETTLED, ", which holds only after settling"
    if answer is None or value is None:
        if candidate.value not in why:
            checked(candidate.value)
        words = candidate.words(candidate.value)
        what = f"{words} holds the region, but of the whole: {why[candidate.value]}"
        if largest > candidate.value:
            last = f" ({why[largest]})" if largest in why else ""
            what += (
                f"; larger values do not hold it either, up to: {candidate.words(largest)}{last}"
            )
        bench.tried.append(Tried(candidate.kind, what))
        return None
    made, result = answer
    still = [names[i] for i in held if names[i] in made.assembly]
    region = bench.region
    volume = volume_changed(model, made)
    whole = float(model.assembly.volume[list(region.blocks)].sum())
    cost += JOINT * candidate.joints + ADDED * candidate.added + VOLUME * volume / whole
    if candidate.kind == "friction":
        gained = np.asarray(made.contacts.friction) - np.asarray(model.contacts.friction)
        cost += FRICTION * float(gained.sum())
    return Mend(
        candidate.kind,
        tuple(names[i] for i in region.blocks),
        candidate.words(value) + how,
        value,
        candidate.joints,
        candidate.added,
        volume,
        cost,
        model,
        made,
        result,
        tuple(still),
    )
