"""Blocks, motions and layers as matplotlib draws them.

Faces are painted from back to front. Two that overlap on the paper are ordered by their depth at a
point that both cover; a comparison of centroids is not enough. Faces that hide each other in a ring
are drawn triangle by triangle.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from drystone.answer.scene import Layer, LayerKind, MarkerShape, State
from drystone.assembly import Assembly
from drystone.base.arrays import ROUNDING, Bools, Floats, Ints, plane_cross
from drystone.base.ragged import Ragged
from drystone.geometry import clip
from drystone.geometry.frames import area_vectors
from drystone.geometry.halfedge import sharp_edges
from drystone.geometry.triangulate import triangulate
from drystone.view.palette import STATE_COLOUR, ramp_colours, rgb
from drystone.view.section import clip_loop, cut_faces
from drystone.view.sheet import Sheet

if TYPE_CHECKING:
    from matplotlib.path import Path


@dataclass(frozen=True, eq=False)
class SortedPolygons:
    """Polygons in the order in which they are drawn, far ones first.

    Attributes
    ----------
    corner : (l,) positions in ``assembly.faces.loop``, patch after patch
    start : (p + 1,)
    face : (p,) the face that a patch is, or is part of
    outlined : (l,) whether the side from a corner to the next is an edge of the block
    """

    corner: Ints
    start: Ints
    face: Ints
    outlined: Bools


def ordered_patches(assembly: Assembly, toward: Floats, paper: Floats) -> SortedPolygons:
    """The visible sides of all blocks, far ones first.

    Parameters
    ----------
    assembly
    toward, paper
        Unit vector (3,) to the eye, and the axes (2, 3) of the paper.
    """
    faces = assembly.faces
    front = faces.normals @ toward > ROUNDING
    _, _, drawn = sharp_edges(faces, front)
    corners = faces.point[faces.loop]
    every = np.flatnonzero(front)
    loops_of, row = faces.corners.take(every)
    triangle, face = triangulate(corners[row], loops_of.start)
    triangle, face = row[triangle], every[face]
    behind, before = _hidden_pairs(corners[triangle], toward, paper)
    # Faces stay whole unless they hide each other in a ring; then they go triangle by triangle.
    ring = _rings(faces.count, face[behind], face[before])
    single = ring[face]
    item = np.where(single, faces.count + np.arange(len(face)), face)
    depth = np.concatenate(
        [faces.corners.mean(corners @ toward), (corners[triangle] @ toward).mean(axis=1)]
    )
    place = np.argsort(topological(len(depth), item[behind], item[before], depth))
    whole = every[~ring[every]]
    loops = [np.arange(faces.start[f], faces.start[f + 1]) for f in whole]
    loops += list(triangle[single])
    owner = np.concatenate([whole, face[single]]).astype(np.intp)
    order = np.argsort(place[np.concatenate([whole, item[single]])])
    loops = [loops[i] for i in order]
    corner = np.concatenate(loops) if loops else np.zeros(0, dtype=np.intp)
    start = Ragged.of(loops).start
    next_corner = corner[Ragged(start).following] if len(corner) else corner
    outlined = drawn[corner] & (next_corner == faces.corners.following[corner])
    return SortedPolygons(corner, start, owner[order], outlined)


def topological(count: int, before: Ints, after: Ints, depth: Floats) -> Ints:
    """An order (count,) that respects all pairs, the farthest first where there is a choice.

    Parameters
    ----------
    count
    before, after : (e,)
    depth : (count,)
        Larger is nearer to the eye. In a ring of pairs the farthest is drawn first.
    """
    pairs = np.unique(np.stack([before, after], axis=1), axis=0).reshape(-1, 2)
    first = np.searchsorted(pairs[:, 0], np.arange(count + 1)).tolist()
    target = pairs[:, 1].tolist()
    waiting = np.bincount(pairs[:, 1], minlength=count).tolist()
    keys = depth.tolist()
    ready = [(keys[i], i) for i in range(count) if waiting[i] == 0]
    heapq.heapify(ready)
    by_depth = iter(np.argsort(depth, kind="stable").tolist())
    done = [False] * count
    order: list[int] = []
    while len(order) < count:
        item = heapq.heappop(ready)[1] if ready else next(i for i in by_depth if not done[i])
        if done[item]:
            continue
        done[item] = True
        order.append(item)
        for other in target[first[item] : first[item + 1]]:
            waiting[other] -= 1
            if waiting[other] == 0 and not done[other]:
                heapq.heappush(ready, (keys[other], other))
    return np.array(order, dtype=np.intp)


def _rings(count: int, before: Ints, after: Ints) -> Bools:
    """Which items (count,) no order of the pairs can place."""
    graph = coo_array((np.ones(len(before)), (before, after)), shape=(count, count))
    _, group = connected_components(graph, directed=True, connection="strong")
    return (np.bincount(group) > 1)[group] if count else np.zeros(0, dtype=bool)


def _hidden_pairs(triangle: Floats, toward: Floats, paper: Floats) -> tuple[Ints, Ints]:
    """Pairs (behind, in front) of triangles (t, 3, 3) that overlap on the paper."""
    if len(triangle) == 0:
        return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
    flat = triangle @ paper.T  # counter-clockwise: the sides are seen from outside
    depth = triangle @ toward
    shape = shapely.polygons(flat)
    area = shapely.area(shape)
    wide = area > 1e-12 * np.ptp(flat) ** 2  # a sliver seen edge-on hides nothing
    i, j = shapely.STRtree(shape).query(shape)
    keep = (i < j) & wide[i] & wide[j]
    i, j = i[keep], j[keep]
    three = np.full(len(i), 3)
    common, start = clip.flatten(clip.intersect_convex((flat[i], three), (flat[j], three)))
    keep = clip.areas(common, start) > 1e-9 * np.minimum(area[i], area[j])
    i, j = i[keep], j[keep]
    at = Ragged(start).mean(common)[keep]
    nearer = _depth_at(flat[j], depth[j], at) - _depth_at(flat[i], depth[i], at)
    apart = np.abs(nearer) > 1e-9 * (np.ptp(depth) + np.ptp(flat))
    front_j = nearer > 0.0
    behind, before = np.where(front_j, i, j)[apart], np.where(front_j, j, i)[apart]
    return behind.astype(np.intp), before.astype(np.intp)


def _depth_at(flat: Floats, depth: Floats, at: Floats) -> Floats:
    """Depth of the planes of triangles (p, 3, 2) with corner depths (p, 3) at points (p, 2)."""
    a, b = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    p = at - flat[:, 0]
    whole = plane_cross(a, b)
    whole = np.where(whole == 0.0, 1.0, whole)
    s = plane_cross(p, b) / whole
    t = plane_cross(a, p) / whole
    return depth[:, 0] + s * (depth[:, 1] - depth[:, 0]) + t * (depth[:, 2] - depth[:, 0])


_WIDEST = 5.0
"""[points], line of the largest force in a network."""
ADDED_OPACITY = 0.85
"""Least opacity of blocks that were added, in the colour of the legend."""
_SHADES = 12
"""Number of colours of forces: a triangle is divided until each part has one colour."""
_FINEST = 0.02
"""[inches], about, parts that are not divided any more. Chosen: half a millimetre."""


def draw_blocks(sheet: Sheet, layers: list[Layer]) -> list[tuple[int, Floats]]:
    """The blocks of the stage and the polygons of layers, hidden ones under those in front.

    Returns the block and the outline on the paper of each face drawn, far ones first.
    """
    from matplotlib.path import Path as Line

    scene, stage, paper = sheet.scene, sheet.stage, sheet.paper
    present = np.flatnonzero(stage.state != State.ABSENT)
    if len(present) == 0:
        return []
    assembly = scene.assembly.subset(present)
    patches = ordered_patches(assembly, sheet.eye, paper)
    faces = assembly.faces
    corners = faces.point[faces.loop]
    flat = sheet.project(corners)
    height = None if sheet.plane is None else sheet.plane.heights(corners)
    state = stage.state[present][faces.owner[patches.face]]
    fills, edge = _shaded(sheet, sheet.states[state], faces.normals[patches.face])
    fills[state == State.ADDED, 3] = np.maximum(fills[state == State.ADDED, 3], ADDED_OPACITY)
    wide = np.where(state == State.FALLING, 1.2, 0.5) * sheet.thin
    between = _between(sheet, layers, patches, faces.owner, present)
    paths: list[Line] = []
    drawn: list[tuple[int, Floats]] = []
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
        drawn.append((int(present[faces.owner[patches.face[i]]]), corner))
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
    if paths:
        _paint(sheet, paths, look)
    return drawn


def _shaded(sheet: Sheet, base: Floats, normal: Floats) -> tuple[Floats, Floats]:
    """Fills (p, 4) and edges (p, 3) of faces by their colours (p, 3) and normals (p, 3)."""
    light = 0.72 * sheet.eye + 0.42 * sheet.paper[1] - 0.55 * sheet.paper[0]
    shade = 0.58 + 0.36 * np.maximum(normal @ light, 0.0) + 0.08 * normal[:, 2]
    glass = np.full(len(base), sheet.opacity)
    if sheet.opacity < 1.0:
        glass += 0.3 * (1.0 - np.abs(normal @ sheet.eye)) ** 3
    fills = np.c_[np.clip(base * shade[:, None], 0.0, 1.0), np.minimum(glass, 1.0)]
    edge = np.where((base @ [0.3, 0.6, 0.1] < 0.2)[:, None], 0.62, rgb(sheet.colours["edge"]))
    return fills, edge


def _paint(sheet: Sheet, paths: list[Path], look: list[tuple[Any, Any, float, str]]) -> None:
    """Add paths, each with its fill, edge, width of the edge and hatch."""
    from matplotlib.collections import PathCollection

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
    from scipy.spatial.transform import Rotation  # slow to import

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


def as_seen(layer: Layer, eye: Floats) -> Layer:
    """A layer as it is seen from (3,): faces that one looks along, as the lines around them.

    They are in pieces, unless they are many, and grow wider with a value that differs along them.
    Faces without a value do not count: of a wall from its end, those between its stones.
    """
    if layer.start is None:
        return layer
    loops, at = Ragged(layer.start), layer.position
    area = area_vectors(at, layer.start)
    seen = np.abs(area @ eye) > 1e-3 * np.linalg.norm(area, axis=1)
    if layer.value is not None:
        seen &= np.maximum.reduceat(layer.value, layer.start[:-1]) > 1e-3 * layer.largest
    if seen.any():
        return layer
    pieces = 1 if layer.value is None or len(at) > 5_000 else _SHADES
    share, after = np.arange(pieces)[:, None] / pieces, loops.following
    value = layer.value
    if value is not None:
        value = (value + (share + 0.5 / pieces) * (value[after] - value)).ravel()
    owner = np.tile(loops.owner, pieces)
    return replace(
        layer, kind=LayerKind.LINES, start=None, width=2.0, value=value,
        label=f"{layer.label}, along joints" if value is not None else layer.label,
        position=(at + share[:, :, None] * (at[after] - at)).reshape(-1, 3),
        vector=np.tile((at[after] - at) / pieces, (pieces, 1)),
        interface=None if layer.interface is None else layer.interface[owner],
        block=None if layer.block is None else layer.block[owner],
    )  # fmt: skip


def draw_layer(sheet: Sheet, layer: Layer, stretch: float) -> None:
    """Lines, arrows or markers of a layer over the blocks; arrows ``stretch`` times as long."""
    from matplotlib.collections import LineCollection

    colour = sheet.colours[layer.colour]
    at = sheet.project(layer.position)
    if layer.kind is LayerKind.MARKERS:
        sheet.axes.scatter(
            at[:, 0], at[:, 1], s=(7.5 * max(sheet.thin, 0.35)) ** 2,
            facecolors=np.where(_behind(sheet, layer.position), "none", colour).tolist(),
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


def _behind(sheet: Sheet, points: Floats) -> Bools:
    """Which points (p, 3) lie behind solid blocks, in the box of none: their marks are hollow."""
    hidden = np.zeros(len(points), dtype=bool)
    here = sheet.stage.state != State.ABSENT
    if sheet.opacity < 1.0 or sheet.plane is not None or not here.any():
        return hidden
    faces = sheet.scene.assembly.subset(np.flatnonzero(here)).faces
    corners = faces.point[faces.loop]
    triangle, face = triangulate(corners, faces.start)
    three = corners[triangle[(faces.normals @ sheet.eye > ROUNDING)[face]]]
    flat, depth = sheet.project(three), three @ sheet.eye
    spot, over = shapely.STRtree(shapely.polygons(flat)).query(
        shapely.points(sheet.project(points)), predicate="intersects"
    )
    front = _depth_at(flat[over], depth[over], sheet.project(points[spot]))
    nearer = front > points[spot] @ sheet.eye
    low, high = sheet.scene.assembly.bounds[here].transpose(1, 0, 2)
    on = ROUNDING * np.ptp(corners)
    for one in np.unique(spot[nearer]).tolist():
        hidden[one] = not ((low - on <= points[one]) & (points[one] <= high + on)).all(axis=1).any()
    return hidden


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
