"""Places: vertices of several blocks at one point, which move together; the sides of an arch.

Vertices of all blocks in one array: volumes, centroids, and how they follow the vertices.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from drystone.assembly import Assembly, Block, replace_block
from drystone.base.arrays import SAME, Bools, Floats, Ints, cross, dot, marked
from drystone.base.errors import InputError
from drystone.base.ragged import Ragged, linked, sum_by_owner
from drystone.geometry.selfcontact import self_contacts
from drystone.model import Model

AXES = {"x": 0, "y": 1, "z": 2}

SIDES = {"intrados": 1.0, "extrados": -1.0}
"""Sides by whether their faces look to the middle of the supports, or away from it."""


@dataclass(frozen=True, eq=False)
class Places:
    """The places of the vertices of a model, and their images in its symmetries.

    Attributes
    ----------
    point : (g, 3) [m]
        Of each place, with the coordinate along the axis of the prisms left out.
    group : (v,)
        The place of each vertex.
    image : (s, g)
        The image of each place in each symmetry; the first symmetry leaves all as it is.
    turn : (s, 3, 3)
        The symmetries: rotations and mirrors.
    """

    point: Floats
    group: Ints
    image: Ints
    turn: Floats

    @classmethod
    def of(cls, model: Model, along: str | None, mirror: str | None, sectors: int = 1) -> Places:
        """The places of a model.

        Raises
        ------
        InputError
            An axis is unknown, or the model does not have the symmetry.
        """
        vertex = model.assembly.faces.point
        near = SAME * float(np.ptp(vertex, axis=0).max())
        flat = flattened(vertex, along)
        group = places_of(flat, near)
        point = flat[np.unique(group, return_index=True)[1]]
        turn = _symmetries(mirror, sectors)
        return cls(point, group, _images(point, turn, near), turn)

    @property
    def count(self) -> int:
        """Number of places, g."""
        return len(self.point)

    def matrix(self, ways: Sequence[Floats], still: Bools) -> sparse.csr_matrix:
        """Moves (3 v, p) of the vertices along ways (w, 3) of each place, but for those that stay.

        Parameters
        ----------
        ways
        still : (v,)
            A place stays where one of its vertices, or of those of its images, stays.
        """
        stays = marked(self.group[still], self.count)
        stays = np.asarray(stays[self.image].any(axis=0), dtype=np.bool_)
        members = [np.flatnonzero(self.group == place) for place in range(self.count)]
        rows: list[Ints] = []
        values: list[Floats] = []
        firsts = np.arange(self.count) == self.image.min(axis=0)
        for place in np.flatnonzero(~stays & firsts).tolist():
            for way in self._kept(place, ways[place]):
                step = dict(zip(self.image[:, place].tolist(), self.turn @ way, strict=True))
                some = [(members[one], move) for one, move in step.items()]
                rows.append(np.concatenate([(3 * m[:, None] + np.arange(3)).ravel()
                                            for m, _ in some]))  # fmt: skip
                values.append(np.concatenate([np.tile(move, len(m)) for m, move in some]))
        shape = (3 * len(self.group), len(rows))
        if not rows:
            return sparse.csr_matrix(shape)
        column = np.repeat(np.arange(len(rows)), [len(one) for one in rows])
        made = sparse.csr_matrix((np.concatenate(values), (np.concatenate(rows), column)), shape)
        made.eliminate_zeros()
        return made

    def _kept(self, place: int, ways: Floats) -> Floats:
        """Unit moves (w, 3) of a place along ways (w, 3) that its symmetries leave as they are."""
        own = self.turn[self.image[:, place] == place].mean(axis=0)
        found: list[Floats] = []
        for move in ways @ own.T:
            rest = move - sum((one * float(one @ move) for one in found), np.zeros(3))
            size = float(np.linalg.norm(rest))
            if size > SAME:
                found.append(rest / size)
        return np.array(found).reshape(-1, 3)


def _symmetries(mirror: str | None, sectors: int) -> Floats:
    """The rotations and mirrors (s, 3, 3) of a number of sectors about z, and of a mirror axis.

    Raises
    ------
    InputError
        The axis is unknown, or sectors are mirrored upside down.
    """
    if sectors > 1 and mirror == "z":
        raise InputError("sectors about z are not mirrored along z", remedy="give x or y")
    angle = 2.0 * np.pi * np.arange(sectors) / sectors
    turn = np.zeros((sectors, 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(angle)
    turn[:, 1, 0], turn[:, 0, 1] = np.sin(angle), -np.sin(angle)
    turn[:, 2, 2] = 1.0
    if mirror is None:
        return turn
    flip = np.eye(3)
    flip[axis_of(mirror), axis_of(mirror)] = -1.0
    return np.concatenate([turn, turn @ flip])


def axis_of(name: str) -> int:
    """The position of an axis.

    Raises
    ------
    InputError
        It is not x, y or z.
    """
    if name not in AXES:
        raise InputError(f"there is no axis '{name}'", remedy="give x, y or z")
    return AXES[name]


def flattened(vertex: Floats, along: str | None) -> Floats:
    """The vertices with the coordinate along an axis left out."""
    out = vertex.copy()
    if along is not None:
        out[:, axis_of(along)] = 0.0
    return out


def places_of(point: Floats, near: float) -> Ints:
    """A number (v,) for each place: points that are nearer than this have the same."""
    from scipy.spatial import cKDTree  # slow to import

    pairs = cKDTree(point).query_pairs(near, output_type="ndarray")
    return linked(pairs[:, 0], pairs[:, 1], len(point))


def require_prisms(model: Model, along: str, kept: Bools) -> None:
    """Refuse where a block that is not among those kept (n,) is no prism along an axis.

    Raises
    ------
    InputError
        There is such a block that has faces of more than three corners.
    """
    some = [model.assembly.blocks[i] for i in np.flatnonzero(~kept)]
    if all(len(loop) == 3 for block in some for loop in block.faces):
        return
    for block in some:
        if not is_prism(block, along):
            raise InputError(
                f"is no prism along {along}: its faces would not stay plane",
                where=f"block '{block.name}'",
                remedy="keep it, name another axis, or name none",
            )


def is_prism(block: Block, along: str) -> bool:
    """Whether a block is a prism along an axis."""
    level = np.unique(np.round(block.vertices[:, axis_of(along)] / (SAME * block.size)))
    ends = places_of(flattened(block.vertices, along), SAME * block.size)
    return len(np.unique(ends)) * 2 == len(ends) and len(level) == 2


def _images(place: Floats, turn: Floats, near: float) -> Ints:
    """The image (s, g) of each place in each symmetry, about the mean of all places."""
    from scipy.spatial import cKDTree  # slow to import

    centred = place - place.mean(axis=0)
    found = []
    for one in turn:
        away, image = map(np.asarray, cKDTree(centred).query(centred @ one.T))
        if away.max() > 10.0 * near or len(np.unique(image)) < len(image):
            what = "mirror image" if np.linalg.det(one) < 0.0 else "image in another sector"
            raise InputError(
                f"the model is not its own {what}", remedy="leave the mirror or the sectors out"
            )
        found.append(image)
    return np.array(found, dtype=np.intp)


def on_side(model: Model, side: str, along: str | None) -> Bools:
    """Whether each vertex (v,) is on the intrados, or on the extrados.

    That is where a free block has a face that no joint covers and that looks to the middle of the
    joints with supports, or away from it. Faces across the axis of the prisms are on neither side.

    Raises
    ------
    InputError
        Nothing stands on supports, or no face is on that side.
    """
    assembly, contacts = model.assembly, model.contacts
    fixed = assembly.fixed
    feet = fixed[contacts.block_a] != fixed[contacts.block_b]
    if not feet.any():
        raise InputError("nothing stands on supports", remedy="fix the blocks that it stands on")
    middle = contacts.centroid[feet].mean(axis=0)
    faces = assembly.faces
    found = np.zeros(len(faces.point), dtype=bool)
    towards = SIDES[side] * dot(faces.normals, middle - faces.middles) > 0.0
    if along is not None:
        towards &= np.abs(faces.normals[:, axis_of(along)]) <= 1.0 - SAME
    for j in np.flatnonzero(towards & ~fixed[faces.owner]).tolist():
        i, normal, loop = faces.owner[j], faces.normals[j], faces.loop[faces.corners[j]]
        own = (contacts.block_a == i) | (contacts.block_b == i)
        flat = np.abs(contacts.frame[own, 0] @ normal) > 1.0 - SAME
        away = np.abs((contacts.centroid[own] - faces.point[loop[0]]) @ normal)
        found[loop] |= not (flat & (away < SAME * assembly.size[i])).any()
    if not found.any():
        raise InputError(f"no face is on the {side}", remedy="leave that side out")
    return found


def slides(model: Model, places: Places) -> list[Floats]:
    """The directions (w, 3), one or none, in which the end of a joint at each place slides.

    An end is a place that two blocks share. From it one edge of each block leads away from the
    joint; the direction is that between the ends of the two edges.

    Raises
    ------
    InputError
        No joint has such ends.
    """
    faces = model.assembly.faces
    start, end = places.group[[faces.loop, faces.loop[faces.corners.following]]].tolist()
    # of each block: the places that edges lead to
    beside = [defaultdict[int, set[int]](set) for _ in model.assembly.blocks]
    for i, one, other in zip(faces.owner[faces.corners.owner], start, end, strict=True):
        if one != other:
            beside[i][one].add(other)
    ways = []
    for place in range(places.count):
        at = [found for found in beside if place in found]
        shared = at[0].keys() & at[-1].keys() if at else set()
        away = [found[place] - shared for found in at]
        ends = [next(iter(one)) for one in away if len(one) == 1]
        if len(at) != 2 or len(ends) != 2:
            ways.append(np.zeros((0, 3)))
            continue
        along = places.point[ends[1]] - places.point[ends[0]]
        ways.append((along / np.linalg.norm(along))[None])
    if not any(len(one) for one in ways):
        raise InputError(
            "no joint has ends that two blocks share",
            remedy="move vertices freely, or blocks as a whole",
        )
    return ways


def owners_of(assembly: Assembly) -> Ints:
    """The block (v,) of each vertex."""
    return Ragged.of([block.vertices for block in assembly.blocks]).owner


@dataclass(frozen=True, eq=False)
class BlockVertices:
    """The blocks of an assembly as one array of vertices.

    Attributes
    ----------
    assembly
    triangle : (t, 3) points of the triangles of all faces: fans about the means of their corners
    mean : (v + f, v) the points of the triangles: the vertices, and the means of faces with more
        than three corners
    """

    assembly: Assembly
    triangle: Ints
    mean: sparse.csr_matrix

    @classmethod
    def of(cls, assembly: Assembly) -> BlockVertices:
        """The vertices and triangles of an assembly."""
        faces, corners = assembly.faces, assembly.faces.corners
        total, loop = len(faces.point), faces.loop
        share = 1.0 / corners.counts[corners.owner]
        means = sparse.csr_matrix((share, loop, faces.start), (faces.count, total))
        return cls(
            assembly,
            np.stack([total + corners.owner, loop, loop[corners.following]], axis=1),
            sparse.csr_matrix(sparse.vstack([sparse.identity(total), means])),
        )

    @property
    def vertex(self) -> Floats:
        """(v, 3) [m] of all blocks, one after the other."""
        return self.assembly.faces.point

    @cached_property
    def of_block(self) -> Ragged:
        """The vertices of each block."""
        return Ragged.of([block.vertices for block in self.assembly.blocks])

    @cached_property
    def _triangle_owner(self) -> Ints:
        faces = self.assembly.faces
        return faces.owner[faces.corners.owner]

    def assembly_at(self, vertex: Floats) -> Assembly:
        """The assembly with its vertices (v, 3) elsewhere; blocks that do not move stay.

        Raises
        ------
        InputError
            A block would be turned inside out, or its surface would cross itself.
        """
        blocks = list(self.assembly.blocks)
        moved = []
        for i, block in enumerate(blocks):
            own = vertex[self.of_block[i]]
            if not np.array_equal(own, block.vertices):
                blocks[i] = replace_block(block, vertices=own, repairs=())
                if blocks[i].faces != block.faces:
                    raise InputError(
                        "would be turned inside out",
                        where=f"block '{block.name}'",
                        remedy="allow smaller moves",
                    )
                moved.append(blocks[i])
        for body, what in self_contacts(
            [one.vertices for one in moved], [one.faces for one in moved]
        ):
            raise InputError(
                f"its surface {what}",
                where=f"block '{moved[body].name}'",
                remedy="allow smaller moves",
            )
        return Assembly(tuple(blocks), self.assembly.fixed)

    def measures(self, vertex: Floats) -> tuple[Floats, Floats]:
        """Volumes (n,) [m3] and centroids (n, 3) [m] for vertices (v, 3)."""
        six, total, middle = self._tetrahedra(vertex)[3:]
        owner, count = self._triangle_owner, len(self.assembly)
        volume = np.bincount(owner, six, minlength=count) / 6.0
        moment = sum_by_owner(six[:, None] * total, owner, count)
        return volume, middle + moment / (24.0 * volume[:, None])

    def measures_pulled_back(
        self, vertex: Floats, by_volume: Floats, by_centroid: Floats
    ) -> Floats:
        """Derivative (v, 3) by the vertices, from those by volumes (n,) and centroids (n, 3)."""
        a, b, c, six, total, middle = self._tetrahedra(vertex)
        volume, centroid = self.measures(vertex)
        by_moment = by_centroid / volume[:, None]
        rest = by_volume - dot(by_moment, centroid - middle)
        moment = by_moment[self._triangle_owner]
        along = rest[self._triangle_owner] / 6.0 + dot(moment, total) / 24.0
        shared = moment * (six / 24.0)[:, None]
        out = np.zeros((self.mean.shape[0], 3))
        for k, (one, other) in enumerate(((b, c), (c, a), (a, b))):
            np.add.at(out, self.triangle[:, k], along[:, None] * cross(one, other) + shared)
        # the origin of each block moves with its vertices, and has no effect
        return self.mean.T @ out

    def _tetrahedra(self, vertex: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
        """Corners of the triangles about the middle of their block, six volumes, sums, middles."""
        middle = self.of_block.mean(vertex)
        local = self.mean @ (vertex - self.of_block.spread(middle))
        a, b, c = (local[self.triangle[:, k]] for k in range(3))
        return a, b, c, dot(a, cross(b, c)), a + b + c, middle
