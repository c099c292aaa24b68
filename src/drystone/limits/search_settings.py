"""Settings of a search for a limit, and the default widths of its brackets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TypeAlias

import numpy as np

from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.limits.brackets import Bracket, FoundBracket
from drystone.limits.limit_checks import STANDS, Check
from drystone.limits.limit_families import Family
from drystone.limits.limit_types import LimitOptions
from drystone.limits.search import VerdictSearch
from drystone.results import Result, Verdict

COARSE = 1.0 / 96.0
"""Default width for larger models, relative to the distance between the start and the limit of
equilibrium. A finer bracket would depend more on the iteration than on the structure. It is the
result of a scan of six steps, each halved four times."""

FOLLOWED = 1e-3
"""Default width where blocks are followed by finite steps, as a share of the same distance: three
digits. The limit itself depends on the joints by more."""


Brackets: TypeAlias = tuple[FoundBracket | None, FoundBracket, Bracket | None]
"""For uniform stiffness, of the verdict, and for every stiffness."""


@dataclass(frozen=True, eq=False)
class SearchSettings:
    """Settings of a search. Without a check, that of drystone is made in two steps.

    Attributes
    ----------
    check, options
    given
        The executor, or what starts one.
    progress, stop, time_limit_s
    executor
        What was started.
    at_start
        What uniform stiffness and the verdict say at the start, where that is known.
    followed
        Default width where blocks are followed; a share of the distance to the end when left out.
    """

    check: Check | None
    options: LimitOptions
    given: Workers | None
    progress: Progress | None
    stop: Stop | None
    time_limit_s: float = float("inf")
    executor: Executor | None = None
    at_start: tuple[Result | None, Result | None] = (None, None)
    followed: float | None = None

    @cached_property
    def clock(self) -> Clock:
        """The time since the start; keeps a request to stop."""
        return Clock(self.time_limit_s, self.stop)

    def search(
        self,
        family: Family,
        check: Callable[..., Result],
        meaning: Mapping[Verdict, bool | None] = STANDS,
        known: Mapping[float, Result | None] | None = None,
    ) -> VerdictSearch:
        """A search with a check of drystone, which can be stopped, from known values on."""
        if self.stop is not None or np.isfinite(self.time_limit_s):
            check = partial(check, stop=self.clock.late)
        search = VerdictSearch(family, check, self.executor, meaning, self.clock.late)
        search.results.update({v: one for v, one in (known or {}).items() if one is not None})
        return search

    def tell(self, stage: str, done: int) -> None:
        """Report one of three steps."""
        if self.progress is not None:
            self.progress(stage, done, 3)
