"""The functions of compas_cra by their own names, on its own assemblies, solved by drystone.

Change one import line::

    from drystone.compat.compas_cra import assembly_interfaces_numpy, cra_solve

Assemblies are changed as compas_cra 0.8 changes them: interfaces are added to the edges, corner
forces are written to ``interface.forces``, displacements to the nodes. An assembly that does not
stand raises ``ValueError``. Weights are volume times density, gravity being one, as there. What
would be printed goes to the log of this module.
"""

from __future__ import annotations

import importlib
import logging
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.checks import corner_motion
from drystone.compat.compas import block_of, interface_frame
from drystone.contacts import Contacts
from drystone.detection import DetectionOptions, find_contacts
from drystone.geometry.arrays import Bools
from drystone.io.compas_contacts import joined
from drystone.loads import LoadCase
from drystone.results import Result, Verdict
from drystone.stability import (
    CRAOptions,
    FrictionCone,
    RBEOptions,
    solve_cra,
    solve_cra_penalty,
    solve_rbe,
)

_log = logging.getLogger(__name__)

WIDEST_GAP = 0.25
"""Largest gap asked of the contact search, relative to the block size, chosen: blocks must not be
joined across each other however large ``tmax`` is."""


@dataclass(frozen=True)
class _Read:
    """A COMPAS assembly as ours, and the way back."""

    assembly: Assembly
    contacts: Contacts
    interfaces: tuple[Any, ...]
    backwards: Bools
    nodes: tuple[Any, ...]


def assembly_interfaces_numpy(
    assembly: Any, nmax: int = 10, tmax: float = 1e-6, amin: float = 1e-1
) -> Any:
    """Find the interfaces between the blocks of an assembly and add them to its edges.

    Parameters
    ----------
    assembly
        ``CRA_Assembly``; changed in place.
    nmax
        Not needed: all neighbours are looked at.
    tmax : [m]
        Faces this far apart still touch, or further where the default of
        :class:`drystone.DetectionOptions` says so.
    amin : [m2]
        Smallest area of an interface.

    Returns
    -------
    The same assembly.
    """
    del nmax
    ours, nodes = _blocks(assembly, 1.0)
    size = float(np.median(np.cbrt(ours.volume)))
    gap = min(max(DetectionOptions().gap, float(tmax) / size), WIDEST_GAP)
    contacts = find_contacts(ours, options=DetectionOptions(gap=gap)).contacts
    frame_type: Any = importlib.import_module("compas.geometry").Frame  # there, as the assembly is
    known = {frozenset(edge) for edge in assembly.graph.edges()}
    for i in np.flatnonzero(contacts.area >= amin).tolist():
        a, b = int(contacts.block_a[i]), int(contacts.block_b[i])
        both_fixed = bool(ours.fixed[a] and ours.fixed[b])
        if both_fixed or frozenset((nodes[a], nodes[b])) in known:
            continue
        _, u, v = contacts.frame[i].tolist()
        assembly.add_to_interfaces(
            nodes[a],
            nodes[b],
            size=float(contacts.area[i]),
            points=contacts.polygon(i).tolist(),
            frame=frame_type(contacts.centroid[i].tolist(), u, v),
        )
    return assembly


def rbe_solve(
    assembly: Any,
    mu: float = 0.84,
    density: float = 1.0,
    verbose: bool = False,
    timer: bool = False,
) -> Any:
    """Rigid block equilibrium with penalised tension and the eight-sided cone.

    Parameters
    ----------
    assembly
        Changed in place: ``interface.forces``.
    mu
    density
        Where a block has no density of its own.
    verbose, timer
        Tell the log more.

    Returns
    -------
    The same assembly.

    Raises
    ------
    ValueError
        No forces were found.
    """
    read = _read(assembly, mu, density)
    begin = time.perf_counter()
    options = RBEOptions(cone=FrictionCone.octagon())
    load = LoadCase.gravity(read.assembly, 1.0)
    result = solve_rbe(read.assembly, read.contacts, load, options=options)
    _tell(result, begin, verbose, timer)
    return _write(assembly, read, result)


def cra_solve(
    assembly: Any,
    mu: float = 0.84,
    density: float = 1.0,
    d_bnd: float = 1e-3,
    eps: float = 1e-4,
    verbose: bool = False,
    timer: bool = False,
) -> Any:
    """Forces and displacements that fit together.

    Where it stands but no state with equal overlaps is found within ``d_bnd``, the state that was
    found is written, and that is logged.

    Parameters
    ----------
    assembly
        Changed in place: ``interface.forces`` and, at free nodes, ``displacement``.
    mu
    density
        Where a block has no density of its own.
    d_bnd, eps
        Bound of the displacements, and the overlap; only their ratio matters for the answer.
        Without an overlap displacements are written such that the largest is ``d_bnd``.
    verbose, timer
        Tell the log more.

    Returns
    -------
    The same assembly.

    Raises
    ------
    ValueError
        It does not stand, or that could not be decided.
    """
    read = _read(assembly, mu, density)
    begin = time.perf_counter()
    options = CRAOptions(slide_limit=d_bnd / eps if eps > 0.0 else float("inf"))
    load = LoadCase.gravity(read.assembly, 1.0)
    result = solve_cra(read.assembly, read.contacts, load, options=options)
    _tell(result, begin, verbose, timer)
    if result.verdict is not Verdict.STABLE:
        raise ValueError(f"solve failed: {result.verdict.value} ({result.message})")
    return _write(assembly, read, result, (eps, d_bnd))


def cra_penalty_solve(
    assembly: Any,
    mu: float = 0.84,
    density: float = 1.0,
    d_bnd: float = 1e-3,
    eps: float = 1e-4,
    verbose: bool = False,
    timer: bool = False,
) -> Any:
    """As :func:`cra_solve`, with tension where it does not stand: this one always answers.

    Parameters
    ----------
    assembly
        Changed in place: ``interface.forces`` (``c_nn`` is tension) and ``displacement``.
    mu, density, d_bnd, eps, verbose, timer
        As there.

    Returns
    -------
    The same assembly.

    Raises
    ------
    ValueError
        No forces were found.
    """
    read = _read(assembly, mu, density)
    begin = time.perf_counter()
    load = LoadCase.gravity(read.assembly, 1.0)
    result = solve_cra_penalty(read.assembly, read.contacts, load)
    _tell(result, begin, verbose, timer)
    return _write(assembly, read, result, (eps, d_bnd))


def density_setup(assembly: Any, density: Mapping[Any, float]) -> None:
    """Give blocks a density of their own, by node.

    Parameters
    ----------
    assembly
        Changed in place.
    density
        Nodes that are not named keep theirs.
    """
    for node in assembly.graph.nodes():
        if node in density:
            assembly.node_block(node).attributes["density"] = density[node]


def _blocks(assembly: Any, density: float) -> tuple[Assembly, tuple[Any, ...]]:
    nodes = tuple(assembly.graph.nodes())
    blocks = []
    for node in nodes:
        mesh = assembly.node_block(node)
        blocks.append(block_of(mesh, str(node), mesh.attributes.get("density", density)))
    fixed = [bool(assembly.graph.node_attribute(node, "is_support")) for node in nodes]
    return Assembly(tuple(blocks), np.array(fixed, dtype=bool)), nodes


def _read(assembly: Any, mu: float, density: float) -> _Read:
    ours, nodes = _blocks(assembly, density)
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
    return _Read(ours, contacts, tuple(interfaces), backwards, nodes)


def _write(
    assembly: Any, read: _Read, result: Result, scale: tuple[float, float] | None = None
) -> Any:
    """Forces per corner, in the order of the interface's points, and displacements."""
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


def _factor(eps: float, d_bnd: float, read: _Read, result: Result) -> float:
    """By how much displacements grow for pressed corners to overlap by ``eps``."""
    if result.force is None or result.displacement is None:
        return 1.0
    moved = corner_motion(read.assembly, read.contacts, result.displacement)
    if eps > 0.0:
        weight = np.maximum(result.force[:, 0], 0.0)
        now, wanted = float(-(weight @ moved[:, 0]) / max(weight.sum(), 1e-300)), eps
    else:
        now, wanted = float(np.abs(moved).max(initial=0.0)), d_bnd
    return wanted / now if now > 0.0 else 1.0


def _tell(result: Result, begin: float, verbose: bool, timer: bool) -> None:
    _log.info("result: %s, %s", result.verdict.value, result.message)
    if timer:
        _log.info("solving time: %.3f seconds", time.perf_counter() - begin)
    if verbose:
        _log.info("residuals: %s", result.residuals)
