"""Conversion of assemblies of compas_cra, and results written as compas_cra writes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools
from drystone.checks import corner_motion
from drystone.compat.compas import block_of, interface_frame
from drystone.contacts import Contacts
from drystone.io.compas_contacts import joined
from drystone.results import Result


@dataclass(frozen=True)
class Taken:
    """A converted COMPAS assembly, with the references needed to write results back."""

    assembly: Assembly
    contacts: Contacts
    interfaces: tuple[Any, ...]
    backwards: Bools
    nodes: tuple[Any, ...]


def blocks_of(assembly: Any, density: float) -> tuple[Assembly, tuple[Any, ...]]:
    """The blocks with their supports, and the node of each."""
    nodes = tuple(assembly.graph.nodes())
    blocks = []
    for node in nodes:
        mesh = assembly.node_block(node)
        blocks.append(block_of(mesh, str(node), mesh.attributes.get("density", density)))
    fixed = [bool(assembly.graph.node_attribute(node, "is_support")) for node in nodes]
    return Assembly(tuple(blocks), np.array(fixed, dtype=bool)), nodes


def taken(assembly: Any, mu: float, density: float) -> Taken:
    """The assembly with the interfaces of its edges.

    Raises
    ------
    ValueError
        No interfaces or no free blocks.
    """
    ours, nodes = blocks_of(assembly, density)
    position = {node: i for i, node in enumerate(nodes)}
    pairs, interfaces, corners, frames = [], [], [], []
    for a, b in assembly.graph.edges():
        for interface in assembly.graph.edge_attribute((a, b), "interfaces") or []:
            points = np.array([list(point) for point in interface.points], dtype=np.float64)
            pairs.append((position[a], position[b]))
            interfaces.append(interface)
            corners.append(points)
            frames.append(interface_frame(interface, points))
    if not interfaces or ours.fixed.all():
        raise ValueError("assembly has no contact interfaces or no free blocks")
    joint = np.array(pairs, dtype=np.intp)
    contacts, backwards = joined(joint[:, 0], joint[:, 1], corners, np.stack(frames), mu)
    return Taken(ours, contacts, tuple(interfaces), backwards, nodes)


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
