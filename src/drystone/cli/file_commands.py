"""Commands on the blocks of files: ``convert``, ``inspect`` and ``poses``."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.base.arrays import texts
from drystone.base.errors import InputError, counted
from drystone.base.files import plain_target, same_place
from drystone.cli import kinds
from drystone.cli.command import command
from drystone.cli.model_input import Converted, Inspected, Source, on_its_side, warnings_of
from drystone.cli.offered import CONTACTS, MODEL, OUTPUT, Argument, Option
from drystone.cli.told import Pictures, Told, left_out
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.io.draft import Contents
    from drystone.io.registry import Format


@command(
    "drystone convert arch.json arch.obj",
    "drystone convert arch.obj again.json --supports lowest --contacts",
)
def convert(
    *,
    source: Converted,
    target: Annotated[
        str, Argument("TARGET", "File to write; its suffix determines the format.", kinds.WRITTEN)
    ],
    contacts: Annotated[bool, Option("Find the contacts and write them too.", CONTACTS)] = False,
    to: Annotated[
        str | None,
        Option(
            "Format by name, where several share a suffix: drystone, compas-assembly, compas-dem.",
            OUTPUT,
            metavar="FORMAT",
        ),
    ] = None,
    to_units: Annotated[
        str | None,
        Option("Unit of length of the written file (that of the model).", OUTPUT, kind=kinds.UNIT),
    ] = None,
    joint_allowance: Annotated[
        float | None,
        Option(
            "Blocks to fabricate, with room in their joints: both faces of each move inward by "
            "half of this length.",
            OUTPUT,
            kind=kinds.LENGTH,
        ),
    ] = None,
    overwrite: Annotated[bool, Option("Write over the model itself.", OUTPUT)] = False,
    waiting: Waiting,
) -> Told:
    """Write a model in another format, and list what that format cannot hold."""
    from drystone import io  # the program starts fast: work is imported when there is some
    from drystone.model import Model
    from drystone.supports import ground_of, select
    from drystone.ties import with_ties

    how = source.how
    friction, density = how.pop("friction", None), how.pop("density", None)
    if (contacts or friction is not None) and joint_allowance is not None:
        raise InputError(
            "blocks with a joint allowance touch nowhere",
            where="--contacts" if contacts else "--friction",
            remedy="leave it out, or write two files",
        )
    supports = how.get("supports")
    chosen = io.registry.writable(target, to)
    _refuse_other_suffix(target, chosen)
    if friction is not None:
        _refuse_lost_friction(chosen, contacts)
    if to_units not in (None, "m") and not chosen.any_unit:
        remedy = "leave it out, or write another format"
        raise InputError(f"{chosen.title} is in m", where="--to-units", remedy=remedy)
    named = same_place(plain_target(target))
    if not overwrite and any(named == same_place(file) for file in source.each):
        raise InputError(
            "the model would be written over itself",
            where=f"'{target}'",
            remedy="name another file, or add --overwrite",
        )
    waiting.stage("read", f"reading {source.name}")
    read = io.read_file(source.place, **how)
    notes = list(read.notes)
    if density is not None:
        read = _with_density(read, density, chosen)
    if supports is not None:
        grounded, fixed = ground_of(read.assembly, supports)
        placed = select(grounded, str(fixed))
        read = replace(read, assembly=placed, results=(), loads=())
    if contacts or joint_allowance is not None or (friction is not None and chosen.name == "mjcf"):
        waiting.stage("detect", "finding contacts")
        made = with_ties(Model.of(read.assembly, friction=friction, anyway=True), read.ties)
        notes += [*made.notes, *([] if made.report is None else warnings_of(made.report))]
        read = replace(read, contacts=made.contacts, results=(), detection=made.detection)
        if joint_allowance is not None:
            from drystone import design

            smaller = design.joint_allowance(made, joint_allowance)
            read = replace(read, assembly=smaller, contacts=None, loads=())
    waiting.stage("write", f"writing {target}")
    units = to_units or (read.units if chosen.any_unit else "m")
    io.write(read, target, format=to, units=units)
    from drystone.answer import Role, Sentence, Statement
    from drystone.supports import own_blocks

    count = int(own_blocks(read.assembly).sum())
    values = {
        "format": chosen.name,
        "blocks": count,
        "fixed": int(read.assembly.fixed.sum()),
        "interfaces": None if read.contacts is None else read.contacts.count,
        "joint_allowance": joint_allowance,
        "loses": chosen.loses,
    }
    told = [Sentence(f"{counted(count, 'block')}, {chosen.title}, in {units}", Role.GOOD)]
    if joint_allowance is not None:
        said = f"joints are open by {1e3 * joint_allowance:g} mm; analyse the model without it"
        told.append(Sentence(said, Role.REMARK))
    told += [Sentence(said, Role.REMARK) for said in left_out(chosen, units, read)]
    found = Statement(tuple(told), values=values)
    return Told(found, subject=source.name, notes=notes, written=[target])


def _with_density(read: Contents, density: float, chosen: Format) -> Contents:
    """What was read with a density of all blocks; refused where it would not be in the file."""
    if "densities" in chosen.loses:
        what, remedy = f"{chosen.title} does not store it", "give it when the model is checked"
        raise InputError(what, where="--density", remedy=remedy)
    if read.loads:
        what, remedy = "the loads of the file hold its weight", "give it when the model is checked"
        raise InputError(what, where="--density", remedy=remedy)
    return replace(read, assembly=read.assembly.with_density(density), results=())


def _refuse_lost_friction(chosen: Format, contacts: bool) -> None:
    """Refuse a friction coefficient that would not be in the file, and no note would say so."""
    if "friction" in chosen.loses or (chosen.name == "drystone" and contacts):
        return
    if chosen.name == "drystone":
        said, remedy = "only contacts have friction", "add --contacts"
    else:
        said, remedy = f"{chosen.title} does not store it", "give it when the model is checked"
    raise InputError(said, where="--friction", remedy=remedy)


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


@command("drystone inspect arch.json", "drystone inspect arch.json --html contacts.html")
def inspect(
    *,
    source: Inspected,
    pictures: Pictures,
    everything: Annotated[bool, Option("List every block.", OUTPUT, ("--all",))] = False,
    waiting: Waiting,
) -> Told:
    """List the blocks of a model, the defects of their meshes and the contacts between them.

    The page and the figure show the contacts, near misses in orange. Exit code 0: every block can
    be used. 2: some cannot.
    """
    from drystone import io  # the program starts fast: work is imported when there is some
    from drystone.detection import find_contacts
    from drystone.io.inspection import Inspection, usable
    from drystone.io.opening import tolerances
    from drystone.model import Model
    from drystone.ties import with_tie_words

    waiting.stage("read", f"reading {source.name}")
    how = source.how
    supports, ties = how.get("supports"), texts(how.pop("tie", ()))
    if "fill" in ties:
        raise InputError("inspect takes no loads", where="tie fill", remedy="ask 'drystone check'")
    options = tolerances(**{name: how.pop(name, None) for name in ("gap", "angle", "edges")})
    built = io.inspect(source.place, **how)
    assembly, notes = usable(built, supports)
    found = None
    if assembly is not None:
        notes += source.uncut(assembly)
        pictures.require_through(assembly)
        waiting.stage("detect", "finding contacts")
        found = find_contacts(assembly, options=options)
        if ties:
            tied = with_tie_words(Model(assembly, found.contacts), ties)
            found = replace(found, contacts=tied.contacts)
            notes += tied.notes
        tried = Model(assembly, found.contacts)
        if supports and (said := on_its_side(tried, source.place, how)):
            notes.append(said)
    answer = Inspection(assembly, found, built, source.name)
    files = partial(pictures.of, answer) if assembly is not None else None
    return Told(answer, notes=notes, files=files, everything=everything)


@command(
    "drystone poses arch.json --block voussoir-03 --html poses.html",
    "drystone poses arch.json --block voussoir-06 --json",
)
def poses(
    *,
    source: Source,
    block: Annotated[
        str | None, Option("Which block of several; the only free one when left out.", MODEL)
    ] = None,
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """Find the poses on a plane in which one block stands, with their shares and tilts.

    The share is how often it ends so when it is put down at random. Exit code 0: it stands. 2: bad
    input.
    """
    from drystone.poses import find_poses  # the program starts fast

    waiting.stage("read", f"reading {source.name}")
    found = find_poses(source.place, block=block, **source.how)
    return Told(found, files=partial(pictures.of, found))
