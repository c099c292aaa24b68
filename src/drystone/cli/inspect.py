"""``drystone inspect``: what is in a file, what is wrong with it, what touches what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drystone.cli import options, output, verdict
from drystone.cli.session import detection_options
from drystone.cli.waiting import Waiting
from drystone.errors import InputError, counted

if TYPE_CHECKING:
    from drystone.arrays import Floats
    from drystone.assembly import Assembly
    from drystone.detection import Detection, GapSweep
    from drystone.io.build import Built

LISTED = 20
"""Blocks shown without --all."""


def inspect(
    model: options.ModelArgument,
    supports: options.Supports = None,
    units: options.Units = None,
    gap: options.Gap = None,
    angle: options.Angle = None,
    edges: options.Edges = None,
    split: options.Split = False,
    sweep: Annotated[
        bool, typer.Option("--sweep", help="Count the contacts for many gap tolerances.")
    ] = False,
    html: Annotated[
        str | None,
        typer.Option(
            "--html", help="Write a page with the contacts, near misses in orange, and the sweep."
        ),
    ] = None,
    png: Annotated[
        str | None, typer.Option("--png", help="Write them as a figure, .png or .svg.")
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="List every block.")] = False,
    as_json: options.Json = False,
) -> int:
    """List the blocks of a model, the defects of their meshes and the contacts between them.

    Exit code 0: every block can be used. 2: some cannot.
    """
    files = verdict.Files.checked(html, png)
    from drystone import io  # the program starts fast: work is imported when there is some
    from drystone.detection import find_contacts

    with Waiting() as waiting:
        waiting.stage("read", f"reading {model}")
        built = io.inspect(model, units=units, split=split)
        assembly, notes = _usable(built, supports)
        report = swept = None
        written: list[str] = []
        if assembly is not None:
            waiting.stage("detect", "finding contacts")
            detection = find_contacts(assembly, options=detection_options(gap, angle, edges))
            report = detection.report
            swept = _swept(assembly, waiting) if sweep else None
            written = _draw(assembly, detection, swept, built.bare, files, waiting, model)
    blocks = [block for block in built.blocks if block is not None]
    held = (
        set()
        if assembly is None
        else {name for name, at in zip(assembly.names, assembly.fixed.tolist(), strict=True) if at}
    )
    fixed = [
        was if assembly is None or block is None else block.name in held
        for block, was in zip(built.blocks, built.fixed, strict=True)
    ]
    data: dict[str, Any] = {
        "model": model,
        "blocks": [
            {
                "name": block.name,
                "fixed": bool(is_fixed),
                "volume": float(block.volume),
                "mass": float(block.mass),
                "centroid": block.centroid.tolist(),
                "bounds": block.bounds.tolist(),
                "vertices": len(block.vertices),
                "faces": len(block.faces),
                "repairs": list(block.repairs),
            }
            for block, is_fixed in zip(built.blocks, fixed, strict=True)
            if block is not None
        ],
        "volume": float(sum(block.volume for block in blocks)),
        "defects": [
            {"what": error.what, "where": error.where, "remedy": error.remedy}
            for error in built.defects
        ],
        "contacts": None if report is None else report.to_dict(),
        "sweep": None if swept is None else swept.to_dict(),
        "files": written,
        "notes": notes,
        "time_s": dict(waiting.time_s),
    }
    if as_json:
        output.emit(data)
    else:
        lines = [] if report is None else report.summary()
        lines += [] if swept is None else swept.summary()
        _show(data, built.defects, lines, everything)
    return 2 if built.defects else 0


def _usable(built: Built, supports: str | None) -> tuple[Assembly | None, list[str]]:
    """The blocks in which contacts can be looked for, with their supports, and what to note."""
    from drystone import supports as chosen

    assembly, notes = built.assembly, list(built.notes)
    if assembly is not None:
        return assembly if supports is None else chosen.select(assembly, supports), notes
    assembly = built.usable
    if assembly is None:
        notes.append("contacts are found, and drawn, once the defects are mended")
        return None, notes
    rest = len(built.blocks) - len(assembly)
    left_out = f"{counted(rest, 'block')} left out" if rest else "as they are"
    some = counted(len(assembly), "block")
    notes.append(
        f"contacts are found among the {some} that can be used, {left_out}: mend the defects first"
    )
    if supports is not None:
        try:
            assembly = chosen.select(assembly, supports)
        except InputError as error:
            notes.append(f"--supports waits for the defects: {error}")
    return assembly, notes


def _swept(assembly: Assembly, waiting: Waiting) -> GapSweep:
    from drystone.detection import gap_sweep

    waiting.stage("sweep", "trying gaps")
    return gap_sweep(assembly, progress=waiting)


def _draw(
    assembly: Assembly,
    found: Detection,
    swept: GapSweep | None,
    bare: Sequence[Floats],
    files: verdict.Files,
    waiting: Waiting,
    source: str,
) -> list[str]:
    """Write the page and the figure that were asked for."""
    if not files.written():
        return []
    from drystone import view

    page = partial(view.save_inspection, assembly, found, sweep=swept, bare=bare, source=source)
    scene = view.inspection_scene(assembly, found, bare, source)
    figure = partial(view.save_figure, scene)
    return verdict.write(files.jobs(page, figure), waiting)


def _show(
    data: Mapping[str, Any], defects: tuple[Any, ...], contacts: list[str], everything: bool
) -> None:
    from rich.table import Table

    console = output.console()
    blocks = data["blocks"]
    supports = sum(block["fixed"] for block in blocks)
    console.print(
        f"[bold]{output.safe(data['model'])}[/]  {len(blocks)} blocks, {supports} of them fixed, "
        f"{data['volume']:,.4g} m3"
    )
    table = Table("block", "", "volume [m3]", "mass [kg]", "size [m]", "faces", box=None)
    for block in blocks if everything else blocks[:LISTED]:
        low, high = block["bounds"]
        size = " x ".join(f"{b - a:.3g}" for a, b in zip(low, high, strict=True))
        state = "fixed" if block["fixed"] else ""
        volume, mass = f"{block['volume']:.4g}", output.number(block["mass"])
        table.add_row(output.safe(block["name"]), state, volume, mass, size, str(block["faces"]))
    console.print(table)
    if len(blocks) > LISTED and not everything:
        console.print(f"[dim]and {len(blocks) - LISTED} more (--all lists every block)[/]")
    for error in defects:
        console.print(f"[red]defect:[/] {output.safe(str(error))}")
    for note in data["notes"]:
        console.print(f"[yellow]note:[/] {output.safe(note)}")
    for line in contacts:
        console.print(output.safe(line))
    for name in data["files"]:
        console.print(f"wrote {output.safe(name)}")
