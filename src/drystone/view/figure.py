"""A static figure: PNG, SVG or PDF by matplotlib, which is imported only when needed."""

from __future__ import annotations

import textwrap
from collections.abc import Collection
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.answer import Answer
from drystone.answer.chart import Chart
from drystone.answer.question import asked_line
from drystone.answer.scene import (
    Layer,
    LayerKind,
    MarkerShape,
    Scene,
    SceneStage,
    State,
    with_version,
)
from drystone.base.arrays import Floats, frozen_floats
from drystone.base.errors import InputError
from drystone.base.units import quantity
from drystone.contacts import Contacts
from drystone.geometry.frames import unit
from drystone.results import Verdict
from drystone.view.exploded import taken_apart
from drystone.view.ink import Sheet, draw_blocks, draw_layer, draw_motion, draw_shadow
from drystone.view.labels import draw_labels
from drystone.view.palette import (
    PRESETS,
    ROLE_COLOUR,
    STATE_COLOUR,
    STATE_LABEL,
    first_preset,
    is_shown,
    ramp_colours,
)
from drystone.view.plots import save_chart, save_plot
from drystone.view.section import behind, cut_at
from drystone.view.subjects import Subject, scene_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_VERDICT_COLOUR = {
    "light": {Verdict.STABLE: "#00664b", Verdict.UNSTABLE: "#a33c00"},
    "dark": {Verdict.STABLE: "#4fd1ab", Verdict.UNSTABLE: "#ff9a5c"},
}
AXES = (0.02, 0.11, 0.96, 0.73)
"""Place of the drawing in the figure: left, bottom, width, height as shares."""


def save_figure(
    subject: Subject,
    path: str | PathLike[str] | None = None,
    contacts: Contacts | None = None,
    *,
    toward: Any = None,
    size: Any = (9.0, 6.5),
    dpi: float = 150.0,
    preset: str | None = None,
    layers: Collection[str] | None = None,
    opacity: float | None = None,
    arrow_scale: float = 1.0,
    stage: int | None = None,
    names: bool = False,
    explode: float = 0.0,
    section: str | None = None,
    dark: bool = False,
) -> Figure:
    """Draw the model, with what is known of it, in parallel projection.

    Parameters
    ----------
    subject
        A result, a model, an assembly, a limit, a plan, a settlement, or a scene put together by
        hand.
    path
        Its suffix says PNG, SVG or PDF. Written to a temporary name beside it and renamed. Left
        out, nothing is written.
    contacts
        Of an assembly; a result has its own. They also determine which block hides which.
    toward : (3,)
        From the model to the eye; any length.
    size : (2,) [inches]
    dpi
        Pixels per inch of a PNG.
    preset
        A picture by name: ``forces``, ``solid``, ``contacts``, ``utilisation`` or ``stages``; left
        out, the one that the page shows at first.
    layers
        Keys of the layers to show instead, such as "interfaces", "joint-force", "network",
        "resultants".
    opacity
        Of the blocks, above 0 up to 1; left out, that of the preset, and 1 where layers were
        chosen.
    arrow_scale
        Makes arrows longer (above 1) or shorter.
    stage
        Of a scene with several; left out, of a limit the state that falls, of a plan the complete
        structure, else the first.
    names
        Write the names of the blocks on them. Numbers are written by the preset ``stages``.
    explode
        How far the blocks are taken apart: 0 not at all, 1 each as far again as it is from the foot
        of the model.
    section
        Cut the model across an axis: ``x`` through its middle, or ``x=1.2`` at a coordinate [m].
        What lies between the plane and the eye is not drawn.
    dark
        Draw on a dark ground.

    Returns
    -------
    matplotlib.figure.Figure
        It belongs to no window; ``figure.axes[0]`` takes what is to be added.

    Raises
    ------
    InputError
        A suffix, size, direction, preset, layer or stage that does not exist, a section beside the
        model, or contacts of another model.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from drystone.models import tower
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> figure = save_figure(tower(3), folder / "tower.png", size=(3, 2), dpi=50)
    >>> (folder / "tower.png").exists()
    True
    """
    width, height = frozen_floats(size, (2,), "size")
    if not (width > 0.0 and height > 0.0 and dpi > 0.0):
        raise InputError("size and dpi must be above zero")
    if not 0.0 <= explode < np.inf:
        raise InputError(f"explode is {explode}", remedy="give zero or more, such as 0.5")
    if isinstance(subject, Answer):
        shown = subject.figure()
        if isinstance(shown, Chart):
            return save_chart(shown, path, title=Path(subject.asked.file).stem)
        scene = replace(shown, made=with_version(subject.when))
    else:
        scene = scene_of(subject, contacts)
    if section is not None:
        scene = cut_at(scene, section)
    if explode:
        scene = taken_apart(scene, float(explode))

    def drawing() -> Figure:
        return draw(
            scene,
            (float(width), float(height)),
            toward=None if toward is None else unit(toward, "view direction"),
            preset=preset,
            layers=layers,
            opacity=opacity,
            arrow_scale=float(arrow_scale),
            stage=stage,
            names=names,
            theme="dark" if dark else "light",
        )

    return save_plot(path, drawing, dpi, "figure")


def draw(
    scene: Scene,
    size: tuple[float, float],
    *,
    toward: Floats | None = None,
    preset: str | None = None,
    layers: Collection[str] | None = None,
    opacity: float | None = None,
    arrow_scale: float = 1.0,
    stage: int | None = None,
    names: bool = False,
    theme: str = "light",
) -> Figure:
    """The matplotlib figure of one stage; no state of pyplot is touched."""
    from matplotlib.figure import Figure  # heavy, and only figures need it

    stage = scene.still if stage is None else stage
    if not -len(scene.stages) <= stage < len(scene.stages):
        raise InputError(f"there is no stage {stage}", remedy=f"{len(scene.stages)} exist")
    if preset is not None and preset not in PRESETS:
        raise InputError(f"there is no preset '{preset}'", remedy=f"there are {', '.join(PRESETS)}")
    if opacity is not None and not 0.0 < opacity <= 1.0:
        raise InputError(f"opacity is {opacity}", remedy="give a share above 0, up to 1")
    shown = scene.stages[stage]
    key = preset if preset is not None else first_preset(scene, stage)
    chosen = _chosen(shown, layers, key)
    if opacity is None:
        opacity = PRESETS[key].opacity if layers is None else 1.0
    figure = Figure(figsize=size, facecolor=ROLE_COLOUR[theme]["background"])
    axes = figure.add_axes(AXES)
    axes.set_aspect("equal", adjustable="datalim")
    axes.axis("off")
    eye = scene.toward if toward is None else toward
    width, height = AXES[2] * size[0], AXES[3] * size[1]
    sheet = Sheet(axes, scene, shown, eye, width, height, opacity, theme)
    left = chosen
    if sheet.plane is not None:
        left = [behind(layer, sheet.plane, scene.block_size) for layer in chosen]
        left = [layer for layer in left if layer.count]
    draw_shadow(sheet)
    draw_blocks(sheet, [layer for layer in left if layer.kind is LayerKind.POLYGONS])
    draw_motion(sheet)
    for layer in left:
        draw_layer(sheet, layer, arrow_scale)
    draw_labels(sheet, numbers=PRESETS[key].numbers, names=names)
    axes.autoscale_view()
    axes.margins(0.03)
    _draw_scale_bar(sheet)
    _draw_gravity(figure, sheet)
    _write_title(figure, scene, shown, size, theme)
    _write_legend(figure, sheet, chosen)
    _draw_bar(figure, sheet, chosen)
    return figure


def _chosen(stage: SceneStage, layers: Collection[str] | None, preset: str) -> list[Layer]:
    if layers is None:
        return [layer for layer in stage.layers if is_shown(layer, preset)]
    known = {layer.key for layer in stage.layers}
    for key in layers:
        if key not in known:
            raise InputError(
                f"there is no layer '{key}'",
                remedy=f"there are {', '.join(sorted(known))}" if known else "it has no layers",
            )
    return [layer for layer in stage.layers if layer.key in layers]


def _draw_scale_bar(sheet: Sheet) -> None:
    """A scale bar of a round length, about a sixth of the width of the drawing."""
    axes = sheet.axes
    low, high = axes.dataLim.min, axes.dataLim.max
    span = max((high[0] - low[0]) * 1.06, (high[1] - low[1]) * 1.06 * sheet.width / sheet.height)
    if span <= 0.0:
        return
    decade = 10.0 ** np.floor(np.log10(span / 6.0))
    length = decade * max(f for f in (1.0, 2.0, 5.0) if f * decade <= span / 6.0)
    share = length / span
    axes.plot(
        [0.01, 0.01 + share], [0.015, 0.015], color=sheet.colours["edge"], linewidth=2.0,
        transform=axes.transAxes, solid_capstyle="butt", clip_on=False,
    )  # fmt: skip
    axes.text(
        0.01 + 0.5 * share, 0.025, quantity(float(length), "m"), transform=axes.transAxes,
        ha="center", va="bottom", fontsize=8, color=sheet.colours["edge"],
    )  # fmt: skip


def _draw_gravity(figure: Figure, sheet: Sheet) -> None:
    """An arrow along gravity, in the lower right corner."""
    pull = sheet.paper @ sheet.stage.gravity
    if np.linalg.norm(pull) < 0.2:
        return  # it points along the line of sight
    width, height = figure.get_size_inches()
    inch = 0.3 * pull
    tip = (1.0 - 0.35 / width, 0.3 / height)  # below the drawing, which may fill its place
    tail = (tip[0] - inch[0] / width, tip[1] - inch[1] / height)
    colour = sheet.colours["edge"]
    sheet.axes.annotate(
        "", xy=tip, xytext=tail, xycoords="figure fraction", textcoords="figure fraction",
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.5}, annotation_clip=False,
    )  # fmt: skip
    figure.text(
        tip[0], tip[1] - 0.05 / height, "gravity", ha="center", va="top", fontsize=7, color=colour
    )


def _write_title(
    figure: Figure, scene: Scene, stage: SceneStage, size: tuple[float, float], theme: str
) -> None:
    known = _VERDICT_COLOUR[theme]
    ink = ROLE_COLOUR[theme]["edge"]
    colour = known.get(stage.verdict, ink) if stage.verdict else ink
    characters = max(20, int(size[0] * 11.0))  # up to the colour bar
    top = 0.975
    if stage.headline:
        figure.text(
            0.02, top, textwrap.shorten(stage.headline, int(0.75 * characters), placeholder=" ..."),
            fontsize=13, fontweight="bold", color=colour, va="top", parse_math=False,
        )  # fmt: skip
        top -= 0.32 / size[1]
    facts = {**scene.facts, **stage.facts}
    asked = asked_line(facts, scene.made) if facts else ""
    asked = asked.replace(
        " \N{MIDDLE DOT}", "\N{NO-BREAK SPACE}\N{MIDDLE DOT}"
    )  # no line begins with one
    lines = textwrap.wrap(asked, characters, max_lines=2, placeholder=" ...")
    lines += textwrap.wrap(stage.message, characters, max_lines=2, placeholder=" ...")
    figure.text(0.02, top, "\n".join(lines), fontsize=8, color=ink, va="top", parse_math=False)


def _write_legend(figure: Figure, sheet: Sheet, layers: list[Layer]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Patch(
            facecolor=STATE_COLOUR[sheet.theme][state], edgecolor="#555555", label=label,
            hatch="////" if state == State.LATER else None,
        )
        for state, label in STATE_LABEL.items()
        if (sheet.stage.state == state).any()
    ]  # fmt: skip
    if sheet.shows_motion:
        colour = STATE_COLOUR[sheet.theme][State.FALLING]
        name = f"{sheet.stage.motion_name.lower()}, scaled"
        handles.append(Line2D([], [], color=colour, linestyle="--", label=name))
    for layer in layers:
        colour = sheet.colours[layer.colour]
        if layer.kind is LayerKind.POLYGONS:
            if layer.value is None:
                handles.append(Patch(facecolor=colour, alpha=0.75, label=layer.label))
            continue
        text = layer.label
        if layer.kind is LayerKind.MARKERS:
            shape = "D" if layer.shape is MarkerShape.DIAMOND else "o"
            handles.append(
                Line2D(
                    [], [], color=colour, marker=shape, linestyle="", markersize=5.5,
                    markeredgecolor=sheet.colours["edge"], label=f"{text} ({layer.count})",
                )
            )  # fmt: skip
            continue
        wide = 1.6 * layer.width
        if layer.kind is LayerKind.ARROWS or layer.value is not None:
            text += f", up to {quantity(layer.largest, layer.unit)}"
            wide = 1.6 * layer.width if layer.value is None else 3.0
        handles.append(Line2D([], [], color=colour, linewidth=wide, label=text))
    figure.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(0.012, 0.0), ncols=4, frameon=False,
        fontsize=8, handlelength=1.6, columnspacing=1.6, labelcolor=sheet.colours["edge"],
    )  # fmt: skip


def _draw_bar(figure: Figure, sheet: Sheet, layers: list[Layer]) -> None:
    """The legend of the colours of interfaces, in the upper right corner."""
    filled = [
        layer for layer in layers if layer.kind is LayerKind.POLYGONS and layer.value is not None
    ]
    for number, layer in enumerate(filled):
        bar = figure.add_axes((0.76, 0.945 - 0.1 * number, 0.21, 0.018))
        steps = np.linspace(0.0, 1.0, 33)
        colours = ramp_colours(steps[:-1] + 1.0 / 64.0, sheet.theme)
        wide = 1.5 / 32.0  # each reaches below the next one: no seams in an SVG
        bar.bar(steps[:-1], 1.0, width=wide, align="edge", color=colours, linewidth=0.0)
        bar.set_xlim(0.0, 1.0)
        bar.set_ylim(0.0, 1.0)
        top = sheet.scene.top(layer.key)
        more = "\N{GREATER-THAN OR EQUAL TO} " if layer.largest > 1.001 * top else ""
        told = [
            f"{100.0 * x * top:.0f} %" if layer.unit == "" else quantity(x * top, layer.unit)
            for x in (0.0, 0.5, 1.0)
        ]
        bar.set_xticks([0.0, 0.5, 1.0], [*told[:2], more + told[2]], fontsize=7)
        bar.set_yticks([])
        ink = sheet.colours["edge"]
        bar.tick_params(length=2, colors=ink)
        for side in bar.spines.values():
            side.set(linewidth=0.5, color=ink)
        bar.set_title(layer.label, fontsize=8, color=ink, pad=3)
