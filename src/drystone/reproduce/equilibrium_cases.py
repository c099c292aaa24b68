"""Sections 5.1 and 6.1 of the source: what equilibrium alone says, and where it misleads."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from drystone import models
from drystone.base.arrays import SAME, Floats
from drystone.limits import Bracket, LimitOptions, limit_friction, limit_tilt, thrust_bounds
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.programs import (
    Forces,
    FrictionCone,
    FrictionRule,
    Objective,
    find_forces,
    solve_cra,
    solve_rbe,
)
from drystone.reproduce.published_case import ASSUMED, Case, Line
from drystone.results import Verdict
from drystone.stability import check

if TYPE_CHECKING:
    from drystone.reproduce.published_case import Picture

_CROWN = ("voussoir-06", "voussoir-07", "voussoir-08")
"""Blocks of the joints at mid-span of the arch of 15 voussoirs."""

_BOTH = Objective.QUADRATIC, Objective.LINEAR


def pinched_blocks() -> Case:
    """Figure 5.1: blocks that equilibrium alone lets pass."""
    lines = []
    for name, family in (("H", models.h_model), ("A", models.a_model)):
        model = Model.of(family(), friction=0.84)
        told = f"model {name}, friction 0.84: RBE / CRA"
        lines.append(Line.same(told, "stable / unstable", both(model)))
    pictures = {"h": check(models.h_model(), friction=0.84)}
    return Case("5.1.1", "Issues of RBE: models H and A", tuple(lines), pictures)


def wedged_block() -> Case:
    """Figure 5.2: a block in a groove, forces that a motion fits and forces that none fits."""
    block, lines = models.wedge("a"), []
    pictures: dict[str, Picture] = {}
    for kind, tilt, wanted in (("a", 45.0, "a motion fits"), ("b", 105.0, "none")):
        load = LoadCase.tilt(block, (0.0, 1.0, 0.0), tilt)
        model = Model.of(block, friction=0.84, load=load)
        forces, fitted = find_forces(model), solve_cra(model)
        told = "forces / " if _with_tension(forces) == "compression alone" else "none / "
        told += "a motion fits" if fitted.method == "cra" and fitted.stable else "none"
        what = f"wedge, friction 0.84, inclined by {tilt:g} degrees (5.2{kind}): RBE / CRA"
        lines.append(Line.same(what, f"forces / {wanted}", told, ASSUMED))
        pictures |= {f"v-{kind}": fitted, f"v-{kind}-rbe": forces}
    return Case("5.1.2", "Insight problems: model V", tuple(lines), pictures)


def penalty_form() -> Case:
    """Equations 5.7 and 5.8: forces with tension where no motion fits compression alone."""
    model = Model.of(models.overhang([0.6]), friction=0.8)
    usual, cheap = (find_forces(model, form="penalty", gamma=gamma) for gamma in (1e6, 10.0))
    result = usual.result
    force, tension = result.force, result.tension
    assert force is not None
    assert tension is not None
    pulls, small = tension > 0.0, SAME * np.abs(force).max()
    both = int((pulls & (force[:, 0] > small)).sum())
    rubs = int((pulls & (np.linalg.norm(force[:, 1:], axis=1) > small)).sum())
    share = usual.pull.sum() / cheap.pull.sum()
    slides = find_forces(models.two_blocks_on_incline(40.0), friction=0.3, form="penalty")
    lines = (
        Line.same("block pushed out by 0.6 of its length", "tension", _with_tension(usual)),
        Line.same("corners that press and pull at once (5.7)", "0", str(both)),
        Line.same("corners that pull and rub", "0", str(rubs)),
        Line("pull at gamma 1e6 by that at gamma 10 (5.8)", "no more", f"{share:.3f}",
             bool(share <= 1.0)),
        Line("block that slides down a slope", "", slides.title, None,
             "eq. 5.8 lets a corner press as hard as another one pulls, so friction holds it; "
             "ours does not"),
    )  # fmt: skip
    return Case("5.3", "Penalty formulation", lines, {"overhang": usual, "slope": slides})


def stack() -> Case:
    """Figures 6.1 to 6.3: two blocks, their joint level, overhanging and inclined."""
    level = Model.of(models.two_blocks_on_incline(0.0), friction=0.8)
    spread, corners = solve_rbe(level), find_forces(level, objective=Objective.VERTEX).result
    lines = [
        Line.same("level joint, quadratic: corners that press (6.1a)", "4",
                  str(_pressing(spread.force))),
        Line.same("level joint, linear, by simplex: corners that press (6.1b)", "2",
                  str(_pressing(corners.force)),
                  "the program has many solutions; which vertex is found depends on the solver"),
    ]  # fmt: skip
    lines += [_overhang(share) for share in (0.25, 0.45, 0.6)]
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
        Line.same("friction 0.8, friction-net, thresholds 0.6 and 0.2 (6.3a)", "within and beyond",
                  told, f"the joint needs {needed:.3f}")
    )  # fmt: skip
    slippery = inclined.with_friction(0.2)
    net = find_forces(slippery, rule=FrictionRule.NET)
    plus = [find_forces(slippery, objective=one, threshold=0.2) for one in _BOTH]
    lines += [
        Line.same("friction 0.2, friction-net", "no forces", _with_tension(net)),
        Line.same("friction 0.2, friction+, quadratic / linear (6.3b)", "tension / tension",
                  " / ".join(map(_with_tension, plus))),
    ]  # fmt: skip
    pictures = {"stack": rough, "slippery": plus[0],
                "overhang": find_forces(models.overhang([0.6]), friction=0.8)}  # fmt: skip
    return Case("6.1.1", "Two stacked blocks", tuple(lines), pictures)


def _overhang(share: float) -> Line:
    """Figure 6.2: the upper block pushed out by a share of its length."""
    found = [find_forces(models.overhang([share]), friction=0.8, objective=one) for one in _BOTH]
    one, other = (each.result.resultants for each in found)
    alike = np.allclose(one.force, other.force, rtol=1e-4, atol=1e-4 * one.normal.max())
    alike &= np.allclose(one.position, other.position, atol=1e-4)
    told = f"{' / '.join(map(_with_tension, found))}, {'one resultant' if alike else 'two'}"
    kind = "tension" if share > 0.5 else "compression alone"
    what = f"block pushed out by {share:g} of its length, quadratic / linear (6.2)"
    return Line.same(what, f"{kind} / {kind}, one resultant", told)


def _with_tension(found: Forces) -> str:
    """Whether there are forces, and whether some of them pull."""
    if found.result.force is None:
        return "no forces"
    return "tension" if found.pull.any() else "compression alone"


def _pressing(force: Floats | None) -> int:
    """The number of corners that press."""
    if force is None:
        return 0
    return int((force[:, 0] > SAME * np.abs(force).max()).sum())


def buttressed_arch() -> Case:
    """Figures 6.4 to 6.6: an arch on buttresses."""
    model = Model.of(models.buttressed_arch(), friction=0.8)
    least = middle(limit_friction(model).equilibrium)
    at_rest = [
        find_forces(model, objective=one, rule=FrictionRule.NET, threshold=0.6) for one in _BOTH
    ]
    smallest = -thrust_bounds(model, "left-0").most
    thrusts = [one.result.reactions()["force"][0][0] / smallest for one in at_rest]
    inner = find_forces(model, virtual=[f"in=0.02@{','.join(_CROWN)}"])
    fitted = find_forces(model, virtual=["kern"])
    worst = fitted.contacts.joints.block_a[int(np.argmax(fitted.pull))]
    name = model.assembly.names[worst]
    wide = model.with_friction(0.6)
    tilt = middle(limit_tilt(wide, "y").equilibrium)
    within = " / ".join(map(_in_buttresses, at_rest))
    lines = (
        Line("thrust by the least one, quadratic / linear (6.4)", "close to it",
             " / ".join(f"{one:.3f}" for one in thrusts), max(thrusts) < 1.05),
        Line.same("buttresses, quadratic / linear (6.4)", "within the kern / within the kern",
                  within),
        Line("friction threshold 0.6, friction-net and 0.8 at corners (6.4)", "not exceeded",
             f"{float(at_rest[0].friction.max()):.3f}", at_rest[0].code == 0),
        Line.same("joints at mid-span reduced inwards (6.5a): buttresses", "outside the kern",
                  _in_buttresses(inner)),
        Line("every joint shrunk to its kern (6.5b): the thrust", "is outside at mid-span",
             f"pulls most at {name}" if fitted.pull.any() else "fits",
             bool(fitted.pull.any()) and name in _CROWN),
        Line("least friction (6.6a)", "0.31", f"{least:.3f}", abs(least - 0.31) <= 0.01),
        Line("tilt, friction 0.6 (6.6b)", "12", f"{tilt:.2f}", abs(tilt - 12.0) <= 0.5),
    )  # fmt: skip
    tilted = LoadCase.tilt(model.assembly, (0.0, 1.0, 0.0), tilt - 0.1)
    pictures: dict[str, Picture] = {
        "forces": at_rest[0], "mid-span": inner, "kern": fitted,
        "least-friction": find_forces(model.with_friction(least + 0.001), rule=FrictionRule.NET),
        "tilted": find_forces(wide.with_load(tilted)),
    }  # fmt: skip
    return Case("6.1.2", "Semi-circular arch on buttresses", lines, pictures)


def _in_buttresses(found: Forces) -> str:
    """Where the resultants of the joints of the buttresses are."""
    joints = found.result.joints()
    ends = zip(joints["kern_ratio"], joints["block_a"], joints["block_b"], strict=True)
    most = max(ratio for ratio, *names in ends if not any("voussoir" in one for one in names))
    return "within the kern" if most <= 1.0 else "outside the kern"


def dome() -> Case:
    """Figures 6.7 to 6.10: a hemispherical dome."""
    model = Model.of(models.dome(), friction=0.6)
    count = f"{len(model.assembly)} blocks, {int(model.assembly.fixed.sum())} fixed"
    at_rest = [find_forces(model, objective=one) for one in _BOTH]
    options = LimitOptions(cone=FrictionCone.octagon(), equilibrium_only=True)
    tilt = middle(limit_tilt(model, "y", upper=60.0, options=options).equilibrium)
    beyond = model.with_load(LoadCase.tilt(model.assembly, (0.0, 1.0, 0.0), 35.0))
    penalty = find_forces(beyond, cone=FrictionCone.octagon())
    rough = model.with_friction(0.8)
    fitted = {
        name: find_forces(rough, virtual=[word], threshold=0.6)
        for name, word in (
            ("kern", "kern"), ("inner", "in=0.2@supports"), ("outer", "out=0.2@supports")
        )
    }  # fmt: skip
    alone = "compression alone"
    lines = (
        Line.same("blocks (6.7)", "140 blocks, 14 fixed", count),
        Line.same("at rest, quadratic / linear (6.8)", f"{alone} / {alone}",
                  " / ".join(map(_with_tension, at_rest))),
        Line.same("joints of a ring, quadratic / linear (6.8)", "equal / not equal",
                  " / ".join(map(_around, at_rest))),
        Line("every joint shrunk to its kern (6.9a)", alone, _with_tension(fitted["kern"]),
             fitted["kern"].code == 0),
        Line.same("supports reduced to the inner / outer fifth (6.9b, c)", f"{alone} / {alone}",
                  " / ".join(_with_tension(fitted[one]) for one in ("inner", "outer"))),
        Line("tilt, friction 0.6 (6.10)", "32", f"{tilt:.1f}", abs(tilt - 32.0) <= 0.5,
             "with the source's eight-sided pyramid"),
        Line("penalty form, tilted by 35 degrees", "", _with_tension(penalty), None),
    )  # fmt: skip
    last = LoadCase.tilt(model.assembly, (0.0, 1.0, 0.0), tilt - 0.1)
    pictures: dict[str, Picture] = {
        "dome": at_rest[0], **fitted, "beyond": penalty,
        "tilted": find_forces(model.with_load(last), cone=options.cone),
    }  # fmt: skip
    return Case("6.1.3", "Hemispherical dome", lines, pictures)


def _around(found: Forces) -> str:
    """Whether the joints between two rings press alike all around."""
    joints = found.result.joints()
    ends = zip(joints["normal"], joints["block_a"], joints["block_b"], strict=True)
    normal = [force for force, a, b in ends if (a[:3], b[:3]) == ("r04", "r05")]
    return "equal" if max(normal) - min(normal) < 1e-3 * max(normal) else "not equal"


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
        Line.same("CRA (6.12d): falls", wanted, falls),
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


def both(model: Model) -> str:
    """What RBE and CRA say of a model."""
    return f"{word(solve_rbe(model).verdict)} / {word(check(model).verdict)}"


def word(verdict: Verdict) -> str:
    """A verdict in the words of the source."""
    return "stable" if verdict is Verdict.EQUILIBRIUM_EXISTS else str(verdict.value)
