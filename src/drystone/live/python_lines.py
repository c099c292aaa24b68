"""The Python lines, and the load case of our JSON, that give what a window shows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from drystone.geometry.frames import rotation_about
from drystone.io.jsontext import Field
from drystone.live.wish import Wish
from drystone.loads import DOWN


def python_lines(
    source: str, how: Mapping[str, Any], sent: Mapping[str, Any], facts: Mapping[str, Any]
) -> dict[str, Any]:
    """Lines that read a file and give the verdict of a wish, and the wish as a load case.

    Parameters
    ----------
    source
        Name of the file.
    how
        Arguments of :func:`drystone.read` that differ from the default.
    sent
        The wish, as plain values.
    facts
        Of the model: its gravity [m/s2], and whether its load moves supports.
    """
    from pathlib import Path

    wish = Wish.read(Field(dict(sent), "", Path("wish")))
    lines = _lines(source, how, wish, bool(facts["moves"]))
    return {"python": "\n".join(lines) + "\n", "case": _case(wish, facts["gravity"])}


def _lines(source: str, how: Mapping[str, Any], wish: Wish, moves: bool) -> list[str]:
    plain = {key: getattr(one, "value", one) for key, one in how.items() if one is not None}
    given = "".join(f", {key}={one!r}" for key, one in plain.items())
    loads, lines = [], [f"model = drystone.read({source!r}{given})"]
    if wish.supports is not None:
        lines.append(f"model = model.with_supports({list(wish.supports)!r})")
    if wish.friction is not None:
        lines.append(f"model = model.with_friction({wish.friction!r})")
    if wish.gravity is not None:
        loads.append(f"more_gravity(model, {wish.gravity!r})")
    for block, force in wish.pushes:
        numbers = ", ".join(f"{x:.6g}" for x in force)
        loads.append(f"drystone.LoadCase.point_load(model.assembly, {block!r}, ({numbers}))")
    for load in loads:
        lines.append(f"model = model.with_load(model.load + {load})")
    if wish.tilt:
        axis = ", ".join(f"{x + 0.0:.12g}" for x in wish.axis)
        lines.append(f"model = Tilt(model, ({axis}))({wish.tilt!r})  # degrees")
    if wish.removed:
        lines.append(f"model = model.without({list(wish.removed)!r})")
    answer = "drystone.check(model)"
    if wish.moves or moves:
        motion = {block: tuple(float(f"{x:.6g}") for x in by) for block, by in wish.moves}
        answer = f"move_supports(model, {motion!r})"
    imports = ["import drystone"]
    if wish.tilt:
        imports.append("from drystone.limits import Tilt")
    if wish.gravity is not None:
        imports.append("from drystone.live import more_gravity")
    if wish.moves or moves:
        imports.append("from drystone.settlement import move_supports")
    return [*imports, "", *lines, f"print({answer})"]


def _case(wish: Wish, own: float) -> dict[str, Any]:
    """A load case of our JSON: gravity and pushes as the tilted model feels them."""
    turn = rotation_about(np.array(wish.axis), wish.tilt)
    gravity = own if wish.gravity is None else wish.gravity
    parts: list[dict[str, Any]] = [
        {"kind": "gravity", "g": gravity, "direction": _rounded(np.array(DOWN) @ turn)}
    ]
    for block, force in wish.pushes:
        parts.append({"kind": "point", "block": block, "force": _rounded(np.array(force) @ turn)})
    for block, by in wish.moves:
        parts.append({"kind": "settlement", "block": block, "motion": _rounded(np.array(by))})
    return {"name": f"tilt {wish.tilt:g} deg" if wish.tilt else "live", "parts": parts}


def _rounded(values: Any) -> list[float]:
    return [float(f"{x:.12g}") + 0.0 for x in values]
