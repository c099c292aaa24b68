"""A film: the stages of an answer one after the other, as an animated GIF by Pillow."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.answer import Answer, Scene
from drystone.base.errors import FormatError, InputError
from drystone.base.files import PathLike, write_bytes
from drystone.base.settings import checked_call
from drystone.view.figure import draw
from drystone.view.palette import ROLE_COLOUR
from drystone.view.plots import draw_chart

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure


@checked_call
def save_film(subject: Answer | Scene, path: PathLike) -> None:
    """Write the stages of an answer as an animated GIF of ten seconds: a train that moves, a plan.

    Where the first chart of the answer has a place for each stage, it stands below the drawing.

    Parameters
    ----------
    subject
    path
        Ends in .gif. Written to a temporary name beside it and renamed.

    Raises
    ------
    FormatError
        Another suffix.
    InputError
        There is one stage only.
    """
    if not str(path).lower().endswith(".gif"):
        raise FormatError("this is no name of a film", where=str(path), remedy="end it in .gif")
    scene = subject.layers() if isinstance(subject, Answer) else subject
    stages = [i for i, one in enumerate(scene.stages) if one.spot] or [*range(len(scene.stages))]
    if len(stages) < 2:
        raise InputError("one stage is no film", where="film", remedy="write a figure, --png")
    figures = [_frame(scene, i) for i in stages]
    boxes = np.array([one.axes[0].dataLim.get_points() for one in figures])
    low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    (left, down), (right, up) = low - 0.03 * (high - low), high + 0.03 * (high - low)
    for one in figures:
        one.axes[0].set(adjustable="box", xlim=(left, right), ylim=(down, up))
    write_gif(figures, path, [8000 // len(figures)] * (len(figures) - 1) + [2000])


def write_gif(figures: Sequence[Figure], path: PathLike, milliseconds: Sequence[int]) -> None:
    """Write figures as an endless GIF, each for its own time."""
    from PIL import Image  # which matplotlib brings

    images, made = [], BytesIO()
    for figure in figures:
        file = BytesIO()
        figure.savefig(file, format="png", dpi=100)
        images.append(Image.open(file).convert("P", palette=Image.Palette.ADAPTIVE, colors=32))
    images[0].save(
        made, "GIF", save_all=True, append_images=images[1:], duration=list(milliseconds), loop=0,
        optimize=True,
    )  # fmt: skip
    write_bytes(path, made.getvalue())


def _frame(scene: Scene, stage: int) -> Figure:
    """A stage, and where it is in the first chart."""
    from matplotlib.figure import Figure  # heavy, and only figures need it

    figure = Figure(figsize=(8.0, 6.4), facecolor=ROLE_COLOUR["light"]["background"])
    spot = scene.stages[stage].spot
    above: Any = figure.add_axes((0.02, 0.42, 0.96, 0.5) if spot else (0.02, 0.04, 0.96, 0.86))
    draw(scene, (8.0, 6.4), stage=stage, inside=above, scaled=False)
    figure.suptitle(scene.title, fontsize=10, parse_math=False)
    if spot:
        below: Any = figure.add_axes((0.1, 0.1, 0.86, 0.26))
        draw_chart(below, scene.charts[0])
        below.plot(*spot, "o", color=ROLE_COLOUR["light"]["edge"], markersize=9)
        below.legend(loc="best", frameon=False, fontsize=8)
    return figure
