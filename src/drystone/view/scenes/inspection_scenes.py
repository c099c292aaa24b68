"""What the contact search found and what it missed, as a scene."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike

import numpy as np

from drystone.answer.asked import Asked
from drystone.answer.drawing import interface_layers, state_of
from drystone.answer.scene import Layer, LayerKind, Scene, SceneStage
from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.base.errors import counted
from drystone.base.files import write_bytes
from drystone.base.ragged import Ragged
from drystone.detection import ContactReport, Detection, GapSweep
from drystone.view.transforms.section import cut_at
from drystone.view.web.page import page_text

WIDTH, HEIGHT = 280.0, 150.0
LEFT, RIGHT, TOP, BOTTOM = 44.0, 8.0, 10.0, 30.0
"""Size [px] of the drawing of a sweep, and of its margins."""


def inspection_scene(assembly: Assembly, found: Detection, bare: Sequence[Floats] = ()) -> Scene:
    """A scene with the interfaces, and near misses between blocks that do not touch in orange.

    Parameters
    ----------
    assembly
    found
        Its contacts and their report.
    bare
        Faces (c, 3) [m] of open meshes, at their holes.

    Examples
    --------
    >>> from drystone.detection import find_contacts
    >>> from drystone.models import tower
    >>> assembly = tower(3)
    >>> inspection_scene(assembly, find_contacts(assembly)).title
    'drystone: 3 blocks, 2 interfaces'
    """
    state = state_of(assembly)
    count = f"{len(assembly)} blocks, {found.contacts.count} interfaces"
    layers = (
        *interface_layers(found.contacts),
        *_edge_layers(found),
        *missed_layers(found.report),
        *_polygon_layer("defects", "faces at holes", "help", bare),
    )
    count_line, *rest = found.report.summary()
    advice = [f"suggestion: {text}" for text in found.report.suggestions()]
    message = "; ".join([count_line, *advice, *(line for line in rest if line not in advice)])
    missed = sum(not miss.joined for miss in found.report.missed)
    near = f", {counted(missed, 'near miss', 'near misses')}" if missed else ""
    headline = (
        f"{counted(len(assembly), 'block')}, {counted(found.contacts.count, 'interface')}{near}"
    )
    stage = SceneStage("contacts", headline, message, state, layers=layers)
    facts = Asked.of_blocks(assembly, found.contacts).facts()
    return Scene(assembly, found.contacts, (stage,), f"drystone: {count}", facts)


def save_inspection(
    assembly: Assembly,
    found: Detection,
    path: str | PathLike[str],
    sweep: GapSweep | None = None,
    bare: Sequence[Floats] = (),
    section: str | None = None,
) -> None:
    """Write the page of :func:`inspection_scene`, with the report and a sweep's curve beside it.

    Parameters
    ----------
    assembly
    found
    path
        Written to a temporary name beside it and renamed.
    sweep
        Number of pairs against the gap tolerance.
    bare
        Faces (c, 3) [m] of open meshes, at their holes.
    section
        As in :func:`drystone.view.save_page`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from drystone.detection import find_contacts, gap_sweep
    >>> from drystone.models import tower
    >>> page = pathlib.Path(tempfile.mkdtemp()) / "tower.html"
    >>> swept = gap_sweep(tower(3), [1e-5, 1e-3])
    >>> save_inspection(tower(3), find_contacts(tower(3)), page, swept)
    >>> "plateau from 1e-05 to 0.001" in page.read_text(encoding="utf-8")
    True
    """
    panels = [_report_panel(found.report)]
    if sweep is not None:
        panels.append(_sweep_panel(sweep, found.report.options.gap))
    scene = replace(inspection_scene(assembly, found, bare), panels=tuple(panels))
    text = page_text(scene if section is None else cut_at(scene, section))
    write_bytes(path, text.encode("utf-8"))


def _report_panel(report: ContactReport) -> str:
    """HTML with the whole report; the line above the picture may be shortened."""
    lines = "".join(f"<p>{html.escape(line)}</p>" for line in report.summary())
    return f"    <fieldset><legend>Contact search</legend>{lines}</fieldset>"


def missed_layers(report: ContactReport) -> tuple[Layer, ...]:
    """Near misses of pairs of blocks that do not touch elsewhere."""
    missed = [miss.polygon for miss in report.missed if not miss.joined]
    areas = [polygon for polygon in missed if len(polygon) > 2]
    points = np.array([polygon for polygon in missed if len(polygon) == 2]).reshape(-1, 2, 3)
    layers = list(_polygon_layer("missed", "near misses", "missed", areas))
    if len(points):
        layers.append(
            Layer(
                "missed-points",
                "near misses of corners",
                LayerKind.LINES,
                "missed",
                points[:, 0],
                points[:, 1] - points[:, 0],
                width=2.0,
            )
        )
    return tuple(layers)


def _polygon_layer(
    key: str, label: str, colour: str, polygons: Sequence[Floats]
) -> tuple[Layer, ...]:
    """Polygons (c, 3) in one colour; no layer where there are none."""
    if not polygons:
        return ()
    start = Ragged.of(polygons).start
    corner = np.concatenate(polygons)
    return (Layer(key, label, LayerKind.POLYGONS, colour, corner, start=start.astype(np.intp)),)


def _edge_layers(found: Detection) -> tuple[Layer, ...]:
    """Contacts along a line."""
    contacts = found.contacts
    lines = contacts.start[:-1][np.diff(contacts.start) == 2]
    if len(lines) == 0:
        return ()
    position = contacts.point[lines]
    return (
        Layer(
            "lines",
            "line contacts",
            LayerKind.LINES,
            "interface",
            position,
            contacts.point[lines + 1] - position,
            width=2.0,
        ),
    )


def _sweep_panel(sweep: GapSweep, used: float) -> str:
    """HTML with the curve, its plateau shaded, and a line at the gap that was ``used``.

    Examples
    --------
    >>> from drystone.detection import gap_sweep
    >>> from drystone.models import tower
    >>> "<svg" in _sweep_panel(gap_sweep(tower(3), [1e-5, 1e-3]), 0.005)
    True
    """
    low, high = sweep.plateau
    most = max(int(sweep.pairs.max()), 1)
    x, y = _across(sweep.gap, sweep.gap), _up(sweep.pairs / most)
    band = _across(np.array([low, high]), sweep.gap)
    marks = [
        f'<rect x="{band[0]:.1f}" y="{TOP:g}" width="{max(band[1] - band[0], 2.0):.1f}"'
        f' height="{HEIGHT - TOP - BOTTOM:g}" fill="var(--accent)" opacity="0.18"/>',
        '<polyline fill="none" stroke="var(--accent)" stroke-width="2" points="'
        + " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
        + '"/>',
        f'<path d="M{LEFT:g} {TOP:g}V{HEIGHT - BOTTOM:g}H{WIDTH - RIGHT:g}" fill="none"'
        ' stroke="var(--line)"/>',
    ]
    if sweep.gap[0] <= used <= sweep.gap[-1]:
        at = float(_across(np.array([used]), sweep.gap)[0])
        marks.append(
            f'<path d="M{at:.1f} {TOP:g}V{HEIGHT - BOTTOM:g}" stroke="var(--ink)"'
            ' stroke-dasharray="3 3"/>'
        )
    marks += _ticks(sweep, most)
    told = html.escape(sweep.summary()[-1])
    return f"""    <fieldset><legend>Gap tolerance</legend>
      <svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="100%" role="img" fill="var(--quiet)"
        font-size="11" aria-label="Pairs of blocks that touch, by gap tolerance">
        {"".join(marks)}
      </svg>
      <p>{told}. Dashed: {used:g}, the one used here.</p>
    </fieldset>"""


def _across(gap: Floats, range_of: Floats) -> Floats:
    """Place of gaps on the logarithmic axis [px]."""
    first, last = np.log(range_of[0]), np.log(range_of[-1])
    share = (np.log(gap) - first) / (last - first) if last > first else np.full(len(gap), 0.5)
    place: Floats = LEFT + share * (WIDTH - LEFT - RIGHT)
    return place


def _up(share: Floats) -> Floats:
    """Place of shares of the largest number on the other axis [px]."""
    place: Floats = HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM)
    return place


def _ticks(sweep: GapSweep, most: int) -> list[str]:
    ticks = []
    for count in (0, most):
        height = float(_up(np.array([count / most]))[0]) + 4.0
        ticks.append(f'<text x="{LEFT - 5:g}" y="{height:.1f}" text-anchor="end">{count:,}</text>')
    exponents = np.arange(np.ceil(np.log10(sweep.gap[0]) - 1e-9), np.log10(sweep.gap[-1]) + 1e-9)
    step = max(-(-len(exponents) // 4), 1)
    for exponent in exponents[::step].tolist():
        at = float(_across(np.array([10.0**exponent]), sweep.gap)[0])
        ticks.append(
            f'<text x="{at:.1f}" y="{HEIGHT - BOTTOM + 13:g}" text-anchor="middle">'
            f"{10.0**exponent:g}</text>"
        )
    ticks.append(
        f'<text x="{(LEFT + WIDTH - RIGHT) / 2:g}" y="{HEIGHT - 3:g}" text-anchor="middle">'
        "gap by block size: pairs that touch</text>"
    )
    return ticks
