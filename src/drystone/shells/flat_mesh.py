"""An open mesh with one border: its vertices merged, its border, and the mesh laid flat."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from drystone.base.arrays import Floats, dot
from drystone.base.errors import InputError
from drystone.geometry.coincidence import first_coincident
from drystone.geometry.polyhedron import edges_of, loop_edges, rings
from drystone.shells.lengths import arc_lengths

_WELD = 1e-6
"""Vertices closer than this, relative to the size of the mesh, are merged: formats such as STL
repeat them."""


def welded(
    points: Floats, faces: Sequence[Sequence[int]], corners: Sequence[int] | None, name: str
) -> tuple[Floats, list[list[int]], list[int] | None]:
    """Used vertices, coincident ones merged; the faces and the named corners among them."""
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    first = first_coincident(points, _WELD * size)
    loops = [list(dict.fromkeys(int(first[i]) for i in face)) for face in faces]
    loops = [loop for loop in loops if len(loop) > 2]
    used = sorted({i for loop in loops for i in loop})
    new = {old: i for i, old in enumerate(used)}
    named = None
    if corners is not None:
        unknown = [c for c in corners if not 0 <= int(c) < len(points) or first[c] not in new]
        wrong = [f"{c} is no vertex of its faces" for c in unknown]
        wrong += [f"{c} is named twice" for c in corners if list(corners).count(c) > 1]
        if wrong:
            remedy = f"give different numbers of vertices, from 0 to {len(points) - 1}"
            raise InputError(wrong[0], where=f"corners of mesh '{name}'", remedy=remedy)
        named = [new[int(first[c])] for c in corners]
    return points[used], [[new[i] for i in loop] for loop in loops], named


def border_of(loops: list[list[int]], name: str) -> list[int]:
    """The border's vertices in order, the mesh on their left."""
    after: dict[int, int] = {}
    runs = [edge for loop in loops for edge in loop_edges(loop)]
    edges = set(runs)
    if len(edges) < len(runs):
        raise InputError(
            "neighbouring faces have opposite normals, or three meet at an edge",
            where=f"mesh '{name}'",
            remedy="orient its faces consistently, and leave one surface",
        )
    for a, b in edges:
        if (b, a) not in edges:
            if a in after:
                raise InputError("its border touches itself", where=f"mesh '{name}'")
            after[a] = b
    if not after:
        raise InputError(
            "the mesh is closed", where=f"mesh '{name}'", remedy="give an open surface"
        )
    run, *more = rings(after)
    if more:
        raise InputError(
            "the mesh has several borders: it has a hole, or it is closed to a ring like a dome",
            where=f"mesh '{name}'",
            remedy="close its holes; for a ring use patch_from_grid with closed=True, or cut the "
            "mesh open from border to border",
        )
    first = run.index(min(run))
    return [*run[first:], *run[:first]]


def turns_of(points: Floats, border: list[int]) -> Floats:
    """Turn (b,) [degrees] of the border at each of its vertices."""
    run = points[border]
    before, after = run - np.roll(run, 1, axis=0), np.roll(run, -1, axis=0) - run
    cosine = dot(before, after)
    cosine /= np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    turn: Floats = np.rad2deg(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return turn


def side_between(border: list[int], start: int, end: int) -> list[int]:
    """The border from one vertex to another."""
    i = border.index(start)
    turned = border[i:] + border[:i]
    return turned[: turned.index(end) + 1]


def mapped(
    points: Floats,
    loops: list[list[int]],
    border: list[int],
    corners: list[int],
    polygon: Floats,
    name: str,
) -> Floats:
    """Place (p, 2) of every vertex in a convex polygon (k, 2) whose corners are some of the border.

    Every inner vertex lies at the mean of its neighbours, weighted by inverse length. Source:
    Floater 1997.
    """
    where = f"corners of mesh '{name}'"
    inside = [k for k, corner in enumerate(corners, 1) if corner not in border]
    if inside:
        raise InputError(
            f"number {inside[0]} of {len(corners)} is not on the border", where=where,
            remedy="name vertices of the border",
        )  # fmt: skip
    if not _cyclic([border.index(c) for c in corners]):  # given in the opposite direction
        corners, polygon = [corners[0], *corners[:0:-1]], np.roll(polygon[::-1], 1, axis=0)
        if not _cyclic([border.index(c) for c in corners]):
            raise InputError(
                "they do not follow each other", where=where,
                remedy="name them in their order along the border",
            )  # fmt: skip
    place = np.full((len(points), 2), np.nan)
    for k in range(len(corners)):
        after = (k + 1) % len(corners)
        side = side_between(border, corners[k], corners[after])
        share = arc_lengths(points[side])
        place[side] = polygon[k] + share[:, None] / share[-1] * (polygon[after] - polygon[k])
    ends = edges_of([tuple(loop) for loop in loops])
    weight = 1.0 / np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    shape = (len(points), len(points))
    joined = sparse.coo_matrix((weight, (ends[:, 0], ends[:, 1])), shape).tocsr()
    joined = joined + joined.T
    stiffness = (sparse.diags(np.asarray(joined.sum(axis=1)).ravel()) - joined).tocsc()
    known = ~np.isnan(place[:, 0])
    inner = np.flatnonzero(~known)
    if len(inner):
        pull = -(stiffness[inner][:, np.flatnonzero(known)] @ place[known])
        place[inner] = spsolve(stiffness[inner][:, inner], pull).reshape(-1, 2)
    return place


def _cyclic(order: list[int]) -> bool:
    """Whether four positions ascend cyclically."""
    start = int(np.argmin(order))
    turned = order[start:] + order[:start]
    return turned == sorted(turned)
