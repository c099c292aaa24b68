"""Options that the limits share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from drystone.cli.base import kinds
from drystone.cli.base.command import Option
from drystone.cli.base.waiting import Waiting, end_workers
from drystone.cli.inputs.options import TimeLimit

if TYPE_CHECKING:
    from drystone.limits import LimitOptions

Workers: TypeAlias = Annotated[
    int, Option("Processes that work side by side (1).", kind=kinds.whole(1), expert=True)
]


@dataclass(frozen=True)
class LimitSearch:
    """Options of the search for a limit."""

    width: Annotated[
        float | None,
        Option(
            "Width of the brackets, in the unit of the limit.", kind=kinds.POSITIVE, expert=True
        ),
    ] = None
    scan: Annotated[
        int,
        Option(
            "Steps of the scan for islands before the limit is bisected (6).",
            kind=kinds.whole(1),
            expert=True,
        ),
    ] = 6
    cone: Annotated[
        str,
        Option(
            "Friction of the equilibrium limit: exact, or octagon as published (exact).",
            kind=kinds.one_of(("exact", "octagon")),
            expert=True,
        ),
    ] = "exact"
    equilibrium_only: Annotated[bool, Option("Leave out the full verdict.", expert=True)] = False
    workers: Workers = 1
    time_limit: TimeLimit = None

    def options(self) -> LimitOptions:
        """The options of the library."""
        from drystone.limits import LimitOptions
        from drystone.stability import FrictionCone

        exact = self.cone == "exact"
        return LimitOptions(
            width=self.width,
            scan=self.scan,
            cone=FrictionCone.exact() if exact else FrictionCone.octagon(),
            full=not self.equilibrium_only,
        )

    @contextmanager
    def under_way(self, waiting: Waiting) -> Iterator[dict[str, Any]]:
        """The common keywords of all limits of the library."""
        chosen = self.options()
        waiting.stage("solve", "searching")
        limit = {} if self.time_limit is None else {"time_limit_s": self.time_limit}
        with working(self.workers, waiting) as common:
            yield {"options": chosen, **limit, **common}


@contextmanager
def working(workers: int, waiting: Waiting) -> Iterator[dict[str, Any]]:
    """Executor, progress and stop.

    The executor is for more than one worker. Worker processes answer once per scan, so Ctrl-C loses
    the scan that runs.
    """
    if workers == 1:
        with waiting.stoppable() as stop:
            yield {"executor": None, "progress": waiting, "stop": stop}
        return
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(workers, initializer=_begin_worker) as executor:
        try:
            yield {"executor": executor, "progress": waiting}
        except KeyboardInterrupt:
            executor.shutdown(wait=False, cancel_futures=True)
            end_workers()
            raise


def _begin_worker() -> None:
    """Leave Ctrl-C to the process that started this worker, and end with it."""
    import signal

    from drystone.sequence.stage.workers import end_with_parent

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
