"""The functions of compas_cra under their own names, on its assemblies, solved by drystone.

Change the import line::

    from drystone.compat.compas_cra import (
        CRA_Assembly, assembly_interfaces_numpy, cra_solve, cra_view
    )

Assemblies are changed as compas_cra 0.8 changes them: interfaces are added to the edges, corner
forces are written to ``interface.forces``, displacements to the nodes. An assembly that does not
stand raises ``ValueError``. Weights are volume times density with a gravity of one, as in
compas_cra. Messages go to the log of this module.
"""

from __future__ import annotations

import importlib
import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from drystone.compat.compas import blocks_of, from_compas
from drystone.compat.cra_assembly import Taken, assembly_class, taken, write_back
from drystone.detection import DetectionOptions, find_contacts
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.programs import (
    CRAOptions,
    FrictionCone,
    RBEOptions,
    solve_cra,
    solve_cra_penalty,
    solve_rbe,
)
from drystone.results import Result
from drystone.view import scene_of, show

_log = logging.getLogger(__name__)

_WIDEST_GAP = 0.25
"""Largest gap of the contact search, relative to the block size, for any ``tmax``. Chosen: contacts
must not reach through blocks."""


def assembly_interfaces_numpy(
    assembly: Any, nmax: int = 10, tmax: float = 1e-6, amin: float = 1e-1
) -> Any:
    """Find the interfaces between the blocks of an assembly and add them to its edges.

    Parameters
    ----------
    assembly
        ``CRA_Assembly``; changed in place.
    nmax
        Not used: all neighbours are searched.
    tmax : [m]
        Largest distance of faces that touch. The default of
        :class:`drystone.detection.DetectionOptions` is used if it is larger.
    amin : [m2]
        Smallest area of an interface.

    Returns
    -------
    The same assembly.
    """
    del nmax
    nodes = list(assembly.graph.nodes())
    ours = blocks_of(assembly, nodes, 1.0)
    size = float(np.median(np.cbrt(ours.volume)))
    gap = min(max(DetectionOptions().gap, float(tmax) / size), _WIDEST_GAP)
    contacts = find_contacts(ours, options=DetectionOptions(gap=gap, inexact=False)).contacts
    frame_type: Any = importlib.import_module("compas.geometry").Frame  # installed
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
        Write more to the log.

    Returns
    -------
    The same assembly.

    Raises
    ------
    ValueError
        No forces were found.
    """
    solve = partial(solve_rbe, options=RBEOptions(cone=FrictionCone.octagon()))
    read, result = _solved(assembly, mu, density, solve, verbose, timer)
    return write_back(assembly, read, result)


def cra_solve(
    assembly: Any,
    mu: float = 0.84,
    density: float = 1.0,
    d_bnd: float = 1e-3,
    eps: float = 1e-4,
    verbose: bool = False,
    timer: bool = False,
) -> Any:
    """Compatible forces and displacements.

    If no state with equal overlaps is found within ``d_bnd``, another rest state is written, with a
    line in the log.

    Parameters
    ----------
    assembly
        Changed in place: ``interface.forces`` and, at free nodes, ``displacement``.
    mu
    density
        Where a block has no density of its own.
    d_bnd, eps
        Bound of the displacements, and the overlap. Only their ratio changes the answer. With a
        zero overlap the displacements are scaled so that the largest is ``d_bnd``.
    verbose, timer
        Write more to the log.

    Returns
    -------
    The same assembly.

    Raises
    ------
    ValueError
        The assembly does not stand, or this is undecided.
    """
    options = CRAOptions(slide_limit=d_bnd / eps if eps > 0.0 else float("inf"))
    solve = partial(solve_cra, options=options)
    read, result = _solved(assembly, mu, density, solve, verbose, timer)
    if not result.stable:
        raise ValueError(f"solve failed: {result.verdict.value} ({result.message})")
    return write_back(assembly, read, result, (eps, d_bnd))


def cra_penalty_solve(
    assembly: Any,
    mu: float = 0.84,
    density: float = 1.0,
    d_bnd: float = 1e-3,
    eps: float = 1e-4,
    verbose: bool = False,
    timer: bool = False,
) -> Any:
    """As :func:`cra_solve`, with tension where the assembly does not stand.

    Parameters
    ----------
    assembly
        Changed in place: ``interface.forces`` (``c_nn`` is tension) and ``displacement``.
    mu, density, d_bnd, eps, verbose, timer
        As in :func:`cra_solve`.

    Returns
    -------
    The same assembly.

    Raises
    ------
    ValueError
        No forces were found.
    """
    read, result = _solved(assembly, mu, density, solve_cra_penalty, verbose, timer)
    return write_back(assembly, read, result, (eps, d_bnd))


def cra_view(
    assembly: Any,
    scale: float = 1.0,
    density: float = 1.0,
    dispscale: float = 1.0,
    tol: float = 1e-5,
    grid: bool = False,
    resultant: bool = True,
    nodal: bool = False,
    edge: bool = True,
    blocks: bool = True,
    interfaces: bool = True,
    forces: bool = True,
    forcesdirect: bool = True,
    forcesline: bool = False,
    weights: bool = True,
    displacements: bool = True,
) -> None:
    """Open the page of an assembly, with its forces and displacements where it was solved.

    Parameters
    ----------
    assembly
    interfaces, forces, resultant, nodal, displacements
        What is shown at first of interfaces, all forces, resultants, forces at corners and virtual
        displacements.
    scale, density, dispscale, tol, grid, edge, blocks, forcesdirect, forcesline, weights
        Not used: the page scales what it shows, and has buttons for the rest.

    Raises
    ------
    InputError
        There is no browser; the error names the page.
    """
    del scale, density, dispscale, tol, grid, edge, blocks, forcesdirect, forcesline, weights
    read = from_compas(assembly)
    scene = scene_of(read.results[0]) if read.results else scene_of(read.assembly, read.contacts)
    hidden = {
        "interfaces": not interfaces,
        "resultants": not (forces and resultant),
        "network": not forces,
        "pressure": not (forces and nodal),
        "tension": not (forces and nodal),
    }
    stages = tuple(
        replace(
            stage,
            motion=stage.motion if displacements else None,
            layers=tuple(one for one in stage.layers if not hidden.get(one.key)),
        )
        for stage in scene.stages
    )
    show(replace(scene, stages=stages))


def density_setup(assembly: Any, density: Mapping[Any, float]) -> None:
    """Give blocks a density, by node.

    Parameters
    ----------
    assembly
        Changed in place.
    density
        Other nodes keep their density.
    """
    for node in assembly.graph.nodes():
        if node in density:
            assembly.node_block(node).attributes["density"] = density[node]


def _solved(
    assembly: Any,
    mu: float,
    density: float,
    solve: Callable[[Model], Result],
    verbose: bool,
    timer: bool,
) -> tuple[Taken, Result]:
    """The converted assembly and the result of a solver, with log messages."""
    read = taken(assembly, mu, density)
    begin = time.perf_counter()
    result = solve(Model(read.assembly, read.contacts, LoadCase.gravity(read.assembly, 1.0)))
    _log.info("result: %s, %s", result.verdict.value, result.message)
    if timer:
        _log.info("solving time: %.3f seconds", time.perf_counter() - begin)
    if verbose:
        _log.info("residuals: %s", result.residuals)
    return read, result


def __getattr__(name: str) -> Any:
    """The class ``CRA_Assembly``, made when it is asked for: it needs compas_assembly."""
    if name == "CRA_Assembly":
        return assembly_class()
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")


__all__ = [
    "assembly_interfaces_numpy",
    "cra_penalty_solve",
    "cra_solve",
    "cra_view",
    "density_setup",
    "rbe_solve",
]
