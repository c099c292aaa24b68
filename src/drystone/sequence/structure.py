"""Whether subsets of a structure stand: thousands of questions about one model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Unpack

import numpy as np

from drystone.assembly.assembly import Blocks
from drystone.base.arrays import Bools, Floats, frozen, number, whole
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, LongWork, checked_call
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, How, Whole, supported_model
from drystone.model import Model
from drystone.results import Verdict
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.solving import most_used
from drystone.sequence.stages import Stage, StageAnswer, StageCheck, StagedModel, mask_of, members
from drystone.stability import CheckOptions
from drystone.stability.touching_edges import may_touch_more


@dataclass(frozen=True, eq=False)
class StageAnswers(OneLine):
    """The answers about several subsets, as arrays.

    Attributes
    ----------
    answers
        One for each subset, in the order asked.
    blocks
        Number of blocks of the structure, n.
    """

    answers: tuple[StageAnswer, ...]
    blocks: int

    def _summary(self) -> str:
        return f"{counted(len(self), 'subset')}, {int(self.stands.sum())} stand"

    def __len__(self) -> int:
        return len(self.answers)

    def __getitem__(self, subset: int) -> StageAnswer:
        return self.answers[subset]

    @property
    def verdict(self) -> tuple[Verdict, ...]:
        """Verdict of each subset."""
        return tuple(one.verdict for one in self.answers)

    @cached_property
    def stands(self) -> Bools:
        """Whether each subset (s,) was shown to stand."""
        return frozen(np.array([one.stands for one in self.answers], dtype=bool))

    @cached_property
    def friction_left(self) -> Floats:
        """Share left (s,) of the friction of the most used joint: 0 if it falls, NaN if unknown."""
        return frozen(np.array([one.friction_left for one in self.answers], dtype=np.float64))

    @cached_property
    def falling(self) -> Bools:
        """The blocks (s, n) that fall."""
        out = np.zeros((len(self), self.blocks), dtype=bool)
        for row, one in zip(out, self.answers, strict=True):
            row[list(one.falling)] = True
        return frozen(out)


class Structure(OneLine):
    """A model of which many subsets are asked whether they stand.

    Supports are always in place. The verdict is that of :func:`drystone.check` on the blocks in
    place. It costs less, as what is known already is used: the answers of connected parts that come
    again; the rest state of a similar part, where the next one begins; mechanisms, which prove
    other parts to fall; what fell when it was followed, where it begins to do so again between the
    same blocks; and, where a structure is its own image, the answers of images. So the blocks that
    an answer names as falling are those of one proof for each part; a check of all blocks together
    may name others, as several motions are possible.

    Parameters
    ----------
    given
        A model of the complete structure; or an assembly or a file that ``how`` turns into one.
    robust
        Whether other contact stiffnesses are tried too. They change no verdict; what stands is then
        known to be ``sensitive`` to them or not.
    each_s : [s]
        Time limit of every check; what is not decided until then is UNDECIDED.
    kept
        Largest number of connected parts whose answers are kept.

    Raises
    ------
    InputError
        What was given cannot be made into a model, no block is fixed, or a number is out of range.

    Examples
    --------
    >>> from drystone.models import arch
    >>> structure = Structure(arch(0.3, 7), friction=0.7)
    >>> structure.stands(["voussoir-00", "voussoir-01", "voussoir-02"]).verdict
    <Verdict.UNSTABLE: 'unstable'>
    >>> structure.stands(["voussoir-00"]).friction_left > 0.2
    True
    """

    @checked_call
    def __init__(
        self,
        given: Given,
        *,
        robust: bool = False,
        each_s: float = float("inf"),
        kept: int = 10_000,
        **how: Unpack[How],
    ) -> None:
        options = CheckOptions.robust() if robust else CheckOptions()
        self.model: Model = supported_model(given, **how)
        if not number(each_s, "each_s", finite=False) >= 0.0:
            raise InputError(f"each_s is {each_s}", remedy="give seconds, none or more")
        self.robust, self.each_s = robust, each_s
        self.kept = whole(kept, "kept", least=1)
        self._check = StageCheck(options, each_s, brief=True)
        self._asked: dict[bytes, Evaluator] = {}
        self._of(None)  # refuses a model without supports

    def _summary(self) -> str:
        return self.model._summary()

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.model, self.robust, self.each_s, self.kept)

    def stands(
        self, blocks: Blocks, *, held: Blocks = (), load: Whole | None = None
    ) -> StageAnswer:
        """Whether some blocks stand, with all supports and without the others.

        Parameters
        ----------
        blocks
            Names or positions of the blocks in place, or a mask (n,) bool.
        held
            Those of them that a hand, a robot or a prop holds in every direction: they count as
            fixed. ``reaction`` of the answer has the force on each.
        load
            The load of this stage; that of the model when left out. See :class:`drystone.Model`.

        Raises
        ------
        InputError
            There is no such block, a held block is not in place, or the load moves supports.
        """
        placed, fixed = (self._mask(some) for some in (blocks, held))
        return self._answers([(placed, fixed)], self._of(load))[0]

    @checked_call
    def stands_many(
        self,
        masks: Bools,
        *,
        held: Bools | None = None,
        load: Whole | None = None,
        **work: Unpack[LongWork],
    ) -> StageAnswers:
        """Whether subsets of the blocks stand.

        The largest are asked first, as what is known of them helps most with the others. Where the
        time is up the rest is UNDECIDED.

        Parameters
        ----------
        masks : (s, n) bool
            The blocks in place; supports are so in any case.
        held : (s, n) or (n,) bool
            Those that are held; none when left out.
        load
            The load of these stages; that of the model when left out.

        Raises
        ------
        InputError
            A mask has another shape, a held block is not in place, or the load moves supports.
        """
        placed = self._masks(masks, "masks")
        if placed.ndim != 2:
            raise InputError(f"masks has shape {placed.shape}", remedy="give (s, n)")
        fixed = np.zeros_like(placed)
        if held is not None:
            given = self._masks(held, "held")
            if given.ndim == 2 and len(given) != len(placed):
                said = f"held has {counted(len(given), 'row')} and masks {len(placed)}"
                raise InputError(said, remedy="give one row for each, or one for all")
            fixed |= given
        sets = list(zip(self._sets(placed), self._sets(fixed), strict=True))
        order = sorted(range(len(sets)), key=lambda i: -sets[i][0].bit_count())
        clock = Clock.of(work)
        late = StageAnswer(Verdict.UNDECIDED)
        found = dict.fromkeys(range(len(sets)), late)
        asked = self._of(load)
        with WorkerPool(clock.workers, needed=False) as pool:
            size = max(1, 4 * pool.count)
            for begin in range(0, len(order), size):
                some = order[begin : begin + size]
                if clock.late():
                    late = replace(late, message=clock.reason)
                    found |= dict.fromkeys(order[begin:], late)
                    break
                answers = self._answers([sets[i] for i in some], asked, pool)
                found |= zip(some, answers, strict=True)
                clock.tell("subsets", begin + len(some), len(order))
        return StageAnswers(tuple(found[i] for i in range(len(sets))), len(self.model))

    def _mask(self, blocks: Blocks) -> int:
        """Some blocks as a set, without supports."""
        free = self.model.assembly.indices(blocks)
        return mask_of(free[~self.model.assembly.fixed[free]].tolist())

    def _masks(self, given: Bools, what: str) -> Bools:
        """Masks (..., n) of blocks."""
        n, remedy = len(self.model), "give an array of bool whose rows have {} entries"
        try:
            masks = np.asarray(given)
        except ValueError as error:  # rows of several lengths
            raise InputError(f"{what} is no array", remedy=remedy.format(n)) from error
        if masks.dtype != bool or masks.ndim not in (1, 2) or masks.shape[-1] != n:
            said = f"{what} has shape {masks.shape} and type {masks.dtype}"
            raise InputError(said, remedy=remedy.format(n))
        return masks

    def _sets(self, masks: Bools) -> list[int]:
        """Masks (s, n) as sets, without supports."""
        rows = np.packbits(masks & ~self.model.assembly.fixed, axis=1, bitorder="little")
        return [int.from_bytes(row.tobytes(), "little") for row in rows]

    def _of(self, load: Whole | None) -> Evaluator:
        """What is known under a load."""
        model = self.model if load is None else self.model.with_load(load)
        model.require_still()
        key = model.load.wrench.tobytes()
        if key not in self._asked:
            while len(self._asked) >= 8:  # loads, chosen
                del self._asked[next(iter(self._asked))]
            staged = StagedModel(model, self._check)
            self._asked[key] = Evaluator(staged, learns=True, kept=self.kept)
        return self._asked[key]

    def _answers(
        self, sets: Sequence[tuple[int, int]], asked: Evaluator, pool: WorkerPool | None = None
    ) -> list[StageAnswer]:
        """The answers about sets of blocks in place and of held blocks among them."""
        for placed, held in sets:
            if held & ~placed:
                names = [self.model.assembly.names[b] for b in members(held & ~placed)]
                raise InputError(
                    f"'{names[0]}' is held and not in place", remedy="put it among the blocks"
                )
        stages = [Stage(*one) for one in sets]
        found = asked.answers(stages, pool=pool)
        return [
            self._if_more_touches(stage, answer, asked)
            if answer.verdict is Verdict.UNSTABLE and self._may_touch_more
            else answer
            for stage, answer in zip(stages, found, strict=True)
        ]

    @cached_property
    def _may_touch_more(self) -> bool:
        """Whether a proof of a fall may rest on blocks that were not joined."""
        return may_touch_more(self.model, parts=True)

    def _if_more_touches(self, stage: Stage, answer: StageAnswer, asked: Evaluator) -> StageAnswer:
        """The check of a stage that falls, with the pairs of blocks that were not joined."""
        model, blocks = asked.model.cut_out(stage)
        if not may_touch_more(model):
            return answer
        found = self._check(model)
        falling = tuple(blocks[list(found.falling)].tolist())
        used = 0.0 if found.force is None else most_used(found.contacts, found.force)
        return StageAnswer(found.verdict, found.message, falling, used=used)


def _again(model: Model, robust: bool, each_s: float, kept: int) -> Structure:
    """A structure in another process; it knows nothing yet."""
    return Structure(model, robust=robust, each_s=each_s, kept=kept)
