"""A static figure: PNG, SVG or PDF through matplotlib, which is imported only here, when asked."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Collection
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.contacts import Contacts
from drystone.errors import FormatError, InputError
from drystone.geometry.arrays import Floats, frozen_floats
from drystone.geometry.frames import unit
from drystone.io.files import write_whole
from drystone.results import Verdict
from drystone.view.depth import ordered_patches
from drystone.view.mesh import face_normals, sharp_edges
from drystone.view.palette import ROLE_COLOUR, STATE_COLOUR, STATE_LABEL, State, rgb
from drystone.view.scene import Layer, LayerKind, Scene, Stage, Subject, scene_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SUFFIXES = ("png", "svg", "pdf")
VERDICT_COLOUR = {Verdict.STABLE: "#00664b", Verdict.UNSTABLE: "#a33c00"}
COLOURS = ROLE_COLOUR["light"]


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
    paper = paper_axes(toward)
    figure = Figure(figsize=size, facecolor="white")
    axes = figure.add_axes((0.02, 0.11, 0.96, 0.75))
    axes.set_aspect("equal", adjustable="datalim")
    axes.axis("off")
    _draw_blocks(axes, scene, shown, toward, paper)
    _draw_motion(axes, scene, shown, paper)
    scale = scene.force_scale * arrow_scale
    for layer in chosen:
        _draw_layer(axes, scene, layer, paper, scale)
    axes.autoscale_view()
    axes.margins(0.03)
    _draw_scale_bar(axes, size)
    _write_title(figure, shown, size)
    _write_legend(figure, shown, chosen)
    return figure


def paper_axes(toward: Floats) -> Floats:
    """(2, 3), right and up on the paper; up is up unless one looks straight down or up."""
    helper = np.array([0.0, 0.0, 1.0]) if abs(toward[2]) < 0.999 else np.array([0.0, 1.0, 0.0])
    right = np.cross(helper, toward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(toward, right)])


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


def _draw_blocks(axes: Axes, scene: Scene, stage: Stage, toward: Floats, paper: Floats) -> None:
    from matplotlib.collections import PathCollection
    from matplotlib.path import Path as Line

    present = np.flatnonzero(stage.state != State.ABSENT)
    if len(present) == 0:
        return
    assembly = scene.assembly.subset(present)
    contacts = scene.contacts.of_blocks(present, len(scene.assembly))
    patches = ordered_patches(assembly, contacts, toward, paper)
    faces = assembly.faces
    flat = (faces.point[faces.loop] - scene.centre) @ paper.T
    normal = face_normals(faces)[patches.face]
    light = 0.72 * toward + 0.42 * paper[1] - 0.55 * paper[0]
    shade = 0.58 + 0.36 * np.maximum(normal @ light, 0.0) + 0.08 * normal[:, 2]
    palette = np.zeros((len(State), 3))
    for state, colour in STATE_COLOUR["light"].items():
        palette[state] = rgb(colour)
    base = palette[stage.state[present][faces.owner[patches.face]]]
    fills = np.clip(base * shade[:, None], 0.0, 1.0)
    edge = np.where((base @ [0.3, 0.6, 0.1] < 0.2)[:, None], 0.62, rgb(COLOURS["edge"]))
    paths: list[Line] = []
    look: list[tuple[Any, Any, float]] = []
    for i in range(len(patches.face)):
        part = slice(patches.start[i], patches.start[i + 1])
        corner = flat[patches.corner[part]]
        outlined = patches.outlined[part]
        closed = np.vstack([corner, corner[:1]])
        paths.append(Line(closed, closed=True))
        whole = outlined.all()
        look.append((fills[i], edge[i] if whole else fills[i], 0.5 if whole else 0.25))
        if not whole and outlined.any():
            sides = np.stack([corner, closed[1:]], axis=1)[outlined].reshape(-1, 2)
            codes = np.tile([Line.MOVETO, Line.LINETO], len(sides) // 2)
            paths.append(Line(sides, codes))
            look.append(("none", edge[i], 0.5))
    fill, line, width = zip(*look, strict=True)
    axes.add_collection(
        PathCollection(
            paths, facecolors=fill, edgecolors=line, linewidths=width, joinstyle="round",
        )
    )  # fmt: skip


def _draw_motion(axes: Axes, scene: Scene, stage: Stage, paper: Floats) -> None:
    """Outlines of falling blocks where the motion takes them, and an arrow for each."""
    from matplotlib.collections import LineCollection

    moving = np.flatnonzero(stage.state == State.FALLING)
    if stage.motion is None or len(moving) == 0:
        return
    assembly = scene.assembly.subset(moving)
    motion = stage.motion[moving]
    faces = assembly.faces
    edge, owner, _ = sharp_edges(faces, face_normals(faces))
    turn = Rotation.from_rotvec(np.repeat(motion[owner, 3:], 2, axis=0))
    centroid = np.repeat(assembly.centroid[owner], 2, axis=0)
    arm = turn.apply(faces.point[edge.ravel()] - centroid)
    moved = centroid + np.repeat(motion[owner, :3], 2, axis=0) + arm
    lines = ((moved - scene.centre) @ paper.T).reshape(-1, 2, 2)
    colour = STATE_COLOUR["light"][State.FALLING]
    axes.add_collection(LineCollection(list(lines), colors=colour, linewidths=0.6, linestyles="--"))
    tail = (assembly.centroid - scene.centre) @ paper.T
    _arrows(axes, tail, motion[:, :3] @ paper.T, "black", 1.0)


def _draw_layer(axes: Axes, scene: Scene, layer: Layer, paper: Floats, scale: float) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    colour = COLOURS[layer.colour]
    at = (layer.position - scene.centre) @ paper.T
    if layer.start is not None:
        loops = np.split(at, layer.start[1:-1])
        axes.add_collection(
            PolyCollection(loops, facecolors=colour, edgecolors=colour, alpha=0.55, linewidths=0.6)
        )
        return
    if layer.vector is None:
        return
    vector = layer.vector @ paper.T
    if layer.kind is LayerKind.LINES:
        lines = np.stack([at, at + vector], axis=1)
        axes.add_collection(LineCollection(list(lines), colors=colour, linewidths=layer.width))
        return
    for half in (0.5 * scale * vector, -0.5 * scale * vector):
        if layer.inward:
            _arrows(axes, at + half, -half, colour, layer.width)
        else:
            _arrows(axes, at, half, colour, layer.width)


def _arrows(axes: Axes, at: Floats, vector: Floats, colour: str, width: float) -> None:
    long = np.linalg.norm(vector, axis=1) > 0.0
    if not long.any():
        return
    at, vector = at[long], vector[long]
    axes.quiver(
        at[:, 0], at[:, 1], vector[:, 0], vector[:, 1],
        angles="xy", scale_units="xy", scale=1.0, units="inches", width=0.011 * width,
        headwidth=5.0, headlength=6.0, headaxislength=6.0, minlength=0.0,
        color=colour, zorder=3.0,
    )  # fmt: skip
    axes.update_datalim(at + vector)


def _draw_scale_bar(axes: Axes, size: tuple[float, float]) -> None:
    """A bar of a round length, about a sixth of the drawing wide."""
    width, height = 0.96 * size[0], 0.75 * size[1]
    low, high = axes.dataLim.min, axes.dataLim.max
    span = max((high[0] - low[0]) * 1.06, (high[1] - low[1]) * 1.06 * width / height)
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


def _write_legend(figure: Figure, stage: Stage, layers: list[Layer]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Patch(facecolor=STATE_COLOUR["light"][state], edgecolor="#555555", label=label)
        for state, label in STATE_LABEL.items()
        if (stage.state == state).any()
    ]
    if stage.motion is not None and (stage.state == State.FALLING).any():
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
