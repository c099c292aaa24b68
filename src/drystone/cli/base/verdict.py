"""A verdict as text, as JSON and as an exit code."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.base import units
from drystone.base.errors import counted
from drystone.cli.base.answer import Answer, Files
from drystone.cli.base.output import Screen, grouped
from drystone.cli.base.waiting import Waiting

if TYPE_CHECKING:
    from drystone.model import Model
    from drystone.results import Result

STYLE = {"stable": "bold green", "unstable": "bold red", "undecided": "bold yellow"}
NEGLIGIBLE = 1e-6
"""Share of the largest force below which a force is rounding and is printed as 0."""


def answer(
    result: Result,
    waiting: Waiting,
    model: str,
    files: Callable[[], Files],
    strict: bool = False,
    diagnosis: Mapping[str, Any] | None = None,
) -> Answer:
    """The answer of a command that checks a model; ``diagnosis`` says why it falls."""
    data = {**content(result, waiting.time_s, model), "diagnosis": diagnosis}
    code = exit_code(result, strict)
    return Answer(data, partial(show, data), code, result.model.notes, files)


def solve(model: Model, waiting: Waiting, time_limit: float | None) -> Result:
    """The verdict of ``check``, or what is known when the time limit or Ctrl-C end it."""
    waiting.end_stage()  # the import is no part of the stage before
    from drystone.stability import check

    waiting.stage("solve", "solving")
    with waiting.keywords(time_limit) as common:
        result = check(model, **common)
    waiting.end_stage()
    return result


def is_sensitive(result: Result) -> bool:
    """Whether it stands only for some contact stiffnesses, or only after settling."""
    some = result.samples.standing < result.samples.tried
    return result.stable and (some or result.settlement is not None)


def exit_code(result: Result, strict: bool) -> int:
    """0 if stable; with ``strict`` only if it stands for every stiffness and all were tried."""
    robust = not is_sensitive(result) and not result.stopped
    return 0 if result.stable and (robust or not strict) else 1


def _settlement(result: Result) -> list[dict[str, Any]] | None:
    """How the blocks move with each carrier of the ends of joints, where that decided."""
    if result.settlement is None:
        return None
    return [
        {
            "carrier": path.carrier.value,
            "outcome": path.outcome.value,
            "travel": float(path.travel.max(initial=0.0)),
        }
        for path in result.settlement.paths
    ]


def content(result: Result, spent: Mapping[str, float], model: str) -> dict[str, Any]:
    """The answer as plain values: forces in N, moments in N m, lengths in m."""
    assembly, contacts = result.assembly, result.contacts
    inner = dict(result.time_s)
    checking = float(inner.get("check", 0.0))
    return {
        "model": model,
        "verdict": result.verdict.value,
        "method": result.method,
        "message": result.message,
        "sensitive": is_sensitive(result),
        "settlement": _settlement(result),
        "stopped": result.stopped,
        "blocks": len(assembly),
        "free_blocks": len(assembly.free),
        "interfaces": contacts.count,
        "corners": contacts.corner_count,
        "mass": float(assembly.mass[assembly.free].sum()),
        "size": (assembly.bounds[:, 1].max(axis=0) - assembly.bounds[:, 0].min(axis=0)).tolist(),
        "falling": list(result.falling_names),
        "props": props(result),
        "samples": dataclasses.asdict(result.samples),
        "residuals": dataclasses.asdict(result.residuals) if result.residuals else None,
        "largest": largest(result),
        "time_s": {
            "read": spent.get("read", 0.0),
            "detect": spent.get("detect", 0.0),
            "solve": max(spent.get("solve", 0.0) - checking, 0.0),
            "check": checking,
        },
    }


def props(result: Result) -> list[dict[str, Any]]:
    """The prop of each falling block: force [N] and moment [N m] about its centroid."""
    if result.prop is None:
        return []
    size = np.linalg.norm(result.prop[:, :3], axis=1)
    order = sorted(result.falling, key=lambda i: -size[i])
    return [
        {
            "block": result.assembly.names[i],
            "force": result.prop[i, :3].tolist(),
            "moment": result.prop[i, 3:].tolist(),
        }
        for i in order
    ]


def largest(result: Result) -> dict[str, Any] | None:
    """The interfaces with the largest normal force and with the largest utilisation."""
    if result.force is None or result.contacts.count == 0:
        return None
    resultants, share = result.resultants, result.utilisation

    def at(interface: int) -> dict[str, Any]:
        names, contacts = result.assembly.names, result.contacts
        return {
            "interface": interface,
            "blocks": [names[contacts.block_a[interface]], names[contacts.block_b[interface]]],
            "normal": float(resultants.normal[interface]),
            "tangential": float(resultants.tangential[interface]),
            "utilisation": float(share[interface]),
        }

    return {
        "force": at(int(np.argmax(resultants.normal))),
        "utilisation": at(int(np.argmax(share))),
    }


def show(data: Mapping[str, Any], screen: Screen) -> None:
    """Print the answer for people."""
    word = data["verdict"].upper() + (" (sensitive)" if data["sensitive"] else "")
    screen.line(str(data["model"]), word, STYLE.get(data["verdict"], "bold"))
    if data["message"]:
        screen.line(data["message"])
    screen.line(
        f"{counted(data['blocks'], 'block')} ({data['free_blocks']} free, "
        f"{units.mass(data['mass'])}), {units.extent(data['size'])}, "
        f"{counted(data['interfaces'], 'interface')}, {counted(data['corners'], 'corner')}"
    )
    if data["falling"]:
        _show_falling(screen, data)
    for sentence in (data.get("diagnosis") or {}).get("sentences", ()):
        screen.line(sentence)
    if data["largest"] is not None:
        rows = []
        for title, key in (("largest force", "force"), ("most friction used", "utilisation")):
            row = data["largest"][key]
            used, least = row["utilisation"], NEGLIGIBLE * abs(row["normal"])
            rows.append(
                [
                    title,
                    " - ".join(row["blocks"]),
                    units.quantity(row["normal"], "N"),
                    units.quantity(row["tangential"], "N", least),
                    f"{used + 0.0:.1%}" if np.isfinite(used) else "no capacity",
                ]
            )
        screen.table(("", "between", "normal", "friction", "utilisation"), rows)
    if data["samples"]["tried"]:
        tried, standing = data["samples"]["tried"], data["samples"]["standing"]
        screen.line(f"contact stiffnesses: stands for {standing} of {tried} tried")


def _show_falling(screen: Screen, data: Mapping[str, Any]) -> None:
    needs = {row["block"]: row for row in data["props"]}
    names = [*needs, *(name for name in data["falling"] if name not in needs)]
    screen.line(f"gives way: {counted(len(names), 'block')}")
    rows = []
    force, moment = (
        max((abs(part) for need in needs.values() for part in need[key]), default=0.0)
        for key in ("force", "moment")
    )
    for name in names:
        told = ["-", "-"]
        if need := needs.get(name):
            # with the size of the model as lever arm
            least = NEGLIGIBLE * max(map(abs, need["force"])) * max(data["size"])
            told = [
                units.components(need["force"], "N", column=force),
                units.components(need["moment"], "N m", least, moment),
            ]
        rows.append([name, *told])
    screen.table(("block", "prop force", "prop moment"), grouped(rows))
