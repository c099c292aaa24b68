"""The files of ``drystone plan``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.cli import kinds, options
from drystone.cli.offered import OUTPUT, Option
from drystone.cli.written import apart, cad_jobs, refuse_missing

if TYPE_CHECKING:
    from drystone.base.files import Job
    from drystone.cli.told import Files
    from drystone.sequence import Margins, Plan, Robot, Scaffolding


@dataclass(frozen=True)
class PlanFiles:
    """The files of a plan."""

    work: Annotated[
        Path | None,
        Option("Write the placements for robots: paths, grips and holds, .json or .csv.", OUTPUT,
               kind=kinds.target(".json", ".csv"), expert=True),
    ] = None  # fmt: skip
    html: options.Html = None
    png: options.Png = None
    cad: options.Cad = None
    instructions: Annotated[
        Path | None,
        Option("Write numbered instructions for printing, .html.", OUTPUT, ("--print",),
               kinds.target(".html", ".htm"), expert=True),
    ] = None  # fmt: skip
    csv: Annotated[
        Path | None,
        Option("Write the table of stages, .csv.", OUTPUT, kind=kinds.target(".csv"), expert=True),
    ] = None

    def __post_init__(self) -> None:
        apart(astuple(self))
        refuse_missing(self.cad)

    def of(
        self,
        plan: Plan,
        made: Scaffolding | None,
        margins: Margins | None,
        robots: Sequence[Robot],
    ) -> Files:
        """The files of a plan, with its scaffolding and its margins where there are some."""
        if not plan.steps:
            wanted = [str(path) for path in astuple(self) if path is not None]
            return [], [f"not written: {', '.join(wanted)}"] if wanted else []
        jobs: list[Job] = cad_jobs(self.cad, plan)
        if self.html is not None or self.png is not None or self.instructions is not None:
            from drystone.view import save_figure, save_page
            from drystone.view.instructions import save_instructions

            if self.html is not None:
                jobs.append((self.html, partial(save_page, made or plan)))
            if self.png is not None:
                jobs.append((self.png, partial(save_figure, made or plan)))
            if self.instructions is not None:
                jobs.append((self.instructions, partial(save_instructions, plan)))
        if self.work is not None:
            from drystone.sequence import handling

            placed, flat = handling(plan, robots), self.work.suffix == ".csv"
            jobs.append((self.work, placed.table().to_csv if flat else placed.save_json))
        if self.csv is not None:
            jobs.append((self.csv, (plan if margins is None else margins).table().to_csv))
        return jobs, []
