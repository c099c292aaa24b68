"""Meshes of vaults on legs, made of four-sided patches, for tests of what users may give."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from drystone.base.arrays import Floats

Plan = tuple[list[Floats], list[tuple[Floats, Floats]]]
"""Four-sided patches (4, 2) [m] counter-clockwise, and the two ends of each foot."""

PARTS = 8
"""Faces along each side of a patch."""


def _boxes(*given: tuple[float, float, float, float]) -> list[Floats]:
    return [np.array([(a, b), (c, b), (c, d), (a, d)]) for a, b, c, d in given]


def _feet(*given: tuple[float, float, float, float]) -> list[tuple[Floats, Floats]]:
    return [(np.array(f[:2]), np.array(f[2:])) for f in given]


def _star(lengths: Sequence[float], angles: Sequence[float], half: float = 1.0) -> Plan:
    """Legs about a middle polygon of quads, at angles [degrees]."""
    turn = np.radians(angles)
    between = 0.5 * (turn + np.roll(turn, -1) + np.where(np.arange(len(turn)) == len(turn) - 1,
                                                         2.0 * np.pi, 0.0))  # fmt: skip
    opening = between - turn
    corner = (half / np.sin(opening))[:, None] * np.stack([np.cos(between), np.sin(between)], 1)
    quads, feet = [], []
    for k, angle in enumerate(turn):
        out = np.array([np.cos(angle), np.sin(angle)])
        right, left = corner[k - 1], corner[k]
        ends = right + lengths[k] * out, left + lengths[k] * out
        middle, outer = 0.5 * (right + left), 0.5 * (ends[0] + ends[1])
        quads += [
            np.array([right, ends[0], outer, middle]), np.array([middle, outer, ends[1], left]),
        ]  # fmt: skip
        later = 0.5 * (left + corner[(k + 1) % len(turn)])
        quads.append(np.array([0.0 * out, middle, left, later]))
        feet.append(ends)
    return quads, feet


def plans() -> dict[str, Plan]:
    """Plans by name."""
    return {
        "T": (
            _boxes((-5, -1, -1, 1), (-1, -1, 1, 1), (1, -1, 5, 1), (-1, -6, 1, -1)),
            _feet((-5, 1, -5, -1), (-1, -6, 1, -6), (5, -1, 5, 1)),
        ),
        "Y": _star((4.0, 4.0, 4.0), (90.0, 210.0, 330.0)),
        "uneven": _star((3.0, 5.0, 4.0), (80.0, 200.0, 330.0)),
        "cross": (
            _boxes((-1, -1, 1, 1), (-5, -1, -1, 1), (1, -1, 5, 1), (-1, -5, 1, -1), (-1, 1, 1, 5)),
            _feet((-5, 1, -5, -1), (-1, -5, 1, -5), (5, -1, 5, 1), (1, 5, -1, 5)),
        ),
        "H": (
            _boxes((-4, -6, -2, -1), (-4, -1, -2, 1), (-4, 1, -2, 6), (-2, -1, 2, 1),
                   (2, -6, 4, -1), (2, -1, 4, 1), (2, 1, 4, 6)),
            _feet((-4, -6, -2, -6), (2, -6, 4, -6), (4, 6, 2, 6), (-2, 6, -4, 6)),
        ),
        "L": (
            _boxes((-1, -1, 1, 1), (1, -1, 5, 1), (-1, 1, 1, 6)),
            _feet((5, -1, 5, 1), (1, 6, -1, 6)),
        ),
    }  # fmt: skip


def mesh_of(
    name: str, *, rise: float = 3.0, noise: float = 0.0, triangles: bool = False,
    tilt_deg: float = 0.0,
) -> tuple[Floats, list[list[int]], list[int]]:  # fmt: skip
    """Vertices, faces, and the ends of the feet. An arch rises from each foot
    to the middle; the lowest of them is the surface."""
    quads, feet = plans()[name]
    at = np.linspace(0.0, 1.0, PARTS + 1)
    u, v = (a.ravel()[:, None] for a in np.meshgrid(at, at, indexing="ij"))
    each = [
        (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
        for a, b, c, d in quads
    ]
    n = np.arange((PARTS + 1) ** 2).reshape(PARTS + 1, PARTS + 1)
    loop = np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], axis=-1).reshape(-1, 4)
    plan, new = np.unique(np.concatenate(each).round(9), axis=0, return_inverse=True)
    faces = [list(f) for k in range(len(each)) for f in new.ravel()[loop + k * n.size].tolist()]
    arches = []
    for a, b in feet:
        inwards = np.array([a[1] - b[1], b[0] - a[0]]) / np.linalg.norm(b - a)
        arches.append(1.0 - np.clip((plan - a) @ inwards / (-a @ inwards) - 1.0, -1.0, 0.0) ** 2)
    height = -0.1 * np.log(np.exp(-10.0 * np.array(arches)).sum(axis=0))  # a smooth least one
    points = np.column_stack([plan, rise * height])
    points += np.random.default_rng(3).normal(0.0, noise, points.shape)
    corners = [int(np.argmin(np.linalg.norm(plan - e, axis=1))) for foot in feet for e in foot]
    if triangles:
        faces = [t for a, b, c, d in faces for t in ([a, b, c], [a, c, d])]
    c, s = np.cos(np.radians(tilt_deg)), np.sin(np.radians(tilt_deg))
    return points @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]]), faces, corners


def write_obj(path: Path, points: Floats, faces: list[list[int]]) -> None:
    """Write an OBJ file."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
