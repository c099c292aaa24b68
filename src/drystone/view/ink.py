"""Blocks, motions and layers as matplotlib draws them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from scipy.spatial.transform import Rotation

from drystone.answer.question import UP
from drystone.answer.scene import Layer, LayerKind, MarkerShape, Scene, SceneStage, State
from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints
from drystone.geometry.frames import rotation_about
from drystone.geometry.halfedge import sharp_edges
from drystone.geometry.triangulate import triangulate
from drystone.view.depth import SortedPolygons, ordered_patches
from drystone.view.palette import ROLE_COLOUR, STATE_COLOUR, ramp_colours, rgb
from drystone.view.section import Plane, clip_loop, cut_faces, plane_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.path import Path

_FINE_BLOCK = 0.5
"""[inches], drawn blocks smaller than this get thinner lines and arrows; chosen by eye."""
_MANY_FALLING = 200
"""With more falling blocks the motion is not drawn: it would hide the model. Chosen by eye."""
_WIDEST = 5.0
"""[points], line of the largest force in a network."""
_SHADES = 12
"""Number of colours of forces: a triangle is divided until each part has one colour."""
_FINEST = 0.02
"""[inches], about, parts that are not divided any more. Chosen: half a millimetre."""


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
        made: Floats = np.stack([right, np.cross(self.toward, right)]) @ self._tilt
        return made

    @cached_property
    def eye(self) -> Floats:
        """(3,) unit, from the model to the eye, in the axes of the model."""
        turned: Floats = self.toward @ self._tilt
        return turned

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
        flat: Floats = (points - self.scene.centre) @ self.paper.T
        return flat

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
        grown = cover.buffer(reach, quad_segs=6).simplify(1e-3 * size)
        paths = []
        for part in shapely.get_parts(grown):
            if part.is_empty or part.geom_type != "Polygon":
                continue
            rings = [part.exterior, *part.interiors]
            flat = [np.asarray(ring.coords) for ring in rings]
            at = [sheet.project(np.c_[xy, np.full(len(xy), ground)]) for xy in flat]
            paths.append(Line.make_compound_path(*(Line(one, closed=True) for one in at)))
        if paths:
            sheet.axes.add_collection(
                PathCollection(paths, facecolors="black", alpha=0.02, linewidths=0, zorder=0.5),
                autolim=False,
            )


def draw_blocks(sheet: Sheet, layers: list[Layer]) -> None:
    """The blocks of the stage and the polygons of layers, hidden ones under those in front."""
    from matplotlib.collections import PathCollection
    from matplotlib.path import Path as Line

    scene, stage, paper = sheet.scene, sheet.stage, sheet.paper
    present = np.flatnonzero(stage.state != State.ABSENT)
    if len(present) == 0:
        return
    assembly = scene.assembly.subset(present)
    contacts = scene.contacts.of_blocks(present, len(scene.assembly))
    patches = ordered_patches(assembly, contacts, sheet.eye, paper)
    faces = assembly.faces
    corners = faces.point[faces.loop]
    flat = sheet.project(corners)
    height = None if sheet.plane is None else sheet.plane.heights(corners)
    normal = faces.normals[patches.face]
    light = 0.72 * sheet.eye + 0.42 * paper[1] - 0.55 * paper[0]
    shade = 0.58 + 0.36 * np.maximum(normal @ light, 0.0) + 0.08 * normal[:, 2]
    state = stage.state[present][faces.owner[patches.face]]
    base = sheet.states[state]
    glass = np.full(len(base), sheet.opacity)
    if sheet.opacity < 1.0:
        glass += 0.3 * (1.0 - np.abs(normal @ sheet.eye)) ** 3
    fills = np.c_[np.clip(base * shade[:, None], 0.0, 1.0), np.minimum(glass, 1.0)]
    edge = np.where((base @ [0.3, 0.6, 0.1] < 0.2)[:, None], 0.62, rgb(sheet.colours["edge"]))
    wide = np.where(state == State.FALLING, 1.2, 0.5) * sheet.thin
    between = _between(sheet, layers, patches, faces.owner, present)
    paths: list[Line] = []
    look: list[tuple[Any, Any, float, str]] = []
    for i in range(len(patches.face)):
        for loop, colour in between.get(i, ()):
            paths.append(Line(np.vstack([loop, loop[:1]]), closed=True))
            look.append((colour, colour, 0.4, ""))
        part = patches.corner[patches.start[i] : patches.start[i + 1]]
        corner, outlined = flat[part], patches.outlined[patches.start[i] : patches.start[i + 1]]
        if height is not None:
            corner, outlined = clip_loop(corner, height[part], outlined)
            if len(corner) < 3:
                continue
        closed = np.vstack([corner, corner[:1]])
        paths.append(Line(closed, closed=True))
        whole = outlined.all()
        bare = "none" if sheet.opacity < 1.0 else fills[i]
        hatch = "////" if state[i] == State.LATER else ""
        look.append((fills[i], edge[i] if whole else bare, wide[i] if whole else 0.25, hatch))
        if not whole and outlined.any():
            sides = np.stack([corner, closed[1:]], axis=1)[outlined].reshape(-1, 2)
            codes = np.tile([Line.MOVETO, Line.LINETO], len(sides) // 2)
            paths.append(Line(sides, codes))
            look.append(("none", edge[i], wide[i], ""))
    for path in _cut_faces(sheet, assembly):
        paths.append(path)
        glass_of = 1.0 if sheet.opacity == 1.0 else 0.5 * sheet.opacity
        look.append((np.r_[rgb(sheet.colours["cut"]), glass_of], sheet.colours["edge"], 0.8, ""))
    if not paths:
        return
    # one collection keeps the order; hatched ones are in another
    fill, line, width, hatches = zip(*look, strict=True)
    sheet.axes.add_collection(
        PathCollection(
            paths, facecolors=fill, edgecolors=line, linewidths=width, joinstyle="round",
        )
    )  # fmt: skip
    hatched = [path for path, hatch in zip(paths, hatches, strict=True) if hatch]
    if hatched:
        stripe = STATE_COLOUR[sheet.theme][State.PROPPED]
        sheet.axes.add_collection(
            PathCollection(
                hatched, facecolors="none", edgecolors=stripe, linewidths=0.0, hatch="////",
            )
        )  # fmt: skip


def _cut_faces(sheet: Sheet, assembly: Assembly) -> list[Path]:
    """What a section shows of the inside of blocks; it lies before everything that is left."""
    from matplotlib.path import Path as Line

    if sheet.plane is None:
        return []
    rings: dict[int, list[Line]] = {}
    for block, ring in cut_faces(assembly.faces, sheet.plane.normal, sheet.plane.offset):
        closed = sheet.project(np.vstack([ring, ring[:1]]))
        rings.setdefault(block, []).append(Line(closed, closed=True))
    return [Line.make_compound_path(*some) for some in rings.values()]


def _between(
    sheet: Sheet, layers: list[Layer], patches: SortedPolygons, owner: Ints, present: Ints
) -> dict[int, list[tuple[Floats, Floats]]]:
    """Polygons of layers by the patch before which they are drawn.

    A polygon of an interface lies behind the nearer of its two blocks and before the other one.
    """
    position = np.full(len(sheet.scene.assembly), len(patches.face))
    block = present[owner[patches.face]]
    position[block[::-1]] = np.arange(len(block))[::-1]
    out: dict[int, list[tuple[Floats, Floats]]] = {}
    last = len(patches.face) - 1
    for layer in layers:
        if layer.start is None:
            continue
        contacts = sheet.scene.contacts
        first = np.zeros(layer.count, dtype=np.intp)
        if layer.interface is not None:
            ends = (contacts.block_a[layer.interface], contacts.block_b[layer.interface])
            first = np.minimum(np.maximum(position[ends[0]], position[ends[1]]), last)
        for polygon, loop, colour in _coloured(sheet, layer):
            out.setdefault(int(first[polygon]), []).append((loop, colour))
    return out


def _coloured(sheet: Sheet, layer: Layer) -> list[tuple[int, Floats, Floats]]:
    """Polygon, corners on the paper, and colour of each piece of a layer of polygons."""
    start = layer.start if layer.start is not None else np.zeros(1, dtype=np.intp)
    at = sheet.project(layer.position)
    if layer.value is None:
        colour = np.r_[rgb(sheet.colours[layer.colour]), 0.75]
        loops = np.split(at, start[1:-1])
        return [(i, loop, colour) for i, loop in enumerate(loops)]
    share = layer.value / max(sheet.scene.top(layer.key), 1e-300)
    triangle, polygon = triangulate(layer.position, start)
    pieces: list[tuple[int, Floats, Floats]] = []
    for corners, number in zip(triangle, polygon.tolist(), strict=True):
        shades = _SHADES * float(np.ptp(np.minimum(share[corners], 1.0)))
        fine = float(np.ptp(at[corners], axis=0).max()) * sheet.scale / _FINEST
        steps = max(1, int(np.ceil(min(shades, fine))))
        weight = _divided(steps)
        colours = ramp_colours(weight.mean(axis=1) @ share[corners], sheet.theme)
        pieces += [
            (number, one, colour) for one, colour in zip(weight @ at[corners], colours, strict=True)
        ]
    return pieces


def _divided(steps: int) -> Floats:
    """Weights (t, 3, 3) of the corners of a triangle at those of its steps^2 parts."""
    parts = []
    for i in range(steps):
        for j in range(steps - i):
            k = steps - i - j
            parts.append([(i, j, k), (i + 1, j, k - 1), (i, j + 1, k - 1)])
            if k > 1:
                parts.append([(i + 1, j, k - 1), (i + 1, j + 1, k - 2), (i, j + 1, k - 1)])
    return np.array(parts) / steps


def draw_motion(sheet: Sheet) -> None:
    """Outlines of falling blocks at the end of the motion, and an arrow for each."""
    from matplotlib.collections import LineCollection

    stage = sheet.stage
    if stage.motion is None or not sheet.shows_motion:
        return
    moving = np.flatnonzero(stage.state == State.FALLING)
    assembly = sheet.scene.assembly.subset(moving)
    motion = stage.motion[moving]
    faces = assembly.faces
    edge, owner, _ = sharp_edges(faces)
    turn = Rotation.from_rotvec(np.repeat(motion[owner, 3:], 2, axis=0))
    centroid = np.repeat(assembly.centroid[owner], 2, axis=0)
    arm = turn.apply(faces.point[edge.ravel()] - centroid)
    moved = centroid + np.repeat(motion[owner, :3], 2, axis=0) + arm
    if sheet.plane is not None:
        moved = moved.reshape(-1, 6)[(sheet.plane.heights(moved) <= 0.0).reshape(-1, 2).all(axis=1)]
    lines = sheet.project(moved.reshape(-1, 3)).reshape(-1, 2, 2)
    colour = STATE_COLOUR[sheet.theme][State.FALLING]
    sheet.axes.add_collection(
        LineCollection(list(lines), colors=colour, linewidths=0.6, linestyles="--")
    )
    shown = slice(None) if sheet.plane is None else sheet.plane.heights(assembly.centroid) <= 0.0
    tail = sheet.project(assembly.centroid[shown])
    _arrows(sheet, tail, motion[shown, :3] @ sheet.paper.T, sheet.colours["edge"], 1.0)


def draw_layer(sheet: Sheet, layer: Layer, stretch: float) -> None:
    """Lines, arrows or markers of a layer over the blocks; arrows ``stretch`` times as long."""
    from matplotlib.collections import LineCollection

    colour = sheet.colours[layer.colour]
    at = sheet.project(layer.position)
    if layer.kind is LayerKind.MARKERS:
        sheet.axes.scatter(
            at[:, 0], at[:, 1], s=(7.5 * max(sheet.thin, 0.35)) ** 2, color=colour,
            marker="D" if layer.shape is MarkerShape.DIAMOND else "o",
            edgecolors=sheet.colours["edge"], linewidths=0.8, zorder=4.0,
        )  # fmt: skip
        return
    if layer.vector is None:
        return
    vector = layer.vector @ sheet.paper.T
    if layer.kind is LayerKind.LINES:
        lines = np.stack([at, at + vector], axis=1)
        share = np.full(len(lines), 0.2)
        if layer.value is not None:
            share = np.minimum(layer.value / max(sheet.scene.top(layer.key), 1e-300), 1.0)
        wide = layer.width if layer.value is None else np.maximum(0.6, _WIDEST * share * sheet.thin)
        sheet.axes.add_collection(
            LineCollection(
                list(lines), colors=colour, linewidths=wide, capstyle="round", zorder=3.0,
                alpha=np.clip(0.2 + 10.0 * share, 0.0, 1.0),
            )
        )  # fmt: skip
        return
    vector = vector * sheet.scene.arrow_scale(layer.group) * stretch
    if layer.single:
        _arrows(sheet, at - vector, vector, colour, layer.width)
        return
    for half in (0.5 * vector, -0.5 * vector):
        if layer.inward:
            _arrows(sheet, at + half, -half, colour, layer.width)
        else:
            _arrows(sheet, at, half, colour, layer.width)


def _arrows(sheet: Sheet, at: Floats, vector: Floats, colour: str, width: float) -> None:
    """Arrows on the paper; small ones are paler."""
    length = np.linalg.norm(vector, axis=1)
    long: Bools = length > 1e-3 * length.max(initial=0.0)
    if not long.any():
        return
    at, vector, length = at[long], vector[long], length[long]
    seen = np.clip(0.15 + 4.0 * length / length.max(), 0.0, 1.0)
    sheet.axes.quiver(
        at[:, 0], at[:, 1], vector[:, 0], vector[:, 1],
        angles="xy", scale_units="xy", scale=1.0, units="inches", width=0.010 * width * sheet.thin,
        headwidth=4.5, headlength=6.0, headaxislength=5.5, minlength=0.0,
        color=colour, alpha=seen, zorder=3.0,
    )  # fmt: skip
    sheet.axes.update_datalim(np.concatenate([at, at + vector]))
