"""The scene of every value that has a picture."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

from drystone.answer import Answer
from drystone.answer.drawing import bare_scene, scene_of_blocks
from drystone.answer.scene import Scene, with_version
from drystone.assembly import Assembly
from drystone.base.errors import InputError, quoted
from drystone.contacts import Contacts
from drystone.model import Model

Subject: TypeAlias = Answer | Model | Assembly | Scene


def scene_of(subject: Subject, contacts: Contacts | None = None) -> Scene:
    """The scene of a model or of an answer, or the scene itself.

    Parameters
    ----------
    subject
        A scene, or an answer, a model or an assembly that is drawn.
    contacts
        Of an assembly; everything else has its own.

    Raises
    ------
    InputError
        Contacts were given that are not those of the result, or that name other blocks; or there
        is no picture of such a value.
    """
    if isinstance(subject, Assembly):
        return scene_of_blocks(subject, contacts)
    own = getattr(subject, "contacts", None)
    if contacts is not None and contacts is not own:
        raise InputError(
            "contacts other than those of the result", remedy="leave them out: a result has its own"
        )
    match subject:
        case Scene():
            return subject
        case Answer():
            return replace(subject.layers(), made=with_version(subject.when))
        case Model():
            return bare_scene(subject)
        case _:
            raise InputError(
                f"there is no picture of {quoted(subject)}",
                remedy="give a model, an assembly, a result, a limit, a plan or a settlement",
            )
