"""The verdict on every combination of loads, what it needs, and the one that governs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Literal, Unpack

import numpy as np

from drystone.answer import Answer, Question, Role, Scene, Sentence, Verdict
from drystone.base.declared import Offered
from drystone.base.display import rounded_down
from drystone.base.errors import InputError, counted
from drystone.base.files import PathLike
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.table import Table
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, How, supported_model
from drystone.limits import LimitOptions, limit_friction, limit_shrink
from drystone.model import Model
from drystone.results import Result
from drystone.solvers.threads import one_blas_thread
from drystone.stability import CheckOptions, check
from drystone.studies.combination_file import Combination, read_combinations

Need = Literal["size", "friction", "none"]
_ORDER = {Verdict.UNSTABLE: 0, Verdict.UNDECIDED: 1}
_COARSE = LimitOptions(equilibrium_only=True, width=1e-3)


@dataclass(frozen=True, eq=False)
class Combinations(Answer):
    """Verdicts on combinations, and what each needs of its joints.

    Attributes
    ----------
    model
        Under its own load.
    file
    each
        The combinations.
    results
        Of each the verdict, with friction and strength divided.
    needed
        Of each the least share of the size of the joints, or of their friction, at which some
        forces balance the loads, brittle joints cracked; NaN where it does not stand, was not
        asked, or falls when its brittle joints crack.
    needed_of
        Which of the two.
    stopped
        Why not all were checked; else empty.
    """

    model: Model
    file: str
    each: tuple[Combination, ...]
    results: tuple[Result, ...]
    needed: tuple[float, ...]
    needed_of: Need = "size"
    stopped: str = ""

    def _summary(self) -> str:
        return f"{counted(len(self.results), 'combination')}, {self.title.lower()}"

    @cached_property
    def governs(self) -> int:
        """Position of the combination that falls, is undecided, or needs most."""
        return self._worst_first[0]

    @cached_property
    def _worst_first(self) -> list[int]:
        shares = np.nan_to_num(np.array(self.needed), nan=2.0)
        order = np.array([_ORDER.get(one.verdict, 2) for one in self.results])
        found: list[int] = np.lexsort((-shares, order)).tolist()
        return found

    @property
    def governing(self) -> Result:
        """The verdict on it."""
        return self.results[self.governs]

    @property
    def title(self) -> str:
        """In how many it stands."""
        fallen = sum(not one.stable for one in self.results)
        count = counted(len(self.results), "combination")
        if not fallen:
            return f"Stands in {'' if len(self.results) == 1 else 'all '}{count}"
        return f"Does not stand in {fallen} of {count}"

    def sentences(self) -> Sequence[Sentence]:
        """The same, the combination that governs, and what it needs."""
        stands = all(one.stable for one in self.results)
        one, share = self.each[self.governs], self.needed[self.governs]
        said = [Sentence(self.title, Role.GOOD if stands and not self.stopped else Role.BAD)]
        said.append(Sentence(f"governs: {one.situation.name}: {one.words}"))
        said.append(Sentence(f"there: {self.governing.title}"))
        if np.isfinite(share) and share > 0.0:
            what = "size of the joints" if self.needed_of == "size" else "friction"
            cracked = ", its joints cracked" if self.governing.contacts.brittle else ""
            safety, needs = rounded_down(1.0 / share), np.ceil(1e3 * share - 1e-9) / 1e3
            said.append(Sentence(f"it needs {needs:.1%} of the {what}{cracked}: safety {safety:g}"))
        elif self.needed_of != "none" and self.governing.stable and self.governing.contacts.brittle:
            said.append(
                Sentence("what it needs is not known: it falls when its brittle joints crack")
            )
        by = one.situation
        divided = f"friction is divided by {by.friction:g}, strength of joints by {by.strength:g}"
        said.append(Sentence(divided))
        if self.stopped:
            said.append(Sentence(f"not finished: {self.stopped}", Role.REMARK))
        return said

    def tables(self) -> Sequence[Table]:
        """Each combination: situation, factors, verdict and what it needs; the worst first."""
        order = self._worst_first
        columns = {
            "number": np.array(order) + 1,
            "situation": [self.each[i].situation.name for i in order],
            "factors": [self.each[i].words for i in order],
            "verdict": [self.results[i].verdict.value for i in order],
            "needs": np.array(self.needed)[order],
        }
        return [Table("combinations", columns, {"needs": "1"}, {"needs": True})]

    def layers(self) -> Scene:
        """The combination that governs."""
        return self.governing.layers()

    def numbers(self) -> Mapping[str, Any]:
        """How many stand, what it needs, and the one that governs."""
        return {
            "file": self.file,
            "standing": sum(one.stable for one in self.results),
            "checked": len(self.results),
            "governing": self.each[self.governs].words,
            "situation": self.each[self.governs].situation.name,
            "source": self.each[self.governs].situation.source,
            "needed": self.needed[self.governs],
            "needed_of": self.needed_of,
            "falling": self.governing.falling_names,
            "stopped": self.stopped,
        }

    @cached_property
    def asked(self) -> Question:
        """What was asked, without the loads, which differ."""
        return super().asked.without("load", "acceleration", "loads")


@checked_call
@one_blas_thread()
def combinations(
    given: Given,
    file: PathLike,
    *,
    needed_of: Need = "size",
    options: CheckOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Combinations:
    """Check every combination of actions with partial factors.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    file
        TOML with the cases and their factors.
    needed_of
        What is said of a combination that stands: the share of the ``size`` of all joints that it
        needs for equilibrium, or of their ``friction``; or ``none``.
    options
        Of every check.

    Raises
    ------
    InputError
        Something in the file is not known, contradicts another, or has no unit; its place is named.
    """
    model = supported_model(given, **how)
    each = read_combinations(file, model)
    for one in each:
        replaced = one.of(model)
        replaced.require_still()
    clock = Clock(time_limit_s, stop, progress)
    found: list[tuple[Result, float]] = []
    task = partial(_checked, needed_of=needed_of, options=options)
    with WorkerPool(executor) as pool:
        for pair in pool.answers(task, (one.of(model) for one in each), clock.late):
            found.append(pair)
            clock.tell("checking combinations", len(found), len(each))
    if not found:
        raise InputError(clock.reason or "nothing was checked", remedy="give it more time")
    results, needed = zip(*found, strict=True)
    return Combinations(
        model, str(file), tuple(each[: len(results)]), results, needed, needed_of,
        clock.reason if len(results) < len(each) else "",
    )  # fmt: skip


@one_blas_thread()
def _checked(model: Model, needed_of: Need, options: CheckOptions | None) -> tuple[Result, float]:
    """The verdict on a model, and the share that it needs."""
    result = check(model, options=options)
    if needed_of == "none" or not result.stable:
        return result, float("nan")
    model = model.cracked() if model.contacts.brittle else model
    found = (
        limit_shrink(model, options=_COARSE)
        if needed_of == "size"
        else limit_friction(model, scaled=True, options=_COARSE)
    )
    stands = found.equilibrium.stands
    return result, float("nan") if stands is None else stands


OFFERED = Offered(combinations, "arch.json cases.toml", ("needed_of",))
