"""Pages written from the program: every public name, every command with its options."""

import enum
import inspect
import re
import textwrap
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import click

import drystone
from drystone.cli.application import app

ROOMS = {
    "What most people need": ("drystone",),
    "Limits": ("drystone.limits",),
    "Combinations": ("drystone.studies",),
    "Masonry in earthquakes": ("drystone.seismic",),
    "Design": ("drystone.design",),
    "Assembly planning": ("drystone.sequence",),
    "Shells": ("drystone.shells",),
    "Model families": ("drystone.models",),
    "Contacts": ("drystone.detection",),
    "Answers": ("drystone.answer",),
    "Analyses": ("drystone.stability", "drystone.programs", "drystone.results"),
    "Settlement and large displacement": ("drystone.settlement",),
    "Films of a fall": ("drystone.fall",),
    "Resting poses": ("drystone.poses",),
    "Forces in joints": ("drystone.joints", "drystone.virtual"),
    "Files": ("drystone.io",),
    "Pictures": ("drystone.view",),
    "Reports": ("drystone.report",),
    "Blocks, loads and repairs": (
        "drystone.assembly",
        "drystone.loads",
        "drystone.joint_capacity",
        "drystone.repair",
        "drystone.model",
    ),
    "The source's studies": ("drystone.reproduce",),
    "Objects and functions of COMPAS": ("drystone.compat", "drystone.compat.compas_cra"),
    "The live page": ("drystone.live",),
}
"""Headings and their public modules; a name is listed once, in the first module that has it."""


def public(module: str, seen: set[int]) -> list[str]:
    """Public names of a module that no module before it has."""
    room, names = import_module(module), []
    for name in listed(module):
        value = getattr(room, name)
        if not inspect.ismodule(value) and id(value) not in seen:
            seen.add(id(value))
            names.append(name)
    return names


def parts(value: type) -> list[type]:
    """Values without a public name of which a class is made: what they have is told with it."""
    named = {name for modules in ROOMS.values() for m in modules for name in listed(m)}
    return [
        base
        for base in value.__mro__[1:]
        if base.__module__.startswith("drystone.")
        and "__dataclass_fields__" in vars(base)
        and base.__name__ not in named
    ]


def listed(module: str) -> tuple[str, ...]:
    """The public names of a module."""
    return tuple(getattr(import_module(module), "__all__", ()))


def entry(module: str, name: str) -> str:
    """The directive of one name."""
    value = getattr(import_module(module), name)
    examples = f"\n.. minigallery:: {module}.{name}\n"
    if inspect.isclass(value):
        kind = "autoexception" if issubclass(value, BaseException) else "autoclass"
        options = "   :members:\n"
        if own := parts(value):
            others = ", ".join(base.__name__ for base in value.__mro__[1:] if base not in own)
            options += f"   :inherited-members: {others}\n"
        if issubclass(value, enum.Enum):
            options += "   :undoc-members:\n"
        return f".. {kind}:: {module}.{name}\n{options}{examples}"
    if inspect.isroutine(value):
        return f".. autofunction:: {module}.{name}\n{examples}"
    told = ", ".join(map(str, value)) if isinstance(value, dict) else repr(value)
    return f".. py:data:: {module}.{name}\n\n   ``{told}``\n"


def elsewhere(module: str, names: set[str]) -> list[str]:
    """References to public names of a module that are listed with an earlier one."""
    earlier = sorted(set(listed(module)) - names)
    room = import_module(module)
    kinds = {
        name: "class" if inspect.isclass(getattr(room, name)) else "func"
        for name in earlier
        if callable(getattr(room, name))
    }
    return [f":{kind}:`drystone.{name}`" for name, kind in kinds.items() if hasattr(drystone, name)]


def titled(title: str, underline: str = "=") -> str:
    """A heading."""
    return f"{title}\n{underline * len(title)}\n\n"


SHARED = {
    "given": "A model; or an assembly or a file that ``how`` turns into one.",
    "check": "A function that gives the verdict on a model; that of drystone when left out.",
    "how": "How a model is made of an assembly or a file: the keywords of :func:`drystone.read`.",
}
"""Parameters of many functions, where a function says nothing of them."""


def linked(kind: object, called: Callable[..., Any]) -> str:
    """An annotation of a function, with links to the classes of drystone in it."""

    def link(match: re.Match[str]) -> str:
        one = getattr(drystone, match[0], None) or called.__globals__.get(match[0])
        ours = inspect.isclass(one) and one.__module__.startswith("drystone.")
        return f":class:`{match[0]}`" if ours else match[0]

    return re.sub(r"[A-Z]\w+", link, str(kind))


def by_type(name: str, called: Callable[..., Any]) -> str | None:
    """What a parameter is, where its name and its type say all: None where they do not."""
    one = inspect.signature(called).parameters.get(name)
    kind = "" if one is None else str(one.annotation)
    if choices := re.search(r"Literal\[(.*?)\]", kind):
        return "One of " + ", ".join(f"``{one.strip()}``" for one in choices[1].split(","))
    classes = re.findall(":class:`.*?`", linked(kind, called))
    return f"See {' or '.join(classes)}." if classes else None


def section(lines: Sequence[str]) -> tuple[int, int]:
    """The first line of the parameters in a documentation, and the first one behind them."""
    begin = lines.index("Parameters") + 2
    rules = (i for i, line in enumerate(lines) if i > begin and re.fullmatch("-{3,}", line))
    return begin, next(rules, len(lines) + 1) - 1


def described(called: Callable[..., Any], lines: Sequence[str]) -> dict[tuple[str, ...], list[str]]:
    """Lines of a documentation by the parameters that they describe, in the order of the function.

    What is not described is what all functions say, or what its type says.
    """
    begin, end = section(lines)
    entries: dict[tuple[str, ...], list[str]] = {}
    for line in filter(None, lines[begin:end]):
        if line[0] != " ":
            head = line.partition(" : ")[0].split(",")
            entry = entries[tuple(one.strip(" *") for one in head)] = []
        entry.append(line)
    order = [*inspect.signature(called).parameters]
    told = {name for names in entries for name in names}
    entries |= {(one,): [one] for one in order if one in SHARED and one not in told}
    for (name, *others), entry in entries.items():
        said = SHARED.get(name) or by_type(name, inspect.unwrap(called))
        if said and not others and entry == [name]:
            entry.append(f"    {said}")
    place = {name: at for at, name in enumerate(order)}
    ordered = sorted(entries, key=lambda names: place.get(names[0], len(place)))
    return {names: entries[names] for names in ordered}


def api(folder: Path) -> list[str]:
    """One page for each heading."""
    seen: set[int] = set()
    pages = []
    for title, modules in ROOMS.items():
        text = titled(title)
        for module in modules:
            names = sorted(public(module, seen))
            text += f"``import {module}``\n\n" if names else ""
            others = elsewhere(module, set(names)) if module != "drystone" else []
            text += f"Here too: {', '.join(others)}.\n\n" if others else ""
            text += "\n".join(entry(module, name) for name in names) + "\n"
        pages.append(modules[0])
        (folder / f"{modules[0]}.rst").write_text(text, "utf-8")
    return pages


def commands(folder: Path) -> None:
    """One page with the help of every command, as ``--help-all`` prints it."""
    text = titled("Commands and their options")
    for words, command in every(app, "drystone"):
        context = click.Context(command, info_name=words)
        context.meta["drystone.everything"] = True
        told = textwrap.indent(command.get_help(context), "   ")
        text += f"{titled(words, '-')}.. code-block:: text\n\n{told}\n\n"
    (folder / "commands.rst").write_text(text, "utf-8")


def every(group: click.Group, words: str) -> list[tuple[str, click.Command]]:
    """Every command of a group and of the groups in it, with its words."""
    found: list[tuple[str, click.Command]] = []
    context = click.Context(group)
    for name in group.list_commands(context):
        one, here = group.get_command(context, name), f"{words} {name}"
        assert one is not None
        found += every(one, here) if isinstance(one, click.Group) else [(here, one)]
    return found


def write_reference(folder: Path) -> None:
    """Write all of it."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.rst"):
        old.unlink()
    pages = api(folder)
    commands(folder)
    entries = "\n".join(f"   {page}" for page in pages)
    (folder / "index.rst").write_text(
        titled("Functions and commands")
        + f".. toctree::\n   :maxdepth: 1\n\n   commands\n{entries}\n",
        "utf-8",
    )
