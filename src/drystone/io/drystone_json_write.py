"""Writing the JSON schema of drystone; see :mod:`drystone.io.drystone_json`."""

from __future__ import annotations

import dataclasses
import enum
import json
import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drystone.assembly import Block
from drystone.base.errors import FormatError
from drystone.base.files import utf8, write_bytes, write_together
from drystone.contacts import Contacts
from drystone.io import npz
from drystone.io.draft import Contents
from drystone.io.drystone_json import ARRAYS, CONTACTS, SCHEMA, VERSION
from drystone.joint_capacity import DRY
from drystone.loads import LoadCase
from drystone.results import Result


def write(model: Contents, path: Path) -> None:
    """Write a model with all its data to one file.

    Raises
    ------
    FormatError
        A result belongs to other contacts, or metadata is not made of JSON values.
    """
    write_bytes(path, _text(_content(model, path, None), path))


def write_beside(model: Contents, path: Path) -> None:
    """Write a model with all its data, the arrays to an npz file with the same name.

    Raises
    ------
    FormatError
        As :func:`write`.
    """
    packer = npz.Packer()
    content = _content(model, path, packer)
    data = packer.data()
    beside = path.with_suffix(".npz")
    content["arrays"] = {"file": beside.name, "sha256": npz.digest(data)}
    text = _text(content, path)
    write_together(
        [(beside, partial(write_bytes, data=data)), (path, partial(write_bytes, data=text))]
    )


def _text(content: dict[str, Any], path: Path) -> bytes:
    """JSON with a line for each block."""
    parts = []
    for key, value in content.items():
        if key == "blocks":
            blocks = ",\n  ".join(_dumps(block, path) for block in value)
            parts.append(f'"blocks": [\n  {blocks}\n ]')
        elif value is not None:
            parts.append(f'"{key}": {_dumps(value, path)}')
    return utf8("{\n " + ",\n ".join(parts) + "\n}\n")


def _content(model: Contents, path: Path, packer: npz.Packer | None) -> dict[str, Any]:
    """A model as plain values; its arrays as nested lists, or in the packer."""

    def array(key: str, values: NDArray[Any]) -> Any:
        return values.tolist() if packer is None else packer.put(key, values)

    assembly, contacts = model.assembly, model.contacts
    loads = list(model.loads)
    results = []
    for number, result in enumerate(model.results):
        if result.assembly is not assembly or result.contacts is not contacts:
            raise FormatError(
                "a result belongs to another assembly or to other contacts",
                where=str(path),
                remedy="write it to a file of its own",
            )
        if not any(load is result.load for load in loads):
            loads.append(result.load)
        position = next(i for i, load in enumerate(loads) if load is result.load)
        arrays = {
            name: array(f"result-{number}-{name}", getattr(result, name))
            for name in ARRAYS
            if getattr(result, name) is not None
        }
        results.append(_result_content(result, position, arrays))
    return {
        "schema": SCHEMA,
        "version": VERSION,
        "units": "m",
        "arrays": None,
        "blocks": [
            _block_content(block, bool(fixed), packer)
            for block, fixed in zip(assembly.blocks, assembly.fixed, strict=True)
        ],
        "contacts": None if contacts is None else contacts_content(contacts, array),
        "loads": [_load_content(load, number, array) for number, load in enumerate(loads)] or None,
        "results": results or None,
    }


def contacts_content(
    contacts: Contacts, array: Callable[[str, NDArray[Any]], Any]
) -> dict[str, Any]:
    """Contacts as plain values; ``array`` says what stands for an array of a name."""
    content = {name: array(name, getattr(contacts, name)) for name in CONTACTS}
    if contacts.capacity is not None:
        content |= {name: array(name, getattr(contacts.capacity, name)) for name in DRY}
    return content


def _load_content(
    load: LoadCase, number: int, array: Callable[[str, NDArray[Any]], Any]
) -> dict[str, Any]:
    content = {"name": load.name, "wrench": array(f"load-{number}", load.wrench)}
    if load.motion is not None:
        content["motion"] = array(f"load-{number}-motion", load.motion)
    return content


def _block_content(block: Block, fixed: bool, packer: npz.Packer | None) -> dict[str, Any]:
    content: dict[str, Any] = {"name": block.name, "fixed": fixed, "density": block.density}
    if packer is None:
        content |= {"vertices": block.vertices.tolist(), "faces": block.faces}
    else:
        corners = np.array([corner for face in block.faces for corner in face], dtype=np.int64)
        lengths = [len(face) for face in block.faces]
        content["vertices"] = packer.append("vertices", block.vertices)
        content["faces"] = packer.append("corners", corners) | {"lengths": lengths}
    if block.metadata:
        content["metadata"] = dict(block.metadata)
    if block.repairs:
        content["repairs"] = block.repairs
    return content


def _result_content(result: Result, load: int, arrays: dict[str, Any]) -> dict[str, Any]:
    return {
        "method": result.method,
        "verdict": result.verdict.value,
        "message": result.message,
        "load": load,
        **arrays,
        "falling": list(result.falling),
        "samples": dataclasses.asdict(result.samples),
        "residuals": None if result.residuals is None else dataclasses.asdict(result.residuals),
        "eta": result.eta,
        "tilt_margin": result.tilt_margin,
        "sensitive_to": [one.name.lower() for one in result.sensitive_to],
        "stopped": result.stopped,
        "options": _plain(result.options),
        "solver": result.solver,
        "iterations": result.iterations,
        "time_s": dict(result.time_s),
    }


def _plain(value: Any) -> Any:
    """Options as JSON values: a frozen dataclass becomes an object, an enum its value."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: _plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, enum.Enum):
        return _plain(value.value)
    if isinstance(value, dict):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if value is None or isinstance(value, str | bool | int | float):
        return value
    return repr(value)


def _dumps(value: Any, path: Path) -> str:
    try:
        return json.dumps(value, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise FormatError(
            f"something in the model is no JSON value: {error}",
            where=str(path),
            remedy="keep metadata to text, finite numbers, lists and objects",
        ) from error
