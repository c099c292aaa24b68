"""Sections 6.3 to 7.5 of the source: what is designed, and built without props; its table 8.1.

Chapters 4 and 8 of the source: equilibrium, kern, resultants, the graph; the example.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import shapely

from drystone import models
from drystone.assembly import Assembly
from drystone.design import CutOptions, cut_until_free, sharpen
from drystone.geometry.frames import rotation_about
from drystone.geometry.kern import kern
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.programs import FrictionCone, RBEOptions, build_rbe, solve_cra, solve_rbe
from drystone.programs.cra import CRAOptions
from drystone.reproduce.equilibrium_cases import word
from drystone.reproduce.published_case import ASSUMED, Case, Line
from drystone.results import Result, Verdict
from drystone.sequence import Order, Plan, PlanOptions, Rules, plan, take_turns
from drystone.shells import Ground, Layout, Shell, ShellBody, build_shell
from drystone.shells import dome as dome_shape
from drystone.shells import tri_dome as tri_dome_shape
from drystone.shells.shell_families import shape_by_name
from drystone.stability import check

THOROUGH = PlanOptions(patience=math.inf)
BY_COURSE = PlanOptions(rules=Rules(order=Order.COURSE))


def shelf_fixes() -> Case:
    """Figure 6.18: three changes that hold one of the two pieces, and the whole checked again."""
    lines, pictures = [], {}
    fixes = {1: "a piece is added (6.18b)", 2: "lower joint (6.18c)", 3: "upper joint (6.18d)"}
    for number, told in fixes.items():
        result = check(models.shelf(number), friction=0.9)  # type: ignore[arg-type]
        found = ", ".join(result.falling_names) or "nothing"
        held = "block-9" not in result.falling_names
        note = "the other piece still falls: local stability is not that of the whole"
        lines.append(Line(f"{told}: falls", "not block-9", found, held, note))
        pictures[f"fix-{number}"] = result
    return Case("6.3.2", "Interactive process towards stability", tuple(lines), pictures)


def wedge_arch() -> Case:
    """Figure 6.19: joints made wedges until a thin arch stands."""
    model = Model.of(models.arch(0.04, 15), friction=0.7)
    plane, sharper = check(model).verdict, sharpen(model)
    verdict = check(sharper.model).verdict
    told = f"{word(plane)} / {word(verdict)}"
    lines = (
        Line(
            "arch of 15 voussoirs, thickness 0.04 of its radius: plane joints / wedges",
            "unstable / stable", told, told == "unstable / stable", f"{ASSUMED}; {sharper.message}",
        ),
    )  # fmt: skip
    return Case("6.3.3", "Wedge arch", lines, {"wedge-arch": check(sharper.model)})


def leaning_tower() -> Case:
    """Figure 7.1: a leaning tower, cut until every block can be placed without a prop."""
    shape = models.prism([(0.0, 0.0), (1.0, 0.0), (2.5, 4.0), (1.5, 4.0)], (0.0, 1.0), "tower")
    cut = cut_until_free(shape, options=CutOptions(blocks=8))
    tower = "no plan" if cut.plan is None else _told(cut.plan)
    line = Line("from the whole to its parts", "8 blocks, none propped", tower, None, ASSUMED)
    pictures: dict[str, Result | Plan] = {} if cut.plan is None else {"leaning-tower": cut.plan}
    return Case("7.2.1", "Discretisation and assembly sequence", (line,), pictures)


def snake() -> Case:
    """Figure 7.2: three pieces that hook over each other."""
    model = Model.of(models.snake(), friction=0.66)
    result, order = check(model), plan(model)
    lines = (
        Line("complete, friction 0.66", "stable", word(result.verdict), result.stable),
        _counted(
            "order, friction 0.66", "3 free", order, order.counts["free"] == 3,
            "foot and two pieces alone slide at 0.66 and 0.7 in our check; the vertices are those "
            "of the source's files, the printed pieces had a tolerance",
        ),
        _counted("order, friction 0.8", "", plan(model.with_friction(0.8)), None),
    )  # fmt: skip
    return Case("7.2.3", "Snake design", lines, {"snake": result, "snake-order": order})


def bridge() -> Case:
    """Figures 7.3 and 7.4: the bridge, and the bridge with a load."""
    model = Model.of(models.bridge(), friction=0.66)
    plans = {mu: plan(model.with_friction(mu), options=THOROUGH) for mu in (0.66, 0.35, 0.34)}
    lines = []
    for mu in (0.66, 0.35):
        free = plans[mu].counts["free"]
        lines.append(_counted(f"friction {mu}: order", "9 free", plans[mu], free == 9))
    none, stands = plans[0.34].counts["free"] < 9, plans[0.34].complete.stands
    words = "no order without help is left; complete it " + ("stands" if stands else "falls")
    lines.append(_counted("friction 0.34: order", "none without help", plans[0.34], none, words))
    loaded = Model.of(models.bridge(load=True), friction=0.9)
    for mu in (0.35, 0.34):
        order = plan(loaded.with_friction(mu), options=THOROUGH)
        note = "" if mu > 0.34 else "two of the load's blocks are placed early, as counterweights"
        lines.append(_counted(f"with load, friction {mu}: order", "", order, None, note))
    result = check(loaded)
    lines.append(Line("with load: complete", "stable", result.verdict.value, result.stable))
    state = solve_cra(loaded, options=CRAOptions(tolerance=2e-6))
    met = state.verdict is Verdict.STABLE and state.method == "cra"
    lines.append(
        Line("with load: eq. 5.6", "a state", "a state" if met else "none", met, "to 2e-6")
    )
    pictures: dict[str, Result | Plan] = {"bridge": plans[0.66], "bridge-load": result}
    return Case("7.2.4", "Bridge design", tuple(lines), pictures)


def two_robots() -> Case:
    """Figure 6.21: two robots place and hold the blocks of a tri-dome, and of an arch in turn."""
    order = plan(tri_dome().model(friction=0.66), options=BY_COURSE)
    arch = Model.of(models.arch(0.3, 11), friction=0.7)
    found = take_turns(arch)
    places = f"tri-dome of {len(order.model.assembly)} blocks: a robot holds what would be propped"
    lines = (
        Line(
            f"{places}, or its partner",
            "two robots",
            f"{order.hands} robots, {_told(order)}",
            order.stable and order.hands == 2,
            ASSUMED,
        ),
        Line(
            "arch of 11 voussoirs, two robots in turn",
            "",
            f"{'no props' if found.works else 'falls'}, largest hold {found.largest:.0f} N",
            None,
            "an arch of ours, on which the method works without props",
        ),
    )
    return Case(
        "6.4.2",
        "Robotic assembly of shell structures",
        lines,
        {"tri-dome": order, "arch": check(arch)},
    )


def vault() -> Case:
    """Figures 7.11 to 7.13: a vault held along three edges, arch by arch."""
    shallow, deep = (
        plan(free_edge_vault(wedge).model(friction=0.6), options=BY_COURSE)
        for wedge in (0.02, (0.4, 0.4, 0.4, 0.02, 0.02))
    )
    lines = (
        _counted("first iteration, shallow wedges (7.12a)", "", shallow, None, ASSUMED),
        _counted(
            "after the loop (7.13)", "17 free, 2 held, 2 propped", deep, None,
            f"{ASSUMED}; the wedges are those that `drystone shell free-edge --courses 6 "
            "--buildable` finds",
        ),
    )  # fmt: skip
    return Case("7.5.1", "Vault designs", lines, {"vault": deep, "vault-first": shallow})


def dome() -> Case:
    """Figures 7.14 to 7.16: a dome, ring by ring."""
    found = plan(Model.of(ring_dome(), friction=0.66), options=BY_COURSE)
    published = "none propped, the first of a ring with its neighbour"
    line = _counted("dome of 60 blocks, friction 0.66", published, found, None, ASSUMED)
    return Case("7.5.2", "Dome designs", (line,), {"dome": found})


def freeform() -> Case:
    """Figure 7.17: a shell of three vaults, and the tri-dome of section 6.4.2."""
    found = {
        "three-vault shell": plan(arched_vaults().model(friction=0.66), options=BY_COURSE),
        "tri-dome": plan(tri_dome().model(friction=0.66), options=BY_COURSE),
    }
    arches = f"{ASSUMED}; its courses are arches from leg to leg, and their springers supports"
    lines = (
        _counted("three-vault shell of 42 blocks", "", found["three-vault shell"], None, arches),
        _counted("tri-dome of 43 blocks, friction 0.66", "", found["tri-dome"], None, ASSUMED),
    )
    pictures: dict[str, Result | Plan] = {k.replace(" ", "-"): v for k, v in found.items()}
    return Case("7.5.3", "Free-form discrete shell designs", lines, pictures)


TIMES: tuple[tuple[str, Callable[[], Assembly], float, int, int, float], ...] = (
    ("arch thick (6.11)", partial(models.arch, 0.15, 36), 0.93, 38, 37, 1.02),
    ("shelf (6.12)", models.shelf, 0.9, 11, 19, 0.5),
    ("type-a (6.14a)", partial(models.wedge, "a"), 0.84, 3, 2, 0.05),
    ("type-b (6.14b)", partial(models.wedge, "b"), 0.84, 3, 2, 0.05),
    ("type-c (6.14c)", partial(models.wedge, "c"), 0.84, 3, 2, 0.05),
    ("type-d (6.14d)", partial(models.wedge, "d"), 0.84, 3, 2, 0.05),
    ("concave-short (6.15a)", partial(models.concave, "short"), 0.84, 2, 7, 0.23),
    ("concave-long (6.15b)", partial(models.concave, "long"), 0.84, 2, 7, 0.15),
    ("curve-3-blocks (6.16a)", models.curve_three_blocks, 0.84, 3, 40, 2.38),
    ("cube-curve-short (6.16b)", partial(models.cube_curve, "short"), 0.84, 2, 72, 1.15),
    ("cube-curve-tall (6.16c)", partial(models.cube_curve, "tall"), 0.84, 2, 72, 1.04),
    ("snake (7.2)", models.snake, 0.66, 4, 7, 0.35),
    ("bridge (7.3)", models.bridge, 0.66, 11, 33, 1.27),
    ("bridge with load (7.4)", partial(models.bridge, load=True), 0.66, 16, 38, 1.26),
)
"""Rows of table 8.1: figure, model, friction, blocks, interfaces, solving time [s]."""


def performance() -> Case:
    """Table 8.1: blocks, interfaces of those that can move, and solving times at rest."""
    lines = []
    for name, build, friction, blocks, interfaces, seconds in TIMES:
        model = Model.of(build(), friction=friction)
        began = time.process_time()
        check(model)
        spent = time.process_time() - began
        at, fixed = model.contacts, model.assembly.fixed
        count = (len(model), int((~fixed[at.block_a] | ~fixed[at.block_b]).sum()))
        same = count == (blocks, interfaces)
        lines.append(
            Line(
                name, f"{blocks} blocks, {interfaces} interfaces, {seconds:g} s",
                f"{count[0]} blocks, {count[1]} interfaces, {spent:.3f} s",
                True if same else None,
                "" if same else "the source divides interfaces by hand or into triangles (5.4)",
            )
        )  # fmt: skip
    lines += [
        Line(name, published, "not computed", None, why)
        for name, published, why in (
            ("Armadillo Vault (6.20)", "399 blocks, 1014 interfaces, 2424 s",
             "its data belongs to others; docs/trust/speed.md has its time"),
            ("leaning tower (7.1h)", "8 blocks, 11 interfaces, 2.43 s", ASSUMED),
        )
    ]  # fmt: skip
    return Case("8.5", "Performance (table 8.1)", tuple(lines), {})


def free_edge_vault(wedge: float | tuple[float, ...]) -> Shell:
    """A form-found vault of 37 voussoirs in six arches, 15 of them supports, with a free edge."""
    layout = Layout(courses=6, width=1.2, wedge=wedge)
    return build_shell(shape_by_name("free-edge")[0], layout, ShellBody(ground=Ground.SPRINGERS))


def arched_vaults() -> Shell:
    """Three form-found vaults of 42 voussoirs in three arches each, 18 of them supports."""
    layout = Layout(courses=3, width=2.5, wedge=0.02)
    return build_shell(shape_by_name("three-vaults")[0], layout, ShellBody(ground=Ground.SPRINGERS))


def tri_dome() -> Shell:
    """A dome of 43 voussoirs on three feet, the first course of which is fixed.

    Near the feet, where rings end at open sides, bed lines have wedges below zero.
    """
    layout = Layout(courses=5, blocks=(2, 2, 3, 3, 2), wedge=(-0.2, -0.2, 0.4, 0.4))
    body = ShellBody(thickness=0.5, ground=Ground.SPRINGERS)
    return build_shell(tri_dome_shape(), layout, body)


def ring_dome() -> Assembly:
    """Five closed rings of twelve voussoirs, from 20 to 47.5 degrees of latitude."""
    eye = 5.0 * math.cos(math.radians(47.5))
    shape = dome_shape(radius=5.0, oculus=eye, springing_deg=20.0)
    return build_shell(
        shape, Layout(courses=5, blocks=12, wedge=0.2), ShellBody(thickness=0.5)
    ).assembly


def _counted(what: str, published: str, found: Plan, agrees: bool | None, note: str = "") -> Line:
    return Line(what, published, _told(found), agrees, note)


def _told(found: Plan) -> str:
    counts = found.counts
    return ", ".join(f"{counts[k]} {k}" for k in ("free", "held", "propped", "impossible"))


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
