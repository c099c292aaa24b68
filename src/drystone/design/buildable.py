"""The layout and the wedges with which a shell is built with the least help.

A course is looked at alone, on those below it, which are held. The help that it needs there depends
on the bed lines below and above it only. So a few shells give it for every pair of wedges, and the
best wedges of all lines follow by dynamic programming. What is found so is planned as a whole.

Source: Kao 2023, sections 7.3 to 7.5: course by course, on fixed lower ones; wedges where a course
needs help, as shallow as they can be, since sharp corners break.
"""

from __future__ import annotations

import contextlib
import heapq
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import permutations
from typing import TypeAlias, Unpack

import numpy as np

from drystone.base.arrays import Floats, Ints, frozen_floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.settings import Clock, LongWork, Options, checked_call
from drystone.base.workers import WorkerPool
from drystone.contacts import DEFAULT_FRICTION
from drystone.design.changed import Buildable, Help, Kept
from drystone.design.regions import local_model
from drystone.model import FlushEnds
from drystone.results import Verdict
from drystone.sequence import Order, Plan, PlanOptions, Rules, plan
from drystone.sequence.rules import courses
from drystone.sequence.stages import StagedModel, check_both
from drystone.shells import Layout, Shape, Shell, ShellBody, build_shell
from drystone.shells.pattern import LARGEST_WEDGE

WEDGES = (0.02, -0.2, 0.4)
"""Wedges that are tried, the shallowest first. Half blocks at open ends lie on one below zero:
without it 9 blocks of a tri-dome of 40 need help. A layout takes as many shells as there are
pairs."""

_DEEPENED = 3
"""This many layouts, those that need least help, are looked at with unlike wedges, and of each this
many ways are planned as a whole: with one 8 blocks of a tri-dome of 40 need help, and not 4."""

_Cost: TypeAlias = tuple[int, int, int, float]
"""Blocks that cannot be placed, that need help, of them propped; and the sum of the wedges."""

_Place: TypeAlias = tuple[int, float, float]
"""A course, and the wedges of the bed lines below and above it."""


@dataclass(frozen=True)
class BuildableOptions(Options):
    """Options of :func:`make_buildable`.

    Attributes
    ----------
    wedges
        The wedges that a bed line may have, the shallowest first, to either side. See
        :class:`drystone.shells.Layout`.
    friction
        Coefficient of every joint.
    hands : >= 1
        See :class:`drystone.sequence.Rules`.
    ends
        What becomes of flush ends of joints.
    """

    wedges: tuple[float, ...] = WEDGES
    friction: float = DEFAULT_FRICTION
    hands: int = 2
    ends: FlushEnds | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        wedges = frozen_floats(self.wedges, (None,), "wedges")
        object.__setattr__(self, "wedges", tuple(wedges.tolist()))
        sizes = np.abs(wedges)
        rising = len(sizes) > 0 and bool((np.diff(sizes) >= 0.0).all())
        if not rising or len(set(self.wedges)) < len(sizes) or sizes[-1] > LARGEST_WEDGE:
            raise InputError(
                f"the wedges are {', '.join(f'{one:g}' for one in self.wedges) or 'none'}",
                remedy="give different ones, the shallowest first, "
                f"from -{LARGEST_WEDGE} to {LARGEST_WEDGE}",
            )


@checked_call
def make_buildable(
    shape: Shape,
    layouts: Layout | Sequence[Layout],
    body: ShellBody | None = None,
    *,
    options: BuildableOptions | None = None,
    **work: Unpack[LongWork],
) -> Buildable:
    """Search the layout and the wedges with which the fewest blocks need help, propped or held.

    Each course of each layout is planned alone, on those below it, which are held: with one wedge
    at all bed lines, and for the layouts that need least help with every pair of wedges below and
    above it. Of the wedges that need least help in sum the shallowest are taken. Shells that
    promise less help than the best one so far are planned as a whole.

    Parameters
    ----------
    shape
    layouts
        One or several, those that are tried first first; their own wedges are not used.
    body
    options

    Returns
    -------
    Buildable
        ``build_shell(shape, found.layout, body)`` is its shell. Its changes are the bed lines with
        deeper wedges, its log tells what each layout promises and needs. Stopped, it is the best
        one so far.

    Raises
    ------
    InputError
        No layout can be built, or it was stopped before the first one was planned.

    Examples
    --------
    >>> from drystone.shells import Layout, ShellBody, dome
    >>> layout, body = Layout(courses=2, blocks=6), ShellBody(thickness=0.5)
    >>> found = make_buildable(dome(3.0, 2.0), layout, body)
    >>> found.help <= found.before
    True
    """
    chosen = BuildableOptions.of(options)
    several = [layouts] if isinstance(layouts, Layout) else list(layouts)
    clock = Clock.of(work)
    with WorkerPool(clock.workers) as pool:
        return _WedgeSearch(shape, body or ShellBody(), chosen, pool, clock).run(several)


@dataclass(frozen=True, eq=False)
class _Wedged(OneLine):
    """A shell with a wedge for each bed line between two courses, and its plan."""

    layout: Layout
    plan: Plan

    @property
    def wedges(self) -> Floats:
        """Of the bed lines, from the springing."""
        return frozen_floats(self.layout.wedge, (None,), "wedges")

    @property
    def cost(self) -> _Cost:
        """As of courses that are planned alone."""
        return _cost_of(self.plan, float(np.abs(self.wedges).sum()))

    @property
    def help(self) -> Help:
        """What its plan needs."""
        return Help.of(self.plan)

    @property
    def rank(self) -> tuple[bool, bool, int, Help, float]:
        """Every stage stands, then fewest blocks with help, then the shallowest wedges."""
        stands, needed = self.plan.verdict is Verdict.STABLE, self.help
        return not stands, needed.unplanned, needed.blocks, needed, self.cost[-1]


class _WedgeSearch:
    """The search over layouts, and over the wedges of each."""

    def __init__(
        self,
        shape: Shape,
        body: ShellBody,
        options: BuildableOptions,
        pool: WorkerPool,
        clock: Clock,
    ) -> None:
        self.shape, self.body, self.options = shape, body, options
        self.pool, self.clock, self.late = pool, clock, clock.late
        self.rules = Rules(hands=options.hands, order=Order.COURSE)
        # of each layout: of a course between two wedges the help it needs alone
        self.alone: dict[Layout, dict[_Place, _Cost]] = {}
        self.promised: dict[Layout, _Cost] = {}
        self.best: _Wedged | None = None
        self.log: list[str] = []
        self.tried = 0

    def run(self, layouts: list[Layout]) -> Buildable:
        """The best of all layouts."""
        self.look_with_one_wedge(layouts)
        self.look_with_unlike_wedges()
        if self.best is None and self.log:
            raise InputError(
                f"no layout was planned: {self.log[0].partition(': ')[2]}",
                remedy="try other courses or blocks",
            )
        if self.best is None:
            raise InputError("the search was stopped before its first plan", remedy="give it time")
        return self.answer(self.best)

    def look_with_one_wedge(self, layouts: list[Layout]) -> None:
        """Look at each layout with the same wedge at all bed lines, until one needs no help."""
        for done, layout in enumerate(layouts):
            self.clock.tell(f"planning layouts{self.so_far}", done, len(layouts))
            self.look(layout, [(wedge, wedge) for wedge in self.options.wedges])
            self.tell(layout)
            if self.late() or self.free:
                break

    def look_with_unlike_wedges(self) -> None:
        """Look at the layouts that promise least help with every pair of wedges."""
        several = sorted(self.promised, key=lambda one: self.promised[one])
        several = several[: 1 if self.free else _DEEPENED]
        for done, layout in enumerate(several):
            self.clock.tell(f"planning wedges{self.so_far}", done, len(several))
            self.look(layout, list(permutations(self.options.wedges, 2)))
            self.tell(layout)

    @property
    def so_far(self) -> str:
        """What the best shell so far needs."""
        return "" if self.best is None else f", so far {self.best.help}"

    @property
    def free(self) -> bool:
        """Whether the best shell needs no help."""
        return self.best is not None and not any(self.best.help)

    def look(self, layout: Layout, pairs: Sequence[tuple[float, float]]) -> None:
        """Plan each course alone, with one wedge at even bed lines and another at odd ones."""
        known = self.alone.setdefault(layout, {})
        lines = max((course for course, *_ in known), default=0)  # none at first: one wedge at all
        open_: dict[_Place, Shell] = {}
        for even, odd in pairs:
            wedges = tuple(odd if line % 2 else even for line in range(lines))
            shell = None if self.late() else self.built(layout, wedges or even)
            if shell is not None:
                wedges = wedges or (even,) * line_count(shell)
                places = zip(range(len(wedges) + 1), [0.0, *wedges], [*wedges, 0.0], strict=True)
                open_ |= {place: shell for place in places if place not in known | open_}
        task = partial(_course_alone, self.options, self.clock)
        answers = self.pool.answers(task, open_.items(), self.late)
        for place, found in zip(open_, answers, strict=False):
            if self.late():
                return
            self.tried += 1
            known[place] = found

    def built(self, layout: Layout, wedge: float | tuple[float, ...]) -> Shell | None:
        """The shell of a layout with other wedges; ``None`` where it cannot have them."""
        try:
            return build_shell(self.shape, replace(layout, wedge=wedge), self.body)
        except InputError as error:
            told = ", ".join(f"{one:g}" for one in np.atleast_1d(wedge))
            self.log.append(f"{_told(layout)}, wedges of {told}: {error}")
            return None

    def promises(self, layout: Layout) -> list[tuple[_Cost, tuple[float, ...]]]:
        """The wedges with the least help of all courses alone, and that help; the least first."""
        known = self.alone[layout]
        lines = max((course for course, *_ in known), default=0)
        ways: dict[float, list[tuple[_Cost, tuple[float, ...]]]] = {0.0: [((0, 0, 0, 0.0), ())]}
        for course in range(lines + 1):
            further: dict[float, list[tuple[_Cost, tuple[float, ...]]]] = {}
            for high in self.options.wedges if course < lines else (0.0,):
                some = [
                    (_sum(cost, known[course, low, high], abs(high)), (*wedges, high))
                    for low, several in ways.items()
                    if (course, low, high) in known
                    for cost, wedges in several
                ]
                further[high] = heapq.nsmallest(_DEEPENED, some)
            ways = further
        return [(cost, wedges[:-1]) for cost, wedges in ways[0.0]]

    def tell(self, layout: Layout) -> None:
        """Note what a layout promises; plan it where that is less, or shallower, than the best."""
        found = self.promises(layout)
        if not found or self.late():
            return
        (least, _), *_ = found
        if self.promised.get(layout) == least:  # unlike wedges promise no less
            return
        self.promised[layout] = least
        _, helped, propped, _ = least
        told = f"{_told(layout)}: {propped} propped, {helped - propped} held where each course is "
        told += "planned alone"
        whole: list[_Wedged] = []
        for cost, wedges in found:
            if self.best is None or cost < self.best.cost:
                one = self.planned(replace(layout, wedge=wedges))
                if one is None:
                    break
                whole.append(one)
                if self.best is None or one.rank < self.best.rank:
                    self.best = one
        if whole:
            told += f", {min(whole, key=lambda one: one.rank).help} as a whole"
        self.log.append(told)

    def planned(self, layout: Layout) -> _Wedged | None:
        """The shell of a layout and its plan; ``None`` if stopped."""
        self.tried += 1
        shell = build_shell(self.shape, layout, self.body)
        found = plan(
            shell.model(friction=self.options.friction, ends=self.options.ends),
            options=PlanOptions(rules=self.rules, anyway=True),
            executor=self.pool.executor,
            stop=self.late,
        )
        return None if found.stopped else _Wedged(layout, found)

    def answer(self, best: _Wedged) -> Buildable:
        """The best shell, and the bed lines of it with deeper wedges than the shallowest."""
        least = self.options.wedges[0]
        wedges = best.wedges.tolist()
        deeper = {i + 1: x for i, x in enumerate(wedges) if x != least}
        kept = [Kept("wedge", (), f"a wedge of {x:g} below course {i}", x)
                for i, x in deeper.items()]  # fmt: skip
        first = best if not deeper else self.before(best)
        words = str(best.help)
        if deeper:
            below = ", ".join(map(str, deeper))
            words += f", with deeper wedges below course{'s' * (len(deeper) > 1)} {below}"
        words += "" if first is None else f"; {first.help} with the shallowest wedges"
        words += "; it was stopped before all was tried" if self.late() else ""
        told = f"wedges from the springing: {', '.join(f'{x:g}' for x in wedges)}"
        return Buildable(
            best.plan.model.model, best.plan, tuple(kept), (*self.log, told, words), self.tried,
            None if first is None else first.help, best.layout,
        )  # fmt: skip

    def before(self, best: _Wedged) -> _Wedged | None:
        """The same layout with the shallowest wedges; ``None`` if stopped or not to be built."""
        if self.late():
            return None
        with contextlib.suppress(InputError):
            wedges = (self.options.wedges[0],) * len(best.wedges)
            return self.planned(replace(best.layout, wedge=wedges))
        return None


def _course_alone(options: BuildableOptions, clock: Clock, of: tuple[_Place, Shell]) -> _Cost:
    """The help that a course of a shell needs on those below it, which are held."""
    (course, *_), shell = of
    model = shell.model(friction=options.friction, ends=options.ends)
    level = levels_of(shell)
    own = (course_of(shell) == course) & ~model.assembly.fixed
    if not own.any():
        return (0, 0, 0, 0.0)
    below = (level < level[own].min()) | model.assembly.fixed
    place = np.flatnonzero(own | below)
    part = model.subset(place.tolist())
    alone, _ = local_model(part, np.flatnonzero(own[place]).tolist())
    rules = Rules(hands=options.hands)
    return _cost_of(plan(alone, options=PlanOptions(rules=rules, anyway=True), stop=clock.late))


def _cost_of(found: Plan, wedge: float = 0.0) -> _Cost:
    needed = Help.of(found)
    impossible = needed.unplanned + needed.impossible
    return impossible, needed.propped + needed.held, needed.propped, wedge


def _sum(one: _Cost, other: _Cost, wedge: float) -> _Cost:
    """The help of a further course, and the wedge above it, added."""
    return one[0] + other[0], one[1] + other[1], one[2] + other[2], one[3] + wedge


def line_count(shell: Shell) -> int:
    """Number of bed lines between two courses of a patch."""
    return int(shell.mesh.course[shell.mesh.of_patch >= 0].max())


def _told(layout: Layout) -> str:
    """A layout in a few words."""
    told = [f"{layout.courses} courses"] if layout.courses is not None else []
    if layout.blocks is not None:
        told.append(f"{layout.blocks} blocks each")
    if layout.width is not None:
        told.append(f"blocks of {layout.width:.3g} m")
    return ", ".join([*told, "staggered" if layout.staggered else "not staggered"])


def levels_of(shell: Shell) -> Floats:
    """Level (n,) of each block in :attr:`drystone.sequence.Order.COURSE`.

    The course; or the number of joints to a support, where courses close between two supports.
    Ground blocks have none, and come first.
    """
    level = courses(StagedModel(shell.model(), check_both)).astype(np.float64)
    level[shell.ground] = -1.0
    return level


def course_of(shell: Shell) -> Ints:
    """Course (n,) of each block; -1 of ground blocks."""
    course = [int(block.metadata.get("course", -1)) for block in shell.assembly.blocks]
    out = np.array(course, dtype=np.intp)
    out[shell.ground] = -1
    return out
