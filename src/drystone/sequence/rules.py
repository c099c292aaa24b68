"""Rules of a plan: hands, payload, precedence, order of trial.

Which blocks can leave while others are in place.

Straight directions that no joint blocks are tried first: most blocks have one. If there is none, a
path with rotation is searched, without collision with the blocks in place.
"""

from __future__ import annotations

import enum
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from graphlib import CycleError, TopologicalSorter

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.display import OneLine, named, rounded_up
from drystone.base.errors import InputError, counted
from drystone.base.settings import Options
from drystone.mechanics.corners import distance_from_supports
from drystone.results import Verdict
from drystone.sequence.freedom import TOLERANCE, Freedom, Joints, free_twists, freedom
from drystone.sequence.path_search import NoPath, PathFinder, PathOptions, RemovalPath
from drystone.sequence.robots import Robot, check_robots, why_not
from drystone.sequence.stages import StageAnswer, StagedModel, mask_of, members

COURSE = re.compile(r"^(?:p\d+-)?[A-Za-z]+[-_]?(\d+)[-_.]")
"""Names such as ``c06-b03``, or ``p1-c06-b03`` in a shell of several patches, give the course."""

COUNTLESS = 10**9
"""Largest number of hands for one block in the calculation."""

TOO_HEAVY = "too heavy"
"""How the reason begins for which hands or robots cannot lift a block."""

NO_WAY = "without a way in"
"""What is said of blocks whose reason is that others block every motion, or are there already."""

WAITS = "waiting for them"
"""How the reason begins for which a block has to wait for others that cannot be placed."""


class Order(enum.Enum):
    """The order in which blocks are tried for removal; assembly is the reverse."""

    COURSE = "course"
    """Course by course, the last one first; a course is removed completely before the next one
    begins. Courses are taken from names (``c06-b03``), else from the number of joints to a
    support."""
    TOP = "top"
    """The highest first."""
    BOUNDARY = "boundary"
    """The farthest from a support first."""


@dataclass(frozen=True)
class Rules(Options):
    """Limits and preferences of a plan.

    Attributes
    ----------
    hands : >= 1
        Number of hands or robots: one places a block, each of the others may hold one.
    payload : [kg] > 0
        Mass that each hand can lift or hold. Heavier blocks need several hands; larger forces need
        a prop.
    before
        Pairs of names: the first is placed before the second.
    reach
        Groups of names: every block of a group is placed before any block of the next group. Other
        blocks can be placed at any time.
    order
        Or its name, or a list of names in the order of assembly, which is followed where possible.
        Blocks that it does not name are placed after them, in the default order.
    placed
        Names of blocks that are in place before the plan begins, though they are not fixed.
    """

    hands: int = 2
    payload: float = float("inf")
    before: Sequence[tuple[str, str]] = ()
    reach: Sequence[Sequence[str]] = ()
    order: Order | str | Sequence[str] = Order.TOP
    robots: Sequence[Robot] = ()
    placed: Sequence[str] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.order, str):
            known = [one.value for one in Order]
            if self.order not in known:
                raise InputError(
                    f"order '{self.order}' is not known",
                    remedy=f"use {', '.join(known)}, or give a list of names",
                )
            object.__setattr__(self, "order", Order(self.order))

    @property
    def team(self) -> Sequence[Robot]:
        """The robots; else one for each hand."""
        hands = [Robot(f"hand {i + 1}", payload=self.payload) for i in range(self.hands)]
        return self.robots or hands


@dataclass(frozen=True, eq=False)
class BoundRules:
    """Rules applied to one model.

    Attributes
    ----------
    rules
    after : per block the set of blocks that must be placed later
    rank : (n,) lower is removed earlier
    course : (n,) blocks of a lower course stay while one of a higher course can leave
    lifters : (n,) hands that a block needs
    limit : (n,) [kg]
        Mass whose weight these hands can hold.
    able : (r, n)
        Whether each robot reaches and carries each block; without robots r = 0.
    core
        Free blocks that are in place before the plan begins.
    impossible
        Blocks that are never placed, with reasons.
    removal
        Which blocks the others in place let out.
    """

    rules: Rules
    after: tuple[int, ...]
    rank: Ints
    course: Floats
    lifters: Ints
    limit: Floats
    able: Bools
    core: int
    impossible: Mapping[int, str]
    removal: RemovalTest

    @property
    def hands(self) -> int:
        """Hands or robots."""
        return len(self.able) or self.rules.hands

    @property
    def there(self) -> int:
        """The blocks in place at the end of the plan, as bits."""
        return self.removal.model.everything & ~mask_of(self.impossible)

    def can_leave(self, block: int, placed: int) -> bool:
        """Whether a block may, and can, be removed before the others in place."""
        return not self.after[block] & placed and self.removal.free(block, placed)

    def can_hold(self, blocks: Sequence[int]) -> bool:
        """Whether hands can take some blocks at once; a robot takes one."""
        from scipy.optimize import linear_sum_assignment  # slow to import

        if not len(self.able):
            return int(self.lifters[list(blocks)].sum()) <= self.hands
        able = self.able[:, list(blocks)]
        return bool(able[linear_sum_assignment(~able)].sum() == len(blocks))

    def without_what_falls(self, answer: Callable[[int], StageAnswer]) -> BoundRules:
        """Also without the blocks that fall where those that cannot be placed are absent.

        Parameters
        ----------
        answer
            Of the stage with these blocks in place, as bits.
        """
        impossible, model = dict(self.impossible), self.removal.model
        left = self.there
        while impossible and not (found := answer(left)).stands:
            free = left & ~self.core
            near = model.around(mask_of(impossible)) & free
            wait = mask_of(found.falling) & free or near or free
            if not wait:
                break
            falls = "would" if found.verdict is Verdict.UNSTABLE else "might"
            why = f"{WAITS}: {falls} fall without blocks that cannot be placed"
            impossible |= dict.fromkeys(members(wait), why)
            impossible = _with_later(impossible, self)
            left &= ~mask_of(impossible)
        return replace(self, impossible=impossible)


def bind(rules: Rules, model: StagedModel, removal: RemovalTest) -> BoundRules:
    """Check rules against a model.

    Raises
    ------
    InputError
        Unknown names, contradictory precedence.
    """
    lifters, limit, able = strength(rules, model)
    after = _after(rules, model)
    core = mask_of(model.assembly.indices(list(rules.placed)).tolist()) & model.everything
    course = courses(model) if rules.order is Order.COURSE else np.zeros(len(model.assembly))
    rank = removal_rank(rules.order, model)
    bound = BoundRules(rules, after, rank, course, lifters, limit, able, core, {}, removal)
    return replace(bound, impossible=_impossible(bound))


def strength(rules: Rules, model: StagedModel) -> tuple[Ints, Floats, Bools]:
    """Hands needed per block (n,), mass (n,) [kg] that these can hold, and what robots can do.

    The last is (r, n): whether each robot reaches and carries each block.
    """
    mass = model.assembly.mass
    robots = check_robots(rules.robots)
    if robots:
        able = np.array([robot.manages(model.assembly.centroid, mass) for robot in robots])
        strength = np.array([robot.payload for robot in robots])[:, None]
        best: Floats = np.where(able, strength, 0.0).max(axis=0)
        return np.where(able.any(axis=0), 1, COUNTLESS).astype(np.intp), best, able
    with np.errstate(over="ignore"):  # a very small payload
        needed = np.ceil(mass / rules.payload * (1.0 - 1e-12))
    lifters = np.clip(needed, 1, COUNTLESS).astype(np.intp)
    limit: Floats = rules.payload * lifters.astype(np.float64)
    return lifters, limit, np.zeros((0, len(mass)), dtype=bool)


def too_heavy(rules: Rules, model: StagedModel, blocks: Sequence[int]) -> str:
    """What too heavy blocks weigh, and what would lift them; masses are rounded up."""
    mass = float(model.assembly.mass[list(blocks)].max())
    verb = "weighs" if len(blocks) == 1 else "weigh up to"
    names = named([model.assembly.names[block] for block in blocks])
    said = f"{names} {verb} {rounded_up(mass):g} kg"
    if rules.robots:
        near = [
            robot.payload for robot in rules.robots for b in blocks
            if robot.distance(model.assembly.centroid[b]) <= robot.reach
        ]  # fmt: skip
        remedy = f"give a robot with a payload of {rounded_up(mass):g} kg that reaches them"
        return f"payload {max(near):g} kg: {said}; {remedy}"
    each = f"give a payload of {rounded_up(mass / rules.hands):g} kg"
    needed = int(strength(rules, model)[0][list(blocks)].max())
    remedy = f"{each}, or {counted(needed, 'hand')}" if needed < COUNTLESS else each
    return f"payload {rules.payload:g} kg, {counted(rules.hands, 'hand')}: {said}; {remedy}"


def removal_rank(order: Order | Sequence[str], model: StagedModel) -> Ints:
    """Rank (n,) of each block in the order of removal; ties in reverse numbering."""
    n = len(model.assembly)
    index = np.arange(n)
    height = np.round(model.height / float(model.assembly.size.mean()), 6)
    if isinstance(order, Order):
        keys = {
            Order.TOP: (-index, -height),
            Order.COURSE: (-index, -courses(model)),
            Order.BOUNDARY: (-index, -height, -distances(model)),
        }[order]
    else:
        named = model.assembly.indices(order)
        if len(np.unique(named)) != len(named):
            raise InputError("the order names a block twice", remedy="name each block once")
        place = np.full(n, len(named))
        place[named] = np.arange(len(named))
        keys = (-index, -height, -place)
    rank = np.empty(n, dtype=np.intp)
    rank[np.lexsort(keys)] = index
    return rank


def courses(model: StagedModel) -> Floats:
    """Course (n,) of each block, from its name, or the number of joints between it and a support.

    Names are used if no course above the lowest one is a springing, all of which is fixed or stands
    on supports. In a vault that springs from its first and its last course, joints are counted from
    both sides.
    """
    found = [COURSE.match(name) for name in model.assembly.names]
    number = np.array([float(match[1]) if match else -1.0 for match in found])
    fixed = model.assembly.fixed
    if (number[~fixed] < 0.0).any():
        return distances(model)
    stands = np.array([bool(ground) for ground in model.grounds])
    for course in np.unique(number[number > number[~fixed].min(initial=np.inf)]):
        own = number == course
        if fixed[own].all() or (stands[own].all() and not fixed[own].any()):
            return distances(model)
    return number


def distances(model: StagedModel) -> Floats:
    """Number of joints (n,) from each block to the nearest support; infinity if there is none."""
    away = distance_from_supports(model.assembly, model.contacts)
    return np.where(away < len(away), away, np.inf)


def _after(rules: Rules, model: StagedModel) -> tuple[int, ...]:
    assembly = model.assembly
    after = [0] * len(assembly)
    pairs = [(assembly.index(first), assembly.index(then)) for first, then in rules.before]
    groups = [assembly.indices(group).tolist() for group in rules.reach]
    if len({b for group in groups for b in group}) != sum(map(len, groups)):
        raise InputError("a block is named in two groups", where="reach", remedy="name it once")
    later = 0
    for group in reversed(groups):
        for block in group:
            after[block] |= later & model.everything
        later |= mask_of(group)
    for first, then in pairs:
        if assembly.fixed[then] and not assembly.fixed[first]:
            raise InputError(
                f"'{assembly.names[first]}' cannot come before '{assembly.names[then]}', which is "
                "a support",
                where="before",
                remedy="supports are there from the beginning",
            )
        after[first] |= (1 << then) & model.everything
    try:
        TopologicalSorter({b: members(later) for b, later in enumerate(after)}).prepare()
    except CycleError as error:
        names = " before ".join(f"'{assembly.names[b]}'" for b in reversed(error.args[1]))
        raise InputError(
            f"the order of precedence contradicts itself: {names}",
            where="before",
            remedy="drop one of these",
        ) from error
    return tuple(after)


def _impossible(bound: BoundRules) -> dict[int, str]:
    """The blocks that are never placed: nobody lifts them, they have no way in, or they wait.

    What has no way in is what remains when all others are removed, without regard to stability.
    With fewer blocks in place fewer motions are blocked, so the order does not matter.
    """
    model, removal, out = bound.removal.model, bound.removal, dict[int, str]()
    for block in members(model.everything & ~bound.core):
        if bound.lifters[block] > bound.hands:
            body, robots = model.assembly.blocks[block], bound.rules.robots
            heavy = f"{TOO_HEAVY}: it needs {bound.lifters[block]} hands of this payload"
            out[block] = why_not(robots, body.name, body.centroid, body.mass) if robots else heavy
    out = _with_later(out, bound)
    left = model.everything & ~mask_of(out)
    ordered = mask_of(block for block, later in enumerate(bound.after) if later)
    waiting = left & ~bound.core
    while waiting:
        block = next(members(waiting))
        waiting &= ~(1 << block)
        if not bound.can_leave(block, left):
            continue
        left &= ~(1 << block)
        before = mask_of(b for b in members(left & ordered) if bound.after[b] >> block & 1)
        waiting |= (model.neighbours[block] & left | before) & ~bound.core
    for block in members(left & ~bound.core):
        there = "must be placed before blocks that are there already"
        out[block] = there if removal.free(block, left) else removal.reason(block, left)
    return _with_later(out, bound)


def _with_later(impossible: Mapping[int, str], bound: BoundRules) -> dict[int, str]:
    """Blocks that cannot be placed, with those that must come after one of them."""
    out, names, known = dict(impossible), bound.removal.model.assembly.names, mask_of(impossible)
    queue = list(out)
    for first in queue:
        later = list(members(bound.after[first] & ~known))
        why = f"{WAITS}: to come after '{names[first]}', which cannot be placed"
        out |= dict.fromkeys(later, why)
        known |= bound.after[first]
        queue += later
    return out


EFFORT = 1500
"""Number of swept volumes that are tested before a block counts as blocked during planning.
Chosen."""


class RemovalTest(OneLine):
    """Tests which blocks can be removed while others are in place.

    Parameters
    ----------
    model
    """

    def __init__(self, model: StagedModel) -> None:
        self.model = model
        self._all: dict[int, Joints] = {}
        self._known: dict[tuple[int, int], Freedom] = {}
        self._free: dict[tuple[int, int], bool] = {}
        self._paths: dict[tuple[int, int], RemovalPath | NoPath] = {}

    def _summary(self) -> str:
        return repr(self.model)

    def freedom(self, block: int, placed: int) -> Freedom:
        """Straight directions in which a block can be removed from the blocks in place."""
        key = self._key(block, placed)
        if key not in self._known:
            self._known[key] = freedom(self._normals(*key), self.model.up)
        return self._known[key]

    def direction(self, block: int, placed: int) -> Floats | None:
        """The free direction (3,) nearest to up; None when blocked."""
        return self.freedom(block, placed).preferred

    def free(self, block: int, placed: int) -> bool:
        """Whether it can be removed, straight or with rotation."""
        key = self._key(block, placed)
        if key not in self._free:
            normals = self._normals(*key)
            # most blocks can move straight up or away from all joints; opposite joints have no sum
            away = normals.sum(axis=0)
            length = float(np.linalg.norm(away))
            quick = np.stack([self.model.up, away] if length > TOLERANCE else [self.model.up])
            leaves = bool((normals @ quick.T >= 0.0).all(axis=0).any())
            self._free[key] = leaves or not self.freedom(*key).blocked
        return self._free[key] or self._turns(block, placed)

    def leaves(self, block: int, placed: int, directions: Floats) -> Bools:
        """Whether it can be removed straight, for each direction (d, 3), unit."""
        normals = self._normals(*self._key(block, placed))
        return np.asarray((directions @ normals.T >= -TOLERANCE).all(axis=1))

    def path(self, block: int, placed: int) -> RemovalPath | NoPath:
        """The path on which a block is removed from those in place, or why there is none."""
        key = (block, placed & ~(1 << block))
        if key not in self._paths:
            self._paths[key] = self._finder.path(block, self._here(placed))
        return self._paths[key]

    def reason(self, block: int, placed: int) -> str:
        """Why a block cannot be removed, with the blocking faces."""
        found = self.path(block, placed)
        return found.reason if isinstance(found, NoPath) else ""

    def _turns(self, block: int, placed: int) -> bool:
        """Whether a block without a straight path has one with rotation."""
        joints = Joints.of(self.model.contacts, block, self._here(placed))
        if free_twists(joints.rows(self.model.assembly.blocks[block])).blocked:
            return False
        return isinstance(self.path(block, placed), RemovalPath)

    @cached_property
    def _finder(self) -> PathFinder:
        up = self.model.up.tolist()
        return PathFinder(self.model.model, PathOptions(effort=EFFORT, up=tuple(up)))

    def _key(self, block: int, placed: int) -> tuple[int, int]:
        """The block and its neighbours in place; the joints depend on these only."""
        return block, self.model.neighbours[block] & placed & ~(1 << block)

    def _here(self, placed: int) -> Bools:
        here = np.array(self.model.assembly.fixed)
        here[list(members(placed))] = True
        return here

    def _normals(self, block: int, placed: int) -> Floats:
        """Normals (j, 3) into a block of its joints with those in place."""
        if block not in self._all:
            everything = np.ones(len(self.model.assembly), dtype=bool)
            self._all[block] = Joints.of(self.model.contacts, block, everything)
        joints, fixed = self._all[block], self.model.assembly.fixed
        return joints.normal[[bool(fixed[b] or placed >> b & 1) for b in joints.other.tolist()]]
