"""Chapter 6 of the source: what stands, and how far it tilts."""

from __future__ import annotations

import math

from drystone import models
from drystone.limits import Bracket, limit_friction, limit_tilt
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.reproduce.published_case import Case, Line
from drystone.results import Verdict
from drystone.stability import FrictionCone, RBEOptions, check, solve_rbe
from drystone.virtual import shrink


def arches() -> Case:
    """Section 6.1: tilt of the arch against other methods and an experiment; the pi."""
    lines = []
    for degrees, published in ((43.0, 8.2), (21.8, 3.0)):
        model = Model.of(models.arch(0.15, 36), friction=math.tan(math.radians(degrees)))
        lines.append(_tilt(f"arch, friction {degrees:g} degrees: tilt", model, published, 0.1))
    steep = Model.of(models.arch(0.15, 36), friction=math.tan(math.radians(43.0)))
    worn = steep.with_contacts(shrink(steep.contacts, 0.87))
    lines.append(
        _tilt("the same, joints 13 % thinner: tilt, experiment", worn, 4.7, 0.2, "4.7 +- 0.2")
    )
    lines.append(
        Line(
            "three-legged pi: tilt",
            "19.5 (Shin 2016: 19.1, Yao 2017: 16.4, experiment 14.3 +- 0.2)",
            "not computed",
            None,
            "no published dimensions of it are known to us",
        )
    )
    return Case("6.1", "Arch and pi", tuple(lines), {"arch": check(steep)})


def buttressed_arch() -> Case:
    """Section 6.1.2: an arch on buttresses."""
    model = Model.of(models.buttressed_arch(), friction=0.75)
    least = _middle(limit_friction(model).equilibrium)
    lines = (
        Line("least friction", "0.31", f"{least:.3f}", abs(least - 0.31) <= 0.01),
        _tilt("tilt", model, 12.0, 0.5),
    )
    return Case("6.1.2", "Buttressed arch", lines, {"buttressed-arch": check(model)})


def dome() -> Case:
    """Section 6.1.3: a hemispherical dome, by equilibrium with the source's friction pyramid."""
    model = Model.of(models.dome(), friction=0.6)
    pyramid = RBEOptions.feasibility(FrictionCone.octagon())
    stands, falls = 25.0, 40.0
    while falls - stands > 0.05:
        angle = 0.5 * (stands + falls)
        load = LoadCase.tilt(model.assembly, (0.0, 1.0, 0.0), angle)
        found = solve_rbe(model.with_load(load), options=pyramid).verdict
        if found is Verdict.EQUILIBRIUM_EXISTS:
            stands = angle
        else:
            falls = angle
    line = Line(
        "tilt, RBE", "32", f"{stands:.1f}", abs(stands - 32.0) <= 0.5, "eight-sided pyramid"
    )
    return Case("6.1.3", "Dome", (line,), {"dome": check(model)})


def pinched_blocks() -> Case:
    """Section 6.2: blocks that equilibrium alone lets pass."""
    lines = []
    for name, family in (("H", models.h_model), ("A", models.a_model)):
        model = Model.of(family(), friction=0.84)
        balance, verdict = solve_rbe(model).verdict, check(model).verdict
        lines.append(
            Line(
                f"{name}, friction 0.84: RBE / CRA",
                "stable / unstable",
                f"{_word(balance)} / {_word(verdict)}",
                balance is Verdict.EQUILIBRIUM_EXISTS and verdict is Verdict.UNSTABLE,
            )
        )
    return Case("6.2", "H and A", tuple(lines), {"h": check(models.h_model(), friction=0.84)})


def shelf() -> Case:
    """Section 6.3: the shelf, and its three partial fixes."""
    lines, pictures = [], {}
    for fix, falls in ((None, ("block-9", "block-10")), *((i, ("block-10",)) for i in (1, 2, 3))):
        result = check(models.shelf(fix), friction=0.9)  # type: ignore[arg-type]
        name = "shelf" if fix is None else f"shelf, fix {fix}"
        found = ", ".join(result.falling_names) or "nothing"
        agrees = result.falling_names == falls
        lines.append(Line(f"{name}: falls", ", ".join(falls), found, agrees))
        pictures[name.replace(", ", "-").replace(" ", "-")] = result
    rest = Model.of(models.shelf(), friction=0.9).without(["block-9", "block-10"])
    verdict = check(rest).verdict
    lines.append(Line("shelf without the two", "stable", _word(verdict), verdict is Verdict.STABLE))
    return Case("6.3", "Shelf", tuple(lines), pictures)


def _tilt(what: str, model: Model, published: float, within: float, text: str = "") -> Line:
    angle = _middle(limit_tilt(model, "y").rest)
    return Line(what, text or f"{published:g}", f"{angle:.2f}", abs(angle - published) <= within)


def _middle(bracket: Bracket | None) -> float:
    """Middle of a bracket; not a number where there is none."""
    if bracket is None or bracket.stands is None or bracket.falls is None:
        return math.nan
    return 0.5 * (bracket.stands + bracket.falls)


def _word(verdict: Verdict) -> str:
    return "stable" if verdict is Verdict.EQUILIBRIUM_EXISTS else str(verdict.value)
