"""Section 6.2 of the source: tilt limits, by the call that a user makes."""

from __future__ import annotations

import math

from drystone import models
from drystone.limits import Limit, LimitOptions, limit_tilt
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.programs import FrictionCone, solve_rbe
from drystone.reproduce.equilibrium_cases import middle, word
from drystone.reproduce.published_case import Case, Line
from drystone.reproduce.published_tilts import Study, studies
from drystone.results import Result, Verdict
from drystone.settlement import settle
from drystone.stability import check
from drystone.virtual import shrink

_NEVER = 179.9
"""Degrees from which on a limit is that of a model that never falls."""


def arches() -> Case:
    """Table 6.1 and figure 6.11: the arch, the three-legged pi and model H."""
    steep = Model.of(models.arch(0.15, 36), friction=math.tan(math.radians(43.0)))
    fixed = int(steep.assembly.fixed.sum())
    at_rest = f"{word(solve_rbe(steep).verdict)} / {word(check(steep).verdict)}"
    rows, pictures = _rows("arch")
    lines = [
        Line.same("arch: free and fixed blocks", "36 and 2", f"{len(steep) - fixed} and {fixed}"),
        Line.same("arch at rest: RBE / CRA", "stable / stable", at_rest),
        *rows,
    ]
    worn = limit_tilt(steep.with_contacts(shrink(steep.contacts, 0.87)), "y").rest
    lines.append(
        Line(
            "arch, friction 43 degrees, joints 13 % thinner: tilt", "4.7 +- 0.2, an experiment",
            f"{middle(worn):.2f}", abs(middle(worn) - 4.7) <= 0.2,
        )
    )  # fmt: skip
    pinched = Model.of(models.h_model(), friction=math.tan(math.radians(43.0)))
    balance, verdict = solve_rbe(pinched).verdict, check(pinched).verdict
    both = f"{word(balance)} / {word(verdict)}"
    lines += [
        Line.same("model H: RBE / CRA", "stable / unstable", both),
        Line("three-legged pi: tilt", "19.5 (experiment 14.3)", "not computed", None,
             "its dimensions are not published"),
    ]  # fmt: skip
    return Case("6.2.1", "Arch, three-legged pi and model H", tuple(lines), pictures)


def wedges() -> Case:
    """Table 6.2 and figure 6.14: wedges of four types, and the one that is analysed moved."""
    lines, pictures = _rows("type-")
    model = Model.of(models.wedge("c"), friction=0.84)
    axis, tilt = (math.sqrt(3.0), 1.0, 0.0), 46.0
    tilted = model.with_load(LoadCase.tilt(model.assembly, axis, tilt))
    verdict = check(tilted).verdict
    rests = check(settle(tilted).path.moved_model())
    moved = rests.verdict
    lines.append(
        Line(
            "type-c about xy30, 46 degrees: where it stands / where it has settled",
            "unstable / stable", f"{word(verdict)} / {word(moved)}",
            None if verdict is Verdict.UNDECIDED else moved is Verdict.STABLE,
            "between 40 and 48 degrees the source's wedge slides a little and rests; ours is "
            "undecided, since which block carries the common edge decides",
        )
    )  # fmt: skip
    pictures["type-c-moved"] = rests
    return Case("6.2.3", "The wedge model", tuple(lines), pictures)


def concave() -> Case:
    """Table 6.3 and figure 6.15: hooked planks."""
    lines, pictures = _rows("concave")
    return Case("6.2.4", "Interlocking connections", tuple(lines), pictures)


def curved() -> Case:
    """Table 6.4 and figure 6.16: curved joints."""
    lines, pictures = _rows("curve", "cube")
    return Case("6.2.5", "Freeform connections", tuple(lines), pictures)


def _rows(*start: str) -> tuple[list[Line], dict[str, Result]]:
    """Rows of models whose names start so; each model at its limit, by friction."""
    lines: list[Line] = []
    pictures: dict[str, Result] = {}
    for study in studies():
        if study.model.startswith(start):
            model = Model.of(study.build(), friction=study.friction)
            found = limit_tilt(model, study.axis, options=LimitOptions(cone=FrictionCone.octagon()))
            lines.append(_row(study, found))
            last = LoadCase.tilt(model.assembly, study.axis, found.best.stands or 0.0)
            name = f"{study.model}-{study.friction:.2g}"
            if name not in pictures:
                pictures[name] = check(model.with_load(last))
    return lines, pictures


def _row(study: Study, found: Limit) -> Line:
    """A row of a table: the default call, and the bound of equilibrium with the octagon."""
    published = f"{study.dem:g} (3DEC), {study.cra:g} (CRA)"
    if study.sofistik is not None:
        published += f", {study.sofistik:g} (Sofistik)"
    told = _told(found)
    if study.rbe is not None:
        published += f", {study.rbe:g} (RBE)"
        told += f", {found.equilibrium.stands or 0.0:.1f} (RBE)"
    named = f"{study.model} about {study.axis_label}, friction {study.friction:.2g}: tilt"
    equal = study.rbe is None or _near(study.rbe, found.equilibrium.stands or 0.0)
    why = _why(found) if equal else f"RBE differs; {_why(found)}".removesuffix("; ")
    return Line(named, published, told, equal and _agrees(study, found), why)


def _near(published: float, found: float) -> bool:
    """Whether a limit of RBE is the published one; some are cut to whole degrees."""
    cut = 1.0 if published == int(published) else 0.1
    return -0.1 <= found - published < cut + 0.05


def _told(found: Limit) -> str:
    """The limit, or both ends of what is undecided."""
    stands, falls = found.best.stands, found.best.falls
    if stands is not None and falls is not None and found.undecided_between is not None:
        return f"stands to {stands:.1f}, falls from {falls:.1f}"
    angle = middle(found.best)
    return "never" if math.isnan(angle) or angle > _NEVER else f"{angle:.1f}"


def _agrees(study: Study, found: Limit) -> bool:
    """Whether both sides of the limit are within half a degree, or a whole one, of a published one.

    Published figures of concave and curved joints are whole degrees.
    """
    published = [one for one in (study.dem, study.cra, study.sofistik) if one is not None]
    ends = [one for one in (found.best.stands, found.best.falls) if one is not None]
    within = study.tolerance + 0.05  # of the bracket
    return all(any(abs(end - one) <= within for one in published) for end in ends)


def _why(found: Limit) -> str:
    """Why the limit is a band, where it is one."""
    if found.undecided_between is None:
        return ""
    return "between them the ends of the joints or their shear stiffness decide"
