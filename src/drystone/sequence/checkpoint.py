"""Answers about stages on disk, from which an interrupted plan continues."""

from __future__ import annotations

import functools
import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from drystone.base.errors import FormatError
from drystone.base.files import read_bytes, write_bytes
from drystone.results import Verdict
from drystone.sequence.stages import Stage, StageAnswer
from drystone.sequence.structure import Structure

FORMAT, VERSION = "drystone-stages", 5


def _fingerprint(model: Structure) -> str:
    """Hash of a model: geometry, contacts, friction, load, and the check."""
    digest = hashlib.sha256()
    contacts, assembly = model.contacts, model.assembly
    for array in (
        assembly.fixed, assembly.centroid, assembly.mass, contacts.block_a, contacts.block_b,
        contacts.frame, contacts.friction, contacts.point, contacts.interface, model.load.wrench,
    ):  # fmt: skip
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(_named(model.check).encode())
    return digest.hexdigest()


def _named(check: Any) -> str:
    """A name of a check function that is the same in the next run."""
    if isinstance(check, functools.partial):
        return f"{_named(check.func)}{check.args}{sorted(check.keywords.items())}"
    return str(getattr(check, "__qualname__", type(check).__qualname__))


def write_checkpoint(path: Path, model: Structure, known: dict[Stage, StageAnswer]) -> None:
    """Write answers without their forces as JSON, to a temporary file that is renamed."""
    data = {
        "format": FORMAT,
        "version": VERSION,
        "model": _fingerprint(model),
        "parts": [
            {
                "placed": f"{part.placed:x}",
                "held": f"{part.held:x}",
                "quick": part.quick,
                "verdict": found.verdict.name,
                "message": found.message,
                "falling": list(found.falling),
                "reaction": {str(b): wrench.tolist() for b, wrench in found.reaction.items()},
                "used": found.used,
                "settled": found.settled,
            }
            for part, found in known.items()
        ],
    }
    write_bytes(path, json.dumps(data).encode("ascii"))


def read_checkpoint(path: Path, model: Structure) -> dict[Stage, StageAnswer]:
    """The answers in a checkpoint.

    Raises
    ------
    FormatError
        It cannot be read, or belongs to another model.
    """
    try:
        data = json.loads(read_bytes(path))
        if data["format"] != FORMAT or data["version"] != VERSION:
            raise FormatError("is no checkpoint of this version", where=str(path))
        if data["model"] != _fingerprint(model):
            raise FormatError(
                "the checkpoint belongs to another model",
                where=str(path),
                remedy="name another file, or remove this one",
            )
        return {_stage(one): _answer(one) for one in data["parts"]}
    except FormatError:
        raise
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise FormatError(
            "the checkpoint cannot be read", where=str(path), remedy="remove it to start anew"
        ) from error


def _stage(record: Any) -> Stage:
    return Stage(int(record["placed"], 16), int(record["held"], 16), bool(record["quick"]))


def _answer(record: Any) -> StageAnswer:
    return StageAnswer(
        Verdict[record["verdict"]],
        str(record["message"]),
        tuple(int(b) for b in record["falling"]),
        {int(b): np.array(wrench, dtype=np.float64) for b, wrench in record["reaction"].items()},
        float(record["used"]),
        settled=str(record["settled"]),
    )


__all__ = ["read_checkpoint", "write_checkpoint"]
