"""Props: a fixed block against a face, and the force on it.

A strut is a block that fits between a falling block and a near block.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import shapely

from drystone.answer import Layer, LayerKind
from drystone.assembly import Assembly, Block
from drystone.base.arrays import SAME, Floats, Ints, frozen, lengths, unit
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.units import quantity
from drystone.contacts import Contacts
from drystone.design.changed_model import changed, fresh_name, usual_friction
from drystone.design.margin import LARGE_REGION, SPARE, soon_at_rest
from drystone.formulations.corner_forces import FrictionCone
from drystone.formulations.equilibrium import PlaneFactors
from drystone.free_faces import FreePart, free_parts
from drystone.geometry.convex_pieces import solid_of
from drystone.geometry.frames import area_vector, frames_from_normals, rotation_about
from drystone.geometry.glue import cut_cell
from drystone.geometry.polyhedron import prism_faces
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.sequence.scaffold_seats import first_met, post_ways, surface_triangles
from drystone.stability.problem import Problem
from drystone.supports import PROP
from drystone.ties import PLATE

_LEANS = (0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0)
"""[degrees] Tried inclinations of a strut from the normal of the face. Chosen."""

_WITHIN = 0.9
"""Largest inclination of a strut at both ends, as a share of the friction angle. Chosen: it does
not slide under any force."""

_LONGEST = 2.0
"""Longest strut relative to the size of the block. Chosen."""


def struts(model: Model, block: int, motion: Floats) -> list[tuple[float, int, Block]]:
    """Struts that fit against a block: lengths [m], the blocks that they stand on, and the struts.

    The shortest one is the first. A strut goes from a free face that moves forward to the next
    block, with an inclination below the friction angle at both ends, and through no other block.

    Parameters
    ----------
    model
    block
    motion : (6,)
        How the block begins to move.
    """
    return sorted(_all(model, block, motion), key=lambda strut: strut[0])


def _all(model: Model, block: int, motion: Floats) -> Iterator[tuple[float, int, Block]]:
    limit = _WITHIN * np.arctan(usual_friction(model))
    body = model.assembly.blocks[block]
    surface = surface_triangles(model.assembly)
    for seat, lean in product(seats(model, block, motion), _LEANS):
        if abs(np.deg2rad(lean)) > limit:
            continue
        frame = frames_from_normals(-np.asarray(seat.normal)[None])[0]
        point, along = seat.outline.mean(axis=0), rotation_about(frame[1], lean) @ frame[0]
        reach = _LONGEST * body.size
        met = first_met(surface, block, point, point + reach * along)
        length = 0.0 if met is None else float((met.point - point) @ along)
        if met is not None and length >= 1e-3 * reach and -met.normal @ along >= np.cos(limit):
            strut = _fitted(model, block, point, along, length, -seat.normal, met.normal)
            if strut is not None:
                yield length, met.block, strut


def _fitted(
    model: Model,
    block: int,
    point: Floats,
    along: Floats,
    length: float,
    seat: Floats,
    landing: Floats,
) -> Block | None:
    """A bar between two faces, cut to them; ``None`` if another block is between them.

    Parameters
    ----------
    model, block, point, along, length
    seat, landing : (3,) unit
        Outward normals of the face of the block, and of the face that the strut stands on.
    """
    body = model.assembly.blocks[block]
    half = 0.5 * PLATE * body.size
    frame = frames_from_normals(along[None])[0]
    # the line across the strut that lies in both faces stays whole; as deep as the block
    across = np.cross(along, seat) if abs(along @ seat) < 0.999 else frame[1]
    across /= np.linalg.norm(across)
    deep = body.vertices @ across
    low, high = float(deep.min()), float(deep.max())
    other = np.cross(along, across)
    start = point - 2.0 * half * along
    end = point + (length + 2.0 * half) * along
    ring = [(low, -half), (high, -half), (high, half), (low, half)]
    base = np.array(
        [p + (a - p @ across) * across + b * other for p in (start, end) for a, b in ring]
    )
    faces = prism_faces(4)
    if np.linalg.det(np.array([across, other, along])) < 0.0:
        faces = [face[::-1] for face in faces]
    far = point + length * along
    normals = -np.array([seat, landing])
    offsets = np.array([-seat @ point, -landing @ far])
    try:
        (piece, *_), _ = cut_cell([(base, faces)], normals, offsets)
        made = Block(piece[0], tuple(piece[1]), fresh_name(model, "strut"), body.density)
    except (InputError, ValueError):
        return None
    return None if _in_the_way(model, made) else made


def _in_the_way(model: Model, body: Block) -> bool:
    """Whether a body shares volume with a block of the model."""
    solid = solid_of(body.vertices, body.faces)
    low, high = body.bounds
    for other in model.assembly.blocks:
        if (other.bounds[0] >= high).any() or (other.bounds[1] <= low).any():
            continue
        common = (solid ^ solid_of(other.vertices, other.faces)).volume()
        if common > 1e-6 * body.volume:
            return True
    return False


_AGAINST = 0.2
"""A prop is possible where a face moves towards it with at least this share of its speed. Chosen:
12 degrees between motion and face."""

SHARES = (0.0, 0.4, 0.7, -0.4, -0.7)
"""Places on a face, from its middle to its ends."""


@dataclass(frozen=True, eq=False)
class PropSeat(OneLine):
    """A place for a prop against a block.

    Attributes
    ----------
    block
    outline : (c, 3) [m]
        Of the head, on a face of the block, counter-clockwise about the normal.
    normal : (3,) unit
        From the prop into the block.
    covered
        Whether joints cover a part of the face.
    """

    block: int
    outline: Floats
    normal: Floats
    covered: bool = False

    @property
    def middle(self) -> Floats:
        """Of the head (3,) [m]."""
        middle: Floats = np.asarray(self.outline).mean(axis=0)
        return middle


@dataclass(frozen=True, eq=False)
class PropForce(OneLine):
    """A prop that holds a region, and its force.

    Attributes
    ----------
    seat
        Its place.
    point : (3,) [m]
    force : (3,) [N]
        On the block.
    rest : (n + p, 6) [m, rad]
        Rest state of the blocks, and of all p props that hold them together.
    """

    seat: PropSeat
    point: Floats
    force: Floats
    rest: Floats

    @property
    def block(self) -> int:
        """Position of the block that rests on it."""
        return self.seat.block

    @property
    def size(self) -> float:
        """[N]."""
        return float(np.linalg.norm(self.force))


@dataclass(frozen=True)
class PropSearch(OneLine):
    """The props that hold a model, and what was tried.

    Attributes
    ----------
    props
        None of which can be left out; empty where none hold it.
    tried
        The kinds of places, as text.
    """

    props: tuple[PropForce, ...]
    tried: str

    def renumbered(self, place: Ints) -> PropSearch:
        """The same with blocks numbered as in another model, by their places (n,) in it."""
        moved = [
            replace(one, seat=replace(one.seat, block=int(place[one.block]))) for one in self.props
        ]
        return replace(self, props=tuple(moved))


NO_PROPS = PropSearch((), "")
"""No prop was looked for."""


def seats(
    model: Model, block: int, motion: Floats, shares: Sequence[float] = SHARES, *, low: bool = False
) -> Iterator[PropSeat]:
    """Places for a prop against a block: on each free part of its faces that move forward.

    None where earth or fill lies.

    On a part they lie on a line through its middle, in the direction in which it moves forward
    faster, else its steepest one.

    Parameters
    ----------
    model
    block
    motion : (6,)
        First motion of the block.
    shares
        Of the distance from the middle of a part to its end.
    low
        On the other faces that look along the load, in place of those that move forward.
    """
    body = model.assembly.blocks[block]
    half = 0.5 * PLATE * body.size
    load = model.load.wrench[block, :3]
    for part in free_parts(model, block):
        velocity = motion[:3] + np.cross(motion[3:], part.middle - body.centroid)
        speed = max(float(np.linalg.norm(velocity)), 1e-300)
        forward = bool(part.normal @ velocity > _AGAINST * speed)
        lower = bool(part.normal @ load > _AGAINST * np.linalg.norm(load))
        if (
            part.area >= half**2
            and not _pressed(model, part)
            and (lower and not forward if low else forward)
        ):
            faster = np.cross(part.normal, motion[3:]) * body.size / speed
            lines = [part.frame[1:] @ one for one in (faster, np.array([0.0, 0.0, -1.0]))]
            along = next((one for one in lines if np.linalg.norm(one) > _AGAINST), np.eye(2)[0])
            yield from _heads(part, half, along / np.linalg.norm(along), shares)


def _heads(
    part: FreePart, half: float, along: Floats, shares: Sequence[float]
) -> Iterator[PropSeat]:
    """Heads of a size on a free part of a face, where they fit, on a line along u and v (2,)."""
    frame, shape, centre = part.frame, part.shape, part.inside
    reach = (np.array(shape.exterior.coords) - centre) @ along
    for share in shares:
        at = centre + share * (reach.max() if share > 0.0 else -reach.min()) * along
        head = shapely.intersection(shapely.box(*(at - half), *(at + half)), shape)
        if head.geom_type == "Polygon" and head.area > half**2:
            ring = np.array(shapely.geometry.polygon.orient(head).exterior.coords)[:-1]
            outline = frozen(part.origin + ring @ frame[1:])
            yield PropSeat(part.block, outline, frozen(frame[0]), part.covered)


def find_props(
    model: Model,
    blocks: Sequence[int],
    motion: Floats,
    stop: Callable[[], bool] | None = None,
    *,
    single: Sequence[int] | None = None,
    shares: Sequence[float] = SHARES,
) -> PropSearch:
    """The one prop with the least force that holds a model, else a few that hold it together.

    For each place the least force square to the face that balances the loads is found by a convex
    program. A prop from below comes before a level one with a third of its force, and one that
    presses down is the last; of those within a thousandth of each other the one nearest to the
    middle of the blocks is the first. The first one that holds the model is taken, where possible
    one that holds it with 20 % less friction. Heads have friction only where smooth ones do not
    hold.

    Places are free parts of faces, also of those that joints cover partly. Of a large model the
    places are not compared: it is the first prop that holds it. Where none is enough, one prop is
    set under each block, then one under every free part; each one that is not needed is taken away.

    Parameters
    ----------
    model
    blocks
        That may be propped.
    motion : (n, 6)
        First motion of the blocks.
    stop
    single
        Those of the blocks at which a single prop is tried; all when left out.
    shares
        As for :func:`seats`, for a single prop.

    Raises
    ------
    Stopped
    """
    some, large = blocks if single is None else single, len(blocks) > LARGE_REGION
    tried = [
        seat
        for low in (False, True)
        for i in some
        for seat in seats(model, int(i), motion[i], shares, low=low)
    ]
    slippery = model.with_friction(SPARE * model.contacts.friction)
    first: list[PropForce] = []
    best = tried if large else _ranked(model, blocks, tried, stop)
    order = [*best, *(one for one in tried if one not in best)]
    for seat in order:
        held = _forces(model, [seat], stop)
        if held and (large or _forces(slippery, [seat], stop)):
            return PropSearch(tuple(held), "")
        alone = seat is order[0] and not held and len(order) > 2
        if alone and not _forces(model, order, stop):  # what all do not hold none holds
            break
        first = first or held
    if first:
        return PropSearch(tuple(first), "")
    said = f"one prop at {counted(len(tried), 'place')} on free parts of faces"
    covered = sum(one.covered for one in tried)
    if covered:
        said += f", {covered} of them beside joints"
    if large:
        return PropSearch((), said)
    said += ", one under each of its blocks, and one under every free part of their faces"
    return PropSearch(tuple(_few_props(model, blocks, motion, stop)), said)


_RAKED = 3.0
"""A level prop is a raking shore: at 70 degrees it carries three times the level force."""


def _pressed(model: Model, part: FreePart) -> bool:
    """Whether earth or fill lies on a part of a face."""
    surface, near = model.load.surface, 1e-3 * model.assembly.size[part.block]
    if surface is None:
        return False
    offset = np.array([part.middle @ part.normal])
    return bool(surface.lies_on(part.block, part.normal[None], offset, near)[0])


def _ranked(
    model: Model,
    blocks: Sequence[int],
    places: Sequence[PropSeat],
    stop: Callable[[], bool] | None,
) -> list[PropSeat]:
    """Places of one prop, that with the least force first; those where none balances are left out.

    Forces of props from below count once, others three times; those that press down come last.
    """
    assembly, statics = model.assembly, Problem.build(model).statics
    largest = PlaneFactors.of(statics, FrictionCone.exact(), None)
    middle = assembly.centroid[list(blocks)].mean(axis=0)
    found: list[tuple[bool, float, float, PropSeat]] = []
    for seat in places:
        pull = LoadCase.point_load(assembly, seat.block, -np.asarray(seat.normal), seat.middle)
        force = -largest(statics.scaled_wrench(pull.wrench), stop).factor
        if 0.0 < force < np.inf:  # else a pull holds it, or nothing does
            load = model.load.wrench[seat.block, :3]
            up = -float(seat.normal @ load) / max(float(np.linalg.norm(load)), 1e-300)
            counts = 1.0 if carries(model, seat.block, seat.normal) else _RAKED
            off = float(np.linalg.norm(seat.middle - middle))
            found.append((up < -_AGAINST, counts * force, off, seat))
    order: list[PropSeat] = []
    while found:
        down, force = min(one[:2] for one in found)
        equal = [x for x in found if x[0] == down and x[1] <= (1.0 + 1e-3) * force]
        order += [x[3] for x in sorted(equal, key=lambda x: round(x[2] / assembly.size.max(), 6))]
        found = [x for x in found if x not in equal]
    return order


def carries(model: Model, block: int, force: Floats) -> bool:
    """Whether a force (3,) on a block acts mainly against its load: a prop can stand below it."""
    load = model.load.wrench[block, :3]
    return bool(-force @ load > np.sqrt(0.5) * np.linalg.norm(force) * np.linalg.norm(load))


_TOP = 0.6
"""A weight lies on a face whose normal rises by more than this share of it: up to 53 degrees steep,
as haunches below their backing. Chosen."""


def tops_of(model: Model, blocks: Sequence[int]) -> dict[int, Floats]:
    """Where weights can lie on blocks: the middles (3,) [m] of their largest free tops, if any."""
    up, tops = -unit(model.load.wrench[:, :3])[0], dict[int, Floats]()
    for i in blocks:
        parts = [
            part
            for part in free_parts(model, i)
            if part.normal @ up[i] > _TOP and not _pressed(model, part)
        ]
        largest = max(parts, key=lambda part: part.area, default=None)
        if largest and largest.area >= (0.5 * PLATE * model.assembly.size[i]) ** 2:
            tops[i] = largest.middle
    return tops


def _few_props(
    model: Model, blocks: Sequence[int], motion: Floats, stop: Callable[[], bool] | None
) -> list[PropForce]:
    """Props that hold a model together, none of which can be left out; empty where none do."""
    places = [
        [
            seat
            for low in (False, True)
            for seat in seats(model, int(i), motion[i], SHARES[:1], low=low)
        ]
        for i in blocks
    ]
    for chosen in ([some[0] for some in places if some], [one for some in places for one in some]):
        held = _forces(model, chosen, stop) if chosen else []
        if held:
            return _needed(model, held, stop)
    return []


def _needed(
    model: Model, held: list[PropForce], stop: Callable[[], bool] | None
) -> list[PropForce]:
    """Those of some props that hold a model that are needed; those that cannot stand go first."""
    held.sort(key=lambda one: carries(model, one.block, one.force))
    for seat in [one.seat for one in held]:
        fewer = [one.seat for one in held if one.seat is not seat]
        held = (_forces(model, fewer, stop) if fewer else []) or held
    least = SAME * max(one.size for one in held)
    return [one for one in held if one.size > least]


def with_props(model: Model, some: Sequence[PropSeat], *, smooth: bool = False) -> Model:
    """The model with fixed props at some places; the joints below them are the last ones.

    Smooth heads push square to their faces; others have the usual friction.
    """
    props: list[Block] = []
    for seat in some:
        patch = np.asarray(seat.outline)
        foot = patch - PLATE * model.assembly.size[seat.block] * np.asarray(seat.normal)
        name = fresh_name(model, PROP, [one.name for one in props])
        props.append(Block(np.concatenate([foot, patch]), tuple(prism_faces(len(patch))), name))
    contacts = Contacts(
        len(model) + np.arange(len(some)),
        np.array([one.block for one in some]),
        frames_from_normals(np.array([one.normal for one in some])),
        lengths(np.array([area_vector(one.outline) for one in some])),
        np.full(len(some), 0.0 if smooth else usual_friction(model)),
        np.concatenate([one.outline for one in some]),
        np.arange(len(some)).repeat([len(one.outline) for one in some]),
    )
    return changed(model, added=props, fixed=[True] * len(some), contacts=contacts)


def _forces(
    model: Model, some: Sequence[PropSeat], stop: Callable[[], bool] | None
) -> list[PropForce]:
    """The forces of some props, if they are soon found to hold a model; else none."""
    for smooth in (True, False):
        rest = soon_at_rest(with_props(model, some, smooth=smooth), stop)
        if rest.stable and rest.displacement is not None:
            found = rest.resultants
            last = found.position[-len(some) :], found.force[-len(some) :]
            return [
                PropForce(seat, frozen(at), frozen(force), rest.displacement)
                for seat, at, force in zip(some, *last, strict=True)
            ]
    return []


def posts(
    assembly: Assembly, blocks: Ints, point: Floats, force: Floats, what: str = ""
) -> list[Layer]:
    """Props in a picture: posts along their forces, to the ground where there is some.

    Parameters
    ----------
    assembly
    blocks : (p,)
        That they carry.
    point : (p, 3) [m]
    force : (p, 3) [N]
        On the blocks.
    what
        Of the props, in the legend.
    """
    strength = lengths(force)
    if not strength.any():
        return []
    way = post_ways(assembly, blocks, point, -force / np.maximum(strength, 1e-300)[:, None])
    most = "up to " if len(point) > 1 else ""
    told = f"{counted(len(point), 'prop')}{what}, {most}{quantity(strength.max(), 'N')}"
    return [Layer("help", told, LayerKind.LINES, "help", point, way, width=4.0, group="help")]
