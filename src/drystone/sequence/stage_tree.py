"""The stages around a stage: their answers, and what can be removed, held or propped next.

A stage is looked at quickly first. In larger models the neighbourhood of the removed blocks is
checked next, with all other blocks held: where it falls, the whole stage falls.

Where a stage falls, only a change to one of the falling blocks helps: a mechanism that leaves a
block at rest still exists when that block is held or removed. So the next states are, for each
falling block: it is removed too (placed together with the others), or it is propped.

A block without equilibrium between fixed neighbours has none between movable neighbours either.
This decides many stages with a calculation of one block. It also gives a lower bound of the help in
any order: where two blocks need each other, the first one is propped, or both are placed together.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.settings import Stopped
from drystone.loads import STANDARD_GRAVITY
from drystone.results import Verdict
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.rules import BoundRules
from drystone.sequence.scaffold_stages import ScaffoldedStages
from drystone.sequence.stages import Stage, StageAnswer, StagedModel, mask_of, members
from drystone.stability.attempts import FEW_BLOCKS

RAYS = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
"""Directions about a friction cone. Sums of them contain the cone, and reach 2 % farther. Without
this test plans of shells of 40 to 85 blocks take a fifth longer, and need more props."""

FALLING = 1e-5
"""Unbalanced share of the load that counts as no equilibrium."""


class LocalBalance:
    """Equilibrium of single blocks between held neighbours, with a cache."""

    def __init__(self, model: StagedModel) -> None:
        self.model = model
        self._known: dict[tuple[int, int], bool] = {}

    def holds(self, block: int, placed: int) -> bool:
        """Whether contact forces from the blocks in place, all held, may balance a block."""
        around = self.model.neighbours[block] & placed
        key = (block, around)
        if key not in self._known:
            self._known[key] = self._balanced(block, around)
        return self._known[key]

    def _balanced(self, block: int, around: int) -> bool:
        """Whether forces along rays that enclose the friction cones balance it."""
        contacts, assembly = self.model.contacts, self.model.assembly
        here = np.array(assembly.fixed)
        here[list(members(around))] = True
        as_b = (contacts.block_b == block) & here[contacts.block_a]
        as_a = (contacts.block_a == block) & here[contacts.block_b]
        size, wrench = assembly.size[block], self.model.load.wrench[block]
        load = np.append(wrench[:3], wrench[3:] / size)
        length = float(np.linalg.norm(load))
        if length == 0.0 or not contacts.dry[as_a | as_b].all():  # glue may hold it
            return True
        sign = (as_b.astype(np.float64) - as_a)[contacts.interface]
        corner = np.flatnonzero(sign)
        frame = contacts.frame[contacts.interface[corner]] * sign[corner, None, None]
        slide = contacts.friction[contacts.interface[corner], None, None]
        turn = np.stack([np.cos(RAYS), np.sin(RAYS)], axis=1) @ frame[:, 1:]
        ray = frame[:, None, 0] + slide / np.cos(np.pi / len(RAYS)) * turn
        arm = (contacts.point[corner] - assembly.centroid[block]) / size
        forces = np.concatenate([ray, np.cross(arm[:, None], ray)], axis=2).reshape(-1, 6).T
        return len(corner) > 0 and _distance(forces, -load / length) <= FALLING

    def unbalanced(self, blocks: int, placed: int) -> tuple[int, ...]:
        """The given blocks that have no equilibrium among the blocks in place."""
        return tuple(b for b in members(blocks) if not self.holds(b, placed))

    def helpless_pairs(self) -> tuple[int, ...]:
        """Disjoint pairs of blocks, as bits, of which at least one needs help in any order."""
        free = self.model.everything
        pairs = []
        for block in members(free):
            if not free >> block & 1:
                continue
            for other in members(self.model.neighbours[block] & free):
                if self._needs(block, other) and self._needs(other, block):
                    pairs.append(1 << block | 1 << other)
                    free &= ~pairs[-1]
                    break
        return tuple(pairs)

    def _needs(self, block: int, other: int) -> bool:
        """Whether a block has no equilibrium without one neighbour, with all others in place."""
        return not self.holds(block, self.model.everything & ~(1 << other))


def _distance(forces: Floats, load: Floats) -> float:
    """Of a load from the cone of some forces (6, r); zero where it is not found."""
    from scipy.optimize import nnls  # slow to import

    try:
        return float(nnls(forces, load)[1])
    except RuntimeError:  # no convergence
        return 0.0


Cost: TypeAlias = tuple[int, int, int]
"""Number of propped blocks, of held blocks, and of simultaneous placements (of the blocks of a
step, all except the last). Fewer of the first count more than fewer of the next."""

NO_HELP: Cost = (0, 0, 0)

RINGS = 2
"""Rings of neighbours of the removed blocks that are checked alone. Measured on stages of vaults
and domes: with one ring 6 of 43 that stand find no rest state, with two none; of 37 that fall, 31
are found with two rings, in a third to a half of the time of a check."""


@dataclass(frozen=True, eq=False)
class Node:
    """A stage in the search.

    Attributes
    ----------
    placed, props
        Sets of blocks as bits; props are a subset of the placed blocks.
    group
        Blocks removed since the last stage that stands, in the order of removal.
    cost
    parent
        The last stage that stands.
    """

    placed: int
    props: int
    group: tuple[int, ...] = ()
    cost: Cost = NO_HELP
    parent: Node | None = None

    @property
    def propped_first(self) -> bool:
        """Whether the first removed block was propped; it does not count as held then."""
        return self.parent is not None and any(self.parent.props >> b & 1 for b in self.group[:1])

    def joined(self, block: int) -> Node:
        """The node with one more block removed together with the others."""
        props, held, together = self.cost
        first = len(self.group) == 1 and not self.propped_first
        cost = props, held + 1 + first, together + 1
        return replace(
            self, placed=self.placed & ~(1 << block), group=(*self.group, block), cost=cost
        )

    def path(self) -> list[Node]:
        """The stages from the complete structure to this one."""
        out: list[Node] = [self]
        while out[-1].parent is not None:
            out.append(out[-1].parent)
        return out[::-1]


class StageTree:
    """The stages of one model, and what follows from each.

    Parameters
    ----------
    evaluator
    bound
    width
        Number of blocks tried for removal from one stage, the first ones in the order; all when
        left out. Then every stage is checked, as a proof of the least help needs.
    scaffold
        What holds propped blocks. A stage that stands with ideal props must also stand with it.
    carried
        Whether it must; else scaffolding only tells which blocks can be propped.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        bound: BoundRules,
        width: int | None = None,
        scaffold: ScaffoldedStages | None = None,
        carried: bool = True,
    ) -> None:
        self.evaluator = evaluator
        self.carried = carried
        self.model: StagedModel = evaluator.model
        self.bound = bound
        self.width = len(self.model.assembly) if width is None else width
        self.scaffold = scaffold
        self.proppable = self.model.everything if scaffold is None else scaffold.takes
        self.local = LocalBalance(self.model)
        self.quick = self.model.quick is not None and width is not None
        self.few = self.model.largest[0] < FEW_BLOCKS
        self.every = not self.quick or self.model.small

    def likely(self) -> Sequence[Node]:
        """Nodes that are likely to be asked for next; workers compute them too."""
        return ()

    def answer(self, node: Node, *, full: bool = True) -> StageAnswer:
        """The answer of a node: a quick look, and where that does not decide the check if ``full``.

        If a neighbour of the last removed blocks has no equilibrium, neither is needed.
        """
        near = self.model.around(mask_of(node.group))
        loose = self.local.unbalanced(near & node.placed & ~node.props, node.placed)
        if loose:
            return StageAnswer(Verdict.UNSTABLE, "cannot be balanced", loose)
        seen = self.look(node, quick=True) if self.quick else None
        if seen is not None and (seen.verdict is not Verdict.UNDECIDED or not full):
            return seen
        found = self.nearby(node) if self.quick else None
        if found is None or found.stands:
            found = self.look(node, quick=False)
        return found if found.stands or found.falling or seen is None else seen

    def look(self, node: Node, *, quick: bool) -> StageAnswer:
        """The answer of a node; with workers, likely nodes are computed too."""
        ahead = [self.stage(one, quick=self.quick) for one in self.likely()]
        found = self.evaluator.answers([self.stage(node, quick=quick)], ahead=ahead)[0]
        fails = self.failure(node.placed, node.props) if found.stands else None
        return found if fails is None else fails

    def failure(self, placed: int, props: int, *, followed: bool = False) -> StageAnswer | None:
        """The answer of a stage that the scaffolding does not carry; else None.

        ``followed`` as in :meth:`drystone.sequence.scaffold_stages.ScaffoldedStages.result`.

        Raises
        ------
        Stopped
            The time is over.
        """
        if self.scaffold is None or not props or not self.carried:
            return None
        if self.evaluator.late():
            raise Stopped
        answer = self.scaffold.answer(placed, props, followed=followed)
        return None if answer.stands else answer

    def nearby(self, node: Node) -> StageAnswer | None:
        """The neighbourhood of the removed blocks with all others held; None if it is all."""
        near = mask_of(node.group)
        for _ in range(RINGS):
            near = self.widened(near)
        moving = near & node.placed & ~node.props
        held = self.widened(moving) & node.placed & ~moving
        if self.few or not moving or not held & ~node.props:
            return None
        before = None if node.parent is None else (node.parent.placed, node.parent.props)
        return self.evaluator.answer(Stage(moving | held, held, False, before))

    def stage(self, node: Node, *, quick: bool) -> Stage:
        """The stage to check; the search starts from the stage before the last removal."""
        near = None if node.parent is None else (node.parent.placed, node.parent.props)
        return Stage(node.placed, node.props, quick, near)

    def widened(self, blocks: int) -> int:
        """Some blocks and all their neighbours."""
        return blocks | self.model.around(blocks)

    def candidates(self, placed: int) -> Iterator[int]:
        """Blocks that may and can be removed, in this order; of the highest course only."""
        rank, course = self.bound.rank, self.bound.course
        highest = None
        for block in sorted(members(placed & ~self.bound.core), key=lambda b: int(rank[b])):
            if highest is not None and course[block] < highest:
                return
            if self.bound.can_leave(block, placed):
                highest = course[block]
                yield block

    def removals(self, node: Node) -> list[Node]:
        """Stages with one block less, if possible without unsupported blocks."""
        out: list[Node] = []
        hanging: list[Node] = []
        floating = self.model.floating(node.placed)
        for block in self.candidates(node.placed):
            bit = 1 << block
            one = Node(node.placed & ~bit, node.props & ~bit, (block,), node.cost, node)
            air = self.model.floating(one.placed) & ~floating
            (hanging if air else out).append(one)
            if len(out) >= self.width:
                break
        return out or hanging

    def cures(self, node: Node, answer: StageAnswer) -> list[Node]:
        """Stages in which one falling block is removed too, or propped."""
        falling = self.falling(node, answer)
        props, held, together = node.cost
        out = [node.joined(q) for q in falling if self.can_join(node, q)]
        out += [
            replace(node, props=node.props | 1 << p, cost=(props + 1, held, together))
            for p in falling
            if self.proppable >> p & 1
        ]
        return out

    def falling(self, node: Node, answer: StageAnswer) -> list[int]:
        """One of these blocks must be changed; in the order of removal; near the gap if unknown."""
        mask = mask_of(answer.falling) & node.placed & ~node.props
        if not mask:
            movable = node.placed & ~node.props
            mask = self.model.around(mask_of(node.group)) & movable or movable
        return sorted(members(mask), key=lambda b: int(self.bound.rank[b]))

    def can_join(self, node: Node, block: int) -> bool:
        """Whether there are enough hands, and a path, for one more block of a group."""
        if not node.group or self.bound.core >> block & 1:
            return False
        if not self.bound.can_hold([*node.group, block]):
            return False
        if not self.bound.can_leave(block, node.placed):
            return False
        return not self.model.floating(node.placed & ~(1 << block))

    def can_hold(self, node: Node) -> bool:
        """Whether a group can be placed block by block while hands hold the placed ones."""
        if len(node.group) < 2 or node.parent is None:
            return True
        placed = node.placed | mask_of(node.group)
        for number, block in enumerate(node.group[:-1]):  # backwards, as it is removed
            placed &= ~(1 << block)
            held = node.props | mask_of(node.group[number + 1 :])
            answer = self.held_answer(Stage(placed, held, False, (node.placed, node.props)))
            if not answer.stands or overloads(answer, node.group, self.bound.limit, self.model):
                return False
        return True

    def held_answer(self, stage: Stage) -> StageAnswer:
        """The answer of a stage within a step: a quick look, else the check."""
        if self.quick:
            seen = self.evaluator.answer(stage._replace(quick=True))
            if seen.stands:
                return seen
        return self.evaluator.answer(stage)


def overloads(answer: StageAnswer, group: Sequence[int], limit: Floats, model: StagedModel) -> bool:
    """Whether a hand carries more than its payload while a group is placed.

    Parameters
    ----------
    answer
        Of a stage in between.
    group
    limit : (n,) [kg]
        Mass whose weight the hands of a block can hold.
    model
    """
    load, mass = model.load.wrench, model.assembly.mass
    for block in group:
        if block not in answer.reaction:
            continue
        # without a load: standard gravity
        weight = float(np.linalg.norm(load[block, :3])) / float(mass[block]) or STANDARD_GRAVITY
        force = float(np.linalg.norm(answer.reaction[block][:3]))
        if force > (1.0 + 1e-6) * float(limit[block]) * weight:
            return True
    return False
