"""A model from the arguments of a client."""

from __future__ import annotations

import contextlib
import json
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from drystone.assembly import Assembly
from drystone.base.errors import InputError
from drystone.io import read
from drystone.io.jsontext import Field
from drystone.io.own.load_parts import load_of_parts
from drystone.loads import LoadCase
from drystone.mcp.folder import Folder
from drystone.model import Model
from drystone.supports import require_supports


@contextlib.contextmanager
def opened(subject: Mapping[str, Any], folder: Folder) -> Iterator[Path]:
    """The file of a model; errors have the name that the client gave.

    A model that is given as an object is written to a temporary file.

    Raises
    ------
    InputError
        Neither or both are given, the model is too large, or see :meth:`Folder.model`.
    """
    name, content = subject.get("file"), subject.get("content")
    if (name is None) == (content is None):
        raise InputError("names no model", where="model", remedy="give either file or content")
    if name is not None:
        folder.model(name)
        with contextlib.chdir(folder.path):
            yield Path(name)
        return
    text = json.dumps(content)
    folder.accept(len(text), "content")
    with tempfile.TemporaryDirectory() as place, contextlib.chdir(place):
        Path("content.json").write_text(text, "utf-8")
        yield Path("content.json")


def model_of(subject: Mapping[str, Any], folder: Folder) -> Model:
    """The model with its supports, materials and loads.

    Raises
    ------
    InputError
        Something in it cannot be used, or no block is fixed, or ``supports`` fixes all.
    """
    gravity = subject.get("gravity")
    if isinstance(gravity, int | float):
        gravity = (0.0, 0.0, -gravity)
    with opened(subject, folder) as path:
        model = read(
            path,
            supports=subject.get("supports"),
            friction=subject.get("friction"),
            density=subject.get("density"),
            units=subject.get("units"),
            load=gravity,
        )
    chosen = subject.get("supports") is not None
    require_supports(model.assembly, model.joints, chosen=chosen)
    extra = subject.get("loads")
    return replace(model, load=model.load + load_of(extra, model.assembly)) if extra else model


def load_of(parts: Any, assembly: Assembly) -> LoadCase:
    """A load case from its parts, as in our JSON.

    Raises
    ------
    InputError
        With the place of what is wrong.
    """
    return load_of_parts(Field(parts, "", Path("loads")), assembly, "loads")
