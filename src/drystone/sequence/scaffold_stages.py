"""Stages of an assembly whose propped blocks are held by struts, ropes, clamps or centring."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from drystone.base.errors import InputError, counted
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.sequence.scaffold_items import ScaffoldedModel, ScaffoldItem, with_scaffold
from drystone.sequence.scaffold_places import ScaffoldOptions, Support, items_of
from drystone.sequence.stages import Check, StageAnswer, check_once, mask_of, members


class ScaffoldedStages:
    """Stages with items of one kind, each checked once.

    Parameters
    ----------
    model
        Complete: faces that are joints in it carry no item.
    support
        The kind, or its name.
    options
    check
        Tells whether a stage stands.

    Attributes
    ----------
    takes
        Free blocks with a face for an item, as bits.

    Raises
    ------
    InputError
        A kind that is not known, or a foot that is no block.
    """

    def __init__(
        self,
        model: Model,
        support: Support | str,
        options: ScaffoldOptions | None = None,
        check: Check = check_once,
    ) -> None:
        self.model = model
        self.support = Support.named(support)
        self.options = ScaffoldOptions.of(options)
        self.check = check
        self.foot = -1
        if self.support is Support.STRUT and self.options.foot is not None:
            self.foot = model.assembly.index(self.options.foot)
        self._rest = np.zeros((len(model.assembly), 6))
        self._refused: list[InputError] = []
        self._items: dict[int, tuple[ScaffoldItem, ...]] = {}
        self._known: dict[tuple[int, int], tuple[ScaffoldedModel, Result]] = {}

    @cached_property
    def takes(self) -> int:
        """Free blocks with a face for an item, as bits."""
        return mask_of(b for b in self.model.assembly.free.tolist() if self._can_take(b))

    def items(self, block: int) -> tuple[ScaffoldItem, ...]:
        """The items of one block.

        Raises
        ------
        InputError
            It has no free face that looks along, or against, the load.
        """
        if block not in self._items:
            made = items_of(self.model, block, support=self.support, options=self.options)
            self._items[block] = made
        return self._items[block]

    def result(self, placed: int, held: int) -> tuple[ScaffoldedModel, Result]:
        """A stage with its items, and its check.

        Parameters
        ----------
        placed, held
            Free blocks in place, and those of them that are held, as bits.

        Raises
        ------
        InputError
            A held block has no face for an item, or the block under the struts is not in place.
        """
        if (placed, held) not in self._known:
            missing = self._missing(placed, held)
            if missing:
                raise InputError(missing, remedy="take a block that is placed earlier")
            here = self._here(placed)
            mine = [item for block in members(held) for item in self.items(block)]
            whole = with_scaffold(self.model.subset(here), mine)
            if self.check is check_once:
                near = np.concatenate([self._rest[here], np.zeros((len(mine), 6))])
                result = check_once(whole.model, near)
            else:
                result = self.check(whole.model)
            if result.displacement is not None:
                self._rest[here] = result.displacement[: len(here)]
            self._known[placed, held] = whole, result
        return self._known[placed, held]

    def _here(self, placed: int) -> list[int]:
        """The supports and the free blocks in place."""
        return sorted([*np.flatnonzero(self.model.assembly.fixed).tolist(), *members(placed)])

    def _missing(self, placed: int, held: int) -> str:
        """Why the struts of a stage have nothing to stand on; else empty."""
        if self.foot < 0 or not held or self.foot in self._here(placed):
            return ""
        return f"'{self.model.assembly.names[self.foot]}', on which struts stand, is not in place"

    def answer(self, placed: int, held: int) -> StageAnswer:
        """Whether a stage stands with its items, none of them beyond its limit."""
        bare = held & ~self.takes
        if bare:
            names = ", ".join(self.model.assembly.names[b] for b in members(bare))
            kind = self.support.value
            return StageAnswer(Verdict.UNSTABLE, f"{names} can have no {kind}")
        missing = self._missing(placed, held)
        if missing:
            return StageAnswer(Verdict.UNSTABLE, missing)
        whole, result = self.result(placed, held)
        here = self._here(placed)
        if not result.stable:
            falling = tuple(here[i] for i in result.falling if i < len(here))
            return StageAnswer(
                result.verdict, f"on {self.support.value}: {result.message}", falling
            )
        over = whole.overloaded(result)
        if over:
            return StageAnswer(Verdict.UNSTABLE, self._overload(whole, result, over))
        return StageAnswer(Verdict.STABLE)

    def _overload(self, whole: ScaffoldedModel, result: Result, over: Sequence[int]) -> str:
        """What the most loaded of some items carries, and its limit."""
        force, moment = whole.force(result), whole.moment(result)
        kind = "centring" if self.support is Support.CENTRING else f"a {self.support.value}"
        most = max(over, key=lambda i: float(force[i]))
        if force[most] > whole.items[most].limit:
            return f"{kind} carries {force[most]:.3g} N, its limit is {whole.items[most].limit:g} N"
        most = max(over, key=lambda i: float(moment[i]))
        return f"{kind} carries {moment[most]:.3g} N m, its limit is {self.options.moment:g} N m"

    def _can_take(self, block: int) -> bool:
        try:
            self.items(block)
        except InputError as error:
            self._refused.append(error)
            return False
        return True

    @property
    def refusal(self) -> str:
        """How many blocks take no item, and why, of each reason the first; empty where all do."""
        count = len(self.model.assembly.free) - self.takes.bit_count()
        if not count:
            return ""
        first: dict[str, InputError] = {}
        for error in self._refused:
            first.setdefault(error.remedy, error)
        why = "; ".join(str(error) for error in first.values())
        return f"{counted(count, 'block')} can have no {self.support.value}: {why}"
