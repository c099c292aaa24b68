"""An independent answer to "do forces exist that balance the loads?": plain linear programs.

Nothing of the package's statics, detection or solvers is used: contacts come from intersecting
every pair of opposite coplanar faces, equilibrium from summed forces and cross products, and the
friction cone is a pyramid with any number of sides, inside or around the exact cone.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array, csr_array, hstack
from shapely.geometry import Polygon

from drystone import Assembly, Contacts

TOUCH = 1e-5
"""Faces closer than this share of the model are in one plane: the shelf is given to 1e-6 m."""


def touching_faces(assembly: Assembly, friction: float) -> Contacts:
    """Contacts of a small model by brute force over all pairs of faces."""
    size = float(assembly.size.max())
    faces = [[block.vertices[list(loop)] for loop in block.faces] for block in assembly.blocks]
    normals = [np.array([_normal(corners) for corners in each]) for each in faces]
    low, high = assembly.bounds.transpose(1, 0, 2)
    near = (np.maximum(low[:, None], low) <= np.minimum(high[:, None], high) + TOUCH * size).all(2)
    found: list[tuple[int, int, np.ndarray, float, np.ndarray]] = []
    for a, b in np.argwhere(np.triu(near, 1)).tolist():
        for i, j in np.argwhere(normals[a] @ normals[b].T <= -1.0 + TOUCH**2).tolist():
            corners, normal, others = faces[a][i], normals[a][i], faces[b][j]
            if np.abs((others - corners[0]) @ normal).max() > TOUCH * size:
                continue
            u = _cross(np.eye(3)[np.abs(normal).argmin()], normal)
            u /= np.linalg.norm(u)
            frame = np.stack([normal, u, _cross(normal, u)])
            flat = [Polygon((part - corners[0]) @ frame[1:].T) for part in (corners, others)]
            shared = flat[0].intersection(flat[1])
            for piece in getattr(shared, "geoms", [shared]):
                if piece.area > TOUCH * size * np.sqrt(flat[0].area):
                    ring = np.array(piece.normalize().exterior.coords)[-1:0:-1]
                    found.append((a, b, frame, piece.area, ring @ frame[1:] + corners[0]))
    points = [item[4] for item in found]
    return Contacts(
        np.array([item[0] for item in found], dtype=np.intp),
        np.array([item[1] for item in found], dtype=np.intp),
        np.array([item[2] for item in found]),
        np.array([item[3] for item in found]),
        np.full(len(found), friction),
        np.concatenate(points) if points else np.zeros((0, 3)),
        np.repeat(np.arange(len(found), dtype=np.intp), [len(p) for p in points]),
    )


def _normal(corners: np.ndarray) -> np.ndarray:
    arms = corners - corners[0]
    area = _cross(arms.T, np.roll(arms, -1, axis=0).T).sum(axis=1)
    return area / np.linalg.norm(area)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(3, ...) the product of columns; of few several times as fast as numpy's."""
    (x, y, z), (u, v, w) = a, b
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def equilibrium(assembly: Assembly, contacts: Contacts) -> csr_array:
    """Matrix (6 n, 3 k): wrench on each block about its centroid from forces in world axes.

    Rows of fixed blocks are zero. Lengths are divided by the largest block, so that rows compare.
    """
    on = np.stack([contacts.block_b, contacts.block_a], axis=1)[contacts.interface]
    arm = (contacts.point[:, None] - assembly.centroid[on]) / float(assembly.size.max())
    force = np.multiply.outer([1.0, -1.0], np.eye(3))  # of each block along each axis
    wrench = np.zeros((len(on), 2, 3, 6))
    wrench[..., :3], wrench[..., 3:] = force, np.cross(arm[:, :, None], force)
    rows = np.broadcast_to(6 * on[..., None, None] + np.arange(6), wrench.shape)
    cols = np.broadcast_to(np.arange(3 * len(on)).reshape(-1, 1, 3, 1), wrench.shape)
    free = ~assembly.fixed[on]
    where = (rows[free].ravel(), cols[free].ravel())
    return coo_array((wrench[free].ravel(), where), (6 * len(assembly), 3 * len(on))).tocsr()


def generators(contacts: Contacts, sides: int, outside: bool) -> csr_array:
    """Forces in world axes (3 k, sides k) along the edges of each corner's friction pyramid."""
    reach = contacts.friction / (np.cos(np.pi / sides) if outside else 1.0)
    angle = 2.0 * np.pi * (np.arange(sides) + (0.5 if outside else 0.0)) / sides
    frame = contacts.frame[contacts.interface]
    mu = reach[contacts.interface]
    edge = (
        frame[:, 0, None]
        + mu[:, None, None] * np.cos(angle)[:, None] * frame[:, 1, None]
        + mu[:, None, None] * np.sin(angle)[:, None] * frame[:, 2, None]
    )
    k = contacts.corner_count
    rows = (3 * np.arange(k)[:, None, None] + np.arange(3)).repeat(sides, axis=1)
    cols = np.arange(k * sides).reshape(k, sides, 1).repeat(3, axis=2)
    return coo_array((edge.ravel(), (rows.ravel(), cols.ravel())), (3 * k, sides * k)).tocsr()


def weight(assembly: Assembly, direction: np.ndarray) -> np.ndarray:
    """Loads (6 n,) for the rows of :func:`equilibrium`: each block's share of the mean mass."""
    load = np.zeros((len(assembly), 6))
    load[:, :3] = (assembly.mass / assembly.mass.mean())[:, None] * direction
    load[assembly.fixed] = 0.0
    return load.ravel()


def down(axis: tuple[float, float, float] = (0.0, 1.0, 0.0), angle_deg: float = 0.0) -> np.ndarray:
    """Gravity seen from a model that was turned counter-clockwise about ``axis``."""
    e = np.asarray(axis, dtype=np.float64)
    e = e / np.linalg.norm(e)
    g, angle = np.array([0.0, 0.0, -1.0]), -np.deg2rad(angle_deg)
    return g * np.cos(angle) + np.cross(e, g) * np.sin(angle) + e * (e @ g) * (1.0 - np.cos(angle))


class Oracle:
    """Linear programs on one model with one pyramid.

    Parameters
    ----------
    sides
        Of the pyramid; ``outside`` has its faces, otherwise its edges, on the exact cone.
    """

    def __init__(
        self, assembly: Assembly, contacts: Contacts, *, sides: int = 8, outside: bool = True
    ) -> None:
        self.assembly = assembly
        self.rows = np.repeat(~assembly.fixed, 6)
        matrix = equilibrium(assembly, contacts) @ generators(contacts, sides, outside)
        self.matrix = matrix[self.rows]

    def balances(self, direction: np.ndarray) -> bool:
        """Whether forces balance gravity along ``direction``.

        The largest share of the load that can be balanced is all of it or nothing, since forces in
        cones can be scaled: no tolerance decides.
        """
        return self._largest(np.zeros(len(self.rows)), weight(self.assembly, direction), 1.0) > 0.5

    def load_factor(self, direction: np.ndarray) -> float:
        """Largest factor of gravity along ``direction`` on top of gravity downwards."""
        return self._largest(weight(self.assembly, down()), weight(self.assembly, direction), None)

    def _largest(self, dead: np.ndarray, live: np.ndarray, bound: float | None) -> float:
        cost = np.zeros(self.matrix.shape[1] + 1)
        cost[-1] = -1.0
        matrix = hstack([self.matrix, coo_array(live[self.rows, None])])
        limits = [(0.0, None)] * (len(cost) - 1) + [(0.0, bound)]
        answer = linprog(cost, A_eq=matrix, b_eq=-dead[self.rows], bounds=limits, method="highs")
        assert answer.status == 0, answer.message
        return float(answer.x[-1])

    def tilt(self, axis: tuple[float, float, float], below: float, above: float) -> float:
        """Angle [degrees] between ``below`` and ``above`` where balance is lost, to 0.005."""
        return bisected(lambda angle: self.balances(down(axis, angle)), below, above, 0.005)


def bisected(holds: Callable[[float], bool], inside: float, outside: float, width: float) -> float:
    """Middle of a bracket no wider than ``width`` with ``holds`` true at one end only."""
    assert holds(inside)
    assert not holds(outside)
    while abs(outside - inside) > width:
        middle = 0.5 * (inside + outside)
        if holds(middle):
            inside = middle
        else:
            outside = middle
    return 0.5 * (inside + outside)


def largest_warp(points: np.ndarray, polygons: list[tuple[int, ...]]) -> float:
    """Largest distance of a corner from the least-squares plane of its polygon."""
    corners = [points[list(polygon)] for polygon in polygons]
    centred = [corner - corner.mean(axis=0) for corner in corners]
    return max(float(np.abs(one @ np.linalg.svd(one)[2][2]).max()) for one in centred)
