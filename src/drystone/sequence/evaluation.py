"""Checks of many stages: cached by part, on any executor, resumed from a checkpoint."""

from __future__ import annotations

import functools
import logging
import pickle
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future
from dataclasses import replace

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import DrystoneError
from drystone.base.files import PathLike, as_path
from drystone.base.progress import Stopped
from drystone.base.workers import LOST_WORKER, ExecutorFactory
from drystone.sequence.checkpoint import read_checkpoint, write_checkpoint
from drystone.sequence.solving import PartSolver, combined
from drystone.sequence.stages import Check, Stage, StageAnswer, members
from drystone.sequence.structure import Structure
from drystone.stability.attempts import Candidate

SAVE_EVERY_S = 10.0
"""Time between two writes of the checkpoint: an interruption loses at most this."""
REVIVALS = 5
"""Number of restarts of workers before the work continues in this process. If workers fail more
often, the work itself is the probable cause."""

_log = logging.getLogger(__name__)


class Evaluator(OneLine):
    """Answers about stages of one model.

    Parameters
    ----------
    model
    executor
        An executor, or a function that starts one; without it, the work is done in this process. An
        executor started by the function is shut down at the end; a given one is not.
    checkpoint
        File for all answers; if it exists and belongs to this model, the work continues from it.
    late
        Called before parts are checked; True ends the work.

    Attributes
    ----------
    solved
        Number of parts that were checked, without cached ones.
    asked
        Number of parts that were needed for the first time. It does not depend on the workers or
        the checkpoint.
    solve_s
        Time spent on them, seen from this process.

    Raises
    ------
    FormatError
        The checkpoint belongs to another model, or cannot be read.
    """

    def __init__(
        self,
        model: Structure,
        *,
        executor: Executor | ExecutorFactory | None = None,
        checkpoint: PathLike | None = None,
        late: Callable[[], bool] = bool,
    ) -> None:
        self.model = model
        self.solver = PartSolver(model)
        self.late = late
        self.solved = 0
        self.asked = 0
        self.solve_s = 0.0
        self._known: dict[Stage, StageAnswer] = {}
        self._ahead: dict[Stage, StageAnswer] = {}
        self._kept: dict[Stage, StageAnswer] = {}
        self._factory = None if isinstance(executor, Executor) else executor
        self._executor = executor if isinstance(executor, Executor) else None
        self._revivals = 0
        self._file = None if checkpoint is None else as_path(checkpoint)
        self._saved = time.monotonic()
        if self._file is not None and self._file.exists():
            self._kept = read_checkpoint(self._file, model)

    def _summary(self) -> str:
        return f"{self.model!r}, {self.solved} parts checked"

    @functools.cached_property
    def _payload(self) -> bytes:
        return pickle.dumps(self.solver)

    @property
    def batch(self) -> int:
        """Number of stages to request at once."""
        if self._executor is None and self._factory is None:
            return 1
        return int(getattr(self._start(), "_max_workers", None) or 2)

    def __enter__(self) -> Evaluator:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.save()
        if self._factory is not None and self._executor is not None:
            self._executor.shutdown(wait=kind is None, cancel_futures=True)
            self._executor = None

    def answer(self, stage: Stage, *, forces: bool = False, checked: bool = False) -> StageAnswer:
        """The answer of a stage; see :meth:`answers`."""
        return self.answers([stage], forces=forces, checked=checked)[0]

    def answers(
        self,
        stages: Sequence[Stage],
        *,
        ahead: Sequence[Stage] = (),
        forces: bool = False,
        checked: bool = False,
    ) -> list[StageAnswer]:
        """The answers of several stages.

        Parameters
        ----------
        stages
        ahead
            Stages that are likely to be requested next. Their results are stored separately until
            then, so no answer depends on the number of workers.
        forces
            Whether to check again if the forces were not kept.
        checked
            Whether to check stages that were only looked at.

        Raises
        ------
        Stopped
            The time limit is reached; earlier results are kept. The first stage is always checked.
        """
        parts = [self.model.parts(stage) for stage in stages]
        missing = []
        for part in dict.fromkeys(part for some in parts for part in some):
            if not self._has(part, forces, checked):
                self.asked += 1
                key = part._replace(near=None)
                if part in self._ahead:
                    self._known[key] = self._ahead.pop(part)
                elif key in self._kept and not (forces and self._kept[key].stands):
                    self._known[key] = self._kept[key]
                else:
                    missing.append(part)
        if missing and self._known and self.late():
            raise Stopped
        if missing:
            began = time.perf_counter()
            further = dict.fromkeys(part for stage in ahead for part in self.model.parts(stage))
            for part in missing:
                further.pop(part, None)
            new = [
                p
                for p in further
                if p not in self._ahead
                and p._replace(near=None) not in self._kept
                and self._find(p) is None
            ]
            for number, (part, found) in enumerate(self._solve([*missing, *new])):
                if number < len(missing):
                    self._known[part._replace(near=None)] = found
                else:
                    self._ahead[part] = found
                self.solved += 1
                if time.monotonic() - self._saved > SAVE_EVERY_S:
                    self.save()
            self.solve_s += time.perf_counter() - began
        return [
            combined(
                self.model, stage, [one for part in some if (one := self._find(part)) is not None]
            )
            for stage, some in zip(stages, parts, strict=True)
        ]

    def settled(self, stage: Stage, check: Check) -> StageAnswer:
        """A stage by another check, which is kept where it stands."""
        other = PartSolver(replace(self.model, check=check))
        for part in self.model.parts(stage):
            if not self.answer(part).stands:
                found = other.solve(part)
                self.solved += 1
                if not found.stands:
                    return found
                self._known[part] = found
        return self.answer(stage)

    def save(self) -> None:
        """Write the checkpoint, if there is one."""
        self._saved = time.monotonic()
        if self._file is not None:
            write_checkpoint(self._file, self.model, self._kept | self._known)

    def _find(self, part: Stage) -> StageAnswer | None:
        """The known answer of a part: the check, or a quick look that shows that it stands."""
        part = part._replace(near=None)
        checked = self._known.get(part._replace(quick=False))
        seen = self._known.get(part._replace(quick=True)) if checked is None else None
        return seen if seen is not None and (seen.stands or part.quick) else checked

    def _rest_near(self, part: Stage) -> Floats | None:
        """Displacements (n, 6) of the known rest states of a part and of its similar stage."""
        out: Floats | None = None
        for stage in (part.near, (part.placed, part.held)):
            for other in () if stage is None else self.model.parts(Stage(*stage)):
                moving = other.placed & ~other.held
                found = self._find(other) if moving & part.placed else None
                if found is None or not found.stands:
                    continue
                if not len(found.rest):  # from a checkpoint
                    rest = self.solver.solve(other._replace(quick=True)).rest
                    found = self._known[other] = replace(found, rest=rest)
                out = np.zeros((len(self.model.assembly), 6)) if out is None else out
                if len(found.rest):
                    out[list(members(moving))] = found.rest
        return out

    def _screened(self, part: Stage) -> Candidate | None:
        """The rest state of a part with uniform stiffness that a quick look found."""
        if part.quick:
            return None
        found = self._find(part)
        return None if found is None else found.uniform

    def _has(self, part: Stage, forces: bool, checked: bool) -> bool:
        known = self._known.get(part._replace(near=None)) if checked else self._find(part)
        return known is not None and not (forces and known.stands and not len(known.corner))

    def _solve(self, parts: Sequence[Stage]) -> Iterable[tuple[Stage, StageAnswer]]:
        left = list(parts)
        while left and len(parts) > 1 and (self._executor or self._factory):
            try:
                futures = [self._submit(part) for part in left]
                for future in futures:
                    yield left[0], future.result()
                    del left[0]
            except LOST_WORKER as error:
                self._revive(error)
        for part in left:
            yield part, self.solver.solve(part, self._rest_near(part), self._screened(part))

    def _start(self) -> Executor | None:
        if self._executor is None and self._factory is not None:
            try:
                self._executor = self._factory()
            except DrystoneError:
                if not self._revivals:
                    raise
                self._factory = None  # it is gone for good: the work goes on in this process
        return self._executor

    def _submit(self, part: Stage) -> Future[StageAnswer]:
        executor = self._start()
        if executor is None:
            raise BrokenExecutor("no workers are left")
        near, rest = self._rest_near(part), self._screened(part)
        return executor.submit(solve_remote, self._payload, part, near, rest)

    def _revive(self, error: BaseException) -> None:
        """After the failure of a worker: start new ones if possible, else continue without."""
        self._revivals += 1
        _log.warning("a worker failed (%s); its stages are checked again", error)
        if self._factory is not None and self._executor is not None:
            self._executor.shutdown(wait=False, cancel_futures=True)
        self._executor = None
        if self._revivals > REVIVALS:
            self._factory = None


def solve_remote(
    payload: bytes, part: Stage, near: Floats | None, rest: Candidate | None
) -> StageAnswer:
    """The verdict on one part, computed in a worker that unpacks the solver once."""
    return _unpacked(payload).solve(Stage(*part), near, rest)


@functools.lru_cache(maxsize=2)
def _unpacked(payload: bytes) -> PartSolver:
    solver = pickle.loads(payload)
    if not isinstance(solver, PartSolver):
        raise TypeError(f"a worker was sent a {type(solver).__name__}")
    return solver
