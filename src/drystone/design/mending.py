"""A structure mended region by region until it stands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from drystone.answer import Sentence
from drystone.base.display import named
from drystone.base.errors import counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.design.changed_answer import ChangedAnswer
from drystone.design.mend_types import Mend, MendOptions, Mends
from drystone.design.mends import find_mends, kept_blocks, stands_already
from drystone.io.opening import Given, How, as_model
from drystone.model import Model
from drystone.results import Result

_ROUNDS = 20
"""Largest number of mends of :func:`mend`. Chosen."""


@dataclass(frozen=True, eq=False)
class Mending(ChangedAnswer):
    """A structure mended region by region.

    Attributes
    ----------
    steps
        The mends in order.
    model
        With all of them.
    result
        Its full check, or that of the case of the margin in which it falls.
    stands
        Whether it stands at the margin.
    log
        The steps, one sentence each.
    """

    steps: tuple[Mend, ...]
    model: Model
    result: Result
    stands: bool
    log: tuple[str, ...]

    def _summary(self) -> str:
        state = "stands" if self.stands else "falls"
        return f"{state} after {counted(len(self.steps), 'mend')}"

    @property
    def unchanged(self) -> Model:
        """The structure before the first mend."""
        return self.steps[0].before if self.steps else self.model

    @property
    def change(self) -> str:
        """The mends."""
        return "; ".join(one.description for one in self.steps)

    @property
    def stands_now(self) -> bool:
        """Whether it stands at the margin."""
        return self.stands

    @property
    def title(self) -> str:
        """Whether it stands, and after how many mends."""
        return self._summary()[0].upper() + self._summary()[1:]

    def sentences(self) -> Sequence[Sentence]:
        """The verdict on what was made, and the steps."""
        verdict, _ = super().sentences()
        word = verdict if self.steps else replace(verdict, text=self.result.verdict.upper())
        return [word, *map(Sentence, self.log)]

    def numbers(self) -> Mapping[str, Any]:
        """Whether it stands, and the steps."""
        return {
            "stands": self.stands,
            "verdict": self.result.verdict,
            "message": self.result.message,
            "steps": [step.numbers() for step in self.steps],
            "log": self.log,
        }


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
) -> Mending:
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
    >>> made.stands, len(made.steps)
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
) -> Mending:
    steps: list[Mend] = []
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
        steps.append(best)
        log.append(f"{named(best.blocks)}: {best.description} (cost {best.cost:.3g})")
        # what now touches other blocks is tried again
        changed = _changed(model, best.model) | set(best.blocks)
        passed = {blocks: near for blocks, near in passed.items() if not near & changed}
        model = best.model
    return Mending(tuple(steps), model, result, stands, tuple(log))


def _hopeless(found: Mends) -> dict[tuple[str, ...], str]:
    """The regions that no mend holds: the tried kinds, and their largest values."""
    held = {mend.blocks for mend in found.mends}
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
