"""A static figure: PNG, SVG or PDF through matplotlib, which is imported only here, when asked."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Collection
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from drystone.arrays import Floats, frozen_floats
from drystone.contacts import Contacts
from drystone.errors import FormatError, InputError
from drystone.files import write_whole
from drystone.geometry.frames import unit
from drystone.results import Verdict
from drystone.view.ink import COLOURS, Sheet, draw_blocks, draw_layer, draw_motion
from drystone.view.palette import STATE_COLOUR, STATE_LABEL, State
from drystone.view.scene import Layer, LayerKind, Scene, Stage
from drystone.view.staging import Subject, scene_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUFFIXES = ("png", "svg", "pdf")
VERDICT_COLOUR = {Verdict.STABLE: "#00664b", Verdict.UNSTABLE: "#a33c00"}
AXES = (0.02, 0.11, 0.96, 0.75)
"""Where the drawing lies in the figure: left, bottom, width, height as shares."""


def save_figure(
    subject: Subject,
    path: str | PathLike[str],
    contacts: Contacts | None = None,
    *,
    toward: Any = None,
    size: Any = (9.0, 6.5),
    dpi: float = 150.0,
    layers: Collection[str] | None = None,
    arrow_scale: float = 1.0,
    stage: int = 0,
) -> None:
    """Draw the model, with what is known of it, in parallel projection.

    Parameters
    ----------
    subject
        A result, an assembly, or a scene put together by hand.
    path
        Its suffix says PNG, SVG or PDF. Written to a temporary name beside it and renamed.
    contacts
        Of an assembly; a result has its own. They also tell which block hides which.
    toward : (3,)
        From the model to the eye; any length.
    size : (2,) [inches]
    dpi
        Pixels per inch of a PNG.
    layers
        Keys of the layers to show, such as "interfaces", "pressure", "tension", "resultants"; left
        out, the arrows that the page shows at first.
    arrow_scale
        Makes arrows longer (above 1) or shorter.
    stage
        Of a scene with several.

    Raises
    ------
    InputError
        A suffix, size, direction, layer or stage that does not exist, or contacts of another model.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from drystone.models import tower
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> save_figure(tower(3), folder / "tower.png", size=(3, 2), dpi=50)
    >>> (folder / "tower.png").exists()
    True
    """
    kind = Path(path).suffix.lower().lstrip(".")
    if kind not in SUFFIXES:
        raise FormatError(
            f"a figure cannot be written as '.{kind}'",
            where=str(path),
            remedy="end the name in .png, .svg or .pdf",
        )
    width, height = frozen_floats(size, (2,), "size")
    if not (width > 0.0 and height > 0.0 and dpi > 0.0):
        raise InputError("size and dpi must be above zero")
    scene = scene_of(subject, contacts)
    eye = scene.toward if toward is None else unit(toward, "view direction")
    drawing = draw(scene, eye, (float(width), float(height)), layers, float(arrow_scale), stage)

    def fill(file: BinaryIO) -> None:
        with warnings.catch_warnings():
            # A name in a script that the font lacks is drawn with boxes; the figure is still good.
            warnings.filterwarnings("ignore", message="Glyph .* missing from font")
            drawing.savefig(file, format=kind, dpi=dpi)

    write_whole(path, fill)


def draw(
    scene: Scene,
    toward: Floats,
    size: tuple[float, float],
    layers: Collection[str] | None,
    arrow_scale: float,
    stage: int,
) -> Figure:
    """The matplotlib figure of one stage; no state of pyplot is touched."""
    from matplotlib.figure import Figure  # heavy, and only figures need it

    if not -len(scene.stages) <= stage < len(scene.stages):
        raise InputError(f"there is no stage {stage}", remedy=f"{len(scene.stages)} exist")
    shown = scene.stages[stage]
    chosen = _chosen(shown, layers)
    figure = Figure(figsize=size, facecolor="white")
    axes = figure.add_axes(AXES)
    axes.set_aspect("equal", adjustable="datalim")
    axes.axis("off")
    sheet = Sheet(axes, scene, shown, toward, AXES[2] * size[0], AXES[3] * size[1])
    draw_blocks(sheet)
    draw_motion(sheet)
    scale = scene.force_scale * arrow_scale
    for layer in chosen:
        draw_layer(sheet, layer, scale)
    axes.autoscale_view()
    axes.margins(0.03)
    _draw_scale_bar(sheet)
    _write_title(figure, shown, size)
    _write_legend(figure, sheet, chosen)
    return figure


def _chosen(stage: Stage, layers: Collection[str] | None) -> list[Layer]:
    if layers is None:
        return [x for x in stage.layers if x.visible and x.kind is not LayerKind.POLYGONS]
    known = {layer.key for layer in stage.layers}
    for key in layers:
        if key not in known:
            raise InputError(
                f"there is no layer '{key}'",
                remedy=f"there are {', '.join(sorted(known))}" if known else "it has no layers",
            )
    return [layer for layer in stage.layers if layer.key in layers]


def _draw_scale_bar(sheet: Sheet) -> None:
    """A bar of a round length, about a sixth of the drawing wide."""
    axes = sheet.axes
    low, high = axes.dataLim.min, axes.dataLim.max
    span = max((high[0] - low[0]) * 1.06, (high[1] - low[1]) * 1.06 * sheet.width / sheet.height)
    if span <= 0.0:
        return
    decade = 10.0 ** np.floor(np.log10(span / 6.0))
    length = decade * max(f for f in (1.0, 2.0, 5.0) if f * decade <= span / 6.0)
    share = length / span
    axes.plot(
        [0.01, 0.01 + share], [0.015, 0.015], color="black", linewidth=2.0,
        transform=axes.transAxes, solid_capstyle="butt", clip_on=False,
    )  # fmt: skip
    axes.text(
        0.01 + 0.5 * share, 0.025, quantity(float(length), "m"), transform=axes.transAxes,
        ha="center", va="bottom", fontsize=8,
    )  # fmt: skip


def _write_title(figure: Figure, stage: Stage, size: tuple[float, float]) -> None:
    colour = VERDICT_COLOUR.get(stage.verdict, "black") if stage.verdict else "black"
    characters = max(20, int(size[0] * 12.5))
    top = 0.975
    if stage.headline:
        figure.text(
            0.02, top, textwrap.shorten(stage.headline, int(0.7 * characters), placeholder=" ..."),
            fontsize=13, fontweight="bold", color=colour, va="top", parse_math=False,
        )  # fmt: skip
        top -= 0.32 / size[1]
    lines = textwrap.wrap(stage.message, characters, max_lines=2, placeholder=" ...")
    figure.text(
        0.02, top, "\n".join(lines), fontsize=9, color="#444444", va="top", parse_math=False
    )


def _write_legend(figure: Figure, sheet: Sheet, layers: list[Layer]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Patch(facecolor=STATE_COLOUR["light"][state], edgecolor="#555555", label=label)
        for state, label in STATE_LABEL.items()
        if (sheet.stage.state == state).any()
    ]
    if sheet.shows_motion:
        colour = STATE_COLOUR["light"][State.FALLING]
        handles.append(Line2D([], [], color=colour, linestyle="--", label="first motion, scaled"))
    for layer in layers:
        colour = COLOURS[layer.colour]
        if layer.kind is LayerKind.POLYGONS:
            handles.append(Patch(facecolor=colour, alpha=0.55, label=layer.label))
            continue
        text = layer.label
        if layer.kind is LayerKind.ARROWS:
            text += f", up to {quantity(layer.largest, 'N')}"
        handles.append(Line2D([], [], color=colour, linewidth=1.6 * layer.width, label=text))
    figure.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(0.012, 0.0), ncols=4, frameon=False,
        fontsize=8, handlelength=1.6, columnspacing=1.6,
    )  # fmt: skip


def quantity(value: float, unit_name: str) -> str:
    """Three digits and a prefix: ``12.3 kN``."""
    for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ")):
        if abs(value) >= 0.9995 * factor:
            return f"{value / factor:.3g} {prefix}{unit_name}"
    return f"{value:.3g} {unit_name}"
