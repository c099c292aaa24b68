"""Pages written from the program: every public name, every command with its options."""

import enum
import inspect
import textwrap
from importlib import import_module
from pathlib import Path

import click

from drystone.cli.application import app

ROOMS = {
    "drystone": "What most people need",
    "drystone.limits": "Limits",
    "drystone.design": "Design",
    "drystone.sequence": "Assembly planning",
    "drystone.shells": "Shells",
    "drystone.models": "Model families",
    "drystone.detection": "Contacts",
    "drystone.stability": "Analyses",
    "drystone.io": "Files",
    "drystone.view": "Pictures",
    "drystone.reproduce": "The source's studies",
    "drystone.compat.compas_cra": "The functions of compas_cra",
}
"""Public modules and their headings; a name is listed once, in the first that has it."""


def public(module: str, seen: set[int]) -> list[str]:
    """Public names of a module that no module before it has."""
    room, names = import_module(module), []
    for name in getattr(room, "__all__", ()):
        value = getattr(room, name)
        if not inspect.ismodule(value) and id(value) not in seen:
            seen.add(id(value))
            names.append(name)
    return names


def entry(module: str, name: str) -> str:
    """The directive of one name."""
    value = getattr(import_module(module), name)
    if inspect.isclass(value):
        kind = "autoexception" if issubclass(value, BaseException) else "autoclass"
        options = "   :members:\n"
        if issubclass(value, enum.Enum):
            options += "   :undoc-members:\n"
        return f".. {kind}:: {module}.{name}\n{options}"
    if callable(value):
        return f".. autofunction:: {module}.{name}\n"
    return f".. py:data:: {module}.{name}\n\n   ``{value!r}``\n"


def titled(title: str, underline: str = "=") -> str:
    """A heading."""
    return f"{title}\n{underline * len(title)}\n\n"


def api(folder: Path) -> list[str]:
    """One page for each public module."""
    seen: set[int] = set()
    for module, title in ROOMS.items():
        text = titled(title) + f"``import {module}``\n\n"
        text += "\n".join(entry(module, name) for name in sorted(public(module, seen)))
        (folder / f"{module}.rst").write_text(text, "utf-8")
    return [*ROOMS]


def commands(folder: Path) -> None:
    """One page with the help of every command, as ``--help-all`` prints it."""
    text = titled("Commands and their options")
    for words, command in every(app, "drystone"):
        context = click.Context(command, info_name=words)
        context.meta["drystone.everything"] = True
        told = textwrap.indent(command.get_help(context), "   ")
        text += f"{titled(words, '-')}::\n\n{told}\n\n"
    (folder / "commands.rst").write_text(text, "utf-8")


def every(group: click.Group, words: str) -> list[tuple[str, click.Command]]:
    """Every command of a group and of the groups in it, with its words."""
    found: list[tuple[str, click.Command]] = []
    for name, one in sorted(group.commands.items()):
        here = f"{words} {name}"
        found += every(one, here) if isinstance(one, click.Group) else [(here, one)]
    return found


def write_reference(folder: Path) -> None:
    """Write all of it."""
    folder.mkdir(exist_ok=True)
    pages = api(folder)
    commands(folder)
    listed = "\n".join(f"   {page}" for page in pages)
    (folder / "index.rst").write_text(
        titled("Reference") + f".. toctree::\n   :maxdepth: 1\n\n   commands\n{listed}\n", "utf-8"
    )
