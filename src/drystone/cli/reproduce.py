"""``drystone reproduce``: the source's own structures, published beside found."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drystone.cli import options, output
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

if TYPE_CHECKING:
    from drystone.reproduce import Case


def reproduce(
    section: Annotated[
        str | None,
        typer.Argument(help="Section of Kao 2023, such as 7.2.4; all of them when left out."),
    ] = None,
    out: Annotated[
        str | None, typer.Option(help="Folder for the pages and figures; none without it.")
    ] = None,
    as_json: options.Json = False,
) -> int:
    """Compute the case studies of the source again, each beside its published figures.

    Exit code 0: no line disagrees. 1: some do. 2: bad input.
    """
    if out is not None and not Path(out).is_dir():
        raise InputError("there is no such folder", where="--out", remedy="make it first")
    from drystone import reproduce as cases  # the program starts fast

    chosen = list(cases.SECTIONS) if section is None else [section]
    found, written = [], []
    with Waiting() as waiting:
        for name in chosen:
            waiting.stage("solve", f"section {name}")
            case = cases.reproduce(name)
            found.append(case)
            written += [] if out is None else cases.save_case(case, out)
            if not as_json:
                _show(case)
    if as_json:
        sections = [
            {
                "section": case.section,
                "title": case.title,
                "agrees": case.agrees,
                "lines": [line.to_dict() for line in case.lines],
            }
            for case in found
        ]
        output.emit({"sections": sections, "files": written, "time_s": dict(waiting.time_s)})
    else:
        for path in written:
            output.say(f"wrote {path}")
    return 0 if all(case.agrees for case in found) else 1


def _show(case: Case) -> None:
    """A line per claim: published / found."""
    output.say(f"{case.section} {case.title}")
    for line in case.lines:
        mark = {True: "agrees", False: "DIFFERS", None: "-"}[line.agrees]
        note = f" ({line.note})" if line.note else ""
        output.say(f"  {line.what}: {line.published or '-'} / {line.found}  {mark}{note}")
