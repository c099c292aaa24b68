"""A structure mended region by region until it stands."""

from __future__ import annotations

from dataclasses import replace
from typing import Unpack

from drystone.base.display import named
from drystone.base.errors import counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.design.changed import Changed, Kept
from drystone.design.mends import MendOptions, Mends, find_mends, kept_blocks, stands_already
from drystone.io.opening import Given, How, as_model
from drystone.results import Result

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

    The heaviest region comes first; one that no mend holds is passed over, and tried once more when
    others were mended. A mend that holds only after settling is made where no other one holds the
    region. After each mend the whole structure is checked again, so blocks that fall because of the
    mend are mended too.

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
    before = model = as_model(given, **how)
    names = model.assembly.names
    chosen = replace(chosen, keep=tuple(names[i] for i in kept_blocks(model, chosen.keep)))
    steps: list[Kept] = []
    log: list[str] = []
    passed: dict[frozenset[str], str] = {}
    passed_at = 0
    result = chosen.margin.holds(model, clock.late)
    with WorkerPool(executor) as pool:
        while True:
            stands = chosen.margin.meets(result)
            if stands or len(steps) == _ROUNDS or clock.late():
                break
            found = find_mends(
                model, options=chosen, regions=1, besides=passed, result=result,
                executor=pool.executor, progress=progress, stop=clock.late,
            )  # fmt: skip
            passed |= _hopeless(found)
            if found.mends:
                # one that holds only after settling comes last
                best = max(found.mends, key=lambda one: chosen.margin.meets(one.result))
                model, kept = best.model, best.change
                steps.append(kept)
                log.append(f"{named(kept.blocks)}: {kept.description} (cost {kept.cost:.3g})")
                result = chosen.margin.holds(model, clock.late)
            elif passed and passed_at < len(steps):  # what was mended since may hold them
                passed, passed_at = {}, len(steps)
            else:
                break
    if stands:
        log.append(f"it stands: {result.message}" if steps else stands_already(chosen.margin))
    elif clock.reason or len(steps) == _ROUNDS:
        why = clock.reason or f"ended after {counted(len(steps), 'mend')}"
        log.append(f"{why}; {_left(result)}")
    else:
        log += [*passed.values(), found.message or _left(result)]
    words = "; ".join(one.description for one in steps)
    return Changed(before, model, result, stands, words, tuple(steps), tuple(log))


def _hopeless(found: Mends) -> dict[frozenset[str], str]:
    """The regions that no mend holds: the tried kinds, and their largest values."""
    held = {mend.change.blocks for mend in found.mends}
    said: dict[tuple[str, ...], list[str]] = {}
    for blocks, one in found.tried:
        if blocks not in held:
            said.setdefault(blocks, []).append(f"{one.kind}: {one.what}")
    return {
        frozenset(blocks): f"no mend of the list holds {named(blocks)}: {'; '.join(tried)}"
        for blocks, tried in said.items()
    }


def _left(result: Result) -> str:
    """What still falls."""
    falling = result.falling_names
    return f"it still falls: {named(falling)}" if falling else result.message
