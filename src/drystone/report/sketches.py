"""Drawings of a report: dimensions, pictures of answers, and the sketch of signs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from io import BytesIO
from typing import Any

import numpy as np

from drystone.answer import Answer, Scene, SceneStage
from drystone.answer.chart import Chart
from drystone.answer.drawing import bare_scene
from drystone.answer.scene import Layer
from drystone.base.arrays import Floats, lengths
from drystone.base.display import shortened
from drystone.base.errors import InputError
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.geometry.frames import unit
from drystone.geometry.kern import kern
from drystone.limits import Limit
from drystone.limits.train_answer import TrainEnvelope
from drystone.model import Model
from drystone.report.document import Picture
from drystone.results import Result
from drystone.sequence import Plan
from drystone.view.figure import draw
from drystone.view.plots import save_chart
from drystone.virtual import local_corners

_WIDTH = 6.7
"""[inches], of a picture across a page of A4."""
_DPI = 150


def answer_pictures(answer: Answer) -> Iterator[Picture]:
    """What an answer draws on paper: its chart, and the model; both sides of a limit."""
    try:
        shown, scene = answer.figure(), answer.layers()
    except InputError:
        return
    limit = answer.limit if isinstance(answer, TrainEnvelope) else answer
    if isinstance(shown, Chart):
        yield _picture(save_chart(shown), shown.title)
    else:
        scene = shown
        for one in () if isinstance(limit, Limit) else scene.charts:
            yield _picture(save_chart(one), one.title)
    sides = range(len(limit.states)) if isinstance(limit, Limit) else [scene.still]
    for i in sides:
        told = scene.stages[i].label if isinstance(limit, Limit) else scene.stages[i].headline
        yield _picture(_drawn(scene, i), f"{told[:1].upper()}{told[1:]}")


def numbered_picture(plan: Plan) -> Picture:
    """The complete structure with the number of its step at every planned block."""
    return _picture(_drawn(plan.layers(), -1), "Blocks, by the step that places them")


def loads_picture(model: Model) -> Picture:
    """The model with its loads as arrows."""
    scene = bare_scene(model)
    (stage,) = scene.stages
    loads = tuple(one for one in stage.layers if one.key != "interfaces")
    scene = replace(scene, stages=(replace(stage, message="", layers=loads),))
    return _picture(_drawn(scene), f"Loads: {model.load.name}")


def dimensions_picture(model: Model) -> Picture:
    """An elevation and a side view at one scale, with the overall dimensions of the free blocks."""
    from matplotlib.figure import Figure  # slow to import

    scene = bare_scene(model)
    drawn = [one for one in scene.stages[0].layers if one.key in ("surface", "tie-forces")]
    span, middle = scene.bounds[1] - scene.bounds[0], scene.bounds.mean(axis=0)
    assembly = model.assembly
    told = assembly.bounds[~assembly.fixed] if len(assembly.free) else assembly.bounds
    ends = np.array([told[:, 0].min(axis=0), told[:, 1].max(axis=0)]) - middle
    front, side = (0, 1) if span[0] >= span[1] else (1, 0)
    figure = Figure(figsize=(_WIDTH, 3.1), facecolor="white")
    away = 0.08 * float(span.max())
    half = np.max([0.5 * span, *(np.abs(x.position - middle).max(axis=0) for x in drawn)], axis=0)
    shares = [half[front] + 2.0 * away, half[side] + 2.0 * away]
    grid = figure.add_gridspec(
        1, 2, width_ratios=shares, left=0.06, right=0.97, bottom=0.08, top=0.9
    )
    for number, along in enumerate((front, side)):
        axes: Any = figure.add_subplot(grid[0, number])
        toward = _toward(along)
        keys = [x.key for x in drawn if x.key == "tie-forces" or not _end_on(x, toward)]
        draw(scene, (_WIDTH, 3.1), toward=toward, layers=keys, inside=axes, scaled=False)
        axes.set_title("elevation" if number == 0 else "side view", fontsize=8)
        flat = [along, 2]
        _dimensions(axes, ends[:, flat], half[flat], away)
        _axes_of(axes, -half[flat] - 2.6 * away, 1.2 * away, "xyz"[along])
    words = ["Overall dimensions of the free blocks", *(one.label for one in drawn)]
    return _picture(figure, ", and ".join(words))


def joint_plans(result: Result, table: Table, joints: list[int]) -> Iterator[Picture]:
    """Joints seen against their normals, four beside each other; ``table`` has all joints."""
    from matplotlib.figure import Figure  # as above

    contacts = result.contacts.joints
    origin, flat = local_corners(contacts)
    for first in range(0, len(joints), 4):
        figure = Figure(figsize=(_WIDTH, 1.9), facecolor="white", layout="constrained")
        every: Any = figure.subplots(1, 4)
        told = []
        for axes in every:
            axes.axis("off")
        for axes, i in zip(every, joints[first:][:4], strict=False):
            corners = flat[contacts.start[i] : contacts.start[i + 1]]
            frame = contacts.frame[i, 1:]
            axes.fill(*corners.T, facecolor="#e4e4e4", edgecolor="black", linewidth=0.7)
            axes.fill(*kern(corners).T, facecolor="none", edgecolor="black", linestyle="--")
            axes.plot(*(frame @ (np.array([table[x][i] for x in "xyz"]) - origin[i])), "ko")
            axes.set_aspect("equal")
            axes.set_title(f"joint {i}", fontsize=8)
            between = " – ".join(shortened(str(table[x][i]), 24) for x in ("block_a", "block_b"))
            wide = float(np.ptp(corners, axis=0).max())
            right, up = map(_direction, frame)
            told.append(f"joint {i}: {between}, {wide:.3g} m wide, right: {right}, up: {up}")
        yield _picture(figure, "; ".join(told))


def _direction(along: Floats) -> str:
    """A direction (3,) as an axis of the model with its sign, or its parts."""
    axis = int(np.abs(along).argmax())
    if abs(along[axis]) > 0.995:
        return f"{'-' if along[axis] < 0.0 else '+'}{'xyz'[axis]}"
    return "(" + ", ".join(f"{part + 0.0:.2g}" for part in along.round(2)) + ")"


@cache
def signs_picture() -> Picture:
    """Axes, and the forces in a joint, with the senses in which they are positive."""
    from matplotlib.figure import Figure  # as above
    from matplotlib.patches import Polygon

    figure = Figure(figsize=(_WIDTH, 2.2), facecolor="white")
    axes: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, 6.7), ylim=(0.0, 2.2))
    axes.axis("off")
    for end, name in (((1.35, 0.5), "x"), ((0.95, 0.85), "y"), ((0.5, 1.35), "z, up")):
        _arrow(axes, (0.5, 0.5), end)
        axes.text(end[0] + 0.06, end[1], name, fontsize=9, va="center")
    axes.text(0.15, 0.12, "moments: right-hand rule", fontsize=8)
    for low, name in ((0.15, "block a"), (1.0, "block b")):
        corners = [(2.4, low), (4.0, low), (4.0, low + 0.85), (2.4, low + 0.85)]
        axes.add_patch(Polygon(corners, facecolor="#e4e4e4", edgecolor="black"))
        axes.text(2.5, low + 0.08, name, fontsize=8)
    _arrow(axes, (3.2, 1.0), (3.2, 1.7))
    axes.text(3.26, 1.6, "n, a to b", fontsize=8)
    _arrow(axes, (3.2, 1.0), (3.9, 1.0))
    axes.text(3.55, 0.8, "u", fontsize=8)
    axes.text(2.5, 1.93, "joint: n, u, and v away from you", fontsize=8)
    told = (
        "normal force N > 0: compression",
        "forces act on block b;",
        "block a gets the opposite",
        "reactions act on the structure",
        "loads act on the block named",
    )
    for row, text in enumerate(told):
        axes.text(4.45, 1.85 - 0.36 * row, text, fontsize=8.5, va="center")
    return _picture(figure, "Axes, and the signs of the forces in a joint")


def _drawn(scene: Scene, stage: int = 0) -> Any:
    """A stage without its words, which stand below and beside it on the page."""
    bare = tuple(replace(one, headline="", message="", facts={}) for one in scene.stages)
    shown = replace(scene, stages=bare, facts={}, made="")
    return draw(shown, (_WIDTH, 4.5), stage=stage, toward=_eye(scene, scene.stages[stage]))


def _eye(scene: Scene, stage: SceneStage) -> Floats | None:
    """From the model to the eye; aslant where forces or motions are seen end on."""
    known = [one.vector for one in stage.layers if one.group in ("loads", "acceleration")]
    if stage.motion is not None:
        known.append(stage.motion[:, :3])
    across = stage.gravity - (stage.gravity @ stage.up) * stage.up
    known.append(across[None].round(3))
    hidden = any(
        float(np.abs(one @ scene.toward).sum()) > 0.5 * float(lengths(one).sum())
        for one in known
        if one is not None
    )
    if not hidden:
        return None
    side = np.cross(stage.up, scene.toward)
    beside = [np.abs(one @ side).max(initial=0.0) for one in known if one is not None]
    if scene.plane is not None and max(beside) <= 1e-6 * max(
        float(lengths(one).max(initial=0.0)) for one in known if one is not None
    ):
        return _toward(scene.plane)
    return unit(scene.toward + 0.8 * side + 0.4 * stage.up, "view direction")


def _end_on(layer: Layer, toward: Floats) -> bool:
    """Whether some vector of a layer is seen end on."""
    vector = np.zeros((1, 3)) if layer.vector is None else layer.vector
    return bool((np.abs(vector @ toward) > 0.5 * lengths(vector).max()).any())


def _toward(along: int) -> Floats:
    """From the model to the eye, in the view in which an axis points right."""
    return np.array([0.0, -1.0, 0.0]) if along == 0 else np.array([1.0, 0.0, 0.0])


def _dimensions(axes: Any, ends: Floats, half: Floats, away: float) -> None:
    """Lines of dimension below and left of a view, about its middle.

    ``ends`` (2, 2) are the least and the largest place of what is measured, ``half`` (2,) half of
    the size of what is drawn.
    """
    (low, under), (high, over) = ends.tolist()
    x, y = half.tolist()
    across, up = quantity(high - low, "m"), quantity(over - under, "m")
    for start, end, text, at, turned in (
        ((low, -y - away), (high, -y - away), across, (0.5 * (low + high), -y - 1.35 * away), 0),
        ((-x - away, under), (-x - away, over), up, (-x - 1.35 * away, 0.5 * (under + over)), 90),
    ):
        axes.annotate(
            "", xy=end, xytext=start, annotation_clip=False,
            arrowprops={"arrowstyle": "<->", "lw": 0.8, "shrinkA": 0.0, "shrinkB": 0.0},
        )  # fmt: skip
        axes.text(
            *at, text, fontsize=8, rotation=turned,
            ha="center" if turned == 0 else "right", va="top" if turned == 0 else "center",
        )  # fmt: skip
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(-x - 3.0 * away, x + away)
    axes.set_ylim(-y - 3.0 * away, y + away)


def _axes_of(axes: Any, corner: Floats, size: float, across: str) -> None:
    """The directions of a view in its lower left corner."""
    for end, name in (((size, 0.0), across), ((0.0, size), "z")):
        tip = corner + end
        _arrow(axes, tuple(corner), tuple(tip))
        axes.text(*(tip + 0.2 * size), name, fontsize=8)


def _arrow(axes: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.annotate(
        "", xy=end, xytext=start,
        arrowprops={"arrowstyle": "-|>", "lw": 1.3, "color": "k", "shrinkA": 0.0, "shrinkB": 0.0},
    )  # fmt: skip


def _picture(figure: Any, caption: str) -> Picture:
    width, height = figure.get_size_inches()
    figure.set_size_inches(_WIDTH, _WIDTH * height / width)
    made = BytesIO()
    figure.savefig(made, format="png", dpi=_DPI, metadata={"Software": None})
    pixels = int(_WIDTH * _DPI), int(_WIDTH * height / width * _DPI)
    return Picture(made.getvalue(), pixels, caption)
