"""Writing the JSON schema of drystone; see :mod:`drystone.io.drystone_json`."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

from drystone.answer import plain
from drystone.assembly import Block
from drystone.base.errors import FormatError
from drystone.base.files import utf8, write_bytes
from drystone.contacts import Contacts
from drystone.detection import DetectionOptions
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
    write_bytes(path, _text(_content(model, path), path))


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


def _content(model: Contents, path: Path) -> dict[str, Any]:
    """A model as plain values."""
    assembly, contacts = model.assembly, model.contacts
    loads = list(model.loads)
    results = []
    for result in model.results:
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
            name: getattr(result, name).tolist()
            for name in ARRAYS
            if getattr(result, name) is not None
        }
        results.append(_result_content(result, position, arrays))
    return {
        "schema": SCHEMA,
        "version": VERSION,
        "units": "m",
        "blocks": [
            _block_content(block, bool(fixed))
            for block, fixed in zip(assembly.blocks, assembly.fixed, strict=True)
        ],
        "contacts": None if contacts is None else contacts_content(contacts),
        "detection": detection_content(model),
        "ends": model.ends,
        "loads": [_load_content(load) for load in loads] or None,
        "results": results or None,
    }


def detection_content(model: Contents) -> dict[str, Any] | None:
    """The tolerances with which the contacts were searched, where they differ from the defaults."""
    if model.contacts is None or model.detection is None:
        return None
    usual = vars(DetectionOptions())
    return {name: plain(one) for name, one in vars(model.detection).items() if one != usual[name]}


def contacts_content(contacts: Contacts, decimals: int | None = None) -> dict[str, Any]:
    """Contacts as plain values, rounded where so many ``decimals`` are enough."""
    content = {name: getattr(contacts, name) for name in CONTACTS}
    if contacts.capacity is not None:
        content |= {name: getattr(contacts.capacity, name) for name in DRY}
    if decimals is not None:
        content = {name: values.round(decimals) for name, values in content.items()}
    law = {} if contacts.capacity is None else {"brittle": contacts.capacity.brittle}
    return {name: values.tolist() for name, values in content.items()} | law


def _load_content(load: LoadCase) -> dict[str, Any]:
    content: dict[str, Any] = {"name": load.name, "wrench": load.wrench.tolist()}
    there = {
        "motion": load.motion is not None,
        "acceleration": load.acceleration.any(),
        "shake": load.shake.any(),
        "given": load.given is not None,
    }
    content |= {name: getattr(load, name).tolist() for name, some in there.items() if some}
    if load.masses:
        content["masses"] = [
            {name: plain.tolist() if name != "kind" else plain for name, plain in vars(one).items()}
            for one in load.masses
        ]
    if load.surface is not None:
        content["surface"] = {key: values.tolist() for key, values in vars(load.surface).items()}
    return content


def _block_content(block: Block, fixed: bool) -> dict[str, Any]:
    content: dict[str, Any] = {
        "name": block.name,
        "fixed": fixed,
        "density": block.density,
        "vertices": block.vertices.tolist(),
        "faces": block.faces,
    }
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
        "tilt_about": result.tilt_about,
        "crushing_factor": result.crushing_factor,
        "sensitive_to": [one.name.lower() for one in result.sensitive_to],
        "stopped": result.stopped,
        "options": plain(result.options),
        "solver": result.solver,
        "iterations": result.iterations,
        "time_s": dict(result.time_s),
    }


def _dumps(value: Any, path: Path) -> str:
    try:
        return json.dumps(value, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise FormatError(
            f"something in the model is no JSON value: {error}",
            where=str(path),
            remedy="keep metadata to text, finite numbers, lists and objects",
        ) from error
