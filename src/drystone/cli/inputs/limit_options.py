"""Options that the limits share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from drystone.cli.base import kinds
from drystone.cli.base.command import Option
from drystone.cli.base.waiting import Waiting
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
    equilibrium_only: Annotated[
        bool, Option("Compute the limit of equilibrium only.", expert=True)
    ] = False
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
        with waiting.keywords(self.time_limit, self.workers) as common:
            yield {"options": chosen, **common}
