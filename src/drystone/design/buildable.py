"""Wedges deepened until a shell can be built with the least help.

Source: Kao 2023, section 7.3: wedges where a plan needs help, as shallow as they can be, since
sharp corners break.
"""

from __future__ import annotations

import contextlib
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import Floats, Ints, frozen_floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import Options, checked_call
from drystone.base.workers import WorkerPool
from drystone.contacts import DEFAULT_FRICTION
from drystone.design.built import Buildable, Help, helped
from drystone.design.changed import Kept
from drystone.design.search import improved
from drystone.sequence import Order, Plan, PlanOptions, Rules, plan
from drystone.sequence.rules import courses
from drystone.sequence.stages import check_both
from drystone.sequence.structure import Structure
from drystone.shells import Layout, Shape, Shell, ShellBody, build_shell
from drystone.shells.wedge import LARGEST_WEDGE

WEDGES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.4)
"""Wedges that are tried, the shallowest first: those of the table of the vault, and one more."""

_DEEPENED = 3
"""Of several layouts this many are deepened, those that need least help. Chosen."""


@dataclass(frozen=True)
class BuildableOptions(Options):
    """Options of :func:`make_buildable`.

    Attributes
    ----------
    wedges
        The wedges that a bed line may have, the shallowest first, all of one sign. See
        :class:`drystone.shells.Layout`.
    friction
        Coefficient of every joint.
    hands
        See :class:`drystone.sequence.Rules`.
    """

    wedges: tuple[float, ...] = WEDGES
    friction: float = DEFAULT_FRICTION
    hands: int = 2

    def __post_init__(self) -> None:
        super().__post_init__()
        wedges = frozen_floats(self.wedges, (None,), "wedges")
        object.__setattr__(self, "wedges", tuple(wedges.tolist()))
        sizes = np.abs(wedges)
        rising = len(sizes) > 0 and bool((np.diff(sizes) > 0.0).all())
        if not rising or abs(wedges.sum()) < sizes.sum() or sizes[-1] > LARGEST_WEDGE:
            raise InputError(
                f"the wedges are {', '.join(f'{one:g}' for one in self.wedges) or 'none'}",
                remedy="give them of one sign, the shallowest first, each deeper than the last, "
                f"up to {LARGEST_WEDGE}",
            )
        self._refuse_below(1, "hands")


@checked_call
def make_buildable(
    shape: Shape,
    layouts: Layout | Sequence[Layout],
    body: ShellBody | None = None,
    *,
    options: BuildableOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
) -> Buildable:
    """Search the layout and the wedges with which the fewest blocks are propped, then held.

    Each layout is planned with the shallowest wedges. Of those that need least help, the bed lines
    below courses that need help are made deeper, the lowest first, one alone or all together, as
    long as the plan of the whole shell then needs less. Then each line is made as shallow as that
    plan allows.

    Parameters
    ----------
    shape
    layouts
        One or several; their own wedges are not used.
    body
    options

    Returns
    -------
    Buildable
        ``build_shell(shape, found.layout, body)`` is its shell. Its changes are the bed lines with
        deeper wedges, its log tells what each layout needs.

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
    clock = Clock(time_limit_s, stop, progress)
    with WorkerPool(executor) as pool:
        search = _WedgeSearch(shape, body or ShellBody(), chosen, pool, clock)
        return search.run(several)


@dataclass(frozen=True, eq=False)
class _Wedged(OneLine):
    """A shell with a wedge for each bed line between two courses, and its plan."""

    layout: Layout
    shell: Shell
    plan: Plan

    @property
    def wedges(self) -> Floats:
        """Of the bed lines, from the springing."""
        return frozen_floats(self.layout.wedge, (None,), "wedges")

    @property
    def rank(self) -> tuple[Help, float]:
        """Least help first, then the shallowest wedges."""
        return Help.of(self.plan), float(np.abs(self.wedges).sum())


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
        self.seen: set[Layout] = set()

    def run(self, layouts: list[Layout]) -> Buildable:
        """The best of all layouts."""
        starts, log = self.starts(layouts)
        found: list[tuple[_Wedged, _Wedged]] = []
        for first in starts[:_DEEPENED]:
            best = improved(first, self.proposals, self.late)
            found.append((best, first))
            if not any(best.rank[0]) or self.late():
                break
        best, first = min(found, key=lambda one: one[0].rank)
        return self.answer(best, first, log)

    def starts(self, layouts: list[Layout]) -> tuple[list[_Wedged], list[str]]:
        """The layouts with the shallowest wedges, those first that need least help; and a log."""
        log: list[str] = []
        starts: list[_Wedged] = []
        for done, layout in enumerate(layouts):
            if self.late():
                break
            self.clock.tell("planning layouts", done, len(layouts))
            try:
                first = self.planned(self.shallow(layout))
            except InputError as error:
                log.append(f"{_told(layout)}: {error}")
                continue
            if first is None:  # it was stopped
                break
            starts.append(first)
            log.append(f"{_told(layout)}: {first.rank[0]}")
        if not starts and log:
            why = log[0].partition(": ")[2]
            raise InputError(f"no layout was planned: {why}", remedy="try other courses or blocks")
        if not starts:
            raise InputError("the search was stopped before its first plan", remedy="give it time")
        return sorted(starts, key=lambda one: one.rank[0]), log

    def answer(self, best: _Wedged, first: _Wedged, log: list[str]) -> Buildable:
        """The best shell, and the bed lines of it with deeper wedges than at first."""
        wedges = best.wedges.tolist()
        deeper = {i + 1: x for i, x in enumerate(wedges) if x != first.wedges[i]}
        kept = [Kept("wedge", (), f"a wedge of {x:g} below course {i}", x)
                for i, x in deeper.items()]  # fmt: skip
        words, needed = str(best.rank[0]), first.rank[0]
        if deeper:
            below = ", ".join(map(str, deeper))
            words += f", with deeper wedges below course{'s' * (len(deeper) > 1)} {below}"
        words += f"; {needed} with the shallowest wedges"
        words += "; it was stopped before all was tried" if self.late() else ""
        model = best.plan.model.model
        told = (*log, f"wedges from the springing: {', '.join(f'{x:g}' for x in wedges)}")
        return Buildable(
            model, best.plan, tuple(kept), (*told, words), len(self.seen), needed, best.layout
        )

    def shallow(self, layout: Layout) -> Layout:
        """A layout with the shallowest wedge at each bed line."""
        wedge = self.options.wedges[0]
        course = course_of(build_shell(self.shape, replace(layout, wedge=wedge), self.body))
        return replace(layout, wedge=(wedge,) * int(course.max()))

    def planned(self, layout: Layout) -> _Wedged | None:
        """The shell of a layout and its plan; ``None`` if stopped."""
        if self.late():
            return None
        self.seen.add(layout)
        shell = build_shell(self.shape, layout, self.body)
        rules = Rules(hands=self.options.hands, order=Order.COURSE)
        found = plan(
            shell.model(friction=self.options.friction),
            options=PlanOptions(rules=rules, anyway=True),
            executor=self.pool.executor,
            stop=self.late,
        )
        return None if found.stopped else _Wedged(layout, shell, found)

    def proposals(self, now: _Wedged) -> Iterator[_Wedged]:
        """Other wedges, each tried once."""
        for wedges in self.other_wedges(now):
            layout = replace(now.layout, wedge=tuple(wedges.tolist()))
            if layout in self.seen:
                continue
            self.clock.tell("planning wedges", len(self.seen), 0)
            with contextlib.suppress(InputError):  # the shell cannot have them
                found = self.planned(layout)
                if found is not None:
                    yield found

    def other_wedges(self, now: _Wedged) -> Iterator[Floats]:
        """Deeper ones below courses that need help, then shallower ones, the highest line first."""
        ladder, own = np.array(self.options.wedges), now.wedges
        course, names = course_of(now.shell), now.plan.model.assembly.names
        needy = {int(course[now.shell.assembly.index(names[b])]) for b, *_ in helped(now.plan)}
        lines = lines_below(now.shell, needy)
        for some in (*([line] for line in lines), *([lines] if lines else [])):
            for deeper in ladder[np.abs(ladder) > np.abs(own[some]).min()]:
                yield np.where(np.isin(np.arange(len(own)), some), deeper, own)
        for line in reversed(range(len(own))):
            for shallow in ladder[np.abs(ladder) < abs(own[line])]:
                yield np.where(np.arange(len(own)) == line, shallow, own)


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
    level = courses(Structure(shell.model(), check_both)).astype(np.float64)
    level[shell.ground] = -1.0
    return level


def lines_below(shell: Shell, wanted: Collection[int]) -> list[int]:
    """The bed lines between some courses and those of lower levels, the lowest first.

    Line i is between the courses i and i + 1.
    """
    course, level = course_of(shell), levels_of(shell)
    of_course = [float(level[course == c].min()) for c in range(int(course.max()) + 1)]
    lines = []
    for c in sorted(wanted, key=lambda c: of_course[c]):
        if c > 0 and of_course[c - 1] < of_course[c]:
            lines.append(c - 1)
        if c + 1 < len(of_course) and of_course[c + 1] < of_course[c]:
            lines.append(c)
    return list(dict.fromkeys(lines))


def course_of(shell: Shell) -> Ints:
    """Course (n,) of each block; -1 of ground blocks."""
    course = [int(block.metadata.get("course", -1)) for block in shell.assembly.blocks]
    out = np.array(course, dtype=np.intp)
    out[shell.ground] = -1
    return out
