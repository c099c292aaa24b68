"""``drystone check``: does it stand, what falls, and what would it need?"""

from __future__ import annotations

from typing import Annotated

import typer

from drystone.cli import loading, options, output, verdict
from drystone.cli.groups import Finding, Subject, Written, expanded
from drystone.cli.waiting import Waiting


@expanded
def check(
    *,
    subject: Subject,
    seismic: loading.Seismic = None,
    finding: Finding,
    wanted: Written,
    strict: Annotated[
        bool,
        typer.Option(
            "--strict", help="Only stable if it stands whatever the stiffness of the contacts."
        ),
    ] = False,
    time_limit: options.TimeLimit = None,
    as_json: options.Json = False,
) -> int:
    """Tell whether a model stands, with its proof.

    Exit code 0: it stands. 1: it does not, or that could not be decided. 2: bad input. 130: Ctrl-C
    ended the search; what was known by then is the answer.
    """
    files, tables = wanted.checked()
    options.positive(time_limit, "--time-limit")
    with Waiting() as waiting:
        prepared = subject.prepared(waiting, finding, seismic=seismic)
        result = verdict.solve(prepared, waiting, time_limit)
        waiting.stage("tables", "joints")
        try:
            rows, said = tables.of(result)
            written = verdict.write([*files.of(result, subject.model), *rows], waiting)
        except KeyboardInterrupt:  # the verdict is known: it is told
            waiting.interrupted = True
            written, said = [], [f"interrupted: {waiting.left()}"]
    data = verdict.content(result, waiting.time_s, subject.model, files)
    data["files"] = written
    data["notes"] += said
    if as_json:
        output.emit(data)
    else:
        verdict.show(data)
    return waiting.exit_code(verdict.exit_code(result, strict))
