"""Joint tables that a command writes: CSV, JSON, or a page to print."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from drystone.cli.options import output_path, positive

if TYPE_CHECKING:
    from drystone.files import Job
    from drystone.results import Result

Joints: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--joints",
        help="Write forces, friction, eccentricity and pressure of the joints: .csv or .json for "
        "all, .html for a page on the worst. Can be given several times.",
    ),
]
Strength: TypeAlias = Annotated[
    float | None,
    typer.Option(help="Pressure in MPa that the stone bears; joints above it are marked."),
]


@dataclass(frozen=True)
class JointFiles:
    """Where to write, and the strength [Pa] to hold the pressures against."""

    paths: tuple[Path, ...]
    strength: float | None

    def named(self) -> list[str]:
        """The files that were asked for."""
        return [str(path) for path in self.paths]

    def of(self, result: Result) -> tuple[list[Job], list[str]]:
        """What :func:`drystone.files.write_together` is to write, and remarks."""
        if result.force is None:
            said = ["no joint table: there are no forces"] if self.paths else []
            return [], said
        if not self.paths and self.strength is None:
            return [], []
        from drystone.files import write_bytes  # work is imported when there is some
        from drystone.view import save_report

        table = result.joints(strength=self.strength)
        jobs: list[Job] = []
        for path in self.paths:
            if path.suffix.lower() == ".html":
                jobs.append((path, partial(save_report, result, strength=self.strength)))
            elif path.suffix.lower() == ".csv":
                jobs.append((path, table.to_csv))
            else:
                content = json.dumps({"strength": self.strength, **table.to_dict()})
                jobs.append((path, partial(write_bytes, data=content.encode("utf-8"))))
        said = []
        if self.strength is not None:
            over = int(table["over_strength"].sum())
            said.append(
                f"the peak pressure exceeds {self.strength / 1e6:g} MPa at {over} of "
                f"{len(table)} joints"
            )
        return jobs, said


def checked(paths: list[str] | None, strength: float | None) -> JointFiles:
    """Refuse wrong suffixes and missing folders before the work begins."""
    positive(strength, "--strength")
    chosen = [output_path(path, "--joints", (".csv", ".json", ".html")) for path in paths or ()]
    return JointFiles(tuple(chosen), None if strength is None else 1e6 * strength)
