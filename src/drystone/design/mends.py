"""The search for mends: changes that make a structure stand, ranked by their cost."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import Unpack

import numpy as np

from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.design.bench import Tried
from drystone.design.changed import Changed
from drystone.design.diagnosis import diagnose
from drystone.design.margin import QUICK, DesignMargin
from drystone.design.mend_kinds import KINDS
from drystone.design.mend_types import MendOptions, Mends
from drystone.design.whole_check import mends_of_kind
from drystone.io.opening import Given, How, as_model
from drystone.model import Model
from drystone.stability import check
from drystone.supports import select


@checked_call
def find_mends(
    given: Given,
    *,
    options: MendOptions | None = None,
    regions: int | None = None,
    besides: Collection[frozenset[str]] = (),
    found_one: Callable[[Changed], None] | None = None,
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
        told = found.reasons[0]
        if first.stable:
            told = f"{first.message}: no mend makes it stand for all; 'sensitive' accepts it"
        return Mends(found, (), message=told)
    mends: list[Changed] = []
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
            own: list[Changed] = []
            task = partial(
                mends_of_kind, model, found.motion, region, chosen.margin, keep, held, clock
            )
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


def _rank(made: Changed) -> tuple[float, int, float]:
    """Cost, then kind, then size; costs that differ by rounding are equal."""
    one = made.change
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
