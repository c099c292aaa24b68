"""A static figure and what is around it: PNG, SVG or PDF by matplotlib, imported when needed."""

from __future__ import annotations

import textwrap
from collections.abc import Collection
from dataclasses import replace
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.answer import Answer, Role
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
from drystone.base.arrays import Floats, frozen_floats, number
from drystone.base.errors import InputError
from drystone.base.settings import checked_call
from drystone.base.units import quantity
from drystone.contacts import Contacts
from drystone.geometry.frames import unit
from drystone.view.exploded import taken_apart
from drystone.view.ink import ADDED_OPACITY, as_seen, draw_blocks, draw_layer, draw_motion
from drystone.view.palette import (
    PRESETS,
    ROLE_COLOUR,
    STATE_COLOUR,
    STATE_LABEL,
    first_preset,
    is_shown,
    ramp_colours,
)
from drystone.view.plots import require_axes, save_chart, save_plot
from drystone.view.section import cut_at, seen_behind
from drystone.view.sheet import Sheet, draw_labels, draw_shadow, write_beside
from drystone.view.subjects import Subject, scene_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend
    from matplotlib.text import Text


_HEADLINE_COLOUR = {
    "light": {Role.GOOD: "#00664b", Role.BAD: "#a33c00", Role.UNSURE: "#6a5200"},
    "dark": {Role.GOOD: "#4fd1ab", Role.BAD: "#ff9a5c", Role.UNSURE: "#f0d24a"},
}


def draw_scale_bar(sheet: Sheet, figure: Figure | None = None) -> None:
    """A scale bar of a round length, about a sixth of the width of the drawing.

    With the figure it stands below the drawing, else in its corner.
    """
    axes = sheet.axes
    low, high = axes.dataLim.min, axes.dataLim.max
    box = axes.get_window_extent()
    span = max((high[0] - low[0]) * 1.06, (high[1] - low[1]) * 1.06 * box.width / box.height)
    if span <= 0.0:
        return
    decade = 10.0 ** np.floor(np.log10(span / 6.0))
    length = decade * max(f for f in (1.0, 2.0, 5.0) if f * decade <= span / 6.0)
    share = length / span
    level = 0.015
    if figure is not None:
        level = -0.8 * _strip(figure) * figure.bbox.height / box.height
    axes.plot(
        [0.01, 0.01 + share], [level, level], color=sheet.colours["edge"], linewidth=2.0,
        transform=axes.transAxes, solid_capstyle="butt", clip_on=False,
    )  # fmt: skip
    axes.text(
        0.01 + 0.5 * share, level + 0.01, quantity(float(length), "m"), transform=axes.transAxes,
        ha="center", va="bottom", fontsize=8, color=sheet.colours["edge"],
    )  # fmt: skip


def _strip(figure: Figure) -> float:
    """What the scale bar below a drawing takes of the height of a figure: 0.3 in."""
    return 0.3 / figure.get_figheight()


def draw_gravity(figure: Figure, sheet: Sheet) -> None:
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
        tip[0], tip[1] - 0.05 / height, "gravity", ha="center", va="top", fontsize=8, color=colour
    )


def write_title(figure: Figure, sheet: Sheet, *, plain: bool = False) -> list[Text]:
    """The headline; and unless ``plain`` what was asked, and the message, whole."""
    scene, stage, known = sheet.scene, sheet.stage, _HEADLINE_COLOUR[sheet.theme]
    ink = ROLE_COLOUR[sheet.theme]["edge"]
    colour = known.get(stage.role, ink) if stage.role else ink
    width, height = figure.get_size_inches()
    letters = 15.0 if figure.axes == [sheet.axes] else 11.0  # of an inch, up to the colour bar
    characters = max(20, int(width * letters))
    top, texts = 0.975, []
    write = partial(figure.text, 0.02, va="top", parse_math=False)
    if stage.headline:
        room = 0.55 * characters  # of bold letters of 13 points; a verdict may stand at the end
        points = 13.0 * min(1.0, max(0.55, room / len(stage.headline)))
        told = textwrap.wrap(stage.headline, int(room * 13.0 / points))
        texts += [write(top, "\n".join(told), fontsize=points, fontweight="bold", color=colour)]
        top -= (0.32 + 0.018 * points * (len(told) - 1)) / height
    facts = {**scene.facts, **stage.facts}
    asked = asked_line(facts, scene.made) if facts else ""
    new = "" if stage.message.casefold() == stage.headline.casefold() else stage.message
    # no dot at the beginning of a line
    asked = asked.replace(" \N{MIDDLE DOT}", "\N{NO-BREAK SPACE}\N{MIDDLE DOT}")
    lines = textwrap.wrap(asked, characters, break_on_hyphens=False)
    lines += textwrap.wrap(new, characters)
    if lines and not plain:
        texts += [write(top, "\n".join(lines), fontsize=8, color=ink)]
    return texts


def make_room(figure: Figure, sheet: Sheet, texts: list[Text], legend: Legend) -> None:
    """The drawing between the texts and the legend.

    Where it would have less than two fifths of the height, first what was asked is left out, then
    the legend: a small figure has a caption.
    """
    left, bottom, right, high = sheet.axes.get_position().extents
    whole, gap = figure.bbox.height, 0.1 * figure.dpi
    low = max(bottom, legend.get_window_extent().y1 / whole) + _strip(figure)
    while True:
        above = min([high, *((one.get_window_extent().y0 - gap) / whole for one in texts[-1:])])
        if above - low >= 0.4 or (len(texts) < 2 and low <= bottom + _strip(figure)):
            break
        if len(texts) > 1:
            texts.pop().remove()
        else:
            legend.remove()
            low = bottom + _strip(figure)
    sheet.axes.set_position((left, low, right - left, max(above - low, 0.25)))


def write_legend(figure: Figure, sheet: Sheet, layers: list[Layer]) -> Legend:
    """What the colours of blocks, the lines and the marks mean, below the drawing."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Patch(
            facecolor=(STATE_COLOUR[sheet.theme][state],
                       max(sheet.opacity, ADDED_OPACITY if state == State.ADDED else 0.0)),
            edgecolor="#555555", label=label,
            hatch="////" if state == State.LATER else None,
        )
        for state, label in STATE_LABEL.items()
        if (sheet.stage.state == state).any()
    ]  # fmt: skip
    if sheet.shows_motion:
        colour = STATE_COLOUR[sheet.theme][State.FALLING]
        name = f"{sheet.stage.motion_name.lower()}, scaled"
        handles.append(Line2D([], [], color=colour, linestyle="--", label=name))
        name, ink = "way of each block's middle, scaled", sheet.colours["edge"]
        handles.append(Line2D([], [], color=ink, marker=">", markersize=4.0, label=name))
    for layer in layers:
        colour, text = sheet.colours[layer.colour], layer.label
        if layer.kind is LayerKind.POLYGONS:
            if layer.value is None:
                handles.append(Patch(facecolor=colour, alpha=0.75, label=text))
            continue
        look: dict[str, Any] = {"linewidth": 1.6 * layer.width if layer.value is None else 3.0}
        if layer.kind is LayerKind.MARKERS:
            text += f" ({layer.count})"
            look = {"marker": "D" if layer.shape is MarkerShape.DIAMOND else "o", "linestyle": ""}
            look |= {"markersize": 5.5, "markeredgecolor": sheet.colours["edge"]}
        elif layer.kind is LayerKind.ARROWS or layer.value is not None:
            text += f", up to {_amount(layer.largest, layer.unit)}"
        if layer.kind is LayerKind.ARROWS:  # in pairs, with a head at both ends of the line
            heads = [(0.2, -0.5), (1.0, 0.0), (0.2, 0.5), (0.2, 0.0)]
            heads += [] if layer.single else [(-x, y) for x, y in reversed(heads)]
            look = {"linewidth": 0.72 * layer.width, "marker": heads, "markersize": 13.0}
        handles.append(Line2D([], [], color=colour, label=text, **look))
    half = max(20, int(7.5 * figure.get_figwidth()) - 13)  # letters of a column of two
    for one in handles:
        one.set_label(textwrap.fill(one.get_label(), half))
    for columns in (4, 3, 2, 1):
        legend = figure.legend(
            handles=handles, loc="lower left", bbox_to_anchor=(0.012, 0.0), ncols=columns,
            frameon=False, fontsize=8, handlelength=1.6, columnspacing=1.6,
            labelcolor=sheet.colours["edge"],
        )  # fmt: skip
        gravity = figure.bbox.x1 - 0.8 * figure.dpi  # its arrow and its name
        box = legend.get_window_extent()
        if columns == 1 or box.x1 < gravity:
            break
        legend.remove()
    return legend


def _amount(value: float, unit: str) -> str:
    return f"{100.0 * value:.0f} %" if unit == "" else quantity(value, unit)


def draw_bar(figure: Figure, sheet: Sheet, layers: list[Layer]) -> None:
    """The legend of the colours of interfaces, in the upper right corner."""
    filled = [
        layer for layer in layers if layer.kind is LayerKind.POLYGONS and layer.value is not None
    ]
    for place, layer in enumerate(filled):
        bar = figure.add_axes((0.76, 0.945 - 0.1 * place, 0.21, 0.018))
        steps = np.linspace(0.0, 1.0, 33)
        colours = ramp_colours(steps[:-1] + 1.0 / 64.0, sheet.theme)
        wide = 1.5 / 32.0  # each reaches below the next one: no seams in an SVG
        bar.bar(steps[:-1], 1.0, width=wide, align="edge", color=colours, linewidth=0.0)
        bar.set_xlim(0.0, 1.0)
        bar.set_ylim(0.0, 1.0)
        top = sheet.scene.top(layer.key)
        more = "\N{GREATER-THAN OR EQUAL TO} " if layer.largest > 1.001 * top else ""
        told = [_amount(x * top, layer.unit) for x in (0.0, 1.0)]
        bar.set_xticks([0.0, 1.0], [told[0], more + told[1]], fontsize=8)
        bar.get_xticklabels()[-1].set_horizontalalignment("right")  # else it may leave the page
        bar.set_yticks([])
        ink = sheet.colours["edge"]
        bar.tick_params(length=2, colors=ink)
        for side in bar.spines.values():
            side.set(linewidth=0.5, color=ink)
        bar.set_title(layer.label, fontsize=8, color=ink, pad=3)


AXES = (0.02, 0.11, 0.96, 0.73)
"""Place of the drawing in the figure: left, bottom, width, height as shares."""


@checked_call
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
    ax: Axes | None = None,
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
        In a small figure what was asked, then the legend too, are left out.
    dpi : > 0, < inf
        Pixels per inch of a PNG.
    preset
        A picture by name: ``forces``, ``solid``, ``contacts``, ``utilisation`` or ``stages``; left
        out, the one that the page shows at first. ``solid`` has the headline alone.
    layers
        Keys of the layers to show instead, such as "interfaces", "joint-force", "network",
        "resultants".
    opacity : > 0, <= 1
        Of the blocks; left out, that of the preset, and 1 where layers were
        chosen.
    arrow_scale
        Makes arrows longer (above 1) or shorter.
    stage
        Of a scene with several; left out, of a limit the state that falls, of a plan the complete
        structure, else the first.
    names
        Write the names of the blocks on them. Numbers are written by the preset ``stages``.
    explode : >= 0, < inf
        How far the blocks are taken apart: 0 not at all, 1 each as far again as it is from the foot
        of the model.
    section
        Cut the model across an axis: ``x`` through its middle, or ``x=1.2`` at a coordinate [m].
        What lies between the plane and the eye is not drawn.
    dark
        Draw on a dark ground.
    ax
        Axes of matplotlib to draw in, with the headline as their title and without a legend. Their
        size counts, not ``size``.

    Returns
    -------
    matplotlib.figure.Figure
        It belongs to no window; ``figure.axes[0]`` takes what is to be added.

    Raises
    ------
    InputError
        A suffix, size, direction, preset, layer or stage that does not exist, a section beside the
        model, contacts of another model, or axes of another kind than a chart has.

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
    if not (width > 0.0 and height > 0.0):
        raise InputError("a side of size is not above zero", remedy="give inches, such as 9, 6.5")
    require_axes(ax)
    if isinstance(subject, Answer):
        shown = subject.figure()
        if isinstance(shown, Chart):
            return save_chart(shown, path, title=Path(subject.asked.file).stem, ax=ax)
        scene = replace(shown, made=with_version(subject.when))
    else:
        scene = scene_of(subject, contacts)
    if section is not None:
        scene = cut_at(scene, section)
    if explode:
        scene = taken_apart(scene, float(explode))

    drawing = partial(
        draw, scene, (float(width), float(height)), preset=preset, layers=layers, opacity=opacity,
        toward=None if toward is None else unit(toward, "view direction"),
        arrow_scale=number(arrow_scale, "arrow_scale"), stage=stage, names=names,
        theme="dark" if dark else "light", inside=ax,
    )  # fmt: skip
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
    inside: Any = None,
    scaled: bool = True,
) -> Figure:
    """The matplotlib figure of one stage, or of given axes; no state of pyplot is touched.

    ``scaled`` with a scale bar, which is true until the limits of the axes are changed.
    """
    from matplotlib.figure import Figure  # heavy, and only figures need it

    stage = scene.still if stage is None else stage
    _require(scene, stage, preset)
    shown = scene.stages[stage]
    key = preset if preset is not None else first_preset(scene, stage)
    chosen = _chosen(shown, layers, key)
    if opacity is None:
        opacity = PRESETS[key].opacity if layers is None else 1.0
    figure = Figure(figsize=size, facecolor=ROLE_COLOUR[theme]["background"])
    said = shown.headline or shown.message or shown.facts or scene.facts
    place = (
        AXES
        if said or any(x.value is not None and x.kind is LayerKind.POLYGONS for x in chosen)
        else (*AXES[:3], 0.87)
    )
    axes: Any = figure.add_axes(place) if inside is None else inside
    box = axes.get_window_extent()
    width, height = box.width / axes.figure.dpi, box.height / axes.figure.dpi
    axes.set_aspect("equal", adjustable="datalim")
    axes.axis("off")
    eye = scene.toward if toward is None else toward
    chosen = [as_seen(layer, eye) for layer in chosen]
    sheet = Sheet(axes, scene, shown, eye, width, height, opacity, theme)
    left = chosen if sheet.plane is None else seen_behind(chosen, sheet.plane, scene.block_size)
    draw_shadow(sheet)
    drawn = draw_blocks(sheet, [layer for layer in left if layer.kind is LayerKind.POLYGONS])
    draw_motion(sheet)
    for layer in left:
        draw_layer(sheet, layer, arrow_scale)
        write_beside(sheet, layer)
    draw_labels(sheet, drawn if opacity == 1.0 else None, numbers=PRESETS[key].numbers, names=names)
    axes.autoscale_view()
    axes.margins(0.03)
    if inside is not None:
        if scaled:
            draw_scale_bar(sheet)
        axes.set_title(shown.headline, fontsize=9, color=sheet.colours["edge"], parse_math=False)
        return axes.figure
    draw_gravity(figure, sheet)
    draw_bar(figure, sheet, chosen)
    texts = write_title(figure, sheet, plain=preset == "solid")
    make_room(figure, sheet, texts, write_legend(figure, sheet, chosen))
    draw_scale_bar(sheet, figure)
    return figure


def _require(scene: Scene, stage: int, preset: str | None) -> None:
    """Refuse a stage or a preset that does not exist."""
    if not -len(scene.stages) <= stage < len(scene.stages):
        raise InputError(f"there is no stage {stage}", remedy=f"{len(scene.stages)} exist")
    if preset is not None and preset not in PRESETS:
        raise InputError(f"there is no preset '{preset}'", remedy=f"there are {', '.join(PRESETS)}")


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
