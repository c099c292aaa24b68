"""The verdict on every combination of loads, what it needs, and the one that governs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import PurePath
from typing import Any, Literal, Unpack

import numpy as np

from drystone.answer import Answer, Question, Role, Scene, Sentence, Verdict
from drystone.assembly import Assembly
from drystone.base.declared import Offered
from drystone.base.display import rounded_down
from drystone.base.errors import InputError, counted
from drystone.base.files import PathLike, digest
from drystone.base.settings import Clock, checked_call
from drystone.base.table import Table
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, LongHow, supported_model
from drystone.limits import LimitOptions, limit_friction, limit_load, limit_shrink
from drystone.loads import LoadCase
from drystone.loads.applied import Shaken, loads_apart
from drystone.model import Model
from drystone.results import Result
from drystone.solvers.threads import one_blas_thread
from drystone.stability import CheckOptions, check
from drystone.studies.combination_file import (
    Action,
    Combination,
    Situation,
    listed,
    read_combinations,
)

Need = Literal["both", "size", "friction", "none"]
_OF = {"size": "size of the joints", "friction": "friction"}
_ORDER = {Verdict.UNSTABLE: 0, Verdict.UNDECIDED: 1}
_COARSE = LimitOptions(equilibrium_only=True, width=1e-3)


@dataclass(frozen=True, eq=False)
class Combinations(Answer):
    """Verdicts on combinations, and what each needs of its joints.

    Attributes
    ----------
    model
        Under its own load.
    file, sha256
        Of the cases, and the hash of its content.
    each
        The combinations.
    results
        Of each the verdict, with friction and strength divided; of the first ones only where the
        work was stopped.
    needs
        Of each the least shares of the size of the joints and of their friction, as far as asked,
        at which some forces balance the loads, brittle joints cracked; NaN where it does not stand,
        or falls when its brittle joints crack.
    carries
        Of each that does not stand the share of its actions that are not permanent up to which it
        stands: 0 where it falls under the permanent ones alone. NaN of those that stand, and
        without a permanent action.
    """

    model: Model
    file: str
    sha256: str
    each: tuple[Combination, ...]
    results: tuple[Result, ...]
    needs: Mapping[str, tuple[float, ...]]
    carries: tuple[float, ...]

    @cached_property
    def governs(self) -> int:
        """Position of the combination that does not stand and carries least, or needs most."""
        return self._worst_first[0]

    @property
    def needed(self) -> tuple[float, ...]:
        """The larger share of each; NaN where none is known."""
        shares = np.array([[np.nan] * len(self.results), *self.needs.values()])
        largest: list[float] = np.fmax.reduce(shares).tolist()
        return tuple(largest)

    @cached_property
    def _worst_first(self) -> list[int]:
        shares = np.nan_to_num(np.array(self.needed), nan=2.0)
        order = np.array([_ORDER.get(one.verdict, 2) for one in self.results])
        return np.lexsort((-shares, np.nan_to_num(self.carries, nan=2.0), order)).tolist()

    @property
    def governing(self) -> Result:
        """The verdict on it."""
        return self.results[self.governs]

    @property
    def title(self) -> str:
        """In how many it stands."""
        fallen, count = self._fallen, counted(len(self.each), "combination")
        if self.stopped:
            some = f"the first {len(self.results)} of {count}"
            return f"Does not stand in {fallen} of {some}" if fallen else f"Stands in {some}"
        if not fallen:
            return f"Stands in {'' if len(self.each) == 1 else 'all '}{count}"
        return f"Does not stand in {fallen} of {count}"

    @property
    def _fallen(self) -> int:
        return sum(not one.stable for one in self.results)

    def sentences(self) -> Sequence[Sentence]:
        """The same, the combination that governs, and what it needs."""
        one, share = self.each[self.governs], self.needed[self.governs]
        role = Role.BAD if self._fallen else Role.UNSURE if self.stopped else Role.GOOD
        said = [Sentence(self.title, role)]
        among = " of these" if self.stopped else ""
        said.append(Sentence(f"governs{among}: {one.situation.name}: {one.words}"))
        said.append(Sentence(f"there: {self.governing.title}"))
        carried = self.carries[self.governs]
        if carried > 0.0:
            told = f"{rounded_down(carried, 3):.3g} of its other actions"
            said.append(Sentence(f"beside the permanent ones it stands up to {told}"))
        elif carried == 0.0:
            alike = self.carries.count(0.0) - 1
            others = f", as {alike} more: which of these is worst is not known" if alike else ""
            said.append(Sentence(f"it does not stand under its permanent actions alone{others}"))
        if np.isfinite(share) and share > 0.0:
            cracked = ", its joints cracked" if self.governing.contacts.brittle else ""
            shares = " and ".join(
                f"{max(0.0, np.ceil(1e3 * one[self.governs] - 1e-9)) / 1e3:.1%} of the {_OF[of]}"
                for of, one in self.needs.items()
            )
            safety = rounded_down(1.0 / share)
            said.append(Sentence(f"it needs {shares}{cracked}: safety {safety:g}"))
        elif self.needs and self.governing.stable and self.governing.contacts.brittle:
            said.append(
                Sentence("what it needs is not known: it falls when its brittle joints crack")
            )
        by = one.situation
        divided = f"friction is divided by {by.friction:g}, strength of joints by {by.strength:g}"
        if self.model.contacts.ties.any() or by.tie != 1.0:
            none = "" if self.model.contacts.ties.any() else ", of which there is none: give --tie"
            divided += f", of ties by {by.tie:g}{none}"
        said.append(Sentence(divided))
        said += [Sentence(one, Role.REMARK) for one in self._not_apart]
        shaken: dict[str, str] = {}
        for one in self.each[: len(self.results)]:
            quake = Shaken.of(self.governing.assembly, one.load)
            if quake is not None:
                shaken.setdefault(quake.words, one.words)
        each = (
            f"{what} (in {one})" if shaken.keys() - {what} else what for what, one in shaken.items()
        )
        said += [Sentence(one, Role.REMARK) for one in each]
        return said + self._unfinished()

    @property
    def _not_apart(self) -> list[str]:
        """Where one case has all weight, and a situation has factors of its parts."""
        free = self.model.assembly.free
        whole = [
            one.name
            for one in self.each[0].actions
            if one.kind == "permanent" and len(free) > 1 and one.load.wrench[free, 2].all()
        ]
        names = dict.fromkeys(one.situation.name for one in self.each if one.situation.by_parts)
        return [
            f"{by} takes all of '{one}' by one factor: where a part of it holds what another "
            "overturns write a table for each in its place, "
            '[case.NAME] kind = "permanent" load = "gravity" blocks = "BLOCK,BLOCK-*"'
            for by in names
            for one in whole
        ]

    def tables(self) -> Sequence[Table]:
        """Each combination, the worst first; the situations, the cases and their loads."""
        order = self._worst_first
        columns = {
            "number": np.array(order) + 1,
            "situation": [self.each[i].situation.name for i in order],
            "factors": [self.each[i].words for i in order],
            "verdict": [self.results[i].verdict.value for i in order],
        }
        shares = {f"needs_of_{of}": np.array(one)[order] for of, one in self.needs.items()}
        upward = dict.fromkeys(shares, True)
        if not np.isnan(self.carries).all():
            shares["carries_of_others"] = np.array(self.carries)[order]
        alike = dict.fromkeys(shares, "1"), {**dict.fromkeys(shares, False), **upward}
        each = Table("combinations", columns | shares, *alike)
        return [each, _situations(self.each), *_cases(self.each[0].actions, self.model.assembly)]

    def layers(self) -> Scene:
        """The combination that governs."""
        return self.governing.layers()

    def numbers(self) -> Mapping[str, Any]:
        """How many stand, what it needs, and the one that governs."""
        return {
            "file": self.file,
            "sha256": self.sha256,
            "standing": sum(one.stable for one in self.results),
            "checked": len(self.results),
            "asked_for": len(self.each),
            "governing": self.each[self.governs].words,
            "situation": self.each[self.governs].situation.name,
            "source": self.each[self.governs].situation.source,
            "needed": self.needed[self.governs],
            "carries": self.carries[self.governs],
            "needs": {of: one[self.governs] for of, one in self.needs.items()},
            "falling": self.governing.falling_names,
        }

    @cached_property
    def asked(self) -> Question:
        """What was asked, without the loads, which differ."""
        asked = super().asked.without("load", "acceleration", "loads")
        return replace(asked, options={"cases": PurePath(self.file).name, **asked.options})


@checked_call
@one_blas_thread()
def combinations(
    given: Given,
    file: PathLike,
    *,
    needed_of: Need = "both",
    options: CheckOptions | None = None,
    **how: Unpack[LongHow],
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
        needs for equilibrium, of their ``friction``, or both; or none, which takes least time.
    options
        Of every check.

    Raises
    ------
    InputError
        Something in the file is not known, contradicts another, or has no unit; its place is named.
    """
    clock = Clock.of(how)
    model = supported_model(given, **how)
    each = read_combinations(file, model)
    for combined in each:
        combined.of(model).require_still()
    found: list[tuple[Result, list[float], float]] = []
    asked = [of for of in _OF if needed_of in (of, "both")]
    task = partial(_checked, model, asked=asked, options=options)
    with WorkerPool(clock.workers) as pool:
        for one in pool.answers(task, each, clock.late):
            found.append(one)
            clock.tell("checking combinations", len(found), len(each))
    if not found:
        raise InputError(clock.reason or "nothing was checked", remedy="give it more time")
    results, shares, carries = zip(*found, strict=True)
    needs = dict(zip(asked, zip(*shares, strict=True), strict=True)) if asked else {}
    return Combinations(
        model, str(file), digest(file), tuple(each), results, needs,
        carries, stopped=clock.reason if len(results) < len(each) else "",
    )  # fmt: skip


@one_blas_thread()
def _checked(
    whole: Model, one: Combination, asked: Sequence[str], options: CheckOptions | None
) -> tuple[Result, list[float], float]:
    """The verdict on a combination, the shares that it needs, and the share that it carries."""
    model, unknown = one.of(whole), float("nan")
    result = check(model, options=options)
    if not result.stable:
        return result, [unknown] * len(asked), _carried(model, *one.apart)
    model = model.cracked() if model.contacts.brittle else model
    found = [
        limit_shrink(model, options=_COARSE)
        if of == "size"
        else limit_friction(model, scaled=True, options=_COARSE)
        for of in asked
    ]
    stands = [one.equilibrium.stands for one in found]
    return result, [unknown if one is None else one for one in stands], unknown


def _carried(model: Model, lasting: LoadCase, others: LoadCase) -> float:
    """The share of other loads up to which a model stands that does not stand under all of them."""
    free = model.assembly.free
    if not lasting.wrench[free].any():
        return float("nan")
    if not others.beside(lasting).wrench[free].any():
        return 0.0
    return limit_load(model.with_load(lasting), others, upper=1.0).stands or 0.0


def _situations(each: Sequence[Combination]) -> Table:
    """The situations with their factors."""
    actions = each[0].actions
    rows = [
        (
            by.name, _lasting_words(by, actions), _variable_words(by, by.leading, actions),
            _variable_words(by, by.others, actions), f"1 {by.event}" if by.event else "",
            by.friction, by.strength, by.tie, by.source,
        )
        for by in dict.fromkeys(one.situation for one in each)
    ]  # fmt: skip
    names = ("situation", "permanent", "leading", "others", "event", "friction_by", "strength_by",
             "tie_by", "source")  # fmt: skip
    return Table("situations", dict(zip(names, zip(*rows, strict=True), strict=True)))


def _cases(actions: Sequence[Action], assembly: Assembly) -> list[Table]:
    """The cases with their characteristic values, and the forces of each on blocks."""
    rows, parts = [], []
    for one in actions:
        applied = loads_apart(assembly, one.load, one.load.acceleration)
        parts.append(applied.table(assembly.names))
        rows.append((
            one.name, one.kind, one.words, one.load.wrench[assembly.free, :3].sum(axis=0).tolist(),
            applied.acceleration.tolist(), listed(one.psi) if one.kind == "variable" else "",
            "; ".join(f"{name} {listed(pair)}" for name, pair in one.factors.items())
            or "of the situation",
        ))  # fmt: skip
    names = ("case", "kind", "load", "force", "acceleration", "psi", "factors")
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    loads = {key: np.concatenate([one[key] for one in parts]) for key in parts[0].columns}
    loads = {"case": np.repeat(columns["case"], [len(one) for one in parts]), **loads}
    units = {"force": "N", "acceleration": "m/s2"}
    return [Table("cases", columns, units), Table("loads of cases", loads, parts[0].units)]


def _lasting_words(by: Situation, actions: Sequence[Action]) -> str:
    """Factors of permanent actions, and those of actions that have their own."""
    own = [f"; {one.name} {listed(dict.fromkeys(one.factors[by.name]), ' or ')}"
           for one in actions if one.kind == "permanent" and by.name in one.factors]  # fmt: skip
    return "".join((listed(dict.fromkeys(by.permanent), " or "), *own))


def _variable_words(by: Situation, pair: tuple[float, int], actions: Sequence[Action]) -> str:
    """A factor, those of actions that have their own, and the combination factor beside them."""
    factor, number = pair
    psi = f" psi {number}" if number >= 0 else ""
    own = [f"; {one.name} {one.factors[by.name][0]:g}{psi}"
           for one in actions if one.kind == "variable" and by.name in one.factors]  # fmt: skip
    return "".join((f"{factor:g}{psi}", *own))


OFFERED = Offered(combinations, "arch.json cases.toml", ("needed_of",))
