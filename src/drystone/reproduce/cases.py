"""Chapters 6 and 7 of the source: what structures bear, and how they are built without props."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from drystone import models
from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.design import CutOptions, cut_until_free
from drystone.limits import Bracket, limit_friction, limit_tilt
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.programs import FrictionCone, RBEOptions, solve_cra, solve_rbe
from drystone.programs.cra import CRAOptions
from drystone.reproduce.published_case import Case, Line
from drystone.results import Result, Verdict
from drystone.sequence import (
    Order,
    Plan,
    PlanOptions,
    Rules,
    plan,
    take_turns,
)
from drystone.shells import (
    Edge,
    Layout,
    Patch,
    Shape,
    Shell,
    ShellBody,
    Side,
    build_shell,
    sample_shell,
)
from drystone.shells import dome as dome_shape
from drystone.shells import tri_dome as tri_dome_shape
from drystone.stability import check
from drystone.virtual import shrink

THOROUGH = PlanOptions(patience=math.inf)
BY_COURSE = PlanOptions(rules=Rules(order=Order.COURSE))
ASSUMED = "no published dimensions and counts are known to us: the shape is ours"


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


def snake() -> Case:
    """Section 7.2: a leaning tower that is cut until every block is free, and the snake."""
    shape = models.prism([(0.0, 0.0), (1.0, 0.0), (2.5, 4.0), (1.5, 4.0)], (0.0, 1.0), "tower")
    cut = cut_until_free(shape, options=CutOptions(blocks=8))
    tower = "no plan" if cut.plan is None else _told(cut.plan)
    ours = "one call, from a monolith of ours: no published dimensions are known to us"
    model = Model.of(models.snake(), friction=0.7)
    result = check(model)
    lines = [
        Line("leaning tower: from the whole to its parts", "8 blocks", tower, None, ours),
        Line("snake, friction 0.7: complete", "stable", result.verdict.value, _stands(result)),
        Line(
            "snake: interfaces", "7", str(model.contacts.count), None, "ours merges coplanar ones"
        ),
        _counted("snake, friction 0.8: order", "", plan(model.with_friction(0.8)), None),
    ]
    pictures: dict[str, Result | Plan] = {"snake": result}
    if cut.plan is not None:
        pictures["leaning-tower"] = cut.plan
    return Case("7.2", "Leaning tower and snake", tuple(lines), pictures)


def bridge() -> Case:
    """Section 7.2.4: the bridge, with and without the load of figure 7.4."""
    model = Model.of(models.bridge(), friction=0.66)
    plans = {mu: plan(model.with_friction(mu), options=THOROUGH) for mu in (0.66, 0.35, 0.34)}
    lines = [
        Line("blocks", "11", str(len(model.assembly)), len(model.assembly) == 11),
        Line(
            "interfaces", "33", str(model.contacts.count), None,
            "the bridge is symmetric and has no interface on its axis, so their number is even",
        ),
    ]  # fmt: skip
    for mu in (0.66, 0.35):
        free = plans[mu].counts["free"]
        lines.append(_counted(f"friction {mu}: order", "9 free", plans[mu], free == 9))
    none, stands = plans[0.34].counts["free"] < 9, plans[0.34].complete.stands
    words = "no order without help is left; complete it " + ("stands" if stands else "falls")
    lines.append(_counted("friction 0.34: order", "none without help", plans[0.34], none, words))
    loaded = Model.of(models.bridge(load=True), friction=0.9)
    for mu in (0.35, 0.34):
        order = plan(loaded.with_friction(mu), options=THOROUGH)
        note = "" if mu > 0.34 else "two of the load's blocks are placed early, as counterweights"
        lines.append(_counted(f"with load, friction {mu}: order", "", order, None, note))
    result = check(loaded)
    lines.append(Line("with load: complete", "stable", result.verdict.value, _stands(result)))
    state = solve_cra(loaded, options=CRAOptions(tolerance=2e-6))
    met = state.verdict is Verdict.STABLE and state.method == "cra"
    lines.append(
        Line("with load: eq. 5.6", "a state", "a state" if met else "none", met, "to 2e-6")
    )
    pictures: dict[str, Result | Plan] = {"bridge": plans[0.66], "bridge-load": result}
    return Case("7.2.4", "Bridge", tuple(lines), pictures)


def two_robots() -> Case:
    """Section 6.4.2: robots that hold the last block in turn, on a tri-dome and on an arch."""
    shell, arch = tri_dome().model(friction=0.66), Model.of(models.arch(0.3, 11), friction=0.7)
    blocks, free = shell.assembly.blocks, shell.assembly.free.tolist()
    order = sorted(
        free, key=lambda i: [blocks[i].metadata[k] for k in ("course", "position", "patch")]
    )
    turns, found = take_turns(shell, order), take_turns(arch)
    last = turns.turns[-1].name
    lines = (
        Line(
            f"tri-dome of {len(order)} blocks, two robots in turn, course by course",
            "",
            f"no props, largest hold {turns.largest:.0f} N"
            if turns.works
            else f"without props it falls at block {len(turns.turns)} of {len(order)}, {last}",
            None,
            ASSUMED + "; its plan with props is in section 7.5",
        ),
        Line(
            "arch of 11 voussoirs, two robots in turn",
            "",
            f"{'no props' if found.works else 'falls'}, largest hold {found.largest:.0f} N",
            None,
            "an arch of ours, on which the method works without props",
        ),
    )
    return Case("6.4.2", "Two robots", lines, {"tri-dome": check(shell), "arch": check(arch)})


def shells() -> Case:
    """Section 7.5: vault, dome, three-vault shell and tri-dome, course by course."""
    found = {
        "vault": plan(Model.of(niche(0.2), friction=0.6), options=BY_COURSE),
        "dome": plan(Model.of(ring_dome(), friction=0.66), options=BY_COURSE),
        "three-vault shell": plan(
            sample_shell("freeform", 40).model(friction=0.66), options=BY_COURSE
        ),
        "tri-dome": plan(tri_dome().model(friction=0.66), options=BY_COURSE),
    }
    lines = (
        _counted("vault of 37 blocks, friction 0.6", "", found["vault"], None, ASSUMED),
        _counted("dome of 60 blocks, friction 0.66", "", found["dome"], None, ASSUMED),
        _counted("three-vault shell of 42 blocks", "", found["three-vault shell"], None, ASSUMED),
        _counted("tri-dome of 43 blocks, friction 0.66", "", found["tri-dome"], None, ASSUMED),
    )
    pictures: dict[str, Result | Plan] = {k.replace(" ", "-"): v for k, v in found.items()}
    return Case("7.5", "Shells", lines, pictures)


def niche_shape() -> Shape:
    """A quarter of a sphere, held by a wall on three sides, open at the top."""
    top, radius = math.radians(72.0), 3.0

    def point(u: Floats, v: Floats) -> Floats:
        latitude, longitude = top * u, np.pi * (v - 0.5)
        ring = radius * np.cos(latitude)
        return np.stack(
            [ring * np.cos(longitude), ring * np.sin(longitude), radius * np.sin(latitude)],
            axis=-1,
        )

    supports = (Edge(0, Side.BOTTOM), Edge(0, Side.LEFT), Edge(0, Side.RIGHT))
    return Shape((Patch(point, name="niche"),), supports=supports, name="niche")


NICHE = Layout(courses=5, blocks=7), ShellBody(thickness=0.35)
"""Courses and blocks of the vault, and their thickness."""


def niche(wedge: float) -> Assembly:
    """A vault of 37 voussoirs in five courses, held by a wall on three sides, open at the top."""
    layout, body = NICHE
    return build_shell(niche_shape(), replace(layout, wedge=wedge), body).assembly


def tri_dome() -> Shell:
    """A dome of 43 voussoirs on three feet, closed by a keystone."""
    layout = Layout(courses=5, blocks=(2, 2, 3, 3, 2))
    return build_shell(tri_dome_shape(), layout, ShellBody(thickness=0.5))


def ring_dome() -> Assembly:
    """Five closed rings of twelve voussoirs, from 20 to 47.5 degrees of latitude."""
    eye = 5.0 * math.cos(math.radians(47.5))
    shape = dome_shape(radius=5.0, oculus=eye, springing_deg=20.0)
    return build_shell(
        shape, Layout(courses=5, blocks=12, wedge=0.2), ShellBody(thickness=0.5)
    ).assembly


def _counted(what: str, published: str, found: Plan, agrees: bool | None, note: str = "") -> Line:
    return Line(what, published, _told(found), agrees, note)


def _told(found: Plan) -> str:
    counts = found.counts
    return ", ".join(f"{counts[k]} {k}" for k in ("free", "held", "propped", "impossible"))


def _stands(result: Result) -> bool:
    return result.stable
