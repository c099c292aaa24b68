"""The search for mends: changes that make a structure stand, ranked by cost, and in rounds."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations
from typing import Any, Unpack

import numpy as np

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.answer.chart import Chart
from drystone.answer.scene import side_by_side
from drystone.base.display import named
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, LongWork, Options, Stop, checked_call
from drystone.base.workers import WorkerPool
from drystone.design.bench import Tried, first_alike
from drystone.design.changed import Changed, Kept
from drystone.design.diagnosis import Diagnosis, DiagnosisOptions, Region, diagnose
from drystone.design.margin import QUICK, DesignMargin
from drystone.design.mend_kinds import KINDS
from drystone.design.needs import NEEDED, refuse_other_kinds
from drystone.design.whole_check import mends_of_kind
from drystone.design.words import NOTHING, listed, names_of
from drystone.io.opening import Given, LongHow, as_model
from drystone.limits.bounds import with_tilt_margin
from drystone.limits.train_limit import limit_train
from drystone.loads import Train
from drystone.loads.placing import GivenLoad
from drystone.model import Model
from drystone.results import Result
from drystone.stability import check
from drystone.supports import select

_ROUNDS = 20
"""Largest number of mends of :func:`mend`. Chosen."""


@checked_call
def mend(given: Given, *, options: MendOptions | None = None, **how: Unpack[LongHow]) -> Changed:
    """The structure with the lowest-cost mend of each region, until it stands.

    The heaviest region comes first; one that no mend holds is passed over, and tried once more when
    others were mended. A mend that holds only after settling is made where no other one holds the
    region. After each mend the whole structure is checked again, so blocks that fall because of the
    mend are mended too.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    options

    Examples
    --------
    >>> from drystone import Assembly
    >>> from drystone.models import box
    >>> base, out = box((1.0, 1.0, 1.0)), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    >>> made = mend(Assembly((base, out)).with_fixed([0]), options=MendOptions(kinds=("prop",)))
    >>> made.stands, len(made.changes)
    (True, 1)
    """
    chosen = MendOptions.of(options)
    clock = Clock.of(how)
    before = model = as_model(given, **how)
    names = model.assembly.names
    chosen = replace(chosen, keep=tuple(names[i] for i in kept_blocks(model, chosen.keep)))
    steps: list[Kept] = []
    log: list[str] = []
    passed: dict[frozenset[str], str] = {}
    passed_at = 0
    model, result, _ = _under_train(model, chosen, clock)
    with WorkerPool(clock.workers) as pool:
        while True:
            stands = chosen.margin.meets(result)
            if stands or len(steps) == _ROUNDS or clock.late():
                break
            how = {"executor": pool.executor, "progress": clock.progress, "stop": clock.late}
            found = _found(model, chosen, Clock.of(how), list, 1, passed, result)
            passed |= _hopeless(found)
            if found.mends:
                best = found.mends[0]
                model, kept = best.model, best.change
                steps.append(kept)
                whose = f"{kept.whose}: " if kept.whose else ""
                log.append(f"{whose}{kept.description} (cost {kept.cost:.3g})")
                model, result, _ = _under_train(model, chosen, clock)
            elif passed and passed_at < len(steps):  # what was mended since may hold them
                passed, passed_at = {}, len(steps)
            else:
                break
    if stands:
        log.append(f"it stands: {result.message}" if steps else stands_already(chosen.margin))
    elif clock.reason or len(steps) == _ROUNDS:
        why = clock.reason or f"ended after {counted(len(steps), 'mend')}"
        log.append(f"{why}; {_left(result, chosen.margin.case_of(result, model))}")
    else:
        left = _left(result, chosen.margin.case_of(result, model))
        log += [*passed.values(), found.message or left]
    words = "; ".join(one.description for one in steps)
    return Changed(before, model, result, stands, words, tuple(steps), tuple(log))


def _hopeless(found: Mends) -> dict[frozenset[str], str]:
    """The regions that no mend holds: the tried kinds, and their largest values."""
    held = {mend.change.blocks for mend in found.mends}
    said: dict[tuple[str, ...], list[str]] = {}
    for blocks, one in found.tried:
        if blocks not in held:
            said.setdefault(blocks, []).append(f"{one.kind}: {one.what}")
    return {
        frozenset(blocks): f"no mend of the list holds {named(blocks)}: {'; '.join(tried)}"
        for blocks, tried in said.items()
    }


def _left(result: Result, case: str) -> str:
    """What still falls, in a case of the margin or in any."""
    falling = result.falling_names
    said = f"it still falls: {named(falling)}" if falling else result.message
    return f"{case}, {said}" if case else said


_BUILT = (
    "each was checked when it is complete; whether it can be built block by block was not tried: "
    "--apply 1 --out mended.json makes mend 1, then drystone plan mended.json"
)

_LOADED = "; it keeps the loads: do not give them again, or leave those of it out by --case weight"

_LET_IN = "; joints that are let in, wedged or turned may need props on the way"

_TIED = (
    "a tie is told with what it bears where it is as stiff as a joint and never yields, and the "
    "blocks around are held: --apply has its pull with all free, too; one that yields may bear "
    "less: give its strength, as --tie A:B:20kN, and check it"
)

_GLUED = (
    "glue keeps its pull and its cohesion while joints move (ductile): mortar as strong that is "
    "brittle may crack, check it with --joint-capacity"
)

_ORDER = (
    "listed by cost; behind are those that jam, last those that stand only after settling or do "
    "not carry the train at all places"
)

_DRAIN = (
    "a drain was not tried: a load with its water lower, or left out, and drystone check say "
    "whether it is enough"
)

_WET = " and water to "
"""In the words of earth with water."""

_DRAWN = 5_000
"""Blocks of all mends on a page, which is then 5 MB. Chosen; further mends are listed only."""


_LONG = 120
"""Characters of a mend above its picture, which more would cover; it is listed beside it in full.
Two lines: one holds 70 of them."""

_OF_NEEDS = {**{kind: kind for kind in NEEDED}, "merge": "glue"}
"""The need from which the mends of a kind begin."""


@dataclass(frozen=True)
class MendOptions(Options):
    """Options of :func:`find_mends` and of :func:`drystone.design.mend`.

    Attributes
    ----------
    margin
        Margin with which it has to stand: ``tilt=2deg`` to each side, ``load=1.2`` times the load,
        ``friction=0.9x``, or ``sensitive``, where STABLE after settling is enough.
    kinds
        Kinds of mends to try, of support, prop, tie, friction, slide, turn, wedge, let-in,
        thicker, ballast, glue and merge (all).
    keep
        Blocks that may not be changed: names and patterns, separated by commas, or positions. Their
        joints are not changed either; what is added may touch them.
    train
        That has to cross the model, with the fill of its load: it is mended under the train where
        that is carried least, and each mend is then asked of all places, and of a margin at the
        worst, whose ``load`` multiplies the train alone.
    steps
        Places of the train, before and after each mend.
    """

    margin: DesignMargin = field(default_factory=DesignMargin)
    kinds: tuple[str, ...] = KINDS
    keep: tuple[int | str, ...] = ()
    train: Train | None = None
    steps: int = 20

    def __post_init__(self) -> None:
        for name in ("kinds", "keep"):
            if isinstance(one := getattr(self, name), str | int):
                object.__setattr__(self, name, (one,))
        super().__post_init__()
        refuse_other_kinds(self.kinds, KINDS, "mend")
        if not self.kinds:
            raise InputError("no kind of mend is allowed", remedy="leave kinds out for all")
        if self.train is None and self.steps != MendOptions.steps:
            raise InputError("are places of a train", where="steps", remedy="give a train too")
        if self.train is not None:
            alone = replace(self.margin, variable=f"{self.train.name} at ")
            object.__setattr__(self, "margin", alone)


@dataclass(frozen=True, eq=False)
class Mends(Answer):
    """The mends of every region of a structure.

    Attributes
    ----------
    diagnosis
        Of the structure, or of the first case of the margin in which it falls.
    mends
        Each has one change. Per region, in order of cost, those that jam last, and behind them
        those that hold only after settling; of equal cost and kind the smallest value first.
    tried
        Kinds that do not hold a region, by the names of its blocks.
    message
        Why there is nothing to mend; empty otherwise.
    case
        Words for that case of the margin; empty where the structure falls without a margin.
    """

    diagnosis: Diagnosis
    mends: tuple[Changed, ...] = ()
    tried: tuple[tuple[tuple[str, ...], Tried], ...] = ()
    message: str = ""
    case: str = ""

    def of(self, blocks: Sequence[str]) -> tuple[Changed, ...]:
        """The mends of the region with these blocks."""
        return tuple(mend for mend in self.mends if set(mend.change.blocks) == set(blocks))

    def together(
        self,
        numbers: Sequence[int],
        *,
        options: MendOptions | None = None,
        **how: Unpack[LongWork],
    ) -> Changed:
        """The structure with some of the mends, each of another region, and its check.

        Where one is made, those after it are sought once more, by their kind.

        Parameters
        ----------
        numbers
            Of the mends, the first one is 1.
        options
            Those of the search.

        Raises
        ------
        InputError
            There is no such mend, two are of one region, or one is not found once more.
        """
        first, *others = self._chosen(numbers)
        chosen, clock = MendOptions.of(options), Clock.of(how)
        margin, model, kept = chosen.margin, first.model, [first.change]
        regions = {frozenset(one.change.blocks) for one in self.mends}
        for wanted in others:
            blocks = wanted.change.blocks
            again = find_mends(
                model, options=replace(chosen, kinds=(wanted.change.kind,)),
                besides=regions - {frozenset(blocks)}, **clock.rest,
            ).of(blocks)  # fmt: skip
            if not again:
                raise InputError(
                    f"'{wanted.words}' is not found once the mends before it are made",
                    remedy="write these with --out, and mend that file",
                )
            nearest = min(again, key=wanted.far_from)
            model, kept = nearest.model, [*kept, nearest.change]
        model, result, _ = _under_train(model, chosen, clock)
        stands = margin.meets(result)
        words = "; ".join(one.description for one in kept)
        log = () if stands else (_left(result, margin.case_of(result, model)),)
        return Changed(first.before, model, result, stands, words, tuple(kept), log)

    def _chosen(self, numbers: Sequence[int]) -> list[Changed]:
        """The mends with some numbers, each of another region."""
        for number in numbers:
            if not 1 <= number <= len(self.mends):
                raise InputError(
                    f"there is no mend {number}: {self._found}",
                    remedy="give numbers that are listed" if self.mends else "leave it out",
                )
        chosen = [self.mends[number - 1] for number in numbers]
        for (first, one), (other, two) in combinations(zip(numbers, chosen, strict=True), 2):
            if one.change.blocks == two.change.blocks:
                raise InputError(
                    f"mends {first} and {other} are both of {named(one.change.blocks)}",
                    remedy="give one of each part",
                )
        return chosen

    @property
    def _found(self) -> str:
        """How many mends there are, or what failed."""
        tried = ", ".join(dict.fromkeys(one.kind for _, one in self.tried))
        count = len(self.mends)
        return f"{count} were found" if count else f"{tried or 'nothing'} failed"

    @property
    def model(self) -> Model:
        """The structure."""
        return self.diagnosis.model

    @property
    def title(self) -> str:
        """How many mends there are."""
        return self.message or f"{self._headline}; {counted(len(self.mends), 'mend')}"

    @property
    def _headline(self) -> str:
        """What falls: the structure, or one that stands in a case of the margin."""
        falls = self.diagnosis.title
        return f"Stands; {self.case}, {falls[0].lower()}{falls[1:]}" if self.case else falls

    def sentences(self) -> Sequence[Sentence]:
        """The verdict, the mends, why it falls, and what was tried without success."""
        verdict, *reasons = self.diagnosis.sentences()
        if self.case:
            found = self.diagnosis.result
            falls = "it falls" if found.falls else f"it is {found.verdict}"
            verdict = replace(verdict, text=f"STANDS; {self.case} {falls}")
            why, told = found.message, f"{self.case}: {found.message}"
            own = why != self.message
            reasons = [replace(x, text=told) if own and x.text == why else x for x in reasons]
        failed = [Sentence(self._failed(), Role.REMARK)] if self.tried else []
        near = [f"less than the margin: {one.less}" for _, one in self.tried if one.less]
        failed += [Sentence(text, Role.REMARK) for text in near]
        mends = [Sentence(text) for text in self._told(self._listed())]
        only = {region.sentence: self._only(region) for region in self.diagnosis.regions}
        reasons = [one for one in reasons if one.text not in (self.message, NOTHING)]
        reasons = [replace(one, text=one.text + only.get(one.text, "")) for one in reasons]
        recut = any(one.change.kind in ("let-in", "wedge", "turn") for one in self.mends)
        load = self.model.load
        loaded = bool(load.each or load.masses or load.shake.any())
        told = _BUILT + _LOADED * loaded + _LET_IN * recut
        built = [Sentence(told, Role.REMARK)] if self.mends else []
        if not self.message and any(_WET in one.words for one in load.each):
            built.append(Sentence(_DRAIN, Role.REMARK))
        costs = [[_cost(self.mends[i]) for i in own] for own in self._parts().values()]
        if any(own != sorted(own) for own in costs):
            built.append(Sentence(_ORDER, Role.REMARK))
        tied = any(one.change.kind == "tie" for one in self.mends)
        built += [Sentence(_TIED, Role.REMARK)] * tied
        glued = any(one.change.kind == "glue" for one in self.mends)
        built += [Sentence(_GLUED, Role.REMARK)] * glued
        said = [verdict, Sentence(self.message), *mends, *built, *failed, *reasons]
        return [one for one in said if one.text]

    def _only(self, region: Region) -> str:
        """Which of the ways to hold a region do not hold the whole."""
        names = tuple(self.model.assembly.names[i] for i in region.blocks)
        kinds = region.needs.kinds - {one.change.kind for one in self.of(names)}
        tried = [one for blocks, one in self.tried if blocks == names and one.kind in kinds]
        only = {one.kind: f"{one.kind}: {one.only}" for one in tried if one.only}
        return f" ({'; '.join(only.values())})" if only else ""

    def _listed(self) -> list[str]:
        """A line for each mend."""
        return [
            f"mend {number}: {one.change.description} ({one.price})"
            for number, one in enumerate(self.mends, 1)
        ]

    def _shown(self, lines: Sequence[str]) -> dict[int, str]:
        """The lines of mends, by position; of those of one kind in other joints that of the first.

        It has the numbers of the others.
        """
        like: dict[tuple[Any, ...], list[int]] = {}
        for i, first in enumerate(self._alike("joints", "added")):
            kept = self.mends[i].change
            same = first if kept.joints or kept.added else i
            like.setdefault((kept.blocks, same), []).append(i)
        shown = {}
        for first, *others in like.values():
            shown[first] = lines[first]
            if others:
                what = "is mend" if len(others) == 1 else "are mends"
                shown[first] += f"; like it {what} {_numbers(others)}, elsewhere"
        return shown

    def _told(self, lines: Sequence[str], *, every: bool = False) -> list[str]:
        """The lines of the mends, by the parts that fall; unless ``every`` not of those alike."""
        shown = dict(enumerate(lines)) if every else self._shown(lines)
        parts = self._parts()
        if len(parts) < 2:
            return list(shown.values())
        said = f"{len(parts)} parts fall, and a mend holds its own part only"
        if all(parts.values()):
            best = ",".join(f"{own[0] + 1}" for own in parts.values())
            said += f": one of each is needed, --auto or --apply {best} makes the cheapest of each"
        told = [said]
        for head, own in self._sections(shown, every=every):
            told += [head + ":" * bool(own), *(shown[i] for i in own)]
        return told

    def _sections(
        self, shown: Collection[int], *, every: bool = False
    ) -> Iterator[tuple[str, list[int]]]:
        """The heading of each part that falls, and positions of its mends that are shown.

        Unless ``every`` without those that are as mends of a part before.
        """
        before: list[list[int]] = []
        for blocks, own in self._parts().items():
            like = max((self._like(own, some) for some in before), key=len, default={})
            who = names_of(self.model, self.model.assembly.indices(blocks).tolist())
            head = f"for {who}{_alike_words(like)}" if own else f"for {who}: no mend was found"
            yield head, [i for i in own if i in shown and i not in like]
            before += [own] * (not every)

    def _like(self, own: Sequence[int], before: Sequence[int]) -> dict[int, int]:
        """Positions of the mends of a part that are as those of another one, with theirs.

        None where the first ones differ: then the parts are not alike.
        """
        first = self._alike("joints", "added", "value", "cost")
        pairs = [(i, j) for i in own for j in before if first[i] == first[j]]
        return dict(reversed(pairs)) if (*own[:1], *before[:1]) in pairs else {}

    def _alike(self, *sizes: str) -> list[int]:
        """Of each mend the position of the first of its kind that has the same sizes."""
        rows = []
        for mend in self.mends:
            one = mend.change
            kind = KINDS.index(one.kind), one.jams > 0.0, mend.stands
            rows.append(np.array([*kind, *(getattr(one, name) for name in sizes)]))
        return first_alike(rows)

    def _parts(self) -> dict[tuple[str, ...], list[int]]:
        """Positions of the mends of each region that falls, by the names of its blocks."""
        names = self.model.assembly.names
        regions = [tuple(names[i] for i in region.blocks) for region in self.diagnosis.regions]
        parts: dict[tuple[str, ...], list[int]] = {blocks: [] for blocks in regions}
        for i, one in enumerate(self.mends):
            parts.setdefault(one.change.blocks, []).append(i)
        return parts

    def failures(self) -> list[str]:
        """A line for each mend that is like another one, and for each tried without success."""
        lines = self._listed()
        told = {i for _, own in self._sections(self._shown(lines)) for i in own}
        more = [line for i, line in enumerate(lines) if i not in told]
        return more + [f"{named(blocks)}: {one.kind}: {one.what}" for blocks, one in self.tried]

    def _failed(self) -> str:
        said = []
        for why in sorted({one.skipped for _, one in self.tried}):
            some = [(blocks, one) for blocks, one in self.tried if one.skipped == why]
            told = counted(len(some), "combination was", "combinations were")
            told = f"not tried {why}" if why else f"{told} tried without success"
            where = f" in {n} regions" if (n := len({blocks for blocks, _ in some})) > 1 else ""
            kinds = ", ".join(dict.fromkeys(one.kind for _, one in some))
            said.append(f"{told}{where}: {kinds}")
        alone = not self.mends and len(self.tried) == 1
        return f"{said[0]}: {self.tried[0][1].what}" if alone else "; ".join(said)

    def layers(self) -> Scene:
        """Why it falls, and each mend as a stage of its own, as far as a page carries them."""
        scene = self.figure()
        if not self.mends:
            return scene
        told = self._listed()
        lines = [f"{text}: --apply {i}" for i, text in enumerate(told, 1)]
        chart = Chart("Mends", caption="\n".join(self._told(lines, every=True)))
        few = self.mends[: _DRAWN // max(len(self.model), 1)]
        stages = [scene.stages[0]]
        for text, one in zip(told, few, strict=False):
            rest = f" (others still fall: {named(one.held)}):" if one.held else ":"
            whole = f"M{text[1:].partition(' (cost')[0].replace(':', rest, 1)}"
            headline = textwrap.shorten(whole, _LONG, placeholder=" ...", break_on_hyphens=False)
            stage = replace(one.layers().stages[0], headline=headline)
            stages.append(replace(stage, label=f"mend {len(stages)}"))
        models = [self.diagnosis.model, *(one.result.model for one in few)]
        names = ["", *(f" (mend {i})" for i in range(1, len(few) + 1))]
        assembly, contacts, together = side_by_side(models, stages, names)
        return replace(
            scene, assembly=assembly, contacts=contacts, stages=together, charts=(chart,),
            opens=min(len(few), 1),
        )  # fmt: skip

    def figure(self) -> Scene:
        """Why it falls."""
        scene = self.diagnosis.layers()
        if not self.case:
            return scene
        stage = replace(scene.stages[0], headline=self._headline)
        title = f"drystone: {self._headline[0].lower()}{self._headline[1:]}"
        return replace(scene, stages=(stage,), title=title)

    def numbers(self) -> Mapping[str, Any]:
        """The diagnosis, the mends, and the kinds that do not help."""
        return {
            **self.diagnosis.numbers(),
            "mends": [mend.as_mend() for mend in self.mends],
            "tried": [{"blocks": blocks, **vars(one)} for blocks, one in self.tried],
            "mending": self.message,
            "case": self.case,
        }


@checked_call
def find_mends(
    given: Given,
    *,
    options: MendOptions | None = None,
    regions: int | None = None,
    besides: Collection[frozenset[str]] = (),
    result: Result | None = None,
    found_one: Callable[[Changed], None] | None = None,
    **how: Unpack[LongHow],
) -> Mends:
    """Search for changes that make a structure stand.

    For every region each kind of change is tried on its local model, with a search for the least
    value with which it stands. The change is then made on the whole structure, which is checked.
    Other falling regions are held during the search.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    options
    regions
        Number of regions to mend, the heaviest first; all when left out. Regions that nothing holds
        do not count.
    besides
        Regions that are not examined, by the names of their blocks.
    result
        What :meth:`DesignMargin.holds` of the margin says of this model, if available.
    found_one
        Called with each change that holds the whole structure, once all of its kind were checked.

    Raises
    ------
    InputError
        What was given cannot be made into a model, or a block to keep does not exist.
    """
    chosen, clock, tell_one = MendOptions.of(options), Clock.of(how), found_one or bool

    def told(made: list[Changed]) -> list[Changed]:
        new = _with_margin(made, clock.late)
        for one in new:
            tell_one(one)
        return new

    return _found(as_model(given, **how), chosen, clock, told, regions, besides, result)


def _found(
    model: Model,
    chosen: MendOptions,
    clock: Clock,
    told: Callable[[list[Changed]], list[Changed]],
    regions: int | None,
    besides: Collection[frozenset[str]],
    result: Result | None,
) -> Mends:
    """As :func:`find_mends`, with ``told`` of the mends of each kind."""
    keep = kept_blocks(model, chosen.keep)
    carried = ""
    if result is None:
        model, result, carried = _under_train(model, chosen, clock)
    found, message = _fallen(result, chosen, clock)
    case = _case(result, model, chosen)
    message = carried if message and carried else message
    if message:
        return Mends(found, message=message, case=case)
    mends: list[Changed] = []
    tried: list[tuple[tuple[str, ...], Tried]] = []
    mended = 0
    others = set(found.others).union(*(region.blocks for region in found.regions))
    others |= _falls_besides(found.model, others, clock.late)
    with WorkerPool(clock.workers) as pool:
        for number, region in enumerate(found.regions, 1):
            names = tuple(model.assembly.names[i] for i in region.blocks)
            if mended == regions or frozenset(names) in besides:
                continue
            held = sorted(others - set(region.blocks))
            task = partial(
                mends_of_kind, model, found.motion, region, chosen.margin, keep, held,
                partial(_crossed, chosen), clock,
            )  # fmt: skip
            own: list[Changed] = []
            several = pool.answers(task, chosen.kinds, clock.late)
            for done, (made, failed) in enumerate(several, 1):
                own += told(made)
                tried += [(names, one) for one in failed]
                clock.tell(f"mends of region {number}", done, len(chosen.kinds))
            mended += bool(own)
            mends += sorted(own, key=partial(_rank, chosen.margin))
    return Mends(found, tuple(mends), tuple(tried), case=case)


def _alike_words(like: Mapping[int, int]) -> str:
    """That some mends are as others, by their positions; empty where there are none."""
    each = [sorted(set(some)) for some in (like, like.values())]
    told = [f"mend{'s' * (len(some) > 1)} {_numbers(some)}" for some in each if some]
    return f", alike: {', as '.join(told)}" if told else ""


def _numbers(positions: Sequence[int]) -> str:
    """The numbers of mends as text."""
    return listed([f"{i + 1}" for i in positions])


def _under_train(model: Model, chosen: MendOptions, clock: Clock) -> tuple[Model, Result, str]:
    """A model under the train of the options where that is carried least, and what is said of it.

    Without the train where it is carried at all places, with the margin at the worst, or the model
    falls alone. The result is that of the margin.
    """
    holds = partial(chosen.margin.holds, stop=clock.late)
    if chosen.train is None:
        return model, holds(model), ""
    alone = model.with_load(model.load.without(_trains(model, chosen)))
    found = limit_train(alone, train=chosen.train, steps=chosen.steps, **clock.rest)
    if found.stopped or found.falls_alone or (found.carried and not chosen.margin.words):
        return alone, holds(alone), found.title
    result = holds(found.loaded)
    if not found.carried:
        return found.loaded, result, found.title
    if chosen.margin.meets(result):
        return alone, holds(alone), found.title
    left = _left(result, chosen.margin.case_of(result, found.loaded))
    return found.loaded, result, f"{found.title}; there, {left}"


def _trains(model: Model, chosen: MendOptions) -> list[GivenLoad]:
    """The train of the options among the loads of a model."""
    at = chosen.margin.variable
    return [one for one in model.load.each if at and one.words.startswith(at)]


def _case(result: Result, model: Model, chosen: MendOptions) -> str:
    """Words for the place of the train, and the case of the margin, of which a result is."""
    said = [f"under {one.words}" for one in _trains(model, chosen)]
    return ", ".join([*said, *filter(None, [chosen.margin.case_of(result, model)])])


def _crossed(chosen: MendOptions, made: Changed, clock: Clock) -> Changed:
    """A mend with what the train of the options says of it at all places."""
    if chosen.train is None:
        return made
    model, result, said = _under_train(made.model, chosen, clock)
    kept = replace(
        made.change,
        description=f"{made.change.description}; of all places: {said[0].lower()}{said[1:]}",
    )
    stands = made.stands and chosen.margin.meets(result)  # not where it falls alone, or is stopped
    if _trains(model, chosen):
        made, stands = replace(made, result=result), False
    return replace(made, changes=(kept,), words=kept.description, stands=stands)


def _with_margin(made: Sequence[Changed], stop: Stop) -> list[Changed]:
    """Mends of one kind, those with the least cost with the tilt that forces balance."""
    least = min(map(_cost, made), default=0.0)
    return [
        replace(one, result=with_tilt_margin(one.result, stop))
        if _cost(one) == least and one.result.model is one.model
        else one
        for one in made
    ]


def _fallen(first: Result, chosen: MendOptions, clock: Clock) -> tuple[Diagnosis, str]:
    """Why a model falls in the first case of a margin that falls, or why nothing is mended.

    What large regions need is found by their mends, the first of which is then told soon.
    """
    if chosen.margin.meets(first):
        return diagnose(first.model, result=first), stands_already(chosen.margin)
    needs = tuple(dict.fromkeys(_OF_NEEDS[kind] for kind in chosen.kinds if kind in _OF_NEEDS))
    options = DiagnosisOptions(large=False, kinds=needs)
    # what stands for some stiffnesses only is mended as it falls with the uniform one
    falls = check(first.model, options=QUICK, stop=clock.late) if first.stable else first
    found = diagnose(first.model, options=options, result=falls, **clock.rest)
    if found.regions:
        return found, ""
    if first.stable:
        return found, f"{first.message}: no mend makes it stand for all; 'sensitive' accepts it"
    return found, found.reasons[0]


def _falls_besides(model: Model, falling: set[int], stop: Stop) -> set[int]:
    """The blocks that fall even where those that fall now are held.

    Where no forces balance the loads, only the blocks without balancing forces are known to fall.
    """
    names, fixed = model.assembly.names, set(np.flatnonzero(model.assembly.fixed).tolist())
    more: set[int] = set()
    while len(fixed | falling | more) < len(model):
        held = model.with_supports([names[i] for i in sorted(fixed | falling | more)])
        new = set(check(held, options=QUICK, stop=stop).falling) - falling - more
        if not new:
            break
        more |= new
    return more


def _cost(made: Changed) -> float:
    """Without what is only rounding."""
    return round(made.change.cost, 9)


def _rank(margin: DesignMargin, made: Changed) -> tuple[bool, bool, float, int, float]:
    """Those that settle last, then those that jam; cost, then kind and size."""
    one, settles = made.change, not margin.meets(made.result)
    return settles, one.jams > 0.0, _cost(made), KINDS.index(one.kind), one.value


def kept_blocks(model: Model, keep: int | str | Sequence[int | str]) -> frozenset[int]:
    """Positions of the blocks to keep: of names, patterns and positions.

    Raises
    ------
    InputError
        There is no such block.
    """
    found: set[int] = set()
    for one in (keep,) if isinstance(keep, int | str) else keep:
        if isinstance(one, str):
            try:
                fixed = select(model.assembly, one, joints=model.joints).fixed
            except InputError as error:
                raise error.located("keep") from None
            found.update(np.flatnonzero(fixed).tolist())
        else:
            found.update(model.assembly.indices([one]).tolist())
    return frozenset(found)


def stands_already(margin: DesignMargin) -> str:
    """What is said of a structure that needs no change."""
    if not margin.words:
        return "it stands already: ask for a margin to make it stand more firmly"
    return "it stands already, at the margin that is asked for"
