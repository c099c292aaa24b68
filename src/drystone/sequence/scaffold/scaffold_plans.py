"""Scaffolding of a plan: the ideal props of its stages replaced by struts, ropes, clamps, centring.

A plan says which blocks are propped at which stages, and assumes props that hold a block in
every direction. Here each of these blocks gets items of one kind, and each stage is checked again
with them.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import shapely

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.progress import Progress
from drystone.base.settings import Options
from drystone.base.table import Table
from drystone.geometry.frames import frames_from_normals
from drystone.model import Model
from drystone.sequence.plans import Plan
from drystone.sequence.scaffold.scaffold_items import (
    Centring,
    Clamp,
    Rope,
    ScaffoldItem,
    Strut,
    with_scaffold,
)
from drystone.sequence.stage.stage_checks import Check, check_once
from drystone.sequence.stage.stages import members

INSET = 0.6
"""Distance of heads and knots from the middle of their face, by that of its corners; chosen, well
inside the face."""
SLOPING = 0.3
"""Least cosine between a face that carries a block and the direction of its load; chosen, about 70
degrees."""


LEAST_FREE = 0.05
"""Least share of a face that must be free of joints for an item; chosen."""


class Support(enum.Enum):
    """With what the blocks of a plan are held."""

    STRUT = "strut"
    """Struts along the load under the lower face, one near each of its corners."""
    ROPE = "rope"
    """Ropes along the load from the upper face up to one level."""
    CLAMP = "clamp"
    """One clamp, or hand, at the centroid."""
    CENTRING = "centring"
    """Centring under the lower face."""


@dataclass(frozen=True)
class ScaffoldOptions(Options):
    """What scaffolding may bear, and what it costs.

    Attributes
    ----------
    limit : [N]
        Of one strut, rope, clamp, or the centring under one block.
    moment : [N m]
        Of one clamp.
    friction
        Between centring and blocks.
    clear : [m]
        Height of the anchors of ropes above the highest block.
    stage_cost
        Of a metre for one stage. A clamp counts as one metre.
    move_cost
        Of setting up what holds one block, once.
    """

    limit: float = float("inf")
    moment: float = float("inf")
    friction: float = 0.6
    clear: float = 1.0
    stage_cost: float = 1.0
    move_cost: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._refuse_unless_positive("limit", "moment")
        self._refuse_below(0.0, "friction", "clear", "stage_cost", "move_cost")


@dataclass(frozen=True, eq=False)
class Scaffolding(OneLine):
    """What a plan takes with one kind of scaffolding.

    Attributes
    ----------
    support
    stages
        Table, a row per stage that is held: ``step``, ``blocks`` that are held, ``verdict``,
        ``items``, ``length`` [m], ``peak_force`` [N], ``overloaded`` items.
    metre_stages : [m]
        Sum over the stages of the length in place.
    peak_force : [N]
        Of one item.
    moves
        How often what holds a block is set up.
    cost
        ``stage_cost * metre_stages + move_cost * moves``.
    failed
        Steps, from 0, that do not stand with it, or overload it.
    """

    support: Support
    stages: Table
    metre_stages: float
    peak_force: float
    moves: int
    cost: float
    failed: tuple[int, ...]

    @property
    def works(self) -> bool:
        """Whether every stage stands within the limits."""
        return not self.failed

    def _summary(self) -> str:
        ends = "works" if self.works else f"fails at {counted(len(self.failed), 'stage')}"
        return (
            f"{self.support.value}: {ends}, {self.metre_stages:.3g} m stages, "
            f"{self.peak_force:.3g} N, {counted(self.moves, 'move')}, cost {self.cost:.3g}"
        )


def scaffolding(
    plan: Plan,
    support: Support | str = Support.STRUT,
    *,
    options: ScaffoldOptions | None = None,
    check: Check = check_once,
    progress: Progress | None = None,
) -> Scaffolding:
    """Check the stages of a plan again, with scaffolding in place of its ideal props.

    Parameters
    ----------
    plan
    support
        The kind, or its name.
    options
    check
        Tells whether a stage stands.
    progress

    Raises
    ------
    InputError
        A kind that is not known, or a propped block without a face for it.

    Examples
    --------
    >>> from drystone.models import arch
    >>> from drystone.sequence import Rules, PlanOptions, plan
    >>> found = plan(arch(0.3, 5), friction=0.6, options=PlanOptions(rules=Rules(hands=1)))
    >>> scaffolding(found, "clamp").works, scaffolding(found, "strut").failed
    (True, (2, 3))

    The crown slides off its one neighbour; struts along the load do not push sideways.
    """
    chosen = ScaffoldOptions.of(options)
    kind = _kind(support)
    model = plan.model.model
    rows: list[tuple[object, ...]] = []
    failed, total, peak, held_before, moves = [], 0.0, 0.0, frozenset[int](), 0
    make = partial(items_of, model, support=kind, options=chosen)
    items = {block: make(block) for step in plan.steps for block in step.props}
    for number, step in enumerate(plan.steps):
        if progress is not None:
            progress("scaffolding", number, len(plan.steps))
        held = frozenset(step.props)
        moves += len(held - held_before)
        held_before = held
        if not held:
            continue
        here = [*np.flatnonzero(model.assembly.fixed).tolist(), *members(step.placed)]
        mine = [item for block in sorted(held) for item in items[block]]
        whole = with_scaffold(model.subset(sorted(here)), mine)
        result = check(whole.model)
        bad = whole.overloaded(result) if result.force is not None else ()
        largest = float(whole.force(result).max()) if result.force is not None else np.nan
        length = sum(item.length if not isinstance(item, Clamp) else 1.0 for item in mine)
        total += length
        peak = max(peak, largest) if largest == largest else peak
        if not result.stable or bad:
            failed.append(number)
        told = ", ".join(model.assembly.names[b] for b in sorted(held))
        rows.append((number, told, result.verdict.value, len(mine), length, largest, len(bad)))
    names = ("step", "blocks", "verdict", "items", "length", "peak_force", "overloaded")
    columns = {name: [row[i] for row in rows] for i, name in enumerate(names)}
    table = Table("scaffolding", columns, {"length": "m", "peak_force": "N"})
    cost = chosen.stage_cost * total + chosen.move_cost * moves
    return Scaffolding(kind, table, total, peak, moves, cost, tuple(failed))


def compare_scaffolding(
    plans: Sequence[tuple[str, Plan]],
    supports: Sequence[Support | str] = tuple(Support),
    *,
    options: ScaffoldOptions | None = None,
    progress: Progress | None = None,
) -> Table:
    """A row per plan and kind of scaffolding.

    Parameters
    ----------
    plans
        Plans of one model, with what to call them, such as the order.
    supports
    options
    progress
    """
    rows = []
    for name, plan in plans:
        for support in supports:
            found = scaffolding(plan, support, options=options, progress=progress)
            rows.append((name, plan.counts, found))
    return Table(
        "scaffolding compared",
        {
            "plan": [name for name, _, _ in rows],
            "support": [one.support.value for _, _, one in rows],
            "propped": [counts["propped"] for _, counts, _ in rows],
            "metre_stages": [one.metre_stages for _, _, one in rows],
            "peak_force": [one.peak_force for _, _, one in rows],
            "moves": [one.moves for _, _, one in rows],
            "cost": [one.cost for _, _, one in rows],
            "failed_stages": [len(one.failed) for _, _, one in rows],
        },
        {"metre_stages": "m", "peak_force": "N"},
    )


def items_of(
    model: Model, block: int, *, support: Support, options: ScaffoldOptions
) -> tuple[ScaffoldItem, ...]:
    """The items of one kind that hold one block.

    Parameters
    ----------
    model
        Complete: faces that are joints in it carry no item.
    block
    support
    options

    Raises
    ------
    InputError
        It has no free face that looks along, or against, the load.
    """
    name = model.assembly.names[block]
    if support is Support.CLAMP:
        return (Clamp(name, options.limit, options.moment),)
    total = model.load.wrench[model.assembly.free, :3].sum(axis=0)
    down = total / np.linalg.norm(total)
    facing = -1.0 if support is Support.ROPE else 1.0
    face = _free_face(model, block, facing * down)
    if face is None:
        raise InputError(
            f"no free face of it takes a {support.value}",
            where=f"block '{name}'",
            remedy="use a clamp",
        )
    heights = [float((one.vertices @ down).max()) for one in model.assembly.blocks]
    ground, top = max(heights), min(float((b.vertices @ down).min()) for b in model.assembly.blocks)
    points = face.mean(axis=0) + INSET * (face - face.mean(axis=0))
    if support is Support.CENTRING:
        height = ground - float(face.mean(axis=0) @ down)
        return (Centring(name, options.limit, face, options.friction, height),)
    if support is Support.ROPE:
        return tuple(
            Rope(name, options.limit, at, at - (at @ down - top + options.clear) * down)
            for at in points
        )
    reach = 1e-3 * float(model.assembly.size[block])
    return tuple(
        Strut(name, options.limit, head, head + max(ground - float(head @ down), reach) * down)
        for head in points
    )


def _free_face(model: Model, block: int, direction: Floats) -> Floats | None:
    """The part (c, 3) of a face without joints that looks most along a direction, by its area."""
    body, contacts = model.assembly.blocks[block], model.contacts
    own = np.flatnonzero((contacts.block_a == block) | (contacts.block_b == block))
    best, found = 0.0, None
    for loop in body.faces:
        corner = body.vertices[list(loop)]
        area = 0.5 * np.cross(corner - corner[0], np.roll(corner, -1, 0) - corner[0]).sum(0)
        size = float(np.linalg.norm(area))
        slope = float(area @ direction) / size
        if slope <= SLOPING:
            continue
        frame = frames_from_normals((area / size)[None])[0]
        face = shapely.Polygon((corner - corner[0]) @ frame[1:].T)
        for k in own.tolist():
            joint = contacts.polygon(k) - corner[0]
            if len(joint) >= 3 and np.abs(joint @ frame[0]).max() < 1e-3 * np.sqrt(size):
                face = face.difference(shapely.Polygon(joint @ frame[1:].T).buffer(0.0))
        free = max(shapely.get_parts(face), key=lambda part: part.area, default=None)
        if free is not None and free.area > LEAST_FREE * size and free.area * slope > best:
            best = free.area * slope
            ring = shapely.get_coordinates(shapely.geometry.polygon.orient(free).exterior)[:-1]
            found = corner[0] + ring @ frame[1:]
    return found


def _kind(support: Support | str) -> Support:
    try:
        return Support(support)
    except ValueError as error:
        known = ", ".join(one.value for one in Support)
        raise InputError(f"support '{support}' is not known", remedy=f"use {known}") from error


__all__ = [
    "ScaffoldOptions",
    "Scaffolding",
    "Support",
    "compare_scaffolding",
    "items_of",
    "scaffolding",
]
