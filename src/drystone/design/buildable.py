"""Wedges deepened until a shell can be built with the least help.

Source: Kao 2023, section 7.3: wedges where a plan needs help, as shallow as they can be, since
sharp corners break.
"""

from __future__ import annotations

import contextlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.base.arrays import Floats, Ints, number
from drystone.base.display import OneLine, shortened
from drystone.base.errors import InputError, counted
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import Options, checked_call
from drystone.base.table import Table
from drystone.base.workers import WorkerPool
from drystone.contacts import DEFAULT_FRICTION
from drystone.design.search import improved
from drystone.model import Model
from drystone.sequence import Order, Plan, PlanOptions, Rules, Status, plan
from drystone.sequence.rules import courses
from drystone.sequence.stages import check_both
from drystone.sequence.structure import Structure
from drystone.shells import Layout, Shape, Shell, ShellBody, build_shell
from drystone.shells.wedge import LARGEST_WEDGE

WEDGES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.4)
"""Wedges that are tried, the shallowest first: those of the table of the vault, and one more."""


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
    deepened
        Of several layouts, this many are deepened: those that need the least help with the
        shallowest wedges.
    """

    wedges: tuple[float, ...] = WEDGES
    friction: float = DEFAULT_FRICTION
    hands: int = 2
    deepened: int = 3

    def __post_init__(self) -> None:
        super().__post_init__()
        given: Any = self.wedges
        if not isinstance(given, list | tuple):
            raise InputError(
                f"wedges is {shortened(repr(given), 60)}", remedy="give numbers, the least first"
            )
        object.__setattr__(self, "wedges", tuple(number(one, "a wedge") for one in given))
        sizes = [abs(one) for one in self.wedges]
        rising = all(a < b for a, b in pairwise(sizes))
        one_sign = min(self.wedges, default=0.0) >= 0.0 or max(self.wedges) <= 0.0
        if not sizes or not rising or not one_sign or sizes[-1] > LARGEST_WEDGE:
            raise InputError(
                f"the wedges are {', '.join(f'{one:g}' for one in self.wedges) or 'none'}",
                remedy="give them of one sign, the shallowest first, each deeper than the last, "
                f"up to {LARGEST_WEDGE}",
            )
        self._refuse_below(1, "hands", "deepened")


@dataclass(frozen=True, order=True)
class BuildNeeds(OneLine):
    """The help that a shell needs while it is built course by course; fewer props are less.

    Attributes
    ----------
    propped, held
        Numbers of blocks.
    """

    propped: int
    held: int

    def _summary(self) -> str:
        return f"{self.propped} propped, {self.held} held"

    def to_dict(self) -> dict[str, int]:
        """Plain values."""
        return {"propped": self.propped, "held": self.held}


@dataclass(frozen=True)
class TriedLayout(OneLine):
    """A layout that was tried.

    Attributes
    ----------
    layout
    voussoirs
    shallow
        The help that is needed with the shallowest wedges; ``None`` where it cannot be built.
    deepened
        The same with the wedges that were found; ``None`` where they were not searched for.
    message
        Why it cannot be built.
    """

    layout: Layout
    voussoirs: int
    shallow: BuildNeeds | None
    deepened: BuildNeeds | None = None
    message: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "courses": self.layout.courses,
            "blocks": self.layout.blocks,
            "width": self.layout.width,
            "staggered": self.layout.staggered,
            "voussoirs": self.voussoirs,
            "shallow": self.shallow and self.shallow.to_dict(),
            "deepened": self.deepened and self.deepened.to_dict(),
            "message": self.message,
        }


@dataclass(frozen=True, eq=False)
class Buildable(Answer):
    """A shell with the wedges with which its blocks need the least help.

    Attributes
    ----------
    shell
    plan
        Of the whole shell, course by course.
    layout
        With ``wedge``, one for each bed line between two courses.
    needs
        The help that the plan needs.
    before
        The help that the same layout needs with the shallowest wedges.
    tried
        All layouts.
    message
    """

    shell: Shell
    plan: Plan
    layout: Layout
    needs: BuildNeeds
    before: BuildNeeds
    tried: tuple[TriedLayout, ...]
    message: str

    def _summary(self) -> str:
        return self.message

    @property
    def wedges(self) -> tuple[float, ...]:
        """Of the bed lines between two courses, from the springing."""
        wedge: Any = self.layout.wedge
        return tuple(float(one) for one in wedge)

    def deepened(self, shallow: float) -> tuple[int, ...]:
        """The courses whose lower bed line has a deeper wedge than this."""
        return tuple(i + 1 for i, one in enumerate(self.wedges) if abs(one) > abs(shallow))

    @property
    def model(self) -> Model:
        """The whole shell."""
        return self.plan.model.model

    @property
    def title(self) -> str:
        """The help that it needs."""
        return self.message[0].upper() + self.message[1:]

    def sentences(self) -> Sequence[Sentence]:
        """The help that it needs, and the wedges."""
        role = Role.GOOD if self.needs == _NONE else Role.UNSURE
        wedges = ", ".join(f"{one:g}" for one in self.wedges)
        return [
            Sentence(f"built course by course: {self.message}", role),
            Sentence(f"wedges of the bed joints, from the springing: {wedges}"),
        ]

    def tables(self) -> Sequence[Table]:
        """The layouts that were tried."""
        needs = [one.deepened or one.shallow for one in self.tried]
        columns = {
            "courses": [one.layout.courses for one in self.tried],
            "blocks": [one.layout.blocks for one in self.tried],
            "width": [one.layout.width for one in self.tried],
            "staggered": [one.layout.staggered for one in self.tried],
            "voussoirs": [one.voussoirs for one in self.tried],
            "propped": [None if one is None else one.propped for one in needs],
            "held": [None if one is None else one.held for one in needs],
            "message": [one.message for one in self.tried],
        }
        return [Table("layouts", columns, {"width": "m"})]

    def layers(self) -> Scene:
        """The plan."""
        return self.plan.layers()

    def numbers(self) -> Mapping[str, Any]:
        """The help that it needs, the wedges, and all layouts."""
        return {
            "message": self.message,
            **self.needs.to_dict(),
            "before": self.before.to_dict(),
            "voussoirs": len(self.shell.voussoirs),
            "wedges": self.wedges,
            "tried": [one.to_dict() for one in self.tried],
        }


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

    Raises
    ------
    InputError
        No layout can be built, or it was stopped before the first one was planned.

    Examples
    --------
    >>> from drystone.shells import Layout, ShellBody, dome
    >>> layout, body = Layout(courses=2, blocks=6), ShellBody(thickness=0.5)
    >>> found = make_buildable(dome(3.0, 2.0), layout, body)
    >>> found.needs <= found.before
    True
    """
    chosen = BuildableOptions.of(options)
    several = [layouts] if isinstance(layouts, Layout) else list(layouts)
    clock = Clock(time_limit_s, stop)
    with WorkerPool(executor) as pool:
        search = _WedgeSearch(shape, body or ShellBody(), chosen, pool, progress, clock.late)
        return search.run(several)


@dataclass(frozen=True, eq=False)
class _Planned(OneLine):
    """A shell with wedges, one for each bed line between two courses, and its plan."""

    wedges: tuple[float, ...]
    shell: Shell
    plan: Plan

    @property
    def rank(self) -> tuple[BuildNeeds, float]:
        """Least help first, then the shallowest wedges."""
        return needs_of(self.plan), sum(abs(one) for one in self.wedges)


class _WedgeSearch:
    """The search over layouts, and over the wedges of each."""

    def __init__(
        self,
        shape: Shape,
        body: ShellBody,
        options: BuildableOptions,
        pool: WorkerPool,
        progress: Progress | None,
        late: Stop,
    ) -> None:
        self.shape, self.body, self.options = shape, body, options
        self.pool, self.progress, self.late = pool, progress, late
        self.seen: set[tuple[Layout, tuple[float, ...]]] = set()

    def run(self, layouts: list[Layout]) -> Buildable:
        """The best of all layouts."""
        tried: list[TriedLayout] = []
        starts: list[tuple[int, _Planned]] = []
        for done, layout in enumerate(layouts):
            if self.late():
                break
            self.tell("planning layouts", done, len(layouts))
            try:
                shallow = self.options.wedges[0]
                lines = int(course_of(self.built(layout, shallow)).max())
                first = self.planned(layout, (shallow,) * lines)
            except InputError as error:
                tried.append(TriedLayout(layout, 0, None, message=str(error)))
                continue
            if first is None:
                break
            starts.append((len(tried), first))
            tried.append(TriedLayout(layout, len(first.shell.voussoirs), needs_of(first.plan)))
        if not starts:
            if not tried:
                raise InputError(
                    "the search was stopped before its first plan", remedy="give it time"
                )
            why = tried[0].message
            raise InputError(f"no layout was planned: {why}", remedy="try other courses or blocks")
        starts.sort(key=lambda one: needs_of(one[1].plan))
        found: list[tuple[int, _Planned]] = []
        for at, first in starts[: self.options.deepened]:
            best = improved(first, partial(self.proposals, tried[at].layout), self.late)
            tried[at] = replace(tried[at], deepened=needs_of(best.plan))
            found.append((at, best))
            if needs_of(best.plan) == _NONE or self.late():
                break
        at, best = min(found, key=lambda one: one[1].rank)
        before, needs = tried[at].shallow, needs_of(best.plan)
        assert before is not None
        layout = replace(tried[at].layout, wedge=best.wedges)
        deeper = [i + 1 for i, one in enumerate(best.wedges) if one != self.options.wedges[0]]
        words = _message(needs, before, deeper, self.late())
        return Buildable(best.shell, best.plan, layout, needs, before, tuple(tried), words)

    def tell(self, stage: str, done: int, total: int) -> None:
        if self.progress is not None:
            self.progress(stage, done, total)

    def built(self, layout: Layout, wedges: float | Sequence[float]) -> Shell:
        return build_shell(self.shape, replace(layout, wedge=wedges), self.body)

    def planned(self, layout: Layout, wedges: tuple[float, ...]) -> _Planned | None:
        """The shell with wedges and its plan; ``None`` if stopped."""
        shell = self.built(layout, wedges)
        rules = Rules(hands=self.options.hands, order=Order.COURSE)
        found = plan(
            shell.model(friction=self.options.friction),
            options=PlanOptions(rules=rules, anyway=True),
            executor=self.pool.executor,
            stop=self.late,
        )
        return None if found.stopped else _Planned(wedges, shell, found)

    def proposals(self, layout: Layout, now: _Planned) -> Iterator[_Planned]:
        """Other wedges, each tried once."""
        for wedges in self.wedges(now):
            if (layout, wedges) in self.seen:
                continue
            self.seen.add((layout, wedges))
            self.tell("planning wedges", len(self.seen), 0)
            with contextlib.suppress(InputError):  # the shell cannot have them
                found = self.planned(layout, wedges)
                if found is not None:
                    yield found

    def wedges(self, now: _Planned) -> Iterator[tuple[float, ...]]:
        """Deeper ones below courses that need help, then shallower ones, the highest line first."""
        ladder, own = self.options.wedges, now.wedges
        if needs_of(now.plan) != _NONE:
            lines = lines_below(now.shell, _helped_courses(now.shell, now.plan))
            for some in (*([line] for line in lines), lines):
                least = min((abs(own[i]) for i in some), default=np.inf)
                for deeper in (one for one in ladder if abs(one) > least):
                    yield tuple(deeper if i in some else one for i, one in enumerate(own))
        for line in reversed(range(len(own))):
            for shallow in ladder[: ladder.index(own[line])]:
                yield (*own[:line], shallow, *own[line + 1 :])


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


def _message(needs: BuildNeeds, before: BuildNeeds, deeper: Sequence[int], late: bool) -> str:
    """What was found, as a sentence."""
    if needs == _NONE:
        words = "every block stands when it is placed"
    else:
        words = f"{counted(needs.propped, 'block')} propped, {needs.held} held"
    if deeper:
        courses = ", ".join(str(one) for one in deeper)
        plural = "s" if len(deeper) > 1 else ""
        words += f", with deeper wedges below course{plural} {courses}"
    words += f"; {before.propped} propped and {before.held} held with the shallowest wedges"
    return words + ("; it was stopped before all was tried" if late else "")
