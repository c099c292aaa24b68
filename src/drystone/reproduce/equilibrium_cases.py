"""Sections 5.1 and 6.1 of the source: what equilibrium alone says, and where it misleads."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from drystone import models
from drystone.base.arrays import Floats
from drystone.limits import Bracket, LimitOptions, limit_friction, limit_tilt
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.programs import (
    Forces,
    FrictionCone,
    FrictionRule,
    Objective,
    find_forces,
    solve_rbe,
)
from drystone.reproduce.published_case import Case, Line
from drystone.results import Verdict
from drystone.stability import check

if TYPE_CHECKING:
    from drystone.reproduce.published_case import Picture

_CROWN = ("voussoir-06", "voussoir-07")
"""Blocks before the joints at mid-span of the arch of 15 voussoirs."""

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
    spread, corners = solve_rbe(level), find_forces(level, objective=Objective.VERTEX).result
    lines = [
        Line("level joint, quadratic: corners that press (6.1a)", "4",
             str(_pressing(spread.force)), _pressing(spread.force) == 4),
        Line("level joint, linear, by simplex: corners that press (6.1b)", "2",
             str(_pressing(corners.force)), _pressing(corners.force) == 2,
             "the program has many solutions; which vertex is found depends on the solver"),
    ]  # fmt: skip
    shares = (0.25, 0.45, 0.6)
    pushed = [find_forces(models.overhang([share]), friction=0.8) for share in shares]
    lines += [_overhang(share, found) for share, found in zip(shares, pushed, strict=True)]
    inclined = Model.of(models.two_blocks_on_incline(23.6), friction=0.8)
    least = middle(limit_friction(inclined).equilibrium)
    lines.append(
        Line("inclined by 23.6 degrees: least friction", "0.44", f"{least:.3f}",
             abs(least - 0.44) <= 0.005)
    )  # fmt: skip
    rough = find_forces(inclined, rule=FrictionRule.NET, threshold=0.6)
    over = find_forces(inclined, rule=FrictionRule.NET, threshold=0.2)
    needed = float(rough.friction.max())
    told = " and ".join("beyond" if one.code else "within" for one in (rough, over))
    lines.append(
        Line("friction 0.8, friction-net, thresholds 0.6 and 0.2 (6.3a)", "within and beyond",
             told, told == "within and beyond", f"the joint needs {needed:.3f}")
    )  # fmt: skip
    slippery = inclined.with_friction(0.2)
    net = find_forces(slippery, rule=FrictionRule.NET).result
    plus = find_forces(slippery, threshold=0.2)
    glued = bool(plus.pull.any())
    lines += [
        Line("friction 0.2, friction-net", "no forces", "no forces" if net.force is None else
             "forces", net.force is None),
        Line("friction 0.2, friction+ (6.3b)", "forces with tension",
             "forces with tension" if glued else "no tension", glued),
    ]  # fmt: skip
    pictures = {"stack": rough, "slippery": plus, "overhang": pushed[-1]}
    return Case("6.1.1", "Two stacked blocks", tuple(lines), pictures)


def _overhang(share: float, found: Forces) -> Line:
    """Figure 6.2: the upper block pushed out by a share of its length."""
    wanted = "tension" if share > 0.5 else "compression alone"
    told = "tension" if found.pull.any() else "compression alone" if found.code == 0 else "none"
    return Line(f"block pushed out by {share:g} of its length (6.2)", wanted, told, told == wanted)


def _pressing(force: Floats | None) -> int:
    """The number of corners that press."""
    if force is None:
        return 0
    return int((force[:, 0] > _PRESSES * np.abs(force).max()).sum())


def buttressed_arch() -> Case:
    """Figures 6.4 to 6.6: an arch on buttresses."""
    model = Model.of(models.buttressed_arch(), friction=0.8)
    least = middle(limit_friction(model).equilibrium)
    fitted = find_forces(model, virtual=["kern"])
    worst = fitted.contacts.joints.block_a[int(np.argmax(fitted.pull))]
    outside = bool(fitted.pull.any()) and model.assembly.names[worst] in _CROWN
    level = find_forces(model, rule=FrictionRule.NET, threshold=0.6)
    wide = model.with_friction(0.6)
    tilt = middle(limit_tilt(wide, "y").equilibrium)
    lines = (
        Line("least friction (6.6a)", "0.31", f"{least:.3f}", abs(least - 0.31) <= 0.01),
        Line("tilt, friction 0.6 (6.6b)", "12", f"{tilt:.2f}", abs(tilt - 12.0) <= 0.5),
        Line(
            "every joint shrunk to its kern (6.5b): the thrust",
            "is outside at mid-span",
            f"pulls most at {model.assembly.names[worst]}" if fitted.pull.any() else "fits",
            outside,
        ),
        Line("friction threshold 0.6, friction-net and 0.8 at corners (6.4)", "not exceeded",
             f"{float(level.friction.max()):.3f}", level.code == 0),
    )  # fmt: skip
    pictures: dict[str, Picture] = {"buttressed-arch": check(wide), "kern": fitted, "forces": level}
    return Case("6.1.2", "Semi-circular arch on buttresses", lines, pictures)


def dome() -> Case:
    """Figures 6.7 to 6.10: a hemispherical dome."""
    model = Model.of(models.dome(), friction=0.6)
    count = f"{len(model.assembly)} blocks, {int(model.assembly.fixed.sum())} fixed"
    rest = solve_rbe(model)
    compressed = rest.verdict is Verdict.EQUILIBRIUM_EXISTS
    options = LimitOptions(cone=FrictionCone.octagon(), equilibrium_only=True)
    tilt = middle(limit_tilt(model, "y", upper=60.0, options=options).equilibrium)
    beyond = model.with_load(LoadCase.tilt(model.assembly, (0.0, 1.0, 0.0), 35.0))
    octagon = FrictionCone.octagon()
    penalty = find_forces(beyond, cone=octagon)
    fitted = find_forces(model.with_friction(0.8), virtual=["kern"], threshold=0.6)
    lines = (
        Line("blocks (6.7)", "140 blocks, 14 fixed", count, count == "140 blocks, 14 fixed"),
        Line("at rest, quadratic (6.8a)", "compression alone",
             "compression alone" if compressed else "tension", compressed),
        Line("tilt, friction 0.6 (6.10)", "32", f"{tilt:.1f}", abs(tilt - 32.0) <= 0.5,
             "with the source's eight-sided pyramid"),
        Line("penalty form, tilted by 35 degrees", "",
             "forces with tension" if penalty.pull.any() else "none", None),
        Line("every joint shrunk to its kern (6.9a)", "compression alone",
             "compression alone" if fitted.code == 0 else fitted.title, fitted.code == 0),
    )  # fmt: skip
    pictures: dict[str, Picture] = {"dome": check(model), "kern": fitted, "tilted": penalty}
    return Case("6.1.3", "Hemispherical dome", lines, pictures)


def shelf() -> Case:
    """Figure 6.12: the shelf, of which two pieces fall."""
    model = Model.of(models.shelf(), friction=0.9)
    balance, result = solve_rbe(model), check(model)
    penalty = find_forces(model, form="penalty", gamma=1e6)
    pulled = _pulled(penalty)
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
    pictures: dict[str, Picture] = {"shelf": result, "shelf-penalty": penalty}
    return Case("6.2.2", "The shelf model", lines, pictures)


def _pulled(found: Forces) -> tuple[str, ...]:
    """Names of the free pieces of joints that pull."""
    joints = found.contacts.joints
    which = found.pull > 0.01 * found.pull.max()
    blocks = np.unique(np.concatenate([joints.block_a[which], joints.block_b[which]]))
    names = found.assembly.names
    return tuple(names[b] for b in blocks.tolist() if not found.assembly.fixed[b])


def middle(bracket: Bracket | None) -> float:
    """Middle of a bracket; not a number where there is none."""
    if bracket is None or bracket.stands is None or bracket.falls is None:
        return math.nan
    return 0.5 * (bracket.stands + bracket.falls)


def word(verdict: Verdict) -> str:
    """A verdict in the words of the source."""
    return "stable" if verdict is Verdict.EQUILIBRIUM_EXISTS else str(verdict.value)
