"""How many checks a design job costs: ``python -m benchmarks.jobs [--only PATTERN]``.

A line for each model and job: CPU time, and the same by that of one default check of the model. A
job that needs longer than ``--limit`` is stopped there, as by a time limit, and has a mark. *First*
is when it said its first word, and when it showed the first mend.
"""

from __future__ import annotations

import argparse
import fnmatch
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from benchmarks.measure import timed
from benchmarks.workloads import DOMES, VAULTS, WALLS, X, Y
from drystone import Assembly, LoadCase, Model, check, models
from drystone.answer import Answer
from drystone.design import diagnose, find_mends
from drystone.limits import limit_friction, limit_tilt
from drystone.sequence import plan
from drystone.settlement import settle

CHECK_S = 0.3
"""A check is repeated until it took so long [s]."""


@dataclass
class Watch:
    """CPU seconds since the start of a job, of its first word, and of its first mend."""

    limit_s: float
    word_s: float = float("nan")
    mend_s: float = float("nan")
    mends: int = 0

    def __post_init__(self) -> None:
        self.began = time.process_time()

    def spent(self) -> float:
        """Seconds since the start."""
        return time.process_time() - self.began

    def late(self) -> bool:
        """Whether the job is to end."""
        return self.spent() > self.limit_s

    def tell(self, *_: object) -> None:
        """A word of progress."""
        if self.word_s != self.word_s:
            self.word_s = self.spent()

    def mend(self, _: object) -> None:
        """A mend that is shown."""
        self.mends += 1
        if self.mend_s != self.mend_s:
            self.mend_s = self.spent()


Job = Callable[[Model, Watch], str]


def _diagnose(model: Model, watch: Watch) -> str:
    found = diagnose(model, progress=watch.tell, stop=watch.late)
    return f"{len(found.regions)} regions of {[len(one.blocks) for one in found.regions][:3]}"


def _mend(model: Model, watch: Watch) -> str:
    found = find_mends(model, progress=watch.tell, stop=watch.late, found_one=watch.mend)
    kinds = [one.change.kind for one in found.mends]
    skipped = [one.kind for _, one in found.tried if one.skipped]
    failed = [one.kind for _, one in found.tried if not one.skipped]
    return f"mends {' '.join(kinds)}; failed {' '.join(failed)}; skipped {' '.join(skipped)}"


def _told(ask: Callable[..., Answer], model: Model, watch: Watch) -> str:
    return ask(model, progress=watch.tell, stop=watch.late).title


JOBS: dict[str, tuple[str, Job]] = {
    "diagnose": ("falls", _diagnose),
    "mend": ("falls", _mend),
    "settle falling": ("falls", partial(_told, settle)),
    "settle": ("stands", partial(_told, settle)),
    "tilt": ("stands", partial(_told, limit_tilt)),
    "friction": ("stands", partial(_told, limit_friction)),
    "plan": ("stands", partial(_told, plan)),
}
"""Of which model each is asked, and how."""


def _models() -> Iterator[tuple[str, Callable[[], Assembly], float, tuple[float, ...], float]]:
    """Names, assemblies, frictions, and the axis and the angle [degrees] with which they fall."""
    vaults = {**VAULTS, 412: (25, 16, 6.0)}
    for count in (97, 412, 2_070):
        courses, blocks, length = vaults[count]
        make = partial(models.barrel_vault, courses=courses, blocks=blocks, length=length)
        yield f"vault-{count}", make, 0.6, Y, {97: 21.0, 412: 16.0, 2_070: 13.5}[count]
    for count in (100, 400, 2_000):
        yield f"wall-{count}", partial(models.wall, *WALLS[count]), 0.6, X, 25.0
    for count in (160, 640, 2_000):
        slices, rings = DOMES[count]
        make = partial(models.dome, slices=slices, rings=rings, bonded=True)
        yield f"dome-{count}", make, 0.84, Y, 44.0 if count == 160 else 40.0


def main() -> None:
    """A line for each model and job."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="*", help="of the names, as 'vault-97 mend'")
    parser.add_argument("--limit", type=float, default=60.0, help="CPU seconds of a job")
    given = parser.parse_args()
    print(f"{'model':12} {'job':15} {'check s':>8} {'job s':>8} {'checks':>7} first word, mend s")
    for name, make, friction, axis, angle in _models():
        asked = {
            job: one for job, one in JOBS.items() if fnmatch.fnmatch(f"{name} {job}", given.only)
        }
        if not asked:
            continue
        stands = Model.of(make(), friction=friction)
        falls = stands.with_load(LoadCase.tilt(stands.assembly, axis, angle))
        checks = {}
        for state, model in (("stands", stands), ("falls", falls)):
            if any(of == state for of, _ in asked.values()):
                answer, checks[state] = timed(partial(check, model), CHECK_S)
                print(f"{name:12} {state:15} {checks[state]:8.3f} {answer.verdict.value}")
        for job, (state, ask) in asked.items():
            watch = Watch(given.limit)
            said = ask(stands if state == "stands" else falls, watch)
            spent = watch.spent()
            late = ">" if watch.late() else ""
            share = f"{late}{spent / checks[state]:.1f}"
            print(
                f"{name:12} {job:15} {checks[state]:8.3f} {spent:8.2f} {share:>7} "
                f"{watch.word_s:.2f} {watch.mend_s:.2f} {said}",
                flush=True,
            )


if __name__ == "__main__":
    main()
