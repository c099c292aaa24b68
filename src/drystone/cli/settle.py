"""``drystone settle``: what happens when supports move a little?"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drystone.cli import loading, options, output, verdict
from drystone.cli.groups import Finding, Subject, Written, expanded
from drystone.cli.waiting import Waiting
from drystone.errors import InputError

if TYPE_CHECKING:
    from drystone.files import Job
    from drystone.model import Model
    from drystone.settlement import Settlement

LISTED = 12
"""Rows shown of a table; --json has all."""


@expanded
def settle(
    *,
    moves: loading.Moves = None,
    subject: Subject,
    seismic: loading.Seismic = None,
    finding: Finding,
    compliance: Annotated[
        float,
        typer.Option(
            help="Overlap of a corner under the mean weight of a block, as a share of the motion: "
            "small for stiff blocks."
        ),
    ] = 1e-3,
    wanted: Written,
    as_json: options.Json = False,
) -> int:
    """Which joints open, and how the forces change, when supports move a little.

    Exit code 0: the blocks come to rest. 1: that was not found. 2: bad input.
    """
    files, tables = wanted.checked()
    options.positive(compliance, "--compliance")
    with Waiting() as waiting:
        prepared = subject.prepared(waiting, finding, seismic=seismic, moves=moves, settling=True)
        if prepared.load.motion is None:
            raise InputError(
                "no support moves", where="--move", remedy="write BLOCK:DX,DY,DZ, such as 0,0,-0.01"
            )
        from drystone.settlement import SettlementOptions  # work is imported when there is some
        from drystone.settlement import settle as solve

        waiting.stage("solve", "settling")
        chosen = SettlementOptions(compliance=compliance)
        answer = solve(prepared, options=chosen)
        rows, said = tables.of(answer.result)
        pictures = _pictures(answer, files, subject.model)
        written = verdict.write([*pictures, *rows], waiting)
    data = _content(answer, prepared, subject.model)
    data["notes"] += said
    data["files"] = written
    data["time_s"] = dict(waiting.time_s)
    if as_json:
        output.emit(data)
    else:
        _show(data)
    return verdict.exit_code(answer.result, strict=False)


def _pictures(answer: Settlement, files: verdict.Files, source: str) -> list[Job]:
    if not files.written():
        return []
    from drystone import view  # as above
    from drystone.view.settlement import moved_scene, settlement_scene

    return files.jobs(
        partial(view.save_page, settlement_scene(answer, source)),
        partial(view.save_figure, moved_scene(answer, source)),
    )


def _content(answer: Settlement, prepared: Model, model: str) -> dict[str, Any]:
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
        "notes": list(prepared.notes),
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


def _show(data: Mapping[str, Any]) -> None:
    """The answer for a person."""
    console = output.console()
    style = verdict.STYLE.get(data["verdict"], "bold")
    word = "SETTLED" if data["verdict"] == "stable" else data["verdict"].upper()
    console.print(f"[{style}]{word}[/]  {output.safe(str(data['model']))}")
    console.print(output.safe(data["message"]))
    for row in data["motion"]:
        turn = f", turned by {_plain(row['rotation'])} rad" if any(row["rotation"]) else ""
        console.print(f"moved: {output.safe(row['block'])} by {_plain(row['translation'])} m{turn}")
    if data["joints"]:
        _show_joints(console, data)
    for note in data["notes"]:
        console.print(f"[yellow]note:[/] {output.safe(note)}")
    times = ", ".join(f"{key} {value:.2f} s" for key, value in data["time_s"].items())
    console.print(f"[dim]{times}[/]")
    for name in data["files"]:
        console.print(f"wrote {output.safe(name)}")


def _show_joints(console: Any, data: Mapping[str, Any]) -> None:
    for key, word in (("open", "joints that open"), ("sliding", "joints that slide")):
        rows = data[key]
        console.print(f"{word}: {len(rows) or 'none'}")
        if rows:
            _table(
                console,
                ("joint", "by at most, mm"),
                [(_between(row), f"{1e3 * row['distance']:.4g}") for row in rows],
            )
    joints = sorted(data["joints"], key=lambda row: -_length(row["change"]))
    small = 1e-6 * max(abs(row["normal"]) for row in joints)

    def shown(value: float) -> str:
        return output.number(value if abs(value) > small else 0.0)

    supports = sorted(data["supports"], key=_support_change)
    _table(
        console,
        ("support", "gives [N]", "after"),
        [
            (
                output.safe(row["block"]),
                *(", ".join(map(shown, row[key])) for key in ("before", "after")),
            )
            for row in supports
        ],
    )
    keys = ("normal_before", "normal", "tangential_before", "tangential")
    _table(
        console,
        ("joint", "normal [N]", "after", "friction [N]", "after"),
        [(_between(row), *(shown(row[key]) for key in keys)) for row in joints],
    )


def _table(console: Any, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    from rich.table import Table  # slow to import

    table = Table(*head, box=None)
    for row in rows[:LISTED]:
        table.add_row(*row)
    console.print(table)
    if len(rows) > LISTED:
        console.print(f"[dim]and {len(rows) - LISTED} more (--json lists all)[/]")


def _between(row: Mapping[str, Any]) -> str:
    return output.safe(" - ".join(row["blocks"]))


def _plain(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _length(values: Sequence[float]) -> float:
    return float(sum(value * value for value in values) ** 0.5)


def _support_change(row: Mapping[str, Any]) -> float:
    pairs = zip(row["before"], row["after"], strict=True)
    return -_length([after - before for before, after in pairs])
