"""One model planned with each kind of scaffolding, in each order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias, Unpack

import numpy as np

from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.table import Table
from drystone.io.opening import Given, How, as_model
from drystone.sequence.planner import PlanOptions, plan
from drystone.sequence.plans import Plan
from drystone.sequence.rules import Order
from drystone.sequence.scaffold_places import Support
from drystone.sequence.scaffold_plans import Scaffolding, scaffolding

FEWEST = "fewest-props"
"""The order with the fewest props, by a search without limit. It may cost more than another one."""

Compared: TypeAlias = tuple[str, Support, Plan, Scaffolding | None]


@checked_call
def compare_scaffolding(
    given: Given,
    kinds: Sequence[Support | str] = tuple(Support),
    orders: Sequence[Order | str] = (Order.TOP, Order.COURSE),
    *,
    options: PlanOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
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
        A kind or an order is not known.

    Examples
    --------
    >>> from drystone.models import arch
    >>> table = compare_scaffolding(arch(0.3, 5), ["clamp", "centring"], ["top"], friction=0.6)
    >>> table["failed_stages"].tolist()
    [0, 0]
    """
    model = as_model(given, **how)
    chosen = PlanOptions.of(options)
    named = [Support.named(one) for one in kinds]
    clock = Clock(time_limit_s, stop)
    found: list[Compared] = []
    for name in [_order(one) for one in orders]:
        fewest = name == FEWEST
        rules = replace(chosen.rules, order=Order.TOP if fewest else Order(name))
        for kind in named:
            if progress is not None:
                progress("scaffolding", len(found), len(named) * len(orders))
            one = replace(
                chosen,
                rules=rules,
                scaffold=kind,
                patience=float("inf") if fewest else chosen.patience,
            )
            planned = plan(
                model,
                options=one,
                executor=executor,
                progress=progress,
                stop=stop,
                time_limit_s=clock.left_s,
            )
            made = None
            if planned.steps:
                made = scaffolding(
                    planned,
                    kind,
                    options=chosen.scaffold_options,
                    executor=executor,
                    stop=clock.late,
                )
                made = None if made.stopped else made
            found.append((name, kind, planned, made))
    found.sort(key=_rank)
    return _table(found)


def _order(order: Order | str) -> str:
    known = (*(one.value for one in Order), FEWEST)
    name = order.value if isinstance(order, Order) else order
    if name not in known:
        raise InputError(f"order '{name}' is not known", remedy=f"use {', '.join(known)}")
    return name


def _rank(one: Compared) -> tuple[bool, int, float]:
    made = one[3]
    return (True, 0, 0.0) if made is None else (False, len(made.failed), made.cost)


def _table(found: Sequence[Compared]) -> Table:
    counts = [one.counts for _, _, one, _ in found]
    made = [one for *_, one in found]

    def numbers(name: str) -> list[float]:
        return [np.nan if one is None else float(getattr(one, name)) for one in made]

    return Table(
        "scaffolding compared",
        {
            "support": [kind.value for _, kind, _, _ in found],
            "order": [name for name, *_ in found],
            "propped": [one["propped"] for one in counts],
            "held": [one["held"] for one in counts],
            "metre_stages": numbers("metre_stages"),
            "peak_force": numbers("peak_force"),
            "moves": numbers("moves"),
            "cost": numbers("cost"),
            "failed_stages": [
                len(plan.steps) if one is None else len(one.failed) for _, _, plan, one in found
            ],
            "message": [plan.message for _, _, plan, _ in found],
        },
        {"metre_stages": "m", "peak_force": "N"},
    )
