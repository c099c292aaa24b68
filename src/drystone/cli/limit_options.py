"""Options that the limits share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from drystone.cli.options import positive
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

if TYPE_CHECKING:
    from concurrent.futures import Executor

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
        """What every limit of the library takes besides its model: options, workers, progress."""
        chosen = self.options()
        waiting.stage("solve", "searching")
        with working(self.workers) as executor:
            yield {"options": chosen, "executor": executor, "progress": waiting}


@contextmanager
def working(workers: int) -> Iterator[Executor | None]:
    """Processes to work on, or none for one worker."""
    if workers < 1:
        raise InputError(f"is {workers}", where="--workers", remedy="give one or more")
    if workers == 1:
        yield None
        return
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(workers) as executor:
        yield executor
