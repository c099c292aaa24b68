"""``drystone dataset``: subsets of structures with their verdicts, for learners."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from drystone.cli import kinds
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import OUTPUT, Analysis, Of, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting


@command(
    "drystone dataset arch.json --out data --rows 100",
    "drystone dataset arch.json --rows 20 --out planned --planned",
)
def dataset(
    *,
    subject: Subject,
    out: Annotated[
        Path,
        Option("Folder of the data set. Where it has part of it, the work goes on.", OUTPUT,
               kind=kinds.FOLDER),
    ],
    asked: Annotated[
        Analysis,
        Of("drystone.sequence.dataset", shown=("options.rows", "options.seed", "options.planned",
                                               "executor")),
    ],
    waiting: Waiting,
) -> Told:  # fmt: skip
    """Write subsets of structures, verdicts, friction left and orders of assembly, with a README.

    Each MODEL is a structure. Exit code 0: the data set is complete. 1: it is not yet.
    """
    models = [replace(subject, files=one).prepared(waiting) for one in subject.each]
    waiting.checkpoint = out / "README.md"
    found = asked.of(waiting, models, out, doing="orders")
    notes = [note for model in models for note in model.notes]
    return Told(found, subject=f"{out}", notes=notes)
