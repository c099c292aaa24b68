"""A shell of blocks from a shape, a layout and a body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from drystone.answer import Answer, Question, Role, Scene, Sentence
from drystone.answer.drawing import scene_of_blocks
from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Bools, Floats, Ints, dot, unit
from drystone.base.errors import InputError, counted
from drystone.base.ragged import Ragged
from drystone.base.settings import Progress
from drystone.base.units import quantity
from drystone.contacts import DEFAULT_FRICTION, Contacts
from drystone.geometry import boxes
from drystone.geometry.frames import area_vectors, frames_from_normals
from drystone.geometry.polyhedron import loop_edges, rings
from drystone.geometry.selfcontact import convex_bodies
from drystone.geometry.shared_volume import shared_volumes
from drystone.model import FlushEnds, Model
from drystone.shells.courses import lay_bond, lay_courses
from drystone.shells.materialise import (
    Pins,
    cell_faces,
    check_radius,
    fit_cells,
    make_blocks,
    mean_width,
    vertex_thickness,
)
from drystone.shells.patch import Shape, Side, refuse_unless_positive
from drystone.shells.pattern import Tessellation, lay_pattern
from drystone.shells.planarise import (
    PlanarPins,
    PlanarReport,
    drift_notes,
    hook_notes,
    planar_pins,
    refuse_joggle_at_sides,
    refuse_warped,
    special_remedy,
)
from drystone.shells.shell_options import Ground, Layout, ShellBody
from drystone.shells.weld import weld


def refuse_overlaps(assembly: Assembly, mesh: Tessellation, width: float, ground: Bools) -> None:
    """Refuse a shell with blocks that overlap.

    Parameters
    ----------
    assembly
        A block for each cell of the mesh.
    mesh
    width : [m]
        Mean width of a block.
    ground : (c,)
        Which cells are ground.

    Raises
    ------
    InputError
        The surface crosses itself; two parts of it are closer than the thickness; or a strongly
        curved block reaches into its neighbour.
    """
    least, bounds, blocks = SAME * width, assembly.bounds, assembly.blocks
    a, b = boxes.overlapping(bounds[:, 0] + 0.5 * least, bounds[:, 1] - 0.5 * least)
    convex = convex_bodies([block.vertices for block in blocks], [block.faces for block in blocks])
    found = shared_volumes(assembly.faces, a, b, np.full(len(a), least), convex)
    if not len(found.row):
        return
    a, b, depth = a[found.row], b[found.row], found.depth
    beneath = ground[a] | ground[b]
    worst = int(np.lexsort((-depth, beneath))[0])
    one, other = int(a[worst]), int(b[worst])
    if set(mesh.cells[one]) & set(mesh.cells[other]):
        remedy = "use a smaller thickness or wedge, or larger blocks"
    elif beneath[worst]:
        remedy = "give a smaller ground depth, or move the supports apart"
    else:
        remedy = (
            "the surface must not cross itself, nor come closer to itself than the shell is thick"
        )
    rest = f", and {counted(len(a) - 1, 'more pair')}" if len(a) > 1 else ""
    raise InputError(
        f"overlap, {depth[worst]:.2g} m deep{rest}",
        where=f"blocks '{mesh.names[one]}' and '{mesh.names[other]}'",
        remedy=remedy,
    )


@dataclass(frozen=True, eq=False)
class Shell(Answer):
    """A shell of blocks.

    Attributes
    ----------
    shape
    assembly
        Voussoirs first, ground blocks last. Each block's metadata has ``course``, ``position``,
        ``patch`` and ``role`` (voussoir, springer, keystone, ring or ground).
    mesh, pins
        The cells and the points that they were made from.
    planar
        Result of the planarisation, relative to the mean width of a block.
    off_surface
        Largest component of the drift normal to the surface, relative to that width.
    fitted
        Largest move of a corner normal to the surface before planarisation, relative to that width.
        It compensates the area that flat cells with corners on a curved surface lose.
    ground : (n,) which blocks are ground
    thickness : (v,) [m] at each vertex of the mesh without the ground
    notes
        Remarks for the user: joints that are not planar, a large drift.
    """

    shape: Shape
    assembly: Assembly = field()  # in place of that of the model
    mesh: Tessellation
    pins: Pins
    planar: PlanarReport
    off_surface: float
    fitted: float
    ground: Bools
    thickness: Floats
    notes: tuple[str, ...] = ()

    def _summary(self) -> str:
        return f"'{self.shape.name}', {counted(len(self.voussoirs), 'voussoir')}, {self.assembly!r}"

    @cached_property
    def asked(self) -> Question:
        """What it was made of."""
        return replace(Question.of_blocks(self.assembly, self.contacts), made=self.when)

    @property
    def title(self) -> str:
        """How many blocks in how many courses."""
        courses = int(self.mesh.course[self.voussoirs].max()) + 1
        return f"{counted(len(self.voussoirs), 'voussoir')} in {counted(courses, 'course')}"

    def sentences(self) -> Sequence[Sentence]:
        """How many blocks, and how far they are from plane joints and from the surface."""
        planar = self.planar
        ground = f"{self.assembly.fixed.sum()} of them supports"
        if self.ground.any():
            ground = counted(int(self.ground.sum()), "ground block")
        flat = "the joints are planar" if planar.reached else "some joints are not planar"
        made = f" before, {planar.warp_after:.1e} after planarising"
        if self.pins.faceted:
            flat, made = "warped joints are two triangles", ""
        return [
            Sentence(flat, Role.GOOD if planar.reached or self.pins.faceted else Role.BAD),
            Sentence(f"{self.title}, {ground}, {self.volume:.2f} m3"),
            Sentence(self._thick),
            Sentence(
                f"largest warp of a joint {planar.warp_before:.2%} of a block{made}; "
                f"largest drift {planar.drift:.1%}, {self.off_surface:.1%} off the surface"
            ),
        ]

    def layers(self) -> Scene:
        """The blocks and their joints."""
        return scene_of_blocks(self.assembly, self.contacts)

    def numbers(self) -> Mapping[str, Any]:
        """Counts, warp and drift, which are by the mean width of a block."""
        return {
            "voussoirs": len(self.voussoirs),
            "ground_blocks": self.ground.sum(),
            "courses": self.mesh.course[self.voussoirs].max() + 1,
            "volume": self.volume,
            "warp_before": self.planar.warp_before,
            "warp_after": self.planar.warp_after,
            "planar": self.planar.reached,
            "drift": self.planar.drift,
            "off_surface": self.off_surface,
            "moved_off_surface": self.fitted,
            "supports": [f"patch {edge.patch}, {edge.side.value}" for edge in self.shape.supports],
        }

    @property
    def _thick(self) -> str:
        """How thick it is, and where that comes from if nobody asked for it."""
        low, high = float(self.thickness.min()), float(self.thickness.max())
        if high - low > SAME * high:
            return f"{quantity(low, 'm')} to {quantity(high, 'm')} thick"
        usual = self.shape.default_thickness
        if abs(high - usual) > SAME * usual:
            return f"{quantity(high, 'm')} thick"
        usually = "a thirtieth of its size" if self.shape.thickness is None else "usual of its form"
        return f"{quantity(high, 'm')} thick, {usually}: --thickness gives another"

    @property
    def voussoirs(self) -> Ints:
        """Positions of the blocks that are not ground."""
        return np.flatnonzero(~self.ground)

    @cached_property
    def volume(self) -> float:
        """[m3], of the voussoirs."""
        return float(self.assembly.volume[~self.ground].sum())

    @cached_property
    def beside(self) -> Mapping[frozenset[int], tuple[int, ...]]:
        """For the points of every side face its blocks: one or two."""
        users: dict[frozenset[int], tuple[int, ...]] = {}
        for block, cell in enumerate(self.mesh.cells):
            for face in cell_faces(self.mesh, self.pins, cell)[2]:
                key = frozenset(face)
                users[key] = (*users.get(key, ()), block)
        return users

    @cached_property
    def contacts(self) -> Contacts:
        """The joints between its blocks, one for each face that two blocks share.

        They are equal to the result of :func:`drystone.find_contacts`, without a search. Of faceted
        joints the search makes two triangles one where they turn by less than 0.1 degree.
        """
        loops, ends = [], []
        for block, cell in enumerate(self.mesh.cells):
            for face in cell_faces(self.mesh, self.pins, cell)[2]:
                users = self.beside[frozenset(face)]
                if len(users) == 2 and users[0] == block:
                    loops.append(face)
                    ends.append(users)
        order = sorted(range(len(loops)), key=ends.__getitem__)
        corners = Ragged.of([loops[i] for i in order])
        point = self.pins.point[[pin for i in order for pin in loops[i]]]
        normal, area = unit(area_vectors(point, corners.start))
        height = dot(point - corners.spread(corners.mean(point)), corners.spread(normal))
        a, b = np.array([ends[i] for i in order], dtype=np.intp).reshape(-1, 2).T
        return Contacts(
            a,
            b,
            frames_from_normals(normal),
            area,
            np.full(len(area), DEFAULT_FRICTION),
            point - height[:, None] * corners.spread(normal),
            corners.owner,
        )

    def model(  # type: ignore[override]
        self,
        *,
        friction: float = DEFAULT_FRICTION,
        load: Any = None,
        ends: FlushEnds | None = None,
    ) -> Model:
        """The shell as a model, with its known contacts.

        Parameters
        ----------
        friction
            Coefficient of every joint.
        load, ends
            See :class:`drystone.Model`.

        Examples
        --------
        >>> import drystone
        >>> from drystone.shells import Layout, barrel_vault, build_shell
        >>> shell = build_shell(barrel_vault(span=6.0, length=6.0), Layout(courses=10, blocks=4))
        >>> drystone.check(shell.model(friction=0.6)).stable
        True
        """
        contacts = self.contacts.with_friction(friction)
        return Model(self.assembly, contacts, load, notes=self.notes, ends=ends)


def build_shell(
    shape: Shape,
    layout: Layout | Sequence[Layout],
    body: ShellBody | None = None,
    *,
    progress: Progress | None = None,
) -> Shell:
    """Blocks for a shape.

    Parameters
    ----------
    shape
    layout
        One for all patches or one per patch.
    body
    progress
        Called as ``progress(stage, done, total)``, with 0 <= done <= total.

    Raises
    ------
    InputError
        No support, a thickness above the radius of curvature, too few blocks, joints that stay
        warped, blocks inside out, or blocks that overlap because the surface crosses itself.

    Examples
    --------
    >>> from drystone.shells import Layout, barrel_vault, build_shell
    >>> shell = build_shell(barrel_vault(span=6.0, length=6.0), Layout(courses=10, blocks=4))
    >>> shell.assembly.names[5], len(shell.voussoirs), shell.planar.reached
    ('c01-b01', 45, True)
    """
    body = body if body is not None else ShellBody()
    if not shape.supports:
        raise InputError(
            "the shell has no support",
            where=f"shape '{shape.name}'",
            remedy="name the sides that it stands on",
        )
    refuse_joggle_at_sides(shape, body)
    layouts = [layout] * len(shape.patches) if isinstance(layout, Layout) else list(layout)
    if len(layouts) != len(shape.patches):
        raise InputError(f"{len(layouts)} layouts for {len(shape.patches)} patches")
    patterns = []
    for patch, plan in zip(shape.patches, layouts, strict=True):
        courses = lay_courses(patch, count=plan.courses, height=plan.height)
        bond = lay_bond(courses, blocks=plan.blocks, width=plan.width, staggered=plan.staggered)
        patterns.append(lay_pattern(courses, bond, wedge=plan.wedge))
    mesh, moved = fit_cells(weld(shape, patterns), shape)
    given = body.thickness if body.thickness is not None else shape.default_thickness
    thickness = vertex_thickness(mesh, given)
    check_radius(shape, float(thickness.max()))
    width = mean_width(mesh)
    planar = planar_pins(mesh, thickness, width, body, progress)
    refuse_warped(shape, planar, body)
    return _finish(shape, mesh, planar, moved / width, thickness, body)


def _finish(
    shape: Shape,
    mesh: Tessellation,
    planar: PlanarPins,
    fitted: float,
    thickness: Floats,
    body: ShellBody,
) -> Shell:
    width, pins = mean_width(mesh), planar.pins
    notes = (*drift_notes(mesh, planar), *hook_notes(mesh, body))
    springer = springers(mesh)
    ground = np.zeros(len(mesh.cells), dtype=bool)
    roles = _roles(shape, mesh, springer)
    if body.ground is Ground.BLOCKS:
        depth = body.ground_depth if body.ground_depth is not None else float(thickness.mean())
        refuse_unless_positive(ground_depth=depth)
        mesh, pins, ground = add_ground(mesh, pins, depth)
        fixed = ground
    else:
        fixed = springer
    roles += ["ground"] * int(ground.sum())
    metadata: list[dict[str, Any]] = [
        {"course": c, "position": b, "patch": p, "role": role}
        for c, b, p, role in zip(
            mesh.course.tolist(),
            mesh.position.tolist(),
            mesh.of_patch.tolist(),
            roles,
            strict=True,
        )
    ]
    try:
        blocks = make_blocks(mesh, pins, metadata, density=body.density)
        assembly = Assembly(tuple(blocks), fixed)
        refuse_overlaps(assembly, mesh, width, ground)
    except InputError as error:
        remedy = special_remedy(shape, body)
        if remedy is None:
            raise
        raise error.located(error.where, remedy) from error
    return Shell(
        shape=shape,
        assembly=assembly,
        mesh=mesh,
        pins=pins,
        planar=planar.report,
        off_surface=planar.off_surface,
        fitted=fitted,
        ground=ground,
        thickness=thickness,
        notes=notes,
    )


def _roles(shape: Shape, mesh: Tessellation, springer: Bools) -> list[str]:
    """The role of each block.

    Springers stand on supports. Keystones close an eye, or form the middle course of a patch that
    is supported at its bottom and its top. A ring surrounds an eye.
    """
    ring = _around_openings(mesh)
    last = [int(mesh.course[mesh.of_patch == k].max()) for k in range(len(shape.patches))]
    stood = {(edge.patch, edge.side) for edge in shape.supports}
    spans = [{(k, Side.BOTTOM), (k, Side.TOP)} <= stood for k in range(len(shape.patches))]
    roles = []
    for cell, (course, patch, stands) in enumerate(
        zip(mesh.course.tolist(), mesh.of_patch.tolist(), springer.tolist(), strict=True)
    ):
        if patch < 0 or (spans[patch] and 2 * course == last[patch]):
            roles.append("keystone")
        elif stands:
            roles.append("springer")
        elif cell in ring:
            roles.append("ring")
        else:
            roles.append("voussoir")
    return roles


def _around_openings(mesh: Tessellation) -> set[int]:
    """Cells around an eye: a closed border without supports."""
    cell_of = {
        edge: c for c, cell in enumerate(mesh.cells) if mesh.of_patch[c] >= 0
        for edge in loop_edges(cell)
    }  # fmt: skip
    after = {b: a for a, b in cell_of if (b, a) not in cell_of}  # the border, opening left
    supported = set(mesh.supported)
    around: set[int] = set()
    for ring in rings(after):
        run = [(b, a) for a, b in loop_edges(ring)]
        if after.get(ring[-1]) == ring[0] and not supported & set(run):
            around.update(cell_of[edge] for edge in run)
    return around


def springers(mesh: Tessellation) -> Bools:
    """Which cells (c,) stand on a support."""
    supported = set(mesh.supported)
    return np.array([any(edge in supported for edge in loop_edges(cell)) for cell in mesh.cells])


def add_ground(mesh: Tessellation, pins: Pins, depth: float) -> tuple[Tessellation, Pins, Bools]:
    """A ground block under every springer, with the same support face.

    Its other side is the support face moved out of the shell by ``depth`` [m], normal to the
    border. The third value tells which cells (c,) are ground.
    """
    outwards = _outwards(mesh)
    new_vertex = {old: len(mesh.point) + i for i, old in enumerate(outwards)}
    cells, names, place = list(mesh.cells), list(mesh.names), []
    supported = set(mesh.supported)
    for cell, name, course in zip(mesh.cells, mesh.names, mesh.course.tolist(), strict=True):
        for k, chain in enumerate(_chains(cell, supported)):
            cells.append((*reversed(chain), *(new_vertex[v] for v in chain)))
            names.append(f"ground-{name}" + (f"-{k}" if k else ""))
            place.append(course)
    old = list(outwards)
    shift = depth * np.array(list(outwards.values())).reshape(-1, 3)
    low, high = pins.point[pins.start[:-1][old]], pins.point[pins.start[1:][old] - 1]
    far = np.stack([low + shift, high + shift], axis=1).reshape(-1, 3)
    added = len(place)
    grounded = replace(
        mesh,
        point=np.concatenate([mesh.point, mesh.point[old] + shift]),
        normal=np.concatenate([mesh.normal, mesh.normal[old]]),
        up=np.concatenate([mesh.up, mesh.up[old]]),
        inner=np.concatenate([mesh.inner, np.zeros(len(old), dtype=bool)]),
        cells=tuple(cells),
        names=tuple(names),
        course=np.concatenate([mesh.course, np.array(place, dtype=np.intp)]),
        position=np.concatenate([mesh.position, np.full(added, -1, dtype=np.intp)]),
        of_patch=np.concatenate([mesh.of_patch, np.full(added, -1, dtype=np.intp)]),
        crest=np.concatenate([mesh.crest, np.full((added, 3), np.nan)]),
    )
    start = np.concatenate([pins.start, pins.start[-1] + 2 * np.arange(1, len(old) + 1)])
    ground = np.concatenate([np.zeros(len(mesh.cells), dtype=bool), np.ones(added, dtype=bool)])
    extended = replace(pins, point=np.concatenate([pins.point, far]), start=start)
    return grounded, extended, ground


def _outwards(mesh: Tessellation) -> dict[int, Floats]:
    """Per supported vertex the vector that offsets its edges out of the shell by 1, mitred."""
    at: dict[int, list[Floats]] = {}
    for a, b in mesh.supported:
        along = mesh.point[b] - mesh.point[a]
        square = np.cross(along, mesh.normal[a] + mesh.normal[b])
        square /= np.linalg.norm(square)
        at.setdefault(a, []).append(square)
        at.setdefault(b, []).append(square)
    moves = {}
    for vertex, squares in at.items():
        if len(squares) == 1:
            moves[vertex] = squares[0]
        else:
            total = squares[0] + squares[1]
            moves[vertex] = total / max(1.0 + float(squares[0] @ squares[1]), 0.1)
    return moves


def _chains(cell: tuple[int, ...], supported: set[tuple[int, int]]) -> list[list[int]]:
    """Runs of supported edges of one cell, as vertices in its order."""
    edges = loop_edges(cell)
    on = [edge in supported for edge in edges]
    if not any(on):
        return []
    first = next((i for i, flag in enumerate(on) if not flag), 0)
    chains: list[list[int]] = []
    open_chain = False
    for edge, flag in zip(edges[first:] + edges[:first], on[first:] + on[:first], strict=True):
        if flag and open_chain:
            chains[-1].append(edge[1])
        elif flag:
            chains.append([edge[0], edge[1]])
        open_chain = flag
    return chains
