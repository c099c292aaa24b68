"""Bodies divided into convex pieces, for collision tests, swept volumes and simulators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np

from drystone.base.arrays import SAME, Floats, Ints, unit
from drystone.base.ragged import Ragged
from drystone.geometry.polyhedron import Loop
from drystone.geometry.triangulate import triangulate

_SLIGHT = np.deg2rad(12.0)
"""A concave edge that bends by less may be filled. Chosen: warped faces of vaults bend by up to 8
degrees in their middle, joggles by 45 and more."""
_KERF = 1e-7
"""Half the width of a cut, relative to the size of the body. A cut without width would leave faces
in its plane on the parts, as sheets without thickness."""


@dataclass(frozen=True, eq=False)
class ConvexPiece:
    """A convex part of a body.

    Attributes
    ----------
    point : (p, 3) [m]
        Its corners.
    normal : (f, 3) unit
        Outward, of its faces.
    offset : (f,) [m]
        The piece is where ``normal @ x <= offset``.
    """

    point: Floats
    normal: Floats
    offset: Floats

    @classmethod
    def around(cls, point: Floats) -> ConvexPiece:
        """The convex hull of some points (p, 3) [m] that do not lie in one plane."""
        from scipy.spatial import ConvexHull  # slow to import

        hull = ConvexHull(point)
        plane = np.unique(np.round(hull.equations, 9), axis=0)
        return cls(point[hull.vertices], plane[:, :3], -plane[:, 3])

    def inset(self, depth: float) -> Floats | None:
        """Corners (p, 3) of the piece with all faces moved in by ``depth`` [m]; None if empty."""
        from scipy.spatial import HalfspaceIntersection, QhullError  # slow to import

        middle = self.point.mean(axis=0)
        if (self.normal @ middle >= self.offset - depth).any():
            return None
        inner = np.column_stack([self.normal, depth - self.offset])
        try:
            return np.asarray(HalfspaceIntersection(inner, middle).intersections)
        except QhullError:  # thinner than rounding
            return None


def solid_of(vertices: Floats, faces: Sequence[Loop]) -> manifold3d.Manifold:
    """A closed body as a manifold3d solid.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops, oriented outwards.
    """
    loop = np.concatenate([np.asarray(face, dtype=np.intp) for face in faces])
    start = Ragged.of(faces).start
    triangle = loop[triangulate(vertices[loop], start)[0]]
    return manifold3d.Manifold(manifold3d.Mesh64(np.array(vertices), triangle.astype(np.uint64)))


def convex_pieces(vertices: Floats, faces: Sequence[Loop], slack: float = 0.0) -> list[ConvexPiece]:
    """Convex pieces that fill a body and share no volume.

    A body is cut along the plane of a face beside its longest concave edge. The parts are cut in
    the same way until all of them are convex.

    Parameters
    ----------
    vertices : (v, 3) [m]
    faces
        Loops, oriented outwards.
    slack
        A part is its convex hull where that is nowhere farther away than this share of the size of
        the body, and no edge is concave by more than :data:`_SLIGHT`: warped faces and shallow
        folds are filled, joggles are not.

    Examples
    --------
    >>> from drystone.models import prism
    >>> block = prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], (0, 1))
    >>> len(convex_pieces(block.vertices, block.faces))
    2
    """
    body = solid_of(vertices, faces)
    least = SAME * body.volume()
    dent = slack * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    waiting, found = [body], []
    while waiting:
        part = waiting.pop()
        hull = part.hull()
        if part.volume() <= least:
            continue
        filled = hull.volume() - part.volume() <= SAME * hull.volume()
        if filled or (slack and _slight(part, hull, dent)):
            found.append(ConvexPiece.around(mesh_of(hull)[0]))
            continue
        connected = part.decompose()
        waiting += connected if len(connected) > 1 else _cut(part)
    return found


def _slight(part: manifold3d.Manifold, hull: manifold3d.Manifold, dent: float) -> bool:
    """Whether a part is its hull but for shallow dents; see :func:`convex_pieces`."""
    if part.genus() != 0 or len(part.decompose()) != 1:
        return False
    point, triangle = mesh_of(part)
    around = ConvexPiece.around(mesh_of(hull)[0])
    if (around.offset - point @ around.normal.T).min(axis=1).max() > dent:
        return False
    _, planes = _concave_edges(point, triangle)
    bend = [one[0] @ other[0] for one, other in planes]
    return min(bend, default=1.0) >= np.cos(_SLIGHT)


def _cut(part: manifold3d.Manifold) -> Sequence[manifold3d.Manifold]:
    """Two parts, cut along the plane of a face beside the longest concave edge that it divides.

    Each edge offers two planes. The plane that leaves fewer concave edges is taken. A triangle
    without area may hide the edge; then the cut follows the plane of the largest face with vertices
    above it. A part that no plane divides is convex up to rounding; its hull is taken.
    """
    point, triangle = mesh_of(part)
    normal, size = _normals(point[triangle])
    kerf = _KERF * float(np.linalg.norm(np.ptp(point, axis=0)))
    length, planes = _concave_edges(point, triangle)
    bent = [planes[edge] for edge in np.argsort(-length)]
    high = (
        (point @ normal.T).max(axis=0) - (point[triangle[:, 0]] * normal).sum(axis=1)
    ) > 10 * kerf
    faces = [[(normal[t], float(normal[t] @ point[triangle[t, 0]]))] for t in np.argsort(-size)
             if high[t] and size[t] > 0.0]  # fmt: skip
    least = SAME * part.volume()
    for choice in (*bent, *faces):
        cuts = [
            (part.trim_by_plane(along, offset + kerf), part.trim_by_plane(-along, kerf - offset))
            for along, offset in choice
        ]
        cuts = [halves for halves in cuts if min(half.volume() for half in halves) > least]
        if cuts:
            return min(cuts, key=_bends_left)
    return [part.hull()]


def _bends_left(halves: Sequence[manifold3d.Manifold]) -> int:
    """Number of concave edges of two parts."""
    return sum(len(_concave_edges(*mesh_of(half))[0]) for half in halves)


def _normals(corner: Floats) -> tuple[Floats, Floats]:
    """Unit normals (t, 3) and twice the areas (t,) of triangles (t, 3, 3)."""
    return unit(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))


def _concave_edges(
    point: Floats, triangle: Ints
) -> tuple[Floats, list[list[tuple[Floats, float]]]]:
    """Lengths of the concave edges, and the planes of the two faces at each."""
    corner = point[triangle]
    normal, size = _normals(corner)
    extent = float(np.linalg.norm(np.ptp(point, axis=0)))
    first: dict[tuple[int, int], int] = {}
    for t, (a, b, c) in enumerate(triangle.tolist()):
        first |= {(a, b): t, (b, c): t, (c, a): t}
    length, planes = [], []
    for (a, b), one in first.items():
        other = first.get((b, a))
        if a > b or other is None or min(size[one], size[other]) <= 0.0:
            continue
        above = float(((corner[other] - point[a]) @ normal[one]).max())
        if above > 1e-6 * extent:
            length.append(float(np.linalg.norm(point[a] - point[b])))
            planes.append([(normal[t], float(normal[t] @ point[a])) for t in (one, other)])
    return np.array(length), planes


def hull_of(point: Floats) -> tuple[Floats, Ints]:
    """The convex hull of points (p, 3): those that it uses, and triangles (t, 3) outwards.

    Raises
    ------
    QhullError
        The points lie in one plane.
    """
    from scipy.spatial import ConvexHull  # slow to import

    hull = ConvexHull(point)
    triangle = hull.simplices.astype(np.intp)
    normal, _ = _normals(point[triangle])
    inward = (normal * hull.equations[:, :3]).sum(axis=1) < 0.0
    triangle[inward] = triangle[inward][:, ::-1]
    used, place = np.unique(triangle, return_inverse=True)
    return point[used], place.reshape(-1, 3)


def mesh_of(solid: manifold3d.Manifold) -> tuple[Floats, Ints]:
    """Corners (p, 3) and triangles (t, 3); manifold3d may write one corner several times."""
    mesh = solid.to_mesh64()
    point = np.asarray(mesh.vert_properties)[:, :3]
    place = np.arange(len(point))
    place[np.asarray(mesh.merge_from_vert, dtype=np.intp)] = mesh.merge_to_vert
    return point, place[np.asarray(mesh.tri_verts).astype(np.intp)]
