"""Stages of an assembly whose propped blocks are held by struts, ropes, clamps or centring."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np

from drystone.base.errors import InputError, counted
from drystone.base.settings import member_of
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.sequence.scaffold_items import ScaffoldedModel, ScaffoldItem, Strut, with_items
from drystone.sequence.scaffold_places import ScaffoldOptions, Support, items_of
from drystone.sequence.scaffold_seats import surface_triangles
from drystone.sequence.stages import (
    CHECKED,
    Check,
    StageAnswer,
    check_both,
    check_once,
    check_thoroughly,
    mask_of,
    members,
)


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
        self.support = member_of(Support, support, "support")
        self.options = ScaffoldOptions.of(options)
        self.check = check
        if self.support is Support.STRUT and self.options.foot is not None:
            model.assembly.index(self.options.foot)
        self._surface = surface_triangles(model.assembly)
        self._rest = np.zeros((len(model.assembly), 6))
        self._refused: dict[int, InputError] = {}
        self._fixed = mask_of(np.flatnonzero(model.assembly.fixed).tolist())
        self._items: dict[int, tuple[ScaffoldItem, ...]] = {}
        self._known: dict[tuple[int, int], tuple[ScaffoldedModel, Result]] = {}
        self._followed: set[tuple[int, int]] = set()

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
            self._items[block] = items_of(
                self.model, block, support=self.support, options=self.options,
                surface=self._surface,
            )  # fmt: skip
        return self._items[block]

    def result(
        self, placed: int, held: int, *, followed: bool = False
    ) -> tuple[ScaffoldedModel, Result]:
        """A stage with its items, and its check.

        Parameters
        ----------
        placed, held
            Free blocks in place, and those of them that are held, as bits.
        followed
            Whether a stage is checked from nothing, as those of a plan are, where a look that began
            at the stage before found that it stands; and is followed while it settles.

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
            whole = with_items(self.model.subset(here), mine)
            if self.check is check_once:
                near = np.concatenate([self._rest[here], np.zeros((len(mine), 6))])
                result = check_once(whole.model, near)
            else:
                result = self.check(whole.model)
            if result.displacement is not None:
                self._rest[here] = result.displacement[: len(here)]
            self._known[placed, held] = whole, result
        whole, result = self._known[placed, held]
        if followed and self.check is check_once and (placed, held) not in self._followed:
            self._followed.add((placed, held))
            self._known[placed, held] = whole, result = whole, _followed(whole.model, result)
        return whole, result

    def only_looked_at(self, whole: ScaffoldedModel, result: Result) -> bool:
        """Whether a stage of a plan stands by a look alone, since it has many corners."""
        many = whole.model.contacts.corner_count > CHECKED
        return self.check is check_once and result.stable and many

    def _here(self, placed: int) -> list[int]:
        """The supports and the free blocks in place."""
        return sorted([*np.flatnonzero(self.model.assembly.fixed).tolist(), *members(placed)])

    def _missing(self, placed: int, held: int) -> str:
        """Why the struts of a stage have nothing to stand on; else empty."""
        items = [item for block in members(held) for item in self.items(block)]
        feet = {item.on for item in items if isinstance(item, Strut) and item.on is not None}
        away = set(self.model.assembly.indices(sorted(feet)).tolist()) - set(self._here(placed))
        names = ", ".join(f"'{self.model.assembly.names[block]}'" for block in sorted(away))
        are = "is" if len(away) == 1 else "are"
        return f"{names}, on which struts stand, {are} not in place" if away else ""

    def answer(self, placed: int, held: int, *, followed: bool = False) -> StageAnswer:
        """Whether a stage stands with its items, none beyond its limit; see :meth:`result`."""
        bare = held & ~self.takes
        if bare:
            names = ", ".join(self.model.assembly.names[b] for b in members(bare))
            kind = self.support.value
            return StageAnswer(
                Verdict.UNSTABLE, f"{names} can have no {kind}", tuple(members(bare))
            )
        missing = self._missing(placed, held)
        if missing:
            return StageAnswer(Verdict.UNSTABLE, missing)
        whole, result = self.result(placed, held, followed=followed)
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
            self._refused[block] = error
            return False
        return True

    def refusal(self, falling: Iterable[int]) -> str:
        """How many of some blocks take no item, and why, of each reason the first; else empty."""
        bare = set(members(mask_of(falling) & ~self.takes & ~self._fixed))
        count = len(bare)
        if not count:
            return ""
        first: dict[str, InputError] = {}
        for block in sorted(bare):
            error = self._refused[block]
            first.setdefault(error.remedy, error)
        why = "; ".join(str(error) for error in first.values())
        return f"{counted(count, 'block')} can have no {self.support.value}: {why}"


def _followed(stage: Model, seen: Result) -> Result:
    """What a check says of a stage, from nothing: what was seen where it agrees."""
    few = stage.contacts.corner_count <= CHECKED
    found = check_both(stage) if seen.stable and few else seen
    if found.verdict is Verdict.UNDECIDED:
        return check_thoroughly(stage)
    return seen if found.stable else found
