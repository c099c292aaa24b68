"""Wedges deepened course by course until a shell can be built with the least help.

Source: Kao 2023, section 7.3: wedges where a plan needs help, as shallow as they can be, since
sharp corners break.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.design.buildable import (
    Buildable,
    BuildableOptions,
    BuildNeeds,
    TriedLayout,
    message_of,
)
from drystone.sequence import Order, Plan, PlanOptions, Rules, Status, plan
from drystone.sequence.rules import courses
from drystone.sequence.stages import check_both
from drystone.sequence.structure import Structure
from drystone.shells import Layout, Shape, Shell, ShellBody, build_shell

_NONE = BuildNeeds(0, 0)


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

    Each layout is planned with the shallowest wedges. Those that need least help are then gone
    through course by course from the springing, or from both springings where the courses close
    between them. The bed line below a course that needs help is made deeper, step by step, until it
    needs none; the plan is made again from the course below that line on, the first one that
    changes. The whole shell is planned at the end.

    Parameters
    ----------
    shape
    layouts
        One or several; their own wedges are not used.
    body
    options

    Raises
    ------
    InputError
        No layout can be built, or it was stopped before the first one was planned.

    Examples
    --------
    >>> from drystone.shells import Layout, ShellBody, dome
    >>> layout, body = Layout(courses=2, blocks=6), ShellBody(thickness=0.5)
    >>> found = make_buildable(dome(3.0, 2.0), layout, body)
    >>> found.needs.cost <= found.before.cost
    True
    """
    chosen = BuildableOptions.of(options)
    several = [layouts] if isinstance(layouts, Layout) else list(layouts)
    clock = Clock(time_limit_s, stop)
    with WorkerPool(executor) as pool:
        return _WedgeSearch(shape, body or ShellBody(), chosen, pool, progress, clock).run(several)


class _WedgeSearch:
    """The search over layouts, and over the wedges of each."""

    def __init__(
        self,
        shape: Shape,
        body: ShellBody,
        options: BuildableOptions,
        pool: WorkerPool,
        progress: Progress | None,
        clock: Clock,
    ) -> None:
        self.shape, self.body, self.options = shape, body, options
        self.pool, self.progress, self.late = pool, progress, clock.late

    def run(self, layouts: list[Layout]) -> Buildable:
        """The best of all layouts."""
        shallow = self.options.wedges[0]
        tried: list[TriedLayout] = []
        starts: list[tuple[int, Layout, Shell, Plan]] = []
        for number, layout in enumerate(layouts):
            if self.late():
                break
            self.tell("planning layouts", number, len(layouts))
            try:
                shell = self.built(layout, [shallow] * self.lines(layout))
                first = self.planned(shell)
            except InputError as error:
                tried.append(TriedLayout(layout, 0, None, message=str(error)))
                continue
            if first is None:
                break
            tried.append(TriedLayout(layout, len(shell.voussoirs), needs_of(first)))
            starts.append((len(tried) - 1, layout, shell, first))
        if not starts:
            if not tried:
                raise InputError(
                    "the search was stopped before its first plan", remedy="give it time"
                )
            why = tried[0].message
            raise InputError(f"no layout was planned: {why}", remedy="try other courses or blocks")
        starts.sort(key=lambda one: needs_of(one[3]).cost)
        best: Buildable | None = None
        for at, layout, shell, first in starts[: self.options.deepened]:
            found = self.deepened(layout, shell, first)
            tried[at] = replace(tried[at], deepened=found.needs)
            if best is None or _rank(found) < _rank(best):
                best = found
            if best.needs == _NONE or self.late():
                break
        assert best is not None
        return replace(best, tried=tuple(tried))

    def tell(self, stage: str, done: int, total: int) -> None:
        if self.progress is not None:
            self.progress(stage, done, total)

    def lines(self, layout: Layout) -> int:
        """Number of bed lines between two courses."""
        return int(course_of(self.built(layout, self.options.wedges[0])).max())

    def built(self, layout: Layout, wedges: float | Sequence[float]) -> Shell:
        return build_shell(self.shape, replace(layout, wedge=wedges), self.body)

    # -- plans ----------------------------------------------------------------------------------
    def planned(self, shell: Shell, low: float = 0.0, high: float = np.inf) -> Plan | None:
        """The plan of the blocks from one level to another one; ``None`` if stopped.

        The blocks below are in place; those above are left out.
        """
        level = levels_of(shell)
        names = np.array(shell.assembly.names)
        model = shell.model(friction=self.options.friction)
        model = model.subset(np.flatnonzero(level <= high).tolist())
        free = ~shell.assembly.fixed
        rules = Rules(
            hands=self.options.hands,
            order=Order.COURSE,
            placed=tuple(names[free & (level < low)].tolist()),
        )
        options = PlanOptions(rules=rules, anyway=True)
        found = plan(model, options=options, executor=self.pool.executor, stop=self.late)
        return None if found.stopped else found

    # -- wedges ---------------------------------------------------------------------------------
    def deepened(self, layout: Layout, shell: Shell, first: Plan) -> Buildable:
        """The wedges of one layout, from the shallowest, and the plan of the whole."""
        ladder = self.options.wedges
        wedges = [ladder[0]] * int(course_of(shell).max())
        before = needs_of(first)
        best = shell, first, list(wedges)
        if before != _NONE:
            wedges, shell = self.level_by_level(layout, wedges, shell)
            whole = None if wedges == best[2] else self.planned(shell)
            if whole is not None and needs_of(whole).cost < before.cost:
                best = shell, whole, wedges
            best = self.shallower(layout, *self.remaining(layout, *best))
        shell, made, wedges = best
        deeper = [i + 1 for i, one in enumerate(wedges) if one != ladder[0]]
        words = message_of(needs_of(made), before, deeper, self.late())
        layout = replace(layout, wedge=tuple(wedges))
        return Buildable(shell, made, layout, needs_of(made), before, (), words)

    def level_by_level(
        self, layout: Layout, wedges: list[float], shell: Shell
    ) -> tuple[list[float], Shell]:
        """The shallowest wedges with which each level needs the least help on those below."""
        level = levels_of(shell)
        last = int(level[~shell.ground].max())
        for high in range(int(level[~shell.ground].min()) + 1, last + 1):
            self.tell("planning courses", high, last)
            now = self.planned(shell, high, high)
            if now is None:
                break
            lines = lines_below(shell, _helped_courses(shell, now))
            if needs_of(now) == _NONE or not lines:
                continue
            # the courses below change with the lines, and count from here on
            made = self.planned(shell, high - 1, high)
            for deeper in self.options.wedges[1:]:
                if made is None or needs_of(made) == _NONE or self.late():
                    break
                trial = [deeper if i in lines else one for i, one in enumerate(wedges)]
                try:
                    tried = self.built(layout, trial)
                except InputError:
                    break
                found = self.planned(tried, high - 1, high)
                if found is not None and needs_of(found).cost < needs_of(made).cost:
                    made, shell, wedges = found, tried, trial
        return wedges, shell

    def remaining(
        self, layout: Layout, shell: Shell, made: Plan, wedges: list[float]
    ) -> tuple[Shell, Plan, list[float]]:
        """Lines deepened where the plan of the whole still needs help, the lowest course first."""
        ladder = self.options.wedges
        done: set[int] = set()
        while needs_of(made) != _NONE and not self.late():
            lines = [one for one in lines_below(shell, _helped_courses(shell, made))
                     if one not in done]  # fmt: skip
            if not lines:
                break
            line = lines[0]
            done.add(line)
            for deeper in ladder[ladder.index(wedges[line]) + 1 :]:
                trial = [*wedges[:line], deeper, *wedges[line + 1 :]]
                self.tell("planning the whole", len(done), len(wedges))
                try:
                    tried = self.built(layout, trial)
                except InputError:
                    break
                whole = self.planned(tried)
                if whole is None:
                    break
                if needs_of(whole).cost < needs_of(made).cost:
                    shell, made, wedges = tried, whole, trial
                    done.discard(line)
                    break
        return shell, made, wedges

    def shallower(
        self, layout: Layout, shell: Shell, made: Plan, wedges: list[float]
    ) -> tuple[Shell, Plan, list[float]]:
        """Each line as shallow as the plan of the whole allows, the highest course first."""
        ladder = self.options.wedges
        for line in reversed(range(len(wedges))):
            for shallow in ladder[: ladder.index(wedges[line])]:
                if self.late():
                    return shell, made, wedges
                self.tell("taking wedges back", len(wedges) - line, len(wedges))
                trial = [*wedges[:line], shallow, *wedges[line + 1 :]]
                tried = self.built(layout, trial)
                whole = self.planned(tried)
                if whole is not None and needs_of(whole).cost <= needs_of(made).cost:
                    shell, made, wedges = tried, whole, trial
                    break
        return shell, made, wedges


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


def _helped_courses(shell: Shell, made: Plan) -> set[int]:
    """The courses with blocks that are propped, held, or cannot be put in."""
    helped = (Status.PROPPED, Status.HELD, Status.IMPOSSIBLE)
    course = dict(zip(shell.assembly.names, course_of(shell).tolist(), strict=True))
    names = made.model.assembly.names
    return {course[names[b]] for b, status in enumerate(made.status) if status in helped}


def course_of(shell: Shell) -> Ints:
    """Course (n,) of each block; -1 of ground blocks."""
    course = [int(block.metadata.get("course", -1)) for block in shell.assembly.blocks]
    out = np.array(course, dtype=np.intp)
    out[shell.ground] = -1
    return out


def needs_of(made: Plan) -> BuildNeeds:
    """The help that a plan needs; a block that cannot be put in counts as propped."""
    counts = made.counts
    propped = counts[Status.PROPPED.value] + counts[Status.IMPOSSIBLE.value]
    return BuildNeeds(propped, counts[Status.HELD.value])


def _rank(found: Buildable) -> tuple[int, int, float]:
    """Fewest props, then fewest held blocks, then the shallowest wedges."""
    return (*found.needs.cost, sum(abs(one) for one in found.wedges))
