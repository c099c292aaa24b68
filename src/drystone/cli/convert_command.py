"""``drystone convert``: from one file format to another."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.base.errors import InputError
from drystone.base.files import same_place
from drystone.cli import kinds
from drystone.cli.command import command
from drystone.cli.model_input import Converted, warnings_of
from drystone.cli.offered import CONTACTS, OUTPUT, Argument, Option
from drystone.cli.output import Screen
from drystone.cli.told import Printed
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.io.registry import Format


@command(
    "drystone convert arch.json arch.obj",
    "drystone convert arch.obj again.json --supports lowest --contacts",
)
def convert(
    *,
    source: Converted,
    target: Annotated[
        str, Argument("TARGET", "File to write; its suffix determines the format.", kinds.FILE)
    ],
    contacts: Annotated[bool, Option("Find the contacts and write them too.", CONTACTS)] = False,
    to: Annotated[
        str | None,
        Option(
            "Format by name, where several share a suffix: drystone, drystone-npz, "
            "compas-assembly, compas-dem.",
            OUTPUT,
            metavar="FORMAT",
        ),
    ] = None,
    overwrite: Annotated[bool, Option("Write over the model itself.", OUTPUT)] = False,
    waiting: Waiting,
) -> Printed:
    """Write a model in another format, and list what that format cannot hold."""
    from drystone import io  # the program starts fast: work is imported when there is some
    from drystone.model import Model
    from drystone.supports import select

    how = source.how
    friction = how.pop("friction", None)
    supports = how.get("supports")
    chosen = io.format_of(target, to, writing=True)
    _refuse_other_suffix(target, chosen)
    if not overwrite and any(same_place(target) == same_place(file) for file in source.each):
        raise InputError(
            "the model would be written over itself",
            where=f"'{target}'",
            remedy="name another file, or add --overwrite",
        )
    waiting.stage("read", f"reading {source.name}")
    read = io.read_file(source.place, **how)
    notes = list(read.notes)
    if supports is not None:
        read = replace(read, assembly=select(read.assembly, supports), results=(), loads=())
    if contacts:
        waiting.stage("detect", "finding contacts")
        made = Model.of(read.assembly, friction=friction, anyway=True)
        notes += [*made.notes, *([] if made.report is None else warnings_of(made.report))]
        read = replace(read, contacts=made.contacts, results=())
    waiting.stage("write", f"writing {target}")
    io.write(read, target, format=to)
    data = {
        "model": source.name,
        "format": chosen.name,
        "blocks": len(read.assembly),
        "fixed": int(read.assembly.fixed.sum()),
        "interfaces": None if read.contacts is None else read.contacts.count,
        "loses": chosen.loses,
    }
    told = f"{len(read.assembly)} blocks, {chosen.title}"
    arrays = [str(Path(target).with_suffix(".npz"))] if chosen.name == "drystone-npz" else []
    show = partial(_show, told, chosen.loses)
    return Printed(data, show, notes=notes, written=[target, *arrays])


def _show(told: str, loses: str, screen: Screen) -> None:
    screen.line(told)
    if loses:
        screen.dim(f"this format does not store {loses}")


def _refuse_other_suffix(target: str, chosen: Format) -> None:
    """Refuse a file whose suffix is not that of the chosen format."""
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
