"""The assembly of compas_cra: its class, its conversion, and results written as it writes them."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools
from drystone.base.errors import require
from drystone.checks import corner_motion
from drystone.compat.compas import blocks_of, interfaces_of, joined_interfaces
from drystone.contacts import Contacts
from drystone.results import Result


class _Interfaces:
    """What an assembly of compas_cra has beyond one of compas_assembly."""

    graph: Any

    def add_to_interfaces(self, u: Any, v: Any, size: float, points: Any, frame: Any) -> None:
        """Add an interface to those of the edge from ``u`` to ``v``."""
        made = _of_compas("compas_assembly.datastructures").Interface
        self.add_interface_to_interfaces(u, v, made(size=size, points=points, frame=frame))

    def add_interface_to_interfaces(self, u: Any, v: Any, interface: Any) -> None:
        """Add an interface that exists."""
        if v not in self.graph.edge.get(u, {}):
            self.graph.add_edge(u, v, interfaces=[])
        there = self.graph.edge_attribute((u, v), "interfaces") or []
        self.graph.edge_attribute((u, v), "interfaces", [*there, interface])

    def add_interfaces_from_meshes(self, meshes: Iterable[Any], u: Any, v: Any) -> None:
        """Add an interface for each face of some meshes: those of a curved joint."""
        frame = _of_compas("compas.geometry").Frame
        for mesh in meshes:
            for face in mesh.faces():
                points = mesh.face_coordinates(face)
                plane = frame.from_points(*points[:3])
                self.add_to_interfaces(u, v, mesh.face_area(face), points, plane)

    def set_boundary_conditions(self, keys: Iterable[Any]) -> None:
        """Make supports of the blocks of some nodes."""
        for key in keys:
            self.set_boundary_condition(key)

    def set_boundary_condition(self, key: Any) -> None:
        """Make a support of the block of a node."""
        self.graph.node_attribute(key, "is_support", True)

    def is_block_support(self, key: Any) -> bool:
        """Whether the block of a node is a support."""
        return bool(self.graph.node_attribute(key, "is_support"))

    def rotate_assembly(self, o: Any, axis: Any, rad: float) -> None:
        """Turn blocks and interfaces about an axis through ``o`` [rad]."""
        turn = _of_compas("compas.geometry").Rotation.from_axis_and_angle(axis, rad, point=o)
        for node in self.graph.nodes():
            self.graph.node_attribute(node, "block").transform(turn)
        for edge in self.graph.edges():
            for interface in self.graph.edge_attribute(edge, "interfaces") or []:
                corners = _of_compas("compas.geometry").transform_points(interface.points, turn)
                interface.points = [list(corner) for corner in corners]
                interface.frame.transform(turn)

    def move_block(self, key: Any, vector: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Move the block of a node."""
        by = _of_compas("compas.geometry").Translation.from_vector(list(vector))
        self.graph.node_attribute(key, "block").transform(by)

    def get_weight_total(self, density: float = 1.0) -> float:
        """Weight of all blocks with a gravity of one."""
        blocks = [self.graph.node_attribute(node, "block") for node in self.graph.nodes()]
        return float(density * sum(block.volume() for block in blocks))

    def get_weight_mean(self, density: float = 1.0) -> float:
        """Mean weight of a block with a gravity of one."""
        return self.get_weight_total(density) / max(len([*self.graph.nodes()]), 1)


@cache
def assembly_class() -> type[Any]:
    """The class ``CRA_Assembly``, made of the Assembly of compas_assembly.

    Raises
    ------
    MissingDependency
        compas_assembly is not installed.
    """
    base = _of_compas("compas_assembly.datastructures").Assembly
    own = {name: value for name, value in vars(_Interfaces).items() if callable(value)}
    # the name of the type in files: COMPAS reads them where drystone is not installed
    names = dict.fromkeys(("__dtype__", "dtype"), "compas_assembly.datastructures/Assembly")
    return type("CRA_Assembly", (base,), {**own, **names, "__doc__": _Interfaces.__doc__})


def _of_compas(name: str) -> Any:
    """A module of COMPAS."""
    require(name.partition(".")[0], "compas", "CRA_Assembly")
    return importlib.import_module(name)


@dataclass(frozen=True)
class Taken:
    """A converted COMPAS assembly, with the references needed to write results back."""

    assembly: Assembly
    contacts: Contacts
    interfaces: tuple[Any, ...]
    backwards: Bools
    nodes: tuple[Any, ...]


def taken(assembly: Any, mu: float, density: float) -> Taken:
    """The assembly with the interfaces of its edges.

    Raises
    ------
    ValueError
        No interfaces or no free blocks.
    """
    nodes = tuple(assembly.graph.nodes())
    ours = blocks_of(assembly, nodes, density)
    found = interfaces_of(assembly.graph, nodes, "interfaces")
    if not found or ours.fixed.all():
        raise ValueError("assembly has no contact interfaces or no free blocks")
    contacts, backwards = joined_interfaces(found, mu)
    return Taken(ours, contacts, tuple(stored for _, _, stored in found), backwards, nodes)


def write_back(
    assembly: Any, read: Taken, result: Result, scale: tuple[float, float] | None = None
) -> Any:
    """Forces per corner, in the order of the interface's points, and displacements.

    Parameters
    ----------
    assembly
        Changed in place.
    read
    result
    scale
        Overlap of corners in compression, or the largest displacement if the overlap is zero.

    Raises
    ------
    ValueError
        There are no forces.
    """
    if result.force is None:
        raise ValueError(f"solve failed: {result.verdict.value} ({result.message})")
    pull = np.zeros(len(result.force)) if result.tension is None else result.tension
    push = np.maximum(result.force[:, 0] + pull, 0.0)
    start = read.contacts.start
    for i, interface in enumerate(read.interfaces):
        rows = list(range(start[i], start[i + 1]))
        interface.forces = [
            {
                "c_np": float(push[k]),
                "c_nn": float(pull[k]),
                "c_u": float(result.force[k, 1]),
                "c_v": float(result.force[k, 2]),
            }
            for k in (rows[::-1] if read.backwards[i] else rows)
        ]
    if scale is not None and result.displacement is not None:
        moved = result.displacement * _factor(*scale, read, result)
        for i in read.assembly.free.tolist():
            assembly.graph.node_attribute(read.nodes[i], "displacement", moved[i].tolist())
    return assembly


def _factor(eps: float, d_bnd: float, read: Taken, result: Result) -> float:
    """The factor on displacements with which corners in compression overlap by ``eps``."""
    if result.force is None or result.displacement is None:
        return 1.0
    moved = corner_motion(read.assembly, read.contacts, result.displacement)
    if eps > 0.0:
        weight = np.maximum(result.force[:, 0], 0.0)
        now, wanted = float(-(weight @ moved[:, 0]) / max(weight.sum(), 1e-300)), eps
    else:
        now, wanted = float(np.abs(moved).max(initial=0.0)), d_bnd
    return wanted / now if now > 0.0 else 1.0
