"""The lines of a plan that are as far from one open side as from another: its spine.

The lines end at the feet of the plan and meet at nodes. They are edges of the Voronoi diagram of
points on the open sides (source: Blum 1967, medial axis).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import shapely

from drystone.base.arrays import SAME, Floats, Ints
from drystone.shells.patch import arc_lengths, at_lengths

if TYPE_CHECKING:
    from scipy.spatial import Voronoi

_SAMPLES = 1_000
"""Points on the open sides. Chosen: far finer than the nodes of a patch."""


@dataclass(frozen=True)
class SpineNode:
    """Where lines of a spine meet or bend.

    Attributes
    ----------
    place : (2,)
    near
        Of each open side beside it: the length along that side to the nearest point.
    apart
        Distance to that point.
    """

    place: Floats
    near: dict[int, float]
    apart: float


@dataclass(frozen=True)
class Spine:
    """The spine of a plan.

    Attributes
    ----------
    nodes
    lines
        By two open sides, the lower number first: places (p, 2) between them, and the lengths
        (p, 2) along the two to their nearest points.
    """

    nodes: list[SpineNode]
    lines: dict[tuple[int, int], tuple[Floats, Floats]]

    def beside(self, side: int) -> list[SpineNode]:
        """The nodes beside an open side, in their order along it."""
        found = [node for node in self.nodes if side in node.near]
        return sorted(found, key=lambda node: node.near[side])

    def has_line(self, one: int, other: int, *ends: SpineNode | None) -> bool:
        """Whether there is a line between two sides, and each of its nodes is beside both."""
        beside = all(node is None or other in node.near for node in ends)
        return beside and (min(one, other), max(one, other)) in self.lines

    def _along(self, one: int, other: int) -> tuple[Floats, Floats]:
        """The line between two sides, along the first."""
        place, near = self.lines[min(one, other), max(one, other)]
        return (place, near) if one < other else (place[::-1], near[::-1, ::-1])

    def line(self, one: int, other: int, start: SpineNode | None, end: SpineNode | None) -> Floats:
        """Places (p, 2) from one node to another, along the first side; None is a foot."""
        place, near = self._along(one, other)
        key = near[:, 0] - near[:, 1]
        low, high = (
            limit if node is None else node.near[one] - node.near[other]
            for node, limit in ((start, -np.inf), (end, np.inf))
        )
        inner = place[(key > low) & (key < high)]
        ends = [[] if node is None else [node.place] for node in (start, end)]
        return np.array([*ends[0], *inner, *ends[1]])

    def bent(self, side: int, length: float, bend: Floats) -> Spine:
        """The spine with a node at a bend of a side: the closest there is, else a new one."""
        for node in self.nodes:
            if abs(node.near.get(side, np.inf) - length) <= node.apart:
                moved = replace(node, near={**node.near, side: length})
                return replace(self, nodes=[moved if n is node else n for n in self.nodes])
        found = []
        for pair in self.lines:
            if side in pair:
                other = pair[1 - pair.index(side)]
                place, near = self._along(side, other)
                left = np.searchsorted(near[:, 0], length - SAME * length)
                right = np.searchsorted(near[:, 0], length + SAME * length)
                if left > 0 and right < len(near):
                    at = place[(left + right) // 2]
                    across = {side: length, other: float(near[[left - 1, right], 1].mean())}
                    found.append(SpineNode(at, across, float(np.linalg.norm(at - bend))))
        found.sort(key=lambda node: node.apart)
        return replace(self, nodes=[*self.nodes, *found[:1]])


def spine_of(outline: Floats, sides: Sequence[Floats], bends: Sequence[Floats]) -> Spine:
    """The spine of a plan.

    Parameters
    ----------
    outline : (p, 2)
    sides
        The open sides, each (s, 2), counter-clockwise.
    bends
        Of each side: the lengths (b,) along it to its bends. There is a node at each.
    """
    from scipy.spatial import Voronoi  # slow to import

    spacing = sum(float(arc_lengths(side)[-1]) for side in sides) / _SAMPLES
    fine = [shapely.segmentize(shapely.LineString(side), spacing) for side in sides]
    samples = [shapely.get_coordinates(line) for line in fine]
    site, along = np.concatenate(samples), np.concatenate([arc_lengths(line) for line in samples])
    label = np.repeat(np.arange(len(sides)), [len(line) for line in samples])
    cells = Voronoi(site)
    pair, ends = np.sort(cells.ridge_points), np.array(cells.ridge_vertices)  # labels ascend
    middle = cells.vertices[ends].mean(axis=1)
    kept = (label[pair[:, 0]] != label[pair[:, 1]]) & (ends >= 0).all(axis=1)
    kept &= shapely.contains_xy(shapely.Polygon(outline), middle)
    pair, ends, middle = pair[kept], ends[kept], middle[kept]
    lines = {}
    for one, other in np.unique(label[pair], axis=0).tolist():
        own = (label[pair] == (one, other)).all(axis=1)
        near = along[pair[own]]
        order = np.argsort(near[:, 0] - near[:, 1])
        lines[one, other] = middle[own][order], near[order]
    nodes = _meetings(cells, pair, ends, label, along)
    return _with_bends(Spine(_merged(nodes), lines), sides, bends)


def _with_bends(spine: Spine, sides: Sequence[Floats], bends: Sequence[Floats]) -> Spine:
    """The spine with a node at each bend of the sides."""
    places = np.array([point for place, _ in spine.lines.values() for point in place])
    turns = [(k, length, at_lengths(sides[k], length)) for k, at in enumerate(bends)
             for length in at.tolist()]  # fmt: skip
    if spine.lines:
        turns.sort(key=lambda turn: float(np.linalg.norm(places - turn[2], axis=1).min()))
    for k, length, bend in turns:  # an inward bend is closer to the spine than the one across it
        spine = spine.bent(k, length, bend)
    return spine


def _meetings(
    cells: Voronoi, pair: Ints, ends: Ints, label: Ints, along: Floats
) -> list[SpineNode]:
    """The vertices of a diagram at which lines between three open sides or more meet."""
    nodes = []
    for vertex in np.unique(ends):
        around = np.unique(pair[(ends == vertex).any(axis=1)])
        if len(named := np.unique(label[around]).tolist()) > 2:
            near_by = {k: float(along[around[label[around] == k]].mean()) for k in named}
            place = cells.vertices[vertex]
            nodes.append(
                SpineNode(place, near_by, float(np.linalg.norm(cells.points[around[0]] - place)))
            )
    return nodes


def _merged(nodes: list[SpineNode]) -> list[SpineNode]:
    """Nodes of a line that is shorter than it is far from its sides are one."""
    for one, other in itertools.combinations(nodes, 2):
        apart = 0.5 * (one.apart + other.apart)
        if (
            len(one.near.keys() & other.near.keys()) > 1
            and np.linalg.norm(one.place - other.place) < apart
        ):
            near = {
                k: float(np.mean([node.near[k] for node in (one, other) if k in node.near]))
                for k in one.near.keys() | other.near.keys()
            }
            rest = [node for node in nodes if node is not one and node is not other]
            return _merged([*rest, SpineNode(0.5 * (one.place + other.place), near, apart)])
    return nodes
