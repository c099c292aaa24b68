"""What stands around the drawing of a figure: title, legend, scale bar, gravity, colour bar."""

from __future__ import annotations

import textwrap
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.answer.question import asked_line
from drystone.answer.scene import Layer, LayerKind, MarkerShape, State
from drystone.base.units import quantity
from drystone.results import Verdict
from drystone.view.ink import ADDED_OPACITY
from drystone.view.palette import ROLE_COLOUR, STATE_COLOUR, STATE_LABEL, ramp_colours
from drystone.view.sheet import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend
    from matplotlib.text import Text

_VERDICT_COLOUR = {
    "light": {Verdict.STABLE: "#00664b", Verdict.UNSTABLE: "#a33c00", None: "#6a5200"},
    "dark": {Verdict.STABLE: "#4fd1ab", Verdict.UNSTABLE: "#ff9a5c", None: "#f0d24a"},
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
    scene, stage, known = sheet.scene, sheet.stage, _VERDICT_COLOUR[sheet.theme]
    ink = ROLE_COLOUR[sheet.theme]["edge"]
    colour = known.get(stage.verdict, known[None]) if stage.verdict else ink
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
        told = [_amount(x * top, layer.unit) for x in (0.0, 1.0)]
        bar.set_xticks([0.0, 1.0], [told[0], more + told[1]], fontsize=8)
        bar.get_xticklabels()[-1].set_horizontalalignment("right")  # else it may leave the page
        bar.set_yticks([])
        ink = sheet.colours["edge"]
        bar.tick_params(length=2, colors=ink)
        for side in bar.spines.values():
            side.set(linewidth=0.5, color=ink)
        bar.set_title(layer.label, fontsize=8, color=ink, pad=3)
