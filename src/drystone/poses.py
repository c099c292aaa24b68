"""Resting poses: on which faces of its convex hull one block stands on a plane.

A body stands on a facet of its hull where the foot of its centroid lies within it. Put down at
random it rolls over edges of the others, each over the edge beyond which the foot lies farthest,
until it stands; the share of a pose is the solid angle of all facets that end in it, as seen from
the centroid. Source: Goldberg, Mirtich, Zhuang, Craig, Carlisle, Canny 1999, Part pose statistics:
estimators and experiments, the quasi-static estimator.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Unpack

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.answer.drawing import bare_scene
from drystone.assembly import Assembly, Block
from drystone.assembly.block import require_sound
from drystone.base.arrays import ROUNDING, Bools, Floats, dot, frozen, unit
from drystone.base.errors import InputError, counted
from drystone.base.ragged import linked, sum_by_owner
from drystone.base.settings import checked_call
from drystone.base.table import Table
from drystone.geometry.solid import solid_angles
from drystone.io.opening import Given
from drystone.io.registry import FileOptions, files_at, read_file
from drystone.io.several import digest_of, is_paths, place_of
from drystone.mesh_objects import assembly_of
from drystone.model import Model, Origin
from drystone.supports import GroundPlane

__all__ = ["Poses", "find_poses"]

_DRAWN = 24
"""Poses in a picture; the others are in the table."""


@dataclass(frozen=True, eq=False)
class Poses(Answer):
    """The poses in which a block stands on a plane, the likeliest first.

    Attributes
    ----------
    block
    transform : (p, 4, 4)
        Moves the block into each pose: the plane is z = 0, the centroid above the origin.
    share : (p,)
        Probability that it ends so when it is put down at random, and slowly.
    tilt_to_topple : (p,) [degrees]
        Tilt of the plane at which it topples over the nearest edge; friction holds it.
    height : (p,) [m]
        Of the centroid.
    origin
        The file of the block.
    """

    block: Block
    transform: Floats
    share: Floats
    tilt_to_topple: Floats
    height: Floats
    origin: Origin = field(default_factory=Origin)

    @cached_property
    def model(self) -> Model:
        """The block in its poses side by side, on a plane of ground."""
        copies, x = [], 0.0
        for number, pose in enumerate(self.transform[:_DRAWN], start=1):
            one = self.block.transformed(pose[:3, :3], pose[:3, 3])
            half = 0.75 * float(one.bounds[1, 0] - one.bounds[0, 0])
            moved = one.transformed(None, (x - float(one.bounds[0, 0]), 0.0, 0.0))
            copies.append(moved.renamed(f"pose-{number}"))
            x += 2.0 * half
        row = Assembly(tuple(copies), np.zeros(len(copies), dtype=bool))
        return replace(Model.of(row, supports=GroundPlane(0.0)), origin=self.origin)

    @property
    def title(self) -> str:
        """How many poses there are."""
        return f"'{self.block.name}' stands in {counted(len(self.share), 'pose')}"

    def sentences(self) -> Sequence[Sentence]:
        """How many poses, and the likeliest of them."""
        likeliest = (
            f"put down at random it ends in pose 1 with {100.0 * self.share[0]:.3g} %, where it "
            f"bears a tilt of {self.tilt_to_topple[0]:.3g} degrees"
        )
        firmest = int(np.argmax(self.tilt_to_topple))
        told = [Sentence(self.title, Role.GOOD), Sentence(likeliest)]
        if firmest:
            most = f"pose {firmest + 1} bears most: {self.tilt_to_topple[firmest]:.3g} degrees"
            told.append(Sentence(most))
        if len(self.share) > _DRAWN:
            told.append(Sentence(f"pictures show the first {_DRAWN}", Role.REMARK))
        return told

    def tables(self) -> Sequence[Table]:
        """The poses."""
        columns = {
            "pose": np.arange(1, len(self.share) + 1),
            "share": self.share,
            "tilt_to_topple": self.tilt_to_topple,
            "height": self.height,
        }
        return (
            Table("poses", columns, {"share": "1", "tilt_to_topple": "degrees", "height": "m"}),
        )

    def layers(self) -> Scene:
        """The poses side by side."""
        scene = bare_scene(self.model)
        number = np.where(self.assembly.fixed, 0, np.arange(1, len(self.assembly) + 1))
        stage = replace(scene.stages[0], headline=self.title, message=self.sentences()[1].text)
        return replace(scene, title=self.title, stages=(stage,), number=number)

    def numbers(self) -> Mapping[str, Any]:
        """The name of the block, and the matrix of each pose."""
        return {"block": self.block.name, "transform": self.transform}


@checked_call
def find_poses(
    given: Block | Given, *, block: int | str | None = None, **how: Unpack[FileOptions]
) -> Poses:
    """The poses on a plane in which one block stands.

    Parameters
    ----------
    given
        A block; or a model, an assembly, a mesh of another package, or a file.
    block
        Which block of several, by name or position; the only free one when left out.
    how
        Of a file only; see :class:`drystone.io.registry.FileOptions`.

    Raises
    ------
    InputError
        There are several blocks and none is named, the file cannot be read, or ``how`` is given
        for what is no file.

    Examples
    --------
    >>> from drystone.models import box
    >>> found = find_poses(box((1.0, 1.0, 2.0)))
    >>> len(found.share), found.tilt_to_topple.round(1).tolist()
    (6, [45.0, 45.0, 45.0, 45.0, 26.6, 26.6])
    >>> round(float(found.share[0]), 3)
    0.218
    """
    if how and not is_paths(given):
        raise InputError("is of files", where=next(iter(how)), remedy="leave it out")
    origin = Origin()
    if isinstance(given, Block):
        return _found(given, origin)
    if is_paths(given):
        assembly = read_file(given, **how).assembly
        origin = Origin(str(place_of(given)), digest_of(files_at(given)))
    else:
        assembly = given.assembly if isinstance(given, Model) else assembly_of(given)
    if block is None:
        some = assembly.free if len(assembly.free) == 1 else np.arange(len(assembly))
        if len(some) > 1:
            raise InputError(
                f"there are {len(some)} blocks, and one is looked at",
                where="block",
                remedy=f"name it, such as --block {assembly.names[0]} (block= in Python)",
            )
        return _found(assembly.blocks[int(some[0])], origin)
    return _found(assembly.blocks[int(assembly.indices([block])[0])], origin)


def _found(block: Block, origin: Origin) -> Poses:
    require_sound([block])
    point = block.vertices - block.centroid
    normal, height, share, stands, foot = _facets(point)
    kept = np.flatnonzero(stands)
    kept = kept[np.argsort(-share[kept].round(9), kind="stable")]
    pose = np.tile(np.eye(4), (len(kept), 1, 1))
    down = np.array([[0.0, 0.0, -1.0]])
    for i, facet in enumerate(kept.tolist()):
        turn = Rotation.align_vectors(down, normal[facet][None])[0].as_matrix()
        pose[i, :3, :3] = turn
        pose[i, :3, 3] = np.array([0.0, 0.0, height[facet]]) - turn @ block.centroid
    tilt = np.rad2deg(np.arctan2(foot[kept], height[kept]))
    height, share = height[kept], share[kept]
    return Poses(block, frozen(pose), frozen(share), frozen(tilt), frozen(height), origin)


def _facets(point: Floats) -> tuple[Floats, Floats, Floats, Bools, Floats]:
    """Facets of the convex hull of points (p, 3) about their origin, the centroid.

    Returns
    -------
    normal : (f, 3) unit, outward
    height : (f,) [m]
        Of the centroid above each.
    share : (f,)
        Probability that it ends there.
    stands : (f,)
    foot : (f,) [m]
        How far inside the foot of the centroid is.
    """
    hull = ConvexHull(point)
    normal, plane = hull.equations[:, :3], -hull.equations[:, 3]
    near = hull.neighbors.astype(np.intp)
    row = np.repeat(np.arange(len(near)), 3)
    same = dot(normal[row], normal[near.ravel()]) > 1.0 - ROUNDING
    group = linked(row[same], near.ravel()[same], len(near))
    count = int(group.max()) + 1
    corner = point[hull.simplices]
    double = np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    mean = unit(sum_by_owner(normal * double[:, None], group, count))[0]
    height = np.full(count, -np.inf)
    np.maximum.at(height, group, plane)
    angle = np.bincount(group, np.abs(solid_angles(np.zeros(3), corner)))
    # the neighbour k of a simplex lies across the edge opposite to its corner k
    side, k = np.nonzero(group[near] != group[:, None])
    start, end = corner[side, (k + 1) % 3], corner[side, (k + 2) % 3]
    home = group[side]
    across = unit(np.cross(end - start, mean[home]))[0]
    outward = np.sign(dot(across, start - corner[side, k]))[:, None] * across
    inside = dot(start - height[home, None] * mean[home], outward)
    beyond = group[near[side, k]]
    order = np.lexsort((inside, home))
    first = order[np.unique(home[order], return_index=True)[1]]
    foot, target = inside[first], beyond[first]
    stands = (foot > 0.0) | (height[target] >= height)
    share = angle / angle.sum()
    for facet in np.argsort(-height).tolist():  # it rolls to lower ones only
        if not stands[facet]:
            share[target[facet]] += share[facet]
    return mean, height, np.where(stands, share, 0.0), stands, np.maximum(foot, 0.0)
