"""Data of blocks for simulators: convex pieces about the centroid, mass and inertia."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np

from drystone.assembly import Block
from drystone.base.arrays import Floats, Ints, dot
from drystone.base.errors import InputError
from drystone.geometry.apart import PLANE, levelled, set_apart
from drystone.geometry.convex_pieces import ConvexPiece, convex_pieces, hull_of, solid_of
from drystone.geometry.polyhedron import stack_faces
from drystone.geometry.triangulate import fan_warped
from drystone.io.draft import Contents
from drystone.model import Model

_SLACK = 0.02
"""Dents of blocks with warped faces that are filled, by the size of the block. Measured: with half
of it a dome of 237 warped voussoirs has 764 pieces in place of 432, of which thin ones end up to
8 mm inside a neighbour. Blocks with plane faces are divided exactly."""
_TOLD = 1e-4
"""[m] Blocks that were nearer to touching are cut back without a word. Chosen: the depth at which a
simulator begins to push them apart visibly."""
_SAME_ACCELERATION = 1e-6
"""Largest relative difference of the accelerations of blocks that count as one gravity."""


@dataclass(frozen=True, eq=False)
class SimulatorBody:
    """A block for a simulator. Its frame has its origin at the centroid and the world's axes.

    Attributes
    ----------
    name
        Letters, digits, dots, dashes and underscores.
    fixed
    place : (3,) [m]
        Of its centroid.
    mass : [kg]
    inertia : (3, 3) [kg m2]
        About the centroid.
    pieces
        Per convex piece its corners (p, 3) [m] and its triangles (t, 3), outwards.
    """

    name: str
    fixed: bool
    place: Floats
    mass: float
    inertia: Floats
    pieces: tuple[tuple[Floats, Ints], ...]


def bodies(model: Model) -> tuple[list[SimulatorBody], str]:
    """The blocks of a model, in their order, and a remark on how far they are from rest.

    No piece begins inside one of another block; see :mod:`drystone.geometry.apart`. The remark says
    how deep they were drawn in each other, and how wide the widest gap is that a block crosses
    first.
    """
    assembly = model.assembly
    names = _plain_names(assembly.names)
    every = [_pieces(block) for block in assembly.blocks]
    owner = np.repeat(np.arange(len(every)), [len(own) for own in every])
    pieces, deepest = set_apart(
        [piece for own in every for piece in own], owner, assembly.fixed[owner]
    )
    out = []
    for i, block in enumerate(assembly.blocks):
        left = [piece for k in np.flatnonzero(owner == i) if (piece := pieces[k]) is not None]
        own = tuple(hull_of(piece.point - block.centroid) for piece in left)
        inertia, fixed = _inertia(block, own), bool(assembly.fixed[i])
        out.append(SimulatorBody(names[i], fixed, block.centroid, block.mass, inertia, own))
    said = []
    if deepest >= _TOLD:
        said.append(f"blocks up to {1e3 * deepest:.2g} mm inside each other are cut back")
    widest = _widest_gap(out, model)
    if widest >= _TOLD:
        said.append(f"blocks with a joint begin up to {1e3 * widest:.2g} mm apart")
    return out, "; ".join(said)


def _widest_gap(found: Sequence[SimulatorBody], model: Model) -> float:
    """The largest of the distances [m] between two blocks that have a joint."""
    solids = [
        manifold3d.Manifold.compose(
            [solid_of(at + one.place, face.tolist()) for at, face in one.pieces]
        )
        for one in found
    ]
    contacts = model.contacts
    pairs = np.unique(np.c_[contacts.block_a, contacts.block_b], axis=0)
    reach = [float(model.assembly.blocks[i].size) for i in range(len(found))]
    gaps = [solids[a].min_gap(solids[b], min(reach[a], reach[b])) for a, b in pairs.tolist()]
    return max(gaps, default=0.0)


def _pieces(block: Block) -> list[ConvexPiece]:
    """Convex pieces of a block, in the world."""
    level = levelled(block.vertices, block.faces)
    if level is not None:
        return [level]
    fan = fan_warped(stack_faces([block.vertices], [block.faces]), PLANE)
    loops = np.split(fan.loop, fan.start[1:-1])
    slack = _SLACK if len(fan.point) > len(block.vertices) else 0.0
    return convex_pieces(fan.point, [tuple(loop) for loop in loops], slack)


def model_of(contents: Contents) -> Model:
    """The model of what is written, its contacts found if there are none."""
    assembly, load = contents.assembly, next(iter(contents.loads), None)
    if contents.contacts is None:
        return Model.of(assembly, load=load, anyway=True)
    made = Model(assembly, contents.contacts)
    return made if load is None else made.with_load(load)


def gravity_of(model: Model) -> Floats:
    """The acceleration (3,) [m/s2] that the load gives to all free blocks.

    Raises
    ------
    InputError
        The load differs from block to block, or has moments.
    """
    free = model.assembly.free
    if not len(free):
        return np.array([0.0, 0.0, -9.81])
    wrench = model.load.wrench[free]
    each = wrench[:, :3] / model.assembly.mass[free][:, None]
    common: Floats = each[0]
    scale = max(float(np.abs(each).max()), 1e-300)
    alike = np.abs(each - common).max() <= _SAME_ACCELERATION * scale
    if not alike or np.abs(wrench[:, 3:]).max() > 1e-9 * np.abs(wrench).max():
        raise InputError(
            f"the load case '{model.load.name}' is not a uniform acceleration",
            where="load",
            remedy="give a load that accelerates all masses equally, or model loads as blocks",
        )
    return common


def _plain_names(names: tuple[str, ...]) -> list[str]:
    """Names that are valid in every format, all different; ``world`` is that of the ground."""
    out: list[str] = ["world"]
    for i, name in enumerate(names):
        plain = re.sub(r"[^A-Za-z0-9._-]", "_", name)
        out.append(plain if plain not in out and plain == name else f"{plain}_{i}")
    return out[1:]


def _inertia(block: Block, pieces: tuple[tuple[Floats, Ints], ...]) -> Floats:
    """(3, 3) [kg m2] about the centroid: tetrahedra from it to the triangles of the pieces."""
    second, volume = np.zeros((3, 3)), 0.0
    for point, triangle in pieces:
        corner = point[triangle]
        six = dot(corner[:, 0], np.cross(corner[:, 1], corner[:, 2]))
        total = corner.sum(axis=1)
        moment = np.einsum("tki,tkj->tij", corner, corner) + np.einsum("ti,tj->tij", total, total)
        second += np.einsum("t,tij->ij", six, moment) / 120.0
        volume += float(six.sum()) / 6.0
    second *= block.mass / volume
    inertia: Floats = np.trace(second) * np.eye(3) - second
    return inertia
