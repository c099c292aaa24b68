"""Options that belong together: declared once, taken by many commands."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from typing import TYPE_CHECKING, Any, get_type_hints

from drystone.cli import joint_files, loading, options, verdict
from drystone.cli.session import prepare
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.model import Model


@dataclass(frozen=True)
class Subject:
    """The model that is analysed, its supports and materials, and its loads but for earthquakes."""

    model: options.ModelArgument
    supports: options.Supports = None
    friction: options.Friction = None
    density: options.Density = None
    units: options.Units = None
    gravity: options.Gravity = None
    loads: loading.Loads = None
    cases: loading.Cases = None

    def prepared(self, waiting: Waiting, finding: Finding | None = None, **more: Any) -> Model:
        """See :func:`drystone.cli.session.prepare`; ``more`` are its other arguments."""
        given = _values(self) | ({} if finding is None else _values(finding))
        return prepare(given.pop("model"), waiting, **given, **more)


@dataclass(frozen=True)
class Finding:
    """How the contacts of a model are found."""

    gap: options.Gap = None
    angle: options.Angle = None
    edges: options.Edges = None
    find_contacts: options.FindContacts = False
    split: options.Split = False
    anyway: options.Anyway = False


@dataclass(frozen=True)
class Written:
    """The files that tell an answer."""

    html: options.Html = None
    png: options.Png = None
    joints: joint_files.Joints = None
    strength: joint_files.Strength = None

    def checked(self) -> tuple[verdict.Files, joint_files.JointFiles]:
        """Pictures and tables; refused before the work begins when they cannot be written."""
        files = verdict.Files.checked(self.html, self.png)
        tables = joint_files.checked(self.joints, self.strength)
        options.apart([*files.written(), *tables.named()])
        return files, tables


def expanded(command: Callable[..., int]) -> Callable[..., int]:
    """The command with an option for each field of every group that it takes.

    A group is a parameter whose type is a dataclass of options. Its options come where it stands;
    what must be given comes first, that of groups before the command's own.
    """
    hints = get_type_hints(command, include_extras=True)
    groups: dict[str, type[Any]] = {}
    must: list[inspect.Parameter] = []
    own: list[inspect.Parameter] = []
    can: list[inspect.Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        if is_dataclass(hints[name]):
            groups[name] = hints[name]
            members = _options(hints[name])
            must += [one for one in members if one.default is one.empty]
            can += [one for one in members if one.default is not one.empty]
        else:
            (own if parameter.default is parameter.empty else can).append(
                parameter.replace(annotation=hints[name])
            )

    def run(**given: Any) -> int:
        made = {
            name: kind(**{each.name: given.pop(each.name) for each in fields(kind)})
            for name, kind in groups.items()
        }
        return command(**made, **given)

    parameters = [one.replace(kind=one.KEYWORD_ONLY) for one in (*must, *own, *can)]
    run.__name__, run.__doc__ = command.__name__, command.__doc__
    run.__annotations__ = {one.name: one.annotation for one in parameters}
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]  # PEP 362
    return run


def _values(group: Any) -> dict[str, Any]:
    return {each.name: getattr(group, each.name) for each in fields(group)}


def _options(group: type[Any]) -> list[inspect.Parameter]:
    """A parameter for each field of a dataclass."""
    types = get_type_hints(group, include_extras=True)
    return [
        one.replace(annotation=types[one.name])
        for one in inspect.signature(group).parameters.values()
    ]


__all__ = ["Finding", "Subject", "Written", "expanded"]
