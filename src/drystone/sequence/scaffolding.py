"""Scaffolding of a plan: struts, ropes, clamps or centring in place of its ideal props.

A plan says which blocks are propped at which stages, and assumes props that hold a block in
every direction. Here each of these blocks gets items of one kind, and each stage is checked again
with them. A table compares what a model takes with each kind, in each order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from itertools import pairwise, product
from typing import Any, NamedTuple, Unpack

import numpy as np

from drystone.answer import (
    Answer,
    Layer,
    LayerKind,
    MarkerShape,
    Role,
    Scene,
    SceneStage,
    Sentence,
    State,
)
from drystone.assembly import Assembly
from drystone.base import units
from drystone.base.arrays import Floats
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, LongWork, checked_call, member_of
from drystone.base.table import Table
from drystone.io.opening import Given, LongHow, as_model
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.sequence import planner
from drystone.sequence.plans import Plan
from drystone.sequence.rules import Order
from drystone.sequence.scaffold_items import (
    Centring,
    Clamp,
    Rope,
    ScaffoldedModel,
    ScaffoldItem,
    Strut,
)
from drystone.sequence.scaffold_places import ScaffoldOptions, Support
from drystone.sequence.scaffold_stages import ScaffoldedStages
from drystone.sequence.stages import Check, check_once, mask_of
from drystone.stability import CheckOptions
from drystone.stability.verdict import check as check_whole

_WIDE = 3.0
"""Width of a strut or a rope, by that of other lines; chosen by eye."""


def scaffold_layers(
    items: Sequence[ScaffoldItem], support: Support, assembly: Assembly
) -> tuple[Layer, ...]:
    """Bars of struts and ropes, edges of centring, a mark for each clamp."""
    if not items:
        return ()
    label = f"{len(items)} {support.words(len(items))}"
    ends: list[tuple[Floats, Floats]] = []
    for item in items:
        if isinstance(item, Strut):
            ends.append((np.array([item.foot]), np.array([item.head])))
        elif isinstance(item, Rope):
            ends.append((np.array([item.at]), np.array([item.anchor])))
        elif isinstance(item, Centring):
            ends.append((item.face, np.roll(item.face, -1, axis=0)))
    if not ends:
        block = assembly.indices([item.block for item in items])
        place = assembly.centroid[block]
        mark = MarkerShape.DIAMOND
        return (Layer("scaffold", label, LayerKind.MARKERS, "added", place, shape=mark),)
    start, end = (np.concatenate(side) for side in zip(*ends, strict=True))
    return (Layer("scaffold", label, LayerKind.LINES, "added", start, end - start, width=_WIDE),)


FEWEST = "fewest-props"
"""The order with the fewest props, by a search without limit. It may cost more than another one."""


@dataclass(frozen=True, eq=False)
class Scaffolding(Answer):
    """What a plan takes with one kind of scaffolding.

    Attributes
    ----------
    plan
    support
    stages
        Table, a row per stage that is held: ``step``, ``blocks`` that are held, ``verdict``,
        ``items``, ``length`` [m], ``peak_force`` [N], ``overloaded`` items, and whether it was
        ``followed`` while it settles: not where it has too many corners.
    metre_stages : [m]
        Sum over the stages of the length in place.
    peak_force : [N]
        Of one item.
    moves
        How often what holds a block is set up.
    cost
        ``metre_stages + moves``. A clamp counts as a metre.
    items
        Everything that is set up, block by block.
    failed
        Steps, from 1, that do not stand with it, or overload it, or that do not stand and have
        nothing that is held.
    staying
        Where some of it stays, for how many contact stiffnesses the whole stands with it.
    """

    plan: Plan
    support: Support
    stages: Table
    metre_stages: float
    peak_force: float
    moves: int
    cost: float
    items: tuple[ScaffoldItem, ...]
    failed: tuple[int, ...]
    staying: str = ""

    @property
    def works(self) -> bool:
        """Whether every stage was checked and stands within the limits."""
        return not (self.failed or self.stopped)

    @property
    def propped(self) -> tuple[int, ...]:
        """Blocks that it holds at some stage: what the source counts (Kao 2023, section 7.5)."""
        return tuple(sorted({prop.block for prop in self.plan.props}))

    @property
    def most_at_once(self) -> int:
        """Blocks that it holds at one stage, at most."""
        return max((len(step.props) for step in self.plan.steps), default=0)

    @property
    def model(self) -> Model:
        """The complete model."""
        return self.plan.model.model

    @property
    def title(self) -> str:
        """Whether every stage stands with it."""
        if self.works:
            looked = int((self.stages["followed"] == "no").sum())
            but = f"; {counted(looked, 'stage')} only looked at, not followed" if looked else ""
            return f"Every stage stands with {self.support.words(2)}{but}"
        failed = f"{counted(len(self.failed), 'step')} of {len(self.plan.steps)} do not stand"
        return f"Not every stage stands with {self.support.words(2)}: {self.stopped or failed}"

    def sentences(self) -> Sequence[Sentence]:
        """Whether every stage stands, and what it takes."""
        unsure = self.stopped or (self.works and "no" in self.stages["followed"])
        role = Role.UNSURE if unsure else Role.GOOD if self.works else Role.BAD
        known = " where a rest state was found" if self.failed else ""
        blocks, of = len(self.propped), len(self.plan.model.assembly.free)
        takes = (
            f"{blocks} of {counted(of, 'block')} propped, at most {self.most_at_once} at once: "
            f"{self.metre_stages:.3g} m times stages, at most "
            f"{units.quantity(self.peak_force, 'N')} in one{known}, {counted(self.moves, 'move')}, "
            f"cost {self.cost:.3g}"
        )
        stay = [Sentence(self.staying)] if self.staying else []
        return [Sentence(self.title, role), Sentence(takes), *stay]

    def tables(self) -> Sequence[Table]:
        """The stages that are held."""
        return [self.stages]

    def numbers(self) -> Mapping[str, Any]:
        """What it takes, and everything that is set up."""
        return {
            "support": self.support,
            "propped": [self.assembly.names[block] for block in self.propped],
            "most_at_once": self.most_at_once,
            "metre_stages": self.metre_stages,
            "peak_force": self.peak_force,
            "moves": self.moves,
            "cost": self.cost,
            "failed": self.failed,
            "staying": self.staying,
            "items": [item_numbers(item) for item in self.items],
        }

    def layers(self) -> Scene:
        """The plan, with what is set up at every stage.

        A stage that does not stand with it, or overloads it, says so.
        """
        scene, plan = self.plan.layers(), self.plan
        shown = [number for number, step in enumerate(plan.steps) for _ in step.blocks]
        stages = [
            self._stage(number, stage)
            for number, stage in zip(shown, scene.stages[: len(shown)], strict=True)
        ]
        (summary,) = scene.stages[len(shown) :]
        every = (
            replace(one, label=f"{one.label} in all")
            for one in scaffold_layers(self.items, self.support, self.assembly)
        )
        told, takes, *_ = self.sentences()
        ideal = f"with ideal props: {summary.message}"
        summary = replace(
            summary,
            layers=(*summary.layers, *every),
            headline=told.text,
            message=takes.text if self.works else ideal,
            role=told.role,
        )
        return replace(scene, stages=(*stages, summary))

    def _stage(self, number: int, stage: SceneStage) -> SceneStage:
        """A stage with what is set up at it, and with what is said of it."""
        kind, held = self.support, np.flatnonzero(stage.state == State.PROPPED)
        items = [item for item in self.items if int(self.assembly.indices([item.block])[0]) in held]
        layers = scaffold_layers(items, kind, self.assembly)
        forces = [
            replace(one, label=f"ideal {one.label} (in place of props: {kind.words(2)})")
            if one.key == "help"
            else one
            for one in stage.layers
        ]
        stage = replace(stage, layers=(*forces, *layers))
        row = next((one for one in self.stages if one["step"] == number + 1), None)
        if number + 1 not in self.failed or row is None:  # nothing is held, and it does not stand
            return stage
        over, verdict = int(row["overloaded"]), Verdict(row["verdict"])
        role = Role.of(verdict)
        if verdict is Verdict.STABLE:
            said = f"{kind.words(over)} overloaded: {over} of {len(items)}"
            role = Role.BAD
        else:
            known = "does not stand" if verdict is Verdict.UNSTABLE else "not known to stand"
            said = f"{known} with {kind.words(len(items))}"
        block = stage.headline.partition(":")[0]
        return replace(stage, headline=f"{block}: {said}", role=role)

    def _summary(self) -> str:
        ends = "works" if self.works else f"fails at {counted(len(self.failed), 'stage')}"
        return (
            f"{self.support.value}: {ends}, {self.metre_stages:.3g} m stages, "
            f"{self.peak_force:.3g} N, {counted(self.moves, 'move')}, cost {self.cost:.3g}"
        )


@checked_call
def scaffolding(
    plan: Plan,
    support: Support | str = Support.STRUT,
    *,
    options: ScaffoldOptions | None = None,
    check: Check = check_once,
    **work: Unpack[LongWork],
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

    Raises
    ------
    InputError
        A kind that is not known, or a propped block without a face for it.

    Examples
    --------
    >>> from drystone.models import arch
    >>> from drystone.sequence import Rules, PlanOptions, plan
    >>> found = plan(arch(0.3, 5), friction=0.6, options=PlanOptions(rules=Rules(hands=1)))
    >>> scaffolding(found, "strut").works
    True
    >>> scaffolding(found, "rope", options=ScaffoldOptions(limit=450.0)).failed
    (3, 4)

    One rope of the crown, which slides off its one neighbour, carries up to 513 N.
    """
    stages = ScaffoldedStages(plan.model.model, support, options, check)
    clock = Clock.of(work)
    propped = [(number, step) for number, step in enumerate(plan.steps) if step.props]
    rows: list[_Row] = []
    several = [(step.placed, mask_of(step.props)) for _, step in propped]
    answers = clock.answers(partial(_checked, stages), several, "scaffolding")
    for (whole, result), (number, step) in zip(answers, propped, strict=False):
        told = ", ".join(plan.model.assembly.names[b] for b in sorted(step.props))
        followed = "no" if stages.only_looked_at(whole, result) else "yes"
        rows.append(_row(number + 1, told, whole, result, followed))
    failed = [row.step for row in rows if row.verdict != Verdict.STABLE.value or row.overloaded]
    failed += [i for i, one in enumerate(plan.steps, 1) if not (one.props or one.answer.stands)]
    columns = {key: [getattr(row, key) for row in rows] for key in _Row._fields}
    stopped = clock.reason if len(rows) < len(propped) else ""
    stay = not (failed or stopped) and plan.steps and plan.steps[-1].props
    held = [set[int](), *(set(step.props) for step in plan.steps)]
    moves = sum(len(now - before) for before, now in pairwise(held))
    metres = sum(row.length for row in rows)
    return Scaffolding(
        plan,
        stages.support,
        Table("scaffolding", columns, {"length": "m", "peak_force": "N"}),
        metres,
        max((row.peak_force for row in rows if row.peak_force == row.peak_force), default=0.0),
        moves,
        metres + moves,
        tuple(item for prop in plan.props for item in stages.items(prop.block)),
        tuple(sorted(failed)),
        _staying(stages, plan.steps[-1].placed, mask_of(stay), clock) if stay else "",
        stopped=stopped,
    )


def _staying(stages: ScaffoldedStages, placed: int, held: int, clock: Clock) -> str:
    """How the complete structure stands with what stays: for how many contact stiffnesses."""
    whole = stages.result(placed, held)[0]
    found = check_whole(whole.model, options=CheckOptions.robust(), stop=clock.late)
    what, tried = stages.support.words(len(whole.items)), found.samples
    told = f"stands for {tried.standing} of {tried.tried} contact stiffnesses tried"
    if not tried.standing:
        told = found.title[0].lower() + found.title[1:]
    return f"{len(whole.items)} {what} stay: with them the whole {told}"


class _Row(NamedTuple):
    """A stage with its items: what of them is there, and what they carry."""

    step: int
    blocks: str
    verdict: str
    items: int
    length: float
    peak_force: float
    overloaded: int
    followed: str


def _row(number: int, held: str, whole: ScaffoldedModel, result: Result, followed: str) -> _Row:
    largest, over = np.nan, 0
    if result.force is not None:
        largest, over = float(whole.force(result).max()), len(whole.overloaded(result))
    length = sum(1.0 if isinstance(item, Clamp) else item.length for item in whole.items)
    return _Row(
        number, held, result.verdict.value, len(whole.items), length, largest, over, followed
    )


def item_numbers(item: ScaffoldItem) -> dict[str, Any]:
    """An item as plain values; limits that it does not have are None."""
    told = {one.name: getattr(item, one.name) for one in fields(item)}
    told = {key: v.tolist() if isinstance(v, np.ndarray) else v for key, v in told.items()}
    told = {key: None if v == float("inf") else v for key, v in told.items()}
    return told | {"length": item.length}


def _checked(stages: ScaffoldedStages, stage: tuple[int, int]) -> tuple[ScaffoldedModel, Result]:
    return stages.result(*stage, followed=True)


@checked_call
def compare_scaffolding(
    given: Given,
    kinds: Sequence[Support | str] = tuple(Support),
    orders: Sequence[Order | str] = (Order.TOP, Order.COURSE),
    *,
    options: planner.PlanOptions | None = None,
    **how: Unpack[LongHow],
) -> Table:
    """Plan a model with each kind of scaffolding in each order, and compare what it takes.

    Ended early, plans that are missing are rows with a ``message`` only.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    kinds
    orders
        An order, its name, or ``"fewest-props"``: the search goes on until no order has fewer
        props. Fewer props can stay for more stages, so its cost may be higher.
    options
        Of each plan; ``rules.order``, ``scaffold`` and ``patience`` are set here.

    Returns
    -------
    Table
        The cheapest first, those with failed stages last: ``support``, ``order``, ``propped`` and
        ``held`` blocks, ``metre_stages`` [m], ``peak_force`` [N] of an item, ``moves``, ``cost``,
        ``failed_stages``, ``message``.

    Raises
    ------
    InputError
        A kind or an order is not known, or there is none.

    Examples
    --------
    >>> from drystone.models import arch
    >>> table = compare_scaffolding(arch(0.3, 5), ["clamp", "centring"], ["top"], friction=0.6)
    >>> table["failed_stages"].tolist()
    [0, 0]
    """
    clock = Clock.of(how)
    model = as_model(given, **how)
    chosen = planner.PlanOptions.of(options)
    named = [member_of(Support, one, "support") for one in kinds]
    names = [_order_name(order) for order in orders]
    if not named or not names:
        raise InputError("nothing to compare", remedy="give a kind and an order")
    rows: list[dict[str, object]] = []
    for name, kind in product(names, named):
        clock.tell("scaffolding", len(rows), len(named) * len(names))
        fewest = name == FEWEST
        rules = replace(chosen.rules, order=Order.TOP if fewest else Order(name))
        patience = float("inf") if fewest else chosen.patience
        planned = planner.plan(
            model,
            options=replace(chosen, rules=rules, scaffold=kind, patience=patience),
            **clock.rest,
        )
        made = None
        if planned.steps:
            made = scaffolding(
                planned,
                kind,
                options=chosen.scaffold_options,
                executor=clock.workers,
                stop=clock.late,
            )
        rows.append(_compared(name, kind, planned, None if made is None or made.stopped else made))
    rows.sort(key=lambda row: (row["cost"] != row["cost"], row["failed_stages"], row["cost"]))
    columns = {key: [row[key] for row in rows] for key in rows[0]}
    return Table("scaffolding compared", columns, {"metre_stages": "m", "peak_force": "N"})


def _order_name(order: Order | str) -> str:
    name = order.value if isinstance(order, Order) else order
    known = (*(one.value for one in Order), FEWEST)
    if name not in known:
        raise InputError(f"order '{name}' is not known", remedy=f"use {', '.join(known)}")
    return name


def _compared(name: str, kind: Support, plan: Plan, made: Scaffolding | None) -> dict[str, object]:
    """What a model takes with one kind in one order."""
    counts = plan.counts
    numbers = ("metre_stages", "peak_force", "moves", "cost")
    return {
        "support": kind.value,
        "order": name,
        "propped": counts["propped"],
        "held": counts["held"],
        **{one: np.nan if made is None else float(getattr(made, one)) for one in numbers},
        "failed_stages": len(plan.steps) if made is None else len(made.failed),
        "message": plan.message,
    }
