"""A verdict on the terminal, as JSON, as pictures, and as an exit code."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.cli import options, output
from drystone.cli.waiting import Waiting
from drystone.errors import counted

if TYPE_CHECKING:
    from drystone.files import Job
    from drystone.limits import Limit, TiltSweep
    from drystone.model import Model
    from drystone.results import Result

LISTED = 12
"""Rows shown of a table; --json has all."""
STYLE = {"stable": "bold green", "unstable": "bold red", "undecided": "bold yellow"}


@dataclass(frozen=True)
class Files:
    """The pictures that were asked for.

    Attributes
    ----------
    html, png
        Checked paths; ``None`` where none is wanted.
    """

    html: Path | None
    png: Path | None

    @classmethod
    def checked(cls, html: str | None, png: str | None) -> Files:
        """Refuse wrong suffixes and missing folders before the work begins."""
        return cls(
            None if html is None else options.output_path(html, "--html", (".html", ".htm")),
            None if png is None else options.output_path(png, "--png", (".png", ".svg")),
        )

    def jobs(self, page: Callable[[Path], None], figure: Callable[[Path], None]) -> list[Job]:
        """What :func:`drystone.files.write_together` is to write, from what writes each."""
        both = ((self.html, page), (self.png, figure))
        return [(path, write) for path, write in both if path is not None]

    def of(self, subject: Result | Limit | TiltSweep, source: str = "") -> list[Job]:
        """The pictures of an answer about the model of a file."""
        if self.html is None and self.png is None:
            return []
        from drystone import view  # the program starts fast: pictures are imported when asked for

        return self.jobs(
            partial(view.save_page, subject, source=source),
            partial(view.save_figure, subject, source=source),
        )

    def write(
        self, subject: Result | Limit | TiltSweep, waiting: Waiting, source: str = ""
    ) -> None:
        """Write the pictures of an answer, all or none."""
        write(self.of(subject, source), waiting)

    def written(self) -> list[str]:
        """Their names."""
        return [str(path) for path in (self.html, self.png) if path is not None]


def write(jobs: list[Job], waiting: Waiting) -> list[str]:
    """Write files, all or none; their names."""
    if not jobs:
        return []
    from drystone.files import write_together

    waiting.stage("pictures", "writing")
    written = write_together(jobs)
    waiting.wrote += written
    return written


def solve(model: Model, waiting: Waiting, time_limit: float | None) -> Result:
    """The verdict of the whole cascade, or what is known of it when time or Ctrl-C end it."""
    from drystone.stability import CheckOptions, check

    waiting.stage("solve", "solving")
    chosen = CheckOptions() if time_limit is None else CheckOptions(time_limit_s=time_limit)
    with waiting.stoppable() as stop:
        return check(model, options=chosen, progress=waiting, stop=stop)


def is_sensitive(result: Result) -> bool:
    """Whether it stands for some contact stiffnesses only."""
    return result.stable and result.samples.standing < result.samples.tried


def exit_code(result: Result, strict: bool) -> int:
    """0 for stable; with ``strict`` only when it stands for every stiffness, and all were tried."""
    robust = not is_sensitive(result) and not result.stopped
    return 0 if result.stable and (robust or not strict) else 1


def content(result: Result, spent: Mapping[str, float], model: str, files: Files) -> dict[str, Any]:
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
        "stopped": result.stopped,
        "blocks": len(assembly),
        "free_blocks": len(assembly.free),
        "interfaces": contacts.count,
        "corners": contacts.corner_count,
        "mass": float(assembly.mass[assembly.free].sum()),
        "falling": list(result.falling_names),
        "props": props(result),
        "samples": dataclasses.asdict(result.samples),
        "residuals": dataclasses.asdict(result.residuals) if result.residuals else None,
        "largest": largest(result),
        "notes": list(result.model.notes),
        "files": files.written(),
        "time_s": {
            "read": spent.get("read", 0.0),
            "detect": spent.get("detect", 0.0),
            "solve": max(spent.get("solve", 0.0) - checking, 0.0),
            "check": checking,
        },
    }


def props(result: Result) -> list[dict[str, Any]]:
    """What would hold each falling block: force [N] and moment [N m] about its centroid."""
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
    """Where it works hardest: the interfaces with the most pressure and the most friction."""
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


def show(data: Mapping[str, Any]) -> None:
    """The answer for a person."""
    from rich.table import Table

    console = output.console()
    word = data["verdict"].upper() + (" (sensitive)" if data["sensitive"] else "")
    console.print(
        f"[{STYLE.get(data['verdict'], 'bold')}]{word}[/]  {output.safe(str(data['model']))}"
    )
    if data["message"]:
        console.print(output.safe(data["message"]))
    console.print(
        f"{data['blocks']} blocks ({data['free_blocks']} free, {output.number(data['mass'])} kg), "
        f"{counted(data['interfaces'], 'interface')}, {counted(data['corners'], 'corner')}"
    )
    if data["falling"]:
        _show_falling(console, data)
    if data["largest"] is not None:
        table = Table("", "between", "normal [N]", "friction [N]", "utilisation", box=None)
        for title, key in (("largest force", "force"), ("most friction used", "utilisation")):
            row = data["largest"][key]
            used = row["utilisation"]
            table.add_row(
                title,
                output.safe(" - ".join(row["blocks"])),
                output.number(row["normal"]),
                output.number(
                    row["tangential"] if row["tangential"] > 1e-6 * row["normal"] else 0.0
                ),
                f"{used:.1%}" if np.isfinite(used) else "no capacity",
            )
        console.print(table)
    if data["samples"]["tried"]:
        tried, standing = data["samples"]["tried"], data["samples"]["standing"]
        console.print(f"contact stiffnesses: stands for {standing} of {tried} tried")
    for note in data["notes"]:
        console.print(f"[yellow]note:[/] {output.safe(note)}")
    times = ", ".join(f"{key} {value:.2f} s" for key, value in data["time_s"].items())
    console.print(f"[dim]{times}[/]")
    for name in data["files"]:
        console.print(f"wrote {output.safe(name)}")


def _show_falling(console: Any, data: Mapping[str, Any]) -> None:
    from rich.table import Table

    needs = {row["block"]: row for row in data["props"]}
    rows = [*needs, *(name for name in data["falling"] if name not in needs)]
    console.print(f"falls: {len(rows)} block{'s' if len(rows) > 1 else ''}")
    table = Table("block", "prop force [N]", "prop moment [N m]", box=None)
    for name in rows[:LISTED]:
        need = needs.get(name)
        force = output.vector(need["force"]) if need else "-"
        moment = output.vector(need["moment"]) if need else "-"
        table.add_row(output.safe(name), force, moment)
    console.print(table)
    if len(rows) > LISTED:
        console.print(f"[dim]and {len(rows) - LISTED} more (--json lists all)[/]")
