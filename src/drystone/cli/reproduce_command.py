"""``drystone reproduce``: the structures of the source, published and computed figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.base.errors import InputError
from drystone.cli import kinds
from drystone.cli.command import command
from drystone.cli.offered import OUTPUT, Argument, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.reproduce import Case


@command("drystone reproduce 5.1.1", "drystone reproduce 5.1.1 --out .")
def reproduce(
    *,
    section: Annotated[
        str | None,
        Argument(
            "SECTION", "Section of Kao 2023, such as 7.2.4, or all; lists them when left out."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        Option(
            "Folder for the pages and figures, made where there is none; none without it.",
            OUTPUT,
            kind=kinds.FOLDER,
        ),
    ] = None,
    waiting: Waiting,
) -> Told:
    """Compute the case studies of the source, and compare with the published figures.

    Exit code 0: all figures agree. 1: some differ. 2: bad input.
    """
    from drystone import reproduce as cases  # the program starts fast
    from drystone.answer import Role, Sentence, Statement

    if section is None:
        if out is not None:
            raise InputError("no section is named", remedy="write a section or all before --out")
        return Told(cases.sections(), subject="sections of Kao 2023", everything=True)
    if section != "all" and section not in cases.SECTIONS:
        cases.reproduce(section)  # says which there are
    found: list[Case] = []
    written: list[str] = []
    for name in cases.SECTIONS if section == "all" else [section]:
        waiting.stage("solve", f"section {name}")
        found.append(cases.reproduce(name))
        written += [] if out is None else cases.save_case(found[-1], out)
        waiting.wrote = written
    wrong = [case.section for case in found if not case.agrees]
    verdict = f"{', '.join(wrong)} differs" if wrong else "all figures agree"
    told = Sentence(verdict, Role.BAD if wrong else Role.GOOD)
    numbers = {"sections": [case.numbers() for case in found]}
    answer = Statement((told,), tuple(case.table() for case in found), numbers)
    asked = "all sections" if section == "all" else f"section {section}"
    return Told(answer, subject=asked, written=written, everything=True)
