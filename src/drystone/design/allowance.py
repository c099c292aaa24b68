"""Blocks made smaller at their joints, to be fabricated with something between them."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np
import shapely

from drystone.assembly import Assembly, Block
from drystone.base.arrays import SAME
from drystone.base.errors import InputError, counted
from drystone.design.joint_cut import block_with
from drystone.design.surgery import CornerError, face_planes, in_joints, with_moved_faces
from drystone.free_faces import NEAR
from drystone.geometry.convex_pieces import mesh_of, solid_of
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.glue import glue
from drystone.geometry.planar import parts_of
from drystone.geometry.polyhedron import loop_edges, stack_faces
from drystone.geometry.selfcontact import self_contacts
from drystone.geometry.triangulate import fan_warped
from drystone.model import Model


def joint_allowance(model: Model, allowance: float) -> Assembly:
    """The blocks to fabricate: each face in a joint is moved inward by half the allowance.

    So each joint of faces is open by the allowance along its normal; a support gives its half like
    any block. Faces of a block in one plane move together, others stay in their planes. Where more
    faces meet at a corner than can move together, as on notched and on facetted blocks, a layer of
    that depth is cut off behind each face instead. Where blocks touch along an edge or at a corner
    only, nothing moves. Gaps that are drawn stay and are
    added. Analyses are of the model as it is, without the allowance.

    Parameters
    ----------
    model
    allowance : [m] > 0
        At the scale of the model: the thickness of what lies in each joint.

    Raises
    ------
    InputError
        The allowance is not above zero, or so large that a face or an edge would be swallowed or a
        block would cross itself or fall apart; or no faces touch.

    Examples
    --------
    >>> from drystone.models import tower
    >>> made = joint_allowance(Model.of(tower(3), friction=0.6), 0.01)
    >>> [round(float(high - low), 6) for low, high in made.bounds[:, :, 2]]
    [0.995, 0.99, 0.995]

    Notes
    -----
    Source: Kao 2023, section 7.2.4: sandpaper of 0.58 mm between printed blocks.
    """
    assembly = model.assembly
    blocks, bound = list(assembly.blocks), in_joints(model, 2.0 * NEAR)
    for i, body in enumerate(blocks):
        joined = np.flatnonzero(bound[assembly.faces.owner == i]).tolist()
        if joined:
            try:
                back = dict.fromkeys(joined, -0.5 * allowance)
                (blocks[i],) = with_moved_faces([body], [back])
            except CornerError:
                blocks[i] = _cut_back(body, joined, 0.5 * allowance)
    moved = [i for i, body in enumerate(blocks) if body is not assembly.blocks[i]]
    if not moved:
        raise InputError("no faces touch", remedy="give a model with joints of faces")
    for one, what in self_contacts(
        [blocks[i].vertices for i in moved], [blocks[i].faces for i in moved]
    ):
        raise InputError(
            f"with the joint allowance it {what}",
            where=f"block '{blocks[moved[one]].name}'",
            remedy="give a smaller one",
        )
    return Assembly(tuple(blocks), assembly.fixed)


def _cut_back(body: Block, joined: Sequence[int], depth: float) -> Block:
    """A block without a layer of some depth [m] behind each of some faces."""
    near = NEAR * SAME * body.size
    whole = fan_warped(stack_faces([body.vertices], [body.faces]), SAME)
    loops = [tuple(loop.tolist()) for loop in np.split(whole.loop, whole.start[1:-1])]
    solids = [
        solid_of(whole.point, loops),
        *(_layer(body, face, joined, depth) for face in joined),
    ]
    left = manifold3d.Manifold.batch_boolean(
        [one.set_tolerance(near) for one in solids], manifold3d.OpType.Subtract
    )
    point, triangle = mesh_of(left.as_original().simplify(near))
    pieces = glue([(point, [tuple(corners) for corners in triangle.tolist()])])
    if len(pieces) != 1:
        raise InputError(
            f"the joint allowance would leave {counted(len(pieces), 'piece')} of it",
            where=f"block '{body.name}'",
            remedy="give a smaller one",
        )
    return block_with(body, pieces[0])


def _layer(body: Block, face: int, joined: Sequence[int], depth: float) -> manifold3d.Manifold:
    """What lies less than a depth [m] behind a face, over its edges too.

    Not over an edge from which a face rises that does not move: that one is only prolonged.
    """
    loop = body.faces[face]
    normals, offsets = face_planes(body)
    corner, normal, offset = body.vertices[list(loop)], normals[face], offsets[face]
    frame = frames_from_normals(normal[None])[0]
    flat = corner @ frame[1:].T
    shape = shapely.Polygon(flat)
    wide = shape.buffer(depth, join_style="mitre", mitre_limit=2.0)
    beside = {edge: k for k, one in enumerate(body.faces) for edge in loop_edges(one)}
    for (a, b), start, end in zip(loop_edges(loop), flat, np.roll(flat, -1, axis=0), strict=True):
        other = beside[b, a]
        along = (end - start) / np.linalg.norm(end - start)
        aside = np.array([along[1], -along[0]])
        if other in joined or normals[other] @ (aside @ frame[1:]) > -SAME:
            continue
        reach, ends = 2.0 * depth * aside, (start - depth * along, end + depth * along)
        strip = shapely.Polygon([*ends, ends[1] + reach, ends[0] + reach])
        wide = wide.difference(strip)
    rings = [
        np.array(ring.coords)[:-1]
        for part in parts_of(shapely.union(wide, shape), "Polygon")
        for ring in (part.exterior, *part.interiors)
    ]
    above = depth + float(np.abs(corner @ normal - offset).max())
    section = manifold3d.CrossSection(rings, manifold3d.FillRule.EvenOdd)
    place = np.column_stack([frame[1], frame[2], frame[0], (offset - depth) * normal])
    return manifold3d.Manifold.extrude(section, depth + above).transform(place)
