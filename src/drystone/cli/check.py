"""``drystone check``: does it stand, what falls, and what would it need?"""

from __future__ import annotations

from typing import Annotated

import typer

from drystone.cli import joint_files, loading, options, output, verdict
from drystone.cli.groups import Subject, expanded
from drystone.cli.waiting import Waiting


@expanded
def check(
    subject: Subject,
    seismic: loading.Seismic = None,
    gap: options.Gap = None,
    angle: options.Angle = None,
    edges: options.Edges = None,
    find_contacts: options.FindContacts = False,
    split: options.Split = False,
    html: options.Html = None,
    png: options.Png = None,
    strict: Annotated[
        bool,
        typer.Option(
            "--strict", help="Only stable if it stands whatever the stiffness of the contacts."
        ),
    ] = False,
    joints: joint_files.Joints = None,
    strength: joint_files.Strength = None,
    time_limit: options.TimeLimit = None,
    as_json: options.Json = False,
) -> int:
    """Tell whether a model stands, with its proof.

    Exit code 0: it stands. 1: it does not, or that could not be decided. 2: bad input.
    """
    files = verdict.Files.checked(html, png)
    tables = joint_files.checked(joints, strength)
    options.apart([*files.written(), *tables.named()])
    options.positive(time_limit, "--time-limit")
    with Waiting() as waiting:
        prepared = subject.prepared(
            waiting,
            seismic=seismic,
            gap=gap,
            angle=angle,
            edges=edges,
            find_contacts=find_contacts,
            split=split,
        )
        result = verdict.solve(prepared, waiting, time_limit)
        rows, said = tables.of(result)
        written = verdict.write([*files.of(result), *rows], waiting)
    data = verdict.content(result, prepared, waiting.time_s, subject.model, files)
    data["files"] = written
    data["notes"] += said
    if as_json:
        output.emit(data)
    else:
        verdict.show(data)
    return verdict.exit_code(result, strict)
