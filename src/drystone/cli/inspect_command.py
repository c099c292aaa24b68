"""``drystone inspect``: the blocks of a file, their defects and their contacts."""

from __future__ import annotations

from functools import partial
from typing import Annotated

from drystone.cli.command import command
from drystone.cli.model_input import Inspected
from drystone.cli.offered import CONTACTS, OUTPUT, Option
from drystone.cli.told import Files, Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Pictures


@command("drystone inspect arch.json", "drystone inspect arch.json --sweep --html contacts.html")
def inspect(
    *,
    source: Inspected,
    sweep: Annotated[bool, Option("Count the contacts for many gap tolerances.", CONTACTS)] = False,
    pictures: Pictures,
    everything: Annotated[bool, Option("List every block.", OUTPUT, ("--all",))] = False,
    waiting: Waiting,
) -> Told:
    """List the blocks of a model, the defects of their meshes and the contacts between them.

    The page and the figure show the contacts, near misses in orange. Exit code 0: every block can
    be used. 2: some cannot.
    """
    from drystone import io  # the program starts fast: work is imported when there is some
    from drystone.detection import find_contacts, gap_sweep
    from drystone.io.inspection import Inspection, usable
    from drystone.io.opening import tolerances

    waiting.stage("read", f"reading {source.name}")
    how = source.how
    supports = how.get("supports")
    options = tolerances(**{name: how.pop(name, None) for name in ("gap", "angle", "edges")})
    built = io.inspect(source.place, **how)
    assembly, notes = usable(built, supports)
    found = swept = None
    if assembly is not None:
        pictures.require_through(assembly)
        waiting.stage("detect", "finding contacts")
        found = find_contacts(assembly, options=options)
        if sweep:
            waiting.stage("sweep", "trying gaps")
            swept = gap_sweep(assembly, progress=waiting)
    answer = Inspection(assembly, found, swept, built, source.name)
    files = partial(pictures.of, answer) if assembly is not None else _no_files
    return Told(answer, notes=notes, files=files, everything=everything)


def _no_files() -> Files:
    return [], []
