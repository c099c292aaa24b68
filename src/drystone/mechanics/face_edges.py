"""Which block an edge of an interface belongs to, and how far the face of the other goes on."""

from __future__ import annotations

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, cross
from drystone.geometry.polyhedron import Faces

FLUSH = 1e-6
"""Distance below which an edge of an interface lies on an edge of a block, by the block's size."""
COPLANAR = 0.01
"""Largest distance between an interface and a face that it lies on, by the block's size, and
largest sine of the angle between them: contacts are found on faces that are not quite flat."""

ASKEW = 0.1
"""Sine of the angle between an edge of an imperfect interface and that edge of a block that it
stands for."""


class FaceSides:
    """The sides of the faces of all blocks.

    Attributes
    ----------
    begin, end : (e, 3) [m]
    face : (e,) the face of each
    normal : (f, 3) outward, of each face
    of_block
        The sides of each block.
    """

    def __init__(self, assembly: Assembly) -> None:
        faces: Faces = assembly.faces
        following = np.arange(len(faces.loop)) + 1
        following[faces.start[1:] - 1] = faces.start[:-1]
        self.begin, self.end = faces.point[faces.loop], faces.point[faces.loop[following]]
        self.face = np.repeat(np.arange(faces.count), np.diff(faces.start))
        # relative to the first corner of the face, so a distant origin costs no digits
        first = self.begin[faces.start[:-1]][self.face]
        twice = np.zeros((faces.count, 3))
        np.add.at(twice, self.face, cross(self.begin - first, self.end - first))
        length = np.linalg.norm(twice, axis=1, keepdims=True)
        self.normal = twice / np.where(length > 0.0, length, 1.0)
        owner = faces.owner[self.face]
        order = np.argsort(owner, kind="stable")
        bounds = np.searchsorted(owner[order], np.arange(len(assembly) + 1))
        self.of_block = [order[bounds[i] : bounds[i + 1]] for i in range(len(assembly))]
        self.size = np.cbrt(assembly.volume)
        self.largest = assembly.size

    def in_plane(self, block: int, frame: Floats, origin: Floats) -> Floats:
        """Ends (e, 2, 2), local u and v, of the outer sides of the faces of a block in a plane."""
        here = self.of_block[block]
        begin, end = self.begin[here] - origin, self.end[here] - origin
        size = self.size[block]
        lean = np.linalg.norm(cross(self.normal[self.face[here]], frame[0][None]), axis=1)
        near = np.maximum(np.abs(begin @ frame[0]), np.abs(end @ frame[0])) < COPLANAR * size
        flat = (lean < COPLANAR) & near
        ends = np.stack([begin[flat], end[flat]], axis=1) @ frame[1:].T
        # sides between two faces in the plane are no ends
        back = np.abs(ends[:, None, ::-1] - ends[None]).max(axis=(2, 3), initial=0.0)
        inner = (back < FLUSH * size).any(axis=1)
        return np.asarray(ends[~inner])

    def owned(
        self, block: int, middle: Floats, along: Floats, outward: Floats
    ) -> tuple[Bools, Floats]:
        """Which edges (k,) of interfaces are edges of a block, and their bend (k,).

        The bend is the sine of the angle by which the block's surface turns away from the interface
        at the edge: positive at a convex edge, negative at a re-entrant one.

        Parameters
        ----------
        block
        middle, along : (k, 3) [m]
            The middle of each edge, and its end less its beginning.
        outward : (k, 3)
            Normal of the edge in the plane of its interface.
        """
        here = self.of_block[block]
        on = _on_edges(middle, along, self.begin[here], self.end[here], self.largest[block])
        turned = np.where(on, outward @ self.normal[self.face[here]].T, 0.0)
        most = np.abs(turned).argmax(axis=1)
        bend: Floats = turned[np.arange(len(middle)), most]
        return np.asarray(on.any(axis=1)), bend

    def nearest(self, block: int, middle: Floats, along: Floats) -> Floats:
        """Distance (k,) [m] of edges, as for :meth:`owned`, from the nearest edge of a block.

        Edges of the block that run in another direction do not count.
        """
        here = self.of_block[block]
        run = self.end[here] - self.begin[here]
        square = (run**2).sum(axis=1)
        axis = run / np.sqrt(np.where(square > 0.0, square, 1.0))[:, None]
        arm = middle[:, None] - self.begin[here]
        at = np.clip(np.einsum("kej,ej->ke", arm, axis), 0.0, np.sqrt(square))
        off = np.linalg.norm(arm - at[..., None] * axis, axis=2)
        reach = np.linalg.norm(along, axis=1)
        direction = along / np.where(reach > 0.0, reach, 1.0)[:, None]
        askew = np.linalg.norm(cross(direction[:, None], axis[None]), axis=2)
        return np.asarray(np.where(askew < ASKEW, off, np.inf).min(axis=1, initial=np.inf))


def _on_edges(middle: Floats, along: Floats, begin: Floats, end: Floats, size: float) -> Bools:
    """(k, e) whether a point lies on a side (e, 3) to (e, 3) that runs along a direction."""
    run = end - begin
    length = np.linalg.norm(run, axis=1)
    axis = run / np.where(length > 0.0, length, 1.0)[:, None]
    arm = middle[:, None] - begin[None]
    at = np.einsum("kej,ej->ke", arm, axis)
    off = np.linalg.norm(arm - at[..., None] * axis[None], axis=2)
    near = (off < FLUSH * size) & (at > -FLUSH * size) & (at < length + FLUSH * size)
    reach = np.linalg.norm(along, axis=1)
    direction = along / np.where(reach > 0.0, reach, 1.0)[:, None]
    askew = np.linalg.norm(cross(direction[:, None], axis[None]), axis=2)
    parallel = (askew < 1e-3) | (reach == 0.0)[:, None]
    return np.asarray(near & parallel)


def to_the_end(at: Floats, outward: Floats, segments: Floats) -> Floats:
    """(c,) distance from points (c, 2) along directions (c, 2) to one of segments (e, 2, 2)."""
    run = segments[:, 1] - segments[:, 0]
    arm = segments[None, :, 0] - at[:, None]
    turn = outward[:, None, 0] * run[None, :, 1] - outward[:, None, 1] * run[None, :, 0]
    safe = np.where(np.abs(turn) > 0.0, turn, 1.0)
    far = (arm[..., 0] * run[None, :, 1] - arm[..., 1] * run[None, :, 0]) / safe
    part = (arm[..., 0] * outward[:, None, 1] - arm[..., 1] * outward[:, None, 0]) / safe
    length = np.linalg.norm(run, axis=1)[None]
    met = (np.abs(turn) > 1e-6 * length) & (far > 0.0) & (part >= 0.0) & (part <= 1.0)
    return np.asarray(np.where(met, far, np.inf).min(axis=1, initial=np.inf))
