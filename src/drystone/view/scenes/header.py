"""The question and the answer as text, for the head of a picture."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePath

import numpy as np

from drystone.assembly import Assembly
from drystone.base import units
from drystone.base.arrays import Floats, frozen
from drystone.contacts import Contacts
from drystone.loads import LoadCase
from drystone.loads.case import STANDARD_GRAVITY
from drystone.results import Result, Verdict
from drystone.view.scenes.scene import UP

_NAMED = 4
"""Supports named; more are counted."""


def sentence(result: Result) -> str:
    """The verdict as a plain sentence."""
    total = len(result.assembly)
    if result.verdict is Verdict.UNSTABLE:
        falling = len(result.falling)
        if falling == 0:
            return "Falls"
        if falling == 1:
            return f"Falls: block '{result.falling_names[0]}'"
        return f"Falls: {falling} of {total} blocks"
    if result.verdict is Verdict.UNDECIDED:
        return "Not decided: neither standing nor falling was shown"
    if result.verdict is Verdict.EQUILIBRIUM_EXISTS:
        return "Some forces balance the loads; whether it stands was not asked"
    if result.settlement is not None:
        return "Stands after settling: it depends on how the joints press"
    tried, standing = result.samples.tried, result.samples.standing
    if standing == tried:
        return "Stands"
    return f"Contact stiffness decides: stands for {standing} of {tried} tried"


def facts_of(
    assembly: Assembly,
    contacts: Contacts,
    load: LoadCase | None = None,
    source: str = "",
) -> Mapping[str, str]:
    """Facts about the input by name; empty entries are left out."""
    density = np.array([block.density for block in assembly.blocks])
    free = ~assembly.fixed
    facts = {
        "File": PurePath(source).name,
        "Blocks": f"{len(assembly):,}",
        "Interfaces": f"{contacts.count:,}",
        "Supports": _supports(assembly),
        "Free mass": units.mass(float(assembly.mass[free].sum())),
        "Density": _range(density, " kg/m³"),
        "Friction": _range(contacts.friction, "") if contacts.count else "",
        "Load": "" if load is None else load.name,
        "Notes": "" if load is None else "; ".join(load.notes),
    }
    return {name: text for name, text in facts.items() if text}


def asked_line(facts: Mapping[str, str], made: str = "") -> str:
    """What was asked, in one line.

    Parameters
    ----------
    facts
        Of a scene and its stage; see :func:`facts_of`.
    made
        When and with what the picture was made.

    Examples
    --------
    >>> asked_line({"File": "arch.json", "Blocks": "17", "Friction": "0.6", "Supports": "none"})
    'arch.json · 17 blocks · friction 0.6 · no supports'
    """
    shown = [facts.get("File", "")]
    for name, text in (
        ("Blocks", "{} blocks"),
        ("Free mass", "free mass {}"),
        ("Density", "density {}"),
        ("Friction", "friction {}"),
        ("Load", "{}"),
        ("Supports", "supports: {}"),
        ("Supports that move", "moved: {}"),
        ("Plan", "plan of {}"),
        ("Changed", "changed: {}"),
    ):
        if facts.get(name) == "none":
            shown.append(f"no {name.lower()}")
        elif name in facts:
            shown.append(text.format(facts[name]))
    if "Left out" in facts:
        shown.append("shown without details, see below")
    return " \N{MIDDLE DOT} ".join(one for one in (*shown, made) if one)


def directions(assembly: Assembly, load: LoadCase) -> tuple[Floats, Floats]:
    """The directions of up in the picture and of gravity, both (3,) unit.

    If all free masses have the same acceleration of the size of standard gravity, gravity is
    turned: the picture is tilted until it points down. Otherwise up is along z.
    """
    free = ~assembly.fixed
    force, mass = load.wrench[free, :3], assembly.mass[free]
    total = force.sum(axis=0)
    size = float(np.linalg.norm(total))
    if size == 0.0:
        return UP, -UP
    pull = total / size
    mean = total / mass.sum()
    alike = np.abs(force - mass[:, None] * mean).max() <= 1e-6 * np.abs(force).max()
    turned = alike and abs(size / mass.sum() / STANDARD_GRAVITY - 1.0) < 1e-3
    return (frozen(-pull) if turned else UP), frozen(pull)


def _supports(assembly: Assembly) -> str:
    fixed = [assembly.names[i] for i in np.flatnonzero(assembly.fixed)]
    if not fixed:
        return "none"
    if len(fixed) > _NAMED:
        return f"{len(fixed):,} blocks"
    told = ", ".join(fixed)
    if any(name.isdecimal() for name in fixed):  # "0" alone would be a count
        return f"block {told}" if len(fixed) == 1 else f"blocks {told}"
    return told


def _range(values: Floats, unit: str) -> str:
    low, high = float(values.min()), float(values.max())
    text = f"{low:.4g}" if high - low <= 1e-9 * abs(high) else f"{low:.4g} to {high:.4g}"
    return text + unit
