"""Sections 5.1 and 6.1 of the source: what equilibrium alone says, and where it misleads."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import linprog

from drystone import models
from drystone.base.arrays import Floats
from drystone.base.errors import SolverError
from drystone.limits import Bracket, LimitOptions, limit_friction, limit_tilt
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.programs import (
    FrictionCone,
    FrictionRule,
    Objective,
    RBEOptions,
    build_rbe,
    solve_cra_penalty,
    solve_rbe,
)
from drystone.reproduce.published_case import Case, Line
from drystone.results import Result, Verdict
from drystone.stability import check
from drystone.virtual import to_kern

_PRESSES = 1e-6
"""Share of the largest normal force from which on a corner presses; below is rounding."""


def pinched_blocks() -> Case:
    """Figure 5.1: blocks that equilibrium alone lets pass."""
    lines = []
    for name, family in (("H", models.h_model), ("A", models.a_model)):
        model = Model.of(family(), friction=0.84)
        balance, verdict = solve_rbe(model).verdict, check(model).verdict
        lines.append(
            Line(
                f"model {name}, friction 0.84: RBE / CRA",
                "stable / unstable",
                f"{word(balance)} / {word(verdict)}",
                balance is Verdict.EQUILIBRIUM_EXISTS and verdict is Verdict.UNSTABLE,
            )
        )
    pictures = {"h": check(models.h_model(), friction=0.84)}
    return Case("5.1.1", "Issues of RBE: models H and A", tuple(lines), pictures)


def stack() -> Case:
    """Figures 6.1 to 6.3: two blocks, their joint level, overhanging and inclined."""
    level = Model.of(models.two_blocks_on_incline(0.0), friction=0.8)
    spread, corners = solve_rbe(level), _vertex(level)
    lines = [
        Line("level joint, quadratic: corners that press (6.1a)", "4",
             str(_pressing(spread.force)), _pressing(spread.force) == 4),
        Line("level joint, linear, by simplex: corners that press (6.1b)", "2",
             str(_pressing(corners)), _pressing(corners) == 2,
             "the program has many solutions; which vertex is found depends on the solver"),
    ]  # fmt: skip
    lines += [_overhang(share) for share in (0.25, 0.45, 0.6)]
    inclined = Model.of(models.two_blocks_on_incline(23.6), friction=0.8)
    least = middle(limit_friction(inclined).equilibrium)
    lines.append(
        Line("inclined by 23.6 degrees: least friction", "0.44", f"{least:.3f}",
             abs(least - 0.44) <= 0.005)
    )  # fmt: skip
    rough = solve_rbe(inclined)
    needed = _needed(rough)
    lines.append(
        Line("friction 0.8: global friction that the joint uses (6.3a)", "below 0.6 and above 0.2",
             f"{needed:.3f}", 0.2 < needed < 0.6)
    )  # fmt: skip
    slippery = inclined.with_friction(0.2)
    net = solve_rbe(slippery, options=RBEOptions(rule=FrictionRule.NET))
    plus = solve_rbe(slippery, options=RBEOptions(rule=FrictionRule.PLUS))
    glued = plus.tension is not None and bool((plus.tension > 0.0).any())
    lines += [
        Line("friction 0.2, friction-net", "no forces", "no forces" if net.force is None else
             "forces", net.force is None),
        Line("friction 0.2, friction+ (6.3b)", "forces with tension",
             "forces with tension" if glued else "no tension", glued),
    ]  # fmt: skip
    return Case("6.1.1", "Two stacked blocks", tuple(lines), {"stack": rough})


def _overhang(share: float) -> Line:
    """Figure 6.2: the upper block pushed out by a share of its length."""
    model = Model.of(models.overhang([share]), friction=0.8)
    found = solve_rbe(model)
    pulls = found.tension is not None and bool((found.tension > 0.0).any())
    told = (
        "no forces" if found.force is None else f"forces {'with' if pulls else 'without'} tension"
    )
    wanted = "forces with tension" if share > 0.5 else "forces without tension"
    return Line(
        f"upper block pushed out by {share:g} of its length (6.2)", wanted, told, told == wanted
    )


def _vertex(model: Model) -> Floats:
    """Corner forces (k, 3) [N] of a linear program, in a vertex of the set of its solutions."""
    chosen = RBEOptions(objective=Objective.LINEAR, cone=FrictionCone.octagon(), tension=False)
    program = build_rbe(model, options=chosen)
    equal, rest = slice(None, program.cones.zero), slice(program.cones.zero, None)
    found = linprog(
        program.linear,
        A_ub=program.matrix[rest].toarray(),
        b_ub=program.right[rest],
        A_eq=program.matrix[equal].toarray(),
        b_eq=program.right[equal],
        bounds=[(None, None)] * len(program.linear),
        method="highs-ds",
    )
    if found.x is None:
        raise SolverError(f"the simplex method found no forces: {found.message}")
    return program.value(found.x, "force").reshape(-1, 3)


def _pressing(force: Floats | None) -> int:
    """The number of corners that press."""
    if force is None:
        return 0
    return int((force[:, 0] > _PRESSES * np.abs(force).max()).sum())


def _needed(result: Result) -> float:
    """The largest share of tangential to normal force of a joint."""
    found = result.resultants
    return float((found.tangential / found.normal).max())


def buttressed_arch() -> Case:
    """Figures 6.4 to 6.6: an arch on buttresses."""
    model = Model.of(models.buttressed_arch(), friction=0.8)
    least = middle(limit_friction(model).equilibrium)
    fitted = solve_rbe(model.with_contacts(to_kern(model.contacts)))
    outside = fitted.verdict is Verdict.UNSTABLE
    wide = model.with_friction(0.6)
    tilt = middle(limit_tilt(wide, "y").equilibrium)
    lines = (
        Line("least friction (6.6a)", "0.31", f"{least:.3f}", abs(least - 0.31) <= 0.01),
        Line("tilt, friction 0.6 (6.6b)", "12", f"{tilt:.2f}", abs(tilt - 12.0) <= 0.5),
        Line(
            "every joint shrunk to its kern (6.5b): the thrust",
            "is outside at mid-span",
            "is outside" if outside else "fits",
            outside,
        ),
    )
    return Case(
        "6.1.2", "Semi-circular arch on buttresses", lines, {"buttressed-arch": check(wide)}
    )


def dome() -> Case:
    """Figures 6.7 to 6.10: a hemispherical dome."""
    model = Model.of(models.dome(), friction=0.6)
    count = f"{len(model.assembly)} blocks, {int(model.assembly.fixed.sum())} fixed"
    rest = solve_rbe(model)
    compressed = rest.verdict is Verdict.EQUILIBRIUM_EXISTS
    options = LimitOptions(cone=FrictionCone.octagon(), equilibrium_only=True)
    tilt = middle(limit_tilt(model, "y", upper=60.0, options=options).equilibrium)
    beyond = model.with_load(LoadCase.tilt(model.assembly, (0.0, 1.0, 0.0), 35.0))
    penalty = solve_rbe(beyond, options=RBEOptions(cone=FrictionCone.octagon()))
    lines = (
        Line("blocks (6.7)", "140 blocks, 14 fixed", count, count == "140 blocks, 14 fixed"),
        Line("at rest, quadratic (6.8a)", "compression alone",
             "compression alone" if compressed else "tension", compressed),
        Line("tilt, friction 0.6 (6.10)", "32", f"{tilt:.1f}", abs(tilt - 32.0) <= 0.5,
             "with the source's eight-sided pyramid"),
        Line("penalty form, tilted by 35 degrees", "",
             "forces with tension" if penalty.force is not None else "no forces", None),
    )  # fmt: skip
    return Case("6.1.3", "Hemispherical dome", lines, {"dome": check(model)})


def shelf() -> Case:
    """Figure 6.12: the shelf, of which two pieces fall."""
    model = Model.of(models.shelf(), friction=0.9)
    balance, result = solve_rbe(model), check(model)
    penalty = solve_cra_penalty(model)
    pulled = () if penalty.tension is None else _pulled(penalty)
    wanted = "block-9, block-10"
    falls = ", ".join(result.falling_names) or "nothing"
    rest = model.without(["block-9", "block-10"])
    lines = (
        Line("RBE (6.12c)", "stable", word(balance.verdict),
             balance.verdict is Verdict.EQUILIBRIUM_EXISTS),
        Line("CRA (6.12d): falls", wanted, falls, falls == wanted),
        Line("CRA with penalty: pieces that are pulled (6.12d)", wanted, ", ".join(pulled), None,
             "the joints between which a pull is shown have both of their pieces named"),
        Line("the others alone", "", word(check(rest).verdict), None),
    )  # fmt: skip
    return Case("6.2.2", "The shelf model", lines, {"shelf": result, "shelf-penalty": penalty})


def _pulled(result: Result) -> tuple[str, ...]:
    """Names of the free pieces of joints that pull."""
    contacts, tension = result.contacts, result.tension
    assert tension is not None
    joints = np.unique(contacts.interface[tension > 0.01 * tension.max()])
    blocks = np.unique(np.concatenate([contacts.block_a[joints], contacts.block_b[joints]]))
    names = result.assembly.names
    return tuple(names[b] for b in blocks.tolist() if not result.assembly.fixed[b])


def middle(bracket: Bracket | None) -> float:
    """Middle of a bracket; not a number where there is none."""
    if bracket is None or bracket.stands is None or bracket.falls is None:
        return math.nan
    return 0.5 * (bracket.stands + bracket.falls)


def word(verdict: Verdict) -> str:
    """A verdict in the words of the source."""
    return "stable" if verdict is Verdict.EQUILIBRIUM_EXISTS else str(verdict.value)
