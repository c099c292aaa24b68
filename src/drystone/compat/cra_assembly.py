"""Conversion of assemblies of compas_cra, and results written as compas_cra writes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools
from drystone.checks import corner_motion
from drystone.compat.compas import blocks_of, interfaces_of, joined_interfaces
from drystone.contacts import Contacts
from drystone.results import Result


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
