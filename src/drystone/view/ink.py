"""Blocks, motions and layers as matplotlib draws them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.arrays import Floats
from drystone.view.depth import ordered_patches
from drystone.view.mesh import face_normals, sharp_edges
from drystone.view.palette import ROLE_COLOUR, STATE_COLOUR, State, rgb
from drystone.view.scene import Layer, LayerKind, Scene, Stage

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ROLE_COLOUR["light"]
FINE_BLOCK = 0.5
"""[inches], drawn blocks smaller than this get thinner lines and arrows; chosen by eye."""
MANY_FALLING = 200
"""Of more falling blocks the motion is not drawn: it would hide the model; chosen by eye."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """Where one stage is drawn.

    Attributes
    ----------
    axes
    scene, stage
    toward : (3,) unit, from the model to the eye
    width : [inches], of the axes
    height : [inches], of the axes
    """

    axes: Axes
    scene: Scene
    stage: Stage
    toward: Floats
    width: float
    height: float

    @cached_property
    def paper(self) -> Floats:
        """(2, 3), right and up on the paper; up is up unless one looks straight down or up."""
        straight = abs(self.toward[2]) > 0.999
        helper = np.array([0.0, 1.0, 0.0]) if straight else np.array([0.0, 0.0, 1.0])
        right = np.cross(helper, self.toward)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(self.toward, right)])

    def project(self, points: Floats) -> Floats:
        """Points (p, 3) on the paper (p, 2) [m], about the middle of the model."""
        flat: Floats = (points - self.scene.centre) @ self.paper.T
        return flat

    @cached_property
    def thin(self) -> float:
        """Factor on the width of lines, below 1 where blocks are drawn small."""
        span = np.ptp(self.project(self.scene.assembly.bounds.reshape(-1, 3)), axis=0)
        scale = min(self.width / max(span[0], 1e-300), self.height / max(span[1], 1e-300))
        return float(np.clip(self.scene.block_size * scale / FINE_BLOCK, 0.15, 1.0))

    @property
    def shows_motion(self) -> bool:
        """Whether the motion of falling blocks is drawn."""
        falling = int((self.stage.state == State.FALLING).sum())
        return self.stage.motion is not None and 0 < falling <= MANY_FALLING


def draw_blocks(sheet: Sheet) -> None:
    """The blocks of the stage, hidden ones under those in front."""
    from matplotlib.collections import PathCollection
    from matplotlib.path import Path as Line

    scene, stage, toward, paper = sheet.scene, sheet.stage, sheet.toward, sheet.paper
    present = np.flatnonzero(stage.state != State.ABSENT)
    if len(present) == 0:
        return
    assembly = scene.assembly.subset(present)
    contacts = scene.contacts.of_blocks(present, len(scene.assembly))
    patches = ordered_patches(assembly, contacts, toward, paper)
    faces = assembly.faces
    flat = sheet.project(faces.point[faces.loop])
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
        look.append(
            (fills[i], edge[i] if whole else fills[i], (0.5 if whole else 0.25) * sheet.thin)
        )
        if not whole and outlined.any():
            sides = np.stack([corner, closed[1:]], axis=1)[outlined].reshape(-1, 2)
            codes = np.tile([Line.MOVETO, Line.LINETO], len(sides) // 2)
            paths.append(Line(sides, codes))
            look.append(("none", edge[i], 0.5 * sheet.thin))
    fill, line, width = zip(*look, strict=True)
    sheet.axes.add_collection(
        PathCollection(
            paths, facecolors=fill, edgecolors=line, linewidths=width, joinstyle="round",
        )
    )  # fmt: skip


def draw_motion(sheet: Sheet) -> None:
    """Outlines of falling blocks where the motion takes them, and an arrow for each."""
    from matplotlib.collections import LineCollection

    stage = sheet.stage
    if stage.motion is None or not sheet.shows_motion:
        return
    moving = np.flatnonzero(stage.state == State.FALLING)
    assembly = sheet.scene.assembly.subset(moving)
    motion = stage.motion[moving]
    faces = assembly.faces
    edge, owner, _ = sharp_edges(faces, face_normals(faces))
    turn = Rotation.from_rotvec(np.repeat(motion[owner, 3:], 2, axis=0))
    centroid = np.repeat(assembly.centroid[owner], 2, axis=0)
    arm = turn.apply(faces.point[edge.ravel()] - centroid)
    moved = centroid + np.repeat(motion[owner, :3], 2, axis=0) + arm
    lines = sheet.project(moved).reshape(-1, 2, 2)
    colour = STATE_COLOUR["light"][State.FALLING]
    sheet.axes.add_collection(
        LineCollection(list(lines), colors=colour, linewidths=0.6, linestyles="--")
    )
    tail = sheet.project(assembly.centroid)
    _arrows(sheet, tail, motion[:, :3] @ sheet.paper.T, "black", 1.0)


def draw_layer(sheet: Sheet, layer: Layer, scale: float) -> None:
    """One layer over the blocks; arrows are ``scale`` [m/N] long."""
    from matplotlib.collections import LineCollection, PolyCollection

    colour = COLOURS[layer.colour]
    at = sheet.project(layer.position)
    if layer.start is not None:
        loops = np.split(at, layer.start[1:-1])
        sheet.axes.add_collection(
            PolyCollection(loops, facecolors=colour, edgecolors=colour, alpha=0.55, linewidths=0.6)
        )
        return
    if layer.vector is None:
        return
    vector = layer.vector @ sheet.paper.T
    if layer.kind is LayerKind.LINES:
        lines = np.stack([at, at + vector], axis=1)
        sheet.axes.add_collection(
            LineCollection(list(lines), colors=colour, linewidths=layer.width)
        )
        return
    for half in (0.5 * scale * vector, -0.5 * scale * vector):
        if layer.inward:
            _arrows(sheet, at + half, -half, colour, layer.width)
        else:
            _arrows(sheet, at, half, colour, layer.width)


def _arrows(sheet: Sheet, at: Floats, vector: Floats, colour: str, width: float) -> None:
    long = np.linalg.norm(vector, axis=1) > 0.0
    if not long.any():
        return
    at, vector = at[long], vector[long]
    sheet.axes.quiver(
        at[:, 0], at[:, 1], vector[:, 0], vector[:, 1],
        angles="xy", scale_units="xy", scale=1.0, units="inches", width=0.010 * width * sheet.thin,
        headwidth=4.5, headlength=6.0, headaxislength=5.5, minlength=0.0,
        color=colour, zorder=3.0,
    )  # fmt: skip
    sheet.axes.update_datalim(at + vector)
