"""All calls of drystone: a question in, a plain answer out.

An answer has plain values only, so that it can be kept as a line of JSON. It has what physics
determines, and what a user is told: forces of statically indeterminate joints are left out but for
the thrust on the supports, which is compared loosely.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from drystone import (
    CheckOptions,
    Model,
    Result,
    Verdict,
    check,
    limit_friction,
    limit_load,
    limit_tilt,
    plan,
    settle,
)
from drystone.design import MendOptions, find_mends
from drystone.limits import Limit, LimitOptions
from drystone.sequence import PlanOptions, Rules

Answer = dict[str, Any]

WIDTH = 1e-3
"""Of the brackets of limits: degrees, coefficients and factors."""
TINY = 1e-300
"""In place of zero, where it divides."""


def verdict(model: Model) -> Answer:
    """Verdict and its word, what falls and where it goes, what the supports carry."""
    result = check(model)
    found: Answer = {"verdict": result.verdict.value, "word": _word(result)}
    if result.verdict is Verdict.UNSTABLE:
        found["falls"] = spans(result.falling)
        if result.mechanism is not None:
            found |= _first_motion(result)
    if result.verdict is Verdict.STABLE and result.force is not None:
        found |= _forces(result)
    return found


def _word(result: Result) -> str:
    """Robust, sensitive or settles where it stands; why not where it is undecided."""
    settled = result.settlement
    if result.verdict is Verdict.STABLE:
        if settled is not None:
            return "settles"
        samples = check(result.model, options=CheckOptions.robust()).samples
        return "robust" if samples.standing == samples.tried else "sensitive"
    if result.verdict is Verdict.UNSTABLE:
        return ""
    return "" if settled is None else str(settled.outcome.value)


def _first_motion(result: Result) -> Answer:
    """Mean motion of the falling blocks by mass, and the motion of each block by the largest."""
    assert result.mechanism is not None
    mass = np.array([block.mass for block in result.assembly.blocks])
    motion = result.mechanism[:, :3]
    drift = mass[list(result.falling)] @ motion[list(result.falling)]
    size = np.linalg.norm(motion, axis=1)
    largest = int(np.argmax(size > (1.0 - 1e-6) * size.max(initial=0.0)))
    # blocks that were followed are seen at some moment, and the slow ones lean this way or that
    mean = (
        None if result.settlement is not None else drift / max(float(np.linalg.norm(drift)), TINY)
    )
    return {
        "drift": None if mean is None else rounded(mean, 3),
        "moves": [largest, *rounded(motion[largest] / max(float(size[largest]), TINY), 3)],
        "_motion": motion / max(float(size.max(initial=0.0)), TINY),
    }


def _forces(result: Result) -> Answer:
    """By the weight: total force on the supports, thrust, and the largest unbalanced force."""
    assembly, contacts = result.assembly, result.contacts
    fixed = assembly.fixed
    joint, on_b = contacts.interface, result.world_force()
    a, b = contacts.block_a[joint], contacts.block_b[joint]
    total = np.zeros((len(assembly), 3))
    np.add.at(total, b, on_b)
    np.subtract.at(total, a, on_b)
    load = result.load.wrench[:, :3]
    weight = max(float(np.abs(load[~fixed]).sum()), TINY)
    unbalanced = np.linalg.norm((total + load)[~fixed], axis=1).max(initial=0.0) / weight
    up = -load.sum(axis=0) / max(float(np.linalg.norm(load.sum(axis=0))), TINY)
    apart = total[fixed] - np.outer(total[fixed] @ up, up)
    found = {"reaction": rounded(total[fixed].sum(axis=0) / weight, 5)}
    if result.settlement is None:
        found["unbalanced"] = bool(unbalanced > 1e-6)
        found["thrust"] = round(float(np.linalg.norm(apart, axis=1).sum()) / weight, 3)
    return found


def limit(model: Model, kind: str, by: Any) -> Answer:
    """A limit ``tilt``, ``load`` or ``friction`` of equilibrium and of rest, and what falls."""
    options = LimitOptions(width=WIDTH)
    if kind == "tilt":
        found = limit_tilt(model, by, options=options)
    elif kind == "load":
        found = limit_load(model, by, options=options)
    else:
        found = limit_friction(model, options=options)
    return _plain_limit(found)


def _plain_limit(found: Limit) -> Answer:
    rest = found.best
    return {
        "equilibrium": _value(found.equilibrium.value),
        "stands": _value(rest.stands),
        "falls": _value(rest.falls),
        "blocks": "" if rest.falling is None else spans(rest.falling.falling),
        "islands": len(found.islands),
    }


def plan_of(model: Model, **rules: Any) -> Answer:
    """An order, the help that it takes, and whether every stage stands."""
    found = plan(model, options=PlanOptions(rules=Rules(**rules)))
    names = list(found.model.assembly.names)
    return {
        "verdict": found.verdict.value,
        "help": list(found.help),
        "steps": len(found.steps),
        "impossible": spans(found.impossible),
        "proved": found.proved,
        "order": [names.index(name) for name in found.order],
        "prop_stages": sum(prop.stages for prop in found.props),
    }


def mends_of(model: Model, kinds: tuple[str, ...]) -> Answer:
    """The mends in their order: kind, joints, added parts, cost, and whether it stands then."""
    options = MendOptions(kinds=kinds) if kinds else MendOptions()
    found = find_mends(model, options=options)
    kept = [one.change for one in found.mends]
    return {
        "mends": [f"{one.kind} {one.joints} {one.added}" for one in kept],
        "cost": [_value(one.cost) for one in kept],
        "value": [_value(one.value) for one in kept],
        "stand": all(one.result.verdict is Verdict.STABLE for one in found.mends),
    }


def settlement(model: Model, motion: dict[int | str, Any] | None) -> Answer:
    """How it ends, how far the blocks go, and which way the farthest."""
    found = settle(model, motion)
    moved = found.displacement[:, :3]
    free = np.where(model.assembly.fixed, 0.0, np.linalg.norm(moved, axis=1))
    farthest = int(np.argmax(free > (1.0 - 1e-6) * free.max(initial=0.0)))
    return {
        "outcome": found.outcome.value,
        "travel": _value(found.travel),
        "moved": [_value(one) for one in moved[farthest].tolist()],
    }


def spans(blocks: Any) -> str:
    """Positions of blocks in few letters: ``3-7,9``."""
    out: list[list[int]] = []
    for block in sorted(int(one) for one in blocks):
        if out and block == out[-1][1] + 1:
            out[-1][1] = block
        else:
            out.append([block, block])
    return ",".join(f"{a}" if a == b else f"{a}-{b}" for a, b in out)


def rounded(values: Any, digits: int) -> list[float]:
    """Plain numbers, without the sign of zero."""
    return [round(float(one), digits) + 0.0 for one in values]


def _value(number: float | None) -> float | None:
    return None if number is None else float(f"{number:.5g}")
