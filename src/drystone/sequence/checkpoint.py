"""Answers about stages on disk, from which an interrupted plan continues."""

from __future__ import annotations

import functools
import hashlib
from typing import Any

import numpy as np

from drystone.base.errors import FormatError
from drystone.base.files import PathLike
from drystone.base.journal import Journal
from drystone.base.version import version
from drystone.results import Verdict
from drystone.sequence.stages import Stage, StageAnswer
from drystone.sequence.structure import Structure

FORMAT = "drystone-stages"


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


class Checkpoint:
    """Answers about stages in a journal.

    Raises
    ------
    FormatError
        It belongs to another model, check or version, is damaged, or cannot be read or written.
    """

    def __init__(self, path: PathLike, model: Structure) -> None:
        about = {"format": FORMAT, "version": version(), "model": _fingerprint(model)}
        self._journal = Journal(path, about)
        try:
            self.known = {_stage(one): _answer(one) for one in self._journal.records}
        except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
            raise FormatError(
                "the checkpoint has a record that is no answer",
                where=str(self._journal.path),
                remedy="remove it to start anew",
            ) from error

    def add(self, part: Stage, found: StageAnswer) -> None:
        """Write an answer without its forces."""
        record = {
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
        self._journal.add([record])


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


__all__ = ["Checkpoint"]
