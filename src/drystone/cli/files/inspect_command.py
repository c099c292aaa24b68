"""``drystone inspect``: the blocks of a file, their defects and their contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base import units as si
from drystone.base.errors import InputError, counted
from drystone.cli.base.command import CONTACTS, OUTPUT, Option, command
from drystone.cli.base.output import LISTED, Screen, grouped
from drystone.cli.base.told import Printed
from drystone.cli.base.waiting import Waiting
from drystone.cli.base.written import Pictures
from drystone.cli.inputs import options
from drystone.cli.inputs.model_input import Source, Tolerances

if TYPE_CHECKING:
    from drystone.assembly import Assembly
    from drystone.base.arrays import Floats
    from drystone.cli.base.told import Files
    from drystone.detection import Detection, GapSweep
    from drystone.io.build import Built


@command("drystone inspect arch.json", "drystone inspect arch.json --sweep --html contacts.html")
def inspect(
    *,
    source: Source,
    supports: options.Supports = None,
    tolerances: Tolerances,
    sweep: Annotated[bool, Option("Count the contacts for many gap tolerances.", CONTACTS)] = False,
    pictures: Pictures,
    everything: Annotated[bool, Option("List every block.", OUTPUT, ("--all",))] = False,
    waiting: Waiting,
) -> Printed:
    """List the blocks of a model, the defects of their meshes and the contacts between them.

    The page and the figure show the contacts, near misses in orange. Exit code 0: every block can
    be used. 2: some cannot.
    """
    from drystone import io  # the program starts fast: work is imported when there is some
    from drystone.detection import find_contacts

    waiting.stage("read", f"reading {source.model}")
    built = io.inspect(source.model, supports=supports, **source.how())
    assembly, notes = _usable(built, supports)
    detection = swept = None
    if assembly is not None:
        pictures.require_through(assembly)
        waiting.stage("detect", "finding contacts")
        detection = find_contacts(assembly, options=tolerances.options())
        swept = _swept(assembly, waiting) if sweep else None
    data = _content(source.model, built, assembly, detection, swept)
    lines = [] if detection is None else list(detection.report.summary())
    lines += [] if swept is None else swept.summary()

    def files() -> Files:
        if assembly is None or detection is None:
            return [], []
        return _pictures(assembly, detection, swept, built.bare, pictures)

    show = partial(_show, data, lines, everything)
    return Printed(data, show, 2 if built.defects else 0, notes, files)


def _content(
    model: str,
    built: Built,
    assembly: Assembly | None,
    detection: Detection | None,
    swept: GapSweep | None,
) -> dict[str, Any]:
    """The answer as plain values: lengths in m, volumes in m3, masses in kg."""
    fixed = {} if assembly is None else dict(zip(assembly.names, assembly.fixed, strict=True))
    blocks = [
        {
            "name": block.name,
            "fixed": bool(fixed.get(block.name, was)),
            "volume": float(block.volume),
            "mass": float(block.mass),
            "centroid": block.centroid.tolist(),
            "bounds": block.bounds.tolist(),
            "vertices": len(block.vertices),
            "faces": len(block.faces),
            "repairs": list(block.repairs),
        }
        for block, was in zip(built.blocks, built.fixed, strict=True)
        if block is not None
    ]
    return {
        "model": model,
        "blocks": blocks,
        "volume": sum(block["volume"] for block in blocks),
        "defects": [
            {
                "what": error.what,
                "where": error.where,
                "remedy": error.remedy,
                "kind": error.kind,
            }
            for error in built.defects
        ],
        "contacts": None if detection is None else detection.report.to_dict(),
        "sweep": None if swept is None else swept.to_dict(),
    }


def _usable(built: Built, supports: str | None) -> tuple[Assembly | None, list[str]]:
    """The blocks that can be used, with their supports, and notes."""
    from drystone.supports import ground_of, select

    assembly, notes = built.assembly, list(built.notes)
    if assembly is not None:
        assembly, chosen = ground_of(assembly, supports)
        return assembly if supports is None else select(assembly, str(chosen)), notes
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
            assembly = select(assembly, supports)
        except InputError as error:
            notes.append(f"--supports waits for the defects: {error}")
    return assembly, notes


def _swept(assembly: Assembly, waiting: Waiting) -> GapSweep:
    from drystone.detection import gap_sweep

    waiting.stage("sweep", "trying gaps")
    return gap_sweep(assembly, progress=waiting)


def _pictures(
    assembly: Assembly,
    found: Detection,
    swept: GapSweep | None,
    bare: Sequence[Floats],
    pictures: Pictures,
) -> Files:
    """The page and the figure."""
    from drystone import view

    scene = pictures.cut(view.inspection_scene(assembly, found, bare))
    page = partial(
        view.save_inspection, assembly, found, sweep=swept, bare=bare,
        section=pictures.section,
    )  # fmt: skip
    return pictures.jobs(page, partial(view.save_figure, scene)), []


def _show(
    data: Mapping[str, Any], contacts: Sequence[str], everything: bool, screen: Screen
) -> None:
    blocks = data["blocks"]
    supports = sum(block["fixed"] for block in blocks)
    screen.line("", data["model"])
    told = [f"{counted(len(blocks), 'block')}, {supports} of them fixed"]
    if blocks:
        import numpy as np  # the commands start fast

        bounds = np.array([block["bounds"] for block in blocks])
        extent = bounds[:, 1].max(axis=0) - bounds[:, 0].min(axis=0)
        weight = si.mass(sum(block["mass"] for block in blocks))
        told += [si.extent(extent), f"{data['volume']:,.4g} m3", weight]
    screen.line(", ".join(told))
    rows = []
    for block in blocks:
        low, high = block["bounds"]
        size = " x ".join(f"{b - a:.3g}" for a, b in zip(low, high, strict=True))
        state = "fixed" if block["fixed"] else ""
        volume, mass = f"{block['volume']:.4g}", si.mass(block["mass"])
        rows.append([block["name"], state, volume, mass, size, str(block["faces"])])
    head = ("block", "", "volume [m3]", "mass", "size [m]", "faces")
    shown, most = (rows, len(rows)) if everything else (grouped(rows), LISTED)
    screen.table(head, shown, most, more="--all lists every block")
    if len(shown) < len(rows):
        screen.dim("blocks of one size share a row (--all lists every block)")
    kinds: dict[str, list[Any]] = {}
    for error in data["defects"]:
        kinds.setdefault(error["kind"] or error["what"], []).append(error)
    for kind, errors in kinds.items():
        first = errors[0]
        fault = InputError(first["what"], where=first["where"], remedy=first["remedy"])
        more = f" ({len(errors) - 1} more: {kind}; --json lists all)" if len(errors) > 1 else ""
        screen.line(f"{fault}{more}", "defect:", "red", " ")
    for line in contacts:
        screen.line(line)
