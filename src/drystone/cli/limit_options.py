"""Options that the limits share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from drystone.cli.options import positive
from drystone.cli.waiting import Waiting, end_workers
from drystone.errors import InputError

if TYPE_CHECKING:
    from drystone.limits import LimitOptions

Workers: TypeAlias = Annotated[int, typer.Option(help="Processes that work side by side.")]


@dataclass(frozen=True)
class Search:
    """How to search for a limit."""

    width: Annotated[
        float | None, typer.Option(help="Width of the brackets, in the unit of the limit.")
    ] = None
    scan: Annotated[
        int, typer.Option(help="Steps of the scan for islands before the limit is bisected.")
    ] = 6
    cone: Annotated[
        str, typer.Option(help="Friction of the equilibrium limit: exact, or octagon as published.")
    ] = "exact"
    equilibrium_only: Annotated[
        bool, typer.Option("--equilibrium-only", help="Leave out the full verdict.")
    ] = False
    workers: Workers = 1

    def options(self) -> LimitOptions:
        """The same as the library takes it.

        Raises
        ------
        InputError
        """
        positive(self.width, "--width")
        if self.scan < 1:
            raise InputError(f"is {self.scan}", where="--scan", remedy="give one step or more")
        from drystone.limits import LimitOptions
        from drystone.stability import FrictionCone

        cones = {"exact": FrictionCone.exact, "octagon": FrictionCone.octagon}
        if self.cone not in cones:
            raise InputError(
                f"is '{self.cone}'", where="--cone", remedy=f"one of {', '.join(cones)}"
            )
        return LimitOptions(
            width=self.width,
            scan=self.scan,
            cone=cones[self.cone](),
            full=not self.equilibrium_only,
        )

    @contextmanager
    def under_way(self, waiting: Waiting) -> Iterator[dict[str, Any]]:
        """What every limit of the library takes besides its model: options, workers and so on."""
        chosen = self.options()
        waiting.stage("solve", "searching")
        with working(self.workers, waiting) as common:
            yield {"options": chosen, **common}


@contextmanager
def working(workers: int, waiting: Waiting) -> Iterator[dict[str, Any]]:
    """Where and how to work: the executor, if more than one is to, progress, and when to stop.

    Answers of other processes come a scan at a time, so that Ctrl-C ends those without one.
    """
    if workers < 1:
        raise InputError(f"is {workers}", where="--workers", remedy="give one or more")
    if workers == 1:
        with waiting.stoppable() as stop:
            yield {"executor": None, "progress": waiting, "stop": stop}
        return
    import signal
    from concurrent.futures import ProcessPoolExecutor

    # Ctrl-C reaches every process of a terminal: this one answers for all
    ignore = (signal.SIGINT, signal.SIG_IGN)
    with ProcessPoolExecutor(workers, initializer=signal.signal, initargs=ignore) as executor:
        try:
            yield {"executor": executor, "progress": waiting}
        except KeyboardInterrupt:
            executor.shutdown(wait=False, cancel_futures=True)
            end_workers()
            raise
