"""Chapters 4 and 8 of the source: equilibrium, kern, resultants, the graph; the example."""

from __future__ import annotations

import math

import numpy as np
import shapely

from drystone import models
from drystone.assembly import Assembly
from drystone.geometry.frames import rotation_about
from drystone.geometry.kern import kern
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.programs import FrictionCone, RBEOptions, build_rbe, solve_rbe
from drystone.reproduce.published_case import Case, Line
from drystone.stability import check


def equilibrium() -> Case:
    """Equations 4.2 and 4.6, figure 4.2: the matrices of equilibrium and friction of an arch."""
    model = Model.of(models.buttressed_arch(), friction=0.6)
    program = build_rbe(model, options=RBEOptions(cone=FrictionCone.octagon(), tension=False))
    corners, free = model.contacts.corner_count, len(model.assembly.free)
    rows = program.rows["equilibrium"]
    equal = program.matrix[rows]
    shape = f"{equal.shape[0]} x {equal.shape[1]}"
    most = int(np.diff(equal.tocsc().indptr).max())
    cone = program.rows["friction"]
    planes = (cone.stop or program.matrix.shape[0]) - cone.start
    lines = (
        Line("A_eq (4.2): 6 equations a free block, 3 unknowns a corner",
             f"{6 * free} x {3 * corners}", shape, shape == f"{6 * free} x {3 * corners}"),
        Line("equations and unknowns", "fewer equations", f"{6 * free} for {3 * corners}",
             6 * free < 3 * corners),
        Line("entries of a column: at most two blocks", "12 or fewer", str(most), most <= 12),
        Line("planes of the friction cone a corner (4.2)", "8", f"{planes / corners:g}",
             planes == 8 * corners),
    )  # fmt: skip
    return Case("4.2", "Theoretical background", lines, {"arch": solve_rbe(model)})


def kerns() -> Case:
    """Equations 4.9 to 4.16, figure 4.3: the kern of an interface."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    long = square * (3.0, 1.0)
    lines = []
    for name, shape, width, wanted in (
        ("square", square, 1.0, 1.0 / 6.0),
        ("rectangle, its long side", long, 3.0, 1.0 / 6.0),
    ):
        reach = np.abs(kern(shape)[:, 0] - 0.5 * width).max() / width
        lines.append(
            Line(f"{name}: reach of the kern from the centroid, by its side", "1/6",
                 f"{reach:.6f}", math.isclose(reach, wanted),
                 "what equation 4.16 gives for it")
        )  # fmt: skip
    triangle = np.array([[0.0, 0.0], [2.0, 0.0], [0.5, 1.0]])
    share = math.sqrt(shapely.Polygon(kern(triangle)).area / shapely.Polygon(triangle).area)
    lines.append(
        Line("triangle: side of the kern by that of the triangle", "1/4", f"{share:.6f}",
             math.isclose(share, 0.25), "what equation 4.16 gives for it")
    )  # fmt: skip
    arch = solve_rbe(Model.of(models.buttressed_arch(), friction=0.6))
    return Case("4.3", "Kern of a polygonal interface", tuple(lines), {"arch": arch})


def resultants() -> Case:
    """Equations 4.17 to 4.20: forces, place and torque of an interface."""
    model = Model.of(models.two_blocks_on_incline(23.6), friction=0.8)
    moment = LoadCase.gravity(model.assembly).wrench.copy()
    top = int(model.assembly.free[0])
    moment[top, 5] = 0.02 * abs(moment[top, 2])
    result = solve_rbe(model.with_load(LoadCase(moment, "weight and a turn")))
    contacts, found = result.contacts, result.resultants
    force = result.force
    assert force is not None
    sums = abs(force[:, 0].sum() - found.normal[0])
    pressed = force[:, :1].T @ contacts.point / force[:, 0].sum()
    place = float(np.abs(pressed[0] - found.position[0]).max())
    arm = contacts.point - found.position[0]
    turn = np.cross(arm, result.world_force()) @ contacts.frame[0, 0]
    torque = abs(float(turn.sum()) - float(found.torque[0]))
    balance = np.abs(found.force[0] + moment[top, :3]).max()
    size = float(found.normal[0])
    lines = tuple(
        Line(name, "equal", f"{off / size:.1e} of the force", bool(off <= 1e-7 * size))
        for name, off in (
            ("normal resultant (4.17) and the sum at the corners", sums),
            ("its place (4.19) and the mean of the corners by their forces", place * size),
            ("torque (4.20) and the moment of the corner forces about the normal", torque),
            ("resultant and the load of the block", balance),
        )
    )
    return Case("4.4", "Resultants", lines, {"incline": result})


def assembly_graph() -> Case:
    """The assembly as a graph: blocks in its nodes, interfaces and forces in its edges."""
    model = Model.of(models.buttressed_arch(), friction=0.6)
    result = check(model)
    graph = result.graph()
    force = np.array([model.load.wrench[i, :3] for i in graph])
    for a, b, edge in graph.edges(data=True):
        force[b] += edge["resultant"]
        force[a] -= edge["resultant"]
    off = np.abs(force[model.assembly.free]).max() / np.abs(model.load.wrench).max()
    blocks = sum(graph.nodes[i]["block"] is one for i, one in enumerate(model.assembly.blocks))
    corners = sum(len(edge["force"]) for _, _, edge in graph.edges(data=True))
    same = sum(
        bool(np.array_equal(edge["points"], model.contacts.polygon(edge["interface"])))
        for _, _, edge in graph.edges(data=True)
    )
    lines = (
        Line("nodes with their block", f"{len(model.assembly)}, one a block", str(blocks),
             blocks == len(model.assembly) == len(graph)),
        Line("directed edges with the corners of their interface",
             f"{model.contacts.count}, one an interface", str(same),
             same == model.contacts.count == graph.number_of_edges()),
        Line("forces in the edges", f"{model.contacts.corner_count}, one a corner", str(corners),
             corners == model.contacts.corner_count),
        Line("load of a node and its edges, reversed where they leave it", "balance",
             f"{off:.1e} of the load", bool(off <= 1e-6), "Newton's third law along an edge"),
    )  # fmt: skip
    return Case("4.5", "Assembly data structure", lines, {"arch": result})


def example() -> Case:
    """The example: a box turned by 0.2 rad on a support, density and gravity one."""
    support = models.box((4.0, 2.0, 1.0), (-2.0, -1.0, -0.5), name="0")
    turn = rotation_about(np.array([0.0, 0.0, 1.0]), np.degrees(0.2))
    block = models.box((1.0, 3.0, 1.0), (-0.5, -1.5, 0.5), name="1").transformed(turn)
    assembly = Assembly((support, block), np.array([True, False])).with_density(1.0)
    model = Model.of(assembly, friction=0.84, load=LoadCase.gravity(assembly, 1.0))
    result = check(model)
    normal = float(result.resultants.normal.sum())
    lines = (
        Line("interfaces", "1", str(model.contacts.count), model.contacts.count == 1,
             "section 8.4 gives no figures: those that follow from its sizes"),
        Line("normal force: 1 x 3 x 1 of density and gravity one", "3", f"{normal:.6f}",
             abs(normal - 3.0) < 1e-6),
        Line("cra_solve", "a solution", "stands" if result.stable else "none", result.stable,
             "as printed it runs through drystone.compat.compas_cra"),
    )  # fmt: skip
    return Case("8.4", "Example of COMPAS CRA", lines, {"boxes": result})
