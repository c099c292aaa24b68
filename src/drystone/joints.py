"""Results per interface and joint: resultant, utilisation, eccentricity, pressure, thrust line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from drystone.assembly import Assembly, Blocks
from drystone.base.arrays import ROUNDING, SAME, Bools, Floats, Ints, cross, dot, frozen, lengths
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.ragged import Ragged, linked, sum_by_owner
from drystone.base.settings import hold
from drystone.base.table import Table
from drystone.contacts import Contacts
from drystone.geometry.kern import edge_ratio, kern_ratio, peak_pressure
from drystone.virtual import joint_sections

HINGED = 0.99
"""From this share of the distance between centroid and rim on, a force counts as acting on the rim.
From this share of the friction on, friction counts as fully used. Chosen."""

FAINT = 5e-2
"""Joints that carry less than this share of the largest normal force get no marker, and what they
use of their friction is not told. Measured: of the 94 hinges of a vault of 157 blocks that carry a
hundredth, 62 do not carry a twentieth."""

SWAY = 5e-5
"""How far corners are taken as farther out where blocks are followed, by the mean size of a free
block. Blocks sway on their springs: what stands exactly above an edge would fall by that, wherever
something else makes them be followed. Measured: an end brick over exactly half stands on courses of
14 from 1e-5 on, of 30 from 4e-5; the verdicts of 1,132 models are the same."""

_LOOKED_AT = 20
"""Joints at whose rims forces act that are looked at one by one. Chosen: they take no time."""

UNITS = {
    "area": "m2",
    "normal": "N",
    "tangential": "N",
    "torque": "N m",
    "eccentricity": "m",
    "mean_pressure": "Pa",
    "peak_pressure": "Pa",
    "force_x": "N",
    "force_y": "N",
    "force_z": "N",
    "x": "m",
    "y": "m",
    "z": "m",
}
"""Units of the columns of a joint table."""


@dataclass(frozen=True, eq=False)
class Resultants(OneLine):
    """One force per interface.

    Attributes
    ----------
    force : (m, 3) [N]
        On block b, world axes.
    position : (m, 3) [m]
        Centre of pressure; the interface's centroid where the normal force vanishes.
    torque : (m,) [N m]
        Moment about the normal, on block b, at the centre of pressure.
    normal : (m,) [N]
        Component along n, positive in compression.
    tangential : (m,) [N]
        Length of the component in the plane.
    """

    force: Floats
    position: Floats
    torque: Floats
    normal: Floats
    tangential: Floats

    @property
    def loaded(self) -> Bools:
        """(m,) which press, beyond rounding."""
        return self.normal > ROUNDING * max(float(self.normal.max(initial=0.0)), 1e-300)

    def _summary(self) -> str:
        largest = float(self.normal.max(initial=0.0))
        return f"{counted(len(self.normal), 'interface')}, largest normal force {largest:.3g} N"


def world_forces(contacts: Contacts, force: Floats) -> Floats:
    """Corner forces (k, 3) in world axes, from those in the frames of their interfaces.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    force : (k, 3)
        At each corner, along n, u and v of its interface.
    """
    return np.einsum("ki,kij->kj", force, contacts.frame.take(contacts.interface, axis=0))


def resultants_of(contacts: Contacts, force: Floats) -> Resultants:
    """Resultants of corner forces (k, 3) [N], local n, u, v, on block b.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    force : (k, 3) [N]
        At each corner on block b, along n, u and v of its interface.
    """
    interface, total = contacts.interface, contacts.corners.sum
    n = contacts.frame[:, 0]
    world = world_forces(contacts, force)
    resultant = total(world)
    normal = total(force[:, 0])
    lever = contacts.point - contacts.centroid[interface]
    shift = total(force[:, :1] * lever)
    pressing = normal > 1e-12 * max(float(np.abs(normal).max(initial=0.0)), 1e-300)
    position = contacts.centroid + np.where(
        pressing[:, None], shift / np.where(pressing, normal, 1.0)[:, None], 0.0
    )
    moment = total(cross(contacts.point - position[interface], world))
    torque = dot(moment, n)
    tangential = lengths(resultant - normal[:, None] * n)
    return Resultants(*map(frozen, (resultant, position, torque, normal, tangential)))


def bearable(contacts: Contacts, normal: Floats) -> Floats:
    """The largest tangential force (m,) [N] that each interface can bear.

    That is friction coefficient times normal force, and cohesion, within the limit of shear.
    """
    capacity: Floats = contacts.friction * normal
    if contacts.capacity is not None:
        bound = np.maximum(capacity + contacts.capacity.cohesion, 0.0)
        capacity = np.minimum(bound, contacts.capacity.shear)
    return capacity


def by_joint(
    contacts: Contacts, resultants: Resultants, utilisation: Floats
) -> tuple[Resultants, Floats]:
    """Resultants and utilisation of the joints, from those of their interfaces.

    The normal of a joint of several facets is their mean one. Its utilisation is the tangential
    force of all facets by what all can bear: 1 where all slide.
    """
    whole, joint = contacts.joints, contacts.joint
    if whole is contacts:
        return resultants, utilisation
    n = whole.frame[:, 0]
    force = sum_by_owner(resultants.force, joint, whole.count)
    along = dot(resultants.force, n[joint])
    normal = np.bincount(joint, along).astype(np.float64)
    moment = np.cross(resultants.position - whole.centroid[joint], resultants.force)
    moment += resultants.torque[:, None] * contacts.frame[:, 0]
    moment = sum_by_owner(moment, joint, whole.count)
    pressing = normal > 1e-12 * max(float(np.abs(normal).max(initial=0.0)), 1e-300)
    shift = np.cross(n, moment) / np.where(pressing, normal, 1.0)[:, None]
    shift = np.where(pressing[:, None], shift, 0.0)
    torque = dot(moment - np.cross(shift, force), n)
    tangential = np.linalg.norm(force - normal[:, None] * n, axis=1)
    bound = np.bincount(joint, np.maximum(bearable(contacts, resultants.normal), 0.0))
    rubs = np.bincount(joint, resultants.tangential)
    used = np.divide(rubs, bound, out=np.zeros(len(rubs)), where=bound > 0.0)
    alone = np.bincount(joint) == 1
    first = np.unique(joint, return_index=True)[1][alone]
    made = Resultants(force, whole.centroid + shift, torque, normal, tangential)
    used[alone] = utilisation[first]
    for name in ("force", "position", "torque", "normal", "tangential"):
        getattr(made, name)[alone] = getattr(resultants, name)[first]
        frozen(getattr(made, name))
    return made, frozen(used)


def forces_around(contacts: Contacts, force: Floats) -> Floats:
    """Corner forces (k, 3) [N] as those of the corners of the joints, in their frames.

    The force at a corner of a facet acts at the nearest corner of the outline of its joint.
    """
    whole, world = contacts.joints, world_forces(contacts, force)
    if whole is contacts:
        return force
    joint = contacts.joint[contacts.interface]
    order = np.argsort(joint, kind="stable")
    given = Ragged.from_owners(joint[order], whole.count)
    total = np.zeros((whole.corner_count, 3))
    for i in range(whole.count):
        mine, corners = order[given[i]], whole.corners[i]
        away = contacts.point[mine, None] - whole.point[corners]
        nearest = (away * away).sum(axis=2).argmin(axis=1)
        np.add.at(total[corners], nearest, world[mine])
    return np.einsum("kij,kj->ki", whole.frame[whole.interface], total)


def joint_table(
    contacts: Contacts,
    names: Sequence[str],
    resultants: Resultants,
    utilisation: Floats,
    crushing: Floats | None = None,
) -> Table:
    """The table of :meth:`drystone.Result.joints`, from the values of interfaces.

    A tie has no eccentricity and no pressure.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    names
        Of all blocks, by their numbers.
    resultants
        Of the interfaces; see :func:`resultants_of`.
    utilisation : (m,)
        Share of the friction that each interface uses.
    crushing : (m,)
        Share of the strength that each interface uses; left out, zero.
    """
    resultants, utilisation = by_joint(contacts, resultants, utilisation)
    strength_use = np.zeros(contacts.joints.count)
    if crushing is not None:
        np.maximum.at(strength_use, contacts.joint, crushing)
    contacts = contacts.joints
    normal = resultants.normal
    least = ROUNDING * max(float(np.abs(normal).max(initial=0.0)), 1e-300)
    loaded = (normal > least) & ~contacts.ties
    origin, corners, made = joint_sections(contacts)
    at = np.einsum("mij,mj->mi", contacts.frame[:, 1:], resultants.position - origin)
    at = np.where(loaded[:, None], at, made.centroid)
    start = contacts.start
    within = np.where(loaded, kern_ratio(made, corners, start, at), 0.0)
    rim = np.where(loaded, edge_ratio(made, corners, start, at), 0.0)
    has_area = made.area > 0.0
    mean = np.where(has_area, normal / np.where(has_area, made.area, 1.0), np.inf)
    mean = np.where(loaded, mean, 0.0)
    peak = peak_pressure(made, corners, start, np.where(loaded, normal, 0.0), at)
    position = origin + np.einsum("mi,mij->mj", at, contacts.frame[:, 1:])
    columns = {
        "joint": np.arange(contacts.count),
        "block_a": [names[a] for a in contacts.block_a],
        "block_b": [names[b] for b in contacts.block_b],
        "area": contacts.area,
        "normal": normal,
        "tangential": resultants.tangential,
        "torque": resultants.torque,
        "friction_use": utilisation,
        "eccentricity": np.linalg.norm(at - made.centroid, axis=1),
        "kern_ratio": within,
        "edge_ratio": rim,
        "mean_pressure": mean,
        "peak_pressure": peak,
        "strength_use": strength_use,
        **{f"force_{axis}": resultants.force[:, i] for i, axis in enumerate("xyz")},
        **{axis: position[:, i] for i, axis in enumerate("xyz")},
    }
    return Table("joints", columns, UNITS)


def worst_joints(table: Table, count: int = 10) -> Ints:
    """Rows of a joint table nearest to sliding or to forming a hinge, worst first.

    Those that carry hardly anything come last.

    Parameters
    ----------
    table
        As :func:`joint_table` gives it.
    count
        Largest number of rows.
    """
    use, normal = np.maximum(table["friction_use"], table["edge_ratio"]), table["normal"]
    faint = normal <= FAINT * normal.max(initial=0.0)
    return np.lexsort((-normal, -use, faint))[:count]


@dataclass(frozen=True, eq=False)
class ThrustLine(OneLine):
    """The thrust line along a row of voussoirs.

    Attributes
    ----------
    blocks : (s,) positions, in order
    point : (s - 1, 3) [m]
        Centre of pressure between each two successive blocks.
    force : (s - 1, 3) [N]
        The force of each block on the next one, world axes.
    """

    blocks: tuple[int, ...]
    point: Floats
    force: Floats


def thrust_line(
    assembly: Assembly, contacts: Contacts, resultants: Resultants, blocks: Blocks | None = None
) -> ThrustLine:
    """The line of :meth:`drystone.Result.thrust_line`.

    Parameters
    ----------
    assembly
        The blocks that the contacts are of.
    contacts
        The m interfaces, with k corners.
    resultants
        Of the interfaces; see :func:`resultants_of`.
    blocks
        Names or numbers along the line, in order; left out, those of :func:`chain`.
    """
    order = chain(assembly, contacts) if blocks is None else assembly.indices(blocks).tolist()
    if not order:
        raise InputError("no blocks are given", remedy="give those along the line, in their order")
    point, force = np.zeros((len(order) - 1, 3)), np.zeros((len(order) - 1, 3))
    for i, (a, b) in enumerate(pairwise(order)):
        onward = (contacts.block_a == a) & (contacts.block_b == b)
        back = (contacts.block_a == b) & (contacts.block_b == a)
        joints = np.flatnonzero(onward | back)
        if len(joints) == 0:
            raise InputError(
                f"blocks '{assembly.names[a]}' and '{assembly.names[b]}' do not touch",
                remedy="give the voussoirs in the order of the thrust",
            )
        weight = np.maximum(resultants.normal[joints], 0.0)
        weight = weight if weight.any() else np.ones(len(joints))
        point[i] = weight @ resultants.position[joints] / weight.sum()
        sign = np.where(onward[joints], 1.0, -1.0)
        force[i] = sign @ resultants.force[joints]
    return ThrustLine(tuple(order), point, force)


def hinged(contacts: Contacts, resultants: Resultants) -> Bools:
    """Whether each joint (m,) is a hinge: it has an area, and its resultant acts on the rim.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    resultants
        Of the interfaces; see :func:`resultants_of`.
    """
    rim, area = eccentricity(contacts, resultants)
    return resultants.loaded & (area > 0.0) & (rim > HINGED)


def eccentricity(contacts: Contacts, resultants: Resultants) -> tuple[Floats, Floats]:
    """How far (m,) each resultant is from the centroid, by the rim, and the areas (m,) [m2]."""
    origin, corners, made = joint_sections(contacts)
    at = np.einsum("mij,mj->mi", contacts.frame[:, 1:], resultants.position - origin)
    return edge_ratio(made, corners, contacts.start, at), made.area


def on_an_edge(
    assembly: Assembly, contacts: Contacts, resultants: Resultants, within: float = SAME
) -> list[tuple[int, Ints]]:
    """Blocks that stand exactly above an edge, with those below: their margin is zero.

    The resultant acts on the rim of a joint that alone holds the block and what it carries, or on
    those of several in one line about which it may turn. So no other forces balance it. Of many
    such joints a few are looked at.

    Parameters
    ----------
    assembly
    contacts
        Joints, as :attr:`Contacts.joints` gives them.
    resultants
        Of the joints.
    within
        Distance from a rim, by that of the rim from the centroid, that counts as none.
    """
    rim, area = eccentricity(contacts, resultants)
    # of what has no area all is rim: an edge or a corner that a block stands on
    at_rim = np.flatnonzero(resultants.loaded & ((area <= 0.0) | (rim > 1.0 - within)))
    ends = np.stack([contacts.block_a[at_rim], contacts.block_b[at_rim]], axis=1)
    loose = ~_held_without(assembly, contacts, at_rim)  # by one of them, or by several
    at_rim, ends = at_rim[loose[ends].any(axis=1)], ends[loose[ends].any(axis=1)]
    found = []
    for i, pair in enumerate(ends[:_LOOKED_AT]):
        held = _held_without(assembly, contacts, at_rim[i : i + 1])
        found += [(int(one), pair[pair != one]) for one in pair if not held[one]]
    blocks, times = np.unique(ends[~assembly.fixed[ends]], return_counts=True)
    for block in blocks[times > 1][:_LOOKED_AT].tolist():
        own = (ends == block).any(axis=1)
        line = _turns_about(contacts, resultants, block, at_rim[own])
        held = _held_without(assembly, contacts, at_rim[own])
        if line is not None and not held[block] and _beside(assembly, ~held, *line):
            found.append((block, ends[own][ends[own] != block]))
    return found


def _turns_about(
    contacts: Contacts, resultants: Resultants, block: int, joints: Ints
) -> tuple[Floats, Floats] | None:
    """The line (place, direction) of resultants about which a block may turn, if there is one.

    No corner of these joints comes closer, whichever of both ways it turns.
    """
    place = resultants.position[joints[0]]
    away = resultants.position[joints] - place
    last = away[np.argmax(lengths(away))]
    span = float(lengths(last))
    axis = last / max(span, 1e-300)
    corner = np.isin(contacts.interface, joints)
    which = contacts.interface[corner]
    turned = cross(axis, contacts.point[corner] - place)
    opening = np.where(contacts.block_b[which] == block, 1.0, -1.0)
    opening *= dot(contacts.frame[which, 0], turned)
    least = SAME * span
    one_line = lengths(cross(axis, away)).max() < least
    free = opening.min() >= -least or opening.max() <= least
    return (place, axis) if one_line and free else None


def _beside(assembly: Assembly, blocks: Bools, place: Floats, axis: Floats) -> bool:
    """Whether the centroid of some blocks is beside a line."""
    mass = assembly.mass[blocks]
    centre = mass @ assembly.centroid[blocks] / mass.sum()
    return bool(lengths(cross(axis, centre - place)) > SAME * assembly.size[blocks].max())


def foot_pressed(
    assembly: Assembly, contacts: Contacts, resultants: Resultants
) -> tuple[float, float] | None:
    """How far [m] the only joint with a support is pressed from its middle, and beside its kern.

    As :func:`on_an_edge`. The second value is 1 at the edge of the kern. ``None`` where there is no
    such joint, or several.
    """
    fixed = assembly.fixed
    (feet,) = np.nonzero(fixed[contacts.block_a] != fixed[contacts.block_b])
    origin, corners, made = joint_sections(contacts)
    if len(feet) != 1 or not made.area[feet[0]] > 0.0:
        return None
    at = np.einsum("mij,mj->mi", contacts.frame[:, 1:], resultants.position - origin)
    within = kern_ratio(made, corners, contacts.start, at)
    return float(lengths(at - made.centroid)[feet[0]]), float(within[feet[0]])


def _held_without(assembly: Assembly, contacts: Contacts, joints: Ints) -> Bools:
    """Which blocks (n,) are connected with a support when some joints are missing."""
    a, b = (np.delete(end, joints) for end in (contacts.block_a, contacts.block_b))
    part = linked(a, b, len(assembly))
    return np.isin(part, part[assembly.fixed])


def corner_pressure(contacts: Contacts, force: Floats) -> Floats:
    """Pressure (k,) [Pa]: normal force of each corner by its share of the area; 0 without area.

    Parameters
    ----------
    contacts
        The m interfaces, with k corners.
    force : (k, 3) [N]
        At each corner on block b, along n, u and v of its interface.
    """
    area = contacts.tributary
    return np.divide(force[:, 0], area, out=np.zeros(len(area)), where=area > 0.0)


def plane_pressure(contacts: Contacts, force: Floats) -> Floats:
    """Linear pressure (k,) [Pa] of a plane section at each corner; zero without area."""
    _, flat, made = joint_sections(contacts)
    corners, owner = contacts.corners, contacts.interface
    face = (contacts.area > 0.0) & (corners.counts > 2)
    area = np.where(face, made.area, 1.0)
    arm = flat - made.centroid[owner]
    slope = np.einsum("mij,mj->mi", made.inverse, corners.sum(force[:, :1] * arm)) / area[:, None]
    mean = corners.sum(force[:, 0]) / area
    return np.where(face[owner], mean[owner] + dot(slope[owner], arm), 0.0)


def linear_strength_use(contacts: Contacts, force: Floats) -> Floats:
    """Largest linear pressure (m,) by the strength; zero without a finite one."""
    if contacts.capacity is None or not contacts.count:
        return np.zeros(contacts.count)
    most = contacts.corners.max(plane_pressure(contacts, force)) * contacts.area
    return np.where(contacts.crushes, most / np.maximum(contacts.capacity.compression, 1e-300), 0.0)


@dataclass(frozen=True, eq=False)
class ForceNetwork(OneLine):
    """Lines along which the normal forces pass through the blocks.

    In every free block a line runs from each joint in compression to the mean of the block's
    centres of pressure, weighted by the normal forces. In a row of voussoirs these lines form the
    thrust line. A free block with a single joint in compression has a line to its centroid.
    Supports have no lines.

    Attributes
    ----------
    start : (s, 3) [m], centres of pressure
    end : (s, 3) [m]
    force : (s,) [N], normal force
    interface : (s,)
    """

    start: Floats
    end: Floats
    force: Floats
    interface: Ints

    def _summary(self) -> str:
        return f"{counted(len(self.force), 'line')}, at most {self.force.max(initial=0.0):.3g} N"


def force_network(assembly: Assembly, contacts: Contacts, resultants: Resultants) -> ForceNetwork:
    """The force network of resultants, through joints; ties have no part in it.

    Parameters
    ----------
    assembly
        The blocks that the contacts are of.
    contacts
        The m interfaces, with k corners.
    resultants
        Of the interfaces; see :func:`resultants_of`.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import tower
    >>> result = drystone.check(tower(3))
    >>> made = force_network(result.assembly, result.contacts, result.resultants)
    >>> made.end[:, 2].round(3).tolist()  # the lower joint carries twice as much
    [1.333, 1.333, 2.5]
    """
    normal = resultants.normal
    pressed = np.flatnonzero(resultants.loaded & ~contacts.ties)
    block = np.concatenate([contacts.block_a[pressed], contacts.block_b[pressed]])
    interface = np.concatenate([pressed, pressed])
    free = ~assembly.fixed[block]
    block, interface = block[free], interface[free]
    order = np.lexsort((interface, block))
    block, interface = block[order], interface[order]
    force, start = normal[interface], resultants.position[interface]
    total = np.bincount(block, force, len(assembly))
    count = np.bincount(block, minlength=len(assembly))
    moment = np.zeros((len(assembly), 3))
    np.add.at(moment, block, force[:, None] * start)
    middle = moment / np.where(total > 0.0, total, 1.0)[:, None]
    hub = np.where((count > 1)[:, None], middle, assembly.centroid)
    return ForceNetwork(*map(frozen, (start, hub[block], force, interface)))


def chain(assembly: Assembly, contacts: Contacts) -> list[int]:
    """Blocks of a model in which each block touches only the previous and the next one.

    Parameters
    ----------
    assembly
        The blocks that the contacts are of.
    contacts
        The m interfaces, with k corners.

    Raises
    ------
    InputError
        The blocks branch, form a ring, or are not connected.
    """
    neighbours: list[set[int]] = [set() for _ in range(len(assembly))]
    for a, b in zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True):
        neighbours[a].add(b)
        neighbours[b].add(a)
    ends = [i for i, others in enumerate(neighbours) if len(others) == 1]
    order = ends[:1]
    while order and len(order) < len(assembly):
        onward = neighbours[order[-1]] - set(order[-2:])
        if len(onward) != 1:
            break
        order.append(onward.pop())
    if len(ends) != 2 or len(order) != len(assembly):
        raise InputError(
            "the blocks are not one row of voussoirs", remedy="name those of a row in order"
        )
    return order


__all__ = [
    "ForceNetwork",
    "Resultants",
    "ThrustLine",
    "chain",
    "corner_pressure",
    "force_network",
    "hinged",
    "joint_table",
    "resultants_of",
    "thrust_line",
    "world_forces",
    "worst_joints",
]

hold(globals())
