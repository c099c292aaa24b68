"""A structure mended region by region until it stands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Unpack

from drystone.base.display import OneLine, named
from drystone.base.errors import counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.design.mends.mends import Mend, MendOptions, Mends, find_mends, stands_already
from drystone.io.opening import Given, How, as_model
from drystone.model import Model
from drystone.results import Result

ROUNDS = 20
"""Largest number of mends of :func:`mend`. Chosen."""


@dataclass(frozen=True, eq=False)
class Mending(OneLine):
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

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "stands": self.stands,
            "verdict": self.result.verdict.value,
            "message": self.result.message,
            "steps": [step.to_dict() for step in self.steps],
            "log": list(self.log),
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

    The heaviest region comes first. After each mend the whole structure is checked again, so blocks
    that fall because of the mend are mended too.

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
    while True:
        result = chosen.margin.holds(model, clock.late)
        stands = chosen.margin.meets(result)
        if stands:
            log.append(f"it stands: {result.message}" if steps else stands_already(chosen.margin))
            break
        if len(steps) == ROUNDS or clock.late():
            log.append(f"ended after {counted(len(steps), 'mend')}")
            break
        found = find_mends(
            model,
            options=chosen,
            regions=1,
            executor=pool.executor,
            progress=progress,
            stop=clock.late,
        )
        if not found.mends:
            log.append(_hopeless(found))
            break
        best = found.mends[0]
        steps.append(best)
        model = best.model
        log.append(f"{named(best.blocks)}: {best.description} (cost {best.cost:.3g})")
    return Mending(tuple(steps), model, result, stands, tuple(log))


def _hopeless(found: Mends) -> str:
    """Why no mend was found: the tried kinds, and their largest values."""
    if not found.tried:
        return found.message or "no mend was tried"
    names = ", ".join(found.tried[0][0])
    return f"no mend of the list holds {names}: " + "; ".join(
        f"{one.kind}: {one.what}" for _, one in found.tried
    )


__all__ = ["Mending", "mend"]
