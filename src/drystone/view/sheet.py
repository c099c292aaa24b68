"""The sheet on which a stage is drawn: its directions and scale, the shadow, numbers and names."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from drystone.answer.question import UP
from drystone.answer.scene import Layer, Scene, SceneStage, State
from drystone.assembly import Block
from drystone.base.arrays import Floats
from drystone.geometry.frames import rotation_about
from drystone.geometry.polyhedron import fan_triangles, stack_faces
from drystone.view.palette import ROLE_COLOUR, STATE_COLOUR, rgb
from drystone.view.section import Plane, plane_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ALIKE = 0.9
"""Cosine of the angle up to which faces are one side of a block to a reader."""
_SIZE = 7.0
"""[points], letters of a label."""
LETTER, LINE = 0.6 * _SIZE / 72.0, 1.7 * _SIZE / 72.0
"""[inches], about the width of a letter and the height of a label."""
_FINE_BLOCK = 0.5
"""[inches], drawn blocks smaller than this get thinner lines and arrows; chosen by eye."""

_MANY_FALLING = 200
"""With more falling blocks the motion is not drawn: it would hide the model. Chosen by eye."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """The drawing of one stage.

    Attributes
    ----------
    axes
    scene, stage
    toward : (3,) unit, from the model to the eye, where up is up
    width : [inches], of the axes
    height : [inches], of the axes
    opacity
        Of the blocks.
    theme
        ``light`` or ``dark``.
    """

    axes: Axes
    scene: Scene
    stage: SceneStage
    toward: Floats
    width: float
    height: float
    opacity: float = 1.0
    theme: str = "light"

    @cached_property
    def colours(self) -> dict[str, str]:
        """By role."""
        return ROLE_COLOUR[self.theme]

    @cached_property
    def states(self) -> Floats:
        """(s, 3) components of the colour of each state."""
        palette = np.zeros((len(State), 3))
        for state, colour in STATE_COLOUR[self.theme].items():
            palette[state] = rgb(colour)
        return palette

    @cached_property
    def paper(self) -> Floats:
        """(2, 3), right and up on the paper; up is up unless one looks straight down or up."""
        straight = abs(self.toward[2]) > 0.999
        helper = np.array([0.0, 1.0, 0.0]) if straight else np.array([0.0, 0.0, 1.0])
        right = np.cross(helper, self.toward)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(self.toward, right)]) @ self._tilt

    @cached_property
    def eye(self) -> Floats:
        """(3,) unit, from the model to the eye, in the axes of the model."""
        return self.toward @ self._tilt

    @cached_property
    def plane(self) -> Plane | None:
        """Of the section, if there is one."""
        return plane_of(self.scene, self.eye)

    @cached_property
    def _tilt(self) -> Floats:
        """(3, 3), turns the direction that is up in the picture to z."""
        axis = np.cross(self.stage.up, UP)
        size = float(np.linalg.norm(axis))
        if size < 1e-12:
            return np.diag([1.0, 1.0, 1.0] if self.stage.up[2] > 0.0 else [1.0, -1.0, -1.0])
        angle = np.rad2deg(np.arctan2(size, float(self.stage.up @ UP)))
        return rotation_about(axis, float(angle))

    def project(self, points: Floats) -> Floats:
        """Points (p, 3) on the paper (p, 2) [m], about the middle of the model."""
        return (points - self.scene.centre) @ self.paper.T

    @cached_property
    def scale(self) -> float:
        """[inches/m], about, of the drawing."""
        span = np.ptp(self.project(self.scene.assembly.bounds.reshape(-1, 3)), axis=0)
        return float(min(self.width / max(span[0], 1e-300), self.height / max(span[1], 1e-300)))

    @cached_property
    def thin(self) -> float:
        """Factor on the width of lines, below 1 where blocks are drawn small."""
        return float(np.clip(self.scene.block_size * self.scale / _FINE_BLOCK, 0.15, 1.0))

    @property
    def shows_motion(self) -> bool:
        """Whether the motion of falling blocks is drawn."""
        falling = int((self.stage.state == State.FALLING).sum())
        return self.stage.motion is not None and 0 < falling <= _MANY_FALLING


def draw_shadow(sheet: Sheet) -> None:
    """A shadow on the ground, in rings that fade outwards."""
    from matplotlib.collections import PathCollection
    from matplotlib.path import Path as Line

    bounds = sheet.scene.assembly.bounds
    if sheet.eye[2] <= 0.0:
        return  # seen from below the ground
    faces = sheet.scene.assembly.faces
    owner = np.repeat(faces.owner, np.diff(faces.start))
    seen = shapely.multipoints(faces.point[faces.loop][:, :2], indices=owner)
    cover = shapely.union_all(shapely.convex_hull(seen))
    if sheet.plane is not None and sheet.plane.normal[2] == 0.0:
        low, high = bounds[:, 0, :2].min(axis=0), bounds[:, 1, :2].max(axis=0)
        side, offset = sheet.plane.normal[:2], sheet.plane.offset
        high = np.where(side > 0.0, offset, high)
        low = np.where(side < 0.0, -offset, low)
        cover = shapely.intersection(cover, shapely.box(*low, *high))
    size = float(np.ptp(bounds[..., :2].reshape(-1, 2), axis=0).max())
    ground = float(bounds[:, 0, 2].min())
    for reach in np.linspace(0.05, -0.03, 9) * size:
        rims = shapely.get_rings(cover.buffer(reach, quad_segs=6).simplify(1e-3 * size))
        flat = [shapely.get_coordinates(rim) for rim in rims]
        at = [sheet.project(np.c_[xy, np.full(len(xy), ground)]) for xy in flat]
        if at:
            path = Line.make_compound_path(*(Line(one, closed=True) for one in at))
            sheet.axes.add_collection(
                PathCollection([path], facecolors="black", alpha=0.02, linewidths=0, zorder=0.5),
                autolim=False,
            )


def draw_labels(
    sheet: Sheet, drawn: list[tuple[int, Floats]] | None, *, numbers: bool, names: bool
) -> None:
    """Write numbers and names on the blocks; of labels that would touch, the nearest is written.

    Of solid blocks on what is seen of the faces ``drawn``, which are given far ones first.
    """
    scene = sheet.scene
    given = scene.number if numbers and scene.number is not None else None
    if given is None and not names:
        return
    taken: list[tuple[float, float, float]] = []
    here = np.flatnonzero(sheet.stage.state != State.ABSENT)
    if sheet.plane is not None:
        here = here[sheet.plane.heights(scene.assembly.centroid[here]) <= 0.0]
    seen = None if drawn is None else _seen(drawn)
    near = here[np.argsort(-(scene.assembly.centroid[here] @ sheet.eye), kind="stable")]
    for i in near.tolist():
        number = str(given[i]) if given is not None and given[i] > 0 else ""
        name = scene.assembly.names[i][:24] if names else ""
        text = " ".join(one for one in (number, name) if one)
        if not text:
            continue
        place = sheet.project(shown_middle(scene.assembly.blocks[i], sheet.eye)[None])[0]
        if seen is not None:
            if i not in seen or seen[i].area * sheet.scale**2 < LETTER**2:
                continue
            if not seen[i].buffer(-0.3 * LINE / sheet.scale).contains(shapely.Point(place)):
                place = shapely.maximum_inscribed_circle(seen[i], LETTER / sheet.scale).coords[0]
        x, y = float(place[0]) * sheet.scale, float(place[1]) * sheet.scale
        half = 0.5 * LETTER * (len(text) + 1)
        if any(abs(x - u) < half + w and abs(y - v) < LINE for u, v, w in taken):
            continue
        taken.append((x, y, half))
        sheet.axes.text(
            float(place[0]), float(place[1]), text, ha="center", va="center", fontsize=_SIZE,
            zorder=1e6, parse_math=False, color=sheet.colours["edge"],
            bbox={
                "boxstyle": "round,pad=0.15", "facecolor": sheet.colours["background"],
                "alpha": 0.75, "lw": 0,
            },
        )  # fmt: skip


def write_beside(sheet: Sheet, layer: Layer) -> None:
    """The texts of a layer, below its entries."""
    for place, text in zip(sheet.project(layer.position), layer.text or (), strict=False):
        if text:
            sheet.axes.annotate(
                text, place, (0.0, -6.0), textcoords="offset points", ha="center", va="top",
                fontsize=_SIZE, zorder=1e6, parse_math=False, color=sheet.colours["edge"],
                bbox={"pad": 1.0, "facecolor": sheet.colours["background"], "lw": 0},
            )  # fmt: skip


def _seen(drawn: list[tuple[int, Floats]]) -> dict[int, Any]:
    """What is seen of each block on the paper: its faces without those drawn later."""
    block = np.array([one for one, _ in drawn])
    shape = shapely.buffer([shapely.Polygon(loop) for _, loop in drawn], 0.0)
    tree, left = shapely.STRtree(shape), {}
    for one in np.unique(block).tolist():
        parts = []
        for face in np.flatnonzero(block == one):
            over = tree.query(shape[face])
            over = over[(over > face) & (block[over] != one)]
            parts.append(shape[face].difference(shapely.union_all(shape[over])))
        left[one] = shapely.union_all(parts)
    return left


def shown_middle(block: Block, toward: Floats) -> Floats:
    """Middle (3,) of the side of a block that an eye in some direction sees most of.

    A side is the face with the largest picture and those that turn as it does, within ALIKE.
    """
    triangles, _ = fan_triangles(stack_faces([block.vertices], [block.faces]))
    normal = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    largest = normal[int(np.argmax(normal @ toward))]
    alike = normal @ largest > _ALIKE * np.linalg.norm(normal, axis=1) * np.linalg.norm(largest)
    weight = np.where(alike, normal @ toward, 0.0)
    return weight @ triangles.mean(axis=1) / weight.sum()
