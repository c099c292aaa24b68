"""A static figure: PNG, SVG or PDF by matplotlib, which is imported only when needed."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drystone.answer import Answer
from drystone.answer.chart import Chart
from drystone.answer.scene import (
    Layer,
    LayerKind,
    Scene,
    SceneStage,
    with_version,
)
from drystone.base.arrays import Floats, frozen_floats, number
from drystone.base.errors import InputError, quoted
from drystone.base.settings import checked_call
from drystone.contacts import Contacts
from drystone.geometry.frames import unit
from drystone.view.around import (
    draw_bar,
    draw_gravity,
    draw_scale_bar,
    make_room,
    write_legend,
    write_title,
)
from drystone.view.exploded import taken_apart
from drystone.view.ink import as_seen, draw_blocks, draw_layer, draw_motion
from drystone.view.palette import (
    PRESETS,
    ROLE_COLOUR,
    first_preset,
    is_shown,
)
from drystone.view.plots import save_chart, save_plot
from drystone.view.section import cut_at, seen_behind
from drystone.view.sheet import Sheet, draw_labels, draw_shadow, write_beside
from drystone.view.subjects import Subject, scene_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
        model, contacts of another model, or axes for a chart.

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
    if not (ax is None or hasattr(ax, "get_window_extent")):
        raise InputError(f"ax is {quoted(ax)}", remedy="give axes of matplotlib")
    if isinstance(subject, Answer):
        shown = subject.figure()
        if isinstance(shown, Chart):
            if ax is not None:
                what = f"'{subject.title}' is drawn as a chart, which makes axes of its own"
                raise InputError(what, where="ax", remedy="leave it out")
            return save_chart(shown, path, title=Path(subject.asked.file).stem)
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
