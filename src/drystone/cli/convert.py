"""``drystone convert``: from one file format to another."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drystone.cli import options, output
from drystone.cli.session import warnings_of
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

if TYPE_CHECKING:
    from drystone.io.formats import Format


def convert(
    model: options.ModelArgument,
    target: Annotated[
        str, typer.Argument(metavar="TARGET", help="File to write; its suffix tells the format.")
    ],
    to: Annotated[
        str | None,
        typer.Option(
            help="Format by name, where several share a suffix: drystone, drystone-npz, "
            "compas-assembly, compas-dem."
        ),
    ] = None,
    supports: options.Supports = None,
    units: options.Units = None,
    split: options.Split = False,
    contacts: Annotated[
        bool, typer.Option("--contacts", help="Find the contacts and write them too.")
    ] = False,
    friction: options.Friction = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Write over the model itself.")
    ] = False,
    as_json: options.Json = False,
) -> int:
    """Write a model in another format, and say what that format has no place for."""
    from dataclasses import replace

    from drystone import io  # the program starts fast: work is imported when there is some
    from drystone.model import Model
    from drystone.supports import select as select_supports

    chosen = io.format_of(target, to)
    _refuse_other_suffix(target, chosen)
    if not overwrite and Path(target).resolve() == Path(model).resolve():
        raise InputError(
            "the model would be written over itself",
            where=f"'{target}'",
            remedy="name another file, or add --overwrite",
        )
    with Waiting() as waiting:
        waiting.stage("read", f"reading {model}")
        read = io.read_file(model, units=units, split=split)
        notes = list(read.notes)
        if supports is not None:
            read = replace(
                read, assembly=select_supports(read.assembly, supports), results=(), loads=()
            )
        if contacts:
            waiting.stage("detect", "finding contacts")
            made = Model.of(read.assembly, friction=friction, anyway=True)
            notes += [*made.notes, *([] if made.report is None else warnings_of(made.report))]
            read = replace(read, contacts=made.contacts, results=())
        waiting.stage("write", f"writing {target}")
        io.write(read, target, format=to)
        waiting.wrote.append(target)
    data = {
        "model": model,
        "files": [target],
        "format": chosen.name,
        "blocks": len(read.assembly),
        "fixed": int(read.assembly.fixed.sum()),
        "interfaces": None if read.contacts is None else read.contacts.count,
        "notes": notes,
        "loses": chosen.loses,
        "time_s": dict(waiting.time_s),
    }
    if as_json:
        output.emit(data)
        return 0

    console = output.console()
    console.print(f"wrote {output.safe(target)}: {data['blocks']} blocks, {chosen.title}")
    for note in notes:
        console.print(f"[yellow]note:[/] {output.safe(note)}")
    if chosen.loses:
        console.print(f"[dim]this format has no place for {chosen.loses}[/]")
    return 0


def _refuse_other_suffix(target: str, chosen: Format) -> None:
    """Refuse a file whose suffix says another format than the one that is asked for."""
    from drystone.io.registry import FORMATS

    suffix = Path(target).suffix.lower()
    known = {each for one in FORMATS for each in one.suffixes}
    if chosen.suffixes and suffix in known - set(chosen.suffixes):
        stem = Path(target).stem
        raise InputError(
            f"'{target}' does not end like {chosen.title}",
            where="--to",
            remedy=f"leave --to out, or write {stem}{chosen.suffixes[0]}",
        )
