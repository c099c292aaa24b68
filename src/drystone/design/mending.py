"""A structure mended region by region until it stands."""

from __future__ import annotations

from dataclasses import replace
from typing import Unpack

import numpy as np

from drystone.base.display import named
from drystone.base.errors import counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.design.changed import Changed, Kept
from drystone.design.mend_types import MendOptions, Mends
from drystone.design.mends import find_mends, kept_blocks, stands_already
from drystone.io.opening import Given, How, as_model
from drystone.model import Model

_ROUNDS = 20
"""Largest number of mends of :func:`mend`. Chosen."""


@checked_call
def mend(
    given: Given,
    *,
    options: MendOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Changed:
    """The structure with the lowest-cost mend of each region, until it stands.

    The heaviest region comes first; one that no mend holds is passed over. A mend that holds only
    after settling is made where no other one holds the region. After each mend the
    whole structure is checked again, so blocks that fall because of the mend are mended too.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    options

    Examples
    --------
    >>> from drystone import Assembly
    >>> from drystone.models import box
    >>> base, out = box((1.0, 1.0, 1.0)), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    >>> made = mend(Assembly((base, out)).with_fixed([0]), options=MendOptions(kinds=("prop",)))
    >>> made.stands, len(made.changes)
    (True, 1)
    """
    chosen = MendOptions.of(options)
    clock = Clock(time_limit_s, stop)
    with WorkerPool(executor) as pool:
        return _mended(as_model(given, **how), chosen, pool, progress, clock)


def _mended(
    model: Model,
    chosen: MendOptions,
    pool: WorkerPool,
    progress: Progress | None,
    clock: Clock,
) -> Changed:
    before = model
    steps: list[Kept] = []
    log: list[str] = []
    names = tuple(model.assembly.names)
    chosen = replace(chosen, keep=tuple(names[i] for i in kept_blocks(model, chosen.keep)))
    passed: dict[frozenset[str], frozenset[str]] = {}  # regions, and what each of them touches
    while True:
        result = chosen.margin.holds(model, clock.late)
        stands = chosen.margin.meets(result)
        if stands:
            log.append(f"it stands: {result.message}" if steps else stands_already(chosen.margin))
            break
        if len(steps) == _ROUNDS or clock.late():
            falls = f": {named(result.falling_names)} would still fall" if result.falling else ""
            why = clock.reason or f"ended after {counted(len(steps), 'mend')}"
            log.append(f"{why}{falls}")
            break
        found = find_mends(
            model,
            options=chosen,
            regions=1,
            besides=passed,
            executor=pool.executor,
            progress=progress,
            stop=clock.late,
        )
        for blocks, why in _hopeless(found).items():
            log.append(why)
            passed[frozenset(blocks)] = _touched(found, blocks)
        if not found.mends:
            log.append(_left(found))
            break
        firm = (one for one in found.mends if chosen.margin.meets(one.result))
        best = next(firm, found.mends[0])
        kept = best.change
        steps.append(kept)
        log.append(f"{named(kept.blocks)}: {kept.description} (cost {kept.cost:.3g})")
        # what now touches other blocks is tried again
        changed = _changed(model, best.model) | set(kept.blocks)
        passed = {blocks: near for blocks, near in passed.items() if not near & changed}
        model = best.model
    words = "; ".join(one.description for one in steps)
    return Changed(before, model, result, stands, words, tuple(steps), tuple(log))


def _hopeless(found: Mends) -> dict[tuple[str, ...], str]:
    """The regions that no mend holds: the tried kinds, and their largest values."""
    held = {mend.change.blocks for mend in found.mends}
    said: dict[tuple[str, ...], list[str]] = {}
    for blocks, one in found.tried:
        if blocks not in held:
            said.setdefault(blocks, []).append(f"{one.kind}: {one.what}")
    return {
        blocks: f"no mend of the list holds {named(blocks)}: {'; '.join(tried)}"
        for blocks, tried in said.items()
    }


def _left(found: Mends) -> str:
    """What still falls."""
    names, regions = found.diagnosis.model.assembly.names, found.diagnosis.regions
    if not regions:
        return found.message or "no mend was tried"
    falling = [names[i] for region in regions for i in region.blocks]
    return f"it still falls: {named(falling)}"


def _touched(found: Mends, blocks: tuple[str, ...]) -> frozenset[str]:
    """The names of the blocks of a region and of those beside it."""
    names = found.diagnosis.model.assembly.names
    for region in found.diagnosis.regions:
        if {names[i] for i in region.blocks} == set(blocks):
            return frozenset(names[i] for i in (*region.blocks, *region.neighbours))
    return frozenset(blocks)


def _changed(before: Model, after: Model) -> set[str]:
    """The names of blocks that are new, gone or of another shape."""
    old, new = (
        {block.name: block.vertices for block in model.assembly.blocks} for model in (before, after)
    )
    same = {name for name in old if name in new and np.array_equal(old[name], new[name])}
    return (set(old) | set(new)) - same
