"""Answers about stages on disk, from which an interrupted plan continues."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from drystone.base.files import PathLike
from drystone.base.journal import Journal, exactly
from drystone.base.version import version
from drystone.io.opening import content_of
from drystone.results import Verdict
from drystone.sequence.stages import Stage, StageAnswer, StagedModel

FORMAT = "drystone-stages"


def fingerprint(model: StagedModel) -> str:
    """Hash of a model: geometry, contacts and what they carry, load, and the check."""
    told = content_of(replace(model.model, cases=())) + exactly(model.check)
    return hashlib.sha256(told.encode()).hexdigest()


class Checkpoint:
    """Answers about stages in a journal.

    Raises
    ------
    FormatError
        It belongs to another model, check or version, is damaged, or cannot be read or written.
    """

    def __init__(self, path: PathLike, model: StagedModel) -> None:
        about = {"format": FORMAT, "version": version(), "model": fingerprint(model)}
        self._journal = Journal(path, about, partial(_known, len(model.assembly)))
        self.known = dict(self._journal.records)

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


def _known(blocks: int, record: Any) -> tuple[Stage, StageAnswer]:
    """A stage of a model of so many blocks, and its answer."""
    placed, held = (int(record[name], 16) for name in ("placed", "held"))
    falling = tuple(map(int, record["falling"]))
    reaction = {int(b): np.array(one, dtype=np.float64) for b, one in record["reaction"].items()}
    if not 0 <= held <= placed < 2**blocks or {*falling, *reaction} - {*range(blocks)}:
        raise LookupError("it has other blocks")
    if any(one.shape != (6,) for one in reaction.values()):
        raise ValueError("a reaction has six numbers")
    message, settled, used = str(record["message"]), str(record["settled"]), float(record["used"])
    answer = StageAnswer(
        Verdict[record["verdict"]], message, falling, reaction, used, settled=settled
    )
    return Stage(placed, held, bool(record["quick"])), answer


__all__ = ["Checkpoint"]
