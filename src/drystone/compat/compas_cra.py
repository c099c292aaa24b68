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
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from drystone.base.arrays import lengths
from drystone.base.errors import require
from drystone.base.settings import hold
from drystone.checks import corner_motion
from drystone.compat.compas import blocks_of, from_compas, interfaces_of, joined_interfaces
from drystone.detection import DetectionOptions, find_contacts
from drystone.io.compas_contacts import COMPONENTS
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

__all__ = [
    "assembly_interfaces_numpy",
    "cra_penalty_solve",
    "cra_solve",
    "cra_view",
    "density_setup",
    "rbe_solve",
]

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
        Friction coefficient of all joints.
    density
        Where a block has no density of its own.
    verbose, timer
        Not used: the log has the result.

    Returns
    -------
    The same assembly.

    Raises
    ------
    ValueError
        No forces were found.
    """
    del verbose, timer
    solve = partial(solve_rbe, options=RBEOptions(cone=FrictionCone.octagon()))
    return _solved(assembly, mu, density, solve)


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
        Friction coefficient of all joints.
    density
        Where a block has no density of its own.
    d_bnd, eps
        Bound of the displacements, and the overlap. Only their ratio changes the answer. With a
        zero overlap the displacements are scaled so that the largest is ``d_bnd``.
    verbose, timer
        Not used: the log has the result.

    Returns
    -------
    The same assembly.

    Raises
    ------
    ValueError
        The assembly does not stand, or this is undecided.
    """
    del verbose, timer
    options = CRAOptions(slide_limit=d_bnd / eps if eps > 0.0 else float("inf"))
    solve = partial(solve_cra, options=options)
    return _solved(assembly, mu, density, solve, (eps, d_bnd), stands=True)


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
    del verbose, timer
    return _solved(assembly, mu, density, solve_cra_penalty, (eps, d_bnd))


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
        As for a solver, solved or not.
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
    scale: tuple[float, float] | None = None,
    stands: bool = False,
) -> Any:
    """The assembly, with forces per corner in the order of its points, and displacements.

    Parameters
    ----------
    assembly
        Changed in place.
    mu, density, solve
    scale
        Overlap of corners in compression, or the largest displacement if the overlap is zero.
    stands
        Whether to refuse what does not stand, whatever its forces.
    """
    nodes = list(assembly.graph.nodes())
    ours = blocks_of(assembly, nodes, density)
    found = interfaces_of(assembly.graph, nodes, "interfaces")
    if not found or ours.fixed.all():
        raise ValueError("assembly has no contact interfaces or no free blocks")
    contacts, backwards = joined_interfaces(found, mu)
    result = solve(Model(ours, contacts, LoadCase.gravity(ours, 1.0)))
    _log.info("result: %s, %s", result.verdict.value, result.message)
    if result.force is None or (stands and not result.stable):
        raise ValueError(f"solve failed: {result.verdict.value} ({result.message})")
    pull = result.tension if result.tension is not None else np.zeros(len(result.force))
    push = np.maximum(result.force[:, 0] + pull, 0.0)
    rows = np.column_stack([push, pull, result.force[:, 1:]]).tolist()
    for i, (_, _, interface) in enumerate(found):
        own = [dict(zip(COMPONENTS, row, strict=True)) for row in rows[contacts.corners[i]]]
        interface.forces = own[::-1] if backwards[i] else own
    _displace(assembly, nodes, result, scale)
    return assembly


def _displace(
    assembly: Any, nodes: Sequence[Any], result: Result, scale: tuple[float, float] | None
) -> None:
    """Displacements of free nodes with which corners in compression overlap by so much."""
    if scale is None or result.force is None or result.displacement is None:
        return
    eps, d_bnd = scale
    moved = corner_motion(result.assembly, result.contacts, result.displacement)
    now, wanted = float(lengths(moved).max(initial=0.0)), d_bnd
    if eps > 0.0:
        weight = np.maximum(result.force[:, 0], 0.0)
        now, wanted = float(-(weight @ moved[:, 0]) / max(weight.sum(), 1e-300)), eps
    scaled = result.displacement * (wanted / now if now > 0.0 else 1.0)
    for i in result.assembly.free.tolist():
        assembly.graph.node_attribute(nodes[i], "displacement", scaled[i].tolist())


def __getattr__(name: str) -> Any:
    """The class ``CRA_Assembly``, made when it is asked for: it needs compas_assembly."""
    if name == "CRA_Assembly":
        return assembly_class()
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")


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


hold(globals())
