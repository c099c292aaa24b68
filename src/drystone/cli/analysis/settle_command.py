"""``drystone settle``: forces and joints when supports move."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base import units
from drystone.base.errors import InputError
from drystone.cli.analysis import followed_answer, large_answer
from drystone.cli.analysis.large_answer import Curves
from drystone.cli.base import kinds, verdict
from drystone.cli.base.command import OUTPUT, Option, command
from drystone.cli.base.output import Screen
from drystone.cli.base.told import Printed
from drystone.cli.base.waiting import Waiting
from drystone.cli.base.written import Written
from drystone.cli.inputs import loading, options
from drystone.cli.inputs.model_input import Finding, Subject

if TYPE_CHECKING:
    from drystone.cli.base.told import Files
    from drystone.model import Model
    from drystone.settlement import SupportResponse


LARGE = 0.1
"""Motion of a support by the mean size of a block from which on it is no longer small."""


@command(
    "drystone settle arch.json --gravity 0,1,-9.81 --html settled.html",
    "drystone settle arch.json --move springer-right:1,0,0 --to 0.05 --html spread.html",
)
def settle(
    *,
    move: loading.Moves = (),
    subject: Subject,
    seismic: loading.Seismic = None,
    finding: Finding,
    to: Annotated[
        float | None,
        Option(
            "Follow the blocks by finite steps until the corner of a support that moves farthest "
            "has moved by this, m, or they fall.",
            kind=kinds.POSITIVE,
        ),
    ] = None,
    compliance: Annotated[
        float,
        Option(
            "Overlap of a corner under the mean weight of a block, as a share of the motion: small "
            "for stiff blocks (0.001).",
            kind=kinds.POSITIVE,
            expert=True,
        ),
    ] = 1e-3,
    time_limit: options.TimeLimit = None,
    curve: Annotated[
        Path | None,
        Option(
            "With --to: write the curve of force against displacement, .csv or .json.",
            OUTPUT,
            kind=kinds.target(".csv", ".json"),
            expert=True,
        ),
    ] = None,
    wanted: Written,
    waiting: Waiting,
) -> Printed:
    """Where the blocks come to rest; with --move, which joints open when supports move.

    Exit code 0: the blocks come to rest, or follow the supports up to --to. 1: they do not. 2: bad
    input.
    """
    model = subject.prepared(waiting, finding, seismic, move, settling=True)
    wanted.require_through(model.assembly)
    if model.load.motion is None and (move or to is not None):
        raise InputError(
            "no support moves", where="--move", remedy="write BLOCK:DX,DY,DZ, such as 0,0,-0.01"
        )
    if curve is not None and to is None:
        raise InputError("there is no curve without --to", where="--curve", remedy="add --to")
    if model.load.motion is None:
        return followed_answer.answer(model, subject.model, wanted, waiting, time_limit)
    if to is not None:
        return _far(model, to, subject.model, wanted, curve, time_limit, waiting)
    if time_limit is not None:
        raise InputError(
            "small motions of supports take no steps that could end early",
            where="--time-limit",
            remedy="leave it out, or add --to",
        )
    # work is imported when there is some
    from drystone.settlement import SupportResponseOptions, support_response

    waiting.stage("solve", "settling")
    found = support_response(model, options=SupportResponseOptions(compliance=compliance))
    data = _content(found, subject.model)
    code = verdict.exit_code(found.result, strict=False)
    files = partial(_files, found, wanted)
    notes = model.notes
    if found.size > LARGE * model.assembly.size.mean():
        notes += (
            "the motion is large, and this answer is for small ones: --to follows the blocks",
        )
    return Printed(data, partial(_show, data), code, notes, files)


def _far(
    model: Model,
    to: float,
    source: str,
    wanted: Written,
    curve: Path | None,
    time_limit: float | None,
    waiting: Waiting,
) -> Printed:
    """Supports that move by finite amounts."""
    from drystone.settlement import End, move_supports  # as above

    if wanted.joints or wanted.strength is not None or wanted.cad is not None:
        raise InputError(
            "--to has no table of joints and no file for CAD programs",
            remedy="ask for --html, --png, --curve or --json",
        )
    waiting.stage("solve", "moving")
    with waiting.keywords(time_limit) as common:
        found = move_supports(model, to=to, **common)
    curves = Curves(html=wanted.html, png=wanted.png, section=wanted.section, curve=curve)
    code = 0 if found.end is End.REACHED else 1
    return large_answer.answer(found, source, model.notes, curves, code)


def _files(found: SupportResponse, wanted: Written) -> Files:
    tables, said = wanted.tables(found.result)
    tables = [*wanted.for_cad(found), *tables]
    if wanted.html is None and wanted.png is None:
        return tables, said
    from drystone import view  # as above
    from drystone.view.scenes.settlement_scenes import moved_scene, settlement_scene

    page = partial(view.save_page, wanted.cut(settlement_scene(found)))
    figure = partial(view.save_figure, wanted.cut(moved_scene(found)))
    return [*wanted.jobs(page, figure), *tables], said


def _content(answer: SupportResponse, model: str) -> dict[str, Any]:
    """The answer as plain values: forces in N, lengths in m, rotations in rad."""
    import numpy as np  # as above

    from drystone.settlement import support_forces

    result, before = answer.result, answer.before
    assembly, contacts, motion = result.assembly, result.contacts, result.load.motion
    names = assembly.names
    moved = [] if motion is None else np.flatnonzero(motion.any(axis=1)).tolist()
    data: dict[str, Any] = {
        "model": model,
        "verdict": result.verdict.value,
        "method": result.method,
        "message": result.message,
        "motion": [
            {
                "block": names[i],
                "translation": motion[i, :3].tolist(),
                "rotation": motion[i, 3:].tolist(),
            }
            for i in moved
            if motion is not None
        ],
        "open": [],
        "sliding": [],
        "supports": [],
        "joints": [],
        "residuals": dataclasses.asdict(result.residuals) if result.residuals else None,
    }
    if result.force is None or before.force is None:
        return data

    def joint(i: int) -> dict[str, Any]:
        blocks = [names[contacts.block_a[i]], names[contacts.block_b[i]]]
        return {"interface": i, "blocks": blocks}

    for key, distance, where in (
        ("open", answer.opening, answer.open_joints()),
        ("sliding", answer.slide, answer.sliding_joints()),
    ):
        most = np.full(contacts.count, -np.inf)
        np.maximum.at(most, contacts.interface, distance)
        rows = [{**joint(i), "distance": float(most[i])} for i in where.tolist()]
        data[key] = sorted(rows, key=lambda row: -row["distance"])
    first, last, change = before.resultants, result.resultants, answer.change()
    fixed = assembly.fixed
    for i in np.flatnonzero(~(fixed[contacts.block_a] & fixed[contacts.block_b])).tolist():
        one = {
            "normal_before": float(first.normal[i]),
            "normal": float(last.normal[i]),
            "tangential_before": float(first.tangential[i]),
            "tangential": float(last.tangential[i]),
            "change": change[i].tolist(),
        }
        data["joints"].append({**joint(i), **one})
    was, is_ = support_forces(before), support_forces(result)
    data["supports"] = [
        {"block": names[i], "before": was[i].tolist(), "after": is_[i].tolist()}
        for i in np.flatnonzero(assembly.fixed).tolist()
    ]
    return data


def _show(data: Mapping[str, Any], screen: Screen) -> None:
    """The answer for a person."""
    word = "SETTLED" if data["verdict"] == "stable" else data["verdict"].upper()
    screen.line(str(data["model"]), word, verdict.STYLE.get(data["verdict"], "bold"))
    screen.line(data["message"])
    for row in data["motion"]:
        degrees = [math.degrees(value) for value in row["rotation"]]
        turn = f", turned by {_plain(degrees)} degrees" if any(degrees) else ""
        screen.line(f"moved: {row['block']} by {_plain(row['translation'])} m{turn}")
    if data["joints"]:
        _show_joints(screen, data)


def _show_joints(screen: Screen, data: Mapping[str, Any]) -> None:
    for key, word in (("open", "joints that open"), ("sliding", "joints that slide")):
        rows = data[key]
        screen.line(f"{word}: {len(rows) or 'none'}")
        told = [(_between(row), units.quantity(row["distance"], "m")) for row in rows]
        screen.table(("joint", "by at most"), told)
    joints = sorted(data["joints"], key=lambda row: -_length(row["change"]))
    least = verdict.NEGLIGIBLE * max(abs(row["normal"]) for row in joints)
    supports = sorted(data["supports"], key=_support_change)
    screen.table(
        ("support", "gives", "after"),
        [
            (row["block"], *(units.components(row[key], "N") for key in ("before", "after")))
            for row in supports
        ],
    )
    keys = ("normal_before", "normal", "tangential_before", "tangential")
    screen.table(
        ("joint", "normal", "after", "friction", "after"),
        [
            (_between(row), *(units.quantity(row[key], "N", least) for key in keys))
            for row in joints
        ],
    )


def _between(row: Mapping[str, Any]) -> str:
    return " - ".join(row["blocks"])


def _plain(values: Sequence[float]) -> str:
    return ", ".join(f"{value + 0.0:g}" for value in values)


def _length(values: Sequence[float]) -> float:
    return float(sum(value * value for value in values) ** 0.5)


def _support_change(row: Mapping[str, Any]) -> float:
    pairs = zip(row["before"], row["after"], strict=True)
    return -_length([after - before for before, after in pairs])
